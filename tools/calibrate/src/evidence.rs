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
//! must explain more than structure error of the observed size. The covariance of e is compared as well: white noise of the stated size,
//! or noise with a memory (`evidence/memory.rs`), in which case r, Z and S are whitened first.
//! *Sources*: Rasmussen, Williams, Gaussian Processes for Machine Learning (2006), sec. 2.7 and 5.4; Kennedy, O'Hagan, J. R. Stat. Soc. B
//! 63 (2001) 425-464 (structure error).

mod drift;
mod gains;
mod memory;
mod prior;
#[cfg(test)]
mod tests;

use crate::algebra::{cholesky, solve_lower, squares};
use crate::levels::NEGLIGIBLE;
use crate::selection::NEAR;
use drift::Drift;
pub use memory::{Memory, Series};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
pub use prior::Prior;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Drifts that are compared: ratio of its standard deviation to that of the noise, and correlation time, s. Tuned: thermocouples drift
/// by up to their noise within an hour.
const DRIFTS: [(f64, f64); 7] =
    [(0.0, 1.0), (0.1, 2e3), (0.1, 2e4), (0.3, 2e3), (0.3, 2e4), (1.0, 2e3), (1.0, 2e4)];
/// Ratio of successive sizes of the structure error, from [`NEGLIGIBLE`] on. Numerical: a parabola refines the best one.
const APART: f64 = 3.0;
/// Inverse prior variance of absent components. Numerical: they are zero.
const ABSENT: f64 = 1e30;
/// Largest number of estimates of the noise. Numerical: each changes what drift and structure error leave, the second by a few percent.
const REPETITIONS: usize = 3;
/// Part of a column orthogonal to the null model that is rounding, relative to its square. Numerical: 1e4 terms, condition 1e3.
const ROUNDING: f64 = 1e-9;
/// Prior sizes of a free shape that are compared: ratio of its variance to the mean estimation variance of the shape. Numerical:
/// between two of them ln p is lower by at most 0.7 for each coefficient.
const SIZES: [f64; 5] = [1.0, 3e1, 1e3, 3e4, 1e6];

/// A residual with the columns of the null model.
#[derive(Clone)]
pub struct Evidence {
    prior: Prior,
    /// Drift of the sensors.
    drift: Arc<Drift>,
    /// Outputs and runs of the values.
    series: Vec<Series>,
    /// Compared covariances of the noise; the first is white noise of the stated size.
    noises: Vec<Noise>,
}

/// A covariance of the noise.
#[derive(Clone)]
struct Noise {
    /// `None` for white noise of the stated size.
    memory: Option<Memory>,
    /// The residual, whitened.
    r: DVector<f64>,
    /// Columns of parameters, sensor drift and structure error, whitened.
    z: DMatrix<f64>,
    /// Z'Z.
    ztz: DMatrix<f64>,
    /// Log determinant of the covariance.
    determinant: f64,
    /// Compared hyperparameters: drift sizes and correlation times, sizes of the structure error.
    states: Vec<State>,
}

impl Noise {
    /// White noise of the stated size; `known` are the first rows and columns of Z'Z.
    fn white(r: DVector<f64>, z: DMatrix<f64>, known: &DMatrix<f64>) -> Noise {
        let ztz = squares(&z, known);
        Noise { memory: None, r, z, ztz, determinant: 0.0, states: Vec::new() }
    }

    /// Columns in units of this noise.
    fn whitened(&self, series: &[Series], s: &DMatrix<f64>) -> DMatrix<f64> {
        self.memory.as_ref().map_or_else(|| s.clone(), |memory| memory.whitened(series, s))
    }

    /// Residual after the estimate of c.
    fn left(&self, c: &DVector<f64>) -> DVector<f64> {
        &self.r - &self.z * c
    }

    /// The state with the lowest cost.
    fn fitting(&self) -> &State {
        self.states.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(&self.states[0])
    }
}

#[derive(Clone)]
struct State {
    /// Cholesky factor F of Z'Z + L.
    factor: Cholesky<f64, Dyn>,
    /// F^-1, if it was used: hundreds of candidates are compared in the same state.
    inverse: OnceLock<DMatrix<f64>>,
    /// The estimate of c: (Z'Z + L)^-1 (Z'r + L c0).
    c: DVector<f64>,
    /// Eq. (2).
    cost: f64,
    /// Drift: ratio of its standard deviation to that of the noise, and correlation time, s.
    drift: (f64, f64),
    /// Size of the structure error, in units of the noise.
    size: f64,
}

impl State {
    /// F^-1.
    fn inverse(&self) -> &DMatrix<f64> {
        self.inverse.get_or_init(|| {
            let n = self.c.len();
            solve_lower(&self.factor, DMatrix::identity(n, n))
        })
    }
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
    /// Indices of the covariance of the noise and of these hyperparameters.
    state: (usize, usize),
}

impl Gain {
    /// The same less the price of coefficients.
    pub fn less(self, price: f64) -> Gain {
        Gain { raw: self.raw - price, whitened: self.whitened - price, ..self }
    }
}

impl Evidence {
    /// The null model of a residual. `slopes` are sensitivities to the parameters in the units of their `prior`, `drift` the columns of B
    /// for a drift with the deviation of the noise, `knots` the time and the sensor of each of them, and `series` the outputs and runs of
    /// the values.
    pub fn new(
        r: DVector<f64>,
        slopes: &DMatrix<f64>,
        prior: Prior,
        drift: &DMatrix<f64>,
        knots: &[(f64, usize)],
        series: Vec<Series>,
    ) -> Option<Evidence> {
        let mut evidence =
            Evidence { prior, drift: Arc::new(Drift::new(knots)?), series, noises: Vec::new() };
        let mut white = Noise::white(r, beside(slopes, drift), &DMatrix::zeros(0, 0));
        let ztr = white.z.tr_mul(&white.r);
        let states = evidence.drifts().iter().map(|drift| evidence.state(&white, &ztr, *drift, 0.0));
        white.states = states.collect::<Option<Vec<_>>>()?;
        evidence.noises.push(white);
        Some(evidence)
    }

    /// Drifts that are compared.
    fn drifts(&self) -> &'static [(f64, f64)] {
        if self.drift.count == 0 { &DRIFTS[..1] } else { &DRIFTS[..] }
    }

    /// The null model extended by structure error with the directions `columns` for a size of 1.
    pub fn with_structure(&self, columns: &DMatrix<f64>) -> Option<Evidence> {
        let own = &self.noises[0];
        let mut white = Noise::white(own.r.clone(), beside(&own.z, columns), &own.ztz);
        let (prior, series) = (self.prior.clone(), self.series.clone());
        let mut other = Evidence { prior, drift: Arc::clone(&self.drift), series, noises: Vec::new() };
        let ztr = white.z.tr_mul(&white.r);
        let plain = own.states.iter().map(|s| other.state(&white, &ztr, s.drift, 0.0));
        let plain = plain.collect::<Option<Vec<_>>>()?;
        let drift = own.fitting().drift;
        // Increase the size while the cost decreases, then take the vertex of the parabola through the last three, over the logarithm.
        let mut sizes: Vec<State> = Vec::new();
        while columns.ncols() > 0 && !rises(&sizes) {
            let size = sizes.last().map_or(NEGLIGIBLE, |s| APART * s.size);
            sizes.push(other.state(&white, &ztr, drift, size)?);
        }
        if let [.., a, b, c] = &sizes[..] {
            let way = vertex([a.cost, b.cost, c.cost]);
            let size = b.size * APART.powf(way);
            sizes.push(other.state(&white, &ztr, drift, size)?);
        }
        let least = |states: &[State]| states.iter().map(|s| s.cost).fold(f64::INFINITY, f64::min);
        white.states = if least(&sizes) >= least(&plain) {
            plain
        } else {
            // With structure error, another drift may be optimal.
            let size = sizes.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?.size;
            for own in plain.iter().filter(|s| s.drift != drift) {
                let next = other.state(&white, &ztr, own.drift, size)?;
                if next.cost < least(&sizes) {
                    sizes.push(next);
                }
            }
            // Keep the states without structure error (no drift, best drift) as alternatives for the gains.
            let simpler = plain.into_iter().enumerate().filter(|(k, s)| *k == 0 || s.drift == drift);
            simpler.map(|(_, s)| s).chain(sizes).collect()
        };
        other.noises.push(white);
        Some(other)
    }

    /// The same null model without the priors of tables. Whether a run asks for another size is judged without them: a table that only this
    /// run determines would trade its prior against the size.
    pub fn without_tables(&self) -> Option<Cow<'_, Evidence>> {
        if !self.prior.has_tables() {
            return Some(Cow::Borrowed(self));
        }
        let mut other = Evidence { prior: self.prior.without_tables(), ..self.clone() };
        for n in 0..other.noises.len() {
            let noise = &other.noises[n];
            let ztr = noise.z.tr_mul(&noise.r);
            let states = noise.states.iter().map(|s| other.state(noise, &ztr, s.drift, s.size));
            let states = states.collect::<Option<Vec<_>>>()?;
            other.noises[n].states = states;
        }
        Some(Cow::Owned(other))
    }

    /// Extends the null model by noise with a memory, if the residual has it.
    pub fn add_memory(&mut self) -> Option<()> {
        let white = &self.noises[0];
        let best = white.fitting();
        let (mut left, mut used) = (white.left(&best.c), self.used(best)?);
        let mut hyper = (best.drift, best.size);
        let mut found: Option<Noise> = None;
        for _ in 0..REPETITIONS {
            let memory = Memory::of(&self.series, &left, used / left.len() as f64);
            if memory.is_negligible() {
                break;
            }
            let r = DMatrix::from_columns(std::slice::from_ref(&white.r));
            let r = memory.whitened(&self.series, &r).column(0).into_owned();
            let z = memory.whitened(&self.series, &white.z);
            let (determinant, ztr) = (memory.log_determinant(&self.series), z.tr_mul(&r));
            let same = Noise::white(r, z, &DMatrix::zeros(0, 0));
            let mut noise = Noise { memory: Some(memory), determinant, ..same };
            // Memory takes over part of what drift and structure error described.
            let sizes = [0.0, hyper.1 / APART, hyper.1, hyper.1 * APART];
            for drift in self.drifts() {
                noise.states.push(self.state(&noise, &ztr, *drift, hyper.1)?);
            }
            let drift = noise.fitting().drift;
            for size in sizes.into_iter().filter(|size| *size != hyper.1) {
                noise.states.push(self.state(&noise, &ztr, drift, size)?);
            }
            let best = noise.fitting();
            if found.as_ref().is_some_and(|known| known.fitting().cost <= best.cost) {
                break;
            }
            (left, used, hyper) = (white.left(&best.c), self.used(best)?, (best.drift, best.size));
            found = Some(noise);
        }
        self.noises.extend(found);
        Some(())
    }

    /// Keeps only the states that cannot be distinguished from the best one, and the one without drift and structure error.
    pub fn settle(&mut self) {
        let most = self.fitting().cost + NEAR;
        for (n, noise) in self.noises.iter_mut().enumerate() {
            let mut k = 0;
            noise.states.retain(|state| {
                k += 1;
                (n, k) == (0, 1) || state.cost <= most
            });
        }
        self.noises.retain(|noise| !noise.states.is_empty());
    }

    /// Releases all memory except the cost.
    pub fn release(&mut self) {
        self.settle();
        for noise in &mut self.noises {
            (noise.z, noise.ztz) = (DMatrix::zeros(0, 0), DMatrix::zeros(0, 0));
            noise.states.iter_mut().for_each(|state| drop(state.inverse.take()));
        }
    }

    /// The null model for given noise, drift and size of the structure error.
    fn state(&self, noise: &Noise, ztr: &DVector<f64>, drift: (f64, f64), size: f64) -> Option<State> {
        let p = self.prior.count();
        let (l, prior_determinant) = self.precision(noise.z.ncols(), drift, size)?;
        let mut rhs = ztr.clone();
        let mut own = rhs.rows_mut(0, p);
        own -= &self.prior.pull;
        let whole = &noise.ztz + &l;
        let coefficients = noise.z.ncols() - p;
        let inner = whole.view((p, p), (coefficients, coefficients)).into_owned();
        let determinant = noise.determinant + prior_determinant + log_determinant(&cholesky(inner)?);
        let factor = cholesky(whole)?;
        let c = factor.solve(&rhs);
        let cost = noise.r.norm_squared() + self.prior.cost - rhs.dot(&c) + determinant;
        Some(State { factor, inverse: OnceLock::new(), c, cost, drift, size })
    }

    /// L for given drift and size of the structure error, for `all` columns, and minus the log determinant of the part of drift and
    /// structure error.
    fn precision(&self, all: usize, drift: (f64, f64), size: f64) -> Option<(DMatrix<f64>, f64)> {
        let (p, d) = (self.prior.count(), self.drift.count);
        let mut l = DMatrix::zeros(all, all);
        l.view_mut((0, 0), (p, p)).copy_from(&self.prior.precision);
        let mut determinant = 0.0;
        if drift.0 > 0.0 {
            let (inverse, own) = self.drift.precision(drift)?;
            l.view_mut((p, p), (d, d)).copy_from(&inverse);
            determinant += own;
        }
        for k in p..all {
            if if k < p + d { drift.0 == 0.0 } else { size == 0.0 } {
                l[(k, k)] = ABSENT;
                determinant -= ABSENT.ln();
            } else if k >= p + d {
                l[(k, k)] = 1.0 / (size * size);
                determinant += 2.0 * size.ln();
            }
        }
        Some((l, determinant))
    }

    /// Number of coefficients that the data determine in a state: gamma of `evidence/memory.rs`.
    fn used(&self, state: &State) -> Option<f64> {
        let all = state.c.len();
        let (l, _) = self.precision(all, state.drift, state.size)?;
        Some(all as f64 - state.factor.solve(&l).trace())
    }

    /// The state with the lowest cost.
    fn fitting(&self) -> &State {
        let (noise, state) = self.best_state();
        &self.noises[noise].states[state]
    }

    /// Indices of its noise and of the state itself.
    fn best_state(&self) -> (usize, usize) {
        let all = self.noises.iter().enumerate();
        let all = all.flat_map(|(n, noise)| (0..noise.states.len()).map(move |k| (n, k)));
        let cost = |(n, k): &(usize, usize)| self.noises[*n].states[*k].cost;
        all.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or((0, 0))
    }

    /// Variance of the mean of many readings of an output relative to that of white noise of the stated size.
    pub fn inflation(&self, output: usize) -> f64 {
        let memory = &self.noises[self.best_state().0].memory;
        memory.as_ref().map_or(1.0, |memory| memory.inflation(output))
    }

    /// Best size of the structure error, in units of the noise.
    pub fn structure(&self) -> f64 {
        self.fitting().size
    }

    /// Number of values in the residual.
    pub fn values(&self) -> usize {
        self.noises[0].r.len()
    }

    /// Best drift of the null model: ratio of its standard deviation to that of the noise, and correlation time, s.
    pub fn drift(&self) -> (f64, f64) {
        let best = self.fitting();
        best.drift
    }

    /// Mean square of the residual with the best drift, after further columns if given; 1 for noise.
    pub fn misfit(&self, beside: Option<(&DMatrix<f64>, &Gain)>) -> f64 {
        let left = match beside {
            None => {
                let (noise, state) = self.best_state();
                let noise = &self.noises[noise];
                noise.left(&noise.states[state].c).norm_squared()
            }
            Some((s, gain)) => {
                let (noise, state) =
                    (&self.noises[gain.state.0], &self.noises[gain.state.0].states[gain.state.1]);
                let s = noise.whitened(&self.series, s);
                let lent = state.factor.solve(&noise.z.tr_mul(&s));
                (noise.left(&state.c) - (s - &noise.z * lent) * &gain.size).norm_squared()
            }
        };
        left / self.noises[0].r.len() as f64
    }

    /// Eq. (2) with the best hyperparameters, and without drift and structure error.
    pub fn cost(&self) -> (f64, f64) {
        (self.fitting().cost, self.noises[0].states[0].cost)
    }

    /// First-order corrections of the parameters and their covariance, in units of their prior deviations, with the best hyperparameters;
    /// estimated jointly with further columns if given. A variance is the greatest of those with hyperparameters that cannot be
    /// distinguished from the best ones.
    pub fn estimate(
        &self,
        parameters: usize,
        beside: Option<(&DMatrix<f64>, &Gain)>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let place = beside.map_or_else(|| self.best_state(), |(_, gain)| gain.state);
        let noise = &self.noises[place.0];
        let best = &noise.states[place.1];
        let mut c = best.c.clone();
        let mut covariance = best.factor.inverse();
        if let Some((s, gain)) = beside {
            let lent = best.factor.solve(&noise.z.tr_mul(&noise.whitened(&self.series, s)));
            c -= &lent * &gain.size;
            covariance += &lent * &gain.covariance * lent.transpose();
        }
        let mut view = covariance.view((0, 0), (parameters, parameters)).into_owned();
        let near = |state: &&State| beside.is_none() && state.cost <= best.cost + NEAR;
        for other in self.noises.iter().flat_map(|noise| &noise.states).filter(near) {
            let variances = other.factor.inverse();
            for k in 0..parameters {
                let wider = (variances[(k, k)] / view[(k, k)]).sqrt().max(1.0);
                view.row_mut(k).scale_mut(wider);
                view.column_mut(k).scale_mut(wider);
            }
        }
        (c.rows(0, parameters).iter().copied().collect(), view)
    }

    /// Eq. (4): columns of one smooth shape, with the prior covariance `kernel` of their coefficients.
    pub fn shape(&self, s: &DMatrix<f64>, kernel: &DMatrix<f64>) -> Option<Gain> {
        self.shapes(s, kernel).pop()?
    }

    /// Eq. (4) for each of several shapes with the same `kernel`, whose columns are side by side.
    pub fn shapes(&self, s: &DMatrix<f64>, kernel: &DMatrix<f64>) -> Vec<Option<Gain>> {
        let Some(factor) = kernel.clone().cholesky() else { return Vec::new() };
        let (inverse, prior) = (factor.inverse(), log_determinant(&factor));
        self.explain(s, kernel.nrows(), |_, power, seen| {
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
