//! Inputs that saturate: in every model, both standards and both interface types.

use crate::common::{CS2, Importer, KINDS, LOGGED, MODELS, MOTOR, Succeeds, shortened, vr};
use motor_fmu::logger::Status;
use physics::declare::{Causality, Variability};
use physics::model::{Entry, ModelType};

/// All models, and all of their inputs, with a flag for those that saturate.
fn inputs() -> impl Iterator<Item = (&'static ModelType, &'static Entry)> {
    MODELS.iter().flat_map(|kind| {
        let inputs = (kind.declaration)().entries.iter();
        inputs.filter(|e| e.row.causality == Causality::Input).map(move |entry| (kind, entry))
    })
}

/// Start values with which the input acts.
fn modes(kind: &ModelType, entry: &Entry) -> Vec<(&'static str, f64)> {
    match ((kind.declaration)().name, entry.name.as_str()) {
        ("AnnulusCooledMotor", "duty") => vec![("drive_mode", 2.0), ("voltage", 24.0)],
        ("AnnulusCooledMotor", "fan_command") => vec![("drive_mode", 3.0), ("current_command", 3.0)],
        _ => Vec::new(),
    }
}

#[test]
fn duty_and_fan_command_saturate_and_nothing_else() {
    let names: Vec<String> = inputs()
        .filter(|(_, entry)| entry.row.saturates)
        .map(|(kind, entry)| format!("{}.{}", (kind.declaration)().name, entry.name))
        .collect();
    assert_eq!(names, ["AnnulusCooledMotor.duty", "AnnulusCooledMotor.fan_command", "BrushedGearmotor.duty"]);
}

/// A value beyond the limits acts as the limit, bit for bit, with one warning; NaN and infinity are refused.
#[test]
fn a_value_beyond_the_limits_acts_as_the_limit() {
    for (kind, entry) in inputs().filter(|(_, entry)| entry.row.saturates) {
        for standard in KINDS {
            let values = [
                (entry.row.max + 1e-7, entry.row.max),
                (entry.row.max + 40.0, entry.row.max),
                (-7.0, entry.row.min),
            ];
            for (beyond, limit) in values.into_iter().take(shortened(3, 1)) {
                let make = || Importer::instantiated(kind, standard, LOGGED).started(&modes(kind, entry));
                let (one, two) = (make(), make());
                one.said();
                assert_eq!(one.set(&entry.name, beyond), Status::Warning);
                two.set(&entry.name, limit).ok();
                let said = one.said();
                assert!(said.len() == 1 && said[0].status == 1, "{said:?}");
                assert_eq!(said[0].category, "logStatusWarning");
                for word in [entry.name.as_str(), &beyond.to_string(), &format!("limited to {limit}")] {
                    assert!(said[0].text.contains(word), "{word} in {said:?}");
                }
                assert_eq!(one.set(&entry.name, beyond), Status::Ok, "reported once");
                assert_eq!(one.get(&entry.name), limit);
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    assert_eq!(one.set(&entry.name, bad), Status::Discard);
                }
                assert_eq!(one.get(&entry.name), limit, "a refused value changes nothing");
                if standard.1 {
                    assert_eq!(one.rates(), two.rates());
                } else {
                    for k in 0..shortened(20, 2) {
                        one.set(&entry.name, beyond).ok();
                        let at = k as f64 * 1e-3;
                        one.step(at, 1e-3).ok();
                        two.step(at, 1e-3).ok();
                    }
                    for name in ["shaft_speed", "winding_temperature", "housing_temperature"] {
                        assert_eq!(one.get(name).to_bits(), two.get(name).to_bits(), "{name}");
                    }
                }
                assert_eq!(one.said().len(), 3, "the refused values only");
                if !standard.1 {
                    one.reset().ok();
                    assert_eq!(one.set(&entry.name, beyond), Status::Warning, "a new run warns again");
                }
            }
        }
    }
}

/// Other inputs are refused beyond their limits, as before.
#[test]
fn other_inputs_are_refused_beyond_their_limits() {
    for (kind, entry) in inputs().filter(|(_, entry)| !entry.row.saturates) {
        for standard in KINDS {
            let one = Importer::instantiated(kind, standard, LOGGED);
            for beyond in [entry.row.max * (1.0 + 1e-9) + 1e-9, entry.row.min - 1e9] {
                assert_eq!(one.set(&entry.name, beyond), Status::Discard, "{}", entry.name);
            }
        }
    }
}

/// In a list every variable is limited on its own, and one invalid value refuses the whole list without a warning.
#[test]
fn variables_of_a_list_saturate_one_by_one() {
    let kind = MOTOR;
    for standard in KINDS {
        let one = Importer::instantiated(kind, standard, LOGGED).started(&[]);
        one.said();
        let list = |voltage: f64| [("duty", -1.5), ("voltage", voltage), ("fan_command", 1.5)];
        assert_eq!(one.set_all(&list(1e9)), Status::Discard);
        assert_eq!(one.said().len(), 1, "the refused voltage");
        assert_eq!((one.get("duty"), one.get("fan_command")), (0.0, 0.0));
        assert_eq!(one.set_all(&list(12.0)), Status::Warning);
        let said = one.said();
        assert!(said.len() == 2 && said.iter().all(|m| m.status == 1), "{said:?}");
        assert_eq!(["duty", "voltage", "fan_command"].map(|name| one.get(name)), [-1.0, 12.0, 1.0]);
        one.set_all(&list(13.0)).ok();
    }
}

/// An input derivative ends at the limit: the step equals two steps, the first up to the limit.
#[test]
fn an_input_derivative_ends_at_the_limit() {
    let kind = MOTOR;
    let start = [("drive_mode", 2.0), ("voltage", 24.0), ("duty", 0.9), ("fan_command", 0.2)];
    let make = || Importer::instantiated(kind, CS2, LOGGED).started(&start);
    let references = ["voltage", "duty", "fan_command"].map(vr);
    let slopes = |one: &Importer, values: [f64; 3]| one.set_slopes(&references, &[1; 3], &values);
    let (one, two) = (make(), make());
    // Duty reaches 1 after 1 ms, the fan command 0 after 2 ms; the step takes 4 ms.
    slopes(&one, [500.0, 100.0, -100.0]).ok();
    let state = one.save();
    one.said();
    assert_eq!(one.step(0.0, 4e-3), Status::Warning);
    let said = one.said();
    assert!(
        said.len() == 2 && said[0].text.contains("duty") && said[1].text.contains("fan_command"),
        "{said:?}"
    );
    for (at, h, values) in [
        (0.0, 1e-3, [500.0, 100.0, -100.0]),
        (1e-3, 1e-3, [500.0, 0.0, -100.0]),
        (2e-3, 2e-3, [500.0, 0.0, 0.0]),
    ] {
        slopes(&two, values).ok();
        two.step(at, h).ok();
    }
    let names = ["voltage", "duty", "fan_command", "current", "shaft_speed", "housing_temperature"];
    for name in names {
        let (a, b) = (one.get(name), two.get(name));
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-3), "{name}: {a} and {b}");
    }
    assert_eq!((one.get("duty"), one.get("fan_command")), (1.0, 0.0));
    // The derivatives are a part of the saved state.
    let after = names.map(|name| one.get(name).to_bits());
    one.restore(&state).ok();
    assert_eq!(one.step(0.0, 4e-3), Status::Ok, "reported once");
    assert_eq!(names.map(|name| one.get(name).to_bits()), after);
}

/// All inputs that saturate are continuous, so that a derivative can lead them to a limit.
#[test]
fn inputs_that_saturate_are_continuous_and_have_limits() {
    for (_, entry) in inputs().filter(|(_, entry)| entry.row.saturates) {
        assert_eq!(entry.row.variability, Variability::Continuous);
        assert!(entry.row.min < entry.row.max && entry.row.min.is_finite() && entry.row.max.is_finite());
    }
}
