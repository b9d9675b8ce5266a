//! Gains of columns, and of many groups of columns at once.

use super::{Evidence, Explained, Gain, Noise, ROUNDING, Series};
use crate::algebra::{lower_product, product, squares_of_groups};
use nalgebra::{DMatrix, DVector};

/// Products of a group of columns S with the null model, for one covariance of the noise.
pub(super) struct Seen {
    /// S'S.
    pub(super) squares: DMatrix<f64>,
    /// S'PS, for each state.
    pub(super) powers: Vec<DMatrix<f64>>,
    /// S'(r - Z c): one column for each state.
    pub(super) left: DMatrix<f64>,
}

impl Noise {
    /// The products of each group of `width` neighbouring columns. Z and the factors are read once for all of them.
    fn seen(&self, series: &[Series], s: &DMatrix<f64>, width: usize) -> Vec<Seen> {
        let s = self.whitened(series, s);
        let (zts, own) = (product(&self.z, &s), s.tr_mul(&self.r));
        let squares = squares_of_groups(&s, width);
        let explained =
            self.states.iter().map(|state| squares_of_groups(&lower_product(state.inverse(), &zts), width));
        let explained: Vec<_> = explained.collect();
        let left: Vec<DVector<f64>> = self.states.iter().map(|state| &own - zts.tr_mul(&state.c)).collect();
        let left = DMatrix::from_columns(&left);
        let group = |(k, squares): (usize, DMatrix<f64>)| Seen {
            powers: explained.iter().map(|of_state| &squares - &of_state[k]).collect(),
            left: left.rows(k * width, width).into_owned(),
            squares,
        };
        squares.into_iter().enumerate().map(group).collect()
    }
}

impl Evidence {
    /// Eq. (3). `None` if the columns are collinear with those of the null model.
    pub fn gain(&self, s: &DMatrix<f64>) -> Option<Gain> {
        self.gains(s, s.ncols()).pop()?
    }

    /// Eq. (3) for each group of `width` neighbouring columns alone.
    pub fn gains(&self, s: &DMatrix<f64>, width: usize) -> Vec<Option<Gain>> {
        self.explain(s, width, |squares, power, seen| {
            if (0..power.nrows()).any(|j| power[(j, j)] <= ROUNDING * squares[(j, j)]) {
                return None;
            }
            let factor = power.clone().cholesky()?;
            let size = factor.solve(seen);
            Some((seen.dot(&size), size, factor))
        })
    }

    /// For each group of `width` columns the best result of `explain`, a function of S'S, S'PS and S'Pr, over all compared hyperparameters.
    pub(super) fn explain(
        &self,
        s: &DMatrix<f64>,
        width: usize,
        explain: impl Fn(&DMatrix<f64>, &DMatrix<f64>, &DVector<f64>) -> Option<Explained>,
    ) -> Vec<Option<Gain>> {
        let mut seen: Vec<_> =
            self.noises.iter().map(|noise| noise.seen(&self.series, s, width).into_iter()).collect();
        let groups = s.ncols() / width.max(1);
        (0..groups).map(|_| self.best(seen.iter_mut().filter_map(Iterator::next), &explain)).collect()
    }

    fn best(
        &self,
        group: impl Iterator<Item = Seen>,
        explain: impl Fn(&DMatrix<f64>, &DMatrix<f64>, &DVector<f64>) -> Option<Explained>,
    ) -> Option<Gain> {
        let mut best: Option<(f64, Explained, (usize, usize))> = None;
        let mut raw = 0.0;
        for (n, (noise, own)) in self.noises.iter().zip(group).enumerate() {
            for (k, (state, power)) in noise.states.iter().zip(&own.powers).enumerate() {
                let seen = own.left.column(k).into_owned();
                let Some((gain, size, factor)) = explain(&own.squares, power, &seen) else { continue };
                if (n, k) == (0, 0) {
                    raw = gain;
                }
                let cost = state.cost - gain;
                if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                    best = Some((cost, (gain, size, factor), (n, k)));
                }
            }
        }
        let (cost, (_, size, factor), state) = best?;
        Some(Gain { raw, whitened: self.cost().0 - cost, size, covariance: factor.inverse(), state })
    }
}
