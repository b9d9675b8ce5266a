//! FMI 3.0 through the C functions: what differs from FMI 2.0.

use crate::common::{CS3, Importer, Succeeds, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

#[test]
fn types_have_their_own_functions() {
    let motor = Importer::motor(CS3);
    motor.set("drive_mode", 2.0).ok();
    assert_eq!(unsafe { fmi3SetInt32(motor.handle, &vr("drive_mode"), 1, &2, 1) }, Status::Error);
    motor.initialize();
    assert_eq!(motor.get_whole("drive_mode"), 2);
    assert_eq!(motor.set_reals(&[vr("motor.pole_pairs")], &[3.0]), Status::Error);
    assert!(!motor.is_hot());
    assert_eq!(motor.get_reals(&[vr("current")], &mut [0.0; 2]), Status::Error, "lengths");
    // Nothing asked, nothing wrong.
    unsafe { fmi3GetString(motor.handle, null(), 0, null_mut(), 0) }.ok();
}

#[test]
fn what_is_declared_absent_is_refused() {
    let motor = Importer::motor(CS3).started(&[]);
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
