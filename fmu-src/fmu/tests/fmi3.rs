//! FMI 3.0 through the C functions: what differs from FMI 2.0, and that both give the same numbers.

use crate::common::{Motor2, token, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ffi::{CStr, c_void};
use std::ptr::{null, null_mut};

struct Motor3(*mut c_void);

impl Motor3 {
    fn instantiated() -> Motor3 {
        Motor3::located(c"")
    }

    /// An instance whose archive has its resources in this folder.
    fn located(resources: &CStr) -> Motor3 {
        Motor3(unsafe {
            fmi3InstantiateCoSimulation(
                c"motor".as_ptr(),
                token().as_ptr(),
                resources.as_ptr(),
                0,
                0,
                0,
                0,
                null(),
                0,
                null_mut(),
                None,
                None,
            )
        })
    }

    fn initialize(&self) {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.0, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi3ExitInitializationMode(self.0), Status::Ok);
        }
    }

    fn set(&self, name: &str, value: f64) -> Status {
        unsafe { fmi3SetFloat64(self.0, &vr(name), 1, &value, 1) }
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi3GetFloat64(self.0, &vr(name), 1, &mut value, 1) }, Status::Ok);
        value
    }

    fn step(&self, at: f64, h: f64) -> Status {
        let (mut event, mut terminate, mut early, mut last) = (9, 9, 9, f64::NAN);
        let status =
            unsafe { fmi3DoStep(self.0, at, h, 1, &mut event, &mut terminate, &mut early, &mut last) };
        assert_eq!((event, terminate, early), (0, 0, 0));
        if status == Status::Ok {
            assert_eq!(last, at + h);
        }
        status
    }
}

impl Drop for Motor3 {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.0) }
    }
}

#[test]
fn both_standards_give_the_same_bits() {
    let (two, three) = (Motor2::initialized("two"), Motor3::instantiated());
    three.initialize();
    for k in 0..200 {
        let t = f64::from(k) * 1e-3;
        let volts = 15.0 * (9.0 * t).sin();
        assert_eq!(two.set("voltage", volts), Status::Ok);
        assert_eq!(three.set("voltage", volts), Status::Ok);
        assert_eq!(two.step(t, 1e-3), Status::Ok);
        assert_eq!(three.step(t, 1e-3), Status::Ok);
        for name in ["current", "shaft_speed", "winding_temperature", "energy_electrical"] {
            assert_eq!(two.get(name).to_bits(), three.get(name).to_bits(), "{name} at {t} s");
        }
    }
}

#[test]
fn types_have_their_own_functions() {
    let motor = Motor3::instantiated();
    unsafe {
        assert_eq!(fmi3SetInt64(motor.0, &vr("drive_mode"), 1, &2, 1), Status::Ok);
        assert_eq!(fmi3SetInt32(motor.0, &vr("drive_mode"), 1, &2, 1), Status::Error);
        motor.initialize();
        let mut choice = 0;
        assert_eq!(fmi3GetInt64(motor.0, &vr("drive_mode"), 1, &mut choice, 1), Status::Ok);
        assert_eq!(choice, 2);
        let mut hot = 7;
        assert_eq!(fmi3GetBoolean(motor.0, &vr("over_temperature"), 1, &mut hot, 1), Status::Ok);
        assert_eq!(hot, 0);
        let mut two = [0.0; 2];
        assert_eq!(fmi3GetFloat64(motor.0, &vr("current"), 1, two.as_mut_ptr(), 2), Status::Error, "lengths");
        assert_eq!(
            fmi3GetString(motor.0, null(), 0, null_mut(), 0),
            Status::Ok,
            "nothing asked, nothing wrong"
        );
    }
}

/// Int64 carries whole numbers; the limits hold, and rollback takes them back.
#[test]
fn a_whole_number_is_set_read_and_restored() {
    let motor = Motor3::instantiated();
    motor.initialize();
    let reference = vr("motor.pole_pairs");
    let set = |n: i64| unsafe { fmi3SetInt64(motor.0, &reference, 1, &n, 1) };
    let get = || {
        let mut n = 0;
        assert_eq!(unsafe { fmi3GetInt64(motor.0, &reference, 1, &mut n, 1) }, Status::Ok);
        n
    };
    assert_eq!(get(), 2);
    unsafe {
        let mut state = null_mut();
        assert_eq!(fmi3GetFMUState(motor.0, &mut state), Status::Ok);
        assert_eq!(set(7), Status::Ok, "tunable: also between steps");
        assert_eq!(get(), 7);
        assert_eq!(set(0), Status::Discard);
        assert_eq!(set(i64::MAX), Status::Discard);
        assert_eq!(get(), 7);
        assert_eq!(fmi3SetFMUState(motor.0, state), Status::Ok);
        assert_eq!(get(), 2);
        assert_eq!(fmi3FreeFMUState(motor.0, &mut state), Status::Ok);
        assert_eq!(fmi3SetFloat64(motor.0, &reference, 1, &3.0, 1), Status::Error, "another type");
        assert_eq!(fmi3SetInt32(motor.0, &reference, 1, &3, 1), Status::Error, "another type");
    }
}

#[test]
fn what_is_declared_absent_is_refused() {
    let motor = Motor3::instantiated();
    motor.initialize();
    unsafe {
        assert_eq!(fmi3SetTime(motor.0, 1.0), Status::Error);
        assert_eq!(fmi3GetClock(motor.0, &1, 1, null_mut()), Status::Error);
        let mut n = 9;
        assert_eq!(fmi3GetNumberOfContinuousStates(motor.0, &mut n), Status::Ok);
        assert_eq!(n, 0);
        assert_eq!(CStr::from_ptr(fmi3GetVersion()), c"3.0");
        assert_eq!(
            fmi3DoStep(null_mut(), 0.0, 1.0, 0, null_mut(), null_mut(), null_mut(), null_mut()),
            Status::Error
        );
    }
    assert_eq!(motor.step(0.0, 1e-3), Status::Ok);
}

#[test]
fn rollback_is_bitwise() {
    let motor = Motor3::instantiated();
    motor.initialize();
    motor.set("voltage", 12.0);
    assert_eq!(motor.step(0.0, 1e-3), Status::Ok);
    unsafe {
        let mut state = null_mut();
        assert_eq!(fmi3GetFMUState(motor.0, &mut state), Status::Ok);
        assert_eq!(motor.step(1e-3, 2e-3), Status::Ok);
        let there = motor.get("current").to_bits();
        assert_eq!(fmi3SetFMUState(motor.0, state), Status::Ok);
        assert_eq!(motor.get("time"), 1e-3);
        assert_eq!(motor.step(1e-3, 2e-3), Status::Ok);
        assert_eq!(motor.get("current").to_bits(), there);
        assert_eq!(fmi3FreeFMUState(motor.0, &mut state), Status::Ok);
    }
}
