//! Thermometers whose amplifier saturates before a converter with noise: their readings end at a level, and no two are alike.
//!
//! p(inside) - max(p(first), p(last)) > c_p,   |cov(y, p) / var(p)| < [`SMALL`]   over a stretch at the end        (1)
//!
//! y the readings, p the predictions by the preset and by the fit; a stretch is at the end if its readings are within [`CLEAR`] standard
//! deviations of the noise of the run's greatest (or least) level; c_p is the fraction [`SMALL`] of the prediction's variation. A motor in
//! equilibrium stands still with its prediction; here the prediction goes beyond, and comes back at the end of the stretch. One stretch shows
//! where the amplifier ends: all readings at that level are set aside. Levels that repeat exactly are those of [`super::clipped`].
//!
//! *Source*: saturation as a fault of a measuring chain: Isermann, Fault-Diagnosis Systems (2006), ch. 3.

use super::response::{CLEAR, LEAST_ROWS, Pair, TAIL, pair, slope, spread};
use super::{Predicted, sorted};
use crate::experiment::Experiment;
use crate::levels::{FACTOR, SMALL};
use crate::noise;
use crate::report::count_of;
use std::ops::Range;

/// Sets aside the readings, with notes; the predictions by the preset and by each output's fit. Result: whether there were any.
pub(super) fn set_aside(experiment: &mut Experiment, predicted: &Predicted, fitted: &Predicted) -> bool {
    let inputs = experiment.inputs.len();
    let mut found = false;
    for (output, channel) in
        experiment.outputs.clone().into_iter().enumerate().filter(|(_, c)| c.is_temperature())
    {
        for run in 0..experiment.runs.len() {
            let [preset, fit] = [predicted, fitted].map(|shown| pair(experiment, &shown[run], run, output));
            if preset.rows != fit.rows || preset.rows.len() < LEAST_ROWS {
                continue;
            }
            let own = &mut experiment.runs[run];
            let time: Vec<f64> = preset.rows.iter().map(|row| own.table.time[*row]).collect();
            let band = CLEAR * noise::of_column(&time, &preset.read).unwrap_or(0.0);
            for side in [1.0, -1.0] {
                let at_end = at_end(&preset.read, side, band);
                let is_end =
                    |part: &Range<usize>| [&preset, &fit].iter().all(|of| is_beyond(of, part, side, band));
                if !stretches(&at_end).any(|part| is_end(&part)) {
                    continue;
                }
                let rows: Vec<usize> = (0..at_end.len()).filter(|k| at_end[*k]).collect();
                rows.iter().for_each(|k| own.table.columns[inputs + output][preset.rows[*k]] = f64::NAN);
                found = true;
                let (count, from, to) = (rows.len(), time[rows[0]], time[rows[rows.len() - 1]]);
                experiment.notes.push(format!(
                    "{}: {} ends at a level while the motor goes beyond it, as a saturated amplifier does; {} from {from} s to {to} s set \
                     aside",
                    own.file,
                    channel.column,
                    count_of(count, "reading")
                ));
            }
        }
    }
    found
}

/// Whether each reading is within a band of the greatest level, or of the least.
fn at_end(read: &[f64], side: f64, band: f64) -> Vec<bool> {
    let all = sorted(read.iter().map(|y| side * y));
    let end = all[((1.0 - TAIL) * (all.len() - 1) as f64) as usize];
    read.iter().map(|y| side * y > end - band).collect()
}

/// The stretches at the end that are long enough.
fn stretches(at_end: &[bool]) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut from = 0;
    at_end.chunk_by(|a, b| a == b).filter_map(move |stretch| {
        let part = from..from + stretch.len();
        from = part.end;
        (stretch[0] && stretch.len() >= LEAST_ROWS).then_some(part)
    })
}

/// (1)
fn is_beyond(of: &Pair, part: &Range<usize>, side: f64, band: f64) -> bool {
    let (read, model) = (&of.read[part.clone()], &of.model[part.clone()]);
    let edges = (side * model[0]).max(side * model[model.len() - 1]);
    let beyond = model.iter().fold(f64::NEG_INFINITY, |most, p| most.max(side * p)) - edges;
    let is_still = slope(read, model).abs() < SMALL && spread(read) < FACTOR * SMALL * beyond + band;
    beyond > band.max(SMALL * spread(&of.model)) && is_still
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::super::tests::{HOUSING, WINDING, column, experiment, with_inputs};
    use super::*;
    use crate::deadline::Deadline;
    use crate::testing::{normal, rng};

    /// The rows of a column that are set aside.
    fn aside(data: &mut Experiment, k: usize) -> Vec<bool> {
        assert_eq!(check(data, &[], &Deadline::default()), Ok(true), "{:?}", data.notes);
        column(data, k).iter().map(|x| x.is_nan()).collect()
    }

    /// An amplifier that saturates before a converter with noise: no two readings are alike.
    #[test]
    fn readings_of_a_saturated_amplifier_are_set_aside() {
        for (seed, k, part, noise) in
            [(51, WINDING, 0.75, 0.06), (52, WINDING, 0.6, 0.1), (53, HOUSING, 0.8, 0.03)]
        {
            let mut data = experiment(seed);
            let mut rng = rng(seed + 100);
            let (least, most) =
                column(&mut data, k).iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
            let end = least + part * (most - least);
            let beyond: Vec<bool> = column(&mut data, k).iter().map(|x| *x > end + 1.0).collect();
            column(&mut data, k).iter_mut().for_each(|x| *x = x.min(end) + noise * normal(&mut rng));
            let aside = aside(&mut data, k);
            let left = beyond.iter().zip(&aside).filter(|(beyond, aside)| **beyond && !**aside).count();
            let lost = beyond.iter().zip(&aside).filter(|(beyond, aside)| !**beyond && **aside).count();
            assert!(left < 20 && lost < 150, "{k} {part}: {left} left, {lost} lost, {:?}", data.notes);
        }
    }

    /// A motor in equilibrium stands still at its greatest temperature, too.
    #[test]
    fn a_thermal_equilibrium_is_no_saturation() {
        for seed in [54, 55] {
            let mut data = with_inputs(seed, |columns| {
                columns[0].iter_mut().enumerate().for_each(|(k, i)| *i = if k < 900 { 4.0 } else { 0.0 });
                columns[1].fill(200.0);
                columns[2].fill(1.0);
            });
            for k in [WINDING, HOUSING] {
                let lost = aside(&mut data, k).iter().filter(|x| **x).count();
                assert!(lost < 20, "{k}: {lost} {:?}", data.notes);
            }
        }
    }
}
