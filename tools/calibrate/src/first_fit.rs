//! What the first fit that is evaluated determines for all others.

use nalgebra::DMatrix;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Directions of the structure error, and the noise that inputs pass on.
#[derive(Default)]
pub struct FirstFit {
    /// Directions of the structure error along the fit runs.
    pub structure: OnceLock<DMatrix<f64>>,
    /// Variance of the outputs of a run by the readings of the inputs in the same row: rows times outputs.
    direct: Mutex<HashMap<usize, Arc<Vec<f64>>>>,
}

impl FirstFit {
    /// The variance by input noise of the first fit that was evaluated in a run: `own` if that is this one.
    pub fn direct_variance(&self, run: usize, own: &Arc<Vec<f64>>) -> Arc<Vec<f64>> {
        let mut known = self.direct.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(known.entry(run).or_insert_with(|| Arc::clone(own)))
    }
}
