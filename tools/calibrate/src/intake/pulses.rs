//! Outliers hidden by the signal: pulses in the residual of an output against the model's prediction.
//!
//! Next to a step of the current, or next to another outlier, a pulse is no larger than the neighbouring changes. The residual has no such
//! steps; it is searched as in [`super::signals`], and the greatest fifth of the neighbouring changes is ignored.
//! A channel with confirmed outliers has a contaminated noise distribution, (1 - e) N(0, s) + e U(-m, m), with e their fraction and m the
//! largest of them. A reading is an outlier if the second component is more probable,
//!
//! z^2 > 2 ln[(1 - e) / e * 2 m / (s sqrt(2 pi))]                                                     (1)
//!
//! A pulse caused by an input in the same row is attributed to the input if that channel has outliers; otherwise it is a real response.
//! Where the prediction has the pulse and the reading has none, as of friction at a speed that its noise takes through zero, there is no outlier.
//! *Source*: Box and Tiao, Biometrika 55 (1968) 119-129 (contaminated normal).

use super::signals::{ALIKE, NEAR_BY, Readings, bound};
use crate::experiment::{Channel, Experiment, Table};
use crate::noise;
use crate::report::count_of;
use std::f64::consts::PI;

/// Least change of an input, in SI units. Numerical: rounding.
const ROUNDING: f64 = 1e-9;

/// Sets aside the outliers, with notes; `predicted` by run and output, `spikes` the number found before in each channel.
pub fn set_aside(experiment: &mut Experiment, predicted: &[Vec<Vec<f64>>], spikes: &[usize]) {
    let least = bound(experiment);
    let inputs = experiment.inputs.len();
    let channels: Vec<&'static Channel> =
        experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let mut notes: Vec<String> = Vec::new();
    // Noise and typical changes of the inputs, by run.
    let sizes: Vec<Vec<f64>> = experiment
        .runs
        .iter()
        .map(|r| r.table.columns[..inputs].iter().map(|c| Readings::of(&r.table.time, c).size()).collect())
        .collect();
    for output in 0..experiment.outputs.len() {
        let k = inputs + output;
        let quantised = noise::quantised(experiment, k, channels[k]);
        let residuals: Vec<Option<Residual>> = experiment
            .runs
            .iter()
            .zip(predicted)
            .map(|(run, model)| Residual::of(&run.table, (k, quantised), model.get(output)?))
            .collect();
        let find = |least: f64| -> Vec<Vec<usize>> {
            residuals.iter().map(|r| r.as_ref().map_or(Vec::new(), |r| r.pulses(least))).collect()
        };
        let mut found = find(least);
        if spikes[k] == 0 {
            // The model may be wrong at the row of a step and at the first row, so a pulse there is no proof of outliers.
            for ((rows, run), sizes) in found.iter_mut().zip(&experiment.runs).zip(&sizes) {
                rows.retain(|row| !is_step(&run.table, *row, sizes, least));
            }
        }
        let first: usize = found.iter().map(Vec::len).sum();
        if spikes[k] + first > 0 {
            let readings: usize = residuals.iter().flatten().map(|r| r.off.len()).sum();
            let sizes = residuals.iter().flatten().zip(&found).filter_map(|(r, rows)| r.largest(rows));
            let most = sizes.fold(least, f64::max);
            let part = ((spikes[k] + first) as f64 / readings.max(1) as f64).min(0.5);
            let lower = (2.0 * ((1.0 - part) / part * 2.0 * most / (2.0 * PI).sqrt()).ln().max(0.0)).sqrt();
            found = find(lower.min(least));
        }
        for (((run, rows), sizes), residual) in
            experiment.runs.iter_mut().zip(found).zip(&sizes).zip(&residuals)
        {
            let table = &mut run.table;
            // A change of an input in this row also changes the output, unless the input reading is an outlier itself.
            let moved = |row: &usize| (0..inputs).find(|j| is_pulse(table, *j, *row, least * sizes[*j]));
            let by: Vec<Option<usize>> = rows.iter().map(moved).collect();
            let is_predicted = |row: usize| {
                residual.as_ref().is_some_and(|r| r.is_of_prediction(&table.columns[k], &rows, row))
            };
            let predicted: Vec<bool> = rows.iter().map(|row| is_predicted(*row)).collect();
            let mut aside = vec![0usize; channels.len()];
            for ((row, by), is_predicted) in rows.iter().zip(by).zip(predicted) {
                let column = match by {
                    None if is_predicted => continue,
                    None => k,
                    Some(input) if spikes[input] > 0 => input,
                    Some(_) => continue,
                };
                table.columns[column][*row] = f64::NAN;
                aside[column] += 1;
            }
            for (column, count) in aside.into_iter().enumerate().filter(|(_, count)| *count > 0) {
                notes.push(format!(
                    "{}: {} of {} set aside as spikes, which leave the prediction of the model for a few rows only",
                    run.file,
                    count_of(count, "reading"),
                    channels[column].column
                ));
            }
        }
    }
    for note in notes {
        if !experiment.notes.contains(&note) {
            experiment.notes.push(note);
        }
    }
}

/// Residual of an output in a run: reading minus prediction.
struct Residual {
    time: Vec<f64>,
    off: Vec<f64>,
    /// Noise of the quantization of the readings.
    quantised: f64,
}

impl Residual {
    fn of(table: &Table, (k, quantised): (usize, f64), model: &[f64]) -> Option<Residual> {
        let off: Vec<f64> = table.columns[k].iter().zip(model).map(|(y, p)| y - p).collect();
        off.iter().any(|x| x.is_finite()).then(|| Residual { time: table.time.clone(), off, quantised })
    }

    fn readings(&self) -> Readings {
        Readings::of(&self.time, &self.off).with_least(self.quantised)
    }

    fn pulses(&self, least: f64) -> Vec<usize> {
        let readings = self.readings();
        let mut rows = readings.spikes(true, least, (NEAR_BY, ALIKE));
        rows.extend(readings.ends(least, NEAR_BY));
        rows
    }

    /// Whether the prediction has a pulse in one of the `rows` of outliers that is greater than that of the readings.
    fn is_of_prediction(&self, readings: &[f64], rows: &[usize], row: usize) -> bool {
        let is_other = |other: &usize| !rows.contains(other) && self.off[*other].is_finite();
        let before = (0..row).rev().find(is_other);
        let Some((before, after)) = before.zip((row + 1..self.off.len()).find(is_other)) else {
            return false;
        };
        let near = [before, row, after];
        let (reading, _) = off_line(near.map(|k| self.time[k]), near.map(|k| readings[k]));
        let (model, across) = off_line(near.map(|k| self.time[k]), near.map(|k| readings[k] - self.off[k]));
        across.abs() < ALIKE * model.abs() && reading.abs() < model.abs()
    }

    /// Greatest residual in these rows, in standard deviations.
    fn largest(&self, rows: &[usize]) -> Option<f64> {
        let readings = self.readings();
        rows.iter().map(|row| readings.distance(*row)).max_by(f64::total_cmp)
    }
}

/// Whether an input has a different level before and after a row; true for the first and the last row of a run.
fn is_step(table: &Table, row: usize, sizes: &[f64], least: f64) -> bool {
    let Some(before) = row.checked_sub(1).filter(|_| row + 1 < table.time.len()) else { return true };
    table
        .columns
        .iter()
        .zip(sizes)
        .any(|(c, size)| (c[row + 1] - c[before]).abs() > (least * size).max(ROUNDING))
}

/// Deviation of the second value from the line between the first and the third, and the difference of these.
pub(super) fn off_line(time: [f64; 3], values: [f64; 3]) -> (f64, f64) {
    let across = values[2] - values[0];
    (values[1] - values[0] - (time[1] - time[0]) / (time[2] - time[0]) * across, across)
}

/// Whether a column deviates from the line between the neighbouring rows by more than `least`.
fn is_pulse(table: &Table, k: usize, row: usize, least: f64) -> bool {
    let Some(before) = row.checked_sub(1).filter(|_| row + 1 < table.time.len()) else { return false };
    let near = [before, row, row + 1];
    let (off, across) = off_line(near.map(|n| table.time[n]), near.map(|n| table.columns[k][n]));
    // A step deviates as well, but ends at another level.
    off.abs() > least && across.abs() < ALIKE * off.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings with a prediction; `rows` are those that [`Residual::pulses`] found.
    fn of_prediction(readings: &[f64], model: &[f64], rows: &[usize]) -> Vec<usize> {
        let time: Vec<f64> = (0..readings.len()).map(|k| k as f64).collect();
        let off = readings.iter().zip(model).map(|(y, p)| y - p).collect();
        let residual = Residual { time, off, quantised: 0.0 };
        rows.iter().copied().filter(|row| residual.is_of_prediction(readings, rows, *row)).collect()
    }

    #[test]
    fn a_pulse_of_the_prediction_alone_is_no_outlier() {
        let flat = [1.0; 9];
        let friction = [1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0];
        assert_eq!(of_prediction(&flat, &friction, &[2, 3, 6]), [2, 3, 6]);
        // A spike of the readings beside a smooth prediction, and one at a step of both.
        assert_eq!(of_prediction(&friction, &flat, &[2, 3, 6]), [0usize; 0]);
        let step = [0.0, 0.0, 0.0, 10.0, 10.0, 10.0];
        let spiked = [0.0, 0.0, 0.0, 2.0, 10.0, 10.0];
        assert_eq!(of_prediction(&spiked, &step, &[3]), [0usize; 0]);
    }
}
