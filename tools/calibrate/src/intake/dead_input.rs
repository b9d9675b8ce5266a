//! An input that stands still in one run although it varies in others, while the outputs move: its sensor or its channel has failed.

use super::response::{LEAST_ROWS, pair, spread};
use super::{Unusable, median, sorted};
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::levels::{CERTAIN, SMALL};

/// Input that is constant in one run although noisy in others, while an output driven by it deviates from the prediction. Where an output
/// follows the input at once, this output decides: a motor at rest has no back EMF, a dead speed sensor leaves it.
pub fn found(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    predicted: &[Vec<Vec<f64>>],
    deadline: &Deadline,
) -> Option<Unusable> {
    for (k, channel) in experiment.inputs.iter().enumerate() {
        let same = |w: &[f64]| w[0] == w[1];
        let pairs = || experiment.runs.iter().flat_map(|r| r.table.columns[k].windows(2));
        let (still, count) = (pairs().filter(|w| same(w)).count(), pairs().count());
        if count == 0 || still as f64 > 0.5 * count as f64 {
            continue;
        }
        for (r, run) in experiment.runs.iter().enumerate() {
            let column = &run.table.columns[k];
            let Some((from, to)) = longest(column).filter(|(a, b)| b - a >= LEAST_ROWS) else { continue };
            let witnesses = witnesses(experiment, preset, (k, r), (from, to), &predicted[r], deadline);
            for output in
                (0..experiment.outputs.len()).filter(|k| witnesses.as_ref().is_none_or(|w| w.contains(k)))
            {
                let own = pair(experiment, &predicted[r], r, output);
                let size = spread(&own.model).max(spread(&own.read));
                let off = |inside: bool| {
                    let rows =
                        own.rows.iter().enumerate().filter(|(_, row)| (from..=to).contains(*row) == inside);
                    let all = sorted(rows.map(|(j, _)| (own.read[j] - own.model[j]).abs()));
                    all.get(all.len() * 3 / 4).copied().unwrap_or(f64::NAN)
                };
                let elsewhere = if off(false).is_finite() { off(false) } else { 0.0 };
                if size > 0.0
                    && off(true) > SMALL * size
                    && off(true) > CERTAIN * elsewhere
                    && run.role != Role::Test
                {
                    let (a, b) = (run.table.time[from], run.table.time[to]);
                    let other = experiment.outputs[output].column;
                    return Some(Unusable::new(
                        channel.column,
                        format!(
                            "{} in {} stands at {} from {a} s to {b} s, although it varies elsewhere, and {other} does not agree with that",
                            channel.column,
                            run.file,
                            column[from] - channel.offset
                        ),
                        "leave the run out, or end its window before the sensor failed",
                    ));
                }
            }
        }
    }
    None
}

/// The outputs that would differ at once if the input were as it usually is elsewhere; `None` if there is no such output.
fn witnesses(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    (input, run): (usize, usize),
    (from, to): (usize, usize),
    predicted: &[Vec<f64>],
    deadline: &Deadline,
) -> Option<Vec<usize>> {
    let mut moved = experiment.clone();
    let usual = median(
        experiment
            .runs
            .iter()
            .flat_map(|r| r.table.columns[input].iter())
            .map(|x| x.abs())
            .filter(|x| *x > 0.0),
    );
    moved.runs[run].table.columns[input][from..=to].fill(usual);
    let other = super::predicted(&moved, preset, &[run], deadline).pop()?;
    let differs = |output: &usize| {
        let size = spread(&predicted[*output]);
        let changes = predicted[*output][from..=to].iter().zip(&other[*output][from..=to]);
        median(changes.map(|(a, b)| (a - b).abs())) > SMALL * size
    };
    let fast = (0..experiment.outputs.len()).filter(|k| !experiment.outputs[*k].is_temperature());
    let found: Vec<usize> = fast.filter(differs).collect();
    (!found.is_empty()).then_some(found)
}

/// Longest section of identical readings.
fn longest(column: &[f64]) -> Option<(usize, usize)> {
    let (mut best, mut from) = (None, 0);
    for k in 0..column.len() {
        if column[k] != column[from] {
            from = k;
        }
        if best.is_none_or(|(a, b)| k - from > b - a) {
            best = Some((from, k));
        }
    }
    best
}
