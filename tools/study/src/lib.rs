//! Studies with the native models, without FMI: a model on a bench, its steady state, sweeps, and the numbers
//! of the two published systems recomputed.
//!
//! [`mod@bench`] knows models by name and variables by name; all else here goes through it.

pub mod bench;
pub mod datasheet;
pub mod fit;
mod notes;
pub mod numeric;
pub mod reproduce;
pub mod steady;
pub mod sweep;
pub mod walk;

/// Why a study could not run: one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// The model has no steady state at these values.
    #[error("{0}")]
    Unsettled(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl StudyError {
    /// The error with this sentence.
    pub fn new(sentence: impl Into<String>) -> StudyError {
        StudyError::Other(sentence.into())
    }

    /// The error of a failed step: a model that ends at a limit of validity has no steady state at these values.
    /// The time and the heat flows of the model's own report would be those of an iterate of the search.
    pub(crate) fn of_step(model: &dyn physics::model::Model, fault: &physics::model::Fault) -> StudyError {
        match model.passed_limit() {
            Some(limit) => StudyError::Unsettled(limit),
            None => StudyError::new(fault.to_string()),
        }
    }
}

impl From<describe::preset::PresetError> for StudyError {
    fn from(error: describe::preset::PresetError) -> StudyError {
        StudyError::new(error.to_string())
    }
}
