//! Calls without order for as long as one asks, in seconds: `cargo xtask fuzz --seconds 60`.

#[path = "../tests/common/fuzz.rs"]
mod fuzz;

use std::time::{SystemTime, UNIX_EPOCH};

fn main() {
    let seconds = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(60.0);
    let seed = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |d| d.as_secs() << 20);
    println!("seed {seed}, {seconds} s");
    let (calls, done) = fuzz::play(seconds, seed);
    println!("{calls} calls, {done} done, {} refused, none failed", calls - done);
}
