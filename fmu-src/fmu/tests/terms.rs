//! Terms that are data, from the archive's resources to the motor, through the C functions of both standards.

use crate::common::{CS2, CS3, How, Importer, KINDS, LOGGED, ME3, MOTOR, Message, Options, Succeeds, filled};
use motor_fmu::logger::Status;
use motor_fmu::resources::{of_path, of_uri};
use physics::model::ModelType;
use physics::token::Contents;
use std::path::PathBuf;
use tempfile::TempDir;

/// A folder of resources, with a space in its name, that holds a file of this text.
fn resources(text: &str) -> TempDir {
    let folder = tempfile::Builder::new().prefix("motor fmu").tempdir().unwrap();
    std::fs::write(folder.path().join(terms::FILE_NAME), text).unwrap();
    folder
}

/// As a URI: the space in its name is encoded.
fn uri(folder: &TempDir) -> String {
    format!("file://{}", folder.path().to_str().unwrap().replace(' ', "%20"))
}

/// A constant drop of 2 V.
const DROP: &str = r#"{"format": "motor-fmu effects 1", "terms": [
    {"name": "brush", "port": "terminal_voltage", "coefficient": 2.0, "unit": "V"}]}"#;

/// A motor whose archive has its resources there; the messages where there is none.
fn located(how: How, resources: &str) -> Result<Importer, Vec<Message>> {
    let options = Options { resources: Some(resources), ..Options::default() };
    Importer::tried(MOTOR, how, options, None)
}

/// Contents with start values, terms or a load table.
const STARTS: Contents = Contents { starts: 7, terms: 0, load: 0 };
const TERMS: Contents = Contents { starts: 0, terms: 7, load: 0 };
const LOAD: Contents = Contents { starts: 0, terms: 0, load: 7 };

/// The message of an instantiation that the library refuses.
fn refusal(kind: &ModelType, how: How, contents: Contents, resources: Option<&str>) -> String {
    let options = Options { resources, contents, ..Options::default() };
    let messages = Importer::tried(kind, how, options, None).err().expect("no instance");
    assert_eq!(messages.len(), 1, "{messages:?}");
    messages[0].text.clone()
}

/// The current a tenth of a millisecond after 6 V are switched on: the rotor has hardly moved.
fn current(motor: &Importer) -> f64 {
    motor.initialize();
    motor.set("voltage", 6.0).ok();
    motor.step(0.0, 1e-4).ok();
    motor.get("current")
}

/// A term that the model does not take, in resources that somebody changed, is refused with the reason.
#[test]
fn a_term_of_a_fan_is_refused_where_there_is_none() {
    let fan = DROP.replace("terminal_voltage", "fan_flow").replace("\"V\"", "\"1\"").replace("2.0", "0.5");
    let resources = resources(&fan);
    let gearmotor = physics::models::by_name("BrushedGearmotor").unwrap();
    let message = refusal(gearmotor, CS2, TERMS, Some(&uri(&resources)));
    assert!(message.contains("does not accept the terms of effects.json: it has no fan"), "{message}");
}

#[test]
fn a_term_reaches_the_motor_and_survives_reset_and_serialization() {
    let resources = resources(DROP);
    let plain = Importer::motor(CS2);
    let [braked, other] = [(); 2].map(|()| located(CS2, &uri(&resources)).unwrap());
    let (free, held) = (current(&plain), current(&braked));
    assert!(held < 0.7 * free && held > 0.5 * free, "{held} A of {free} A: about 4 of 6 V are left");
    braked.reset().ok();
    assert_eq!(current(&braked).to_bits(), held.to_bits());
    // A state goes from instance to instance of one archive.
    other.initialize();
    other.take_over(*braked);
    for motor in [&braked, &other] {
        motor.step(1e-4, 1e-3).ok();
    }
    assert_eq!(braked.outputs(), other.outputs());
    // The gain switches the terms off.
    braked.reset().ok();
    braked.set("effect.generic_term.gain", 0.0).ok();
    assert_eq!(current(&braked).to_bits(), free.to_bits());
}

/// A lag of the speed in the housing's sensor: it rises with its time constant in Co-Simulation, is put back to the last bit with the
/// state of the instance, and is a state with a derivative in Model Exchange.
#[test]
fn a_lag_is_a_state_of_the_motor() {
    let lag = r#"{"format": "motor-fmu effects 1", "terms": [{"port": "housing_sensor", "coefficient": 1.0, "drivers":
        [{"driver": "speed", "reference": 10.0}], "lag": {"driver": "speed", "tau": 20.0}}]}"#;
    let folder = resources(lag);
    for how in [CS2, CS3] {
        let resources = if how == CS2 { uri(&folder) } else { format!("{}/", folder.path().display()) };
        let motor = located(how, &resources).unwrap();
        motor.initialize();
        motor.set("voltage", 2.0).ok();
        motor.step(0.0, 1.0).ok();
        motor.step(1.0, 1.0).ok();
        let speed = motor.get("shaft_speed");
        let reached = 0.1 * (motor.get("housing_temperature") - motor.get("state.core_temperature"));
        let share = 1.0 - (-2.0f64 / 20.0).exp();
        assert!((100.0 * reached / (share * speed) - 1.0).abs() < 0.3, "{reached} of {speed} rad/s");
        // FMI 3.0 gives the three states as one array.
        if how == CS2 {
            assert!((motor.get("state.term_lag[1]") - reached).abs() < 1e-9);
            let rate = motor.get("der(state.term_lag[1])");
            assert!((rate - (speed / 100.0 - reached) / 20.0).abs() < 1e-9, "{rate}");
            assert_eq!(motor.get("der(state.term_lag[2])"), 0.0);
        }
        let other = located(how, &resources).unwrap();
        other.initialize();
        other.take_over(*motor);
        for motor in [&motor, &other] {
            motor.step(2.0, 1.0).ok();
        }
        assert_eq!(motor.outputs(), other.outputs());
    }
}

/// Heat that a change of the heat capacity stores is in no balance, so the residual of a balance that closes has the derivative 0: in time, and
/// with respect to an input, which changes the capacity only in the next step.
#[test]
fn a_capacity_that_changes_leaves_the_balance_closed() {
    let capacity = r#"{"format": "motor-fmu effects 1", "terms": [{"port": "heat_capacity", "coefficient": 0.5, "drivers":
        [{"driver": "winding_temperature", "offset": 290.0, "reference": 30.0}, {"driver": "speed", "reference": 100.0}]}]}"#;
    let folder = resources(capacity);
    let motor = located(CS2, &uri(&folder)).unwrap().initialized(&[
        ("voltage", 3.0),
        ("mechanical_mode", 2.0),
        ("imposed_speed", 60.0),
    ]);
    (0..40).for_each(|k| motor.step(f64::from(k), 1.0).ok());
    let power = motor.get("power_electrical");
    let (residual, speed) = (motor.reference("energy_balance_error"), motor.reference("imposed_speed"));
    let in_time = filled(1, |slope| motor.get_slopes(&[residual], &[1], slope))[0];
    let by_speed = filled(1, |slope| motor.directional(&[residual], &[speed], &[1.0], slope))[0];
    assert!(in_time.abs() < 1e-9 * power, "{in_time} W of {power} W");
    assert!(by_speed.abs() < 1e-9, "{by_speed} J per rad/s");
}

#[test]
fn resources_without_terms_are_fine_and_broken_terms_are_not() {
    for nowhere in ["", "file:///no/such/folder", "http://elsewhere/resources"] {
        assert!(located(CS2, nowhere).is_ok(), "{nowhere}");
    }
    let broken = resources(&DROP.replace("2.0", "2e9"));
    let messages = located(CS2, &uri(&broken)).err().unwrap();
    assert_eq!(messages.len(), 1, "{messages:?}");
    for word in
        ["fmi2Instantiate", "effects.json", "\"brush\"", "coefficient = 2000000000", "-1000000 ... 1000000"]
    {
        assert!(messages[0].text.contains(word), "{word} in {messages:?}");
    }
}

/// An archive whose data are missing would silently be another model, whatever the importer passes as location.
#[test]
fn missing_terms_and_a_missing_load_table_are_refused_with_the_cause() {
    let walker = physics::models::by_name("GaitLoad").unwrap();
    let empty = tempfile::tempdir().unwrap();
    let empty = empty.path().to_str().unwrap();
    let (as_uri, as_path) = (format!("file://{empty}"), format!("{empty}/"));
    let nothing = resources(r#"{"format": "motor-fmu effects 1", "terms": []}"#);
    let nothing = nothing.path().to_str().unwrap();
    let common = [
        (None, "passed no resource location (NULL)"),
        (Some(""), "passed an empty resource location"),
        (Some("/no/such/folder/"), "the resource folder /no/such/folder/ does not exist"),
        (Some(as_path.as_str()), "has no FILE"),
    ];
    let two = [
        (Some("http://host/r"), "the resource location http://host/r is not a file URI with a path"),
        (Some("file:///no/such"), "the resource folder /no/such does not exist"),
        (Some(as_uri.as_str()), "has no FILE"),
    ];
    let three = [
        (
            Some("file:///no/such"),
            "the resource location file:///no/such is a URI, and FMI 3 requires a path",
        ),
        (Some(as_uri.as_str()), "is a URI, and FMI 3 requires a path"),
    ];
    for how in KINDS {
        let own: &[_] = if how.0 { &three } else { &two };
        for (location, cause) in common.iter().chain(own) {
            for (kind, contents, file) in [(MOTOR, TERMS, "effects.json"), (walker, LOAD, "load.json")] {
                let text = refusal(kind, how, contents, *location);
                let name = (kind.declaration)().name;
                assert!(text.contains(&format!("{name} was built with the ")), "{text}");
                assert!(text.contains(&format!("resources/{file}, but ")), "{text}");
                assert!(text.contains(&cause.replace("FILE", file)), "{cause}: {text}");
            }
        }
        let text = refusal(MOTOR, how, TERMS, Some(nothing));
        assert!(text.contains("effects.json contains none"), "{text}");
    }
}

/// A user may replace the file of an archive and add one, without a compiler.
#[test]
fn other_terms_and_added_terms_are_accepted() {
    let folder = resources(DROP);
    let located = |contents| {
        let uri = uri(&folder);
        Importer::instantiated(MOTOR, CS2, Options { resources: Some(&uri), contents, ..LOGGED })
    };
    let [added, replaced] = [Contents::default(), TERMS].map(|contents| current(&located(contents)));
    assert_eq!(added.to_bits(), replaced.to_bits());
    assert!(added < 0.7 * current(&Importer::motor(CS2)));
}

#[test]
fn a_description_with_other_start_values_than_the_library_is_refused() {
    for how in KINDS {
        let text = refusal(MOTOR, how, STARTS, None);
        assert!(text.contains("AnnulusCooledMotor: the token {"), "{text}");
        assert!(text.contains("other start values than those in this library"), "{text}");
        assert!(text.contains("different builds"), "{text}");
    }
}

/// The terms and the load table are part of the equations: with others, the numbers of a state mean something else.
#[test]
fn a_state_of_other_equations_is_refused() {
    let half = DROP.replace("2.0", "1.0");
    let folders = [resources(DROP), resources(&half)];
    for how in [CS2, ME3] {
        let [full, half] = folders.each_ref().map(|folder| {
            let options = Options { resources: folder.path().to_str(), ..LOGGED };
            Importer::instantiated(MOTOR, how, options)
        });
        let plain = Importer::motor(how);
        for motor in [&full, &half, &plain] {
            motor.initialize();
        }
        for (from, to) in [(&full, &half), (&half, &plain), (&plain, &full)] {
            to.heard();
            assert_eq!(to.read(&from.save().bytes()).err(), Some(Status::Error));
            let text = &to.said()[0].text;
            assert!(text.contains("other terms (resources/effects.json)"), "{text}");
            assert!(to.read(&to.save().bytes()).is_ok());
        }
    }
    let walker = physics::models::by_name("GaitLoad").unwrap();
    let tables = ["[[0, 1, 2]]", "[[0, 1, 3]]"].map(|rows| {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(r#"{{"format": "motor-fmu load 1", "period": 1, "rows": {rows}}}"#);
        std::fs::write(folder.path().join(terms::load::FILE_NAME), text).unwrap();
        folder
    });
    let [one, two] = tables.each_ref().map(|folder| {
        let path = folder.path().to_str();
        let load = Importer::instantiated(walker, CS3, Options { resources: path, contents: LOAD, ..LOGGED });
        load.initialize();
        load
    });
    two.heard();
    assert_eq!(two.read(&one.save().bytes()).err(), Some(Status::Error));
    let text = &two.said()[0].text;
    assert!(text.contains("another load table (resources/load.json)"), "{text}");
    assert!(one.read(&one.save().bytes()).is_ok());
}

#[test]
fn fmi_3_takes_a_path() {
    let made = |folder: &TempDir| located(CS3, &format!("{}/", folder.path().display()));
    assert!(made(&resources("{")).is_err());
    assert!(made(&resources(DROP)).is_ok());
}

#[test]
fn every_way_to_say_where() {
    for (uri, path) in [
        ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
        ("file:/tmp/resources/", "/tmp/resources/"),
        ("FILE://localhost/tmp/%C3%BC", "/tmp/\u{fc}"),
        ("file:///C:/fmu/resources", "C:/fmu/resources"),
        ("/tmp/100%/x", "/tmp/100%/x"),
        ("C:\\fmu\\resources", "C:\\fmu\\resources"),
        ("file:///tmp/50%25/%zz/%2", "/tmp/50%/%zz/%2"),
    ] {
        assert_eq!(of_uri(uri), Some(PathBuf::from(path)), "{uri}");
    }
    for nothing in ["", "http://host/resources", "file:", "file://", "file://host"] {
        assert_eq!(of_uri(nothing), None, "{nothing}");
    }
    assert_eq!((of_path(""), of_path("/r/")), (None, Some(PathBuf::from("/r/"))));
}
