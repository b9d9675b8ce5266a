use super::*;
use crate::experiment::Experiment;
use physics::terms::{Driver, Factor};

const TOML: &str = r#"
[experiment]
name = "t"
model = "AnnulusCooledMotor"
preset = "maxon-305015"
inputs = ["current_A", "speed_rad_per_s", "fan_command_1", "ambient_temperature_degC"]
outputs = ["voltage_V", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"]
[set]
cooling_mode = "conductance"
"effect.coulomb_friction.tau_c" = 0.005
[[run]]
file = "run.csv"
role = "fit"
"#;

/// The linearised response to a small drag that grows with the root of the speed, to a resistance and to a warmer ambient equals the
/// difference of two simulations.
#[test]
fn answers_are_those_of_simulations() {
    check_answers("", ",");
}

/// The same for a run whose initial temperatures are estimated: the estimate takes over a part of the response.
#[test]
fn answers_adapt_the_start_as_simulations_do() {
    check_answers("start = \"measured\"\n", "60,45");
}

fn check_answers(start: &str, temperatures: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = String::from(
        "time_s,current_A,speed_rad_per_s,fan_command_1,ambient_temperature_degC,voltage_V,shaft_torque_Nm,\
         winding_temperature_degC,housing_temperature_degC\n",
    );
    for k in 0..400 {
        let t = 5.0 * f64::from(k);
        let (i, w) = (3.0 + 2.0 * (t / 90.0).sin(), 300.0 + 250.0 * (t / 130.0).cos());
        let n = if k > 200 { 0.6 } else { 0.0 };
        csv.push_str(&format!("{t},{i},{w},{n},23,,,{temperatures}\n"));
    }
    std::fs::write(folder.path().join("run.csv"), csv).unwrap();
    std::fs::write(folder.path().join("experiment.toml"), format!("{TOML}{start}")).unwrap();
    let experiment = Experiment::read(&folder.path().join("experiment.toml")).unwrap();
    let bench = Bench::new(&experiment, &[]).unwrap();
    let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
    let slot = bench.declaration().by_name("motor.R_ref").unwrap().slot;
    let resistance = Probe::Parameter { slot, with: Vec::new(), way: 1e-4 };
    let probes = [Probe::Port(Port::DragTorque), resistance, Probe::Input(3, 0.0)];
    let tangent = Tangent::new(&bench, &drive, &Override::default(), &probes).unwrap();
    let flat = |columns: Vec<Vec<f64>>| -> Vec<f64> {
        (0..drive.time.len())
            .flat_map(|row| columns.iter().map(move |c| c[row]).collect::<Vec<_>>())
            .collect()
    };
    let base = flat(bench.run(&drive, &Override::default()).unwrap());
    assert!(base.iter().zip(&tangent.shown).all(|(a, b)| (a - b).abs() < 1e-9));

    let size = 1e-5;
    let factor = Factor {
        driver: Driver::Speed,
        offset: 0.0,
        reference: 100.0,
        exponent: 0.5,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: size, factors: [Some(factor), None, None] });
    let dragged = Override { terms: vec![GenericTerm::new(Port::DragTorque, law)], ..Override::default() };
    let warmer = drive.with_input(3, |_, x| x + 0.01);
    let heavier = Override { values: vec![(slot, bench.start_of(slot) + 1e-4)], ..Override::default() };
    let speed = |row: usize| (tangent.drivers[row].speed / 100.0).sqrt();
    for (probe, size, shape, other) in [
        (0, size, &speed as &dyn Fn(usize) -> f64, bench.run(&drive, &dragged).unwrap()),
        (1, 1e-4, &|_| 1.0, bench.run(&drive, &heavier).unwrap()),
        (2, 0.01, &|_| 1.0, bench.run(&warmer, &Override::default()).unwrap()),
    ] {
        let answer = tangent.response(tangent.directions[probe].as_ref().unwrap(), shape);
        let truth: Vec<f64> = flat(other).iter().zip(&base).map(|(a, b)| (a - b) / size).collect();
        for output in 0..4 {
            let of = |v: &[f64]| v.iter().skip(output).step_by(4).copied().collect::<Vec<f64>>();
            let (found, told) = (of(&answer), of(&truth));
            let most = told.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let off = found.iter().zip(&told).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off <= 0.01 * most + 1e-9, "probe {probe} output {output}: {off} of {most}");
        }
    }
}

/// Noise on the current and on the ambient sensor: linear propagation against a hundred simulations.
#[test]
fn variances_are_those_of_simulations() {
    let experiment = crate::testing::experiment("", true);
    let bench = Bench::new(&experiment, &[]).unwrap();
    let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
    let probes = [Probe::Input(0, 0.0), Probe::Input(3, 0.0)];
    let tangent = Tangent::new(&bench, &drive, &Override::default(), &probes).unwrap();
    let sigmas = [0.05, 0.1];
    let directions = tangent.directions.iter().map(|d| d.as_ref().unwrap());
    let noises: Vec<(&Direction, f64)> = directions.zip(sigmas).collect();
    let (direct, whole) = tangent.variance(&noises);
    let (trials, mut rng) = (120, crate::testing::rng(9));
    let mut sums = [0.0; 4];
    for _ in 0..trials {
        let mut inputs = drive.inputs().to_vec();
        for (k, sigma) in [0, 3].into_iter().zip(sigmas) {
            inputs[k].iter_mut().for_each(|x| *x += sigma * crate::testing::normal(&mut rng));
        }
        let shown = bench.run(&Drive::of(drive.time.clone(), inputs), &Override::default()).unwrap();
        for (output, column) in shown.iter().enumerate() {
            let base = tangent.shown.iter().skip(output).step_by(4);
            sums[output] += column.iter().zip(base).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        }
    }
    for (output, sum) in sums.iter().enumerate() {
        let told: f64 = whole.iter().skip(output).step_by(4).sum();
        let ratio = sum / f64::from(trials) / told;
        assert!((ratio - 1.0).abs() < 0.2, "output {output}: {ratio}");
    }
    // A temperature has no direct feedthrough.
    assert!(direct[2 + 4 * 200] < 0.2 * whole[2 + 4 * 200]);
}

/// An unstable state within a row, next to a stable one: its effect is bounded, and the stable one is unaffected.
#[test]
fn what_runs_away_within_a_row_is_bounded() {
    let f = DMatrix::from_row_slice(2, 2, &[900.0, 0.0, 0.1, -0.2]);
    let [keeps, first, second] = pass(&f, 2.0);
    assert!(keeps.iter().chain(first.iter()).chain(second.iter()).all(|x| x.abs() <= 2.0));
    let alone = pass(&DMatrix::from_element(1, 1, -0.2), 2.0);
    assert!((keeps[(1, 1)] - alone[0][(0, 0)]).abs() < 1e-12);
}

/// First-order storage, x' = -a x + u: analytic solutions for constant and ramp inputs.
#[test]
fn one_store_by_hand() {
    let (a, h): (f64, f64) = (0.3, 2.0);
    let [keeps, first, second] = pass(&DMatrix::from_element(1, 1, -a), h);
    let e = (-a * h).exp();
    assert!((keeps[(0, 0)] - e).abs() < 1e-12);
    assert!((first[(0, 0)] + second[(0, 0)] - (1.0 - e) / a).abs() < 1e-12);
    // A ramp from 0 to 1: (h - (1 - e)/a) / (a h).
    assert!((second[(0, 0)] - (h - (1.0 - e) / a) / (a * h)).abs() < 1e-12);
}

/// A bridge that coasts at a duty of 0 brakes at any other duty: no noise of a duty that is commanded exactly crosses this step, whatever the
/// duty of the other rows. Driven, the same noise acts as before.
#[test]
fn noise_of_an_input_does_not_cross_a_step_at_zero() {
    let text = TOML.replace(
        "\"current_A\", \"speed_rad_per_s\", \"fan_command_1\"",
        "\"duty_1\", \"voltage_V\", \"load_torque_Nm\"",
    );
    let text = text.replace(
        "outputs = [\"voltage_V\", \"shaft_torque_Nm\"",
        "outputs = [\"speed_rad_per_s\", \"current_A\"",
    );
    let variances = |zero_duty: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mut csv = String::from(
            "time_s,duty_1,voltage_V,load_torque_Nm,ambient_temperature_degC,speed_rad_per_s,current_A,winding_temperature_degC,\
             housing_temperature_degC\n",
        );
        for k in 0..200 {
            let duty = if k % 100 < 50 { 0.4 } else { 0.0 };
            csv.push_str(&format!("{},{duty},12,0.01,23,,,,\n", 0.5 * f64::from(k)));
        }
        std::fs::write(folder.path().join("run.csv"), csv).unwrap();
        let set = format!("[set]\n\"drive.zero_duty\" = \"{zero_duty}\"\n\"motor.J\" = 0.01\n");
        std::fs::write(folder.path().join("experiment.toml"), text.replace("[set]\n", &set)).unwrap();
        let experiment = Experiment::read(&folder.path().join("experiment.toml")).unwrap();
        let bench = Bench::new(&experiment, &[]).unwrap();
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let sigma = 1e-5;
        let tangent = Tangent::new(&bench, &drive, &Override::default(), &[Probe::Input(0, sigma)]).unwrap();
        let (direct, _) = tangent.variance(&[(tangent.directions[0].as_ref().unwrap(), sigma)]);
        let current = |row: usize| direct[row * 4 + 1].sqrt();
        (current(20), current(80))
    };
    let [(driven, coasting), (as_driven, braking)] = ["coast", "brake"].map(variances);
    assert!((driven / as_driven - 1.0).abs() < 0.01 && driven > 0.0, "{driven} {as_driven}");
    assert!(coasting <= 2.0 * braking && coasting < 1e-3, "{coasting} {braking}");
}
