//! Inputs that were not measured: a constant column that contradicts an output.
//!
//! u <- u + (y - p(u)) / s,   s = dp/du                                                             (1)
//!
//! y the readings of an output with direct feedthrough from the input (voltage, torque, current, speed), p its prediction. Newton's method
//! (1), applied to each row, gives the values of the input that this output implies. The other outputs decide whether they are correct: if
//! the input really is constant, as with a locked shaft, their agreement deteriorates. If no other output depends on the input by more
//! than the structure error, no conclusion is drawn.

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
    pairs.filter_map(|(column, output)| implied(judge, experiment, predicted, column, output)).collect()
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
