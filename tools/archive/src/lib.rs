//! Builds and validates FMU archives.

pub mod build;
mod documentation;
mod metadata;
mod native;
mod object_file;
pub mod platform;
mod reference;
mod terminals;
pub mod validate;
