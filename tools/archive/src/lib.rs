//! Builds and validates FMU archives.

pub mod build;
pub mod documentation;
pub mod validate;
