//! Gaps between rows in which something happened that the rows do not tell.
//!
//! e(after) - e(before) = d,   |d| > e_s   and   |d| > [`CERTAIN`] median |e(t + g) - e(t)|                      (1)
//!
//! e the deviation of a thermometer from the prediction of the fit, which goes on across the gap with the inputs as lines between its two
//! rows; medians over a few readings; g the length of the gap; e_s the error of a thermometer that works. A motor that was loaded or rested
//! meanwhile is at another temperature than predicted, and so is all that follows. Its run ends at the gap, and another one starts at
//! the readings after it.
//!
//! A test run is simulated across: what is predicted there may not start at its own readings.
//!
//! *Source*: detection of abrupt changes in a residual: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

use super::response::ENOUGH;
use super::signals::{NEAR, SENSOR_ERROR};
use super::{Predicted, counted, median};
use crate::comparison::converted;
use crate::experiment::{Experiment, Role, Run, Start};
use crate::levels::CERTAIN;

/// A gap to end a run at.
struct Break {
    run: usize,
    /// The last row before it.
    row: usize,
    column: &'static str,
    /// d of (1), K.
    change: f64,
}

/// Splits runs at gaps; `fitted` are the predictions of each output's fit. Result: whether there was one.
pub(super) fn split(experiment: &mut Experiment, fitted: &[Predicted]) -> bool {
    let runs = (0..experiment.runs.len()).filter(|run| experiment.runs[*run].role != Role::Test);
    let mut found: Vec<Break> = runs
        .flat_map(|run| experiment.runs[run].table.gaps().map(move |row| (run, row)))
        .filter_map(|(run, row)| across(experiment, fitted, run, row))
        .collect();
    // From the last one on, so that the places of the others stay.
    found.reverse();
    for Break { run, row, column, change } in &found {
        let own = &mut experiment.runs[*run];
        let (from, to) = (own.table.time[*row], own.table.time[row + 1]);
        experiment.notes.push(format!(
            "{}: {column} changes by {} K more than the model predicts across the gap from {from} s to {to} s, in which the load may have \
             changed; the run ends at the gap, and another one starts at the readings after it",
            own.file,
            converted((10.0 * change).round() / 10.0)
        ));
        let after = rest(own, row + 1);
        experiment.runs.insert(run + 1, after);
    }
    !found.is_empty()
}

/// Cuts a run before a row; the rest is a run that starts at its readings.
fn rest(run: &mut Run, row: usize) -> Run {
    let mut after = run.clone();
    after.start = Start::Measured;
    after.table.time.drain(..row);
    after.table.columns.iter_mut().for_each(|column| drop(column.drain(..row)));
    run.table.time.truncate(row);
    run.table.columns.iter_mut().for_each(|column| column.truncate(row));
    after
}

/// (1) at a gap that leaves enough rows on both sides: the thermometer with the greatest change.
fn across(experiment: &Experiment, fitted: &[Predicted], run: usize, row: usize) -> Option<Break> {
    let own = &experiment.runs[run];
    let before = counted(own).filter(|k| *k <= row).count();
    if before.min(counted(own).count() - before) < ENOUGH {
        return None;
    }
    let thermometers =
        experiment.outputs.iter().enumerate().filter(|(_, c)| c.is_temperature() && c.node().is_some());
    let changes = thermometers.filter_map(|(output, channel)| {
        let off = |run: usize| deviation(experiment, &fitted[output], output, run);
        let change = step(&off(run), row, row + 1);
        let length = own.table.time[row + 1] - own.table.time[row];
        let all = (0..experiment.runs.len()).flat_map(|k| {
            let (off, time) = (off(k), &experiment.runs[k].table.time);
            let pairs =
                (0..time.len()).step_by(NEAR).map(|a| (a, time.partition_point(|t| *t < time[a] + length)));
            pairs.filter(|(_, b)| *b < time.len()).map(|(a, b)| step(&off, a, b).abs()).collect::<Vec<_>>()
        });
        let usual = median(all.filter(|x| x.is_finite()));
        let is_far = change.abs() > SENSOR_ERROR.max(CERTAIN * usual);
        is_far.then_some(Break { run, row, column: channel.column, change })
    });
    changes.max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()))
}

/// Deviation of an output's readings from a prediction, by row.
fn deviation(experiment: &Experiment, predicted: &Predicted, output: usize, run: usize) -> Vec<f64> {
    let column = &experiment.runs[run].table.columns[experiment.inputs.len() + output];
    let Some(model) = predicted[run].get(output) else { return vec![f64::NAN; column.len()] };
    column.iter().zip(model).map(|(y, p)| y - p).collect()
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
    use crate::deadline::Deadline;

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
        for (from, to) in [(230, 262), (1000, 1040)] {
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
}
