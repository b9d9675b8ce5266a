//! Loose contacts of thermometers: bursts of readings that scatter while the temperature does not.
//!
//! |e_k(y) - e_k(p)| > z sigma,   |e_k(p)| < |e_k(y)| / 2                                            (1)
//!
//! e_k is the deviation of a row from the line between its neighbours (`noise.rs` (1)), y the readings, p the prediction of the preset,
//! sigma the standard deviation of e_k by the channel's noise, z the bound of [`super::signals`] (1). Rows with (1) that are close to each
//! other, of both signs and some beyond the error of a thermometer, are a burst; all readings within are set aside. A temperature belongs to
//! a heat capacity: a step of the load bends it once, and a spike concerns three rows.
//! *Source*: as for spikes in [`super::signals`].

use super::pulses::off_line;
use super::response::ENOUGH;
use super::signals::{ALIKE, FROM_LINE, SENSOR_ERROR, WIDEST, bound};
use super::{all_runs, predicted};
use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::noise;
use crate::report::count_of;

/// Fewest rows with (1) of a burst. Derivation: two spikes beside each other have six.
const LEAST: usize = 7;
/// Fraction of the readings in bursts above which the sensor is set aside. Definition: the majority.
const WHOLE: f64 = 0.5;

/// Sets aside the bursts of the motor's thermometers, with notes.
pub fn set_aside(experiment: &mut Experiment, preset: &[(u32, f64)], deadline: &Deadline) {
    let least = bound(experiment);
    let mut model = None;
    for output in experiment.thermometers() {
        let (place, channel) = (experiment.place_of(output), experiment.outputs[output]);
        let quantised = noise::quantised(experiment, place, channel);
        for run in 0..experiment.runs.len() {
            let (time, read) = (&experiment.runs[run].table.time, experiment.readings(run, output));
            let rows: Vec<usize> = (0..read.len()).filter(|row| read[*row].is_finite()).collect();
            let of = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
            let (time, read) = (of(time), of(read));
            let Some(sigma) = noise::of_column(&time, &read).filter(|_| rows.len() >= ENOUGH) else {
                continue;
            };
            let least = least * FROM_LINE * sigma.max(quantised);
            let own = off_lines(&time, &read);
            // The model is only needed where there are such readings at all.
            if least == 0.0 || own.iter().filter(|e| e.abs() > least).count() < LEAST {
                continue;
            }
            let all =
                model.get_or_insert_with(|| predicted(experiment, preset, &all_runs(experiment), deadline));
            let Some(shown) = all[run].get(output) else { continue };
            let expected = off_lines(&time, &of(shown));
            let bursts = bursts(&own, &expected, least);
            let count: usize = bursts.iter().map(|(from, to)| to - from + 1).sum();
            if count == 0 {
                continue;
            }
            let is_whole = count as f64 > WHOLE * rows.len() as f64;
            let own = &mut experiment.runs[run];
            let column = &mut own.table.columns[place];
            let inside = |k: &usize| is_whole || bursts.iter().any(|(from, to)| (from..=to).contains(&k));
            (0..rows.len()).filter(inside).for_each(|k| column[rows[k]] = f64::NAN);
            let what = if is_whole { "the sensor".to_string() } else { count_of(count, "reading") };
            let note = format!(
                "{}: {} scatters in {}, the first at {} s, while the temperature does not, as with a loose contact; {what} set aside",
                own.file,
                channel.column,
                count_of(bursts.len(), "burst"),
                time[bursts[0].0]
            );
            if !experiment.notes.contains(&note) {
                experiment.notes.push(note);
            }
        }
    }
}

/// e_k of each row; 0 at the ends.
fn off_lines(time: &[f64], y: &[f64]) -> Vec<f64> {
    let of = |k: usize| match k.checked_sub(1) {
        Some(before) if k + 1 < y.len() => {
            let near = [before, k, k + 1];
            off_line(near.map(|n| time[n]), near.map(|n| y[n])).0
        }
        _ => 0.0,
    };
    (0..y.len()).map(of).collect()
}

/// First and last row of each burst.
fn bursts(own: &[f64], expected: &[f64], least: f64) -> Vec<(usize, usize)> {
    let scatters = |k: &usize| {
        let (y, p) = (own[*k], expected[*k]);
        (y - p).abs() > least && p.abs() < ALIKE * y.abs()
    };
    let rows: Vec<usize> = (0..own.len()).filter(scatters).collect();
    let groups = rows.chunk_by(|a, b| b - a <= WIDEST).filter(|group| {
        let up = group.iter().filter(|k| own[**k] > 0.0).count();
        // Less is a noise that varies, as of a thermocouple in an air flow.
        let is_failure = group.iter().any(|k| own[*k].abs() > SENSOR_ERROR);
        group.len() >= LEAST && up > 0 && up < group.len() && is_failure
    });
    groups.map(|group| (group[0], group[group.len() - 1])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{HOUSING, WINDING, column, experiment, with_inputs};
    use super::*;
    use crate::testing::{normal, rng};

    fn aside(data: &mut Experiment, k: usize) -> Vec<bool> {
        set_aside(data, &[], &Deadline::default());
        column(data, k).iter().map(|x| x.is_nan()).collect()
    }

    #[test]
    fn bursts_of_a_loose_contact_are_set_aside() {
        for (seed, k, size, sign) in
            [(91, WINDING, 8.0, -1.0), (92, HOUSING, 3.0, 1.0), (93, WINDING, 4.0, 0.0)]
        {
            let mut data = experiment(seed);
            let mut rng = rng(seed + 1);
            let in_burst = |row: usize| row % 150 >= 90 && row % 150 < 90 + 10 + row / 150;
            for (row, x) in column(&mut data, k).iter_mut().enumerate().filter(|(row, _)| in_burst(*row)) {
                let off = size * normal(&mut rng);
                *x += if sign == 0.0 { off } else { sign * off.abs() } * (1.0 + (row % 3) as f64) / 2.0;
            }
            let aside = aside(&mut data, k);
            let count = |wanted: bool, got: bool| {
                aside
                    .iter()
                    .enumerate()
                    .filter(|(row, aside)| in_burst(*row) == wanted && **aside == got)
                    .count()
            };
            let (left, lost) = (count(true, false), count(false, true));
            assert!(left < 30 && lost < 30, "{k}: {left} left, {lost} lost, {:?}", data.notes);
            assert!(data.notes[0].contains("loose contact"));
        }
    }

    /// A load that changes from row to row in a part of the run, single spikes, and a step of the current.
    #[test]
    fn a_fast_load_and_spikes_are_no_bursts() {
        let mut fast = with_inputs(94, |columns| {
            columns[0]
                .iter_mut()
                .enumerate()
                .skip(300)
                .take(60)
                .for_each(|(k, i)| *i = if k % 2 == 0 { 9.0 } else { 0.0 });
        });
        assert!(!aside(&mut fast, WINDING).contains(&true), "{:?}", fast.notes);
        let mut spikes = experiment(95);
        column(&mut spikes, HOUSING).iter_mut().step_by(40).for_each(|x| *x += 6.0);
        assert!(!aside(&mut spikes, HOUSING).contains(&true), "{:?}", spikes.notes);
    }
}
