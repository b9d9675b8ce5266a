//! Closing the loop: from bench data to the effect that the model lacks.
//!
//! So far: [`experiment`], which reads what was measured and refuses what cannot be right.

pub mod experiment;

/// Why an experiment cannot be used: one sentence with file and, where there is one, line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrateError(pub String);
