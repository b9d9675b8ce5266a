//! Gains of columns, and of many columns at once.

use super::{Evidence, Gain, Noise, ROUNDING};
use crate::algebra::product;
use nalgebra::{DMatrix, DVector};

/// Products of columns S with the null model, for one covariance of the noise.
pub(super) struct Seen {
    /// S'S.
    pub(super) sts: DMatrix<f64>,
    /// Z'S.
    pub(super) zts: DMatrix<f64>,
    /// S'(r - Z c): one column for each state.
    pub(super) left: DMatrix<f64>,
}

impl Seen {
    /// With whitened columns, and S'S.
    fn new(noise: &Noise, s: &DMatrix<f64>, sts: DMatrix<f64>) -> Seen {
        let (zts, own) = (product(&noise.z, s), s.tr_mul(&noise.r));
        let left: Vec<DVector<f64>> = noise.states.iter().map(|state| &own - zts.tr_mul(&state.c)).collect();
        Seen { sts, zts, left: DMatrix::from_columns(&left) }
    }

    /// Those of one column alone; S'S has one row.
    fn alone(&self, k: usize) -> Seen {
        let (sts, zts) = (self.sts.columns(k, 1).into_owned(), self.zts.columns(k, 1).into_owned());
        Seen { sts, zts, left: self.left.rows(k, 1).into_owned() }
    }
}

impl Evidence {
    /// Eq. (3). `None` if the columns are collinear with those of the null model.
    pub fn gain(&self, s: &DMatrix<f64>) -> Option<Gain> {
        self.least_squares(&self.seen(s))
    }

    /// Eq. (3) for each column alone. Z is read once for all of them.
    pub fn gains(&self, s: &DMatrix<f64>) -> Vec<Option<Gain>> {
        let of = |noise: &Noise| {
            let s = noise.whitened(&self.series, s);
            let squares = DMatrix::from_fn(1, s.ncols(), |_, k| s.column(k).norm_squared());
            Seen::new(noise, &s, squares)
        };
        let seen: Vec<Seen> = self.noises.iter().map(of).collect();
        let one = |k: usize| self.least_squares(&seen.iter().map(|own| own.alone(k)).collect::<Vec<_>>());
        (0..s.ncols()).map(one).collect()
    }

    /// The products of columns with the null model, for each covariance of the noise.
    pub(super) fn seen(&self, s: &DMatrix<f64>) -> Vec<Seen> {
        let of = |noise: &Noise| {
            let s = noise.whitened(&self.series, s);
            let sts = product(&s, &s);
            Seen::new(noise, &s, sts)
        };
        self.noises.iter().map(of).collect()
    }

    fn least_squares(&self, seen: &[Seen]) -> Option<Gain> {
        self.best(seen, |sts, power, seen| {
            if (0..power.nrows()).any(|j| power[(j, j)] <= ROUNDING * sts[(j, j)]) {
                return None;
            }
            let factor = power.clone().cholesky()?;
            let size = factor.solve(seen);
            Some((seen.dot(&size), size, factor))
        })
    }
}
