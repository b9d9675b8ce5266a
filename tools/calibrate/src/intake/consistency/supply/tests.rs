//! Current and voltage of the drive's supply in place of the motor's.

use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::intake::check;
use crate::intake::tests::{
    AMBIENT, CURRENT, SPEED, TORQUE, VOLTAGE, column, experiment, reason, unusable, with_inputs,
};
use crate::testing::{self, normal, rng};

/// The same motor, driven by the voltage: the columns of voltage and current are exchanged.
fn by_voltage(mut own: Experiment) -> Experiment {
    let outputs = ["current_A", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"];
    let mut other = testing::driven_by(("voltage_V", 1.0, 190.0), &outputs, testing::PRIORS, true);
    own.runs.iter_mut().for_each(|run| run.table.columns.swap(CURRENT, VOLTAGE));
    (other.runs, other.priors) = (own.runs, own.priors);
    other.noise.clear();
    other
}

/// The same motor, driven by pulse width modulation: the column of the voltage is that of the supply.
fn by_duty(own: Experiment) -> Experiment {
    let outputs = ["current_A", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"];
    let mut pwm = testing::driven_by(("duty_1", 0.1, 190.0), &outputs, testing::PRIORS, true);
    let own = by_voltage(own);
    pwm.inputs.insert(0, own.inputs[CURRENT]);
    (pwm.runs, pwm.priors) = (own.runs, own.priors);
    pwm.noise.clear();
    for run in &mut pwm.runs {
        let (columns, rows) = (&mut run.table.columns, run.table.time.len());
        let volts = std::mem::replace(&mut columns[CURRENT], vec![24.0; rows]);
        columns.insert(1, volts.iter().map(|v| v / 24.0).collect());
    }
    pwm
}

/// Three files of one motor.
fn three() -> Experiment {
    let mut all = experiment(51);
    for (n, seed) in [(2, 52), (3, 53)] {
        let mut run = with_inputs(seed, |columns| columns[CURRENT].rotate_right(37 * n)).runs.remove(0);
        run.file = format!("run-{n}.csv");
        all.runs.push(run);
    }
    all
}

/// The current of a supply with this product of voltage and efficiency and this quiescent current, in one run or in all.
fn at_supply(experiment: &mut Experiment, of: Option<usize>, (product, quiescent): (f64, f64)) {
    let mut rng = rng(54);
    for (_, run) in experiment.runs.iter_mut().enumerate().filter(|(k, _)| of.is_none_or(|of| of == *k)) {
        for row in 0..run.table.time.len() {
            let (i, v) = (run.table.columns[CURRENT][row], run.table.columns[VOLTAGE][row]);
            run.table.columns[CURRENT][row] = v * i / product + quiescent + 0.002 * normal(&mut rng);
        }
    }
}

/// The product in a reason.
fn product(reason: &str) -> f64 {
    let found = reason.split("efficiency of ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok());
    found.unwrap_or_else(|| panic!("{reason}"))
}

/// Several supplies; the current as an input and as an output, also of pulse width modulation, and in both directions.
#[test]
fn the_current_of_the_supply_is_unusable() {
    let input = |own: Experiment| own;
    let drives: [fn(Experiment) -> Experiment; 3] = [input, by_voltage, by_duty];
    for (supply, drive) in [
        ((18.0, 0.0), 0),
        ((24.0, 0.1), 0),
        ((90.0, 0.03), 0),
        ((18.0, 0.1), 1),
        ((46.0, 0.0), 1),
        ((30.0, 0.05), 2),
    ] {
        for is_reversing in [false, drive == 0] {
            let mut wrong = with_inputs(55, |columns| {
                let sign = |row: usize| if is_reversing && row / 240 % 2 == 1 { -1.0 } else { 1.0 };
                columns[..AMBIENT - 1]
                    .iter_mut()
                    .for_each(|column| column.iter_mut().enumerate().for_each(|(row, x)| *x *= sign(row)));
            });
            at_supply(&mut wrong, None, supply);
            let reason = reason(&mut drives[drive](wrong));
            assert!(reason.starts_with("current_A: current_A in every run contra"), "{supply:?}: {reason}");
            assert!((product(&reason) / supply.0 - 1.0).abs() < 0.05, "{supply:?} {drive}: {reason}");
        }
    }
}

/// In one file of three.
#[test]
fn the_current_of_the_supply_in_one_file_is_unusable() {
    for (run, file, supply) in [(0, "run.csv", (24.0, 0.05)), (1, "run-2.csv", (40.0, 0.0))] {
        let mut wrong = three();
        at_supply(&mut wrong, Some(run), supply);
        let mut output = by_voltage(wrong.clone());
        for data in [&mut wrong, &mut output] {
            let reason = reason(data);
            let words = format!(
                "current_A: current_A in {file} contradicts the model; as the current of the drive's supply"
            );
            assert!(reason.starts_with(&words), "{supply:?}: {reason}");
            assert!((product(&reason) / supply.0 - 1.0).abs() < 0.05, "{supply:?}: {reason}");
        }
    }
}

/// The voltage of a supply with a resistance of 50 mOhm, or of a battery that is discharged by 3 %, in one run or in all.
fn bus(experiment: &mut Experiment, of: Option<usize>, (voltage, is_battery): (f64, bool)) {
    let mut rng = rng(56);
    for (_, run) in experiment.runs.iter_mut().enumerate().filter(|(k, _)| of.is_none_or(|of| of == *k)) {
        let rows = run.table.time.len();
        for row in 0..rows {
            let power = run.table.columns[CURRENT][row] * run.table.columns[VOLTAGE][row];
            let sag =
                if is_battery { 0.03 * voltage * row as f64 / rows as f64 } else { 0.05 * power / voltage };
            run.table.columns[VOLTAGE][row] = voltage - sag + 0.02 * normal(&mut rng);
        }
    }
}

/// As an output it is set aside with the cause; as an input it is unusable.
#[test]
fn the_voltage_of_the_supply_is_named() {
    for (of, supplies) in [(None, [(18.0, false), (48.0, true)]), (Some(1), [(24.0, true), (80.0, false)])] {
        for supply in supplies {
            let mut wrong = three();
            bus(&mut wrong, of, supply);
            let mut input = by_voltage(wrong.clone());
            assert_eq!(check(&mut wrong, &[], &Deadline::default()), Ok(true), "{supply:?} {of:?}");
            for (k, run) in wrong.runs.iter().enumerate() {
                let is_blank = run.table.columns[VOLTAGE].iter().all(|v| v.is_nan());
                assert_eq!(is_blank, of.is_none_or(|of| of == k), "{supply:?} {of:?}: {:?}", wrong.notes);
            }
            assert!(wrong.notes.iter().all(|n| n.contains("bus voltage")), "{supply:?}: {:?}", wrong.notes);
            let reason = reason(&mut input);
            let file = of.map_or("every run", |_| "run-2.csv");
            assert!(
                reason.starts_with(&format!("voltage_V: voltage_V in {file} hardly")),
                "{supply:?}: {reason}"
            );
        }
    }
}

/// A gain of the current, a drag that the model lacks, and pulse width modulation with the voltage of the supply in its column.
#[test]
fn other_data_are_not_of_the_supply() {
    for factor in [0.3, 1.4] {
        let mut gain = experiment(57);
        column(&mut gain, CURRENT).iter_mut().for_each(|i| *i *= factor);
        for data in [&mut gain.clone(), &mut by_voltage(gain)] {
            let reason = reason(data);
            assert!(!reason.contains("supply"), "{factor}: {reason}");
        }
    }
    for power in [1, 2] {
        let mut drag = experiment(58);
        let speed = column(&mut drag, SPEED).clone();
        for (torque, w) in column(&mut drag, TORQUE).iter_mut().zip(speed) {
            *torque -= 0.02 * (w / 400.0).powi(power);
        }
        assert_eq!(unusable(&mut drag), None, "{power}: {:?}", drag.notes);
    }
    let mut pwm = by_duty(experiment(59));
    assert_eq!(unusable(&mut pwm), None, "{:?}", pwm.notes);
}
