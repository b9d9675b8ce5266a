//! All integration tests of calibration, in one program.

mod public_sets;
mod seeds;
