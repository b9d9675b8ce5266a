//! Terms that are data, from the archive's resources to the motor, through the C functions of both standards.

use crate::common::{CS2, CS3, How, Importer, MOTOR, Message, Options, Succeeds, filled};
use motor_fmu::resources::{of_path, of_uri};
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

/// The current a tenth of a millisecond after 6 V are switched on: the rotor has hardly moved.
fn current(motor: &Importer) -> f64 {
    motor.initialize();
    motor.set("voltage", 6.0).ok();
    motor.step(0.0, 1e-4).ok();
    motor.get("current")
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
