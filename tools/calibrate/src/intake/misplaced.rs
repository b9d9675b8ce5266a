//! A thermometer that lies at the place of another one: a thermocouple that has slipped from the winding to the housing.
//!
//! ```text
//! spread(y_a - y_b) < c spread(p_a - p_b)                                                  (1)
//! 1/4 < sum y_k^2 / sum p_k^2 < 4    for each measured current, voltage and power             (2)
//! ```
//! y are the readings of two thermometers of the motor, p the predictions of the preset, c the least fraction of a difference that a sensor at
//! its place shows. The heat between two nodes and their resistance are within a factor of two of the preset's. Of the two the one that is
//! predicted to be hotter has left its place: what comes loose gets colder. A frozen sensor varies against the other one, and is none of this.
//! Without (2) the predicted heat is another one than the motor's, for example because a speed in rpm was read as one in rad/s, and nothing
//! follows from (1).
//! *Source*: parity equation of two redundant sensors, Isermann, Fault-Diagnosis Systems (2006), ch. 10.

use super::response::{CLEAR, ENOUGH, LEVEL, spread};
use super::{all_runs, predicted};
use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::noise;
use physics::declare::Unit;

/// (2). Limit: a loss within a factor of two of the preset's, as a square of the current by a resistance within the same factor.
const HEAT: f64 = 4.0;

/// Sets aside, in each run, the thermometers that show the temperature of another one, with notes.
pub fn set_aside(experiment: &mut Experiment, preset: &[(u32, f64)], deadline: &Deadline) {
    let warm = experiment.thermometers();
    if warm.len() < 2 {
        return;
    }
    let predicted = predicted(experiment, preset, &all_runs(experiment), deadline);
    for (run, model) in predicted.iter().enumerate() {
        if !is_heat(experiment, model, run) {
            continue;
        }
        let pairs = warm.iter().flat_map(|a| warm.iter().map(move |b| (*a, *b))).filter(|(a, b)| a != b);
        for (own, other) in pairs.collect::<Vec<_>>() {
            let Some(difference) = shows_another(experiment, model, run, (own, other)) else { continue };
            let [name, place] = [own, other].map(|k| experiment.outputs[k].column);
            experiment.notes.push(format!(
                "{}: {name} shows the temperature of {place}, from which it should differ by up to {difference:.1} K: the sensor has left its \
                 place; it is set aside in this run",
                experiment.runs[run].file
            ));
            let column = experiment.place_of(own);
            experiment.runs[run].table.columns[column].fill(f64::NAN);
        }
    }
}

/// (2): whether the heat of a run can be the predicted one.
fn is_heat(experiment: &Experiment, model: &[Vec<f64>], run: usize) -> bool {
    let electrical =
        |k: &usize| matches!(experiment.outputs[*k].unit, Unit::Ampere | Unit::Volt | Unit::Watt);
    (0..experiment.outputs.len()).filter(electrical).all(|output| {
        let both = experiment.readings(run, output).iter().zip(model.get(output).into_iter().flatten());
        let squares = both.filter(|(y, p)| (*y + *p).is_finite()).map(|(y, p)| (y * y, p * p));
        let (read, expected) = squares.fold((0.0, 0.0), |sum, square| (sum.0 + square.0, sum.1 + square.1));
        read + expected == 0.0 || (expected < HEAT * read && read < HEAT * expected)
    })
}

/// (1): the greatest difference that is predicted, K, if the sensor of an output, which is predicted to be hotter, shows the temperature of
/// another one instead.
fn shows_another(
    experiment: &Experiment,
    model: &[Vec<f64>],
    run: usize,
    (own, other): (usize, usize),
) -> Option<f64> {
    let (a, b) = (experiment.readings(run, own), experiment.readings(run, other));
    let (p, q) = (model.get(own)?, model.get(other)?);
    let rows: Vec<usize> =
        (0..a.len()).filter(|row| (a[*row] + b[*row] + p[*row] + q[*row]).is_finite()).collect();
    if rows.len() < ENOUGH {
        return None;
    }
    let between = |a: &[f64], b: &[f64]| -> Vec<f64> { rows.iter().map(|row| a[*row] - b[*row]).collect() };
    let (read, expected) = (between(a, b), between(p, q));
    let time: Vec<f64> = rows.iter().map(|row| experiment.runs[run].table.time[*row]).collect();
    let sigma = noise::of_column(&time, &read).unwrap_or(0.0);
    // What the noise alone would show.
    let (shown, least) = (spread(&read), LEVEL.0 * spread(&expected));
    let is_hotter = expected.iter().sum::<f64>() > 0.0;
    (is_hotter && CLEAR * sigma < least && shown < least)
        .then(|| expected.iter().fold(0.0, |most: f64, x| most.max(*x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{experiment, normal, read, rng};

    /// The notes of a motor whose winding thermometer is changed: row, reading of the winding, of the housing.
    fn notes(change: impl Fn(usize, f64, f64) -> f64) -> (Vec<String>, bool) {
        notes_with(1.0, change)
    }

    /// The same with readings of the voltage times a factor.
    fn notes_with(factor: f64, change: impl Fn(usize, f64, f64) -> f64) -> (Vec<String>, bool) {
        let mut own = experiment("\"thermal.C_h\" = 0.1", true);
        read(&mut own, &[150.0], None);
        let [winding, housing] = [2, 3].map(|output| own.place_of(output));
        let voltage = own.place_of(0);
        let columns = &mut own.runs[0].table.columns;
        columns[voltage].iter_mut().for_each(|x| *x *= factor);
        let mut noise = rng(5);
        for row in 0..columns[winding].len() {
            columns[housing][row] += 0.005 * normal(&mut noise);
            columns[winding][row] =
                change(row, columns[winding][row], columns[housing][row]) + 0.005 * normal(&mut noise);
        }
        set_aside(&mut own, &[], &Deadline::default());
        let is_blank = own.runs[0].table.columns[winding].iter().all(|x| x.is_nan());
        (own.notes, is_blank)
    }

    /// On the housing, with an offset of its own, with a twentieth of the way back.
    #[test]
    fn a_sensor_at_the_place_of_another_is_set_aside() {
        let slipped: [fn(usize, f64, f64) -> f64; 3] = [
            |_, _, housing| housing,
            |_, _, housing| housing + 1.4,
            |_, own, housing| housing + 0.05 * (own - housing),
        ];
        for (k, change) in slipped.into_iter().enumerate() {
            let (notes, is_blank) = notes(change);
            assert!(is_blank && notes[0].contains("winding_temperature_degC shows"), "{k}: {notes:?}");
        }
    }

    /// The heat is not the predicted one: where no sensor has slipped, the readings of both are as near to each other.
    #[test]
    fn without_the_predicted_heat_nothing_follows() {
        for (factor, is_said) in [(0.4, false), (0.7, true), (1.5, true), (9.549, false)] {
            assert_eq!(notes_with(factor, |_, _, housing| housing).1, is_said, "{factor}");
        }
    }

    /// At its place; with half of the difference, which another motor may have; frozen; exchanged with the housing's.
    #[test]
    fn others_are_not() {
        let others: [fn(usize, f64, f64) -> f64; 4] = [
            |_, own, _| own,
            |_, own, housing| housing + 0.5 * (own - housing),
            |_, _, _| 310.0,
            |_, own, housing| 2.0 * housing - own,
        ];
        for (k, change) in others.into_iter().enumerate() {
            assert_eq!(notes(change), (Vec::new(), false), "{k}");
        }
    }
}
