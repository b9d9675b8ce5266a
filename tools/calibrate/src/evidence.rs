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

/// A gain, the numbers, and the factor of their inverse covariance.
type Explained = (f64, DVector<f64>, Cholesky<f64, Dyn>);

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
    /// That drift, by its index.
    drift: usize,
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

    /// The drift that suits best.
    fn fitting(&self) -> &Drift {
        self.drifts.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(&self.drifts[0])
    }

    /// Number of values in the residual.
    pub fn values(&self) -> usize {
        self.r.len()
    }

    /// The drift that suits best without a further column: its standard deviation over that of the noise, and its
    /// memory, s.
    pub fn drift(&self) -> (f64, f64) {
        let best = self.fitting();
        (best.sd, best.length)
    }

    /// Mean square of what is left with the drift that suits best, beside further columns with what they explain: 1 for noise.
    pub fn misfit(&self, beside: Option<(&DMatrix<f64>, &Gain)>) -> f64 {
        let left = match beside {
            None => self.fitting().left.norm_squared(),
            Some((s, gain)) => {
                let drift = &self.drifts[gain.drift];
                let lent = drift.factor.solve(&self.z.tr_mul(s));
                (&drift.left - (s - &self.z * lent) * &gain.size).norm_squared()
            }
        };
        left / self.r.len() as f64
    }

    /// Eq. (2) of the drift that suits best, and without drift.
    pub fn cost(&self) -> (f64, f64) {
        (self.fitting().cost, self.drifts[0].cost)
    }

    /// The parameters' corrections to first order and their covariance, with the drift that suits best, in units of
    /// their prior deviations; beside further columns with what they explain.
    pub fn estimate(
        &self,
        parameters: usize,
        beside: Option<(&DMatrix<f64>, &Gain)>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let best = beside.map_or(self.fitting(), |(_, gain)| &self.drifts[gain.drift]);
        let mut c = best.factor.solve(&best.rhs);
        let mut covariance = best.factor.inverse();
        if let Some((s, gain)) = beside {
            let lent = best.factor.solve(&self.z.tr_mul(s));
            c -= &lent * &gain.size;
            covariance += &lent * &gain.covariance * lent.transpose();
        }
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
            if scale.is_nan() || scale <= 0.0 {
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
        explain: impl Fn(&DMatrix<f64>, &DVector<f64>) -> Option<Explained>,
    ) -> Option<Gain> {
        let (sts, zts) = (s.tr_mul(s), self.z.tr_mul(s));
        let mut best: Option<(f64, Explained, usize)> = None;
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
                best = Some((cost, (gain, size, factor), k));
            }
        }
        let (cost, (_, size, factor), drift) = best?;
        Some(Gain { raw, whitened: self.cost().0 - cost, size, covariance: factor.inverse(), drift })
    }
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::normal;

    fn column(n: usize, of: impl Fn(f64) -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(n, 1, |k, _| of(k as f64 / n as f64))
    }

    /// Hat functions over a clock of 10 000 s, for readings of nine rows each.
    fn sensor(n: usize) -> (DMatrix<f64>, Vec<(f64, usize)>) {
        let points: Vec<f64> = (0..12).map(|k| k as f64 / 11.0).collect();
        let drift =
            DMatrix::from_fn(n, 12, |row, k| 3.0 * crate::hypothesis::hat(&points, k, row as f64 / n as f64));
        (drift, points.iter().map(|t| (1e4 * t, 0)).collect())
    }

    /// A planted signal comes back with its size, beside a parameter and a drifting sensor, as surely as least squares say.
    #[test]
    fn what_was_planted_is_found() {
        let (n, mut rng) = (400, crate::trial::rng(2));
        let fast = column(n, |t| if (40.0 * t).sin() > 0.0 { 1.0 } else { -1.0 });
        let slope = column(n, |t| 5.0 * t);
        let r = DVector::from_fn(n, |k, _| 0.7 * fast[(k, 0)] + 0.4 * slope[(k, 0)] + normal(&mut rng));
        let (drift, knots) = sensor(n);
        let gain = Evidence::new(r, &slope, &[0.0], &drift, &knots).unwrap().gain(&fast).unwrap();
        let deviation = gain.covariance[(0, 0)].sqrt();
        // Hardly anything else can do what it does: 1 / sqrt n.
        assert!((deviation * (n as f64).sqrt() - 1.0).abs() < 0.1, "{deviation}");
        assert!((gain.size[0] - 0.7).abs() < 3.0 * deviation, "{gain:?}");
        let expected = (0.7 / deviation).powi(2);
        assert!(gain.raw > 0.6 * expected && gain.whitened > 0.6 * expected, "{gain:?} {expected}");
    }

    /// A sensor that drifts, and a slow column that looks like it: white noise alone would take it, drift explains it.
    #[test]
    fn a_drift_is_no_effect() {
        let (n, mut rng) = (400, crate::trial::rng(4));
        let (drift, knots) = sensor(n);
        let walk = |t: f64| (3.1 * t).sin() + 0.5 * (7.3 * t + 1.0).cos();
        let r = DVector::from_fn(n, |k, _| 1.5 * walk(k as f64 / n as f64) + normal(&mut rng));
        let none = DMatrix::zeros(n, 0);
        let slow = column(n, |t| (3.0 * t).sin());
        let gain = Evidence::new(r, &none, &[], &drift, &knots).unwrap().gain(&slow).unwrap();
        assert!(gain.raw > 100.0 && gain.whitened < 10.0, "{gain:?}");
    }

    /// Three readings, a mean that is free and a ramp: the ramp takes the 2 that the mean leaves of 14.
    #[test]
    fn raw_is_the_fall_of_the_squares() {
        let r = DVector::from_vec(vec![1.0, 2.0, 3.0]);
        let (mean, ramp) = (DMatrix::from_element(3, 1, 1.0), DMatrix::from_vec(3, 1, vec![0.0, 1.0, 2.0]));
        let evidence = Evidence::new(r, &mean, &[f64::NAN], &DMatrix::zeros(3, 0), &[]).unwrap();
        assert!((evidence.cost().1 - 2.0).abs() < 1e-6);
        let gain = evidence.gain(&ramp).unwrap();
        assert!((gain.raw - 2.0).abs() < 1e-6 && (gain.whitened - 2.0).abs() < 1e-6, "{gain:?}");
        assert!((gain.size[0] - 1.0).abs() < 1e-6 && (gain.covariance[(0, 0)] - 0.5).abs() < 1e-6);
    }

    /// -2 log of a normal density, without 2 pi.
    fn minus_two_log(r: &DVector<f64>, mean: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let factor = covariance.clone().cholesky().unwrap();
        let off = r - mean;
        off.dot(&factor.solve(&off)) + covariance.determinant().ln()
    }

    /// Eq. (2) and (4) against densities written out: four readings, a parameter that stands 0.3 from its prior, a sensor
    /// with two points, a shape of two numbers.
    #[test]
    fn evidence_is_that_of_the_densities() {
        let r = DVector::from_vec(vec![2.0, -1.0, 0.5, 3.0]);
        let z = DMatrix::from_vec(4, 1, vec![1.0, 0.5, -0.5, 0.2]);
        let s = DMatrix::from_vec(4, 2, vec![1.0, 0.0, 0.3, 2.0, 0.1, -1.0, 0.4, 0.6]);
        let kernel = DMatrix::from_vec(2, 2, vec![1.0, 0.5, 0.5, 1.0]);
        let mean = &z * DVector::from_element(1, -0.3);
        let one = DMatrix::<f64>::identity(4, 4);
        let plain = &one + &z * z.transpose();
        let evidence = Evidence::new(r.clone(), &z, &[0.3], &DMatrix::zeros(4, 0), &[]).unwrap();
        let power = s.transpose() * plain.clone().cholesky().unwrap().solve(&s);
        let with = |size: f64| &plain + &s * &kernel * s.transpose() * (size / (power.trace() / 2.0));
        let told = SIZES.iter().map(|size| minus_two_log(&r, &mean, &with(*size)));
        let told = minus_two_log(&r, &mean, &plain) - told.fold(f64::INFINITY, f64::min);
        let gain = evidence.shape(&s, &kernel).unwrap();
        assert!((gain.raw - told).abs() < 1e-6, "{} instead of {told}", gain.raw);
        let drift = DMatrix::from_vec(4, 2, vec![1.0, 0.5, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0]);
        let evidence = Evidence::new(r.clone(), &z, &[0.3], &drift, &[(0.0, 0), (1e3, 0)]).unwrap();
        let costs = DRIFTS.iter().map(|(sd, length)| {
            let near = (-1e3 / length).exp();
            let k = DMatrix::from_vec(2, 2, vec![1.0, near, near, 1.0]) * (sd * sd);
            let drifting = &drift * k * drift.transpose();
            // The parameters' own share of the determinant is the same for all, and left out.
            let whole = minus_two_log(&r, &mean, &(&plain + &drifting));
            whole - (&plain + &drifting).determinant().ln() + (&one + &drifting).determinant().ln()
        });
        let told = costs.fold(f64::INFINITY, f64::min);
        assert!((evidence.cost().0 - told).abs() < 1e-4, "{:?} instead of {told}", evidence.cost());
    }
}
