//! Estimation of the parameters of a hypothesis: bounded least squares with priors.
//!
//! minimise  sum_k [(y_k - y(t_k; p)) / sigma]^2 + sum_j [(p_j - p_j0) / s_j]^2 + sum_t v_t' P_t v_t          (1)
//!
//! The first sum includes all evaluated rows of the fitted runs. p_j0 is the preset's value and s_j the standard deviation of its prior.
//! v_t are the values of a table and P_t the inverse of their prior covariance, that of a smooth law ([`crate::search`]); other parameters of
//! an addition have no prior. A parameter with a wide prior ([`WIDE`]) can be wrong by a factor. The first fit therefore uses several starts
//! and the logarithms of such parameters, so that it converges from any start, and then the parameters themselves. Sensitivities come from the
//! linearised model ([`crate::tangent`]) and are reused for several steps: near the optimum they hardly change, and a step then costs one
//! simulation.
//! *Source*: Bates, Watts, Nonlinear Regression Analysis (1988), ch. 2 and 3; priors as in PEtab.

mod starts;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::hypothesis::{Hypothesis, Shape};
use crate::parallel;
use crate::setup::{Declared, Setup, Shown, WIDE};
use crate::tangent::{Direction, Probe, Tangent};
use least_squares::{Options, Problem, minimise};
use nalgebra::{DMatrix, DVector};
use physics::terms::Port;

/// Options of a fit near the optimum. Numerical: a step that reduces (1) by less than `decrease` is the last; strong evidence is 60
/// times as much. Steps with the same slopes correct for the curvature there.
const OPTIONS: Options = Options {
    damping: 1e-6,
    linearisations: 6,
    chords: 5,
    relative_decrease: 0.0,
    decrease: 0.1,
    step: 1e-9,
    gradient: 1e-9,
    curved: false,
    rival: f64::INFINITY,
};

/// Options for a start far from the optimum. Numerical: more iterations, and damping as the linearization is poor.
const FAR: Options = Options { damping: 1e-2, linearisations: 40, curved: true, ..OPTIONS };
/// Perturbation of a parameter for its sensitivity, relative to its value or deviation. Numerical: half of the digits remain in the
/// difference.
const WAY: f64 = 1e-4;
/// Changes of a parameter within which its sensitivities are reused: logarithm or relative value, and prior deviations. Numerical: they
/// are updated if a step with them does not reduce the cost.
const REUSED: (f64, f64) = (0.05, 0.3);

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The hypothesis with its estimated parameters.
    pub hypothesis: Hypothesis,
    /// Predicted outputs in the fitted runs.
    pub shown: Vec<Shown>,
    /// Sum of squared residuals over the readings, in units of the noise.
    pub chi_square: f64,
    /// Eq. (1).
    pub cost: f64,
    /// Number of readings.
    pub readings: usize,
}

/// Sensitivities of a hypothesis along runs.
pub struct Slopes {
    /// One linearization for each run.
    pub tangents: Vec<Tangent>,
    /// Source of each sensitivity: a probe, and for additions the indices of addition and parameter that give its shape over time.
    leads: Vec<(usize, Option<(usize, usize)>)>,
    /// The runs in which a parameter acts; `None` for all runs.
    acts: Vec<Option<Vec<usize>>>,
    /// The runs.
    pub runs: Vec<usize>,
}

impl Slopes {
    /// Linearises a hypothesis along runs, with further probes last among the directions.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn new(
        setup: &Setup,
        hypothesis: &Hypothesis,
        runs: &[usize],
        further: &[Probe],
    ) -> Result<Slopes, CalibrateError> {
        let mut probes: Vec<Probe> = Vec::new();
        let mut leads = Vec::new();
        for (d, value) in setup.declared.iter().zip(&hypothesis.declared) {
            leads.push((probes.len(), None));
            let mut way = WAY * value.abs().max(d.deviation);
            if value + way > d.limits.1 {
                way = -way;
            }
            probes.push(Probe::Parameter { slot: d.slot, with: Vec::new(), way });
        }
        let mut ports: Vec<(Port, usize)> = Vec::new();
        for (a, addition) in hypothesis.additions.iter().enumerate() {
            for (n, number) in addition.numbers.iter().enumerate().filter(|(_, n)| n.sloped) {
                if let Shape::Listed { slots, with, .. } = &addition.shape {
                    leads.push((probes.len(), Some((a, n))));
                    let mut way = WAY * number.value.abs().max(number.scale);
                    if number.value + way > number.limits.1 {
                        way = -way;
                    }
                    probes.push(Probe::Parameter { slot: slots[n], with: with.clone(), way });
                } else {
                    let known = ports.iter().find(|(port, _)| *port == addition.port).map(|(_, k)| *k);
                    let k = known.unwrap_or_else(|| {
                        ports.push((addition.port, probes.len()));
                        probes.push(Probe::Port(addition.port));
                        probes.len() - 1
                    });
                    leads.push((k, Some((a, n))));
                }
            }
        }
        probes.extend(further.iter().cloned());
        let tangents = parallel::map(runs, |&run| {
            Tangent::new(&setup.bench, &setup.smooth[run], &setup.change(hypothesis, run), &probes)
        });
        let tangents = tangents.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut acts: Vec<Option<Vec<usize>>> = setup.declared.iter().map(|d| d.runs.clone()).collect();
        acts.resize(leads.len(), None);
        Ok(Slopes { tangents, leads, acts, runs: runs.to_vec() })
    }

    /// Appends those of the same hypothesis and probes along other runs.
    pub fn extend(&mut self, other: Slopes) {
        self.tangents.extend(other.tangents);
        self.runs.extend(other.runs);
    }

    /// Keeps those of the first `count` runs.
    pub fn truncate(&mut self, count: usize) {
        self.tangents.truncate(count);
        self.runs.truncate(count);
    }

    /// Directions of the last `count` probes of a run.
    pub fn further(&self, run: usize, count: usize) -> &[Option<Direction>] {
        let all = &self.tangents[run].directions;
        &all[all.len() - count..]
    }

    /// Sensitivity of the outputs of the `r`-th run to the `k`-th parameter, rows times outputs; `None` if zero.
    pub fn answer(&self, hypothesis: &Hypothesis, r: usize, k: usize) -> Option<Vec<f64>> {
        if self.acts[k].as_ref().is_some_and(|runs| !runs.contains(&self.runs[r])) {
            return None;
        }
        let tangent = &self.tangents[r];
        let (probe, shape) = self.leads[k];
        let direction = tangent.directions[probe].as_ref()?;
        match shape {
            None => Some(tangent.response(direction, |_| 1.0)),
            Some((a, n)) => {
                let addition = &hypothesis.additions[a];
                addition.active[self.runs[r]].then(|| {
                    let place = hypothesis.place(a, self.runs[r]);
                    let above = place.map_or(0.0, |place| tangent.lag_starts_above(place));
                    let slopes = addition.slopes(n, &tangent.time, &tangent.drivers, above);
                    tangent.response(direction, |row| slopes[row])
                })
            }
        }
    }

    /// Whether another hypothesis changes the model in any of the runs ([`Tangent::is_moved_by`]); true if that is no longer known.
    pub fn are_moved_by(&self, setup: &Setup, other: &Hypothesis) -> bool {
        let is_moved = |(&run, tangent): (&usize, &Tangent)| {
            tangent.is_moved_by(&setup.bench, &setup.smooth[run], &setup.change(other, run))
        };
        self.tangents.is_empty() || self.runs.iter().zip(&self.tangents).any(is_moved)
    }

    /// Number of parameters.
    pub fn count(&self) -> usize {
        self.leads.len()
    }
}

impl Setup<'_> {
    /// Scales and limits of the fitted parameters, and the priors of the declared ones.
    pub fn scales(&self, hypothesis: &Hypothesis) -> Vec<(f64, (f64, f64), Option<f64>)> {
        let declared = self.declared.iter().map(|d| (d.deviation, d.limits, (!d.is_free).then_some(d.prior)));
        let added = hypothesis.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
        declared.chain(added.map(|n| (n.scale, n.limits, None))).collect()
    }

    /// Evaluates a hypothesis on runs without a fit.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn judged(&self, hypothesis: Hypothesis, runs: &[usize]) -> Result<Fitted, CalibrateError> {
        let shown = self.show(&hypothesis, runs)?;
        let (chi_square, readings) = self.chi_square(runs, &shown);
        let prior: f64 = self
            .declared
            .iter()
            .zip(&hypothesis.declared)
            .filter(|(d, _)| !d.is_free)
            .map(|(d, value)| ((value - d.prior) / d.deviation).powi(2))
            .sum();
        let laws: f64 =
            hypothesis.priors().iter().map(|(_, values, precision)| values.dot(&(*precision * values))).sum();
        Ok(Fitted { hypothesis, shown, chi_square, cost: chi_square + prior + laws, readings })
    }

    /// Fits the parameters of a hypothesis to runs, starting from their current values.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn fit(&self, start: Hypothesis, runs: &[usize]) -> Result<Fitted, CalibrateError> {
        self.fit_with(start, runs, false, &OPTIONS)
    }

    /// The fit from a start; parameters with wide priors are fitted as logarithms if `logarithms`.
    fn fit_with(
        &self,
        start: Hypothesis,
        runs: &[usize],
        logarithms: bool,
        options: &Options,
    ) -> Result<Fitted, CalibrateError> {
        let scales = self.scaled(&start, logarithms);
        self.fit_scaled(start, runs, scales, options)
    }

    /// The fit with these transformations and limits.
    fn fit_scaled(
        &self,
        start: Hypothesis,
        runs: &[usize],
        scales: Vec<Scale>,
        options: &Options,
    ) -> Result<Fitted, CalibrateError> {
        let limits: Vec<(f64, f64)> =
            scales.iter().map(|s| (s.variable(s.limits.0), s.variable(s.limits.1))).collect();
        let numbers = start.numbers();
        let x =
            DVector::from_iterator(scales.len(), numbers.iter().zip(&scales).map(|(p, s)| s.variable(*p)));
        Ok(minimise(&Fit { setup: self, start: &start, runs, scales }, x, &limits, options)?.point)
    }

    /// Transformation of the parameters to the variables of the fit.
    fn scaled(&self, hypothesis: &Hypothesis, logarithms: bool) -> Vec<Scale> {
        let is_wide = |k: usize| logarithms && self.declared.get(k).is_some_and(is_wide);
        let scales = self.scales(hypothesis).into_iter().enumerate();
        scales.map(|(k, (unit, limits, prior))| Scale { unit, limits, prior, is_log: is_wide(k) }).collect()
    }

    /// The fit from a start far from the optimum. Parameters with wide priors are fitted as logarithms first, and then directly, because a
    /// limit at zero has no logarithm.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn settled(&self, start: Hypothesis, runs: &[usize]) -> Result<Fitted, CalibrateError> {
        self.settled_against(f64::INFINITY, start, runs)
    }

    /// The same, ended early where it promises no cost below that of a rival.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn settled_against(
        &self,
        rival: f64,
        start: Hypothesis,
        runs: &[usize],
    ) -> Result<Fitted, CalibrateError> {
        let options = Options { rival, ..FAR };
        let far = self.fit_with(start, runs, true, &options)?;
        self.fit_with(far.hypothesis, runs, false, &options)
    }

    /// Fisher information of each output about the parameters of a fitted hypothesis, in units of their scales.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn informations(&self, fitted: &Fitted, runs: &[usize]) -> Result<Vec<DMatrix<f64>>, CalibrateError> {
        let fit = Fit {
            setup: self,
            start: &fitted.hypothesis,
            runs,
            scales: self.scaled(&fitted.hypothesis, false),
        };
        Ok(fit.informations(fitted, &fit.columns(fitted)?))
    }
}

/// Whether a parameter can be wrong by a factor.
pub fn is_wide(declared: &Declared) -> bool {
    declared.prior > 0.0 && declared.limits.0 >= 0.0 && declared.deviation > WIDE * declared.prior
}

/// Transformation of a parameter to a variable of the fit: the value in units of its scale, or its logarithm.
struct Scale {
    unit: f64,
    limits: (f64, f64),
    prior: Option<f64>,
    is_log: bool,
}

impl Scale {
    /// Smallest argument of the logarithm. Numerical: rounding of a value of the order of its scale.
    const LEAST: f64 = 1e-12;

    fn variable(&self, number: f64) -> f64 {
        let x = number / self.unit;
        if self.is_log { x.max(Self::LEAST).ln() } else { x }
    }

    fn number(&self, x: f64) -> f64 {
        // Rounding in the back-transformation must not violate a limit.
        (self.unit * if self.is_log { x.exp() } else { x }).clamp(self.limits.0, self.limits.1)
    }

    /// Derivative of the scaled parameter with respect to the variable.
    fn slope(&self, number: f64) -> f64 {
        if self.is_log { number / self.unit } else { 1.0 }
    }
}

/// The least-squares problem of a hypothesis. The variables are its scaled parameters.
struct Fit<'a> {
    setup: &'a Setup<'a>,
    start: &'a Hypothesis,
    runs: &'a [usize],
    scales: Vec<Scale>,
}

/// Sensitivities to the scaled parameters of the readings of each output, in units of the noise: a column for each reading.
type Columns = Vec<DMatrix<f64>>;

impl Fit<'_> {
    /// The sensitivities of a fitted hypothesis.
    fn columns(&self, fitted: &Fitted) -> Result<Columns, CalibrateError> {
        let slopes = Slopes::new(self.setup, &fitted.hypothesis, self.runs, &[])?;
        let of_run = |r: usize| -> Vec<Option<Vec<f64>>> {
            (0..slopes.count()).map(|k| slopes.answer(&fitted.hypothesis, r, k)).collect()
        };
        let answers = parallel::indices(self.runs.len(), of_run);
        let (m, p) = (self.setup.outputs(), self.scales.len());
        let mut all = vec![Vec::new(); m];
        for ((run, shown), answers) in self.runs.iter().zip(&fitted.shown).zip(&answers) {
            self.setup.each(*run, shown, |row, output, _| {
                let sigma = self.setup.noise_of_reading(*run, row, output);
                let of = |(answer, scale): (&Option<Vec<f64>>, &Scale)| {
                    answer.as_ref().map_or(0.0, |values| values[row * m + output] * scale.unit / sigma)
                };
                all[output].extend(answers.iter().zip(&self.scales).map(of));
            });
        }
        Ok(all.into_iter().map(|own| DMatrix::from_vec(p, own.len() / p.max(1), own)).collect())
    }

    /// Derivatives of the scaled parameters with respect to the variables.
    fn slopes(&self, fitted: &Fitted) -> DVector<f64> {
        let numbers = fitted.hypothesis.numbers();
        DVector::from_iterator(numbers.len(), self.scales.iter().zip(&numbers).map(|(s, p)| s.slope(*p)))
    }

    /// Fisher information of each output about the variables.
    fn informations(&self, fitted: &Fitted, columns: &Columns) -> Vec<DMatrix<f64>> {
        let slopes = self.slopes(fitted);
        let scales = &slopes * slopes.transpose();
        columns.iter().map(|own| (own * own.transpose()).component_mul(&scales)).collect()
    }
}

impl Problem for Fit<'_> {
    type Point = Fitted;
    type Slopes = (Columns, DMatrix<f64>);
    type Error = CalibrateError;

    fn evaluate(&self, x: &DVector<f64>) -> Result<Fitted, CalibrateError> {
        let mut hypothesis = self.start.clone();
        hypothesis.take(&x.iter().zip(&self.scales).map(|(x, s)| s.number(*x)).collect::<Vec<_>>());
        self.setup.judged(hypothesis, self.runs)
    }

    fn cost(&self, fitted: &Fitted) -> f64 {
        fitted.cost
    }

    fn linearise(&self, _: &DVector<f64>, fitted: &Fitted) -> Result<Self::Slopes, CalibrateError> {
        let columns = self.columns(fitted)?;
        let mut information: DMatrix<f64> = self.informations(fitted, &columns).iter().sum();
        let numbers = fitted.hypothesis.numbers();
        for (k, scale) in self.scales.iter().enumerate().filter(|(_, s)| s.prior.is_some()) {
            information[(k, k)] += scale.slope(numbers[k]).powi(2);
        }
        for (place, values, precision) in fitted.hypothesis.priors() {
            for (a, b) in (0..values.len()).flat_map(|a| (0..values.len()).map(move |b| (a, b))) {
                information[(place + a, place + b)] +=
                    precision[(a, b)] * self.scales[place + a].unit * self.scales[place + b].unit;
            }
        }
        Ok((columns, information))
    }

    fn information(&self, slopes: &Self::Slopes) -> DMatrix<f64> {
        slopes.1.clone()
    }

    fn gradient(&self, x: &DVector<f64>, fitted: &Fitted, slopes: &Self::Slopes) -> DVector<f64> {
        let mut residuals = vec![Vec::new(); self.setup.outputs()];
        for (run, shown) in self.runs.iter().zip(&fitted.shown) {
            self.setup.each(*run, shown, |row, output, off| {
                residuals[output].push(-off / self.setup.noise_of_reading(*run, row, output));
            });
        }
        let mut gradient = DVector::zeros(x.len());
        for (own, residual) in slopes.0.iter().zip(residuals) {
            gradient.gemv(1.0, own, &DVector::from_vec(residual), 1.0);
        }
        gradient.component_mul_assign(&self.slopes(fitted));
        for (k, (scale, number)) in self.scales.iter().zip(fitted.hypothesis.numbers()).enumerate() {
            let off = scale.prior.map_or(0.0, |prior| (number - prior) / scale.unit);
            gradient[k] += off * scale.slope(number);
        }
        for (place, values, precision) in fitted.hypothesis.priors() {
            for (k, pull) in (precision * values).iter().enumerate() {
                gradient[place + k] += pull * self.scales[place + k].unit;
            }
        }
        gradient
    }

    fn stop(&self) -> bool {
        self.setup.deadline().is_near()
    }

    /// Whether the sensitivities at `from` are still valid: see [`REUSED`].
    fn is_near(&self, from: &DVector<f64>, x: &DVector<f64>) -> bool {
        self.scales.iter().enumerate().all(|(k, scale)| {
            let near = if scale.is_log {
                REUSED.0
            } else if scale.prior.is_some() {
                REUSED.1
            } else {
                REUSED.0 * from[k].abs().max(1.0)
            };
            (x[k] - from[k]).abs() <= near
        })
    }
}
