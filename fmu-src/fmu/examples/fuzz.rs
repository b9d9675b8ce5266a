//! Calls without order for as long as one asks, in seconds, with each model in turn: `cargo xtask fuzz --seconds 60`.

#[path = "../tests/common/fuzz.rs"]
mod fuzz;

use std::time::{SystemTime, UNIX_EPOCH};

fn main() {
    let seconds = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(60.0);
    let seed = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |d| d.as_secs() << 20);
    println!("seed {seed}, {seconds} s for each model");
    for kind in physics::models::ALL {
        let (calls, done) = fuzz::play(seconds, seed, Some(kind));
        println!(
            "{}: {calls} calls, {:.0} a second, {done} done, {} refused, none failed",
            (kind.declaration)().name,
            calls as f64 / seconds,
            calls - done
        );
    }
}
