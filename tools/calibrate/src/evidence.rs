//! Evidence for a further column in the residual, given parameters, sensor drift and structure error (the null model).
//!
//! r = Z c + S s + e,   e ~ N(0, 1),   c ~ N(c0, L^-1)                                      (1)
//! -2 log p(r) = min_c |r - Z c|^2 + (c - c0)' L (c - c0) + log |1 + K B'B|                 (2)
//! gain of S   = (S'P r)' (S'P S)^-1 (S'P r),   P = 1 - Z (Z'Z + L)^-1 Z'                   (3)
//! gain of S with s ~ N(0, q^2 K_s): (S'P r)' (S'P S + (q^2 K_s)^-1)^-1 (S'P r) - log |1 + q^2 K_s S'P S|   (4)
//!
//! r is a residual in units of its noise. Z holds the sensitivities to each declared parameter, in units of its prior deviation, and B.
//! B holds sensor drift, as hat functions over time with covariance K = sd^2 exp(-|t - t'| / length), and the directions of the
//! structure error (`search/structure.rs`) with covariance size^2. The three hyperparameters sd, length and size are unknown: every
//! gain is the decrease of (2) from its minimum over them without S to its minimum with S. `raw` gains are without drift and
//! structure error. A column that explains a slow residual of millikelvins must therefore fit better than sensor drift, and an effect
//! must explain more than structure error of the observed size.
//! *Sources*: Rasmussen, Williams, Gaussian Processes for Machine Learning (2006), sec. 2.7 and 5.4; Kennedy, O'Hagan, J. R. Stat. Soc. B
//! 63 (2001) 425-464 (structure error).

use crate::levels::NEGLIGIBLE;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Drifts that are compared: ratio of its standard deviation to that of the noise, and correlation time, s. Tuned: thermocouples drift
/// by up to their noise within an hour.
const DRIFTS: [(f64, f64); 7] =
    [(0.0, 1.0), (0.1, 2e3), (0.1, 2e4), (0.3, 2e3), (0.3, 2e4), (1.0, 2e3), (1.0, 2e4)];
/// Ratio of successive sizes of the structure error, from [`NEGLIGIBLE`] on. Numerical: a parabola refines the best one.
const APART: f64 = 3.0;
/// Inverse prior variance of absent components. Numerical: they are zero.
const ABSENT: f64 = 1e30;
/// Prior precision of a parameter without prior. Numerical: negligible, but gives parameters without influence a finite variance.
const FLAT: f64 = 1e-8;
/// Relative variance added to the diagonal of a drift's covariance. Numerical: keeps it positive definite.
const JITTER: f64 = 1e-6;
/// Part of a column orthogonal to the null model that is rounding, relative to its square. Numerical: 1e4 terms, condition 1e3.
const ROUNDING: f64 = 1e-9;
/// Prior sizes of a free shape that are compared: ratio of its variance to the mean estimation variance of the shape. Numerical:
/// between two of them ln p is lower by at most 0.7 for each coefficient.
const SIZES: [f64; 5] = [1.0, 3e1, 1e3, 3e4, 1e6];

/// A residual with the columns of the null model.
#[derive(Clone)]
pub struct Evidence {
    r: DVector<f64>,
    /// Columns of parameters, sensor drift and structure error.
    z: DMatrix<f64>,
    apart: Vec<f64>,
    /// Time and sensor of each drift column.
    knots: Vec<(f64, usize)>,
    /// Compared hyperparameters: drift sizes and correlation times, sizes of the structure error.
    states: Vec<State>,
}

#[derive(Clone)]
struct State {
    /// Cholesky factor of Z'Z + L.
    factor: Cholesky<f64, Dyn>,
    /// Residual after the estimate of c: r - Z (Z'Z + L)^-1 (Z'r + L c0).
    left: DVector<f64>,
    /// Eq. (2).
    cost: f64,
    /// Z'r + L c0.
    rhs: DVector<f64>,
    /// Drift: ratio of its standard deviation to that of the noise, and correlation time, s.
    drift: (f64, f64),
    /// Size of the structure error, in units of the noise.
    size: f64,
}

/// A gain, the estimated coefficients, and the Cholesky factor of their inverse covariance.
type Explained = (f64, DVector<f64>, Cholesky<f64, Dyn>);

/// Evidence for one or several columns.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Decrease of (2) without drift and structure error.
    pub raw: f64,
    /// Decrease of (2) with the best hyperparameters before and after.
    pub whitened: f64,
    /// The coefficients s, with the best hyperparameters after.
    pub size: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Index of these hyperparameters.
    state: usize,
}

impl Evidence {
    /// The null model of a residual. `slopes` are sensitivities to the parameters in units of their prior deviations, `apart` their
    /// deviations from the prior in this unit (NaN without a prior), `drift` the columns of B for a drift with the deviation of the noise,
    /// and `knots` the time and the sensor of each of them.
    pub fn new(
        r: DVector<f64>,
        slopes: &DMatrix<f64>,
        apart: &[f64],
        drift: &DMatrix<f64>,
        knots: &[(f64, usize)],
    ) -> Option<Evidence> {
        let z = beside(slopes, drift);
        let evidence = Evidence { r, z, apart: apart.to_vec(), knots: knots.to_vec(), states: Vec::new() };
        let sums = evidence.sums();
        let drifting = if knots.is_empty() { &DRIFTS[..1] } else { &DRIFTS[..] };
        let states =
            drifting.iter().map(|drift| evidence.state(&sums, *drift, 0.0)).collect::<Option<Vec<_>>>()?;
        Some(Evidence { states, ..evidence })
    }

    /// The null model extended by structure error with the directions `columns` for a size of 1.
    pub fn with_structure(&self, columns: &DMatrix<f64>) -> Option<Evidence> {
        let mut other = Evidence { z: beside(&self.z, columns), states: Vec::new(), ..self.clone() };
        let sums = other.sums();
        let plain = self.states.iter().map(|s| other.state(&sums, s.drift, 0.0));
        let plain = plain.collect::<Option<Vec<_>>>()?;
        let drift = self.fitting().drift;
        // Increase the size while the cost decreases, then take the vertex of the parabola through the last three, over the logarithm.
        let mut sizes: Vec<State> = Vec::new();
        while columns.ncols() > 0 && !rises(&sizes) {
            let size = sizes.last().map_or(NEGLIGIBLE, |s| APART * s.size);
            sizes.push(other.state(&sums, drift, size)?);
        }
        if let [.., a, b, c] = &sizes[..] {
            let way = vertex([a.cost, b.cost, c.cost]);
            let size = b.size * APART.powf(way);
            sizes.push(other.state(&sums, drift, size)?);
        }
        let least = |states: &[State]| states.iter().map(|s| s.cost).fold(f64::INFINITY, f64::min);
        if least(&sizes) >= least(&plain) {
            other.states = plain;
            return Some(other);
        }
        // With structure error, another drift may be optimal.
        let size = sizes.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?.size;
        for own in plain.iter().filter(|s| s.drift != drift) {
            let next = other.state(&sums, own.drift, size)?;
            if next.cost < least(&sizes) {
                sizes.push(next);
            }
        }
        // Keep the states without structure error (no drift, best drift) as alternatives for the gains.
        other.states = plain
            .into_iter()
            .enumerate()
            .filter(|(k, s)| *k == 0 || s.drift == drift)
            .map(|(_, s)| s)
            .collect();
        other.states.extend(sizes);
        Some(other)
    }

    /// Keeps only the best state and the one without drift and structure error.
    pub fn settle(&mut self) {
        let best = self.fitting().cost;
        let mut first = true;
        self.states.retain(|s| std::mem::take(&mut first) || s.cost <= best);
    }

    /// Releases all memory except the cost.
    pub fn release(&mut self) {
        self.settle();
        self.z = DMatrix::zeros(0, 0);
    }

    /// Z'Z and Z'r.
    fn sums(&self) -> (DMatrix<f64>, DVector<f64>) {
        (self.z.tr_mul(&self.z), self.z.tr_mul(&self.r))
    }

    /// The null model for given drift and size of the structure error.
    fn state(
        &self,
        (ztz, ztr): &(DMatrix<f64>, DVector<f64>),
        drift: (f64, f64),
        size: f64,
    ) -> Option<State> {
        let (p, d) = (self.apart.len(), self.knots.len());
        let all = self.z.ncols();
        let mut l = DMatrix::zeros(all, all);
        let mut toward = DVector::zeros(all);
        let mut prior_cost = 0.0;
        for (k, apart) in self.apart.iter().enumerate() {
            if apart.is_finite() {
                l[(k, k)] = 1.0;
                toward[k] = -apart;
                prior_cost += apart * apart;
            } else {
                l[(k, k)] = FLAT;
            }
        }
        let mut determinant = 0.0;
        let (sd, length) = drift;
        if sd > 0.0 {
            let kernel = DMatrix::from_fn(d, d, |a, b| {
                let ((t, s), (u, v)) = (self.knots[a], self.knots[b]);
                let near = if s == v { (-(t - u).abs() / length).exp() } else { 0.0 };
                sd * sd * near + if a == b { JITTER * sd * sd } else { 0.0 }
            });
            let factor = kernel.cholesky()?;
            determinant += log_determinant(&factor);
            l.view_mut((p, p), (d, d)).copy_from(&factor.inverse());
        }
        let absent = |k: usize| (k < p + d && sd == 0.0) || (k >= p + d && size == 0.0);
        for k in p..all {
            if absent(k) {
                l[(k, k)] = ABSENT;
                determinant -= ABSENT.ln();
            } else if k >= p + d {
                l[(k, k)] = 1.0 / (size * size);
                determinant += 2.0 * size.ln();
            }
        }
        let whole = ztz + &l;
        let inner = whole.view((p, p), (all - p, all - p)).into_owned();
        determinant += log_determinant(&inner.cholesky()?);
        let factor = whole.cholesky()?;
        let rhs = ztr + toward;
        let c = factor.solve(&rhs);
        let left = &self.r - &self.z * &c;
        let cost = self.r.norm_squared() + prior_cost - rhs.dot(&c) + determinant;
        Some(State { factor, left, cost, rhs, drift, size })
    }

    /// The state with the lowest cost.
    fn fitting(&self) -> &State {
        self.states.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(&self.states[0])
    }

    /// Best size of the structure error, in units of the noise.
    pub fn structure(&self) -> f64 {
        self.fitting().size
    }

    /// Number of values in the residual.
    pub fn values(&self) -> usize {
        self.r.len()
    }

    /// Best drift of the null model: ratio of its standard deviation to that of the noise, and correlation time, s.
    pub fn drift(&self) -> (f64, f64) {
        let best = self.fitting();
        best.drift
    }

    /// Mean square of the residual with the best drift, after further columns if given; 1 for noise.
    pub fn misfit(&self, beside: Option<(&DMatrix<f64>, &Gain)>) -> f64 {
        let left = match beside {
            None => self.fitting().left.norm_squared(),
            Some((s, gain)) => {
                let state = &self.states[gain.state];
                let lent = state.factor.solve(&self.z.tr_mul(s));
                (&state.left - (s - &self.z * lent) * &gain.size).norm_squared()
            }
        };
        left / self.r.len() as f64
    }

    /// Eq. (2) with the best hyperparameters, and without drift and structure error.
    pub fn cost(&self) -> (f64, f64) {
        (self.fitting().cost, self.states[0].cost)
    }

    /// First-order corrections of the parameters and their covariance with the best drift, in units of their prior deviations; estimated
    /// jointly with further columns if given.
    pub fn estimate(
        &self,
        parameters: usize,
        beside: Option<(&DMatrix<f64>, &Gain)>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let best = beside.map_or(self.fitting(), |(_, gain)| &self.states[gain.state]);
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

    /// Eq. (3). `None` if the columns are collinear with those of the null model.
    pub fn gain(&self, s: &DMatrix<f64>) -> Option<Gain> {
        self.best(s, |power, seen| {
            if (0..power.nrows()).any(|j| power[(j, j)] <= ROUNDING * s.column(j).norm_squared()) {
                return None;
            }
            let factor = power.clone().cholesky()?;
            let size = factor.solve(seen);
            Some((seen.dot(&size), size, factor))
        })
    }

    /// Eq. (4): columns of one smooth shape, with the prior covariance `kernel` of their coefficients.
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

    /// The best result of `explain`, a function of S'PS and S'Pr, over all compared hyperparameters.
    fn best(
        &self,
        s: &DMatrix<f64>,
        explain: impl Fn(&DMatrix<f64>, &DVector<f64>) -> Option<Explained>,
    ) -> Option<Gain> {
        let (sts, zts) = (s.tr_mul(s), self.z.tr_mul(s));
        let mut best: Option<(f64, Explained, usize)> = None;
        let mut raw = 0.0;
        for (k, state) in self.states.iter().enumerate() {
            let seen_too = state.factor.l_dirty().solve_lower_triangular(&zts)?;
            let power = &sts - seen_too.tr_mul(&seen_too);
            let seen = s.tr_mul(&state.left);
            let Some((gain, size, factor)) = explain(&power, &seen) else { continue };
            if k == 0 {
                raw = gain;
            }
            let cost = state.cost - gain;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                best = Some((cost, (gain, size, factor), k));
            }
        }
        let (cost, (_, size, factor), state) = best?;
        Some(Gain { raw, whitened: self.cost().0 - cost, size, covariance: factor.inverse(), state })
    }
}

/// Whether the last size has at least the cost of the one before.
fn rises(sizes: &[State]) -> bool {
    matches!(sizes, [.., a, b] if b.cost.total_cmp(&a.cost).is_ge())
}

/// Minimum of the parabola through costs at -1, 0 and 1, limited to that range.
fn vertex([a, b, c]: [f64; 3]) -> f64 {
    let curvature = a - 2.0 * b + c;
    if curvature > 0.0 { (0.5 * (a - c) / curvature).clamp(-1.0, 1.0) } else { 0.0 }
}

/// Columns of two matrices side by side.
fn beside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut z = DMatrix::zeros(a.nrows(), a.ncols() + b.ncols());
    z.columns_mut(0, a.ncols()).copy_from(a);
    z.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    z
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::normal;

    fn column(n: usize, of: impl Fn(f64) -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(n, 1, |k, _| of(k as f64 / n as f64))
    }

    /// Hat functions over a time of 10 000 s, for readings of nine rows each.
    fn sensor(n: usize) -> (DMatrix<f64>, Vec<(f64, usize)>) {
        let points: Vec<f64> = (0..12).map(|k| k as f64 / 11.0).collect();
        let drift =
            DMatrix::from_fn(n, 12, |row, k| 3.0 * crate::hypothesis::hat(&points, k, row as f64 / n as f64));
        (drift, points.iter().map(|t| (1e4 * t, 0)).collect())
    }

    /// A planted signal is recovered with its size, given a parameter and sensor drift, with the variance of least squares.
    #[test]
    fn what_was_planted_is_found() {
        let (n, mut rng) = (400, crate::testing::rng(2));
        let fast = column(n, |t| if (40.0 * t).sin() > 0.0 { 1.0 } else { -1.0 });
        let slope = column(n, |t| 5.0 * t);
        let r = DVector::from_fn(n, |k, _| 0.7 * fast[(k, 0)] + 0.4 * slope[(k, 0)] + normal(&mut rng));
        let (drift, knots) = sensor(n);
        let gain = Evidence::new(r, &slope, &[0.0], &drift, &knots).unwrap().gain(&fast).unwrap();
        let deviation = gain.covariance[(0, 0)].sqrt();
        // Almost orthogonal to all other columns: deviation 1 / sqrt n.
        assert!((deviation * (n as f64).sqrt() - 1.0).abs() < 0.1, "{deviation}");
        assert!((gain.size[0] - 0.7).abs() < 3.0 * deviation, "{gain:?}");
        let expected = (0.7 / deviation).powi(2);
        assert!(gain.raw > 0.6 * expected && gain.whitened > 0.6 * expected, "{gain:?} {expected}");
    }

    /// Sensor drift and a slow column that resembles it: evidence against white noise alone, no evidence against drift.
    #[test]
    fn a_drift_is_no_effect() {
        let (n, mut rng) = (400, crate::testing::rng(4));
        let (drift, knots) = sensor(n);
        let walk = |t: f64| (3.1 * t).sin() + 0.5 * (7.3 * t + 1.0).cos();
        let r = DVector::from_fn(n, |k, _| 1.5 * walk(k as f64 / n as f64) + normal(&mut rng));
        let none = DMatrix::zeros(n, 0);
        let slow = column(n, |t| (3.0 * t).sin());
        let gain = Evidence::new(r, &none, &[], &drift, &knots).unwrap().gain(&slow).unwrap();
        assert!(gain.raw > 100.0 && gain.whitened < 10.0, "{gain:?}");
    }

    /// Three readings, a free mean and a ramp: of the sum of squares 14 the mean leaves 2, which the ramp explains.
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

    /// Two laws of the null model with small errors: a residual that resembles them is no evidence for an effect, since structure error of
    /// the observed size explains it; a much larger residual is.
    #[test]
    fn structure_error_is_no_effect() {
        let (n, mut rng) = (400, crate::testing::rng(6));
        let waves =
            DMatrix::from_fn(n, 12, |k, j| 1.4 * ((j + 1) as f64 * 0.008 * k as f64 + j as f64).sin());
        let none = DMatrix::zeros(n, 0);
        let column = column(n, |t| (10.0 * t).sin());
        let mut found = |size: f64, effect: f64| {
            let numbers = DVector::from_fn(12, |_, _| size * normal(&mut rng));
            let r = &waves * numbers + effect * &column + DVector::from_fn(n, |_, _| normal(&mut rng));
            let evidence = Evidence::new(r, &none, &[], &none, &[]).unwrap().with_structure(&waves).unwrap();
            (evidence.structure(), evidence.gain(&column.columns(0, 1).into_owned()).unwrap())
        };
        let (size, gain) = found(0.0, 0.0);
        assert!(size <= NEGLIGIBLE && gain.whitened < 10.0, "{size} {gain:?}");
        let (size, gain) = found(1.0, 0.0);
        assert!((0.4..3.0).contains(&size) && gain.whitened < 10.0 && gain.raw > 100.0, "{size} {gain:?}");
        let (_, gain) = found(0.0, 5.0);
        assert!(gain.whitened > 30.0, "{gain:?}");
        assert!((gain.size[0] - 5.0).abs() < 1.0, "{gain:?}");
    }

    /// -2 log of a normal density, without the constant 2 pi.
    fn minus_two_log(r: &DVector<f64>, mean: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let factor = covariance.clone().cholesky().unwrap();
        let off = r - mean;
        off.dot(&factor.solve(&off)) + covariance.determinant().ln()
    }

    /// Eq. (2) and (4) against explicit densities: four readings, a parameter with a deviation of 0.3 from its prior, drift of a sensor
    /// with two points, a shape with two coefficients.
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
            // The determinant of the parameters alone is the same for all states and omitted.
            let whole = minus_two_log(&r, &mean, &(&plain + &drifting));
            whole - (&plain + &drifting).determinant().ln() + (&one + &drifting).determinant().ln()
        });
        let told = costs.fold(f64::INFINITY, f64::min);
        assert!((evidence.cost().0 - told).abs() < 1e-4, "{:?} instead of {told}", evidence.cost());
        // Structure error of each compared size, as covariance.
        let structure = DMatrix::from_vec(4, 2, vec![0.3, -0.2, 1.5, 0.4, 1.0, 0.9, -0.8, 0.1]);
        let evidence = Evidence::new(r.clone(), &z, &[0.3], &DMatrix::zeros(4, 0), &[]).unwrap();
        let evidence = evidence.with_structure(&structure).unwrap();
        assert!(evidence.states.len() > 3);
        for state in &evidence.states {
            let wrong = &structure * structure.transpose() * (state.size * state.size);
            let whole = minus_two_log(&r, &mean, &(&plain + &wrong));
            let told = whole - (&plain + &wrong).determinant().ln() + (&one + &wrong).determinant().ln();
            assert!((state.cost - told).abs() < 1e-6, "{} instead of {told}", state.cost);
        }
    }
}
