//! FMI 2.0 through the C functions: life cycle, values, refusals, saved states.

use crate::common::{CS2, Importer, LOGGED, MOTOR, Succeeds, filled, shortened, token, vr};
use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

/// Steps that a test takes before and after a refused call, and their size, s.
const FEW: u32 = shortened(5, 1) as u32;
const STEP: f64 = if cfg!(miri) { 5e-3 } else { 1e-3 };

/// A drive with reversals, loads and a running fan; the same at every call.
fn drive(motor: &Importer, from: u32, to: u32) {
    for k in from..to {
        let t = f64::from(k) * STEP;
        motor.set("voltage", 20.0 * (7.0 * t).sin()).ok();
        motor.set("load_torque", 0.02 * (3.0 * t).cos()).ok();
        motor.set("fan_command", 0.5 + 0.5 * (2.0 * t).sin()).ok();
        motor.step(t, STEP).ok();
    }
}

/// Lets the voltage run along a slope.
fn slope(motor: &Importer, order: i32, value: f64) -> Status {
    motor.set_slopes(&[vr("voltage")], &[order], &[value])
}

/// What must not change when a call is refused.
fn unchanged_by(name: &str, call: impl FnOnce(&Importer) -> Status, expected: Status, words: &[&str]) {
    let motor = Importer::motor(CS2).started(&[]);
    drive(&motor, 0, FEW);
    let before = motor.outputs();
    assert_eq!(call(&motor), expected, "{name}");
    let messages = motor.said();
    assert_eq!(messages.len(), 1, "{messages:?}");
    for word in words {
        assert!(messages[0].text.contains(word), "{words:?} in {messages:?}");
    }
    assert_eq!(motor.outputs(), before, "{name}");
    // In Miri the outputs have to do.
    if !cfg!(miri) {
        let twin = Importer::motor(CS2).started(&[]);
        drive(&motor, FEW, 2 * FEW);
        drive(&twin, 0, 2 * FEW);
        assert_eq!(motor.outputs(), twin.outputs(), "{name}: goes on as if nothing had been asked");
    }
}

#[test]
fn refused_calls_say_why_and_change_nothing() {
    type Case = (&'static str, fn(&Importer) -> Status, Status, &'static [&'static str]);
    const CASES: &[Case] = &[
        ("nan", |m| m.set("voltage", f64::NAN), Status::Discard, &["voltage", "NaN", "-10000 ... 10000 V"]),
        ("inf", |m| m.set("load_torque", f64::INFINITY), Status::Discard, &["load_torque", "inf", "N.m"]),
        (
            "high",
            |m| m.set("ambient_pressure", 9e9),
            Status::Discard,
            &["ambient_pressure = 9000000000", "10000 ... 200000"],
        ),
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
        ("fixed", |m| m.set("drive_mode", 3.0), Status::Error, &["drive_mode is fixed"]),
        ("unknown", |m| m.set_reals(&[9999], &[1.0]), Status::Error, &["AnnulusCooledMotor", "9999"]),
        ("type", |m| (**m).get_whole(&[vr("voltage")], &mut [0]), Status::Error, &["voltage", "Real"]),
        (
            "count",
            |m| m.set("motor.pole_pairs", 101.0),
            Status::Discard,
            &["motor.pole_pairs = 101 is", "1 ... 100."],
        ),
        ("null", |m| unsafe { fmi2GetReal(m.handle, null(), 3, null_mut()) }, Status::Error, &["vr is NULL"]),
        ("slope", |m| slope(m, 2, 1.0), Status::Error, &["order 2", "voltage"]),
        ("nanslope", |m| slope(m, 1, f64::NAN), Status::Discard, &["NaN", "voltage"]),
        (
            "category",
            |m| m.set_logging(true, &[c"logNothing"]),
            Status::Error,
            &["logNothing", "logStatusError"],
        ),
        ("again", |m| unsafe { fmi2EnterInitializationMode(m.handle) }, Status::Error, &["step mode"]),
        ("me", |m| m.set_time(1.0), Status::Error, &["Co-Simulation"]),
    ];
    for (name, call, expected, words) in CASES {
        unchanged_by(name, call, *expected, words);
    }
}

/// One bad value in a list refuses the whole list.
#[test]
fn a_list_of_values_is_taken_whole_or_not_at_all() {
    let motor = Importer::motor(CS2).started(&[]);
    let values = [("voltage", 12.0), ("load_torque", 0.1), ("imposed_speed", 7e9)];
    assert_eq!(motor.set_all(&values), Status::Discard);
    assert_eq!((motor.get("voltage"), motor.get("load_torque")), (0.0, 0.0));
}

#[test]
fn the_life_cycle_is_enforced() {
    let motor = Importer::motor(CS2);
    let h = motor.handle;
    assert_eq!(motor.step(0.0, 1e-3), Status::Error, "before initialization");
    assert_eq!(motor.exit_initialization(), Status::Error);
    assert_eq!(motor.get_reals(&[vr("current")], &mut [0.0]), Status::Error);
    unsafe {
        assert_eq!(fmi2SetupExperiment(h, 0, 0.0, f64::NAN, 0, 0.0), Status::Error);
        assert_eq!(fmi2SetupExperiment(h, 0, 0.0, 2.0, 1, 1.0), Status::Error);
        fmi2SetupExperiment(h, 0, 0.0, 2.0, 1, 2.002).ok();
        assert_eq!(motor.set("ambient_temperature", 310.0), Status::Ok, "a start value");
        fmi2EnterInitializationMode(h).ok();
    }
    // Outputs follow the inputs during initialization.
    assert_eq!(motor.get("winding_temperature"), 310.0);
    motor.set("ambient_temperature", 320.0).ok();
    assert_eq!(motor.get("winding_temperature"), 320.0);
    assert_eq!(motor.get("time"), 2.0);
    motor.exit_initialization().ok();
    motor.step(2.0, 1e-3).ok();
    motor.step(2.001, 1e-3).ok();
    assert_eq!(motor.step(2.002, 1e-3), Status::Error, "past the stop time");
    let mut time = 0.0;
    unsafe { fmi2GetRealStatus(h, 2, &mut time) }.ok();
    assert!((time - 2.002).abs() < 1e-12);
    motor.terminate().ok();
    assert_eq!(motor.step(2.002, 1e-3), Status::Error, "after termination");
    assert_eq!(motor.get("winding_temperature"), 320.0, "values can still be read");
    motor.reset().ok();
    motor.initialize();
    assert_eq!(motor.get("time"), 0.0, "reset takes time back too");
    assert_eq!(motor.get("winding_temperature"), 298.15);
    assert_eq!(motor.said().len(), 7);
}

/// A reset instance, a second instance and a fresh one are the same, bit for bit, and do not touch each other.
#[test]
fn instances_are_independent_and_reset_is_complete() {
    let (a, b) = (Importer::motor(CS2).started(&[]), Importer::motor(CS2).started(&[]));
    let steps = shortened(50, 3) as u32;
    drive(&a, 0, steps);
    b.set("motor.R_ref", 0.5);
    drive(&b, 0, 2);
    let lone = Importer::motor(CS2).started(&[]);
    drive(&lone, 0, steps);
    assert_eq!(a.outputs(), lone.outputs());
    assert_ne!(a.outputs(), b.outputs());
    b.reset().ok();
    b.initialize();
    drive(&b, 0, steps);
    assert_eq!(a.outputs(), b.outputs());
}

/// An input derivative applies to one step; afterwards the input keeps its end value.
#[test]
fn slopes_hold_for_one_step() {
    let motor = Importer::motor(CS2).started(&[]);
    motor.set("voltage", 1.0).ok();
    slope(&motor, 1, 2000.0).ok();
    motor.step(0.0, 1e-3).ok();
    assert_eq!(motor.get("voltage"), 3.0);
    motor.step(1e-3, 1e-3).ok();
    assert_eq!(motor.get("voltage"), 3.0);
}

#[test]
fn choices_and_flags() {
    let motor = Importer::motor(CS2);
    let (limit, h) = if cfg!(miri) { (303.15, 0.1) } else { (428.15, 6.0) };
    motor.set("thermal.T_w_max", limit).ok();
    motor.set("drive_mode", 3.0).ok();
    assert_eq!(motor.set("drive_mode", 9.0), Status::Discard);
    motor.initialize();
    assert_eq!(motor.get_whole("drive_mode"), 3);
    assert!(!motor.is_hot());
    // 40 A in still air: 618 W into 10 J/K.
    motor.set("current_command", 40.0);
    motor.set("load_torque", 1.0);
    motor.step(0.0, h).ok();
    assert!(motor.is_hot());
    assert!(motor.get("winding_margin") < 0.0);
    let text = &motor.said()[0].text;
    assert!(text.contains("drive_mode = 9") && text.contains("3 = current"), "{text}");
}

/// A thermal runaway to values beyond the range of a double is reported for every step size.
#[test]
#[cfg_attr(miri, ignore = "a million steps of the integrator")]
fn a_step_without_solution_is_discarded_and_changes_nothing() {
    let motor = Importer::motor(CS2).started(&[("drive_mode", 3.0)]);
    motor.set("current_command", 1e4);
    let before = motor.outputs();
    assert_eq!(motor.step(0.0, 1e7), Status::Discard);
    assert_eq!(motor.outputs(), before);
    assert_eq!(motor.step(0.0, 1e-6), Status::Ok, "the instance lives on");
    assert!(motor.said()[0].text.contains("no solution"));
}

/// No motor follows such a load torque: the call returns with the cause, after less than a second and not after hours.
#[test]
#[cfg_attr(miri, ignore = "many thousand steps of the integrator")]
fn an_absurd_input_derivative_ends_the_step() {
    let kind = physics::models::by_name("BrushedGearmotor").unwrap();
    let motor = Importer::instantiated(kind, CS2, LOGGED).started(&[]);
    let load = [motor.declaration.by_name("load_torque").unwrap().value_reference];
    motor.set_slopes(&load, &[1], &[1e30]).ok();
    assert_eq!(motor.step(0.0, 1e-3), Status::Discard);
    let text = &motor.said()[0].text;
    assert!(text.contains("no solution") && text.contains("is not finite"), "{text}");
    motor.set_slopes(&load, &[1], &[0.0]).ok();
    motor.step(0.0, 1e-3).ok();
}

#[test]
fn null_handles_and_wrong_tokens() {
    unsafe {
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 0), Status::Error);
        assert_eq!(fmi2Reset(null_mut()), Status::Error);
        assert_eq!(fmi2GetReal(null_mut(), null(), 0, null_mut()), Status::Error);
        fmi2FreeInstance(null_mut());
        let token = token(MOTOR);
        let wrong = c"{00000000-0000-0000-0000-000000000000}".as_ptr();
        assert!(fmi2Instantiate(c"x".as_ptr(), 1, wrong, null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(c"x".as_ptr(), 1, null(), null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(null(), 1, token.as_ptr(), null(), null(), 0, 0).is_null());
        assert!(
            fmi2Instantiate(c"x".as_ptr(), 2, token.as_ptr(), null(), null(), 0, 0).is_null(),
            "no such interface"
        );
        let quiet = fmi2Instantiate(c"x".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 0);
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
    let motor = Importer::motor(CS2).started(&[]);
    let mut native = (physics::models::ALL[0].new)();
    let slot = |name: &str| motor.declaration.by_name(name).unwrap().slot;
    native.start(0.0).unwrap();
    for k in 0..shortened(100, 5) {
        let t = k as f64 * 1e-3;
        let volts = 20.0 * (7.0 * t).sin();
        motor.set("voltage", volts);
        assert!(native.set(slot("voltage"), volts));
        motor.step(t, 1e-3).ok();
        native.step(t, 1e-3).unwrap();
    }
    for name in ["current", "shaft_angle", "winding_temperature", "energy_electrical", "power_balance_error"]
    {
        assert_eq!(motor.get(name).to_bits(), native.get(slot(name)).to_bits(), "{name}");
    }
}

/// A panic becomes status Error; afterwards the instance accepts reset and free only.
#[test]
fn a_panic_does_not_cross_the_interface() {
    let motor = Importer::motor(CS2).started(&[]);
    let status = unsafe { motor_fmu::boundary::enter(motor.handle, "test", |_| panic!("on purpose")) };
    assert_eq!(status, Status::Error);
    assert_eq!(motor.step(0.0, 1e-3), Status::Error);
    assert!(motor.said().iter().any(|m| m.text.contains("internal failure")));
    motor.reset().ok();
    motor.initialize();
    motor.step(0.0, 1e-3).ok();
}

/// During initialization the states follow the start values, so an output has derivatives with respect to them.
#[test]
fn derivatives_of_initialization_move_the_states() {
    let motor = Importer::motor(CS2);
    let known = [vr("ambient_temperature")];
    let slope = |unknown| filled(1, |out| motor.directional(&[vr(unknown)], &known, &[1.0], out))[0];
    motor.enter(None, 0.0).ok();
    for (output, of_ambient) in [("winding_temperature", 1.0), ("winding_margin", -1.0)] {
        assert!((slope(output) - of_ambient).abs() < 1e-9, "{output}: {}", slope(output));
    }
    motor.exit_initialization().ok();
    // The states of a run are there.
    assert!(slope("winding_temperature").abs() < 1e-9);
}
