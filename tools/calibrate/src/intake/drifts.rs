//! Thermometers that drift in a run: an amplifier that warms up, a thermocouple that degrades, a cold junction that is heated.
//!
//! e = a (t - t0) + r,   |a| (t1 - t0) > e_s,   sum r^2 < (1 - c) sum e^2                                (1)
//!
//! e the deviation of a thermometer from a fit that agrees with the other data, t0 and t1 the ends of the run, e_s the error of a thermometer
//! that works, c = [`NEARLY`]. What a model lacks in the motor follows its temperature, and a wrong zero or a loss along the leads are
//! parts of it: e has to be described worse by b (p - p0) + d, p the prediction, with [`FACTOR`] times the sum of squares.
//!
//! *Source*: drift of a sensor as an additive fault that grows linearly: Isermann, Fault-Diagnosis Systems (2006), ch. 5.

use super::signals::{self, SENSOR_ERROR};
use super::{Predicted, all_runs, consistency, predicted_by};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::levels::{FACTOR, NEARLY};

/// The failure in words.
const WHY: &str = "drifts away from the model at a constant rate while the other data agree with it, as a degrading \
                   thermocouple or an amplifier that warms up does";
/// Part of a drift that is left if the thermometer is fitted as well, from which it is looked at without it. Definition: half; what the
/// parameters of the other runs and outputs permit is less.
const LEFT: f64 = 0.5;

/// Deviations of a thermometer from a prediction in a run.
struct Course {
    /// Time since the first reading, s.
    since: Vec<f64>,
    off: Vec<f64>,
    model: Vec<f64>,
}

impl Course {
    fn of(experiment: &Experiment, predicted: &[Vec<f64>], output: usize, run: usize) -> Course {
        let table = &experiment.runs[run].table;
        let column = experiment.readings(run, output);
        let model = predicted.get(output).map_or(&[][..], Vec::as_slice);
        let mut course = Course { since: Vec::new(), off: Vec::new(), model: Vec::new() };
        let mut first = None;
        for ((t, y), p) in
            table.time.iter().zip(column).zip(model).filter(|((_, y), p)| (**y - **p).is_finite())
        {
            course.since.push(t - *first.get_or_insert(*t));
            course.off.push(y - p);
            course.model.push(*p);
        }
        course
    }

    /// Deviation at the end by a constant rate, and what this leaves of the sum of squares.
    fn ramp(&self) -> (f64, f64) {
        let (rate, left) = remainder(&self.since, &self.off);
        (rate * self.since.last().copied().unwrap_or(0.0), left)
    }

    /// Whether it may be what a fit with this thermometer leaves of a drift.
    fn is_suspect(&self) -> bool {
        let (end, left) = self.ramp();
        end.abs() > LEFT * SENSOR_ERROR && left < LEFT * product(&self.off, &self.off)
    }

    /// (1)
    fn is_drift(&self) -> bool {
        let (end, left) = self.ramp();
        let is_far = end.abs() > SENSOR_ERROR && left < (1.0 - NEARLY) * product(&self.off, &self.off);
        is_far && remainder(&centred(&self.model), &centred(&self.off)).1 > FACTOR * left
    }
}

/// A thermometer that drifts, the runs in which it does, and the cost of the fit without it there.
struct Drift {
    output: usize,
    runs: Vec<usize>,
    cost: f64,
}

/// Sets aside the thermometer that drifts, with a note; `fitted` are the predictions of each output's fit. One that drifts spoils the fits in
/// which others seem to: it is the one without which the rest agrees best. Two do not drift together: in the runs `known`, in which one
/// does, no other one is looked for. Result: whether one was set aside, so that another may be seen.
pub(super) fn set_aside(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    (fitted, known): (&[Predicted], &mut Vec<usize>),
    deadline: &Deadline,
) -> Result<bool, CalibrateError> {
    let thermometers = experiment.thermometers();
    let inputs = experiment.inputs.len();
    // A thermometer that has moved spoils the fit from which another one then drifts.
    let is_moved = |run: &usize| {
        let columns = &experiment.runs[*run].table.columns;
        thermometers.iter().any(|k| !signals::jumps(&columns[inputs + k]).is_empty())
    };
    let (all, still): (Vec<usize>, Vec<usize>) = (
        all_runs(experiment),
        all_runs(experiment).into_iter().filter(|r| !is_moved(r) && !known.contains(r)).collect(),
    );
    let drift = |output: usize, without: &[usize]| -> Result<Option<Drift>, CalibrateError> {
        if deadline.is_near() {
            return Ok(None);
        }
        let fit = consistency::without(experiment, preset, (output, without), deadline)?;
        let Some((fit, cost)) = fit else { return Ok(None) };
        let shown = predicted_by(experiment, preset, without, &fit, deadline)?;
        let own = without.iter().zip(&shown).filter(|(run, _)| still.contains(run));
        let own = own.filter(|(run, shown)| Course::of(experiment, shown, output, **run).is_drift());
        let runs: Vec<usize> = own.map(|(run, _)| *run).collect();
        Ok((!runs.is_empty()).then_some(Drift { output, runs, cost }))
    };
    let mut found: Vec<Drift> = Vec::new();
    let mut suspect: Vec<usize> = Vec::new();
    for output in thermometers.iter().copied() {
        for run in &still {
            if Course::of(experiment, &fitted[output][*run], output, *run).is_suspect() {
                suspect.push(output);
                found.extend(drift(output, &[*run])?);
            }
        }
    }
    // One that drifts in every run is seen without all its readings only.
    if found.is_empty() {
        suspect.dedup();
        for output in suspect {
            found.extend(drift(output, &all)?);
        }
    }
    let Some(Drift { output, runs, .. }) = found.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
        return Ok(false);
    };
    let column = experiment.outputs[output].column;
    for run in runs {
        known.push(run);
        let run = &mut experiment.runs[run];
        run.table.columns[inputs + output].fill(f64::NAN);
        experiment.notes.push(format!("{}: {column} {WHY}; it is set aside in this run", run.file));
    }
    Ok(true)
}

/// Slope over x and sum of squares that it leaves of y.
fn remainder(x: &[f64], y: &[f64]) -> (f64, f64) {
    let slope = product(x, y) / product(x, x).max(f64::MIN_POSITIVE);
    (slope, product(y, y) - slope * product(x, y))
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|x| x - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::super::sensors;
    use super::super::tests::{CURRENT, HOUSING, WINDING, column, experiment, with_inputs};
    use super::*;
    use crate::testing::{normal, rng};

    /// An hour of heating up and cooling down by 60 K, and what is added to the readings.
    fn drifts(added: impl Fn(f64, f64) -> f64) -> bool {
        let mut rng = rng(11);
        let time: Vec<f64> = (0..1800).map(|k| 500.0 + 2.0 * f64::from(k)).collect();
        let rise = |t: f64| {
            let heated = |t: f64| 60.0 * (1.0 - (-t / 900.0).exp());
            heated(t) - if t > 2000.0 { heated(t - 2000.0) } else { 0.0 }
        };
        let model: Vec<f64> = time.iter().map(|t| 295.0 + rise(t - 500.0)).collect();
        let off: Vec<f64> =
            time.iter().map(|t| added(t - 500.0, rise(t - 500.0)) + 0.2 * normal(&mut rng)).collect();
        let since = time.iter().map(|t| t - time[0]).collect();
        Course { since, off, model }.is_drift()
    }

    #[test]
    fn only_a_deviation_that_grows_with_time_is_a_drift() {
        for rate in [-9.0, 4.0, 20.0] {
            assert!(drifts(|t, _| rate * t / 3600.0), "{rate} K/h");
        }
        assert!(!drifts(|t, _| 1.5 * t / 3600.0), "within the error of a thermometer");
        assert!(!drifts(|_, rise| 0.2 * rise), "a stem loss or a missing effect");
        assert!(!drifts(|_, _| 6.0), "a zero");
        assert!(!drifts(|t, _| if t < 1800.0 { 0.0 } else { -5.0 }), "a sensor that has moved");
        // A further node that warms up within the hour.
        assert!(!drifts(|t, _| 8.0 * (1.0 - (-t / 1200.0).exp())));
    }

    /// The other run and the other outputs tell what the thermometer should read; all else is left as it is.
    #[test]
    fn a_thermometer_that_drifts_is_set_aside_in_its_run() {
        for (k, rate) in [(HOUSING, 0.008), (WINDING, -0.007)] {
            let mut wrong = with_inputs(21, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= 0.9));
            let mut other = experiment(22).runs.remove(0);
            other.file = "other.csv".to_string();
            column(&mut wrong, k).iter_mut().enumerate().for_each(|(n, x)| *x += rate * n as f64);
            wrong.runs.push(other);
            assert!(sensors(&mut wrong, &[], &Deadline::default()).is_ok());
            let blank =
                |run: usize, k: usize| wrong.runs[run].table.columns[k].iter().filter(|x| x.is_nan()).count();
            let all = [(0, HOUSING), (0, WINDING), (1, HOUSING), (1, WINDING)];
            let expected = all.map(|(run, own)| if (run, own) == (0, k) { 1200 } else { 0 });
            assert_eq!(all.map(|(run, own)| blank(run, own)), expected, "{:?}", wrong.notes);
            assert!(wrong.notes.iter().any(|note| note.contains("drifts away")), "{:?}", wrong.notes);
        }
    }
}
