//! Prior distribution of the parameters: c0 and their part of L in (2) of `evidence.rs`.

use nalgebra::{DMatrix, DVector};

/// Prior precision of a parameter without prior. Numerical: negligible, but gives parameters without influence a finite variance.
const FLAT: f64 = 1e-8;

/// A normal prior about values other than the present ones.
#[derive(Clone)]
pub struct Prior {
    /// Their part of L.
    pub(super) precision: DMatrix<f64>,
    /// L times the deviations of the present values from the prior mean.
    pub(super) pull: DVector<f64>,
    /// The deviations' quadratic form with L.
    pub(super) cost: f64,
    /// First value and number of values of each table, with its part of `cost`.
    tables: Vec<(usize, usize, f64)>,
}

impl Prior {
    /// Independent parameters in units of their prior deviations, with their deviations from the prior mean; NaN without a prior.
    pub fn new(apart: &[f64]) -> Prior {
        let known = |x: &f64| if x.is_finite() { *x } else { 0.0 };
        let precision = apart.iter().map(|x| if x.is_finite() { 1.0 } else { FLAT });
        let pull = DVector::from_iterator(apart.len(), apart.iter().map(known));
        let precision = DMatrix::from_diagonal(&DVector::from_iterator(apart.len(), precision));
        Prior { precision, cost: pull.norm_squared(), pull, tables: Vec::new() }
    }

    /// The values of a table from `place` on have a common prior with mean zero; `units` are those of the columns.
    pub fn table(&mut self, place: usize, values: &DVector<f64>, precision: &DMatrix<f64>, units: &[f64]) {
        let n = values.len();
        let pull = precision * values;
        for a in 0..n {
            self.pull[place + a] = units[a] * pull[a];
            for b in 0..n {
                self.precision[(place + a, place + b)] = units[a] * precision[(a, b)] * units[b];
            }
        }
        let cost = values.dot(&pull);
        self.cost += cost;
        self.tables.push((place, n, cost));
    }

    /// Whether there are tables.
    pub(super) fn has_tables(&self) -> bool {
        !self.tables.is_empty()
    }

    /// The same without the priors of tables.
    pub(super) fn without_tables(&self) -> Prior {
        let mut other = Prior { tables: Vec::new(), ..self.clone() };
        for (place, n, cost) in &self.tables {
            other.pull.rows_mut(*place, *n).fill(0.0);
            let mut own = other.precision.view_mut((*place, *place), (*n, *n));
            own.fill(0.0);
            own.fill_diagonal(FLAT);
            other.cost -= cost;
        }
        other
    }

    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        self.pull.len()
    }
}
