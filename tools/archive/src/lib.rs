//! Builds and validates FMU archives.

pub mod validate;
