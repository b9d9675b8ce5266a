//! Clock offsets (delays or advances) of single channels, estimated against the response of the model.
//!
//! y(t) = p(t - d) + J(t - d) delta + e                                                             (1)
//! G(d) = n ln(S(0) / S(d))                                                                         (2)
//!
//! y readings of an output, p prediction of a fit, J its sensitivities to the declared parameters, delta limited by their priors,
//! S(d) the mean square of e at its minimum over delta, n the number of independent readings: (2) is twice the logarithm of the likelihood
//! ratio with unknown variance. For an input, its column is shifted and simulated. (1) is linearised about the fit of the data as they are
//! and about the preset, since a fit can absorb a delay in a heat capacity. The best shifts are confirmed by a fit with the column
//! shifted. The remaining mean square must be small, in the validation runs as well, and smaller than with a first-order lag of the same
//! sensor: a sensor lag is not a clock error, and is searched for as an effect. A shift of an input must leave a small mean square in one
//! output, and predict the validation runs better in all outputs together. A delay of all outputs together is an advance of the inputs.
//! The shift must be the same in every run, and a lag of the response to an input must not explain the data as well ([`agreement`]).
//!
//! *Sources*: (2) with unknown variance: Seber and Wild, Nonlinear Regression (1989), ch. 2.2; time delay as a parameter: Ljung, System
//! Identification (2nd ed., 1999), ch. 10.

mod agreement;
mod profile;

use super::consistency::thinned;
use super::{Unusable, all_runs, mean_square, structured};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role, Table};
use crate::fit::Fitted;
use crate::hypothesis::Hypothesis;
use crate::levels::{AT_NOISE, FACTOR, SAMPLES, SMALL, STRUCTURE, SURE};
use crate::noise;
use crate::numbers;
use crate::parallel;
use crate::selection::LEAST as VERY_STRONG;
use crate::setup::Setup;
use crate::simulate::Drive;
use profile::{About, moved};

/// Rows of a run that are compared; each is the mean over a constant number of readings. Numerical: the shift is estimated between
/// rows.
const ROWS: usize = 1500;
/// Least value of (2) at which a shift is confirmed or accepted. Derivation: the normal tail exp(-37 / 2) times 1e5, the readings by
/// which columns can be shifted, is a false-alarm probability of 1e-3.
pub(super) const LEAST: f64 = 37.0;
/// Ratio of successive shifts that are tried, for outputs and for inputs. Numerical: the best ones are refined.
const RATIO: (f64, f64) = (1.25, 1.6);
/// The greatest shift as a fraction of a run. Limit: a greater one leaves too few common rows.
const FARTHEST: f64 = 0.2;
/// Number of shifts that are confirmed by a fit. Numerical: a limit of effort; the best are tried first.
const CONFIRMED: usize = 3;
/// Number of the best shifts that are refined. Numerical: a limit of effort.
const STARTS: usize = 3;
/// Smallest step of the refinement, relative to the shift. Numerical: resolution of a start.
const FINE: f64 = 0.01;
/// Steps of half of a shift in its estimate. Numerical: resolution of the estimate.
const STEPS: i32 = 40;
/// Shortest time constant of a sensor relative to the shift, ratio of successive ones, and their number. Numerical: from 0.2 to 3.6
/// times the shift.
const LAGS: (f64, f64, i32) = (0.2, 1.3, 12);

/// Channel with the clock offset.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Who {
    Output(usize),
    Input(usize),
    Outputs,
}

/// Delay of a clock in seconds, with its 95 % interval; negative for an advance.
#[derive(Clone, Copy, Debug)]
struct Shift {
    who: Who,
    late: f64,
    interval: (f64, f64),
    gain: f64,
}

impl Shift {
    /// A shift without gain.
    fn new(who: Who, late: f64) -> Shift {
        Shift { who, late, interval: (late, late), gain: 0.0 }
    }
}

/// Sets aside outputs with a clock offset, with notes. If inputs have one, the data are unusable.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn check(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Unusable>, CalibrateError> {
    in_runs(experiment, &all_runs(experiment), preset, deadline)
}

/// The same for a clock that has an offset in these runs: without the others, all of them are fitted.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn in_runs(
    experiment: &mut Experiment,
    runs: &[usize],
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Unusable>, CalibrateError> {
    let is_whole = runs.len() == experiment.runs.len();
    let files: Vec<&str> = runs.iter().map(|run| experiment.runs[*run].file.as_str()).collect();
    let files = files.join(", ");
    let place = if is_whole { String::new() } else { format!(" in {files}") };
    for _ in 0..experiment.outputs.len() {
        let mut own = experiment.clone();
        own.runs = runs.iter().map(|run| experiment.runs[*run].clone()).collect();
        if !is_whole {
            own.runs.iter_mut().for_each(|run| run.role = Role::Fit);
        }
        let thin = thinned(&own, ROWS);
        let Some(shift) = search(&thin, interval(&own), preset, deadline)? else { return Ok(None) };
        let words = |column: &str| {
            let side = if shift.late > 0.0 { "late" } else { "early" };
            let (a, b) = (shift.interval.0.abs(), shift.interval.1.abs());
            format!(
                "{column} is {:.3} s {side} (95 % interval {:.3} to {:.3} s) against the response of the model",
                shift.late.abs(),
                a.min(b),
                a.max(b)
            )
        };
        let (channel, reason) = match shift.who {
            Who::Output(k) => {
                let column = experiment.outputs[k].column;
                let column_of = experiment.place_of(k);
                runs.iter().for_each(|run| experiment.runs[*run].table.columns[column_of].fill(f64::NAN));
                experiment.notes.push(format!(
                    "{} in {files}, which no lag of its sensor explains; it is set aside: move its times, or give all channels one clock",
                    words(column)
                ));
                continue;
            }
            Who::Input(k) => (experiment.inputs[k].column, words(experiment.inputs[k].column)),
            Who::Outputs => {
                let first = experiment.inputs[0].column;
                (first, format!("every output, compared with {first} and the other inputs: {}", words("it")))
            }
        };
        return Ok(Some(Unusable::new(
            channel,
            format!("{reason}{place}"),
            "give all columns one clock: move the times of the column that is late or early",
        )));
    }
    Ok(None)
}

/// Mean squares of the residual, output by output; NaN without a reading.
fn squares(setup: &Setup, runs: &[usize], fitted: &Hypothesis) -> Option<Vec<f64>> {
    let shown = setup.show(fitted, runs).ok()?;
    Some(setup.rmse(runs, &shown).into_iter().map(|x| x * x).collect())
}

/// Usual interval between two rows of the fit runs, s.
fn interval(experiment: &Experiment) -> f64 {
    let fit = experiment.of_role(Role::Fit);
    numbers::interval(fit.iter().map(|r| &experiment.runs[*r].table.time[..]))
}

/// Grid of shifts of both signs.
fn grid(step: f64, most: f64, ratio: f64) -> Vec<f64> {
    let mut all = Vec::new();
    let mut size = 0.5 * step;
    while size < most {
        all.extend([size, -size]);
        size *= ratio;
    }
    all
}

fn with_moved(experiment: &Experiment, who: Who, late: f64) -> Experiment {
    let inputs = experiment.inputs.len();
    let columns: Vec<usize> = match who {
        Who::Input(k) => vec![k],
        Who::Output(k) => vec![inputs + k],
        Who::Outputs => (inputs..inputs + experiment.outputs.len()).collect(),
    };
    let mut changed = experiment.clone();
    for table in changed.runs.iter_mut().map(|r| &mut r.table) {
        for k in &columns {
            table.columns[*k] = moved(table, *k, late);
        }
    }
    changed
}

/// The clock offset, if one is significant; `row` is the interval between the rows of the files, s.
fn search(
    experiment: &Experiment,
    row: f64,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Shift>, CalibrateError> {
    let (fit, validate) = (experiment.of_role(Role::Fit), experiment.of_role(Role::Validate));
    let setup = structured(experiment, preset, &fit)?.until(deadline.clone());
    let Ok(as_is) = setup.refit(&fit) else { return Ok(None) };
    let inputs = experiment.inputs.len();
    let noise: Vec<f64> = noise::of_experiment(experiment)[inputs..].iter().map(|s| s * s).collect();
    let Some(before) = squares(&setup, &fit, &as_is.hypothesis) else { return Ok(None) };
    let is_noisy = before.iter().zip(&noise).any(|(s, n)| *s > AT_NOISE * n);
    if !is_noisy || deadline.is_near() {
        return Ok(None);
    }
    let step = interval(experiment);
    let tables = || fit.iter().map(|r| &experiment.runs[*r].table);
    let longest = tables().map(Table::span).fold(0.0, f64::max);
    let most = FARTHEST * longest;
    let points: Vec<About> = [as_is.hypothesis.clone(), setup.preset()]
        .iter()
        .filter_map(|h| About::new(&setup, h, &fit).ok())
        .collect();
    let judge = Judge { setup: &setup, fit: &fit, points: &points, noise: &noise };
    let mut shifts = judge.outputs(&grid(step, most, RATIO.0));
    shifts.extend(judge.inputs(&grid(step, most, RATIO.1), deadline));
    shifts.retain(|s| s.gain > LEAST);
    shifts.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut confirmed: Vec<Shift> = Vec::new();
    for shift in shifts.into_iter().take(CONFIRMED) {
        if deadline.is_near() {
            break;
        }
        confirmed.extend(judge.confirmed(shift, preset, &as_is, &before, &validate));
    }
    // What an input does between two rows is not measured: one that steps there acts up to an interval early or late.
    confirmed.retain(|s| matches!(s.who, Who::Output(_)) || s.late.abs() > row);
    confirmed.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let Some(best) = confirmed.first().copied() else { return Ok(None) };
    // If an input explains it equally well, the output is not set aside.
    let other = confirmed.iter().find(|s| matches!(s.who, Who::Input(_)) && s.gain > best.gain - VERY_STRONG);
    Ok(Some(other.copied().unwrap_or(best)))
}

/// Shift with the greatest gain among these, of which each is greater than the last by a ratio; refined where one is likely: a channel
/// that follows the inputs at once has a narrow optimum.
fn best(mut all: Vec<Shift>, ratio: f64, gain: &dyn Fn(f64) -> Option<f64>) -> Option<Shift> {
    let better = |a: &Shift, b: &Shift| a.gain.total_cmp(&b.gain);
    all.sort_by(|a, b| better(b, a));
    let refined = |start: &Shift| {
        let of = |late: f64| Some(Shift { gain: gain(late)?, ..Shift::new(start.who, late) });
        let (mut found, mut step) = (*start, 0.5 * (ratio - 1.0));
        while step > FINE && start.gain > 0.5 * LEAST {
            let near = [1.0 - step, 1.0 + step].into_iter().filter_map(|factor| of(factor * found.late));
            found = near.chain([found]).max_by(better)?;
            step *= 0.5;
        }
        Some(found)
    };
    all.iter().take(STARTS).filter_map(refined).max_by(better)
}

struct Judge<'a> {
    setup: &'a Setup<'a>,
    fit: &'a [usize],
    points: &'a [About],
    /// Variance of the noise, output by output.
    noise: &'a [f64],
}

impl Judge<'_> {
    /// n in (2).
    fn samples(&self, count: usize) -> f64 {
        (SAMPLES * self.fit.len() as f64).min(count as f64)
    }

    /// S(0) of an output, at the better linearization.
    fn unmoved(&self, output: usize) -> Option<f64> {
        let all = self.points.iter().filter_map(|p| p.late(output, 0.0)).map(|(s, _)| s);
        all.min_by(f64::total_cmp)
    }

    /// (2) of an output for a mean square and a number of readings.
    fn gain(&self, output: usize, unmoved: f64, (square, count): (f64, usize)) -> f64 {
        // A mean square below that of the noise is no further gain.
        let floor = self.noise[output];
        self.samples(count) * (unmoved.max(floor) / square.max(floor)).ln()
    }

    /// Best shift of each output, and of all outputs together.
    fn outputs(&self, shifts: &[f64]) -> Vec<Shift> {
        let m = self.setup.outputs();
        let unmoved: Vec<Option<f64>> = (0..m).map(|k| self.unmoved(k)).collect();
        let own = |k: usize, late: f64| {
            let best = self.points.iter().filter_map(|p| p.late(k, late)).min_by(|a, b| a.0.total_cmp(&b.0));
            best.zip(unmoved[k]).map_or(0.0, |(s, unmoved)| self.gain(k, unmoved, s))
        };
        let gains: Vec<Vec<f64>> = parallel::map(shifts, |late| (0..m).map(|k| own(k, *late)).collect());
        let of = |who: Who, gain: &dyn Fn(&[f64]) -> f64| -> Vec<Shift> {
            let all = shifts.iter().zip(&gains);
            all.map(|(late, own)| Shift { gain: gain(own), ..Shift::new(who, *late) }).collect()
        };
        let single = (0..m)
            .filter_map(|k| best(of(Who::Output(k), &|own| own[k]), RATIO.0, &|late| Some(own(k, late))));
        let sum = |late: f64| Some((0..m).map(|k| own(k, late)).sum());
        let all = best(of(Who::Outputs, &|own| own.iter().sum()), RATIO.0, &sum).filter(|_| m > 1);
        single.chain(all).collect()
    }

    /// Best shift of each input.
    fn inputs(&self, shifts: &[f64], deadline: &Deadline) -> Vec<Shift> {
        let experiment = self.setup.experiment;
        let m = self.setup.outputs();
        let unmoved: Vec<Option<f64>> = (0..m).map(|k| self.unmoved(k)).collect();
        // The ambient temperature changes slowly; a shift of a constant column has no effect.
        let moving = |k: &usize| {
            let own = self.fit.iter().map(|r| &experiment.runs[*r].table.columns[*k]);
            !experiment.inputs[*k].is_temperature() && own.flat_map(|c| c.windows(2)).any(|w| w[0] != w[1])
        };
        let hypothesis = self.setup.preset();
        let Some(about) = self.points.last() else { return Vec::new() };
        let outputs = (0..m).filter_map(|k| Some((k, unmoved[k]?, about.with(k)?)));
        let outputs: Vec<_> = outputs.collect();
        let of = |k: usize, late: f64| -> Option<f64> {
            if deadline.is_near() {
                return None;
            }
            let changed = with_moved(experiment, Who::Input(k), late);
            let shown = |run: &usize| {
                let drive = Drive::new(&changed, &changed.runs[*run]).ok()?;
                self.setup.bench.run(&drive, &self.setup.change(&hypothesis, *run)).ok()
            };
            let predicted: Option<Vec<Vec<Vec<f64>>>> = self.fit.iter().map(shown).collect();
            let predicted = predicted?;
            Some(outputs.iter().map(|(k, unmoved, with)| self.gain(*k, *unmoved, with(&predicted))).sum())
        };
        let candidates: Vec<usize> = (0..experiment.inputs.len()).filter(moving).collect();
        parallel::flat_map(&candidates, |k| {
            let of = |late: f64| of(*k, late);
            let shift = |late: &f64| Some(Shift { gain: of(*late)?, ..Shift::new(Who::Input(*k), *late) });
            best(parallel::flat_map(shifts, shift), RATIO.1, &of)
        })
    }

    /// Shift with its gain after a fit, and its interval; `None` if it does not explain the residual.
    fn confirmed(
        &self,
        shift: Shift,
        preset: &[(u32, f64)],
        as_is: &Fitted,
        before: &[f64],
        validate: &[usize],
    ) -> Option<Shift> {
        let mut shift = shift;
        let mut best: Option<Shift> = None;
        // Shift and fit depend on each other, so they are iterated.
        for _ in 0..2 {
            let changed = with_moved(self.setup.experiment, shift.who, shift.late);
            let mut setup = structured(&changed, preset, self.fit).ok()?.until(self.setup.deadline().clone());
            setup.noise.clone_from(&self.setup.noise);
            let fitted = setup.refit(self.fit).ok()?;
            let after = squares(&setup, self.fit, &fitted.hypothesis)?;
            let of = |k: usize| {
                let count = self.setup.experiment.runs.iter().map(|r| r.table.time.len()).sum();
                let gain = self.gain(k, before[k], (after[k], count));
                if gain.is_finite() { gain } else { 0.0 }
            };
            let gains: Vec<f64> = (0..self.setup.outputs()).map(of).collect();
            let prior = |f: &Fitted| f.cost - f.chi_square;
            shift.gain = gains.iter().sum::<f64>() + prior(as_is) - prior(&fitted);
            let judged = |k: usize| match shift.who {
                Who::Output(own) => own == k,
                _ => gains[k] > LEAST,
            };
            let outputs: Vec<usize> = (0..self.setup.outputs()).filter(|k| judged(*k)).collect();
            // The shift must explain nearly all of the residual in the output; that of an input in one of them, since the others can
            // have a structure error as well.
            let explained = |k: &usize| {
                before[*k] > FACTOR * after[*k].max(self.noise[*k])
                    && after[*k] <= self.structure(*k).max(SMALL * before[*k])
            };
            let explains = outputs.iter().any(explained);
            let validated = validate.is_empty() || {
                let (old, new) = (
                    squares(self.setup, validate, &as_is.hypothesis)?,
                    squares(&setup, validate, &fitted.hypothesis)?,
                );
                match shift.who {
                    Who::Output(k) => new[k].is_nan() || new[k] <= 0.5 * old[k].max(2.0 * self.noise[k]),
                    _ => {
                        let of = |k: usize| {
                            let floor = self.noise[k];
                            SAMPLES * validate.len() as f64 * (old[k].max(floor) / new[k].max(floor)).ln()
                        };
                        (0..self.setup.outputs()).map(of).sum::<f64>() > VERY_STRONG
                    }
                }
            };
            // Another clock of the inputs moves every output that depends on them; a lag that the model lacks moves temperatures only.
            let is_common = gains.iter().all(|gain| *gain > -VERY_STRONG);
            if shift.gain < LEAST || !explains || !validated || !is_common {
                return best;
            }
            let fit = agreement::Fit {
                setup: self.setup,
                changed: &setup,
                fitted: &fitted.hypothesis,
                noise: self.noise,
                who: shift.who,
                late: shift.late,
            };
            let runs: Vec<usize> = self.fit.iter().chain(validate).copied().collect();
            if !fit.holds(&runs)? {
                return None;
            }
            let shift_of_fit = self.estimated(&shift, &fitted.hypothesis, &setup, &as_is.hypothesis)?;
            best = Some(Shift { gain: shift.gain, ..shift_of_fit });
            shift = shift_of_fit;
        }
        best
    }

    /// Mean square of an output due to noise and structure error.
    fn structure(&self, output: usize) -> f64 {
        let (square, _) = mean_square(self.setup.experiment, self.fit, output);
        2.0 * self.noise[output] + STRUCTURE.powi(2) * square
    }

    /// Shift at a fit with its 95 % interval; `None` if lags of the outputs explain the data equally well, those about the fit `as_is` for
    /// an input.
    fn estimated(
        &self,
        shift: &Shift,
        fitted: &Hypothesis,
        changed: &Setup,
        as_is: &Hypothesis,
    ) -> Option<Shift> {
        let outputs: Vec<usize> = match shift.who {
            Who::Output(k) => vec![k],
            _ => (0..self.setup.outputs()).collect(),
        };
        // A shift of an input needs a simulation; relative to its prediction the outputs shift in the opposite direction.
        let (setup, sign, from) = match shift.who {
            Who::Input(_) => (changed, -1.0, shift.late),
            _ => (self.setup, 1.0, 0.0),
        };
        let about = About::new(setup, fitted, self.fit).ok()?;
        let cost = |late: f64| {
            let own = outputs.iter().map(|k| {
                let (square, count) = about.late(*k, late)?;
                Some(self.samples(count) * square.max(self.noise[*k] * 0.5).ln())
            });
            own.sum::<Option<f64>>()
        };
        let center = sign * (shift.late - from);
        let step = 0.5 * shift.late.abs() / f64::from(STEPS);
        let shifts: Vec<f64> = (-STEPS..=STEPS).map(|k| center + step * f64::from(k)).collect();
        let costs = parallel::flat_map(&shifts, |d| Some((*d, cost(*d)?)));
        let (at, least) = costs.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let inside = costs.iter().filter(|(_, c)| *c <= least + SURE * SURE).map(|(d, _)| *d);
        let half = 0.5 * step;
        let (low, high) = inside.fold((at, at), |(a, b), d| (a.min(d), b.max(d)));
        let (about, late) = match shift.who {
            Who::Input(_) => (&About::new(self.setup, as_is, self.fit).ok()?, -shift.late),
            _ => (&about, at),
        };
        if late > 0.0 {
            let lagged = |k: usize| {
                let lags = (0..LAGS.2).filter_map(|n| about.lagged(k, LAGS.0 * late * LAGS.1.powi(n)));
                let costs = lags
                    .chain(about.late(k, 0.0))
                    .map(|(square, count)| self.samples(count) * square.max(self.noise[k] * 0.5).ln());
                costs.min_by(f64::total_cmp).unwrap_or(f64::INFINITY)
            };
            if outputs.iter().map(|k| lagged(*k)).sum::<f64>() < least + VERY_STRONG {
                return None;
            }
        }
        let back = |d: f64| from + sign * d;
        let (a, b) = (back(low - half), back(high + half));
        Some(Shift { late: back(at), interval: (a.min(b), a.max(b)), ..*shift })
    }
}
