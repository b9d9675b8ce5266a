//! Inputs that were not measured: a constant column that contradicts an output. Columns without their sign.
//!
//! u <- u + (y - p(u)) / s,   s = dp/du                                                             (1)
//!
//! y the readings of an output with direct feedthrough from the input (voltage, torque, current, speed), p its prediction. Newton's method
//! (1), applied to each row, gives the values of the input that this output implies. The other outputs decide whether they are correct: if
//! the input really is constant, as with a locked shaft, their agreement deteriorates. If no other output depends on the input by more
//! than the structure error, no conclusion is drawn.
//!
//! Of a current, a speed, a torque or a voltage that is never negative, the sign may not have been recorded. An output has the sign of its
//! prediction; an input, in each row, the sign with which an output of a cold motor is predicted better. This output remains evidence: its magnitude has to
//! agree, too. If hardly any row is negative, the sign is not missing.

use super::search::Changed;
use super::{Judge, Mistake, Predicted, blanked};
use crate::experiment::Experiment;
use crate::levels::SMALL;
use physics::declare::Unit;

/// Iterations of (1). Numerical: voltage and torque are linear in speed and current except for friction.
const ITERATIONS: usize = 3;
/// Derivatives below this fraction of the greatest one do not determine the input. Numerical: rounding of the difference.
const FLAT: f64 = 1e-3;
/// Perturbation of an input for s, as a fraction of its nominal value. Numerical: half of the digits remain in the difference.
const MOVE: f64 = 1e-4;

/// Each constant input with the values implied by an output that disagrees.
pub(super) fn of(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    outputs: &[Option<(f64, f64)>],
) -> Vec<Changed> {
    let inputs = experiment.inputs.len();
    let follows =
        |k: &usize| !experiment.outputs[*k].is_temperature() && outputs[*k].is_some_and(|(q, _)| q > SMALL);
    let disagreeing: Vec<usize> = (0..outputs.len()).filter(follows).collect();
    let unmeasured = (0..inputs).filter(|k| is_constant(judge, experiment, *k));
    let pairs = unmeasured.flat_map(|column| disagreeing.iter().map(move |output| (column, *output)));
    let unmeasured =
        pairs.filter_map(|(column, output)| implied(judge, experiment, predicted, column, output));
    unmeasured.chain(without_sign(judge, experiment, predicted, &disagreeing)).collect()
}

/// Each column without negative readings with the signs that the model implies.
fn without_sign(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    disagreeing: &[usize],
) -> Vec<Changed> {
    let inputs = experiment.inputs.len();
    let is_magnitude = |k: &usize| {
        let channel = experiment.inputs.iter().chain(&experiment.outputs).nth(*k);
        let has_sign = channel.is_some_and(|c| {
            matches!(c.unit, Unit::Ampere | Unit::RadianPerSecond | Unit::NewtonMetre | Unit::Volt)
        });
        let readings = || judge.runs.iter().flat_map(|run| &experiment.runs[*run].table.columns[*k]);
        has_sign && readings().any(|x| *x > 0.0) && !readings().any(|x| *x < 0.0)
    };
    let signed = |(column, by): (usize, Option<usize>)| -> Option<Changed> {
        let mut data = experiment.clone();
        let either = by.map(|_| [experiment, &turned(judge, experiment, column)].map(|e| cold(judge, e)));
        let (mut whole, mut negative) = (0.0, 0.0);
        for (n, run) in judge.runs.iter().enumerate() {
            let columns = &mut data.runs[*run].table.columns;
            for row in 0..columns[column].len() {
                let is_negative = match (&either, by) {
                    (Some([own, other]), Some(by)) => {
                        let off = |p: &Predicted| (columns[by][row] - p[n][by - inputs][row]).abs();
                        off(other) < off(own)
                    }
                    _ => predicted[n][column - inputs][row] < 0.0,
                };
                let square = columns[column][row].powi(2);
                if square.is_finite() {
                    whole += square;
                    negative += if is_negative { square } else { 0.0 };
                }
                if is_negative {
                    columns[column][row] *= -1.0;
                }
            }
        }
        if negative < SMALL * whole {
            return None;
        }
        let shown = if by.is_some() { judge.predicted(&data) } else { predicted.clone() };
        Some(Changed { score: 0.0, mistake: Mistake::Magnitude(column), data, shown })
    };
    let of_inputs = (0..inputs).filter(is_magnitude);
    let of_inputs =
        of_inputs.flat_map(|column| disagreeing.iter().map(move |by| (column, Some(inputs + by))));
    let of_outputs = disagreeing.iter().map(|k| inputs + k).filter(is_magnitude).map(|column| (column, None));
    of_inputs.chain(of_outputs).filter_map(signed).collect()
}

/// Prediction of a motor that hardly warms up: a voltage with the wrong sign would overheat it, so that it cannot be simulated.
fn cold(judge: &Judge, experiment: &Experiment) -> Predicted {
    let mut cold = experiment.clone();
    for name in ["thermal.C_w", "thermal.C_h"] {
        if let Some(entry) = super::super::declaration(experiment).and_then(|all| all.by_name(name)) {
            cold.set.retain(|(own, _)| own != name);
            cold.set.push((name.to_string(), entry.row.max));
        }
    }
    super::super::predicted(&cold, judge.preset, judge.runs, &judge.deadline)
}

/// The data with the opposite sign of a column.
fn turned(judge: &Judge, experiment: &Experiment, column: usize) -> Experiment {
    let mut turned = experiment.clone();
    let columns = judge.runs.iter().map(|run| (*run, column));
    columns.for_each(|(run, k)| turned.runs[run].table.columns[k].iter_mut().for_each(|x| *x = -*x));
    turned
}

/// Whether a column that is neither command nor temperature has the same reading in all rows of these runs.
fn is_constant(judge: &Judge, experiment: &Experiment, k: usize) -> bool {
    let column = |run: &usize| experiment.runs[*run].table.columns[k].iter().filter(|x| x.is_finite());
    let mut readings = judge.runs.iter().flat_map(column);
    let first = readings.next();
    let is_measured = !matches!(experiment.inputs[k].unit, Unit::One | Unit::Kelvin | Unit::Pascal);
    is_measured && readings.all(|x| Some(x) == first)
}

/// The data with the input values implied by an output, without this output.
fn implied(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    column: usize,
    output: usize,
) -> Option<Changed> {
    let row = super::super::declaration(experiment)?.by_name(experiment.inputs[column].input?)?.row;
    let by = experiment.inputs.len() + output;
    let mut changed = experiment.clone();
    let mut shown = predicted.clone();
    for _ in 0..ITERATIONS {
        if judge.deadline.is_over() {
            return None;
        }
        let mut moved = changed.clone();
        let way = MOVE * row.nominal;
        for run in judge.runs {
            moved.runs[*run].table.columns[column].iter_mut().for_each(|u| *u += way);
        }
        let aside = judge.predicted(&moved);
        for (n, run) in judge.runs.iter().enumerate() {
            let slopes: Vec<f64> =
                aside[n].get(output)?.iter().zip(&shown[n][output]).map(|(b, a)| (b - a) / way).collect();
            let greatest = slopes.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
            let table = &mut changed.runs[*run].table;
            for (k, slope) in slopes.iter().enumerate() {
                let off = table.columns[by][k] - shown[n][output][k];
                if off.is_finite() && slope.abs() > FLAT * greatest {
                    let value = table.columns[column][k] + off / slope;
                    table.columns[column][k] = value.clamp(row.min, row.max);
                }
            }
        }
        shown = judge.predicted(&changed);
    }
    let changed = blanked(&changed, judge.runs, by);
    // Its agreement is no criterion: one output less.
    Some(Changed { score: 0.0, mistake: Mistake::Unmeasured { column, by }, data: changed, shown })
}
