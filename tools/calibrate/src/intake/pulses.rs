//! Wild readings that the signal itself hides: pulses of what an output reads over what the model predicts.
//!
//! Beside a step of the current, or beside another wild reading, a pulse is no larger than the changes near by. The residual has no such
//! steps; there it is looked for again as [`super::signals`] does, and near by counts but for the greatest fifth of the changes.
//! A channel with proven wild readings has a noise of two parts, (1 - e) N(0, s) + e U(-m, m); e their fraction and m the largest of them.
//! A reading is one of the second part where that is the more probable one,
//!
//! z^2 > 2 ln[(1 - e) / e * 2 m / (s sqrt(2 pi))]                                                     (1)
//!
//! A pulse that an input makes in the same row is the input's own if that channel has wild readings, else it is none.
//! *Source*: Box and Tiao, Biometrika 55 (1968) 119-129 (contaminated normal).

use super::signals::{Readings, bound};
use crate::experiment::{Channel, Experiment, Table};
use std::f64::consts::PI;

/// Changes near by of which the greater ones may be pulses as well.
const NEAR_BY: f64 = 0.8;
/// Beside a step the parameters of the preset leave a step of the residual.
const ALIKE: f64 = 0.6;

/// Sets aside what is found, with notes; `predicted` run by run, output by output, `spikes` what each channel had before.
pub fn set_aside(experiment: &mut Experiment, predicted: &[Vec<Vec<f64>>], spikes: &[usize]) {
    let least = bound(experiment);
    let inputs = experiment.inputs.len();
    let channels: Vec<&'static Channel> =
        experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let mut notes: Vec<String> = Vec::new();
    // Noise and usual changes of the inputs, run by run.
    let sizes: Vec<Vec<f64>> = experiment
        .runs
        .iter()
        .map(|r| r.table.columns[..inputs].iter().map(|c| Readings::of(&r.table.time, c).size()).collect())
        .collect();
    for output in 0..experiment.outputs.len() {
        let k = inputs + output;
        let residuals: Vec<Option<Residual>> = experiment
            .runs
            .iter()
            .zip(predicted)
            .map(|(run, model)| Residual::of(&run.table, k, model.get(output)?))
            .collect();
        let find = |least: f64| -> Vec<Vec<usize>> {
            residuals.iter().map(|r| r.as_ref().map_or(Vec::new(), |r| r.pulses(least))).collect()
        };
        let mut found = find(least);
        if spikes[k] == 0 {
            // A model may be wrong in the row of a step, and in the first one; that proves nothing.
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
        for ((run, rows), sizes) in experiment.runs.iter_mut().zip(found).zip(&sizes) {
            let table = &mut run.table;
            // An input that moves in this row moves the output, unless it reads wild itself.
            let moved = |row: &usize| (0..inputs).find(|j| is_pulse(table, *j, *row, least * sizes[*j]));
            let by: Vec<Option<usize>> = rows.iter().map(moved).collect();
            let mut aside = vec![0usize; channels.len()];
            for (row, by) in rows.iter().zip(by) {
                let column = match by {
                    None => k,
                    Some(input) if spikes[input] > 0 => input,
                    Some(_) => continue,
                };
                table.columns[column][*row] = f64::NAN;
                aside[column] += 1;
            }
            for (column, count) in aside.into_iter().enumerate().filter(|(_, count)| *count > 0) {
                notes.push(format!(
                    "{}: {count} readings of {} that leave the prediction of the model for a few rows are set aside as spikes",
                    run.file, channels[column].column
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

/// What an output of a run reads over what the model predicts.
struct Residual {
    time: Vec<f64>,
    off: Vec<f64>,
}

impl Residual {
    fn of(table: &Table, k: usize, model: &[f64]) -> Option<Residual> {
        let off: Vec<f64> = table.columns[k].iter().zip(model).map(|(y, p)| y - p).collect();
        off.iter().any(|x| x.is_finite()).then(|| Residual { time: table.time.clone(), off })
    }

    fn pulses(&self, least: f64) -> Vec<usize> {
        let readings = Readings::of(&self.time, &self.off);
        let mut rows = readings.spikes(true, least, (NEAR_BY, ALIKE));
        rows.extend(readings.ends(least, NEAR_BY));
        rows
    }

    /// The largest of these rows, in deviations.
    fn largest(&self, rows: &[usize]) -> Option<f64> {
        let readings = Readings::of(&self.time, &self.off);
        rows.iter().map(|row| readings.distance(*row)).max_by(f64::total_cmp)
    }
}

/// Whether an input has another level behind a row than before it; so has the first and the last row of a run.
fn is_step(table: &Table, row: usize, sizes: &[f64], least: f64) -> bool {
    let Some(before) = row.checked_sub(1).filter(|_| row + 1 < table.time.len()) else { return true };
    table.columns.iter().zip(sizes).any(|(c, size)| (c[row + 1] - c[before]).abs() > (least * size).max(1e-9))
}

/// Whether a column leaves the line between the rows beside this one by more than `least`.
fn is_pulse(table: &Table, k: usize, row: usize, least: f64) -> bool {
    let Some(before) = row.checked_sub(1).filter(|_| row + 1 < table.time.len()) else { return false };
    let (time, column) = (&table.time, &table.columns[k]);
    let share = (time[row] - time[before]) / (time[row + 1] - time[before]);
    let across = column[row + 1] - column[before];
    let off = (column[row] - column[before] - share * across).abs();
    // A step leaves the line as well, and ends elsewhere.
    off > least && across.abs() < 0.3 * off
}
