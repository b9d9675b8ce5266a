//! FMI 3.0 through the C functions: what differs from FMI 2.0, and that both give the same numbers.

use crate::common::{CS2, CS3, Importer, MOTOR, Options, Succeeds, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

fn instantiated() -> Importer {
    Importer::instantiated(MOTOR, CS3, Options::default())
}

#[test]
fn both_standards_give_the_same_bits() {
    let two = Importer::instantiated(MOTOR, CS2, Options::default()).started(&[]);
    let three = instantiated().started(&[]);
    for k in 0..200 {
        let t = f64::from(k) * 1e-3;
        let volts = 15.0 * (9.0 * t).sin();
        assert_eq!((two.set("voltage", volts), three.set("voltage", volts)), (Status::Ok, Status::Ok));
        two.step(t, 1e-3).ok();
        assert_eq!(three.ended(t, 1e-3), (false, false, t + 1e-3));
        assert_eq!(two.outputs(), three.outputs(), "at {t} s");
    }
}

#[test]
fn types_have_their_own_functions() {
    let motor = instantiated();
    motor.set("drive_mode", 2.0).ok();
    assert_eq!(unsafe { fmi3SetInt32(motor.handle, &vr("drive_mode"), 1, &2, 1) }, Status::Error);
    motor.initialize();
    assert_eq!(motor.get_whole("drive_mode"), 2);
    assert!(!motor.is_hot());
    assert_eq!(motor.get_reals(&[vr("current")], &mut [0.0; 2]), Status::Error, "lengths");
    // Nothing asked, nothing wrong.
    unsafe { fmi3GetString(motor.handle, null(), 0, null_mut(), 0) }.ok();
}

/// Int64 carries whole numbers; the limits hold, and rollback takes them back.
#[test]
fn a_whole_number_is_set_read_and_restored() {
    let motor = instantiated().started(&[]);
    let name = "motor.pole_pairs";
    let set = |n: i64| motor.set_whole(&[vr(name)], &[n]);
    assert_eq!(motor.get_whole(name), 2);
    let saved = motor.save();
    assert_eq!(set(7), Status::Ok, "tunable: also between steps");
    assert_eq!(motor.get_whole(name), 7);
    assert_eq!([0, i64::MAX].map(set), [Status::Discard; 2]);
    assert_eq!(motor.get_whole(name), 7);
    motor.restore(&saved).ok();
    assert_eq!(motor.get_whole(name), 2);
    assert_eq!(motor.set_reals(&[vr(name)], &[3.0]), Status::Error, "another type");
    let narrow = unsafe { fmi3SetInt32(motor.handle, &vr(name), 1, &3, 1) };
    assert_eq!(narrow, Status::Error, "another type");
}

#[test]
fn what_is_declared_absent_is_refused() {
    let motor = instantiated().started(&[]);
    assert_eq!(motor.set_time(1.0), Status::Error);
    unsafe {
        assert_eq!(fmi3GetClock(motor.handle, &1, 1, null_mut()), Status::Error);
        let mut n = 9;
        fmi3GetNumberOfContinuousStates(motor.handle, &mut n).ok();
        assert_eq!(n, 0);
        assert_eq!(CStr::from_ptr(fmi3GetVersion()), c"3.0");
        let nobody = fmi3DoStep(null_mut(), 0.0, 1.0, 0, null_mut(), null_mut(), null_mut(), null_mut());
        assert_eq!(nobody, Status::Error);
    }
    motor.step(0.0, 1e-3).ok();
}

#[test]
fn rollback_is_bitwise() {
    let motor = instantiated().started(&[("voltage", 12.0)]);
    motor.step(0.0, 1e-3).ok();
    let saved = motor.save();
    motor.step(1e-3, 2e-3).ok();
    let there = motor.outputs();
    motor.restore(&saved).ok();
    assert_eq!(motor.get("time"), 1e-3);
    motor.step(1e-3, 2e-3).ok();
    assert_eq!(motor.outputs(), there);
}
