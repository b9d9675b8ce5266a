//! An outcome with something of everything, for tests.

use calibrate::experiment::Role;
use calibrate::outcome::{
    BlackBox, ChannelError, Curve, Curves, Estimate, Evidence, Follows, Found, Limit, Localised, Outcome,
    Prediction, Setting, Unexplained, Verdict, Whiteness,
};
use calibrate::report::{Provenance, Replay, ReplayedChannel};
use describe::{Driver, GenericTerm, Port};

fn estimate(name: &str, value: f64, half: f64, prior: f64, unit: &'static str) -> Estimate {
    Estimate { name: name.to_owned(), value, ci95: (value - half, value + half), prior, unit }
}

/// A term that drags with the power 0.75 of the speed.
fn term() -> GenericTerm {
    let text = r#"{"format": "motor-fmu effects 1", "terms": [{"port": "drag_torque", "coefficient": 2e-3,
        "drivers": [{"driver": "speed", "reference": 500.0, "exponent": 0.75}]}]}"#;
    archive::build::TermsFile::parse(text, "sample").unwrap().terms().unwrap()[0]
}

fn found(id: &str) -> Found {
    Found {
        id: id.to_owned(),
        port: Port::DragTorque,
        follows: Follows::Driver(Driver::Speed),
        alternatives: vec!["viscous_friction".to_owned()],
        weights: vec![0.75, 0.25],
        runs: vec!["run-1.csv".to_owned()],
        everywhere: false,
        parameters: vec![estimate("k", 9.5e-5, 4e-6, 0.0, "N.m.s^0.5")],
        term: None,
        separating_experiment: Some("run at 1500 rad/s without load: 2.1 mN.m against 3.4 mN.m".to_owned()),
        delta_bic: 120.0,
        delta_bic_whitened: 80.0,
        delta_validation: Some(60.0),
        validation_ratio: Some(0.41),
        magnitude: "changes voltage by at most 0.3 V".to_owned(),
    }
}

fn curves(run: usize, file: &str, role: Role) -> Curves {
    let time: Vec<f64> = (0..300).map(|k| 10.0 * f64::from(k)).collect();
    let outputs = ["voltage_V", "winding_temperature_degC"].map(|column| {
        let of = |off: f64| time.iter().map(|t| 20.0 + (t / 300.0).sin() + off * (t / 900.0).cos()).collect();
        let mut measured: Vec<f64> = of(0.0);
        measured[7] = f64::NAN;
        Curve {
            column,
            measured,
            before: of(3.0),
            refit: of(0.5),
            after: of(0.05),
            half_width: vec![0.2; 300],
        }
    });
    Curves { run, file: file.to_owned(), role, window: Some((0.0, 2000.0)), time, outputs: outputs.to_vec() }
}

/// The outcome with a verdict; what does not belong to it is left out.
pub fn outcome(verdict: Verdict) -> Outcome {
    let effects = match verdict {
        Verdict::Named | Verdict::Class => vec![found("iron_loss")],
        Verdict::Unexplained => vec![Found {
            term: Some(term()),
            alternatives: Vec::new(),
            weights: vec![1.0],
            separating_experiment: None,
            everywhere: true,
            parameters: vec![estimate("exponent", 0.75, 0.03, 0.0, "1")],
            ..found("generic_term")
        }],
        Verdict::Nothing | Verdict::Fitted => Vec::new(),
    };
    let unexplained = (verdict == Verdict::Unexplained).then(|| Unexplained {
        port: Port::DragTorque,
        follows: Follows::Driver(Driver::Speed),
        shape: (0..8).map(|k| (100.0 * f64::from(k), 2e-4 * f64::from(k), 3e-5)).collect(),
        added: true,
    });
    let limit = Limit { id: "iron_loss".to_owned(), symbol: "k", size: 2e-6, unit: "N.m.s^0.5" };
    let candidate_row = |name: &str, accepted: bool, reason: &str| Evidence {
        round: 1,
        name: name.to_owned(),
        port: Port::DragTorque,
        delta_bic: 120.0,
        delta_bic_whitened: 80.0,
        delta_validation: Some(60.0),
        probability: if accepted { 0.8 } else { 0.2 },
        validation_ratio: accepted.then_some(0.41),
        accepted,
        reason: reason.to_owned(),
    };
    let error = |role, column, before| ChannelError {
        role,
        column,
        before,
        refit: 0.5,
        after: 0.11,
        floor: 0.1,
        instruments: 0.0,
        blackbox: Some(0.7),
        prediction: Prediction { half_width: 0.2, inside: 0.95 },
    };
    let export = Setting {
        file: "run-2.csv".to_owned(),
        role: Role::Test,
        values: vec![("motor.R_ref".to_owned(), 0.391), ("drive_mode".to_owned(), 3.0)],
        terms: if verdict == Verdict::Unexplained { vec![term()] } else { Vec::new() },
    };
    Outcome {
        name: "bench <17>".to_owned(),
        model: "AnnulusCooledMotor",
        verdict,
        effects,
        unexplained,
        released: Vec::new(),
        parameters: vec![
            estimate("motor.R_ref", 0.391, 0.002, 0.386, "Ohm"),
            estimate("thermal.C_w", 9.8, f64::NAN, 10.05, "J/K"),
        ],
        refit: vec![
            estimate("motor.R_ref", 0.402, 0.002, 0.386, "Ohm"),
            estimate("thermal.C_w", 14.2, 0.6, 10.05, "J/K"),
        ],
        of_runs: vec![(
            "run-1.csv".to_owned(),
            estimate("effect.winding_sensor_offset.offset", 0.7, 0.2, 0.0, "K"),
        )],
        correlated: vec![("thermal.C_w".to_owned(), "thermal.R_wh".to_owned(), -0.97)],
        errors: vec![
            error(Role::Fit, "voltage_V", 1.9),
            error(Role::Fit, "winding_temperature_degC", 8.0),
            error(Role::Test, "voltage_V", 2.9),
            error(Role::Test, "winding_temperature_degC", f64::NAN),
        ],
        localised: vec![
            Localised { port: Port::DragTorque, share: 0.92, follows: Follows::Driver(Driver::Speed) },
            Localised { port: Port::WindingHeat, share: 0.31, follows: Follows::Nothing },
        ],
        candidate_table: vec![
            candidate_row("iron_loss", true, "it halves the error on what was not fitted"),
            candidate_row(
                "drag_torque ~ speed^0.75",
                false,
                "iron_loss explains the same with a number less",
            ),
        ],
        whiteness: vec![Whiteness {
            column: "voltage_V",
            blocks_refit: 14.0,
            blocks_after: 1.1,
            autocorrelation: (0.83, 0.02),
        }],
        limits: if verdict == Verdict::Nothing { vec![limit] } else { Vec::new() },
        curves: vec![curves(0, "run-1.csv", Role::Fit), curves(1, "run-2.csv", Role::Test)],
        settings: vec![export.clone(), export.clone()],
        export,
        endings: Vec::new(),
        boxes: vec![BlackBox {
            column: "voltage_V",
            kind: "ARX of order 2, interval 10.0 s".to_owned(),
            errors: vec![(Role::Fit, 0.7)],
        }],
        is_cut: false,
        left_out: None,
        notes: vec![
            "run-1.csv: housing_temperature_degC reads -40 degC and is set aside as dead".to_owned(),
            "iron_loss acts in some runs only; thermal.C_w = 5.00 J/K is at its limit".to_owned(),
        ],
        seconds: 3.2,
    }
}

pub fn replay() -> Replay {
    let channel = ReplayedChannel {
        standard: "fmi3",
        column: "voltage_V",
        rmse: 0.11,
        after: 0.11,
        range: 40.0,
        difference: 2e-9,
        difference_of_a_value: 3e-8,
    };
    Replay {
        greatest_difference: 2e-9,
        greatest_difference_of_a_value: 3e-8,
        limit: 1e-6,
        agrees: true,
        replayed: vec!["run-2.csv".to_owned()],
        role: "test",
        start_values: [("run-2.csv".to_owned(), [("initial.winding_temperature".to_owned(), 331.5)].into())]
            .into(),
        channels: vec![channel],
    }
}

pub fn made_of() -> Provenance {
    Provenance {
        program: "motor-fmu 1.0.0".to_owned(),
        data_sha256: "c0ffee".to_owned(),
        date: "2026-03-01T12:00:00Z".to_owned(),
    }
}

/// The experiment that the outcome is of, in a folder of its own.
pub fn experiment() -> calibrate::experiment::Experiment {
    let folder = tempfile::tempdir().unwrap();
    let mut run = String::from(
        "time_s,current_A,speed_rad_per_s,ambient_temperature_degC,voltage_V,winding_temperature_degC\n",
    );
    for k in 0..300 {
        run += &format!("{},{},100,20,3,20\n", 10 * k, 1 + k / 60 % 3);
    }
    for file in ["run-1.csv", "run-2.csv"] {
        std::fs::write(folder.path().join(file), &run).unwrap();
    }
    let file = folder.path().join("experiment.toml");
    let text = r#"
        [experiment]
        name = "bench <17>"
        model = "AnnulusCooledMotor"
        preset = "maxon-305015"
        inputs = ["current_A", "speed_rad_per_s", "ambient_temperature_degC"]
        outputs = ["voltage_V", "winding_temperature_degC"]
        [prior]
        "motor.R_ref" = 0.03
        "thermal.C_w" = 0.1
        [noise]
        winding_temperature_degC = 0.1
        [[run]]
        file = "run-1.csv"
        role = "fit"
        [[run]]
        file = "run-2.csv"
        role = "test"
    "#;
    std::fs::write(&file, text).unwrap();
    calibrate::experiment::Experiment::read(&file).unwrap()
}
