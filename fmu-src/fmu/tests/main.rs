//! All integration tests of the C interface, in one program. `cargo xtask miri` runs them in Miri.

// Miri calls the logger of FMI 2 as what it is, and stable Rust defines no variadic function.
#![cfg_attr(miri, feature(c_variadic))]

mod common;
mod counting;

mod allocation;
mod arrays;
mod exchange;
mod fmi2;
mod fmi3;
mod fuzz;
mod logging;
mod memory;
mod remembered;
mod saturation;
mod saved;
mod settled;
mod states;
mod stepping;
mod terms;
mod threads;
mod tolerance;
