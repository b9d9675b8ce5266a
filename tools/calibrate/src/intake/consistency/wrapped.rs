//! Readings that fold over at the end of an integer type, of a counter or of an angle: 343 rad/s is followed by -343 rad/s.
//!
//! x* = (1 + a) (x + n W) + b,   n = round((x* - x) / W)                                            (1)
//! x* - x = b + a x + sum_k c_k u_k,   a = 0 of an output                                           (2)
//!
//! x is a reading and x* what the model implies: the prediction of an output; of an input, the value with which an output is predicted as it
//! was read (Newton's method, one step). W is the span of the numbers that the channel can show, from 0 or from -W/2 on; the readings use a
//! large part of it, and what is folded is beyond it. (2) is a factor, a sign or a zero of the channel or of another input u_k; it leaves more than (1).
//!
//! *Source*: phase unwrapping, Itoh, Applied Optics 21 (1982) 2470; here the model takes the place of the previous reading, so that steps
//! may be greater than half of the span.

use super::unmeasured::{cold, slopes};
use super::{Judge, Predicted, ROUNDING, files};
use crate::comparison::converted;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment};
use crate::intake::{Unusable, all_runs, deviation, ends, median};
use crate::levels::{FACTOR, SMALL, STRUCTURE};
use nalgebra::{DMatrix, DVector};
use physics::declare::Unit;

/// Fewest rows that are beyond the end. Derivation: three times as many as the numbers of (1).
const FEWEST: usize = 10;
/// Part of the span beyond which a deviation is a fold, and that the readings use at least. Definition: rounding in (1).
const HALF: f64 = 0.5;

/// The channel whose readings fold over in a file.
pub fn found(experiment: &Experiment, preset: &[(u32, f64)], deadline: &Deadline) -> Option<Unusable> {
    let all = all_runs(experiment);
    files(experiment).into_iter().find_map(|(file, runs)| {
        let judge = Judge { runs: &runs, ..Judge::of(preset, &all, deadline) };
        let (channel, span) = in_file(&judge, experiment)?;
        let (name, unit) = (channel.column, channel.unit.name());
        Some(Unusable::new(
            name,
            format!(
                "{name} in {file} wraps around: readings beyond the end of the range of its numbers are off by {} {unit}, and agree with the \
                 model if that is added or subtracted",
                converted(span)
            ),
            format!(
                "record {name} with a wider integer type or a counter that counts its overflows, or unwrap the readings by this span"
            ),
        ))
    })
}

/// The folded channel of the judge's runs, and its span, SI units. A folded channel makes others deviate that are right; its own readings
/// become smoother than theirs.
fn in_file(judge: &Judge, experiment: &Experiment) -> Option<(&'static Channel, f64)> {
    // A load that folds may overheat the model.
    let warm = judge.predicted(experiment);
    let is_run = warm.iter().flatten().flatten().all(|p| p.is_finite());
    let predict = |data: &Experiment| if is_run { judge.predicted(data) } else { cold(judge, data) };
    let predicted = if is_run { warm } else { cold(judge, experiment) };
    // A model that cannot be set up predicts nothing.
    if predicted.iter().any(Vec::is_empty) {
        return None;
    }
    // Reading less prediction by an output's run and row, each divided by what belongs to the run and the row.
    let deviations = |k: usize, by: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        let of = |(n, run): (usize, &usize)| -> Vec<f64> {
            let own = deviation(experiment, &predicted[n], k, *run).into_iter().enumerate();
            own.map(|(row, off)| off / by(n, row)).collect()
        };
        judge.runs.iter().enumerate().map(of).collect()
    };
    let mut folds: Vec<(&'static Channel, Fold)> = Vec::new();
    for (column, channel) in experiment.inputs.iter().enumerate().filter(|(_, channel)| is_load(channel)) {
        if judge.deadline.is_near() {
            return None;
        }
        let slopes = slopes(judge, experiment, (&predicted, &predict), column)?;
        for by in (0..experiment.outputs.len()).filter(|k| !experiment.outputs[*k].is_temperature()) {
            let off = deviations(by, &|n, row| slopes[n][by][row]);
            let Some(fold) = fold(judge, experiment, column, &off) else { continue };
            let after = predict(&fold.unfolded);
            if confirms(judge, experiment, (column, &fold.unfolded), [&predicted, &after]) {
                folds.push((*channel, fold));
            }
        }
    }
    // Other mistakes of an input make a smooth output deviate in some rows.
    let outputs = experiment.outputs.iter().enumerate().filter_map(|(k, channel)| {
        let fold = fold(judge, experiment, experiment.place_of(k), &deviations(k, &|_, _| -1.0))?;
        (fold.roughness < FACTOR).then_some((*channel, fold))
    });
    let (channel, fold) =
        folds.into_iter().chain(outputs).min_by(|(_, a), (_, b)| a.roughness.total_cmp(&b.roughness))?;
    Some((channel, fold.span))
}

/// A fold of a column.
struct Fold {
    /// SI units.
    span: f64,
    unfolded: Experiment,
    /// Sum of the squared differences of successive readings after unfolding, relative to that before.
    roughness: f64,
}

/// Whether an input is one that outputs follow at once.
fn is_load(channel: &Channel) -> bool {
    !channel.is_temperature() && !matches!(channel.unit, Unit::One | Unit::Pascal)
}

/// Whether the unfolded rows of an input confirm it: no output that follows the input at once deviates more there, and one far less.
fn confirms(
    judge: &Judge,
    experiment: &Experiment,
    (column, unfolded): (usize, &Experiment),
    [before, after]: [&Predicted; 2],
) -> bool {
    let of = |output: usize, shown: &Predicted| -> f64 {
        let squares = judge.runs.iter().zip(shown).flat_map(|(run, shown)| {
            let [folded, own] = [experiment, unfolded].map(|data| &data.runs[*run].table.columns[column]);
            let is_changed = folded.iter().zip(own).map(|(a, b)| a != b);
            let off =
                experiment.readings(*run, output).iter().zip(&shown[output]).map(|(y, p)| (y - p).powi(2));
            is_changed.zip(off).filter(|(is_changed, off)| *is_changed && !off.is_nan()).map(|(_, off)| off)
        });
        squares.sum::<f64>().sqrt()
    };
    let direct = (0..experiment.outputs.len()).filter(|k| !experiment.outputs[*k].is_temperature());
    let pairs: Vec<(f64, f64)> = direct.map(|k| (of(k, before), of(k, after))).collect();
    pairs.iter().all(|(before, after)| after <= before)
        && pairs.iter().any(|(before, after)| FACTOR * after < *before)
}

/// What the model implies beyond a reading, and what explains it: 1, the reading, and the other inputs.
pub(super) type Row = (f64, Vec<f64>);

/// The fold of a column, if (1) is the explanation of what the model implies beyond its readings, by run and row.
fn fold(judge: &Judge, experiment: &Experiment, column: usize, off: &[Vec<f64>]) -> Option<Fold> {
    let mut rows: Vec<Row> = Vec::new();
    for (run, off) in judge.runs.iter().zip(off) {
        let columns = &experiment.runs[*run].table.columns;
        let others = (0..experiment.inputs.len()).filter(|k| *k != column);
        let known = |row: usize| -> Vec<f64> {
            [1.0, columns[column][row]].into_iter().chain(others.clone().map(|k| columns[k][row])).collect()
        };
        let own = off.iter().enumerate().map(|(row, off)| (*off, known(row)));
        rows.extend(own.filter(|(off, known)| known.iter().fold(*off, |sum, x| sum + x).is_finite()));
    }
    let (step, span) = span_of(&rows, column >= experiment.inputs.len())?;
    let folds = |off: f64| (off / step).round();
    // What is folded is beyond the other readings; a glitch that adds a constant is among them.
    let own = rows.iter().map(|(off, known)| (folds(*off), known[1]));
    let (inside, folded): (Vec<(f64, f64)>, Vec<_>) = own.partition(|(folds, _)| *folds == 0.0);
    let (least, most) = ends(inside.iter().map(|(_, x)| *x));
    let slack = STRUCTURE * (most - least);
    let is_beyond = |x: f64| x < least + slack || x > most - slack;
    if !folded.iter().all(|(folds, x)| is_beyond(x + folds * span)) {
        return None;
    }
    let mut unfolded = experiment.clone();
    for (run, off) in judge.runs.iter().zip(off) {
        let readings = unfolded.runs[*run].table.columns[column].iter_mut().zip(off);
        readings.filter(|(_, off)| off.is_finite()).for_each(|(x, off)| *x += folds(*off) * span);
    }
    let rough = |data: &Experiment| -> f64 {
        let columns = judge.runs.iter().map(|run| &data.runs[*run].table.columns[column]);
        let changes = columns.flat_map(|column| column.windows(2).map(|w| (w[1] - w[0]).powi(2)));
        changes.filter(|square| square.is_finite()).sum()
    };
    let roughness = rough(&unfolded) / rough(experiment);
    Some(Fold { span, unfolded, roughness })
}

/// The usual deviation of a folded row, and W of (1), if the readings are within a span and (2) leaves far more.
fn span_of(rows: &[Row], is_output: bool) -> Option<(f64, f64)> {
    let (least, most) = ends(rows.iter().map(|(_, known)| known[1]));
    let used = most - least;
    let beyond: Vec<f64> = rows.iter().map(|(off, _)| off.abs()).filter(|off| *off > HALF * used).collect();
    if beyond.len() < FEWEST {
        return None;
    }
    let step = median(beyond.into_iter());
    let (numbers, left) = least_squares(rows, |(off, known)| vec![known[0], known[1], (off / step).round()])?;
    // The model may deviate by a factor: of the folded value, not of the reading.
    let span = numbers[2] / (1.0 + numbers[1]);
    let slack = STRUCTURE * span;
    let is_within = |low: &f64| least > low - slack && most < low + span + slack;
    if used < HALF * span || left > SMALL * span || ![0.0, -HALF * span].iter().any(is_within) {
        return None;
    }
    // An output is a function of the inputs, whatever was read.
    let explaining = |k: &usize| !is_output || *k != 1;
    let (_, without) =
        least_squares(rows, |(_, known)| (0..known.len()).filter(explaining).map(|k| known[k]).collect())?;
    (without > (SMALL * span).max(FACTOR * left)).then_some((step, span))
}

/// Coefficients of these columns for the deviations of all rows, and the root mean square of what they leave.
pub(super) fn least_squares(rows: &[Row], columns: impl Fn(&Row) -> Vec<f64>) -> Option<(DVector<f64>, f64)> {
    let all: Vec<Vec<f64>> = rows.iter().map(columns).collect();
    let design = DMatrix::from_fn(rows.len(), all[0].len(), |row, column| all[row][column]);
    let off = DVector::from_iterator(rows.len(), rows.iter().map(|(off, _)| *off));
    let numbers = design.clone().svd(true, true).solve(&off, ROUNDING).ok()?;
    let left = off - design * &numbers;
    Some((numbers, (left.norm_squared() / left.len() as f64).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::tests::{CURRENT, SPEED, TORQUE, VOLTAGE, column, experiment, with_inputs};

    /// A column that shows numbers from `low` over a span of `span`.
    fn folded(x: f64, low: f64, span: f64) -> f64 {
        (x - low).rem_euclid(span) + low
    }

    fn said(experiment: &Experiment) -> Option<Unusable> {
        found(experiment, &[], &Deadline::default())
    }

    /// Signed and unsigned, inputs and outputs, in one file; the span is that of the fold.
    #[test]
    fn a_fold_is_found_with_its_span() {
        for (k, part, low) in [
            (SPEED, 1.4, -0.5),
            (SPEED, 0.9, 0.0),
            (SPEED, 0.6, 0.0),
            (CURRENT, 0.8, 0.0),
            (CURRENT, 1.5, -0.5),
            (VOLTAGE, 0.6, 0.0),
            (VOLTAGE, 1.3, -0.5),
            (TORQUE, 1.5, -0.5),
            (TORQUE, 1.2, -0.5),
        ] {
            let mut own = experiment(61);
            let greatest = column(&mut own, k).iter().fold(0.0f64, |most, x| most.max(*x));
            let span = part * greatest;
            column(&mut own, k).iter_mut().for_each(|x| *x = folded(*x, low * span, span));
            let name = own.inputs.iter().chain(&own.outputs).nth(k).unwrap().column;
            let why = said(&own).unwrap_or_else(|| panic!("{name} {part} {low}"));
            assert_eq!(why.channel, name, "{part} {low}: {}", why.reason);
            let shown: f64 =
                why.reason.split("are off by ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            assert!((shown / span - 1.0).abs() < 0.05, "{name} {part} {low}: {shown} of {span}");
        }
    }

    /// Other mistakes and other motors: a factor, a sign, a zero, a clipped, a frozen, a dead channel, spikes; two levels only.
    #[test]
    fn other_deviations_are_none() {
        let all = [CURRENT, SPEED, VOLTAGE, TORQUE];
        let changes: [fn(usize, f64) -> f64; 9] = [
            |_, x| x,
            |_, x| 0.3 * x,
            |_, x| 10.0 * x,
            |_, x| -x,
            |_, x| x + 3.0,
            |_, x| x.min(0.5),
            |_, _| 0.0,
            |_, _| 1.0,
            |k, x| if k % 11 == 0 { x + 500.0 } else { x },
        ];
        for (n, change) in changes.into_iter().enumerate() {
            for k in all {
                let mut own = experiment(62);
                column(&mut own, k).iter_mut().enumerate().for_each(|(row, x)| *x = change(row, *x));
                assert_eq!(said(&own), None, "{n} {k}");
                let mut levels = with_inputs(63, |columns| {
                    columns[SPEED]
                        .iter_mut()
                        .enumerate()
                        .for_each(|(row, w)| *w = if row / 200 % 2 == 0 { 0.0 } else { 200.0 });
                });
                column(&mut levels, k).iter_mut().enumerate().for_each(|(row, x)| *x = change(row, *x));
                assert_eq!(said(&levels), None, "two levels of the speed, {n} {k}");
            }
        }
    }
}
