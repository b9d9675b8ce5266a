//! Set-up, tests, demo, benchmarks and tidiness of the workspace.
fn main() {}
