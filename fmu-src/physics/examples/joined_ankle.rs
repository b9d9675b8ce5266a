//! Writes the solution of the joined equations of motor, actuator and gait as CSV:
//! `cargo run --release -p physics --example joined_ankle > tests/reference/coupled-ankle/joined.csv`

#[path = "../tests/common/walker.rs"]
mod walker;

use physics::models::annulus_cooled_motor::DriveMode;
use walker::{LOOKED_AT, TIMES, joined};

fn main() {
    println!("time,{}", LOOKED_AT.join(","));
    for (t, row) in TIMES.iter().zip(joined(DriveMode::Voltage, &TIMES)) {
        println!("{t},{}", row.map(|v| format!("{v:.12e}")).join(","));
    }
}
