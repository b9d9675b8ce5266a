//! What a trial changes of a model before it is run.

use physics::model::Slot;
use physics::terms::GenericTerm;

/// A change of a model.
#[derive(Clone, Debug, Default)]
pub struct Override {
    /// Values of parameters.
    pub values: Vec<(Slot, f64)>,
    /// Terms.
    pub terms: Vec<GenericTerm>,
}
