//! Why an archive is not built.

use describe::start_values;
use std::io;
use std::path::PathBuf;
use terms::TermsError;

/// Why an archive cannot be made: one sentence.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The library is not where it should be.
    #[error(
        "the FMU library {path} cannot be read ({source}); `cargo build --release` puts it beside motor-fmu"
    )]
    Library {
        /// Where it was looked for.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The library has no block for start values.
    #[error("the FMU library {path} does not fit this tool: {source}")]
    Patch {
        /// Which.
        path: PathBuf,
        /// Why.
        source: start_values::PatchError,
    },
    /// The library is for another platform.
    #[error("the library {path} is for {found} and not for {platform}")]
    WrongPlatform {
        /// Which.
        path: PathBuf,
        /// Platform from the file's header.
        found: String,
        /// What it was to be.
        platform: &'static str,
    },
    /// The library exports more than the functions of FMI, which may meet other libraries' names in an importer.
    #[error("the library {path} exports {names} beside the functions of FMI")]
    Exports {
        /// Which.
        path: PathBuf,
        /// What.
        names: String,
    },
    /// The library has not been made.
    #[error(
        "there is no library for {platform} at {path}; `cargo xtask cross` makes it, on any platform with its compiler \
         `cargo build --release`"
    )]
    NoLibrary {
        /// For which platform.
        platform: &'static str,
        /// Where it was looked for.
        path: PathBuf,
    },
    /// A name that is no platform.
    #[error("{name} is no platform; there is {known}")]
    Platform {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
    /// A preset for another model.
    #[error("preset {preset} is for {of} and not for {model}")]
    Preset {
        /// The preset.
        preset: String,
        /// Its model.
        of: String,
        /// The requested model.
        model: &'static str,
    },
    /// Invalid terms.
    #[error(transparent)]
    Terms(#[from] TermsError),
    /// Terms for a model that carries none.
    #[error("{model} carries no terms, so it has no use for {}", terms::FILE_NAME)]
    NoTerms {
        /// The model.
        model: &'static str,
    },
    /// A file that cannot be written.
    #[error("{path} cannot be written: {source}")]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}
