//! The motor-fmu command.
fn main() {}
