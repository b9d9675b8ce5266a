//! Loads recorded without their sign, behind an average or AC coupling, and a file with another interval between its rows.

use super::cost::fitted;
use super::mistakes::{Mistake, mistakes};
use super::search::Found;
use super::{Judge, ROWS, is_of_one_motor, thinned};
use crate::deadline::Deadline;
use crate::experiment::{Deviation, Experiment, Role};
use crate::intake::tests::{
    CURRENT, HOUSING, SPEED, TORQUE, VOLTAGE, WINDING, column, experiment, reason, unusable, with_inputs,
};
use crate::outcome::Unusable;
use crate::setup::Setup;
use std::f64::consts::PI;

/// Steps of current and speed in both directions.
fn reversing(seed: u64) -> Experiment {
    with_inputs(seed, |columns| {
        columns[CURRENT].iter_mut().enumerate().for_each(|(k, i)| *i *= [1.0, -1.0][k / 110 % 2]);
        columns[SPEED].iter_mut().enumerate().for_each(|(k, w)| *w *= [1.0, 1.0, -1.0][k / 140 % 3]);
    })
}

#[test]
fn a_load_without_its_sign_is_unusable() {
    assert_eq!(unusable(&mut reversing(31)), None);
    for (k, channel) in [
        (CURRENT, "current_A"),
        (SPEED, "speed_rad_per_s"),
        (TORQUE, "shaft_torque_Nm"),
        (VOLTAGE, "voltage_V"),
    ] {
        // Exact, and with noise of both signs where it is near zero.
        for noise in [0.0, 2e-3] {
            let mut magnitude = reversing(31);
            let own = column(&mut magnitude, k);
            let most = own.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            own.iter_mut().enumerate().for_each(|(k, x)| *x = x.abs() + [1.0, -1.0][k % 2] * noise * most);
            let reason = reason(&mut magnitude);
            assert!(reason.starts_with(channel) && reason.contains("never negative"), "{noise}: {reason}");
        }
    }
}

/// An input that a drive averages over some rows to minutes is named with the lag; an input with a real ramp is used.
#[test]
fn an_averaged_input_is_unusable() {
    for (k, channel, tau) in
        [(SPEED, "speed_rad_per_s", 40.0), (SPEED, "speed_rad_per_s", 90.0), (CURRENT, "current_A", 60.0)]
    {
        let mut slow = experiment(32);
        let mut shown = column(&mut slow, k)[0];
        for x in column(&mut slow, k) {
            shown += (*x - shown) * (1.0 - (-3.0f64 / tau).exp());
            *x = shown;
        }
        let reason = reason(&mut slow);
        assert!(reason.starts_with(channel) && reason.contains("first-order lag of about"), "{reason}");
        let found: f64 =
            reason.split("about ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).unwrap();
        assert!((found / tau).ln().abs() < 0.5, "{tau}: {reason}");
    }
    let mut ramps = with_inputs(33, |columns| {
        for k in [CURRENT, SPEED] {
            let mut shown = columns[k][0];
            columns[k].iter_mut().for_each(|x| {
                shown += (*x - shown) * (1.0 - (-3.0f64 / 40.0).exp());
                *x = shown;
            });
        }
    });
    assert_eq!(unusable(&mut ramps), None, "{:?}", ramps.notes);
}

/// Thermocouples of another type than that of the logger, all or one.
#[test]
fn thermocouples_of_another_type_are_unusable() {
    for (columns, ratio) in [(vec![WINDING, HOUSING], 4.096 / 0.646), (vec![WINDING], 2.774 / 0.647)] {
        let mut other = experiment(35);
        for k in columns {
            column(&mut other, k).iter_mut().for_each(|x| *x = 296.15 + ratio * (*x - 296.15));
        }
        let reason = reason(&mut other);
        assert!(reason.starts_with("winding") && reason.contains("thermocouple of type"), "{reason}");
    }
}

/// What is left of a load without its first-order lag.
fn coupled(experiment: &mut Experiment, k: usize, tau: f64) {
    let mut removed = 0.0;
    for x in column(experiment, k) {
        let own = *x - removed;
        removed += own * (1.0 - (-3.0f64 / tau).exp());
        *x = own;
    }
}

/// A load behind AC coupling is named with the time constant, an input as well as an output; one that alternates about zero is used.
#[test]
fn an_ac_coupled_load_is_unusable() {
    for (k, channel, tau) in [
        (CURRENT, "current_A", 30.0),
        (SPEED, "speed_rad_per_s", 90.0),
        (TORQUE, "shaft_torque_Nm", 12.0),
        (TORQUE, "shaft_torque_Nm", 300.0),
        (VOLTAGE, "voltage_V", 60.0),
    ] {
        let mut behind = experiment(37);
        coupled(&mut behind, k, tau);
        let reason = reason(&mut behind);
        assert!(reason.starts_with(channel) && reason.contains("AC coupling) of about"), "{tau}: {reason}");
        let found = reason.split("of about ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok());
        let found: f64 = found.unwrap();
        assert!((found / tau).ln().abs() < 0.3, "{tau}: {reason}");
    }
    let mut alternating = with_inputs(38, |columns| {
        for k in [CURRENT, SPEED] {
            columns[k]
                .iter_mut()
                .enumerate()
                .for_each(|(row, x)| *x = [4.0, -4.0][row / 20 % 2] * [1.0, 60.0][k]);
        }
    });
    assert_eq!(unusable(&mut alternating), None, "{:?}", alternating.notes);
}

/// A sensor whose zero follows the housing's temperature resembles a slow high-pass filter: of an output only faster ones are tried, of an
/// input, which no effect changes, all that fit in a run.
#[test]
fn ac_coupling_of_an_output_is_faster_than_a_housing() {
    let data = experiment(39);
    let time = &data.runs[0].table.time;
    let whole = time[time.len() - 1] - time[0];
    let all = mistakes(&data);
    let slowest = |channel: usize| {
        let of = |mistake: &Mistake| match mistake {
            Mistake::Coupled(k, tau) if *k == channel => *tau / whole,
            _ => 0.0,
        };
        all.iter().map(of).fold(0.0, f64::max)
    };
    for (channel, range) in
        [(CURRENT, 0.8..1.0), (SPEED, 0.8..1.0), (TORQUE, 0.08..0.1), (VOLTAGE, 0.08..0.1)]
    {
        assert!(range.contains(&slowest(channel)), "{channel}: {}", slowest(channel));
    }
}

/// Three files of one motor.
fn three() -> Experiment {
    let mut all = experiment(34);
    for (n, seed) in [(2, 35), (3, 36)] {
        let mut run = with_inputs(seed, |columns| columns[CURRENT].rotate_right(37 * n)).runs.remove(0);
        run.file = format!("run-{n}.csv");
        all.runs.push(run);
    }
    all
}

/// One of three files has another interval between its rows than its times state; in all of them it is another motor.
#[test]
fn another_interval_in_one_file_is_unusable() {
    assert_eq!(unusable(&mut three()), None);
    for factor in [0.5, 2.0, 0.2, 0.7, 4.0] {
        let mut wrong = three();
        wrong.runs[1].table.time.iter_mut().for_each(|t| *t *= factor);
        let reason = reason(&mut wrong);
        let found = reason.split("times multiplied by ").nth(1);
        let found: Option<f64> = found.and_then(|rest| rest.split(' ').next()?.parse().ok());
        assert!(reason.starts_with("time_s: time_s in run-2.csv"), "{factor}: {reason}");
        assert!(
            (found.unwrap_or_else(|| panic!("{factor}: {reason}")) * factor - 1.0).abs() < 0.1,
            "{reason}"
        );
    }
}

/// A wrong unit in one of three files is stated of that file and as that unit, also if it spoils the fit of all files.
#[test]
fn a_wrong_unit_of_one_file_is_named_as_one() {
    for (run, k, factor, words) in [
        (1, SPEED, 30.0 / PI, "speed_rad_per_s in run-2.csv contradicts the model; readings in rpm"),
        (0, SPEED, 180.0 / PI, "speed_rad_per_s in run.csv contradicts the model; readings in deg/s"),
        (2, TORQUE, 1e3, "shaft_torque_Nm in run-3.csv contradicts the model; readings in mN.m"),
        // Not a voltage of half its value, with which only the voltage agrees.
        (2, SPEED, 2.0, "speed_rad_per_s in run-3.csv contradicts the model; speeds of 2 pole pairs"),
        (1, SPEED, 0.25, "speed_rad_per_s in run-2.csv contradicts the model; speeds times 4"),
    ] {
        let mut wrong = three();
        wrong.runs[run].table.columns[k].iter_mut().for_each(|x| *x *= factor);
        let reason = reason(&mut wrong);
        assert!(reason.contains(words), "{reason}");
    }
    let mut long = three();
    long.runs[1].table.time.iter_mut().for_each(|t| *t *= 1e3);
    let reason = reason(&mut long);
    assert!(reason.contains("time_s in run-2.csv") && reason.contains("times in ms"), "{reason}");
}

/// Times in a shorter unit are named also if the preset is far from the motor, so that no output agrees before the fit.
#[test]
fn a_time_that_no_run_of_a_bench_lasts_is_named() {
    for (factor, wide, unit) in
        [(1e3, 1.0, "times in ms"), (1e6, 1.0, "times in us"), (1e3, 1.6, "times in ms")]
    {
        let mut long = experiment(43);
        for name in ["motor.R_ref", "thermal.C_h"] {
            let setup = Setup::new(&long, &[]).unwrap();
            let own = setup.declared.iter().find(|d| d.name == name).map(|d| d.prior);
            drop(setup);
            long.set.extend(own.map(|own| (name.to_string(), wide * own)));
        }
        long.priors.iter_mut().filter(|_| wide > 1.0).for_each(|p| p.deviation = Deviation::Relative(0.5));
        long.runs.iter_mut().flat_map(|run| &mut run.table.time).for_each(|t| *t *= factor);
        let reason = reason(&mut long);
        assert!(reason.contains("time_s in every run") && reason.contains(unit), "{factor} {wide} {reason}");
    }
    // No unit makes it one of this motor.
    let mut long = experiment(44);
    long.runs.iter_mut().flat_map(|run| &mut run.table.time).for_each(|t| *t *= 1e5);
    let columns = &mut long.runs[0].table.columns;
    columns[WINDING].reverse();
    let reason = reason(&mut long);
    assert!(reason.contains("no run of a bench lasts longer than 30 days"), "{reason}");
}

/// A value of [set] that is ten times too great or too small, where the data agree with the model otherwise.
#[test]
fn a_value_of_another_order_is_named() {
    for (name, factor) in [("thermal.C_h", 10.0), ("motor.R_ref", 0.1), ("conductance.G_still", 20.0)] {
        let mut wrong = experiment(41);
        let setup = Setup::new(&wrong, &[]).unwrap();
        let own = setup.declared.iter().find(|d| d.name == name).unwrap().prior;
        drop(setup);
        wrong.priors.retain(|p| p.name != name);
        wrong.set.push((name.to_string(), factor * own));
        let reason = reason(&mut wrong);
        assert!(reason.starts_with(name) && reason.contains("contradicts the data"), "{name} {reason}");
    }
}

/// Nothing is heated in one of the runs, and the zeros of the thermometers differ there: no unit explains that.
#[test]
fn thermometers_at_rest_may_differ() {
    let mut all = three();
    let mut rest = with_inputs(42, |columns| [CURRENT, SPEED].into_iter().for_each(|k| columns[k].fill(0.0)));
    rest.runs[0].file = "rest.csv".to_string();
    rest.runs[0].table.columns[WINDING].iter_mut().for_each(|x| *x -= 0.8);
    all.runs.push(rest.runs.remove(0));
    assert_eq!(unusable(&mut all), None, "{:?}", all.notes);
}

/// Thermometers of one file read in another unit: with the right one both files are of one motor, with a wrong one they are of two. The
/// same if the other file alone is fitted.
#[test]
fn a_mistake_of_one_file_agrees_with_the_other_files() {
    for (role, factor) in [(Role::Fit, 1.8), (Role::Validate, 1.8), (Role::Fit, 0.6), (Role::Validate, 0.6)] {
        let mut right = experiment(38);
        let mut second = right.runs[0].clone();
        (second.file, second.role) = ("second.csv".to_string(), role);
        right.runs.push(second);
        let mut wrong = right.clone();
        let columns = &mut wrong.runs[1].table.columns;
        columns[WINDING..=HOUSING].iter_mut().flatten().for_each(|x| *x = 296.15 + factor * (*x - 296.15));
        let agrees = |recorded: &Experiment, meant: &Experiment, factor: f64| {
            let whole = Judge::of(&[], &[0, 1], &Deadline::default());
            let as_is = fitted(&whole, &thinned(recorded, ROWS)).unwrap();
            let (why, data) = (Unusable::new("", "", ""), thinned(meant, ROWS));
            let as_meant = fitted(&whole, &data).unwrap();
            is_of_one_motor(&whole, &as_is, as_meant, &Found { why, data, stretch: 2.0 * factor.ln() }, &[1])
        };
        assert!(agrees(&wrong, &right, 1.0 / factor), "{role:?} {factor}");
        assert!(!agrees(&right, &wrong, factor), "{role:?} {factor}");
    }
}
