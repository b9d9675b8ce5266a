//! Compiles the logger callback of FMI 2.

fn main() {
    println!("cargo::rerun-if-changed=src/logger.c");
    cc::Build::new().file("src/logger.c").warnings_into_errors(true).compile("cosim_logger");
}
