//! Runs that start warm: what their thermometers read at first is no longer compared with the ambient temperature.

use crate::deadline::Deadline;
use crate::experiment::{CELSIUS, Experiment, Start};
use crate::intake::tests::{AMBIENT, HOUSING, WINDING, column, experiment, reason, unusable, with_inputs};
use crate::intake::{FAR, check, start::first_rises};

/// Row of the cold run at which the warm one begins.
const BEGIN: usize = 300;

/// A motor that is warm in the first row, and whose load changes then.
fn warm(seed: u64) -> Experiment {
    begun(experiment(seed))
}

fn begun(mut all: Experiment) -> Experiment {
    let run = &mut all.runs[0];
    run.start = Start::Measured;
    run.table.time.drain(..BEGIN);
    run.table.columns.iter_mut().for_each(|column| drop(column.drain(..BEGIN)));
    all
}

fn ambients(experiment: &mut Experiment) -> Vec<f64> {
    column(experiment, AMBIENT).clone()
}

#[test]
fn a_warm_motor_is_used() {
    for seed in 51..55 {
        let mut good = warm(seed);
        let readings = good.runs[0].table.columns.clone();
        assert_eq!(check(&mut good, &[], &Deadline::default()), Ok(true));
        assert_eq!(good.runs[0].table.columns, readings, "{:?}", good.notes);
    }
}

/// Corrected readings in kelvin as they are recorded, with the ambient temperature.
type Recorded = fn(f64, f64) -> f64;

const MISTAKES: [(&str, Recorded); 6] = [
    ("degF", |t, _| 1.8 * (t - CELSIUS) + 32.0 + CELSIUS),
    ("K", |t, _| t + CELSIUS),
    ("opposite sign", |t, _| 2.0 * CELSIUS - t),
    ("as temperature rises over ambient the readings", |t, ambient| t - ambient + CELSIUS),
    ("opposite sign of the rise over ambient", |t, ambient| 2.0 * ambient - t),
    ("Pt100", |t, _| 100.0 + 0.385 * (t - CELSIUS) + CELSIUS),
];

#[test]
fn a_mistake_in_one_thermometer_is_named() {
    for (words, recorded) in MISTAKES {
        for (k, channel) in [(WINDING, "winding_temperature"), (HOUSING, "housing_temperature")] {
            let mut wrong = warm(56);
            let ambient = ambients(&mut wrong);
            column(&mut wrong, k).iter_mut().zip(ambient).for_each(|(x, a)| *x = recorded(*x, a));
            let reason = reason(&mut wrong);
            assert!(reason.starts_with(channel) && reason.contains(words), "{words}: {reason}");
        }
    }
}

#[test]
fn a_mistake_in_both_thermometers_is_named() {
    for (words, recorded) in MISTAKES {
        let mut wrong = warm(57);
        let ambient = ambients(&mut wrong);
        for k in [WINDING, HOUSING] {
            column(&mut wrong, k).iter_mut().zip(&ambient).for_each(|(x, a)| *x = recorded(*x, *a));
        }
        let reason = reason(&mut wrong);
        let both = "winding_temperature_degC, housing_temperature_degC in every run";
        // The rises of both differ as little from temperatures at an ambient temperature of 2 degC.
        let is_named = reason.contains(both) && reason.contains(words);
        assert!(
            is_named || words.starts_with("rises") && reason.contains("ambient_temperature"),
            "{words}: {reason}"
        );
    }
}

/// A logger that starts late, a spike, a thermometer at ambient temperature: the rest of the run is used.
#[test]
fn first_rows_from_before_the_logger_worked_are_set_aside() {
    for (rows, read) in [(1, CELSIUS), (1, 403.15), (3, 403.15), (8, 296.15)] {
        for channels in [&[WINDING, HOUSING][..], &[HOUSING]] {
            let mut late = warm(58);
            channels.iter().for_each(|k| column(&mut late, *k)[..rows].fill(read));
            assert_eq!(unusable(&mut late), None, "{rows} {read}: {:?}", late.notes);
            for k in [WINDING, HOUSING] {
                let blank = column(&mut late, k).iter().filter(|x| x.is_nan()).count();
                // A winding may have been as cold as that before its first reading.
                let least = if k == HOUSING && channels.contains(&k) { rows } else { 0 };
                assert!((least..=rows).contains(&blank), "{rows} {read} {k}: {blank} {:?}", late.notes);
            }
        }
    }
}

#[test]
fn a_motor_that_is_a_little_warm_starts_as_measured() {
    let mut mild = begun(with_inputs(59, |columns| columns[0].iter_mut().for_each(|i| *i *= 0.5)));
    mild.runs[0].start = Start::Ambient;
    let rises = first_rises(&mild, &mild.runs[0], 296.15);
    assert!(rises.iter().all(|(_, rise)| (2.5..FAR).contains(rise)), "{rises:?}");
    assert_eq!(unusable(&mut mild), None, "{:?}", mild.notes);
    assert_eq!(mild.runs[0].start, Start::Measured);
    assert!(mild.notes.iter().any(|note| note.contains("simulated from the measured temperatures")));
}

/// A command of the opposite sense: the fan stands where it is said to run.
#[test]
fn an_inverted_command_is_named() {
    let mut inverted = with_inputs(60, |columns| {
        columns[0].iter_mut().for_each(|i| *i = 5.0);
        columns[2].iter_mut().enumerate().for_each(|(k, n)| *n = (k / 300 % 2) as f64);
    });
    column(&mut inverted, 2).iter_mut().for_each(|x| *x = 1.0 - *x);
    let reason = reason(&mut inverted);
    assert!(reason.starts_with("fan_command") && reason.contains("one minus the readings"), "{reason}");
}
