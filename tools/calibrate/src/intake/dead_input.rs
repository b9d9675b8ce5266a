//! An input that stands still in one run although it varies in others, while the outputs move: its sensor or its channel has failed.

use super::response::{LEAST_ROWS, pair, spread};
use super::{Unusable, median, sorted};
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::levels::{CERTAIN, SMALL};

/// Sections of a run that are compared. Numerical: a limit of effort; a sensor fails once, and a motor may rest before and after.
const MOST: usize = 4;

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
            for (from, to) in sections(column) {
                let witnesses = witnesses(experiment, preset, (k, r), (from, to), &predicted[r], deadline);
                for output in
                    (0..experiment.outputs.len()).filter(|k| witnesses.as_ref().is_none_or(|w| w.contains(k)))
                {
                    let own = pair(experiment, &predicted[r], r, output);
                    let size = spread(&own.model).max(spread(&own.read));
                    let off = |inside: bool| {
                        let rows = own
                            .rows
                            .iter()
                            .enumerate()
                            .filter(|(_, row)| (from..=to).contains(*row) == inside);
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

/// The longest sections of identical readings.
fn sections(column: &[f64]) -> Vec<(usize, usize)> {
    let mut all: Vec<(usize, usize)> = Vec::new();
    for k in 0..column.len() {
        match all.last_mut() {
            Some((from, to)) if column[*from] == column[k] => *to = k,
            _ => all.push((k, k)),
        }
    }
    all.retain(|(from, to)| to - from >= LEAST_ROWS);
    all.sort_by_key(|(from, to)| from.abs_diff(*to));
    all.into_iter().rev().take(MOST).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{HOUSING, SPEED, WINDING, with_inputs};
    use super::super::{Refusal, check};
    use super::*;

    /// Channel that makes an experiment with these rows of the speed unusable, after a change of the readings.
    fn channel(change: impl Fn(&mut Experiment)) -> Option<String> {
        let mut data = with_inputs(41, |columns| columns[SPEED][500..640].fill(0.0));
        // At rest a speed sensor has no noise.
        data.runs[0].table.columns[SPEED][500..640].fill(0.0);
        change(&mut data);
        match check(&mut data, &[], &Deadline::default()) {
            Err(Refusal::Unusable(why)) => Some(why.channel),
            _ => None,
        }
    }

    /// A motor at rest whose thermometers do not follow the model: the voltage agrees with the rest.
    #[test]
    fn a_rest_is_no_dead_sensor() {
        assert_eq!(channel(|_| ()), None);
        for k in [WINDING, HOUSING] {
            let heated = |data: &mut Experiment| {
                let rows = data.runs[0].table.columns[k].iter_mut().enumerate();
                rows.for_each(|(row, x)| *x += 12.0 * (-(row as f64 / 100.0 - 5.5).powi(2)).exp());
            };
            assert_ne!(channel(heated).as_deref(), Some("speed_rad_per_s"), "{k}");
        }
    }

    /// A sensor that reads 0 while the motor turns: the voltage has the back EMF.
    #[test]
    fn a_dead_sensor_contradicts_the_back_emf() {
        for rows in [300..420, 700..1000] {
            let found = channel(|data| data.runs[0].table.columns[SPEED][rows.clone()].fill(0.0));
            assert_eq!(found.as_deref(), Some("speed_rad_per_s"));
        }
    }
}
