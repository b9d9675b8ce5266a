//! Overrides of a model's parameters and terms for one simulation.

use physics::model::Slot;
use physics::terms::{GenericTerm, Lag};

/// Overrides of a model.
#[derive(Clone, Debug, Default)]
pub struct Override {
    /// Values of parameters.
    pub values: Vec<(Slot, f64)>,
    /// Terms.
    pub terms: Vec<GenericTerm>,
}

impl Override {
    /// The terms with a lag, by their place.
    pub fn lags(&self) -> impl Iterator<Item = (usize, Lag)> + '_ {
        self.terms.iter().enumerate().filter_map(|(k, term)| Some((k, term.lag?)))
    }
}
