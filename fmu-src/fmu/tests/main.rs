//! All integration tests of the C interface, in one program.

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
mod states;
mod stepping;
mod terms;
mod threads;
mod tolerance;
