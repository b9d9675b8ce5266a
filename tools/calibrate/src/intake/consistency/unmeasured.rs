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
    let unmeasured = pairs.filter_map(|(column, output)| {
        let (data, shown) = implied(judge, experiment, predicted, (column, output))?;
        let mistake = Mistake::Unmeasured { column, by: experiment.place_of(output) };
        // Its agreement is no criterion: one output less.
        Some(Changed { score: 0.0, mistake, data, shown })
    });
    unmeasured.chain(without_sign(judge, experiment, predicted, &disagreeing)).collect()
}

/// Each column without negative readings, but for noise, with the signs that the model implies.
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
        let squares = |sign: f64| readings().filter(|x| sign * **x > 0.0).map(|x| x * x).sum::<f64>();
        // A magnitude near zero has noise of both signs.
        has_sign && squares(-1.0) < SMALL * SMALL * squares(1.0)
    };
    let changed = |column, data: Experiment, shown| Changed {
        score: 0.0,
        mistake: Mistake::Magnitude(column),
        data,
        shown,
    };
    let output = |k: &usize| {
        let is_negative = |n: usize, row: usize| predicted[n][*k][row] < 0.0;
        let data = signed(judge, experiment, inputs + k, is_negative)?;
        Some(changed(inputs + k, data, predicted.clone()))
    };
    let input = |column: usize, by: usize| {
        let [own, other] = [experiment, &turned(judge, experiment, column)].map(|e| cold(judge, e));
        let is_negative = |n: usize, row: usize| {
            let reading = experiment.runs[judge.runs[n]].table.columns[inputs + by][row];
            let off = |p: &Predicted| (reading - p[n][by][row]).abs();
            off(&other) < off(&own)
        };
        let data = signed(judge, experiment, column, is_negative)?;
        let shown = judge.predicted(&data);
        Some(changed(column, data, shown))
    };
    let of_inputs = (0..inputs).filter(is_magnitude);
    let of_inputs = of_inputs.flat_map(|column| disagreeing.iter().map(move |by| (column, *by)));
    let of_outputs = disagreeing.iter().filter(|k| is_magnitude(&(inputs + **k))).filter_map(output);
    of_inputs.filter_map(|(column, by)| input(column, by)).chain(of_outputs).collect()
}

/// The data with a negative sign in the rows that have it, given by the place of the run among the judge's and the row; `None` if these are
/// hardly any.
fn signed(
    judge: &Judge,
    experiment: &Experiment,
    column: usize,
    is_negative: impl Fn(usize, usize) -> bool,
) -> Option<Experiment> {
    let mut data = experiment.clone();
    let (mut whole, mut negative) = (0.0, 0.0);
    for (n, run) in judge.runs.iter().enumerate() {
        for (row, x) in data.runs[*run].table.columns[column].iter_mut().enumerate() {
            let square = if x.is_finite() { *x * *x } else { 0.0 };
            whole += square;
            if is_negative(n, row) {
                negative += square;
                *x = -*x;
            }
        }
    }
    (negative >= SMALL * whole).then_some(data)
}

/// Prediction of a motor that hardly warms up: a voltage with the wrong sign would overheat it, so that it cannot be simulated.
pub(super) fn cold(judge: &Judge, experiment: &Experiment) -> Predicted {
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
    for run in judge.runs {
        turned.runs[*run].table.columns[column].iter_mut().for_each(|x| *x = -*x);
    }
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

/// Derivatives of all outputs by an input, by run, output and row, with this prediction of the data; blank where they determine no input.
pub(super) fn slopes(
    judge: &Judge,
    experiment: &Experiment,
    (predicted, predict): (&Predicted, &dyn Fn(&Experiment) -> Predicted),
    column: usize,
) -> Option<Predicted> {
    let row = super::super::declaration(experiment)?.by_name(experiment.inputs[column].input?)?.row;
    let way = MOVE * row.nominal;
    let mut moved = experiment.clone();
    for run in judge.runs {
        moved.runs[*run].table.columns[column].iter_mut().for_each(|u| *u += way);
    }
    let mut all = predict(&moved);
    for (slopes, shown) in all.iter_mut().flatten().zip(predicted.iter().flatten()) {
        slopes.iter_mut().zip(shown).for_each(|(b, a)| *b = (*b - a) / way);
        let least = FLAT * slopes.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
        slopes.iter_mut().filter(|s| s.abs() <= least).for_each(|s| *s = f64::NAN);
    }
    Some(all)
}

/// The data with the input values implied by an output, without this output, and their prediction.
pub(super) fn implied(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    (column, output): (usize, usize),
) -> Option<(Experiment, Predicted)> {
    let row = super::super::declaration(experiment)?.by_name(experiment.inputs[column].input?)?.row;
    let by = experiment.place_of(output);
    let mut changed = experiment.clone();
    let mut shown = predicted.clone();
    for _ in 0..ITERATIONS {
        if judge.deadline.is_over() {
            return None;
        }
        let slopes = slopes(judge, &changed, (&shown, &|data| judge.predicted(data)), column)?;
        for (n, run) in judge.runs.iter().enumerate() {
            let table = &mut changed.runs[*run].table;
            for (k, slope) in slopes[n].get(output)?.iter().enumerate() {
                let off = table.columns[by][k] - shown[n][output][k];
                if (off / slope).is_finite() {
                    let value = table.columns[column][k] + off / slope;
                    table.columns[column][k] = value.clamp(row.min, row.max);
                }
            }
        }
        shown = judge.predicted(&changed);
    }
    Some((blanked(&changed, judge.runs, by), shown))
}
