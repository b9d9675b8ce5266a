//! A given number of random calls of each model: `cargo xtask fuzz --calls 1000000`.

#[path = "../tests/common/mod.rs"]
#[allow(dead_code)] // the other tests use the rest
mod common;
#[path = "../tests/fuzz.rs"]
mod fuzz;

use std::time::{SystemTime, UNIX_EPOCH};

fn main() {
    let wanted: u64 = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(1_000_000);
    let seed = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |d| d.as_secs() << 20);
    println!("seed {seed}, {wanted} calls of each model");
    for kind in physics::models::ALL {
        let (calls, done) = fuzz::run(wanted.div_ceil(400), seed, Some(kind));
        println!(
            "{}: {calls} calls, {done} accepted, {} refused, no internal failure",
            (kind.declaration)().name,
            calls - done
        );
    }
}
