//! How much a further column would explain of a residual, beside all that parameters and drifting sensors can do.
//!
//! r = Z c + S s + e,   e ~ N(0, 1),   c ~ N(c0, L^-1)                                      (1)
//! -2 log p(r) = min_c |r - Z c|^2 + (c - c0)' L (c - c0) + log |1 + K B'B|                 (2)
//! gain of S   = (S'P r)' (S'P S)^-1 (S'P r),   P = 1 - Z (Z'Z + L)^-1 Z'                   (3)
//! gain of S with s ~ N(0, q^2 K_s): (S'P r)' (S'P S + (q^2 K_s)^-1)^-1 (S'P r) - log |1 + q^2 K_s S'P S|   (4)
//!
//! r is a residual in units of its noise. Z holds the slopes over each declared parameter, in units of its prior's deviation,
//! and B: what slowly drifting sensors would do, hat functions over the clock with covariance
//! K = sd^2 exp(-|t - t'| / length). Its two numbers are not known; every gain is the fall of (2) between the best
//! pair without S and the best pair with it. `raw` gains are those without drift. What explains a slow residual of
//! millikelvins has to be better than a drifting sensor.
//! *Source*: Rasmussen, Williams, Gaussian Processes for Machine Learning (2006), sec. 2.7 and 5.4.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Drifts that are tried: standard deviation over that of the noise, and time over which a drift forgets itself, s.
const DRIFTS: [(f64, f64); 7] =
    [(0.0, 1.0), (0.1, 2e3), (0.1, 2e4), (0.3, 2e3), (0.3, 2e4), (1.0, 2e3), (1.0, 2e4)];
/// Sizes of a free shape that are tried: variance over the shape's own mean uncertainty.
const SIZES: [f64; 5] = [1.0, 3e1, 1e3, 3e4, 1e6];

/// A residual with all that may explain it already.
#[derive(Clone)]
pub struct Evidence {
    r: DVector<f64>,
    z: DMatrix<f64>,
    drifts: Vec<Drift>,
}

#[derive(Clone)]
struct Drift {
    /// Of Z'Z + L.
    factor: Cholesky<f64, Dyn>,
    /// What is left of r, without what c0 asks for: r - Z (Z'Z + L)^-1 (Z'r + L c0).
    left: DVector<f64>,
    /// Eq. (2).
    cost: f64,
    /// Z'r + L c0.
    rhs: DVector<f64>,
    sd: f64,
    length: f64,
}

/// What a column, or several, would explain.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Fall of (2) without drift.
    pub raw: f64,
    /// Fall of (2) with the drift that suits best, before and after.
    pub whitened: f64,
    /// The numbers s, by the drift that suits best after.
    pub size: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
}

impl Evidence {
    /// The problem of a residual: `slopes` over the parameters in units of their prior deviations, `apart` how far each
    /// stands from its prior in the same unit (NaN where it has no prior), `drift` the columns of B for a drift as large as
    /// the noise, and `knots` the clock and the sensor that each belongs to.
    pub fn new(
        r: DVector<f64>,
        slopes: &DMatrix<f64>,
        apart: &[f64],
        drift: &DMatrix<f64>,
        knots: &[(f64, usize)],
    ) -> Option<Evidence> {
        let (n, p, d) = (r.len(), slopes.ncols(), drift.ncols());
        let mut z = DMatrix::zeros(n, p + d);
        z.view_mut((0, 0), (n, p)).copy_from(slopes);
        z.view_mut((0, p), (n, d)).copy_from(drift);
        let (ztz, ztr) = (z.tr_mul(&z), z.tr_mul(&r));
        let drifting = if d > 0 { &DRIFTS[..] } else { &DRIFTS[..1] };
        let mut drifts = Vec::new();
        for &(sd, length) in drifting {
            let mut l = DMatrix::zeros(p + d, p + d);
            let mut toward = DVector::zeros(p + d);
            let mut prior_cost = 0.0;
            for (k, apart) in apart.iter().enumerate() {
                if apart.is_finite() {
                    l[(k, k)] = 1.0;
                    toward[k] = -apart;
                    prior_cost += apart * apart;
                } else {
                    // So flat that it does not matter, so that what is not seen at all has a size.
                    l[(k, k)] = 1e-8;
                }
            }
            let mut determinant = 0.0;
            if sd == 0.0 {
                for k in p..p + d {
                    l[(k, k)] = 1e30;
                }
            } else {
                let kernel = DMatrix::from_fn(d, d, |a, b| {
                    let ((t, s), (u, v)) = (knots[a], knots[b]);
                    let near = if s == v { (-(t - u).abs() / length).exp() } else { 0.0 };
                    sd * sd * near + if a == b { 1e-6 * sd * sd } else { 0.0 }
                });
                let inverse = kernel.clone().cholesky()?.inverse();
                l.view_mut((p, p), (d, d)).copy_from(&inverse);
                let inner = &inverse + ztz.view((p, p), (d, d));
                determinant = log_determinant(&inner.cholesky()?) + log_determinant(&kernel.cholesky()?);
            }
            let factor = (&ztz + &l).cholesky()?;
            let rhs = &ztr + toward;
            let c = factor.solve(&rhs);
            let left = &r - &z * &c;
            let cost = r.norm_squared() + prior_cost - rhs.dot(&c) + determinant;
            drifts.push(Drift { factor, left, cost, rhs, sd, length });
        }
        Some(Evidence { r, z, drifts })
    }

    /// Number of values in the residual.
    pub fn values(&self) -> usize {
        self.r.len()
    }

    /// The drift that suits best without a further column: its standard deviation over that of the noise, and its
    /// memory, s.
    pub fn drift(&self) -> (f64, f64) {
        let best = self.drifts.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map_or((0.0, 1.0), |d| (d.sd, d.length))
    }

    /// Mean square of what is left with the drift that suits best: 1 for noise.
    pub fn misfit(&self) -> f64 {
        let best = self.drifts.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map_or(1.0, |d| d.left.norm_squared() / self.r.len() as f64)
    }

    /// Eq. (2) of the drift that suits best, and without drift.
    pub fn cost(&self) -> (f64, f64) {
        let best = self.drifts.iter().map(|d| d.cost).fold(f64::INFINITY, f64::min);
        (best, self.drifts[0].cost)
    }

    /// By how much the parameters move from where they stand, in units of their prior deviations, once the columns are
    /// followed with these numbers; without drift.
    pub fn moved(&self, s: &DMatrix<f64>, numbers: &DVector<f64>, parameters: usize) -> Vec<f64> {
        let first = &self.drifts[0];
        let c = first.factor.solve(&(&first.rhs - self.z.tr_mul(&(s * numbers))));
        c.rows(0, parameters).iter().copied().collect()
    }

    /// The parameters' corrections to first order and their deviations, with the drift that suits best, in units of
    /// their prior deviations.
    pub fn estimate(&self, parameters: usize) -> (Vec<f64>, DMatrix<f64>) {
        let best = self.drifts.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(&self.drifts[0]);
        let c = best.factor.solve(&best.rhs);
        let covariance = best.factor.inverse();
        let view = covariance.view((0, 0), (parameters, parameters)).into_owned();
        (c.rows(0, parameters).iter().copied().collect(), view)
    }

    /// Eq. (3). `None` where the columns are seen by nothing but what is there already.
    pub fn gain(&self, s: &DMatrix<f64>) -> Option<Gain> {
        self.best(s, |power, seen| {
            // What is left of a column after all the others, beside rounding.
            if (0..power.nrows()).any(|j| power[(j, j)] <= 1e-9 * s.column(j).norm_squared()) {
                return None;
            }
            let factor = power.clone().cholesky()?;
            let size = factor.solve(seen);
            Some((seen.dot(&size), size, factor))
        })
    }

    /// Eq. (4): columns of one smooth shape, with the covariance `kernel` between their numbers.
    pub fn shape(&self, s: &DMatrix<f64>, kernel: &DMatrix<f64>) -> Option<Gain> {
        let factor = kernel.clone().cholesky()?;
        let (inverse, prior) = (factor.inverse(), log_determinant(&factor));
        self.best(s, |power, seen| {
            let scale = power.trace() / power.nrows() as f64;
            if !(scale > 0.0) {
                return None;
            }
            let of = |size: f64| {
                let q = size / scale;
                let factor = (power + &inverse / q).cholesky()?;
                let numbers = factor.solve(seen);
                let occam = log_determinant(&factor) + prior + power.nrows() as f64 * q.ln();
                Some((seen.dot(&numbers) - occam, numbers, factor))
            };
            SIZES.iter().filter_map(|size| of(*size)).max_by(|a, b| a.0.total_cmp(&b.0))
        })
    }

    /// What `explain` gives for S'PS and S'Pr, drift by drift.
    fn best(
        &self,
        s: &DMatrix<f64>,
        explain: impl Fn(&DMatrix<f64>, &DVector<f64>) -> Option<(f64, DVector<f64>, Cholesky<f64, Dyn>)>,
    ) -> Option<Gain> {
        let (sts, zts) = (s.tr_mul(s), self.z.tr_mul(s));
        let mut best: Option<(f64, DVector<f64>, Cholesky<f64, Dyn>)> = None;
        let mut raw = 0.0;
        for (k, drift) in self.drifts.iter().enumerate() {
            let power = &sts - zts.tr_mul(&drift.factor.solve(&zts));
            let seen = s.tr_mul(&drift.left);
            let Some((gain, size, factor)) = explain(&power, &seen) else { continue };
            if k == 0 {
                raw = gain;
            }
            let cost = drift.cost - gain;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                best = Some((cost, size, factor));
            }
        }
        let (cost, size, factor) = best?;
        Some(Gain { raw, whitened: self.cost().0 - cost, size, covariance: factor.inverse() })
    }
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
}
