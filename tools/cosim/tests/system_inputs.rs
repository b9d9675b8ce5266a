//! Inputs over time of a system: columns of components and of the system, units, slopes, variable steps, refusals.
use crate::common::sets;
use crate::parts::*;
use cosim::{Algorithm, SystemOptions, SystemRun, cosimulate};
use std::fs;

/// A rotor (2 kg.m2) whose torque and a gain whose input are inputs of the system.
const OPEN: &str = r#"
[system]
name = "open"
connect = ["push -> rotor.torque", "push -> gain.u", "rotor.speed -> speed"]
[experiment]
stop = 3
step = 0.25
[[component]]
name = "rotor"
fmu = "rotor.fmu"
[component.set]
J = 2.0
[[component]]
name = "gain"
fmu = "gain.fmu"
[component.set]
g = 10.0
"#;

fn options(folder: &Folder, csv: &str) -> SystemOptions {
    let path = folder.path("in.csv");
    fs::write(&path, csv).unwrap();
    SystemOptions { input: Some(path), ..SystemOptions::default() }
}

fn values(run: &SystemRun, name: &str) -> Vec<f64> {
    run.recording.column(name).unwrap().values.clone()
}

/// A triangle of 4 N.m, then a jump back to 0 at 2 s, where two rows have the same time.
const PUSH: &str = "time,push\n0,0\n1,4\n2,0\n2,-8\n3,-8\n";

#[test]
fn an_input_of_the_system_runs_linearly_and_jumps() {
    let folder = Folder::new();
    let system = folder.toml(OPEN).unwrap();
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel, Algorithm::JacobiDelayed] {
        let run = cosimulate(&system, &SystemOptions { algorithm, ..options(&folder, PUSH) }, &mut |_| ());
        let run = run.unwrap();
        // J w' = -torque, exact for lines: -4 N.m.s of the triangle over 2 kg.m2, then 8 N.m.s back.
        let speed = values(&run, "rotor.speed");
        assert!((speed[4] + 1.0).abs() < 1e-12 && (speed[8] + 2.0).abs() < 1e-12, "{speed:?}");
        assert!((speed[12] - 2.0).abs() < 1e-12, "{algorithm:?}: {speed:?}");
        assert_eq!(run.notes.iter().find(|n| n.contains("torque")), None);
        // Direct feedthrough: the value at the communication point, after the jump.
        let y = values(&run, "gain.y");
        assert_eq!((y[0], y[1], y[4], y[8], y[12]), (0.0, 10.0, 40.0, -80.0, -80.0), "{algorithm:?}");
    }
    // A jump between communication points: a step ends there. 8 N.m for 1.1 s.
    let between = "time,push\n0,0\n1.9,0\n1.9,-8\n3,-8\n";
    let run = cosimulate(&system, &options(&folder, between), &mut |_| ()).unwrap();
    let speed = values(&run, "rotor.speed");
    assert!((speed[12] - 4.4).abs() < 1e-12 && speed.len() == 13, "{speed:?}");
    // Constant over a step: the triangle is met at its left end in each step.
    let held = SystemOptions { held_inputs: true, ..options(&folder, PUSH) };
    let speed = values(&cosimulate(&system, &held, &mut |_| ()).unwrap(), "rotor.speed");
    assert!((speed[4] + 0.75).abs() < 1e-12, "{speed:?}");
}

#[test]
fn a_variable_step_meets_every_row() {
    let folder = Folder::new();
    let system = folder.toml(OPEN).unwrap();
    // A pulse of 1 ms between long pauses; a step that passes over it would not see it.
    let pulse = "time,push\n0,0\n1.5,0\n1.5005,-4000\n1.501,0\n3,0\n";
    let run =
        cosimulate(&system, &SystemOptions { tolerance: Some(1e-3), ..options(&folder, pulse) }, &mut |_| ());
    let run = run.unwrap();
    let last = *values(&run, "rotor.speed").last().unwrap();
    assert!((last - 1.0).abs() < 1e-9, "{last}");
    for row in [1.5, 1.5005, 1.501] {
        assert!(run.recording.times.contains(&row), "{row}: {:?}", run.recording.times);
    }
    assert!(run.recording.steps < 60, "{}", run.recording.steps);
}

#[test]
fn columns_of_components_and_units() {
    let folder = Folder::new();
    let text = OPEN.replace("\"push -> rotor.torque\", \"push -> gain.u\", ", "");
    let system = folder.toml(&text).unwrap();
    // 2000 mN.m, integers that stay constant until the next row.
    let csv = "time,rotor.torque [mN.m],gain.n\n0,2000,1\n1,2000,3\n";
    let run = cosimulate(&system, &options(&folder, csv), &mut |_| ()).unwrap();
    assert_eq!(values(&run, "rotor.speed")[12], -3.0);
    assert_eq!(values(&run, "gain.twice")[..5], [2.0, 2.0, 2.0, 2.0, 6.0]);
    assert_eq!(run.notes, ["gain: u stays at its start value"]);
}

/// The torque of the rotor is displayed in mN.m: numbers without unit of a caller, for the component and for the system alike.
#[test]
fn inputs_of_the_system_are_in_display_units_as_those_of_components_are() {
    let folder = Folder::new();
    let shown = xml("rotor")
        .replace(
            "s=\"-2\"/></Unit>\n    <Unit name=\"mN.m\">",
            "s=\"-2\"/><DisplayUnit name=\"mN.m\" factor=\"1000\"/></Unit>\n    <Unit name=\"mN.m\">",
        )
        .replace("unit=\"N.m\" start", "unit=\"N.m\" displayUnit=\"mN.m\" start");
    folder.fmu("rotor", &shown);
    let speed = |text: &str, options: SystemOptions| {
        let run = cosimulate(&folder.toml(text).unwrap(), &options, &mut |_| ()).unwrap();
        *values(&run, "rotor.speed").last().unwrap()
    };
    let alone = OPEN.replace("\"push -> rotor.torque\", \"push -> gain.u\", ", "");
    let is_near = |found: f64, expected: f64| (found - expected).abs() < 1e-14;
    // -T t / J, 3 s, 2 kg.m2.
    for (display_units, speed_of_two) in [(false, -3.0), (true, -0.003)] {
        for (text, name) in [(OPEN, "push"), (&alone, "rotor.torque")] {
            let set = |value: &str| SystemOptions {
                sets: sets(&[(name, value)]),
                display_units,
                ..SystemOptions::default()
            };
            assert!(is_near(speed(text, set("2")), speed_of_two), "{name}");
            assert!(is_near(speed(text, set("2 N.m")), -3.0), "{name}");
            for (header, expected) in [(name.to_owned(), speed_of_two), (format!("{name} [N.m]"), -3.0)] {
                let csv = format!("time,{header}\n0,2\n");
                let found = speed(text, SystemOptions { display_units, ..options(&folder, &csv) });
                assert!(is_near(found, expected), "{header}");
            }
        }
        // The gain has no unit: all inputs that the system's input is connected to have one number. It is connected first.
        let swapped = OPEN.replace(
            "\"push -> rotor.torque\", \"push -> gain.u\"",
            "\"push -> gain.u\", \"push -> rotor.torque\"",
        );
        for text in [OPEN, &swapped] {
            let set =
                SystemOptions { sets: sets(&[("push", "2")]), display_units, ..SystemOptions::default() };
            let run = cosimulate(&folder.toml(text).unwrap(), &set, &mut |_| ()).unwrap();
            assert!(
                is_near(values(&run, "gain.y")[1], -10.0 * speed_of_two / 1.5),
                "{:?}",
                values(&run, "gain.y")
            );
        }
        // A value of the file is in the unit of the interface.
        let text = OPEN.replace("[experiment]", "[system.set]\npush = 2\n[experiment]");
        assert_eq!(speed(&text, SystemOptions { display_units, ..SystemOptions::default() }), -3.0);
    }
}

#[test]
fn each_refusal_is_one_sentence() {
    let folder = Folder::new();
    let closed =
        OPEN.replace("\"rotor.speed -> speed\"", "\"rotor.speed -> speed\", \"gain.twice -> gain.n\"");
    for (csv, set, expected) in [
        (
            "time,pull\n0,0\n",
            "",
            "unknown column: pull is neither component.variable nor an input of the system",
        ),
        ("time,rotor.torqe\n0,0\n", "", "unknown column: rotor has no variable torqe, did you mean torque?"),
        ("time,rotor.w\n0,0\n", "", "column rotor.w is a parameter, only inputs can change in time"),
        ("time,push,rotor.torque\n0,0,0\n", "", "columns push and rotor.torque are for the same input"),
        ("time,push\n0,0\n", "push=1", "column push: rotor.torque has a constant value already"),
        (
            "time,gain.n\n0,0\n",
            "",
            "column gain.n: gain.n has a source already, the connection gain.twice -> gain.n",
        ),
        (
            "time,push [rpm]\n0,0\n",
            "",
            "column torque has the unit \"N.m\", and \"rpm\" is not a unit of the same quantity as \"N.m\"; possible are N.m, mN.m and other units of the quantity",
        ),
    ] {
        let pairs: Vec<(&str, &str)> = set.split_once('=').into_iter().collect();
        let options = SystemOptions { sets: sets(&pairs), ..options(&folder, csv) };
        assert_eq!(folder.sentence(folder.toml(&closed), &options), format!("in.csv, line 1: {expected}"));
    }
}

/// A value of a connected input would have no effect.
#[test]
fn a_value_of_a_connected_input_is_refused() {
    let folder = Folder::new();
    let closed =
        OPEN.replace("\"rotor.speed -> speed\"", "\"rotor.speed -> speed\", \"gain.twice -> gain.n\"");
    let asked = SystemOptions { sets: sets(&[("gain.n", "2")]), ..SystemOptions::default() };
    let sentence = folder.sentence(folder.toml(&closed), &asked);
    let connection = "gain.n has a source already, the connection gain.twice -> gain.n";
    assert!(sentence.contains("gain.n = 2") && sentence.contains(connection), "{sentence}");
    let text = closed.replace("g = 10.0", "g = 10.0\nn = 2");
    let sentence = folder.sentence(folder.toml(&text), &SystemOptions::default());
    assert!(sentence.contains(", line 18: "), "{sentence}");
    assert!(sentence.contains(connection), "{sentence}");
    // Without the connection the value is used.
    let open = OPEN.replace("g = 10.0", "g = 10.0\nn = 2");
    assert!(cosimulate(&folder.toml(&open).unwrap(), &SystemOptions::default(), &mut |_| ()).is_ok());
}
