//! Properties of the whole variable table of every model.

use describe::{Dependencies, Entry, Experiment, Resources, StartValues, Unknown, generated, lock, models};
use describe::{Preset, fmi2, fmi3};
use physics::declare::{Causality, Kind, Scale};
use physics::terms::{Driver, GenericTerm, Law, Port, Table};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model-description")
}

/// A generated file of a model.
fn read(model: &str, file: &str) -> String {
    std::fs::read_to_string(folder().join(model).join(file)).unwrap()
}

fn entries() -> impl Iterator<Item = &'static Entry> {
    models::ALL.iter().flat_map(|m| &(m.declaration)().entries)
}

#[test]
fn names_and_value_references_are_unique() {
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        let names: HashSet<&str> = declaration.entries.iter().map(|e| e.name.as_str()).collect();
        let references: HashSet<u32> = declaration.entries.iter().map(|e| e.value_reference).collect();
        assert_eq!(names.len(), declaration.entries.len());
        assert_eq!(references.len(), declaration.entries.len());
        assert!(!references.contains(&physics::model::TIME), "0 is time");
    }
}

#[test]
fn every_variable_is_described_and_within_its_own_limits() {
    for e in entries() {
        let row = e.row;
        assert!(row.doc.trim().len() > 8 && !row.doc.trim().ends_with('.'), "{}: {:?}", e.name, row.doc);
        // The user of an FMU has neither the repository nor what it was made from.
        let is_there =
            ["seeds", ".rs", ".md", "tests/", "docs/"].iter().all(|place| !row.source.contains(place));
        assert!(is_there, "{}: source {:?}", e.name, row.source);
        assert!(row.nominal > 0.0 && row.nominal.is_finite(), "{}: nominal {}", e.name, row.nominal);
        match row.causality {
            Causality::Output | Causality::Local => {
                assert!(row.start.is_nan(), "{} is computed and has no start", e.name);
            }
            _ => assert_eq!(e.check(row.start, false), Ok(()), "{} = {}", e.name, row.start),
        }
        if e.is_settable() && matches!(row.kind, Kind::Real | Kind::Integer) {
            assert!(
                row.min.is_finite() && row.max.is_finite() && row.min < row.max,
                "{} has no limits",
                e.name
            );
        }
        if row.scale == Scale::Log {
            assert!(row.min > 0.0, "{} has a logarithmic scale and the lower limit {}", e.name, row.min);
        }
    }
}

/// Every effect is neutral at its declared start value.
#[test]
fn effects_are_off_by_default() {
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        for e in declaration.entries.iter().filter(|e| e.name.starts_with("effect.")) {
            let switch = e.row.doc.contains("0 switches the effect off");
            assert!(!switch || e.row.start == 0.0, "{} starts at {}", e.name, e.row.start);
        }
    }
}

#[test]
fn a_value_set_is_the_value_read() {
    for kind in models::ALL {
        let mut model = (kind.new)();
        for e in (kind.declaration)().entries.iter().filter(|e| e.is_settable()) {
            let value = if e.row.kind == Kind::Real { e.row.min } else { e.row.start };
            assert!(model.set(e.slot, value), "{}", e.name);
            assert_eq!(model.get(e.slot), value, "{}", e.name);
        }
    }
}

#[test]
fn dependencies_are_the_physics() {
    let kind = &models::ALL[0];
    let declaration = (kind.declaration)();
    let found = Dependencies::of(kind, &Resources::default(), &StartValues::default());
    let on = |list: &[Unknown], name: &str| -> Vec<&str> {
        let k = declaration.entries.iter().position(|e| e.name == name).unwrap();
        let unknown = list.iter().find(|u| u.entry == k).unwrap();
        unknown.on.iter().map(|k| declaration.entries[*k].name.as_str()).collect()
    };
    let inputs = |list: &[Unknown], name: &str| -> Vec<&str> {
        let is_input = |n: &&str| declaration.by_name(n).unwrap().row.causality == Causality::Input;
        on(list, name).into_iter().filter(is_input).collect()
    };
    assert_eq!(inputs(&found.outputs, "stator_temperature"), [""; 0], "a state depends on no input at once");
    // An output with stem loss does.
    assert_eq!(inputs(&found.outputs, "winding_temperature"), ["ambient_temperature"]);
    // The speed because of effect speed_convection, the power because of effect drive_loss; the coolant because the heat that it takes
    // counts as heat to ambient.
    let air = ["imposed_speed", "fan_command", "ambient_temperature", "ambient_pressure"];
    let cooled = [&air[..], &["electrical_power", "coolant_inlet_temperature", "coolant_flow_rate"]].concat();
    assert_eq!(inputs(&found.outputs, "heat_to_ambient"), cooled);
    assert_eq!(on(&found.outputs, "shaft_speed"), ["imposed_speed", "state.shaft_speed"]);
    assert!(!on(&found.outputs, "loss_friction").contains(&"fan_command"));
    // The drift of the ambient sensor changes a run that starts late.
    let (ambient, drift) = ("ambient_temperature", "effect.ambient_drift.rate");
    let (winding, sensor) = ("initial.winding_temperature", "effect.winding_sensor_");
    let [lag, loss, offset] =
        ["lag.tau", "stem_loss.k", "offset.offset"].map(|name| format!("{sensor}{name}"));
    let known = [ambient, winding, drift, lag.as_str(), loss.as_str(), offset.as_str()];
    assert_eq!(on(&found.initial, "winding_temperature"), known);
    assert_eq!(on(&found.initial, "over_temperature"), [ambient, "thermal.T_w_max", winding, drift]);
    // A node of its own, or the housing where there is none.
    let stator = on(&found.initial, "stator_temperature");
    for name in [ambient, "initial.stator_temperature", "initial.housing_temperature", drift] {
        assert!(stator.contains(&name), "{name}: {stator:?}");
    }
    assert_eq!(on(&found.initial, "shaft_angle"), ["initial.shaft_angle"]);
    assert!(on(&found.initial, "loss_friction").contains(&"effect.coulomb_friction.w_small"));
    // Derivatives and indicators, with those of single modes.
    assert_eq!(on(&found.rates, "der(state.shaft_angle)"), ["imposed_speed", "state.shaft_speed"]);
    let sensor = on(&found.rates, "der(state.sensor_temperature)");
    assert!(
        sensor.starts_with(&["state.core_temperature", "state.sensor_temperature", "T_housing[1]"]),
        "{sensor:?}"
    );
    let limit = on(&found.indicators, "event.over_temperature");
    assert_eq!((limit[0], limit.len()), ("state.winding_temperature", 4), "and the phases");
    assert_eq!(on(&found.outputs, "over_temperature"), limit);
    assert_eq!(on(&found.indicators, "event.commutation_sector"), ["state.shaft_angle"]);
    // The drift of the ambient sensor makes it time-dependent.
    let drifts =
        |name: &str| found.outputs.iter().any(|u| declaration.entries[u.entry].name == name && u.on_time);
    assert!(drifts("heat_to_ambient") && !drifts("current"));
}

/// The start values give the number of segments: scalars with derivatives in FMI 2, one array with a structural parameter in FMI 3.
#[test]
fn segments_are_counted_by_the_start_values() {
    let kind = &models::ALL[0];
    let declaration = (kind.declaration)();
    let preset = "name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n[start]\nair_segments = 11\n";
    let starts = Preset::parse(preset, "x.toml").unwrap().starts;
    let found = Dependencies::of(kind, &Resources::default(), &starts);
    assert_eq!(found.rates.len(), 18 + 11);
    // An element that the stored dependencies have not is like the others, but for its neighbours.
    let of_element = |k: usize| -> Vec<usize> {
        let name = format!("der(T_housing[{k}])");
        let unknown = found.initial.iter().find(|u| declaration.entries[u.entry].name == name).unwrap();
        unknown.on.iter().copied().filter(|k| declaration.entries[*k].element.is_none()).collect()
    };
    assert!(of_element(11).len() > 40 && of_element(11) == of_element(3));
    let two =
        fmi2::model_description(declaration, &starts, &Resources::default(), &found, Experiment::default());
    assert!(two.contains("\"T_housing[11]\"") && two.contains("\"der(T_housing[11])\""));
    assert!(!two.contains("T_housing[12]"));
    let three =
        fmi3::model_description(declaration, &starts, &Resources::default(), &found, Experiment::default());
    assert!(!three.contains("T_housing["));
    let line = |start: &str| three.lines().filter(|l| l.contains(start)).map(str::trim).collect::<Vec<_>>();
    let size = line("name=\"air_segments\"")[0];
    assert!(size.starts_with("<UInt64 ") && size.contains("causality=\"structuralParameter\""), "{size}");
    assert!(size.ends_with("min=\"1\" max=\"64\" start=\"11\"/>"), "{size}");
    let (state, rate) = (line("name=\"T_housing\"")[0], line("name=\"der(T_housing)\"")[0]);
    assert!(
        state.contains("causality=\"output\"") && state.contains("intermediateUpdate=\"true\""),
        "{state}"
    );
    assert!(rate.contains("causality=\"local\"") && rate.contains("derivative=\"721\""), "{rate}");
    assert_eq!(line("<Dimension valueReference=\"84\"/>").len(), 2);
    assert_eq!(line("<Dimension start=\"3\"/>").len(), 4, "phases, lags of terms, and their rates");
    // One entry for the array, and each reference once.
    for (list, reference) in [("Output", 721), ("ContinuousStateDerivative", 821), ("InitialUnknown", 821)] {
        assert_eq!(line(&format!("<{list} valueReference=\"{reference}\" ")).len(), 1, "{list}");
    }
    assert!(line("<Output valueReference=\"721\"")[0].contains("dependencies=\"721\""));
    let on = line("<ContinuousStateDerivative valueReference=\"821\"")[0];
    assert_eq!(on.matches(" 721").count(), 1, "{on}");
}

/// FMI 2 refers to a state by index, FMI 3 by value reference; each derivative refers to its own state.
#[test]
fn a_derivative_names_its_state() {
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        let [two, three] = ["fmi2.xml", "fmi3.xml"].map(|file| read(declaration.name, file));
        let variables: Vec<&str> = two.split("<ScalarVariable ").skip(1).collect();
        let name = |text: &str| text.split('"').nth(1).unwrap().to_string();
        let mut pairs = 0;
        for variable in variables.iter().filter(|v| v.contains("derivative=")) {
            let index: usize =
                variable.split("derivative=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            assert_eq!(name(variable), format!("der({})", name(variables[index - 1])));
            pairs += 1;
        }
        assert!(pairs > 0, "{}", declaration.name);
        let line = |name: &str| three.lines().find(|l| l.contains(&format!("name=\"{name}\""))).unwrap();
        let [state, rate] = declaration.states[0].map(|k| &declaration.entries[k]);
        assert!(line(&rate.name).contains(&format!("derivative=\"{}\"", state.value_reference)));
    }
}

/// A generic term adds dependencies: a drag torque with driver fan_command makes loss_friction depend on it.
#[test]
fn terms_bring_dependencies() {
    let kind = &models::ALL[0];
    let entries = &(kind.declaration)().entries;
    let index = |name: &str| entries.iter().position(|e| e.name == name).unwrap();
    let (x, y) = ([0.0, 1.0], [0.0, 0.01]);
    let table = Table::new(Driver::FanCommand, &x, &y).unwrap();
    let terms = [GenericTerm::new(Port::DragTorque, Law::Table(table))];
    let found = Dependencies::of(kind, &Resources::of_terms(&terms), &StartValues::default());
    let friction = found.outputs.iter().find(|u| u.entry == index("loss_friction")).unwrap();
    assert!(friction.on.contains(&index("fan_command")));
}

/// An integer has limits and a start value in both standards, but neither unit nor nominal value.
#[test]
fn a_whole_number_is_an_integer_in_both_standards() {
    let read = |file: &str| read("AnnulusCooledMotor", file);
    assert!(read("fmi2.xml").contains("<Integer min=\"1\" max=\"100\" start=\"2\"/>"));
    let three = read("fmi3.xml");
    let line = three.lines().find(|l| l.contains("motor.pole_pairs")).unwrap().trim();
    assert!(line.starts_with("<Int64 ") && line.ends_with("min=\"1\" max=\"100\" start=\"2\"/>"), "{line}");
    assert!(read("parameters.md").contains("| `motor.pole_pairs` |  | 2 | 1 ... 100 | tunable |"));
}

#[test]
fn the_gearmotor_depends_on_no_effect_of_fan_or_power_input() {
    const IDLE: [&str; 9] = [
        "fan_back_pressure",
        "drive_loss",
        "pwm_ripple",
        "bridge_drop",
        "dead_time",
        "stator_node",
        "housing_sensor_lag",
        "winding_sensor_lag",
        "generic_term",
    ];
    let kind = models::by_name("BrushedGearmotor").unwrap();
    let declaration = (kind.declaration)();
    let found = Dependencies::of(kind, &Resources::default(), &StartValues::default());
    let names = |on: &[usize]| on.iter().map(|k| declaration.entries[*k].name.as_str()).collect::<Vec<_>>();
    for unknown in found.outputs.iter().chain(&found.rates).chain(&found.initial) {
        let idle = names(&unknown.on).into_iter().find(|name| IDLE.iter().any(|idle| name.contains(idle)));
        assert_eq!(idle, None, "{}", declaration.entries[unknown.entry].name);
    }
    let voltage = declaration.entries.iter().position(|e| e.name == "voltage").unwrap();
    let on = |list: &[Unknown]| names(&list.iter().find(|u| u.entry == voltage).unwrap().on);
    let running = on(&found.outputs);
    assert_eq!(running[..2], ["duty", "supply_voltage"]);
    assert!(running[2..].iter().all(|name| name.starts_with("state.")), "{running:?}");
    assert!(
        on(&found.initial).contains(&"drive.pwm_frequency"),
        "discontinuous conduction is among the points"
    );
}

/// `cargo xtask tidy` compares with dependencies from more points, which takes four times as long.
#[test]
fn the_generated_files_are_up_to_date() {
    let stale = generated::stale(&folder(), Dependencies::sampled).unwrap();
    assert!(stale.is_empty(), "run `cargo xtask describe`: {stale:?}");
}

/// The stored dependencies are read as they were written; otherwise every archive would determine them again.
#[test]
fn the_structure_is_read_as_it_is_kept() {
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        let kept = read(declaration.name, "dependencies.toml");
        let found = Dependencies::of(kind, &Resources::default(), &StartValues::default());
        assert!(kept.lines().count() > 20 && found.text(declaration) == kept, "{}", declaration.name);
    }
}

#[test]
fn a_value_reference_is_never_given_again() {
    let declaration = (models::ALL[0].declaration)();
    let taken = "AnnulusCooledMotor 100 motor.something_else\n";
    let error = lock::update(taken, &[declaration]).unwrap_err().to_string();
    assert!(
        error.contains("100") && error.contains("motor.something_else") && error.contains("motor.R_ref"),
        "{error}"
    );
    let retired = lock::update("AnnulusCooledMotor 9999 gone\n", &[declaration]).unwrap();
    assert!(retired.contains("AnnulusCooledMotor 9999 gone"), "a retired variable keeps its number");
    assert!(lock::update("nonsense\n", &[declaration]).is_err());
}
