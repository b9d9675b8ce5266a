//! The importer's relative tolerance reaches the integrator: in every model, in both standards.

use crate::common::{CS2, CS3, How, Importer, KINDS, MODELS, MOTOR, Options, Succeeds, shortened};
use motor_fmu::logger::Status;
use physics::model::ModelType;

struct Case {
    model: usize,
    start: &'static [(&'static str, f64)],
    outputs: &'static [&'static str],
    /// Communication step size, s, and number of steps.
    h: f64,
    steps: u32,
}

const CASES: &[Case] = &[
    Case {
        model: 0,
        start: &[("voltage", 24.0), ("effect.windage.k", 1e-7), ("effect.iron_loss.k", 1e-4)],
        outputs: &["current", "shaft_speed", "winding_temperature", "energy_electrical"],
        h: 0.05,
        steps: 8,
    },
    Case {
        model: 0,
        start: &[("drive_mode", 3.0), ("current_command", 8.0), ("cooling_mode", 4.0), ("fan_command", 0.7)],
        outputs: &["shaft_speed", "winding_temperature", "housing_temperature", "magnet_temperature"],
        h: 5.0,
        steps: 8,
    },
    Case {
        model: 1,
        start: &[("duty", 0.7), ("load_torque", 0.2), ("effect.coulomb_friction.tau_c", 1e-3)],
        outputs: &["current", "shaft_speed", "winding_temperature", "work_mechanical"],
        h: 0.1,
        steps: 8,
    },
    Case {
        model: 2,
        start: &[
            ("torque_demand", 20.0),
            ("transmission.coupling", 2.0),
            ("joint_speed", 0.3),
            ("motor_speed", 3.0),
        ],
        outputs: &["joint_torque", "load_torque", "voltage"],
        h: 0.1,
        steps: 8,
    },
    Case {
        model: 3,
        start: &[("gait.variation", 0.05), ("joint_torque", 10.0)],
        outputs: &["joint_angle", "torque_demand", "energy_demand"],
        h: 0.1,
        steps: 20,
    },
];

impl Case {
    fn kind(&self) -> &'static ModelType {
        &MODELS[self.model]
    }

    /// Outputs at every communication point, with steps divided by `parts`.
    fn run(&self, how: How, tolerance: Option<f64>, parts: u32) -> Vec<f64> {
        let one = Importer::instantiated(self.kind(), how, Options::default());
        for (name, value) in self.start {
            one.set(name, *value).ok();
        }
        one.enter(tolerance, 0.0).ok();
        one.exit_initialization().ok();
        let mut seen = Vec::new();
        let h = self.h / f64::from(parts);
        for k in 0..shortened((self.steps * parts) as usize, 1) as u32 {
            one.step(f64::from(k) * h, h).ok();
            if (k + 1) % parts == 0 {
                seen.extend(self.outputs.iter().map(|name| one.get(name)));
            }
        }
        seen
    }

    /// The largest deviation from the reference, in fractions of the largest or the nominal value of each output.
    fn error(&self, values: &[f64], reference: &[f64]) -> f64 {
        let n = self.outputs.len();
        let worst = (0..n).map(|k| {
            let column = |all: &[f64]| all.iter().skip(k).step_by(n).copied().collect::<Vec<f64>>();
            let (one, other) = (column(values), column(reference));
            let nominal = (self.kind().declaration)().by_name(self.outputs[k]).unwrap().row.nominal;
            let size = other.iter().fold(nominal, |size, x| size.max(x.abs()));
            one.iter().zip(&other).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs() / size))
        });
        worst.fold(0.0, f64::max)
    }
}

/// Tolerances of 1e-2 and 1e-8 give errors that differ by orders of magnitude and stay below ten times the tolerance, or rounding.
#[test]
#[cfg_attr(miri, ignore = "accuracy of the integrator; the other tests make the same calls")]
fn the_error_follows_the_tolerance() {
    for case in CASES {
        let name = (case.kind().declaration)().name;
        let reference = case.run(CS2, Some(1e-9), 40);
        let errors = [1e-2, 1e-4, 1e-6, 1e-8].map(|t| case.error(&case.run(CS2, Some(t), 1), &reference));
        println!("{name}: {errors:?}");
        assert!(errors[0] > 30.0 * errors[3], "{name}: {errors:?}");
        assert!(errors.iter().zip([1e-1, 1e-3, 1e-5, 1e-6]).all(|(e, most)| *e < most), "{name}: {errors:?}");
        assert!(errors.is_sorted_by(|a, b| *b <= a * 1.5), "{name}: {errors:?}");
    }
}

/// Without a tolerance the results are those of 1e-6, bit for bit; both standards agree; a saved state carries the tolerance.
#[test]
fn the_default_is_a_millionth_in_both_standards() {
    for case in CASES.iter().skip(shortened(0, CASES.len() - 1)) {
        let bits = |how, tolerance| -> Vec<u64> {
            case.run(how, tolerance, 1).iter().map(|value| value.to_bits()).collect()
        };
        let usual = bits(CS2, None);
        assert_eq!(usual, bits(CS2, Some(1e-6)));
        assert_eq!(usual, bits(CS3, None));
        assert_ne!(usual, bits(CS2, Some(1e-2)));
        assert_eq!(bits(CS2, Some(1e-2)), bits(CS3, Some(1e-2)));
        assert_eq!(bits(CS2, Some(1e-2)), bits(CS2, Some(0.5)), "tolerances above 1e-2 act as 1e-2");
        assert_eq!(bits(CS2, Some(1e-9)), bits(CS2, Some(1e-14)), "tolerances below 1e-9 act as 1e-9");
    }
}

#[test]
fn a_saved_state_carries_the_tolerance() {
    let start = |tolerance| {
        let one = Importer::instantiated(MOTOR, CS2, Options::default());
        one.set("voltage", 24.0).ok();
        one.enter(tolerance, 0.0).ok();
        one.exit_initialization().ok();
        one.step(0.0, 0.05).ok();
        one
    };
    let (loose, usual) = (start(Some(1e-2)), start(None));
    usual.take_over(*loose);
    for one in [&loose, &usual] {
        one.step(0.05, 0.05).ok();
    }
    assert_eq!(loose.outputs(), usual.outputs());
}

#[test]
fn a_tolerance_that_is_none_is_refused() {
    for how in KINDS {
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            let one = Importer::instantiated(MOTOR, how, Options::default());
            assert_eq!(one.enter(Some(bad), 0.0), Status::Error, "{bad}");
            one.enter(Some(1e-4), 0.0).ok();
        }
    }
}
