//! The uniform interface over both standards: values, statuses, states.
use crate::common::*;
use cosim::{Archive, Experiment, FmiVersion, Instance, Kind, Log, Status, Step, Value};

const U: u32 = 1;
const X: u32 = 5;

fn ready(version: FmiVersion) -> (Archive, Instance, Log) {
    let archive = Fmu::good(version).open().unwrap();
    let log = Log::new();
    let mut instance = Instance::instantiate(&archive, "lag", log.clone()).unwrap();
    let experiment = Experiment { stop: Some(10.0), ..Default::default() };
    instance.setup_experiment(&experiment).unwrap();
    instance.enter_initialization(&experiment).unwrap();
    instance.exit_initialization().unwrap();
    (archive, instance, log)
}

fn fault(archive: &Archive, instance: &mut Instance, number: i64) {
    instance
        .set_value(archive.description().variable("fault").unwrap(), &Value::Integer(number.into()))
        .unwrap();
}

fn x(instance: &mut Instance) -> f64 {
    let mut x = [0.0];
    instance.get_f64(&[X], &mut x).unwrap();
    x[0]
}

#[test]
fn all_types_come_back_as_they_went() {
    for version in BOTH {
        let (archive, mut instance, _) = ready(version);
        let d = archive.description();
        let kind = |name: &str| d.variable(name).unwrap().kind;
        for (name, text) in
            [("u", "1.5"), ("mode", "fast"), ("invert", "true"), ("n", "-7"), ("label", "grüße")]
        {
            let (variable, value) = d.parse_value(name, text).unwrap();
            instance.set_value(variable, &value).unwrap();
        }
        let (mut u, mut i, mut b) = ([0.0], [0], [false]);
        instance.get_f64(&[U], &mut u).unwrap();
        assert_eq!(u, [1.5]);
        instance.get_i64(kind("mode"), &[3], &mut i).unwrap();
        assert_eq!(i, [3]);
        instance.get_bool(&[4], &mut b).unwrap();
        assert_eq!(b, [true]);
        instance.get_i64(kind("twice"), &[8], &mut i).unwrap();
        assert_eq!(i, [-14]);
        instance.get_number(kind("n"), &[7], &mut u).unwrap();
        assert_eq!(u, [-7.0]);
        instance.get_number(Kind::Boolean, &[4], &mut u).unwrap();
        assert_eq!(u, [1.0]);
        assert_eq!(instance.get_string(&[10]).unwrap(), ["grüße"]);
        assert_eq!(instance.set_f64(&[], &[]).map_err(|e| e.to_string()), Ok(()));
    }
}

#[test]
fn lists_and_values_that_do_not_fit_are_refused_before_the_call() {
    for version in BOTH {
        let (_archive, mut instance, _) = ready(version);
        let three = version == FmiVersion::V3;
        let name = if three { "fmi3GetFloat64" } else { "fmi2GetReal" };
        let message = instance.get_f64(&[U, X], &mut [0.0]).unwrap_err().to_string();
        assert_eq!(message, format!("{name} of lag: 1 values for 2 variables"));
        let kind = if three { Kind::Int8 } else { Kind::Int32 };
        let message = instance.set_i64(kind, &[7], &[1 << 40]).unwrap_err().to_string();
        assert!(message.contains("1099511627776 is not in "), "{message}");
        assert!(instance.set_number(kind, &[7], &[f64::NAN]).is_err());
        assert!(instance.set_number(Kind::String, &[10], &[0.0]).is_err());
        assert!(instance.get_i64(Kind::Float64, &[U], &mut [0]).is_err());
    }
}

#[test]
fn a_refused_value_carries_the_words_of_the_fmu() {
    for version in BOTH {
        let (_archive, mut instance, log) = ready(version);
        let name = if version == FmiVersion::V3 { "fmi3SetFloat64" } else { "fmi2SetReal" };
        let message = instance.set_f64(&[U], &[f64::NAN]).unwrap_err().to_string();
        assert_eq!(message, format!("{name} of lag returned Error: NaN is no value"));
        let logged = log.messages();
        assert_eq!((logged.len(), logged[0].status, logged[0].category.as_str()), (1, Status::Error, "all"));
    }
}

#[test]
fn statuses_are_distinguished() {
    for version in BOTH {
        let (archive, mut instance, log) = ready(version);
        let step = if version == FmiVersion::V3 { "fmi3DoStep" } else { "fmi2DoStep" };
        fault(&archive, &mut instance, 1);
        assert_eq!(instance.do_step(0.0, 0.5).unwrap(), Step::Done);
        assert_eq!(log.messages()[0].text, "plain warning, 100%");
        fault(&archive, &mut instance, 2);
        let message = instance.do_step(0.5, 0.5).unwrap_err().to_string();
        assert_eq!(message, format!("{step} of lag returned Discard at t = 0.5 s: step too long"));
        fault(&archive, &mut instance, 3);
        let message = instance.do_step(0.5, 0.5).unwrap_err().to_string();
        // A message of FMI 2 has arguments, one of FMI 3 is a text.
        let said = if version == FmiVersion::V2 { "raw at 1" } else { "%s at %d" };
        assert_eq!(message, format!("{step} of lag returned Error at t = 0.5 s: {said}"));
        fault(&archive, &mut instance, 5);
        assert_eq!(instance.do_step(0.5, 0.5).unwrap(), Step::Terminated);
    }
}

/// The test FMUs abort the process when called after Fatal, also by free.
#[test]
fn nothing_is_called_after_fatal() {
    for version in BOTH {
        let (archive, mut instance, _) = ready(version);
        let state = instance.get_state().unwrap();
        fault(&archive, &mut instance, 4);
        let message = instance.do_step(0.0, 0.5).unwrap_err().to_string();
        assert!(message.ends_with("returned Fatal at t = 0 s: memory is broken"), "{message}");
        for message in [
            instance.get_f64(&[X], &mut [0.0]).unwrap_err().to_string(),
            instance.set_state(&state).unwrap_err().to_string(),
            instance.reset().unwrap_err().to_string(),
            instance.terminate().unwrap_err().to_string(),
            instance.do_step(0.0, 0.5).unwrap_err().to_string(),
        ] {
            assert!(message.ends_with("was not called because the FMU reported Fatal before"), "{message}");
        }
    }
}

#[test]
fn states_restore_every_bit_also_through_bytes() {
    for version in BOTH {
        let (_archive, mut instance, _) = ready(version);
        instance.set_f64(&[U], &[3.0]).unwrap();
        instance.do_step(0.0, 0.5).unwrap();
        let state = instance.get_state().unwrap();
        let bytes = instance.serialize_state(&state).unwrap();
        let advance = |instance: &mut Instance| {
            instance.do_step(0.5, 0.25).unwrap();
            instance.do_step(0.75, 0.25).unwrap();
            x(instance).to_bits()
        };
        let first = advance(&mut instance);
        instance.set_state(&state).unwrap();
        assert_eq!(advance(&mut instance), first);
        let copy = instance.deserialize_state(&bytes).unwrap();
        instance.update_state(&state).unwrap();
        instance.set_state(&copy).unwrap();
        assert_eq!(advance(&mut instance), first);
        instance.set_state(&state).unwrap();
        assert_eq!(x(&mut instance).to_bits(), first);
        instance.free_state(state).unwrap();
        assert!(instance.deserialize_state(&bytes[1..]).is_err());

        // Another instance's state is refused, and instances do not disturb each other.
        let (_other_archive, mut other, _) = ready(version);
        let message = other.set_state(&copy).unwrap_err().to_string();
        assert!(message.ends_with("the state belongs to another instance"), "{message}");
        assert_eq!(x(&mut other), 0.0);
        // `copy` is freed with its instance.
    }
}

#[test]
fn reset_and_what_a_standard_lacks() {
    for version in BOTH {
        let (_archive, mut instance, _) = ready(version);
        instance.set_f64(&[U], &[3.0]).unwrap();
        instance.do_step(0.0, 0.5).unwrap();
        instance.reset().unwrap();
        assert_eq!(x(&mut instance), 0.0);
        let slopes = instance.set_input_derivatives(&[U], &[1.0]).map_err(|e| e.to_string());
        let configuration = instance.enter_configuration_mode().map_err(|e| e.to_string());
        if version == FmiVersion::V2 {
            assert_eq!(slopes, Ok(()));
            assert_eq!(configuration, Err("lag does not provide configuration mode".to_owned()));
        } else {
            assert_eq!(slopes, Err("lag does not provide derivatives of inputs".to_owned()));
            assert_eq!(configuration, Ok(()));
        }
    }
}

#[test]
fn an_instance_may_move_to_another_thread() {
    let (_archive, mut instance, _) = ready(FmiVersion::V3);
    std::thread::spawn(move || instance.do_step(0.0, 0.5).unwrap()).join().unwrap();
}
