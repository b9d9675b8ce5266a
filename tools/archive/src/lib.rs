//! Builds and validates FMU archives.
