//! Covariance K of the drift of the sensors in (2) of `evidence.rs`.

use super::{DRIFTS, log_determinant};
use crate::algebra::cholesky;
use nalgebra::DMatrix;

/// Relative variance added to the diagonal of a drift's covariance. Numerical: keeps it positive definite.
const JITTER: f64 = 1e-6;

/// The inverse covariances of the drifts that are compared. Those with the same correlation time differ by a factor.
pub(super) struct Drift {
    /// Number of drift columns.
    pub(super) count: usize,
    /// For each correlation time, s: inverse and log determinant of the covariance for a standard deviation of 1.
    kernels: Vec<(f64, DMatrix<f64>, f64)>,
}

impl Drift {
    /// For columns with this time and sensor each.
    pub(super) fn new(knots: &[(f64, usize)]) -> Option<Drift> {
        let kernel = |length: f64| {
            let factor = cholesky(DMatrix::from_fn(knots.len(), knots.len(), |a, b| {
                let ((t, s), (u, v)) = (knots[a], knots[b]);
                let near = if s == v { (-(t - u).abs() / length).exp() } else { 0.0 };
                near + if a == b { JITTER } else { 0.0 }
            }))?;
            Some((length, factor.inverse(), log_determinant(&factor)))
        };
        let mut lengths: Vec<f64> =
            DRIFTS.iter().filter(|(sd, _)| *sd > 0.0).map(|(_, length)| *length).collect();
        lengths.sort_by(f64::total_cmp);
        lengths.dedup();
        let kernels = lengths.into_iter().map(kernel).collect::<Option<Vec<_>>>()?;
        Some(Drift { count: knots.len(), kernels })
    }

    /// Inverse and log determinant of the covariance of a drift that is compared.
    pub(super) fn precision(&self, (sd, length): (f64, f64)) -> Option<(DMatrix<f64>, f64)> {
        let (_, inverse, determinant) = self.kernels.iter().find(|(own, ..)| *own == length)?;
        Some((inverse / (sd * sd), determinant + 2.0 * self.count as f64 * sd.ln()))
    }
}
