//! All integration tests of the C interface, in one program.

mod common;
mod counting;

mod allocation;
mod arrays;
mod exchange;
mod fmi2;
mod fmi3;
mod fuzz;
mod memory;
mod remembered;
mod saturation;
mod saved;
mod stepping;
mod terms;
