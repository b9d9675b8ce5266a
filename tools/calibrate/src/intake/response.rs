//! Sensors that do not respond as they should: frozen, detached, open circuit at a plausible temperature, shorted, dead.
//!
//! The model of the preset gives the prediction p at every row; y is the reading and p0 the initial value of both (ambient temperature,
//! otherwise 0). Parameter errors may scale the response, so that y - p0 may be a multiple or a fraction of p - p0, but it has to follow
//! p:
//!
//! level  (y - p0) / (b (p - p0)) within [`LEVEL`], or y within [`FAR`] of p0 + b (p - p0)             (1)
//! slope  cov(y, b p) / var(b p) over a section in which p varies: at least [`SMALL`]                  (2)
//! repeat identical readings, while p varies by more than [`CLEAR`] resolutions                        (3)
//!
//! b is the channel's median of (y - p0) / (p - p0) over all runs, which removes a scale error due to the model's parameters. Between two
//! jumps ([`super::signals`]) the readings must agree with p as well as in the best section of the run. Around a failure, rows are set
//! aside as long as the reading deviates from b p by more than where the sensor works.
//!
//! *Assumes* that parameter errors and missing effects change a temperature rise by less than a factor of eight. *Sources*: Isermann,
//! Fault-Diagnosis Systems (2006), ch. 7 and 10 (signal models, parity equations).

use super::consistency::is_bus;
use super::signals::{NEAR, WIDEST};
use super::steps::{Record, Steps, UNPREDICTED};
use super::{FAR, Predicted, ambient, departures, deviation, median, sorted};
use crate::experiment::{Channel, Experiment};
use crate::levels::{CERTAIN, FACTOR, PART, SMALL};
use crate::noise;
use crate::report::count_of;
use physics::declare::Unit;
use std::cell::LazyCell;

/// (1): a sensor on the motor reads between one eighth of the rise and eight times the rise. Limit: losses, conductance to the air and
/// resistance between the nodes are each within a factor of two of the preset's.
pub(super) const LEVEL: (f64, f64) = (0.125, 8.0);
/// Fewest rows of a section. Derivation: a standard deviation is then known to 13 %, 1 / sqrt(2 n).
pub(super) const LEAST_ROWS: usize = 30;
/// Numbers of sections of a run to which (2) is applied. Numerical: a failure of an eighth of a run or more is seen.
const PARTS: [usize; 4] = [1, 2, 4, 8];
/// Standard deviations of the noise, or resolutions, that count as a change. Derivation: two readings, each with an error within
/// [`CERTAIN`], differ by less.
pub const CLEAR: f64 = 2.0 * CERTAIN;
/// Fraction of failed readings above which the sensor is set aside in the whole run. Definition: the majority.
const WHOLE: f64 = 0.5;
/// Fewest readings of a run for this check. Derivation: the noise is then known to 11 %, 1 / sqrt(2 n).
pub const ENOUGH: usize = 40;
/// Fraction of a deviation from which that of another thermometer confirms it. Derivation: without temperature differences in the motor
/// both deviate equally, and a failed sensor alone does not move the other; this is the middle.
const AGREES: f64 = 0.5;
/// Quantile of a variation that ignores spikes, on either side. Numerical: 2 % of the readings.
pub(super) const TAIL: f64 = 0.02;

/// A sensor that does not respond, in words.
pub const DEAD: &str = "does not follow what drives it, as a dead or detached sensor does";

/// A voltage of the supply of the drive, in words.
const AT_SUPPLY: &str = "hardly varies and is not less than the predicted voltage of the motor, as the voltage of the drive's supply (bus \
                         voltage) does, or a dead sensor";

/// Readings and prediction of one output in one run.
pub(super) struct Pair {
    /// Rows with reading and prediction.
    pub(super) rows: Vec<usize>,
    /// Reading minus the initial value (ambient temperature or zero).
    pub(super) read: Vec<f64>,
    /// Prediction minus the initial value (ambient temperature or zero).
    pub(super) model: Vec<f64>,
}

impl Pair {
    /// Deviation from the prediction.
    fn off(&self) -> Vec<f64> {
        self.read.iter().zip(&self.model).map(|(y, p)| y - p).collect()
    }
}

pub(super) fn pair(experiment: &Experiment, predicted: &[Vec<f64>], run: usize, output: usize) -> Pair {
    let of = &experiment.runs[run];
    let column = experiment.readings(run, output);
    let Some(model) = predicted.get(output) else {
        return Pair { rows: Vec::new(), read: Vec::new(), model: Vec::new() };
    };
    let zero = if experiment.outputs[output].is_temperature() {
        ambient(experiment, of)
    } else {
        vec![0.0; column.len()]
    };
    let is_known = |row: &usize| (column[*row] + model[*row] + zero[*row]).is_finite();
    let rows: Vec<usize> = (0..column.len()).filter(is_known).collect();
    let read = rows.iter().map(|row| column[*row] - zero[*row]).collect();
    let model = rows.iter().map(|row| model[*row] - zero[*row]).collect();
    Pair { rows, read, model }
}

/// Range of the values without [`TAIL`] on either side.
pub fn spread(values: &[f64]) -> f64 {
    let all = sorted(values.iter().copied());
    let at = |share: f64| all[(share * (all.len() - 1) as f64) as usize];
    if all.is_empty() { 0.0 } else { at(1.0 - TAIL) - at(TAIL) }
}

/// cov(y, p) / var(p) of (2).
pub(super) fn slope(read: &[f64], model: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (a, b) = (mean(read), mean(model));
    let pairs = read.iter().zip(model);
    let (both, own) =
        pairs.fold((0.0, 0.0), |(both, own), (y, p)| (both + (y - a) * (p - b), own + (p - b).powi(2)));
    both / own
}

/// Failed readings of an output in a run.
struct Failure {
    output: usize,
    run: usize,
    /// By place in `own`.
    bad: Vec<bool>,
    /// Those that repeat exactly or jump as no temperature does.
    proven: Vec<usize>,
    /// Whether the sensor has moved: its other readings are right.
    is_moved: bool,
    why: &'static str,
    sigma: f64,
    /// With the best prediction that there is.
    own: Pair,
}

/// Sets aside sensors that do not respond, with notes: those that follow neither the preset's prediction nor that of the fitted
/// parameters, by run and output. A current that is the small difference of two voltages cannot be predicted by a preset. With a sure
/// fit, a sensor that departs from it in a run is set aside too.
pub fn set_aside(
    experiment: &mut Experiment,
    predicted: &[Vec<Vec<f64>>],
    (fitted, is_sure): (&[Predicted], &[bool]),
    deviations: impl FnOnce() -> Predicted,
) {
    let deviations = LazyCell::new(deviations);
    let mut failures: Vec<Failure> = Vec::new();
    // Deviation of a channel, by row of a run, from the prediction of an output's fit.
    let off = |of: usize, output: usize, run: usize| deviation(experiment, &fitted[of][run], output, run);
    for output in 0..experiment.outputs.len() {
        let channel = experiment.outputs[output];
        let mut pairs: Vec<Pair> =
            (0..experiment.runs.len()).map(|run| pair(experiment, &predicted[run], run, output)).collect();
        let size =
            pairs.iter().map(|p| p.model.iter().fold(0.0, |m: f64, x| m.max(x.abs()))).fold(0.0, f64::max);
        let ratios = pairs.iter().flat_map(|p| p.read.iter().zip(&p.model));
        let ratio = median(ratios.filter(|(_, m)| m.abs() > PART * size).map(|(y, m)| y / m));
        let ratio = if ratio.is_finite() { ratio.clamp(1.0 / FACTOR, FACTOR) } else { 1.0 };
        pairs.iter_mut().flat_map(|p| &mut p.model).for_each(|m| *m *= ratio);
        let moves = pairs.iter().map(|p| spread(&p.model)).fold(0.0, f64::max);
        let is_predicted = is_sure[output];
        let is_sure = is_predicted && channel.is_temperature();
        let own = |run: usize| off(output, output, run);
        let own: Vec<Vec<f64>> = (0..experiment.runs.len()).map(own).collect();
        let record = Record::new(experiment, &own);
        let gone = if is_sure { departures::of(experiment, output, &own) } else { Vec::new() };
        let usual = median(own.iter().flatten().map(|off| off.abs()).filter(|off| off.is_finite()));
        for (run, own) in pairs.into_iter().enumerate() {
            if own.rows.len() < ENOUGH {
                continue;
            }
            let table = &experiment.runs[run].table;
            let first = experiment.place_of(output);
            let column: Vec<f64> = own.rows.iter().map(|row| table.columns[first][*row]).collect();
            let time: Vec<f64> = own.rows.iter().map(|row| table.time[*row]).collect();
            let sigma = noise::of_column(&time, &column).unwrap_or(0.0);
            let doubt = |rows: &[usize]| {
                let of = |row: &usize| deviations[run].get(output).map_or(0.0, |all| all[*row].powi(2));
                (rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64).sqrt()
            };
            let judge = Judge {
                channel,
                own: &own,
                time: &time,
                column: &column,
                sigma,
                moves,
                record: &record,
                run,
                doubt: &doubt,
            };
            let of_fit = pair(experiment, &fitted[output][run], run, output);
            let is_fitted = of_fit.rows == own.rows;
            let moves = spread(&of_fit.model).max(moves);
            let (mut failed, mut stepped) = (judge.bad(), Vec::new());
            if let Some((bad, _)) = failed.as_mut().filter(|_| is_fitted) {
                let fit = Judge { own: &of_fit, moves, ..judge };
                let also = fit.bad().map_or_else(|| vec![false; bad.len()], |(also, _)| also);
                let is_bad_in_fit = also.contains(&true);
                bad.iter_mut().zip(also).for_each(|(bad, also)| *bad &= also);
                if is_bad_in_fit && !bad.contains(&true) {
                    // A jump that neither prediction contains; they may differ on which side of it is wrong.
                    let (rows, is_clear) = fit.moved();
                    stepped = if is_clear { rows } else { judge.moved().0 };
                    stepped.iter().for_each(|k| bad[*k] = true);
                }
            }
            failed = failed.filter(|(bad, _)| bad.contains(&true));
            if failed.is_none() && is_sure && is_fitted {
                let gone: Vec<bool> = own.rows.iter().map(|row| gone[run].contains(row)).collect();
                failed = Some((gone, departures::WHY)).filter(|(gone, _)| gone.contains(&true));
            }
            if is_predicted && is_fitted {
                // What the other outputs determine is no matter of the priors, and a rise that is small beside that of other runs is
                // known as well as the fit agrees.
                let moves = if channel.is_temperature() { CERTAIN * usual / PART } else { moves };
                let dead = Judge { own: &of_fit, moves, doubt: &|_| 0.0, ..judge }.unmoved();
                if !dead.is_empty() {
                    let (bad, _) = failed.get_or_insert_with(|| (vec![false; column.len()], DEAD));
                    dead.into_iter().for_each(|k| bad[k] = true);
                }
            }
            let Some((bad, mut why)) = failed else { continue };
            let model: Vec<f64> = own.rows.iter().map(|row| predicted[run][output][*row]).collect();
            if why == DEAD && channel.unit == Unit::Volt && is_bus(&column, &model) {
                why = AT_SUPPLY;
            }
            let jumped: Vec<usize> = judge.jumped().into_iter().chain(stepped).collect();
            let mut rest = bad.clone();
            jumped.iter().for_each(|k| rest[*k] = false);
            let is_moved = !rest.contains(&true);
            let proven = judge.repeated().into_iter().chain(jumped).filter(|k| bad[*k]).collect();
            let own = if is_sure && is_fitted { of_fit } else { own };
            failures.push(Failure { output, run, bad, proven, is_moved, why, sigma, own });
        }
    }
    // Two thermometers do not fail together: what both read is the heat, and the prediction is wrong.
    let warm = experiment.thermometers();
    for failure in failures.iter_mut().filter(|f| warm.contains(&f.output)) {
        let own = off(failure.output, failure.output, failure.run);
        let bad: Vec<usize> =
            (0..failure.bad.len()).filter(|k| failure.bad[*k] && !failure.proven.contains(k)).collect();
        let is_heat = warm.iter().filter(|k| **k != failure.output).any(|other| {
            let other = off(failure.output, *other, failure.run);
            let agrees = |row: usize| other[row] * own[row].signum() > AGREES * own[row].abs();
            let count = bad.iter().filter(|k| agrees(failure.own.rows[**k])).count();
            count as f64 > WHOLE * bad.len() as f64
        });
        if is_heat {
            bad.into_iter().for_each(|k| failure.bad[k] = false);
        }
    }
    let least = |f: &Failure| if f.is_moved { WIDEST } else { LEAST_ROWS };
    failures.retain(|f| f.bad.iter().filter(|bad| **bad).count() >= least(f));
    let mut notes: Vec<String> = Vec::new();
    for k in 0..failures.len() {
        let note = blank(experiment, &failures, k);
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    experiment.notes.extend(notes);
}

/// Sets aside the readings of a failure, widened to all that deviate unusually; returns the note.
fn blank(experiment: &mut Experiment, failures: &[Failure], k: usize) -> String {
    let Failure { output, run, bad, is_moved, why, sigma, own, .. } = &failures[k];
    let channel = experiment.outputs[*output];
    let first = experiment.place_of(*output);
    let deviation = own.off();
    let off: Vec<f64> = deviation.iter().map(|x| x.abs()).collect();
    let usual = sorted(off.iter().zip(bad).filter(|(_, bad)| !**bad).map(|(x, _)| *x));
    let usual = usual.get(usual.len() * 3 / 4).copied().unwrap_or(0.0);
    let table = &experiment.runs[*run].table;
    let column: Vec<f64> = own.rows.iter().map(|row| table.columns[first][*row]).collect();
    let jumps =
        if channel.is_temperature() { super::signals::small_jumps(&deviation, &column) } else { Vec::new() };
    let mut bad = bad.clone();
    widen(&mut bad, &off, usual.max(CERTAIN * sigma), &jumps);
    let time = |k: Option<usize>| k.map_or(f64::NAN, |k| table.time[own.rows[k]]);
    let (from, to) = (time(bad.iter().position(|b| *b)), time(bad.iter().rposition(|b| *b)));
    let count = bad.iter().filter(|bad| **bad).count();
    let run = &mut experiment.runs[*run];
    let column = &mut run.table.columns[first];
    let most = if *is_moved { own.rows.len() - LEAST_ROWS } else { (WHOLE * own.rows.len() as f64) as usize };
    if count > most {
        column.fill(f64::NAN);
        return format!("{}: {} {why}; it is set aside in this run", run.file, channel.column);
    }
    own.rows.iter().zip(&bad).filter(|(_, bad)| **bad).for_each(|(row, _)| column[*row] = f64::NAN);
    let count = count_of(count, "reading");
    format!("{}: {} {why}; {count} from {from} s to {to} s set aside", run.file, channel.column)
}

/// Extends the failed rows, with a margin, as long as the reading deviates from the prediction by more than usual. The extension ends at a
/// jump, at which the sensor began or ceased to work.
fn widen(bad: &mut [bool], off: &[f64], usual: f64, jumps: &[usize]) {
    let mut ends = vec![0];
    ends.extend(jumps);
    ends.push(bad.len());
    for (from, to) in ends.windows(2).map(|w| (w[0], w[1])) {
        let (bad, off) = (&mut bad[from..to], &off[from..to]);
        for k in 1..bad.len() {
            bad[k] |= bad[k - 1] && off[k] > usual;
        }
        for k in (1..bad.len()).rev() {
            bad[k - 1] |= bad[k] && off[k - 1] > usual;
        }
        let edges: Vec<usize> = (0..bad.len()).filter(|k| bad[*k]).collect();
        for k in edges {
            let end = (k + WIDEST + 1).min(bad.len());
            bad[k.saturating_sub(WIDEST)..end].fill(true);
        }
    }
}

/// Data for the check of one output in one run.
struct Judge<'a> {
    channel: &'static Channel,
    own: &'a Pair,
    time: &'a [f64],
    column: &'a [f64],
    sigma: f64,
    moves: f64,
    record: &'a Record<'a>,
    run: usize,
    /// Standard deviation of the prediction due to the priors, over some rows.
    doubt: &'a dyn Fn(&[usize]) -> f64,
}

impl Judge<'_> {
    /// Failed readings, and the kind of failure; `None` if there is none.
    fn bad(&self) -> Option<(Vec<bool>, &'static str)> {
        let mut bad = vec![false; self.column.len()];
        let mut why = None;
        let mut mark = |rows: Vec<usize>, what: &'static str| {
            if !rows.is_empty() {
                why.get_or_insert(what);
            }
            rows.into_iter().for_each(|k| bad[k] = true);
        };
        mark(self.repeated(), "stands still while it should move, as a frozen or open sensor does");
        if self.channel.is_temperature() {
            mark(self.jumped(), "jumps as no temperature does, as a loose contact does");
            mark(self.off_level(), "does not follow the heat, as a detached or open sensor does");
        }
        mark(self.unmoved(), DEAD);
        why.map(|what| (bad, what))
    }

    /// (3)
    fn repeated(&self) -> Vec<usize> {
        let n = self.column.len();
        let mut stretches: Vec<(usize, usize)> = Vec::new();
        for k in 0..n {
            match stretches.last_mut() {
                Some((from, to)) if self.column[*from] == self.column[k] => *to = k,
                _ => stretches.push((k, k)),
            }
        }
        let usual = median(stretches.iter().map(|(a, b)| (b - a + 1) as f64));
        let changes = self.column.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|x| *x > 0.0);
        let resolution = sorted(changes).first().copied().unwrap_or(0.0);
        let least = (CLEAR * resolution.max(self.sigma)).max(SMALL * self.moves);
        let long = |(a, b): &(usize, usize)| {
            // If all readings are identical, the usual number of repetitions is no criterion.
            let held = if stretches.len() > 2 { CERTAIN * usual } else { 0.0 };
            let count = b - a + 1;
            let span = self.own.model[*a..=*b]
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
            count >= LEAST_ROWS && count as f64 > held && span.1 - span.0 > least
        };
        stretches.iter().filter(|s| long(s)).flat_map(|(a, b)| *a..=*b).collect()
    }

    fn steps<'b>(&'b self, off: &'b [f64]) -> Steps<'b> {
        Steps { run: self.run, off, time: self.time, rows: &self.own.rows, record: self.record }
    }

    /// Sections between jumps that deviate far more from the prediction than the best one. If there is none, all but one section
    /// between jumps that the model does not predict: a sensor that has moved reads differently before and after.
    fn jumped(&self) -> Vec<usize> {
        let deviation = self.own.off();
        let steps = self.steps(&deviation);
        let mut jumps = super::signals::jumps(self.column);
        jumps.retain(|k| steps.is_sudden(*k, deviation[*k] - deviation[*k - 1]));
        if jumps.is_empty() {
            return self.moved().0;
        }
        let mut ends = vec![0];
        ends.extend(&jumps);
        ends.push(self.column.len());
        let off =
            |(a, b): (usize, usize)| median((a..b).map(|k| (self.own.read[k] - self.own.model[k]).abs()));
        let parts: Vec<(usize, usize)> =
            ends.windows(2).map(|w| (w[0], w[1])).filter(|(a, b)| b > a).collect();
        let best =
            parts.iter().filter(|(a, b)| b - a >= LEAST_ROWS).map(|p| off(*p)).fold(f64::INFINITY, f64::min);
        let least = (CERTAIN * best).max(SMALL * self.moves).max(CLEAR * self.sigma);
        let far: Vec<usize> = parts.into_iter().filter(|p| off(*p) > least).flat_map(|(a, b)| a..b).collect();
        if far.is_empty() { self.moved().0 } else { far }
    }

    /// All readings except those of one section between unpredicted jumps and of sections at the same level: of the one that agrees with
    /// the prediction, if it clearly does, else of the one that agrees with it at the start. Result: the rows, and whether it was clear.
    fn moved(&self) -> (Vec<usize>, bool) {
        if !self.channel.is_temperature() {
            return (Vec::new(), false);
        }
        let off = self.own.off();
        let steps = self.steps(&off);
        let mut jumps = super::signals::jumps(self.column);
        jumps.extend(super::signals::small_jumps(&off, self.column));
        jumps.sort_unstable();
        jumps.dedup();
        let change = |of: &[f64], k: usize| of[k] - of[k - 1];
        let sizes = jumps.iter().map(|k| (*k, change(&self.own.read, *k), change(&self.own.model, *k)));
        let own: Vec<(usize, f64)> = sizes
            .filter(|(_, read, model)| (read - model).abs() > UNPREDICTED * read.abs())
            .map(|(k, read, model)| (k, read - model))
            .filter(|(k, size)| steps.is_one(*k, *size))
            .collect();
        let typical = |part: &std::ops::Range<usize>| median(part.clone().map(|k| off[k].abs()));
        let least = own.iter().map(|(_, size)| size.abs()).fold(f64::INFINITY, f64::min);
        // Sections with the accumulated jump before each.
        let mut parts = vec![(0..self.column.len(), 0.0)];
        for (k, size) in own {
            let Some((last, level)) = parts.last_mut() else { break };
            let next = (k..last.end, *level + size);
            last.end = k;
            parts.push(next);
        }
        let long = parts.iter().filter(|(part, _)| part.len() >= LEAST_ROWS);
        let best = long.min_by(|a, b| typical(&a.0).total_cmp(&typical(&b.0)));
        let longest = parts.iter().max_by_key(|(part, _)| part.len());
        let is_clear =
            best.zip(longest).is_some_and(|(best, longest)| FACTOR * typical(&best.0) < typical(&longest.0));
        // The motor starts at ambient temperature, whatever its parameters are.
        let start = median(off.iter().take(NEAR).copied());
        let at_start = parts.iter().min_by(|a, b| (a.1 + start).abs().total_cmp(&(b.1 + start).abs()));
        let right = if is_clear { best } else { at_start };
        let right = right.map_or(0.0, |(_, level)| *level);
        let elsewhere = parts.iter().filter(|(_, level)| (level - right).abs() > 0.5 * least);
        (elsewhere.flat_map(|(part, _)| part.clone()).collect(), is_clear)
    }

    /// (1)
    fn off_level(&self) -> Vec<usize> {
        let most = self.own.model.iter().fold(0.0, |m: f64, x| m.max(*x));
        let least = (SMALL * most).max(FAR).max(CLEAR * self.sigma);
        let tells: Vec<usize> = (0..self.column.len()).filter(|k| self.own.model[*k] > least).collect();
        let fails = |k: &usize| {
            let (read, model) = (self.own.read[*k], self.own.model[*k]);
            !(LEVEL.0..=LEVEL.1).contains(&(read / model)) && (read - model).abs() > FAR
        };
        // Near ambient, (1) is replaced by a limit on the deviation relative to the variation in the run.
        let far = |k: &usize| (self.own.read[*k] - self.own.model[*k]).abs() > self.moves.max(FAR);
        let failing: Vec<usize> = tells.iter().copied().filter(fails).collect();
        let mut all: Vec<usize> = (0..self.column.len()).filter(far).collect();
        if failing.len() >= LEAST_ROWS {
            all.extend(&failing);
            // A detached sensor does not reattach, unless it follows the prediction again.
            let last = failing[failing.len() - 1];
            if tells.iter().filter(|k| **k > last).count() < LEAST_ROWS {
                all.extend(last..self.column.len());
            }
        }
        if all.len() < LEAST_ROWS { Vec::new() } else { all }
    }

    /// (2)
    fn unmoved(&self) -> Vec<usize> {
        let n = self.column.len();
        let mut all = Vec::new();
        for parts in PARTS {
            let length = n / parts;
            if length < ENOUGH {
                break;
            }
            for from in (0..=n - length).step_by((length / 2).max(1)) {
                let part = from..from + length;
                let model = &self.own.model[part.clone()];
                let moved = spread(model);
                // The prediction has the noise of the inputs.
                let noise = noise::of_column(&self.time[part.clone()], model).unwrap_or(0.0).max(self.sigma);
                if moved <= (PART * self.moves).max(CLEAR * noise) || moved <= f64::EPSILON {
                    continue;
                }
                let slope = slope(&self.own.read[part.clone()], model);
                let moves = spread(&self.own.read[part.clone()]);
                let is_still = slope.abs() < SMALL && moves < FACTOR * SMALL * moved + CLEAR * self.sigma;
                // The priors may account for all of the variation: a current as the small difference of two voltages.
                if is_still && moved > CERTAIN * (self.doubt)(&self.own.rows[part.clone()]) {
                    all.extend(part);
                }
            }
        }
        all
    }
}
