//! Gaps between rows in which something happened that the rows do not tell.
//!
//! e(after) - e(before) = d,   |d| > min(e_s, c s)   and   |d| > [`FACTOR`] q(|e'(t + g) - e'(t)|)                     (1)
//!
//! e the deviation of a thermometer from the prediction of the fit, which goes on across the gap with the inputs as lines between its two
//! rows; medians over a few readings, q the quantile [`USUAL`]; e_s the error of a thermometer that works; c s the
//! structure error, c = [`STRUCTURE`] of the variation s of the readings; g the length of the gap; e' the deviation if the run ends
//! at the gap and another one starts at the readings after it. A motor that was loaded or rested meanwhile is at another temperature than
//! predicted, and spoils the fit, but with two runs the fit agrees again; the changes of e due to an effect that the model lacks are as
//! great as before.
//!
//! A pause that is not in the times is a gap too: all thermometers jump from one row to the next, by more than the bound on the noise of
//! `signals.rs`.
//!
//! A test run is simulated across: what is predicted there may not start at its own readings.
//!
//! *Source*: detection of abrupt changes in a residual: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

use super::response::ENOUGH;
use super::signals::{NEAR, SENSOR_ERROR, bound};
use super::{Predicted, all_runs, consistency, counted, deviation, median, predicted_by, range, sorted};
use crate::comparison::converted;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role, Start};
use crate::levels::{FACTOR, STRUCTURE};
use crate::noise;

/// Quantile of the changes of a deviation that are usual. Derivation: 95 % are as sure as any statement here; the changes of the load, at which
/// an error of the model shows, are more than the rest.
const USUAL: f64 = 0.95;

/// Readings on either side of a pause that are compared. Numerical: in five rows a housing hardly moves, and their mean has half of the noise.
const BESIDE: usize = 5;
/// Quantile of the changes of a deviation that a pause exceeds. Derivation: changes of the load are more than one in a hundred rows, pauses are
/// fewer.
const MOST: f64 = 0.99;
/// Rows on either side of the greatest difference in which the step is. Numerical: the noise moves the greatest difference by a row.
const NEAREST: usize = 3;

/// A gap to end a run at.
#[derive(Clone, Copy)]
struct Break {
    run: usize,
    /// The last row before it.
    row: usize,
    output: usize,
    /// d of (1), K.
    change: f64,
    /// Its first and last time, s.
    ends: (f64, f64),
}

/// Splits runs at gaps; `predicted` is the prediction of each output by its fit. Result: whether there was one.
pub(super) fn split(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    mut predicted: Predicted,
    deadline: &Deadline,
) -> bool {
    let mut is_split = false;
    // The gap with the greatest change first: it spoils the fit most, and where it is refuted, smaller ones are.
    while let Some(found) = greatest(experiment, &predicted) {
        let (from, to) = found.ends;
        let mut apart = experiment.clone();
        let what = cut(&mut apart, found);
        // A start that the model refuses is no better explanation.
        let Ok(Some(fit)) = consistency::fit(&apart, preset, deadline) else { break };
        let Ok(shown) = predicted_by(&apart, preset, &all_runs(&apart), &fit, deadline) else { break };
        if found.change.abs() <= FACTOR * usual(&apart, &shown, found.output, to - from) {
            break;
        }
        let (file, column) = (&experiment.runs[found.run].file, experiment.outputs[found.output].column);
        let kelvin = converted((10.0 * found.change).round() / 10.0);
        let gap = format!("no rows from {from} s to {to} s");
        let is_gap = experiment.runs[found.run].table.gaps().any(|row| row == found.row);
        let note = if is_gap {
            format!(
                "{file}: {gap}; {column} changes by {kelvin} K more across them than the model predicts, as if the load had changed in between; \
                 {what}"
            )
        } else {
            format!(
                "{file}: all temperatures jump between the rows at {from} s and {to} s, {column} by {kelvin} K, as if the logger had paused \
                 although its times go on; {what}"
            )
        };
        apart.notes.retain(|other| !(other.contains(file.as_str()) && other.contains(&gap)));
        apart.notes.push(note);
        (*experiment, predicted) = (apart, shown);
        is_split = true;
    }
    is_split
}

/// Ends a run at a gap, and begins another one after it; what is too short for a run of its own is left out. Result: this in words.
fn cut(experiment: &mut Experiment, Break { run, row, .. }: Break) -> String {
    let own = &mut experiment.runs[run];
    let mut after = own.clone();
    after.start = Start::Measured;
    after.table.time.drain(..=row);
    after.table.columns.iter_mut().for_each(|column| drop(column.drain(..=row)));
    let mut before = own.clone();
    before.table.time.truncate(row + 1);
    before.table.columns.iter_mut().for_each(|column| column.truncate(row + 1));
    let [first, last] = [&before, &after].map(|part| counted(part).count());
    if last < ENOUGH && first >= last {
        *own = before;
        format!("the {last} readings after them are set aside")
    } else if first < ENOUGH {
        *own = after;
        format!(
            "the {first} readings before them are set aside, and the run starts at the readings after them"
        )
    } else {
        *own = before;
        experiment.runs.insert(run + 1, after);
        "the run ends there, and another one starts at the readings after them".to_string()
    }
}

/// The greatest change across a gap, if it matters: more than the error of a thermometer, or than the structure error of
/// a model of these readings.
fn greatest(experiment: &Experiment, predicted: &Predicted) -> Option<Break> {
    let runs = (0..experiment.runs.len()).filter(|run| experiment.runs[*run].role != Role::Test);
    let is_node = |output: &usize| experiment.outputs[*output].node().is_some();
    let nodes: Vec<usize> = (0..experiment.outputs.len()).filter(is_node).collect();
    let all = runs.flat_map(|run| {
        let own = &experiment.runs[run];
        let rows = own.table.gaps().chain(pauses(experiment, predicted, &nodes, run));
        let gaps = rows.map(|row| (row, (own.table.time[row], own.table.time[row + 1])));
        let gaps: Vec<_> = gaps.filter(|(row, _)| *row + 1 < own.table.time.len()).collect();
        let of = |output: &usize| {
            let off = deviation(experiment, &predicted[run], *output, run);
            let readings = experiment.readings(run, *output);
            let least = SENSOR_ERROR.min(STRUCTURE * range(readings.iter().copied()));
            let breaks = gaps.iter().map(|(row, ends)| {
                let change = step(&off, *row, *row + 1);
                Break { run, row: *row, output: *output, change, ends: *ends }
            });
            breaks.filter(|found| found.change.abs() > least).collect::<Vec<_>>()
        };
        nodes.iter().flat_map(of).collect::<Vec<_>>()
    });
    all.max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()))
}

/// The row after which a logger paused although its times go on: all thermometers jump together, as none of them can by itself. (One
/// thermometer alone may have moved.)
fn pauses(experiment: &Experiment, predicted: &Predicted, nodes: &[usize], run: usize) -> Option<usize> {
    let time = &experiment.runs[run].table.time;
    let read: Vec<Vec<f64>> = nodes.iter().map(|k| deviation(experiment, &predicted[run], *k, run)).collect();
    let read: Vec<(Vec<f64>, f64)> =
        read.into_iter().filter_map(|off| noise::of_column(time, &off).map(|sigma| (off, sigma))).collect();
    let least = bound(experiment);
    let means = |row: usize, off: &[f64]| {
        let mean =
            |rows: std::ops::Range<usize>| rows.clone().map(|k| off[k]).sum::<f64>() / rows.len() as f64;
        mean(row + 1..row + 1 + BESIDE) - mean(row + 1 - BESIDE..row + 1)
    };
    // In standard deviations of the difference of two means.
    let jump = |row: usize, (off, sigma): &(Vec<f64>, f64)| {
        means(row, off).abs() / (sigma * (2.0 / BESIDE as f64).sqrt())
    };
    let of = |row: usize| read.iter().map(|one| jump(row, one)).fold(f64::INFINITY, f64::min);
    let rows = (BESIDE + NEAREST..time.len().saturating_sub(BESIDE + NEAREST)).map(|row| (row, of(row)));
    let greatest = rows.filter(|(_, z)| z.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
    let (row, _) = greatest.filter(|(_, z)| read.len() > 1 && *z > least)?;
    let change = |row: &usize| -> f64 {
        read.iter().map(|(off, sigma)| (off[row + 1] - off[*row]).abs() / sigma).sum()
    };
    let row = (row + 1 - NEAREST..row + NEAREST).max_by(|a, b| change(a).total_cmp(&change(b)))?;
    // What the model lacks moves all thermometers as well where the load changes, and does so again at the next change.
    let is_single = |(off, _): &(Vec<f64>, f64)| {
        let rows =
            (BESIDE..time.len().saturating_sub(BESIDE)).filter(|other| other.abs_diff(row) > 2 * BESIDE);
        let changes = sorted(rows.map(|row| means(row, off).abs()));
        let most = changes.get((MOST * changes.len() as f64) as usize).copied().unwrap_or(f64::INFINITY);
        means(row, off).abs() > FACTOR * most
    };
    read.iter().any(is_single).then_some(row)
}

/// What is usual of the changes of a deviation within some seconds, in all runs.
fn usual(experiment: &Experiment, predicted: &Predicted, output: usize, seconds: f64) -> f64 {
    let all = experiment.runs.iter().enumerate().flat_map(|(run, own)| {
        let (off, time) = (deviation(experiment, &predicted[run], output, run), &own.table.time);
        let later = |k: usize| time.partition_point(|t| *t < time[k] + seconds);
        let pairs = (0..time.len()).step_by(NEAR).map(|k| (k, later(k))).filter(|(_, j)| *j < time.len());
        pairs.map(|(k, j)| step(&off, k, j).abs()).collect::<Vec<_>>()
    });
    let all = sorted(all);
    all.get((USUAL * all.len() as f64) as usize).copied().unwrap_or(0.0)
}

/// Median from one row on minus median up to another one, over [`NEAR`] readings or fewer.
fn step(off: &[f64], last: usize, first: usize) -> f64 {
    let of = |rows: std::ops::Range<usize>| median(rows.map(|k| off[k]).filter(|x| x.is_finite()));
    of(first..(first + NEAR).min(off.len())) - of((last + 1).saturating_sub(NEAR)..last + 1)
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::super::tests::{WINDING, experiment, with_inputs};
    use super::*;

    fn without(mut data: Experiment, from: usize, to: usize) -> Experiment {
        let table = &mut data.runs[0].table;
        table.time.drain(from..to);
        table.columns.iter_mut().for_each(|column| drop(column.drain(from..to)));
        data
    }

    /// A motor that was loaded, or rested, while nothing was recorded.
    #[test]
    fn a_run_ends_at_a_gap_in_which_the_load_changed() {
        for (seed, current, from, to) in [(3, 9.0, 400, 470), (4, 0.0, 660, 760), (5, 7.5, 300, 600)] {
            let hidden = with_inputs(seed, |columns| {
                columns[0][from + 3..to - 3].fill(current);
                columns[0][from - 1] = 3.0;
                columns[0][to] = 3.0;
            });
            let mut data = without(hidden, from, to);
            assert_eq!(check(&mut data, &[], &Deadline::default()), Ok(true), "{:?}", data.notes);
            let rows: Vec<usize> = data.runs.iter().map(|run| run.table.time.len()).collect();
            assert_eq!(rows, [from, 1200 - to], "{:?}", data.notes);
            assert_eq!(data.runs[1].start, Start::Measured);
            let lost =
                data.runs.iter().flat_map(|r| &r.table.columns[WINDING]).filter(|x| x.is_nan()).count();
            assert!(lost < 20, "{lost} {:?}", data.notes);
        }
    }

    /// Rows that are missing while the inputs are as before and after.
    #[test]
    fn a_run_goes_on_across_a_gap_in_which_nothing_happened() {
        for (from, to) in [(230, 262), (1000, 1030)] {
            let held = with_inputs(6, |columns| {
                for column in columns.iter_mut() {
                    let value = column[from - 1];
                    column[from..to].fill(value);
                }
            });
            let mut data = without(held, from, to);
            assert_eq!(check(&mut data, &[], &Deadline::default()), Ok(true), "{:?}", data.notes);
            assert_eq!(data.runs.len(), 1, "{:?}", data.notes);
        }
        let mut whole = experiment(7);
        assert_eq!(check(&mut whole, &[], &Deadline::default()), Ok(true));
        assert_eq!(whole.runs.len(), 1);
    }

    /// Rows that are missing while the times go on: the thermometers jump.
    #[test]
    fn a_pause_that_is_not_in_the_times_ends_a_run() {
        for (seed, from, to) in [(11, 300, 340), (12, 700, 900), (13, 905, 950)] {
            let mut data = experiment(seed);
            let table = &mut data.runs[0].table;
            table.time.truncate(1200 - (to - from));
            table.columns.iter_mut().for_each(|column| drop(column.drain(from..to)));
            assert_eq!(check(&mut data, &[], &Deadline::default()), Ok(true), "{:?}", data.notes);
            let rows: Vec<usize> = data.runs.iter().map(|run| run.table.time.len()).collect();
            assert_eq!(rows, [from, 1200 - to], "{:?}", data.notes);
            assert!(
                data.notes.iter().any(|note| note.contains("as if the logger had paused")),
                "{:?}",
                data.notes
            );
        }
        // One thermometer that moves is no pause.
        let mut moved = experiment(11);
        moved.runs[0].table.columns[WINDING][500..].iter_mut().for_each(|x| *x -= 6.0);
        let _ = check(&mut moved, &[], &Deadline::default());
        assert!(!moved.notes.iter().any(|note| note.contains("paused")), "{:?}", moved.notes);
    }
}
