//! Agreement of a clock offset between runs, and its comparison with a lag of the response to an input.
//!
//! C_r(d) = sum_k n ln S_kr(d)                                                                      (1)
//! T = min_d sum_r C_r(d) - sum_r min_d C_r(d)                                                      (2)
//!
//! S_kr(d) mean square of the residual of output k in run r with the channel shifted by d, at its minimum over the declared parameters
//! in this run alone; n its number of independent readings. A clock offset is the same in all runs: then (2), twice the logarithm of
//! the likelihood ratio of separate offsets against a common one, is chi-square with one degree of freedom less than there are runs.
//! A missing effect has another best offset in each run, since it depends on their course. A single run is cut into halves.
//!
//! An input that is early can also be one to which the response is delayed by a missing state, so a first-order lag of this input must
//! explain the data less.
//!
//! *Source*: likelihood ratio of nested models with unknown variance: Seber and Wild, Nonlinear Regression (1989), ch. 2.2 and 5.9.

use super::profile::{About, lagging};
use super::{LAGS, Who, with_moved};
use crate::experiment::Experiment;
use crate::hypothesis::Hypothesis;
use crate::levels::SAMPLES;
use crate::numbers::interval;
use crate::parallel;
use crate::selection::LEAST as VERY_STRONG;
use crate::setup::Setup;
use crate::simulate::Drive;

/// Shifts on either side of the estimate, evenly from zero to twice the estimate. Numerical: the cost is nearly quadratic over a step.
const AROUND: i32 = 20;
/// Quantile of the standard normal distribution beyond which offsets differ between runs. Definition: one-sided probability of 1e-3, the
/// false-alarm probability of a shift.
const DIFFERENT: f64 = 3.09;
/// Variance of the cube root of chi-square over its mean, times the degrees of freedom. Source: E. B. Wilson, M. M. Hilferty, PNAS 17
/// (1931) 684-688.
const CUBE_ROOT: f64 = 2.0 / 9.0;

/// A shift of a channel at a fit.
pub struct Fit<'a> {
    /// The data as they are.
    pub setup: &'a Setup<'a>,
    /// The data with the channel shifted.
    pub changed: &'a Setup<'a>,
    /// The fit to the shifted data.
    pub fitted: &'a Hypothesis,
    /// Variance of the noise, output by output.
    pub noise: &'a [f64],
    /// The channel.
    pub who: Who,
    /// Its delay, s.
    pub late: f64,
}

/// A run, or a half of it.
struct Part {
    run: usize,
    about: About,
    /// Independent readings of an output.
    samples: f64,
    /// Time between rows, s: the resolution of a shift.
    row: f64,
}

impl Fit<'_> {
    /// Whether the shift is the same in these runs and no lag of an input explains them; `None` if that could not be computed.
    pub fn holds(&self, runs: &[usize]) -> Option<bool> {
        let parts = self.parts(runs);
        let steps = f64::from(AROUND);
        let shifts: Vec<f64> = (-AROUND..=AROUND).map(|k| self.late * (1.0 + f64::from(k) / steps)).collect();
        let all: Option<Vec<Vec<f64>>> = parts.iter().map(|part| self.costs(part, &shifts)).collect();
        let all = all?;
        let least = |costs: &[f64]| costs.iter().copied().fold(f64::INFINITY, f64::min);
        // A common shift is not known to less than a row.
        let near = |part: &Part, costs: &[f64], shift: f64| {
            let own = shifts.iter().zip(costs).filter(|(d, _)| (*d - shift).abs() <= part.row);
            own.map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min)
        };
        let sum = |shift: &f64| parts.iter().zip(&all).map(|(p, costs)| near(p, costs, *shift)).sum();
        let common = least(&shifts.iter().map(sum).collect::<Vec<f64>>());
        let separate: f64 = all.iter().map(|costs| least(costs)).sum();
        let agree = parts.len() < 2 || common - separate <= quantile(parts.len() - 1);
        Some(agree && self.beats_lags(&parts, common)?)
    }

    /// Whether every lag of an early input explains the data less than the shift with this cost.
    fn beats_lags(&self, parts: &[Part], common: f64) -> Option<bool> {
        let Who::Input(k) = self.who else { return Some(true) };
        if self.late > 0.0 {
            return Some(true);
        }
        let lags: Vec<i32> = (0..LAGS.2).collect();
        let cost = |n: &i32| -> Option<f64> {
            let tau = LAGS.0 * self.late.abs() * LAGS.1.powi(*n);
            let mut changed = self.setup.experiment.clone();
            for table in changed.runs.iter_mut().map(|r| &mut r.table) {
                table.columns[k] = lagging(table, k, tau);
            }
            parts.iter().map(|part| self.simulated(part, &changed)).sum()
        };
        let costs: Option<Vec<f64>> = parallel::map(&lags, cost).into_iter().collect();
        Some(costs?.iter().all(|lagged| *lagged > common + VERY_STRONG))
    }

    /// The runs in which most rows are known at all shifts that are compared.
    fn parts(&self, runs: &[usize]) -> Vec<Part> {
        let halves = if runs.len() == 1 { 2 } else { 1 };
        let all = runs.iter().flat_map(|run| (0..halves).map(move |half| (*run, half)));
        all.filter_map(|(run, half)| self.part(run, half, halves)).collect()
    }

    fn part(&self, run: usize, half: usize, halves: usize) -> Option<Part> {
        let (experiment, of_input) = (self.setup.experiment, matches!(self.who, Who::Input(_)));
        let own = &experiment.runs[run];
        let time = &own.table.time;
        let (from, to) = own.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let (from, to) = (from.max(time[0]), to.min(time[time.len() - 1]));
        // The rows are the same at every shift: a late input is unknown at the end of the run, a late output has no prediction at its
        // start.
        let most = 2.0 * self.late.abs();
        let is_end = (self.late > 0.0) == of_input;
        let known = if is_end { (from, to - most) } else { (from + most, to) };
        if 2.0 * (known.1 - known.0) < to - from {
            return None;
        }
        let length = (known.1 - known.0) / halves as f64;
        let from = known.0 + half as f64 * length;
        let about = About::new(if of_input { self.changed } else { self.setup }, self.fitted, &[run]).ok()?;
        let samples = SAMPLES / halves as f64;
        Some(Part { run, about: about.within(from, from + length), samples, row: interval([&time[..]]) })
    }

    /// (1) at each shift.
    fn costs(&self, part: &Part, shifts: &[f64]) -> Option<Vec<f64>> {
        let outputs: Vec<usize> = match self.who {
            Who::Output(k) => vec![k],
            _ => (0..self.setup.outputs()).collect(),
        };
        let one = |late: &f64| match self.who {
            Who::Input(_) => self.simulated(part, &with_moved(self.setup.experiment, self.who, *late)),
            _ => Some(outputs.iter().map(|k| self.cost(part, *k, part.about.late(*k, *late))).sum()),
        };
        parallel::map(shifts, one).into_iter().collect()
    }

    /// (1) with the inputs of another experiment.
    fn simulated(&self, part: &Part, changed: &Experiment) -> Option<f64> {
        let drive = Drive::new(changed, &changed.runs[part.run]).ok()?;
        let shown = self.setup.bench.run(&drive, &self.setup.change(self.fitted, part.run)).ok()?;
        let shown = [shown];
        let outputs = 0..self.setup.outputs();
        let square = |k: usize| part.about.with(k).map(|square| square(&shown));
        Some(outputs.map(|k| self.cost(part, k, square(k))).sum())
    }

    /// A term of (1); nothing for an output without readings.
    fn cost(&self, part: &Part, output: usize, square: Option<(f64, usize)>) -> f64 {
        let of = |(square, count): (f64, usize)| {
            part.samples.min(count as f64) * square.max(self.noise[output]).ln()
        };
        square.map_or(0.0, of)
    }
}

/// Quantile of chi-square: its cube root is nearly normal.
fn quantile(freedom: usize) -> f64 {
    let (n, spread) = (freedom as f64, CUBE_ROOT / freedom as f64);
    n * (1.0 - spread + DIFFERENT * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::quantile;

    /// Abramowitz and Stegun, table 26.8, probability 0.001.
    #[test]
    fn quantiles_of_chi_square() {
        for (freedom, expected) in [(1, 10.828), (2, 13.816), (3, 16.266), (5, 20.515)] {
            assert!((quantile(freedom) / expected - 1.0).abs() < 0.04, "{freedom}: {}", quantile(freedom));
        }
    }
}
