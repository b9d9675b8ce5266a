//! Terms that are data, from the archive's resources to the motor, through the C functions of both standards.

use crate::common::{Motor2, said, token};
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::{fmi3FreeInstance, fmi3InstantiateCoSimulation};
use motor_fmu::logger::Status;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};

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

/// The current a tenth of a millisecond after 6 V are switched on: the rotor has hardly moved.
fn current(motor: &Motor2) -> f64 {
    motor.initialize();
    assert_eq!(motor.set("voltage", 6.0), Status::Ok);
    assert_eq!(motor.step(0.0, 1e-4), Status::Ok);
    motor.get("current")
}

#[test]
fn a_term_reaches_the_motor_and_survives_reset_and_serialization() {
    let resources = Resources::with("drop", DROP);
    let (plain, braked) =
        (Motor2::instantiated("plain"), Motor2::located("braked", Some(&resources.uri())).unwrap());
    let (free, held) = (current(&plain), current(&braked));
    assert!(held < 0.7 * free && held > 0.5 * free, "{held} A of {free} A: about 4 of 6 V are left");
    assert_eq!(unsafe { fmi2Reset(braked.0) }, Status::Ok);
    assert_eq!(current(&braked).to_bits(), held.to_bits());
    // A state goes from instance to instance of one archive.
    let (mut state, mut size) = (null_mut(), 0);
    let other = Motor2::located("other", Some(&resources.uri())).unwrap();
    unsafe {
        assert_eq!(fmi2GetFMUstate(braked.0, &mut state), Status::Ok);
        assert_eq!(fmi2SerializedFMUstateSize(braked.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(braked.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        other.initialize();
        assert_eq!(fmi2DeSerializeFMUstate(other.0, bytes.as_ptr(), size, &mut state), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other.0, state), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(other.0, &mut state), Status::Ok);
    }
    for motor in [&braked, &other] {
        assert_eq!(motor.step(1e-4, 1e-3), Status::Ok);
    }
    assert_eq!(braked.outputs(), other.outputs());
    // The gain switches the terms off.
    assert_eq!(unsafe { fmi2Reset(braked.0) }, Status::Ok);
    assert_eq!(braked.set("effect.generic_term.gain", 0.0), Status::Ok);
    assert_eq!(current(&braked).to_bits(), free.to_bits());
}

#[test]
fn resources_without_terms_are_fine_and_broken_terms_are_not() {
    for nowhere in ["", "file:///no/such/folder", "http://elsewhere/resources"] {
        assert!(Motor2::located("nowhere", Some(nowhere)).is_some(), "{nowhere}");
    }
    let broken = Resources::with("broken", &DROP.replace("2.0", "2e9"));
    assert!(Motor2::located("broken", Some(&broken.uri())).is_none());
    let messages = said("broken");
    assert_eq!(messages.len(), 1, "{messages:?}");
    for word in
        ["fmi2Instantiate", "effects.json", "\"brush\"", "coefficient = 2000000000", "-1000000 ... 1000000"]
    {
        assert!(messages[0].contains(word), "{word} in {messages:?}");
    }
}

#[test]
fn fmi_3_takes_a_path() {
    let make = |folder: &Path| unsafe {
        let resources = CString::new(format!("{}/", path(folder))).unwrap();
        let (token, name) = (token(), c"three");
        let (name, token, resources) = (name.as_ptr(), token.as_ptr(), resources.as_ptr());
        fmi3InstantiateCoSimulation(name, token, resources, 0, 0, 0, 0, null(), 0, null_mut(), None, None)
    };
    let (good, broken) = (Resources::with("good 3", DROP), Resources::with("broken 3", "{"));
    assert!(make(&broken.0).is_null());
    let motor = make(&good.0);
    assert!(!motor.is_null());
    unsafe { fmi3FreeInstance(motor) };
}
