//! FMI 2.0 through the C functions: life cycle, values, refusals, saved states.

use crate::common::{Motor2, said, token, vr};
use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;
use std::ffi::{CStr, c_int};
use std::ptr::{null, null_mut};

/// A drive with reversals, loads and a running fan; the same at every call.
fn drive(motor: &Motor2, from: u32, to: u32) {
    for k in from..to {
        let t = f64::from(k) * 1e-3;
        assert_eq!(motor.set("voltage", 20.0 * (7.0 * t).sin()), Status::Ok);
        assert_eq!(motor.set("load_torque", 0.02 * (3.0 * t).cos()), Status::Ok);
        assert_eq!(motor.set("fan_command", 0.5 + 0.5 * (2.0 * t).sin()), Status::Ok);
        assert_eq!(motor.step(t, 1e-3), Status::Ok);
    }
}

/// What must not change when a call is refused.
fn unchanged_by(name: &str, call: impl FnOnce(&Motor2) -> Status, expected: Status, words: &[&str]) {
    let (motor, twin) = (Motor2::initialized(name), Motor2::initialized("undisturbed"));
    drive(&motor, 0, 5);
    drive(&twin, 0, 5);
    let before = motor.outputs();
    assert_eq!(call(&motor), expected, "{name}");
    let messages = said(name);
    assert_eq!(messages.len(), 1, "{messages:?}");
    for word in words {
        assert!(messages[0].contains(word), "{words:?} in {messages:?}");
    }
    assert_eq!(motor.outputs(), before, "{name}");
    drive(&motor, 5, 10);
    drive(&twin, 5, 10);
    assert_eq!(motor.outputs(), twin.outputs(), "{name}: goes on as if nothing had been asked");
}

#[test]
fn refused_calls_say_why_and_change_nothing() {
    type Case = (&'static str, fn(&Motor2) -> Status, Status, &'static [&'static str]);
    const CASES: &[Case] = &[
        ("nan", |m| m.set("voltage", f64::NAN), Status::Discard, &["voltage", "NaN", "-10000 ... 10000 V"]),
        ("inf", |m| m.set("load_torque", f64::INFINITY), Status::Discard, &["load_torque", "inf", "N.m"]),
        ("high", |m| m.set("fan_command", 1.5), Status::Discard, &["fan_command = 1.5 is", "0 ... 1."]),
        (
            "cold",
            |m| m.set("motor.R_ref", -1.0),
            Status::Discard,
            &["motor.R_ref = -1 Ohm", "0.0001 ... 10000"],
        ),
        ("output", |m| m.set("current", 1.0), Status::Error, &["current is computed"]),
        ("clock", |m| m.set("time", 1.0), Status::Error, &["time"]),
        ("backwards", |m| m.step(0.005, -1e-3), Status::Error, &["-0.001 s", "not positive"]),
        ("zero", |m| m.step(0.005, 0.0), Status::Error, &["0 s", "not positive"]),
        ("nanstep", |m| m.step(0.005, f64::NAN), Status::Error, &["NaN"]),
        ("elsewhere", |m| m.step(0.007, 1e-3), Status::Error, &["0.007 s", "0.005 s"]),
        ("nantime", |m| m.step(f64::NAN, 1e-3), Status::Error, &["NaN"]),
        (
            "fixed",
            |m| unsafe { fmi2SetInteger(m.0, &vr("drive_mode"), 1, &3) },
            Status::Error,
            &["drive_mode is fixed"],
        ),
        (
            "unknown",
            |m| unsafe { fmi2SetReal(m.0, &9999, 1, &1.0) },
            Status::Error,
            &["AnnulusCooledMotor", "9999"],
        ),
        (
            "type",
            |m| unsafe { fmi2GetInteger(m.0, &vr("voltage"), 1, &mut 0) },
            Status::Error,
            &["voltage", "Real"],
        ),
        (
            "count",
            |m| unsafe { fmi2SetInteger(m.0, &vr("motor.pole_pairs"), 1, &101) },
            Status::Discard,
            &["motor.pole_pairs = 101 is", "1 ... 100."],
        ),
        ("null", |m| unsafe { fmi2GetReal(m.0, null(), 3, null_mut()) }, Status::Error, &["vr is NULL"]),
        (
            "slope",
            |m| unsafe { fmi2SetRealInputDerivatives(m.0, &vr("voltage"), 1, &2, &1.0) },
            Status::Error,
            &["order 2", "voltage"],
        ),
        (
            "nanslope",
            |m| unsafe { fmi2SetRealInputDerivatives(m.0, &vr("voltage"), 1, &1, &f64::NAN) },
            Status::Discard,
            &["NaN", "voltage"],
        ),
        (
            "category",
            |m| unsafe { fmi2SetDebugLogging(m.0, 1, 1, &c"logNothing".as_ptr()) },
            Status::Error,
            &["logNothing", "logStatusError"],
        ),
        ("again", |m| unsafe { fmi2EnterInitializationMode(m.0) }, Status::Error, &["step mode"]),
        ("me", |m| unsafe { fmi2SetTime(m.0, 1.0) }, Status::Error, &["Co-Simulation"]),
    ];
    for (name, call, expected, words) in CASES {
        unchanged_by(name, call, *expected, words);
    }
}

/// A tunable whole number goes through Integer, also as part of a serialized state.
#[test]
fn a_whole_number_is_set_read_and_serialized() {
    let reference = vr("motor.pole_pairs");
    let get = |motor: &Motor2| {
        let mut n = 0;
        assert_eq!(unsafe { fmi2GetInteger(motor.0, &reference, 1, &mut n) }, Status::Ok);
        n
    };
    let motor = Motor2::initialized("pairs");
    assert_eq!(get(&motor), 2);
    assert_eq!(unsafe { fmi2SetInteger(motor.0, &reference, 1, &11) }, Status::Ok);
    assert_eq!(get(&motor), 11);
    let (mut state, mut size) = (null_mut(), 0);
    let other = Motor2::initialized("others");
    unsafe {
        assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok);
        assert_eq!(fmi2SerializedFMUstateSize(motor.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        assert_eq!(fmi2DeSerializeFMUstate(other.0, bytes.as_ptr(), size, &mut state), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other.0, state), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(other.0, &mut state), Status::Ok);
    }
    assert_eq!(get(&other), 11);
}

/// One bad value in a list refuses the whole list.
#[test]
fn a_list_of_values_is_taken_whole_or_not_at_all() {
    let motor = Motor2::initialized("list");
    let references = [vr("voltage"), vr("load_torque"), vr("fan_command")];
    let status = unsafe { fmi2SetReal(motor.0, references.as_ptr(), 3, [12.0, 0.1, 7.0].as_ptr()) };
    assert_eq!(status, Status::Discard);
    assert_eq!((motor.get("voltage"), motor.get("load_torque")), (0.0, 0.0));
    said("list");
}

#[test]
fn the_life_cycle_is_enforced() {
    let motor = Motor2::instantiated("life");
    unsafe {
        assert_eq!(motor.step(0.0, 1e-3), Status::Error, "before initialization");
        assert_eq!(fmi2ExitInitializationMode(motor.0), Status::Error);
        let mut value = 0.0;
        assert_eq!(fmi2GetReal(motor.0, &vr("current"), 1, &mut value), Status::Error);
        assert_eq!(fmi2SetupExperiment(motor.0, 0, 0.0, f64::NAN, 0, 0.0), Status::Error);
        assert_eq!(fmi2SetupExperiment(motor.0, 0, 0.0, 2.0, 1, 1.0), Status::Error);
        assert_eq!(fmi2SetupExperiment(motor.0, 0, 0.0, 2.0, 1, 2.002), Status::Ok);
        assert_eq!(motor.set("ambient_temperature", 310.0), Status::Ok, "a start value");
        assert_eq!(fmi2EnterInitializationMode(motor.0), Status::Ok);
        assert_eq!(
            motor.get("winding_temperature"),
            310.0,
            "outputs follow the inputs during initialization"
        );
        assert_eq!(motor.set("ambient_temperature", 320.0), Status::Ok);
        assert_eq!(motor.get("winding_temperature"), 320.0);
        assert_eq!(motor.get("time"), 2.0);
        assert_eq!(fmi2ExitInitializationMode(motor.0), Status::Ok);
        assert_eq!(motor.step(2.0, 1e-3), Status::Ok);
        assert_eq!(motor.step(2.001, 1e-3), Status::Ok);
        assert_eq!(motor.step(2.002, 1e-3), Status::Error, "past the stop time");
        let mut time = 0.0;
        assert_eq!(fmi2GetRealStatus(motor.0, 2, &mut time), Status::Ok);
        assert!((time - 2.002).abs() < 1e-12);
        assert_eq!(fmi2Terminate(motor.0), Status::Ok);
        assert_eq!(motor.step(2.002, 1e-3), Status::Error, "after termination");
        assert_eq!(motor.get("winding_temperature"), 320.0, "values can still be read");
        assert_eq!(fmi2Reset(motor.0), Status::Ok);
    }
    motor.initialize();
    assert_eq!(motor.get("time"), 0.0, "reset takes time back too");
    assert_eq!(motor.get("winding_temperature"), 298.15);
    assert_eq!(said("life").len(), 7);
}

/// A reset instance, a second instance and a fresh one are the same, bit for bit, and do not touch each other.
#[test]
fn instances_are_independent_and_reset_is_complete() {
    let (a, b) = (Motor2::initialized("a"), Motor2::initialized("b"));
    drive(&a, 0, 50);
    b.set("motor.R_ref", 0.5);
    drive(&b, 0, 20);
    let lone = Motor2::initialized("lone");
    drive(&lone, 0, 50);
    assert_eq!(a.outputs(), lone.outputs());
    assert_ne!(a.outputs(), b.outputs());
    unsafe { assert_eq!(fmi2Reset(b.0), Status::Ok) };
    b.initialize();
    drive(&b, 0, 50);
    assert_eq!(a.outputs(), b.outputs());
}

#[test]
fn rollback_is_bitwise_in_memory_and_through_bytes() {
    let motor = Motor2::initialized("rollback");
    drive(&motor, 0, 30);
    unsafe {
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok);
        let first = state;
        drive(&motor, 30, 60);
        let there = motor.outputs();

        assert_eq!(fmi2SetFMUstate(motor.0, state), Status::Ok);
        drive(&motor, 30, 60);
        assert_eq!(motor.outputs(), there, "from memory");

        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(motor.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size];
        assert_eq!(fmi2SerializeFMUstate(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        let other = Motor2::initialized("other");
        let mut copy = null_mut();
        assert_eq!(fmi2DeSerializeFMUstate(other.0, bytes.as_ptr(), size, &mut copy), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other.0, copy), Status::Ok);
        drive(&other, 30, 60);
        assert_eq!(other.outputs(), there, "from bytes, in another instance");

        assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok);
        assert_eq!(state, first, "a handle is used again");
        assert_eq!(fmi2FreeFMUstate(motor.0, &mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(motor.0, &mut state), Status::Ok, "twice");
        assert_eq!(fmi2FreeFMUstate(other.0, &mut copy), Status::Ok);
        assert_eq!(fmi2SetFMUstate(motor.0, null_mut()), Status::Error);
    }
    said("rollback");
}

#[test]
fn damaged_bytes_are_refused() {
    let motor = Motor2::initialized("bytes");
    unsafe {
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok);
        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(motor.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size];
        assert_eq!(fmi2SerializeFMUstate(motor.0, state, bytes.as_mut_ptr(), size - 1), Status::Error);
        assert_eq!(fmi2SerializeFMUstate(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        let mut copy = null_mut();
        for n in 0..size {
            assert_eq!(
                fmi2DeSerializeFMUstate(motor.0, bytes.as_ptr(), n, &mut copy),
                Status::Error,
                "{n} bytes"
            );
        }
        bytes[0] ^= 1;
        assert_eq!(fmi2DeSerializeFMUstate(motor.0, bytes.as_ptr(), size, &mut copy), Status::Error);
        assert!(copy.is_null());
        assert_eq!(fmi2FreeFMUstate(motor.0, &mut state), Status::Ok);
    }
    said("bytes");
}

/// An input derivative applies to one step; afterwards the input keeps its end value.
#[test]
fn slopes_hold_for_one_step() {
    let motor = Motor2::initialized("ramp");
    assert_eq!(motor.set("voltage", 1.0), Status::Ok);
    unsafe { assert_eq!(fmi2SetRealInputDerivatives(motor.0, &vr("voltage"), 1, &1, &2000.0), Status::Ok) };
    assert_eq!(motor.step(0.0, 1e-3), Status::Ok);
    assert_eq!(motor.get("voltage"), 3.0);
    assert_eq!(motor.step(1e-3, 1e-3), Status::Ok);
    assert_eq!(motor.get("voltage"), 3.0);
}

#[test]
fn choices_and_flags() {
    let motor = Motor2::instantiated("choice");
    unsafe {
        assert_eq!(fmi2SetInteger(motor.0, &vr("drive_mode"), 1, &3), Status::Ok);
        assert_eq!(fmi2SetInteger(motor.0, &vr("drive_mode"), 1, &9), Status::Discard);
        motor.initialize();
        let mut choice: c_int = 0;
        assert_eq!(fmi2GetInteger(motor.0, &vr("drive_mode"), 1, &mut choice), Status::Ok);
        assert_eq!(choice, 3);
        let mut hot: c_int = 1;
        assert_eq!(fmi2GetBoolean(motor.0, &vr("over_temperature"), 1, &mut hot), Status::Ok);
        assert_eq!(hot, 0);
        // 40 A in still air: 618 W into 10 J/K.
        motor.set("current_command", 40.0);
        motor.set("load_torque", 1.0);
        assert_eq!(motor.step(0.0, 6.0), Status::Ok);
        assert_eq!(fmi2GetBoolean(motor.0, &vr("over_temperature"), 1, &mut hot), Status::Ok);
        assert_eq!(hot, 1);
        assert!(motor.get("winding_margin") < 0.0);
    }
    let message = said("choice");
    assert!(message[0].contains("drive_mode = 9") && message[0].contains("3 = current"), "{message:?}");
}

/// A thermal runaway to values beyond the range of a double is reported for every step size.
#[test]
fn a_step_without_solution_is_discarded_and_changes_nothing() {
    let motor = Motor2::instantiated("runaway");
    unsafe { assert_eq!(fmi2SetInteger(motor.0, &vr("drive_mode"), 1, &3), Status::Ok) };
    motor.initialize();
    motor.set("current_command", 1e4);
    let before = motor.outputs();
    assert_eq!(motor.step(0.0, 1e7), Status::Discard);
    assert_eq!(motor.outputs(), before);
    assert_eq!(motor.step(0.0, 1e-6), Status::Ok, "the instance lives on");
    assert!(said("runaway")[0].contains("no solution"));
}

#[test]
fn null_handles_and_wrong_tokens() {
    unsafe {
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 0), Status::Error);
        assert_eq!(fmi2Reset(null_mut()), Status::Error);
        assert_eq!(fmi2GetReal(null_mut(), null(), 0, null_mut()), Status::Error);
        fmi2FreeInstance(null_mut());
        let wrong = c"{00000000-0000-0000-0000-000000000000}".as_ptr();
        assert!(fmi2Instantiate(c"x".as_ptr(), 1, wrong, null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(c"x".as_ptr(), 1, null(), null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(null(), 1, token().as_ptr(), null(), null(), 0, 0).is_null());
        assert!(
            fmi2Instantiate(c"x".as_ptr(), 2, token().as_ptr(), null(), null(), 0, 0).is_null(),
            "no such interface"
        );
        let quiet = fmi2Instantiate(c"x".as_ptr(), 1, token().as_ptr(), null(), null(), 0, 0);
        assert!(!quiet.is_null(), "no callbacks, no resources");
        assert_eq!(fmi2DoStep(quiet, 0.0, 1.0, 0), Status::Error, "and nobody to tell");
        fmi2FreeInstance(quiet);
        assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
    }
}

/// The C interface does not change values: the native model gives the same bits.
#[test]
fn the_native_model_gives_the_same_bits() {
    let motor = Motor2::initialized("native");
    let mut native = (physics::models::ALL[0].new)();
    let slot = |name: &str| native_slot(name);
    native.start(0.0).unwrap();
    for k in 0..100 {
        let t = f64::from(k) * 1e-3;
        let volts = 20.0 * (7.0 * t).sin();
        motor.set("voltage", volts);
        assert!(native.set(slot("voltage"), volts));
        assert_eq!(motor.step(t, 1e-3), Status::Ok);
        native.step(t, 1e-3).unwrap();
    }
    for name in ["current", "shaft_angle", "winding_temperature", "energy_electrical", "power_balance_error"]
    {
        assert_eq!(motor.get(name).to_bits(), native.get(slot(name)).to_bits(), "{name}");
    }
}

fn native_slot(name: &str) -> physics::model::Slot {
    (physics::models::ALL[0].declaration)().by_name(name).unwrap().slot
}

/// A panic becomes status Error; afterwards the instance accepts reset and free only.
#[test]
fn a_panic_does_not_cross_the_interface() {
    let motor = Motor2::initialized("panic");
    let status = unsafe { motor_fmu::boundary::enter(motor.0, "test", |_| panic!("on purpose")) };
    assert_eq!(status, Status::Error);
    assert_eq!(motor.step(0.0, 1e-3), Status::Error);
    assert!(said("panic").iter().any(|line| line.contains("internal failure")));
    unsafe { assert_eq!(fmi2Reset(motor.0), Status::Ok) };
    motor.initialize();
    assert_eq!(motor.step(0.0, 1e-3), Status::Ok);
}

/// During initialization the states follow the start values, so an output has derivatives with respect to them.
#[test]
fn derivatives_of_initialization_move_the_states() {
    let motor = Motor2::instantiated("derivatives of initialization");
    let known = vr("ambient_temperature");
    let slope = |unknown: &str| {
        let mut slope = f64::NAN;
        let status =
            unsafe { fmi2GetDirectionalDerivative(motor.0, &vr(unknown), 1, &known, 1, &1.0, &mut slope) };
        assert_eq!(status, Status::Ok, "{unknown}");
        slope
    };
    unsafe {
        assert_eq!(fmi2SetupExperiment(motor.0, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(motor.0), Status::Ok);
    }
    for (output, of_ambient) in [("winding_temperature", 1.0), ("winding_margin", -1.0)] {
        assert!((slope(output) - of_ambient).abs() < 1e-9, "{output}: {}", slope(output));
    }
    unsafe { assert_eq!(fmi2ExitInitializationMode(motor.0), Status::Ok) };
    // The states of a run are there.
    assert!(slope("winding_temperature").abs() < 1e-9);
}
