//! Two thermometers whose plugs are exchanged in a part of a run: from a row on, up to a row, or in between, once or several times.
//!
//! ```text
//! D_k = y_a - y_b,   d_k = p_a - p_b,   x_k = D_k - o                                               (1)
//! recorded:  x = c d,   exchanged:  x = -c d,   E_k = -2 c d x / (s^2 + L g^2)                      (2)
//! at a row:  J_k = -2 (D- - o) (D+ - o) / s_D^2                                                     (3)
//! in a section:  y_a = u d + ...,  y_b = v d + ...;   recorded |v| < f u,   exchanged |u| < f v     (4)
//! ```
//! y readings of two thermometers a and b, p predictions of the preset; o zero and c factor of the difference in the run, from a linear
//! regression; s noise of D, g structure error of c d, L rows of an independent reading; E the log-likelihood ratio of a row that is
//! exchanged. D- and D+ are the ends of lines through the rows before and after a row, s_D the standard deviation of their sum: (3) is the
//! log-likelihood ratio of the channels continuing each other against continuing themselves. The sections are those with the greatest sum
//! of (2) and (3), by dynamic programming.
//!
//! o and c are unknown at first. A first estimate of the sections compares D and d without their moving averages, and thus without o; if it
//! finds none, another one has o = 0 and c = 1.
//!
//! A section counts if the sum of (2) over it is clear, and if (3) shows one of its ends, where both channels continue the other one and
//! differ about as predicted, or if (4) does: a linear regression of each channel in the section on d and p_b, all without their moving
//! averages over the time of an independent reading, so that slow errors of the model cancel; the variances of u and v are those of the
//! jackknife over blocks of this time. Plugs are often exchanged at rest, where both temperatures are equal and (3) shows nothing. A
//! thermometer that comes off, and a law of a sensor, change one of the two only. A run that is exchanged as a whole is a contradiction
//! (`consistency.rs`).
//!
//! *Sources*: Viterbi, IEEE Trans. Inf. Theory 13 (1967) 260-269; parity equation of two redundant sensors: Isermann, Fault-Diagnosis Systems
//! (2006), ch. 10; jackknife by blocks: Kuensch, Ann. Stat. 17 (1989) 1217-1241.

use super::response::{ENOUGH, LEAST_ROWS, LEVEL};
use super::signals::{ALIKE, NEAR, WIDEST};
use super::{Predicted, Unusable, all_runs, median, predicted, signals};
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment};
use crate::levels::{CERTAIN, DECISIVE, FACTOR, LEAD, PART, SAMPLES, SMALL};
use crate::noise;
use crate::report::count_of;

/// Iterations of zero, factor and sections. Numerical: sections of a run are unchanged after two.
const ITERATIONS: usize = 3;
/// Longest interval, in usual ones, that is no gap. Definition: [`WIDEST`] missing rows; less than a further one is uneven sampling.
const MISSING: usize = WIDEST + 2;
/// Least sum of (2) over a section that decides whether it is exchanged. Derivation: half the square of [`CERTAIN`], the log-likelihood of a
/// deviation by as much.
const DECIDED: f64 = 0.5 * CERTAIN * CERTAIN;
/// Fraction of a regressor that the others leave, below which it is none. Numerical: rounding of a difference in double precision.
const DEPENDENT: f64 = 1e-6;

/// Sets aside the readings of both thermometers where they are exchanged, with notes. Where an ambient temperature is one of the two, the
/// model was driven by a temperature of the motor, and the data are unusable.
pub fn set_aside(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Option<Unusable> {
    // Readings of an open plug, or spikes, hide an exchange; exchanges that are repeated are faults to a check of single thermometers.
    let mut clean = experiment.clone();
    signals::set_aside(&mut clean);
    let outputs: Vec<usize> = clean.thermometers().iter().map(|k| clean.place_of(*k)).collect();
    if let Some(ambient) = clean.inputs.iter().position(|c| c.is_ambient()) {
        // Where it is exchanged, it is not the temperature of the air.
        let mut driven = clean.clone();
        for run in &mut driven.runs {
            let column = &mut run.table.columns[ambient];
            let first = median(column.iter().copied().filter(|x| x.is_finite()).take(NEAR));
            column.fill(first);
        }
        let pairs: Vec<(usize, usize)> = outputs.iter().map(|own| (*own, ambient)).collect();
        let model = predicted(&driven, preset, &all_runs(&driven), deadline);
        let unusable = in_pairs(experiment, &clean, (&driven, &model), &pairs);
        if unusable.is_some() {
            return unusable;
        }
    }
    let others = |n: usize| outputs[n + 1..].iter().map(move |other| (n, *other));
    let pairs = (0..outputs.len()).flat_map(others).map(|(n, other)| (outputs[n], other));
    let pairs: Vec<(usize, usize)> = pairs.collect();
    if pairs.is_empty() {
        return None;
    }
    let model = predicted(&clean, preset, &all_runs(&clean), deadline);
    in_pairs(experiment, &clean, (&clean, &model), &pairs)
}

/// [`set_aside`] for pairs of columns in data without spikes; `driven` are the data that the model is driven by.
fn in_pairs(
    experiment: &mut Experiment,
    clean: &Experiment,
    (driven, model): (&Experiment, &Predicted),
    pairs: &[(usize, usize)],
) -> Option<Unusable> {
    for (run, model) in model.iter().enumerate() {
        let shown = |place: usize| match place.checked_sub(clean.inputs.len()) {
            Some(output) => model.get(output),
            None => Some(&driven.runs[run].table.columns[place]),
        };
        for (own, other) in pairs.iter().copied() {
            let Some((p, q)) = shown(own).zip(shown(other)) else { continue };
            let Some(course) = Course::of(clean, run, (own, other), (p, q)) else { continue };
            let found = course.exchanged();
            if !found.is_empty()
                && let Some(unusable) = blank(experiment, run, (own, other), &found)
            {
                return Some(unusable);
            }
        }
    }
    None
}

fn channel(experiment: &Experiment, place: usize) -> &'static Channel {
    let inputs = experiment.inputs.len();
    if place < inputs { experiment.inputs[place] } else { experiment.outputs[place - inputs] }
}

/// Sets aside two outputs in some sections of a run, with a note; the reason why this is impossible for an input.
fn blank(
    experiment: &mut Experiment,
    run: usize,
    (own, other): (usize, usize),
    sections: &[(usize, usize)],
) -> Option<Unusable> {
    let [a, b] = [own, other].map(|k| channel(experiment, k).column);
    let is_input = other < experiment.inputs.len();
    let run = &mut experiment.runs[run];
    let what = format!(
        "{a} and {b} seem to be exchanged {}: each continues the readings of the other one, or follows its prediction",
        words(&run.table.time, sections)
    );
    if is_input {
        return Some(Unusable::new(
            b,
            format!("{}: {what}", run.file),
            "exchange the readings of the two columns in these rows, or leave the rows out with window_s",
        ));
    }
    for place in [own, other] {
        sections.iter().for_each(|(from, to)| run.table.columns[place][*from..*to].fill(f64::NAN));
    }
    let rows: usize = sections.iter().map(|(from, to)| to - from).sum();
    let note =
        format!("{}: {what}; the readings of both are set aside in {}", run.file, count_of(rows, "row"));
    if !experiment.notes.contains(&note) {
        experiment.notes.push(note);
    }
    None
}

/// Sections of rows in words.
fn words(time: &[f64], sections: &[(usize, usize)]) -> String {
    let of = |(from, to): &(usize, usize)| {
        let first = if *from == 0 { "the start".to_string() } else { format!("{} s", time[*from]) };
        let last = if *to == time.len() { "the end".to_string() } else { format!("{} s", time[to - 1]) };
        format!("from {first} to {last}")
    };
    sections.iter().map(of).collect::<Vec<_>>().join(" and ")
}

/// Rows of a section, and whether they are exchanged.
#[derive(Clone, Debug, PartialEq)]
struct Section {
    from: usize,
    to: usize,
    is_exchanged: bool,
}

impl Section {
    /// Log-likelihood ratio of its state against the other one.
    fn evidence(&self, evidence: &[f64]) -> f64 {
        evidence[self.from..self.to].iter().sum::<f64>() * sign(!self.is_exchanged)
    }
}

/// Differences of two thermometers from both sides at a row.
struct Joint {
    /// D- and D+.
    ends: [f64; 2],
    /// s_D^2.
    variance: f64,
    /// Whether both channels continue the other one.
    is_seen: bool,
}

impl Joint {
    /// (3) without a zero of the difference; 0 if that is unknown and matters.
    fn ratio(&self, zero: Option<f64>) -> f64 {
        let of = |zero: f64| -2.0 * (self.ends[0] - zero) * (self.ends[1] - zero);
        let product = match zero {
            Some(zero) => of(zero),
            None if self.is_seen => of(0.0),
            None => 0.0,
        };
        product / self.variance.max(f64::MIN_POSITIVE)
    }
}

/// Two thermometers in the rows of a run in which both have a reading and a prediction.
struct Course {
    /// Rows in the table.
    rows: Vec<usize>,
    /// Rows of the table.
    length: usize,
    time: Vec<f64>,
    read: [Vec<f64>; 2],
    /// The prediction of the second one.
    other: Vec<f64>,
    /// d of (1).
    expected: Vec<f64>,
    /// Variance of the noise of each thermometer.
    noise: [f64; 2],
    /// For each row and the one before it.
    joints: Vec<Joint>,
}

impl Course {
    fn of(
        experiment: &Experiment,
        run: usize,
        (own, other): (usize, usize),
        (p, q): (&[f64], &[f64]),
    ) -> Option<Course> {
        let table = &experiment.runs[run].table;
        let (a, b) = (&table.columns[own], &table.columns[other]);
        let length = table.time.len();
        let rows: Vec<usize> =
            (0..length).filter(|row| (a[*row] + b[*row] + p[*row] + q[*row]).is_finite()).collect();
        if rows.len() < ENOUGH {
            return None;
        }
        let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let (time, read) = (pick(&table.time), [pick(a), pick(b)]);
        let noise = [(0, own), (1, other)].map(|(k, place)| {
            let sigma = noise::of_column(&time, &read[k]).unwrap_or(0.0);
            sigma.max(noise::quantised(experiment, place, channel(experiment, place))).powi(2)
        });
        let expected = rows.iter().map(|row| p[*row] - q[*row]).collect();
        let other = pick(q);
        let mut course = Course { rows, length, time, read, other, expected, noise, joints: Vec::new() };
        course.joints = (0..course.rows.len()).map(|k| course.joint(k)).collect();
        Some(course)
    }

    fn difference(&self, k: usize) -> f64 {
        self.read[0][k] - self.read[1][k]
    }

    /// (3) between a row and the one before. Up to [`WIDEST`] rows after it may be wrong, and short lines end before a step of the load.
    fn joint(&self, k: usize) -> Joint {
        let of = |(rows, skip): (usize, usize)| self.joint_over(k, rows, skip);
        let all = [(NEAR, 0), (WIDEST, 0), (NEAR, WIDEST), (WIDEST, WIDEST)];
        all.into_iter().map(of).find(|joint| joint.is_seen).unwrap_or_else(|| of(all[0]))
    }

    fn joint_over(&self, k: usize, rows: usize, skip: usize) -> Joint {
        let unknown = Joint { ends: [0.0; 2], variance: 1.0, is_seen: false };
        let next = k + skip;
        if k < rows || next + rows > self.rows.len() {
            return unknown;
        }
        let intervals = || self.time[k - rows..next + rows].windows(2).map(|w| w[1] - w[0]);
        // What happens in a gap is not seen from its ends.
        let longest = intervals().fold(0.0, f64::max);
        if longest > MISSING as f64 * median(intervals()) {
            return unknown;
        }
        let at = 0.5 * (self.time[k - 1] + self.time[next]);
        let mut ends = [[0.0; 2]; 2];
        let mut variance = 0.0;
        for ((read, noise), end) in self.read.iter().zip(self.noise).zip(&mut ends) {
            for (side, part) in [k - rows..k, next..next + rows].into_iter().enumerate() {
                let (value, square, lever) = line(&self.time[part.clone()], &read[part], at);
                end[side] = value;
                variance += square.max(noise) * lever;
            }
        }
        let [[a, after_a], [b, after_b]] = ends;
        let continues =
            |other: f64, own: f64, after: f64| (after - other).abs() < ALIKE * (after - own).abs();
        let mut joint = Joint { ends: [a - b, after_a - after_b], variance, is_seen: false };
        joint.is_seen = joint.ratio(Some(0.0)) > LEAD && continues(b, a, after_a) && continues(a, b, after_b);
        joint
    }

    /// Rows of the table in which the two are exchanged: first row, and the one after the last.
    fn exchanged(&self) -> Vec<(usize, usize)> {
        let n = self.rows.len();
        let difference: Vec<f64> = (0..n).map(|k| self.difference(k)).collect();
        // The changes of the load need no zero, and a constant load needs no changes.
        let fast = |column: &[f64]| fast(column, self.side());
        let starts = [
            (self.evidence(&fast(&self.expected), &fast(&difference)), None),
            (self.evidence(&self.expected, &difference), Some(0.0)),
        ];
        let sections = starts.iter().map(|start| self.sections(start, &difference));
        let sections = sections.into_iter().find(|sections| sections.len() > 1).unwrap_or_default();
        let first = |k: usize| if k == 0 { 0 } else { self.rows[k - 1] + 1 };
        let last = |k: usize| if k == n { self.length } else { self.rows[k] };
        sections.iter().filter(|s| s.is_exchanged).map(|s| (first(s.from), last(s.to))).collect()
    }

    /// The sections from those that a first estimate of (2) leads to; none if they are not sure.
    fn sections(&self, start: &(Vec<f64>, Option<f64>), difference: &[f64]) -> Vec<Section> {
        let (mut evidence, mut known) = start.clone();
        let mut factor = 1.0;
        let mut sections = Vec::new();
        for _ in 0..ITERATIONS {
            sections = self.most_likely(&evidence, known);
            let (zero, slope) = self.scale(&sections);
            (known, factor) = (Some(zero), slope);
            if sections.len() < 2 || !(LEVEL.0..=LEVEL.1).contains(&factor) {
                return Vec::new();
            }
            let expected: Vec<f64> = self.expected.iter().map(|d| factor * d).collect();
            let off: Vec<f64> = difference.iter().map(|x| x - zero).collect();
            evidence = self.evidence(&expected, &off);
        }
        self.confirm(&mut sections, &evidence, (known.unwrap_or_default(), factor));
        sections
    }

    /// Rows of an independent reading.
    fn side(&self) -> usize {
        (self.rows.len() as f64 / SAMPLES) as usize
    }

    /// (2) for c d and x.
    fn evidence(&self, expected: &[f64], off: &[f64]) -> Vec<f64> {
        let square = product(expected, expected) / expected.len() as f64;
        let white = self.noise[0] + self.noise[1];
        let dependent = self.side().max(1) as f64;
        let of = |(d, x): (&f64, &f64)| {
            let structure = (PART * d).powi(2) + SMALL * SMALL * square;
            -2.0 * d * x / (white + dependent * structure).max(f64::MIN_POSITIVE)
        };
        expected.iter().zip(off).map(of).collect()
    }

    /// The sections with the greatest sum of (2) and (3).
    fn most_likely(&self, evidence: &[f64], zero: Option<f64>) -> Vec<Section> {
        let n = evidence.len();
        // Greatest sum up to a row, as recorded and exchanged, and whether the state changes before the row.
        let (mut best, mut changes) = ([0.0, evidence[0]], vec![[false; 2]; n]);
        for k in 1..n {
            // A joint that is seen costs nothing; one that contradicts the readings may be hidden by a step of the load.
            let change = self.joints[k].ratio(zero).clamp(-DECISIVE, LEAD) - LEAD;
            let next = [0, 1].map(|state| {
                let other = best[1 - state] + change;
                changes[k][state] = other > best[state];
                best[state].max(other) + if state == 1 { evidence[k] } else { 0.0 }
            });
            best = next;
        }
        let mut state = usize::from(best[1] > best[0]);
        let mut sections: Vec<Section> = vec![Section { from: 0, to: n, is_exchanged: state == 1 }];
        for k in (1..n).rev().filter(|k| *k > 0) {
            if changes[k][state] {
                state = 1 - state;
                if let Some(later) = sections.last_mut() {
                    later.from = k;
                }
                sections.push(Section { from: 0, to: k, is_exchanged: state == 1 });
            }
        }
        sections.reverse();
        sections
    }

    /// Zero and factor of the difference: a linear regression on its prediction in these sections.
    fn scale(&self, sections: &[Section]) -> (f64, f64) {
        let rows = || sections.iter().flat_map(|s| (s.from..s.to).map(|k| (k, sign(s.is_exchanged))));
        let n = self.rows.len() as f64;
        let mean = |of: &dyn Fn(usize, f64) -> f64| rows().map(|(k, sign)| of(k, sign)).sum::<f64>() / n;
        let d = |k: usize, sign: f64| sign * self.expected[k];
        let (x, y) = (mean(&d), mean(&|k, _| self.difference(k)));
        let both = mean(&|k, s| (d(k, s) - x) * (self.difference(k) - y));
        let factor = both / mean(&|k, s| (d(k, s) - x).powi(2));
        (y - factor * x, factor)
    }

    /// Joins sections to their neighbours, the shortest first: those that neither (3) nor (4) shows, or that the prediction does not decide.
    fn confirm(&self, sections: &mut Vec<Section>, evidence: &[f64], (zero, factor): (f64, f64)) {
        while sections.len() > 1 {
            let doubtful = |s: &&Section| {
                let is_shown = || {
                    self.shows(s, factor) == Some(s.is_exchanged)
                        || self.is_seen(s.from, s.is_exchanged, (zero, factor))
                        || self.is_seen(s.to, !s.is_exchanged, (zero, factor))
                };
                s.evidence(evidence) < DECIDED || !is_shown()
            };
            let Some(shortest) = sections.iter().filter(doubtful).min_by_key(|s| s.to - s.from).cloned()
            else {
                return;
            };
            let mut joined: Vec<Section> = Vec::new();
            for section in sections.drain(..) {
                let is_exchanged = section.is_exchanged != (section == shortest);
                match joined.last_mut() {
                    Some(last) if last.is_exchanged == is_exchanged => last.to = section.to,
                    _ => joined.push(Section { is_exchanged, ..section }),
                }
            }
            *sections = joined;
        }
    }

    /// Whether the joint before a row shows an exchange, to this state, of about the difference that is predicted: the line through the rows
    /// before a step of the load may miss those after it.
    fn is_seen(&self, k: usize, is_exchanged: bool, (zero, factor): (f64, f64)) -> bool {
        let Some(joint) = self.joints.get(k).filter(|joint| joint.is_seen) else { return false };
        let sides = [(k.saturating_sub(WIDEST)..k, !is_exchanged), (k..k + WIDEST, is_exchanged)];
        sides.into_iter().zip(joint.ends).all(|((rows, is_exchanged), end)| {
            let expected = sign(is_exchanged) * factor * median(rows.map(|k| self.expected[k]));
            (1.0 / FACTOR..=FACTOR).contains(&((end - zero) / expected))
        })
    }

    /// (4): whether a section is exchanged; `None` if it cannot be decided.
    fn shows(&self, section: &Section, factor: f64) -> Option<bool> {
        let rows = section.from..section.to;
        if rows.len() < LEAST_ROWS {
            return None;
        }
        let side = self.side();
        let fast = |column: &[f64]| fast(&column[rows.clone()], side);
        let (all, other) = (fast(&self.expected), fast(&self.other));
        let d = without(&all, &other);
        let size = product(&d, &d);
        if size <= DEPENDENT * product(&all, &all) {
            return None;
        }
        let [(u, of_u), (v, of_v)] = [0, 1].map(|k| {
            let read = without(&fast(&self.read[k]), &other);
            let slope = product(&read, &d) / size;
            let off: Vec<f64> = read.iter().zip(&d).map(|(y, d)| y - slope * d).collect();
            // A block with nearly all of the variation, such as the only step of the load in a section, proves nothing alone.
            let moves = off.chunks(side + 1).zip(d.chunks(side + 1));
            let moves = moves.map(|(off, d)| product(off, d) / (size - product(d, d)).max(f64::MIN_POSITIVE));
            let white = product(&off, &off) / (rows.len() as f64 * size);
            let variance = moves.map(|x| x * x).sum::<f64>().max(white);
            (slope, variance)
        });
        let least = CERTAIN * (of_u + of_v).sqrt();
        let is = |own: f64, other: f64| {
            let is_like = (factor / FACTOR..=factor * FACTOR).contains(&own);
            is_like && own - other > least && other.abs() < PART * own
        };
        if is(v, u) { Some(true) } else { is(u, v).then_some(false) }
    }
}

/// 1 as recorded, -1 exchanged.
fn sign(is_exchanged: bool) -> f64 {
    if is_exchanged { -1.0 } else { 1.0 }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// What a regressor leaves of a column.
fn without(column: &[f64], other: &[f64]) -> Vec<f64> {
    let part = product(column, other) / product(other, other).max(f64::MIN_POSITIVE);
    column.iter().zip(other).map(|(x, y)| x - part * y).collect()
}

/// A column without its means over this number of rows on either side.
fn fast(column: &[f64], side: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    column.iter().for_each(|x| sums.push(sums[sums.len() - 1] + x));
    let of = |k: usize| {
        let (from, to) = (k.saturating_sub(side), (k + side + 1).min(column.len()));
        column[k] - (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..column.len()).map(of).collect()
}

/// The line through some readings at a time: its value, the mean square of the deviations, and the variance of the value relative to that.
fn line(time: &[f64], read: &[f64], at: f64) -> (f64, f64, f64) {
    let n = time.len() as f64;
    let (t, y) = (time.iter().sum::<f64>() / n, read.iter().sum::<f64>() / n);
    let span: f64 = time.iter().map(|x| (x - t).powi(2)).sum();
    let slope = time.iter().zip(read).map(|(x, z)| (x - t) * (z - y)).sum::<f64>() / span;
    let square = time.iter().zip(read).map(|(x, z)| (z - y - slope * (x - t)).powi(2)).sum::<f64>();
    (y + slope * (at - t), square / (n - 2.0), 1.0 / n + (at - t).powi(2) / span)
}

#[cfg(test)]
mod tests;
