//! Failure to start or to step.

/// Why a model cannot start or step: one sentence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct Fault(pub String);
