//! Why an archive is not built.

use std::io;
use std::path::Path;

/// Why an archive cannot be made: one sentence.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct BuildError(pub(crate) String);

impl BuildError {
    /// The library is not where it should be.
    pub(crate) fn library(path: &Path, error: &io::Error) -> BuildError {
        BuildError(format!(
            "the FMU library {} cannot be read ({error}); `cargo build --release` puts it beside motor-fmu",
            path.display()
        ))
    }
}

impl From<terms::TermsError> for BuildError {
    fn from(error: terms::TermsError) -> BuildError {
        BuildError(error.to_string())
    }
}
