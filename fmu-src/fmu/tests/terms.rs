//! Terms that are data, from the archive's resources to the motor, through the C functions of both standards.

use crate::common::{CS2, CS3, How, Importer, MOTOR, Message, Options, Succeeds};
use std::path::{Path, PathBuf};

/// A folder of resources that holds a file of this text; gone at the end.
struct Resources(PathBuf);

impl Resources {
    fn with(name: &str, text: &str) -> Resources {
        let folder = std::env::temp_dir().join(format!("motor-fmu {name} {}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(terms::FILE_NAME), text).unwrap();
        Resources(folder)
    }

    /// As a URI: the space in its name is encoded.
    fn uri(&self) -> String {
        format!("file://{}", path(&self.0).replace(' ', "%20"))
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn path(folder: &Path) -> String {
    folder.to_str().unwrap().to_string()
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
    let resources = Resources::with("drop", DROP);
    let plain = Importer::instantiated(MOTOR, CS2, Options::default());
    let [braked, other] = [(); 2].map(|()| located(CS2, &resources.uri()).unwrap());
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

#[test]
fn resources_without_terms_are_fine_and_broken_terms_are_not() {
    for nowhere in ["", "file:///no/such/folder", "http://elsewhere/resources"] {
        assert!(located(CS2, nowhere).is_ok(), "{nowhere}");
    }
    let broken = Resources::with("broken", &DROP.replace("2.0", "2e9"));
    let messages = located(CS2, &broken.uri()).err().unwrap();
    assert_eq!(messages.len(), 1, "{messages:?}");
    for word in
        ["fmi2Instantiate", "effects.json", "\"brush\"", "coefficient = 2000000000", "-1000000 ... 1000000"]
    {
        assert!(messages[0].text.contains(word), "{word} in {messages:?}");
    }
}

#[test]
fn fmi_3_takes_a_path() {
    let made = |folder: &Resources| located(CS3, &format!("{}/", path(&folder.0)));
    assert!(made(&Resources::with("broken 3", "{")).is_err());
    assert!(made(&Resources::with("good 3", DROP)).is_ok());
}
