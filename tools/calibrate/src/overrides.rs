//! Overrides of a model's parameters and terms for one simulation.

use physics::model::Slot;
use physics::terms::GenericTerm;

/// Overrides of a model.
#[derive(Clone, Debug, Default)]
pub struct Override {
    /// Values of parameters.
    pub values: Vec<(Slot, f64)>,
    /// Terms.
    pub terms: Vec<GenericTerm>,
}
