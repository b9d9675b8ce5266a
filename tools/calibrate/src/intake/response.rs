//! Sensors that do not answer what they should: frozen, detached, open at a level that could be a temperature, shorted, dead.
//!
//! The model of the preset predicts p at every row; y is the reading and p0 where both begin (ambient temperature, else 0). The model may be
//! wrong by any parameter, so that y - p0 may be several times p - p0, or a fraction of it; but it has to follow:
//!
//! level  (y - p0) / (b (p - p0)) within [`LEVEL`], or y within [`FAR`] of p0 + b (p - p0)             (1)
//! slope  cov(y, b p) / var(b p) over a stretch in which p moves: at least [`SLOPE`]                   (2)
//! repeat exactly the same reading, while p moves by more than [`STEPS`] resolutions                   (3)
//!
//! b is the channel's median of (y - p0) / (p - p0) over all runs, which takes out what a parameter of the model is off. Between two
//! jumps ([`super::signals`]) the readings have to lie near p as well as the best stretch of the run does. Around what fails, rows are set
//! aside as far as the reading is away from b p by more than it is where the sensor works.
//!
//! *Assumes* that a law of physics changes a temperature rise by less than a factor of eight. *Sources*: Isermann, Fault-Diagnosis Systems
//! (2006), ch. 7 and 10 (signal models, parity equations).

use super::{FAR, Unusable, ambient, median, sorted};
use crate::experiment::{Channel, Experiment, Role};
use crate::noise;
use std::cell::LazyCell;

/// (1): a sensor on the motor reads at least an eighth of the rise, and no more than eight times.
const LEVEL: (f64, f64) = (0.125, 8.0);
/// (2)
const SLOPE: f64 = 0.1;
/// (3), and the fewest rows of a stretch.
const STEPS: f64 = 5.0;
const LEAST_ROWS: usize = 30;
/// Standard deviations of a prediction that its movement has to exceed: those from -2 to +2, in which 95 % of the priors lie.
const CERTAIN: f64 = 4.0;
/// Fraction of a jump that the model leaves unpredicted, from which on it is the sensor's: a thermal capacity of the preset within a
/// factor of two of the motor's predicts half of a step.
const UNPREDICTED: f64 = 0.5;
/// Parts of a run in which (2) is asked.
const PARTS: [usize; 4] = [1, 2, 4, 8];
/// Fraction of its movement over all runs that the prediction has to move in a stretch to ask (2) or (3) there.
const MOVES: f64 = 0.25;
/// Deviations of the noise that count as clear of it.
const CLEAR: f64 = 10.0;
/// Fraction of a run's readings from which on a sensor that fails is set aside in all of the run.
const WHOLE: f64 = 0.6;
/// Fewest readings of a run to judge it by.
const ENOUGH: usize = 40;

/// One output of one run beside its prediction.
struct Pair {
    /// Rows that were measured and predicted.
    rows: Vec<usize>,
    /// Reading over ambient or zero.
    read: Vec<f64>,
    /// Prediction over ambient or zero.
    model: Vec<f64>,
}

fn pair(experiment: &Experiment, predicted: &[Vec<f64>], run: usize, output: usize) -> Pair {
    let of = &experiment.runs[run];
    let column = &of.table.columns[experiment.inputs.len() + output];
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

fn spread(values: &[f64]) -> f64 {
    let all = sorted(values.iter().copied());
    let at = |share: f64| all[(share * (all.len() - 1) as f64) as usize];
    if all.is_empty() { 0.0 } else { at(0.98) - at(0.02) }
}

/// Sets aside what does not answer, with notes: neither as the preset predicts, nor as the fit of the declared parameters does, both run by
/// run and output by output. A current that is the small difference of two voltages follows no prediction of a preset.
pub fn set_aside(
    experiment: &mut Experiment,
    predicted: &[Vec<Vec<f64>>],
    fitted: &[Vec<Vec<f64>>],
    deviations: impl FnOnce() -> Vec<Vec<Vec<f64>>>,
) {
    let deviations = LazyCell::new(deviations);
    let mut notes: Vec<String> = Vec::new();
    for output in 0..experiment.outputs.len() {
        let channel = experiment.outputs[output];
        let mut pairs: Vec<Pair> =
            (0..experiment.runs.len()).map(|run| pair(experiment, &predicted[run], run, output)).collect();
        let size =
            pairs.iter().map(|p| p.model.iter().fold(0.0, |m: f64, x| m.max(x.abs()))).fold(0.0, f64::max);
        let ratios = pairs.iter().flat_map(|p| p.read.iter().zip(&p.model));
        let ratio = median(ratios.filter(|(_, m)| m.abs() > MOVES * size).map(|(y, m)| y / m));
        let ratio = if ratio.is_finite() { ratio.clamp(0.3, 3.0) } else { 1.0 };
        pairs.iter_mut().flat_map(|p| &mut p.model).for_each(|m| *m *= ratio);
        let moves = pairs.iter().map(|p| spread(&p.model)).fold(0.0, f64::max);
        let off =
            |p: &Pair| -> Vec<f64> { p.read.iter().zip(&p.model).map(|(y, m)| (y - m).abs()).collect() };
        for (run, own) in pairs.iter().enumerate() {
            if own.rows.len() < ENOUGH {
                continue;
            }
            let first = experiment.inputs.len() + output;
            let table = &experiment.runs[run].table;
            let column: Vec<f64> = own.rows.iter().map(|row| table.columns[first][*row]).collect();
            let time: Vec<f64> = own.rows.iter().map(|row| table.time[*row]).collect();
            let sigma = noise::of_column(&time, &column).unwrap_or(0.0);
            let doubt = |rows: &[usize]| {
                let of = |row: &usize| deviations[run].get(output).map_or(0.0, |all| all[*row].powi(2));
                (rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64).sqrt()
            };
            let judge = Judge { channel, own, column: &column, sigma, moves, doubt: &doubt };
            let Some((mut bad, why)) = judge.bad() else { continue };
            let of_fit = pair(experiment, &fitted[run], run, output);
            if of_fit.rows == own.rows {
                let moves = spread(&of_fit.model).max(moves);
                let fit = Judge { own: &of_fit, moves, ..judge };
                let Some((also, _)) = fit.bad() else { continue };
                bad.iter_mut().zip(also).for_each(|(bad, also)| *bad &= also);
                if !bad.contains(&true) {
                    // A jump that neither predicts: they only disagree on the side which is wrong.
                    fit.moved().into_iter().for_each(|k| bad[k] = true);
                }
                if !bad.contains(&true) {
                    continue;
                }
            }
            // What is left of the best there is: the other runs, and what of this one is not bad.
            let good = pairs.iter().enumerate().filter(|(k, _)| *k != run).flat_map(|(_, p)| off(p));
            let kept = off(own).into_iter().zip(&bad).filter(|(_, bad)| !**bad).map(|(x, _)| x);
            let usual = sorted(good.chain(kept));
            let usual = usual.get(usual.len() * 3 / 4).copied().unwrap_or(0.0);
            let jumps = if channel.is_temperature() { super::signals::jumps(&column) } else { Vec::new() };
            widen(&mut bad, &off(own), usual.max(4.0 * sigma), &jumps);
            let count = bad.iter().filter(|bad| **bad).count();
            let file = experiment.runs[run].file.clone();
            let column = &mut experiment.runs[run].table.columns[first];
            let note = if count as f64 > WHOLE * own.rows.len() as f64 {
                column.fill(f64::NAN);
                format!("{file}: {} {why}; it is set aside in this run", channel.column)
            } else {
                let at = |k: Option<usize>| k.map_or(f64::NAN, |k| time[k]);
                let (from, to) = (at(bad.iter().position(|b| *b)), at(bad.iter().rposition(|b| *b)));
                own.rows
                    .iter()
                    .zip(&bad)
                    .filter(|(_, bad)| **bad)
                    .for_each(|(row, _)| column[*row] = f64::NAN);
                format!(
                    "{file}: {} {why}; {count} readings from {from} s to {to} s are set aside",
                    channel.column
                )
            };
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    experiment.notes.extend(notes);
}

/// Grows what is bad as far as the reading is away from the prediction by more than usual, with a margin. It ends at a jump: there the
/// sensor began or ceased to work.
fn widen(bad: &mut [bool], off: &[f64], usual: f64, jumps: &[usize]) {
    const MARGIN: usize = 5;
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
            let end = (k + MARGIN + 1).min(bad.len());
            bad[k.saturating_sub(MARGIN)..end].fill(true);
        }
    }
}

/// What is asked of one output in one run.
struct Judge<'a> {
    channel: &'static Channel,
    own: &'a Pair,
    column: &'a [f64],
    sigma: f64,
    moves: f64,
    /// Standard deviation of the prediction that the priors leave, over some rows.
    doubt: &'a dyn Fn(&[usize]) -> f64,
}

impl Judge<'_> {
    /// Readings that fail, and how; `None` where none does.
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
        mark(self.unmoved(), "does not follow what drives it, as a dead or detached sensor does");
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
        let least = (STEPS * resolution.max(self.sigma)).max(0.05 * self.moves);
        let long = |(a, b): &(usize, usize)| {
            // Where all readings are one, their usual number is no measure.
            let held = if stretches.len() > 2 { 4.0 * usual } else { 0.0 };
            let count = b - a + 1;
            let span = self.own.model[*a..=*b]
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
            count >= LEAST_ROWS && count as f64 > held && span.1 - span.0 > least
        };
        stretches.iter().filter(|s| long(s)).flat_map(|(a, b)| *a..=*b).collect()
    }

    /// Stretches between jumps that lie further from the prediction than the best one by far. Where none does, all but the longest
    /// one between jumps that the model does not predict: a sensor that has moved reads something else on either side.
    fn jumped(&self) -> Vec<usize> {
        let jumps = super::signals::jumps(self.column);
        if jumps.is_empty() {
            return Vec::new();
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
        let least = (3.0 * best).max(0.1 * self.moves).max(CLEAR * self.sigma);
        let far: Vec<usize> = parts.into_iter().filter(|p| off(*p) > least).flat_map(|(a, b)| a..b).collect();
        if far.is_empty() { self.moved() } else { far }
    }

    /// All readings but those of the longest stretch between jumps that are no change of the prediction, and of stretches at its level.
    fn moved(&self) -> Vec<usize> {
        if !self.channel.is_temperature() {
            return Vec::new();
        }
        let jumps = super::signals::jumps(self.column);
        let change = |of: &[f64], k: usize| of[k] - of[k - 1];
        let sizes = jumps.iter().map(|k| (*k, change(&self.own.read, *k), change(&self.own.model, *k)));
        let own: Vec<(usize, f64)> = sizes
            .filter(|(_, read, model)| (read - model).abs() > UNPREDICTED * read.abs())
            .map(|(k, read, model)| (k, read - model))
            .collect();
        let least = own.iter().map(|(_, size)| size.abs()).fold(f64::INFINITY, f64::min);
        // Stretches with the sum of the jumps before each.
        let mut parts = vec![(0..self.column.len(), 0.0)];
        for (k, size) in own {
            let Some((last, level)) = parts.last_mut() else { break };
            let next = (k..last.end, *level + size);
            last.end = k;
            parts.push(next);
        }
        let longest = parts.iter().max_by_key(|(part, _)| part.len()).map_or(0.0, |(_, level)| *level);
        let elsewhere = parts.into_iter().filter(|(_, level)| (level - longest).abs() > 0.5 * least);
        elsewhere.flat_map(|(part, _)| part).collect()
    }

    /// (1)
    fn off_level(&self) -> Vec<usize> {
        let most = self.own.model.iter().fold(0.0, |m: f64, x| m.max(*x));
        let least = (0.2 * most).max(5.0).max(CLEAR * self.sigma);
        let tells: Vec<usize> = (0..self.column.len()).filter(|k| self.own.model[*k] > least).collect();
        let fails = |k: &usize| {
            let (read, model) = (self.own.read[*k], self.own.model[*k]);
            !(LEVEL.0..=LEVEL.1).contains(&(read / model)) && (read - model).abs() > FAR
        };
        // Cold, a sensor that reads beyond all that the run makes of it.
        let far = |k: &usize| (self.own.read[*k] - self.own.model[*k]).abs() > self.moves.max(25.0);
        let failing: Vec<usize> = tells.iter().copied().filter(fails).collect();
        let mut all: Vec<usize> = (0..self.column.len()).filter(far).collect();
        if failing.len() >= LEAST_ROWS {
            all.extend(&failing);
            // What has come off does not come on again, unless it follows again.
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
                if moved <= (MOVES * self.moves).max(CLEAR * self.sigma) || moved <= 1e-9 {
                    continue;
                }
                let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
                let (a, b) = (mean(&self.own.read[part.clone()]), mean(model));
                let (mut both, mut own) = (0.0, 0.0);
                for (y, m) in self.own.read[part.clone()].iter().zip(model) {
                    both += (y - a) * (m - b);
                    own += (m - b).powi(2);
                }
                let moves = spread(&self.own.read[part.clone()]);
                let is_still = (both / own).abs() < SLOPE && moves < 3.0 * SLOPE * moved + CLEAR * self.sigma;
                // What the priors leave open may be all of the movement: a current as the small difference of two voltages.
                if is_still && moved > CERTAIN * (self.doubt)(&self.own.rows[part.clone()]) {
                    all.extend(part);
                }
            }
        }
        all
    }
}

/// An input that is constant although it is noisy elsewhere, while an output that it drives moves away from the prediction.
pub fn dead_input(experiment: &Experiment, predicted: &[Vec<Vec<f64>>]) -> Option<Unusable> {
    const AWAY: f64 = 0.1;
    for (k, channel) in experiment.inputs.iter().enumerate() {
        let same = |w: &[f64]| w[0] == w[1];
        let pairs = || experiment.runs.iter().flat_map(|r| r.table.columns[k].windows(2));
        let (still, count) = (pairs().filter(|w| same(w)).count(), pairs().count());
        if count == 0 || still as f64 > 0.5 * count as f64 {
            continue;
        }
        for (r, run) in experiment.runs.iter().enumerate() {
            let column = &run.table.columns[k];
            let Some((from, to)) = longest(column).filter(|(a, b)| b - a >= LEAST_ROWS) else { continue };
            for output in 0..experiment.outputs.len() {
                let own = pair(experiment, &predicted[r], r, output);
                let size = spread(&own.model).max(spread(&own.read));
                let off = |inside: bool| {
                    let rows =
                        own.rows.iter().enumerate().filter(|(_, row)| (from..=to).contains(*row) == inside);
                    let all = sorted(rows.map(|(j, _)| (own.read[j] - own.model[j]).abs()));
                    all.get(all.len() * 3 / 4).copied().unwrap_or(f64::NAN)
                };
                let elsewhere = if off(false).is_finite() { off(false) } else { 0.0 };
                if size > 0.0
                    && off(true) > AWAY * size
                    && off(true) > 5.0 * elsewhere
                    && run.role != Role::Test
                {
                    let (a, b) = (run.table.time[from], run.table.time[to]);
                    let other = experiment.outputs[output].column;
                    return Some(Unusable {
                        channel: channel.column.to_string(),
                        reason: format!(
                            "{} in {} stands at {} from {a} s to {b} s, although it varies elsewhere, and {other} does not agree with that",
                            channel.column,
                            run.file,
                            column[from] - channel.offset
                        ),
                        suggestion: "leave the run out, or end its window before the sensor failed"
                            .to_string(),
                    });
                }
            }
        }
    }
    None
}

/// The longest stretch of one and the same reading.
fn longest(column: &[f64]) -> Option<(usize, usize)> {
    let (mut best, mut from) = (None, 0);
    for k in 0..column.len() {
        if column[k] != column[from] {
            from = k;
        }
        if best.is_none_or(|(a, b)| k - from > b - a) {
            best = Some((from, k));
        }
    }
    best
}
