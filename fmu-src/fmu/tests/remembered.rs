//! Cached data of an instance do not change values: lists of value references, and the accepted step size.

use crate::common::{Motor2, said, vr};
use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;
use std::ptr::null_mut;

/// What a master sets, reads and lets run along slopes at every step.
const SET: [&str; 3] = ["voltage", "load_torque", "fan_command"];
const READ: [&str; 4] = ["shaft_speed", "current", "power_balance_error", "winding_temperature"];

fn references<const N: usize>(names: [&str; N]) -> [u32; N] {
    names.map(vr)
}

fn set<const N: usize>(motor: &Motor2, names: [&str; N], values: [f64; N]) -> Status {
    unsafe { fmi2SetReal(motor.0, references(names).as_ptr(), N, values.as_ptr()) }
}

fn slope<const N: usize>(motor: &Motor2, names: [&str; N], orders: [i32; N], slopes: [f64; N]) -> Status {
    unsafe {
        fmi2SetRealInputDerivatives(motor.0, references(names).as_ptr(), N, orders.as_ptr(), slopes.as_ptr())
    }
}

fn get<const N: usize>(motor: &Motor2, names: [&str; N]) -> [u64; N] {
    let mut values = [f64::NAN; N];
    assert_eq!(
        unsafe { fmi2GetReal(motor.0, references(names).as_ptr(), N, values.as_mut_ptr()) },
        Status::Ok
    );
    values.map(f64::to_bits)
}

/// Inputs and slopes of step `k` of a millisecond.
fn inputs(k: u32) -> ([f64; 3], [f64; 3]) {
    let t = f64::from(k) * 1e-3;
    (
        [20.0 * (7.0 * t).sin(), 0.02 * (3.0 * t).cos(), 0.5 + 0.4 * (2.0 * t).sin()],
        [140.0 * (7.0 * t).cos(), -0.06 * (3.0 * t).sin(), 0.8 * (2.0 * t).cos()],
    )
}

fn step(motor: &Motor2, k: u32) {
    assert_eq!(motor.step(f64::from(k) * 1e-3, 1e-3), Status::Ok);
}

/// Setting variables in lists gives the same result as setting them one by one, also with other lists in between.
#[test]
fn a_list_that_is_known_is_that_of_its_variables() {
    let (lists, single) = (Motor2::initialized("lists"), Motor2::initialized("single"));
    for k in 0..40 {
        if k == 20 {
            for motor in [&lists, &single] {
                unsafe { assert_eq!(fmi2Reset(motor.0), Status::Ok) };
                motor.initialize();
            }
        }
        let at = k % 20;
        let (values, slopes) = inputs(at);
        // Every third list is another one: the same names in another order, and one name less.
        match k % 3 {
            0 => assert_eq!(set(&lists, ["fan_command", "load_torque"], [values[2], values[1]]), Status::Ok),
            1 => assert_eq!(
                set(&lists, [SET[1], SET[0], SET[2]], [values[1], values[0], values[2]]),
                Status::Ok
            ),
            _ => {}
        }
        assert_eq!(set(&lists, SET, values), Status::Ok);
        assert_eq!(slope(&lists, SET, [1; 3], slopes), Status::Ok);
        for (name, (value, slope)) in SET.iter().zip(values.iter().zip(slopes)) {
            assert_eq!(single.set(name, *value), Status::Ok);
            assert_eq!(
                unsafe { fmi2SetRealInputDerivatives(single.0, &vr(name), 1, &1, &slope) },
                Status::Ok
            );
        }
        step(&lists, at);
        step(&single, at);
        let bits = READ.map(|name| single.get(name).to_bits());
        assert_eq!(get(&lists, READ), bits, "{k}");
        assert_eq!(get(&lists, [READ[2], READ[0]]), [bits[2], bits[0]], "{k}");
        // With the clock among them no list is remembered.
        assert_eq!(get(&lists, ["time", READ[1]])[1], bits[1]);
        assert_eq!(get(&lists, READ), bits, "{k}, again");
    }
}

/// A list that was good is refused whole when one of its values is not.
#[test]
fn a_list_that_is_known_is_judged_each_time() {
    let motor = Motor2::initialized("judged");
    let (values, slopes) = inputs(3);
    for _ in 0..2 {
        assert_eq!(set(&motor, SET, values), Status::Ok);
        assert_eq!(slope(&motor, SET, [1; 3], slopes), Status::Ok);
    }
    for (bad, words) in [(f64::NAN, "NaN"), (1.5, "fan_command = 1.5"), (-0.1, "fan_command = -0.1")] {
        assert_eq!(set(&motor, SET, [1.0, 1.0, bad]), Status::Discard);
        assert_eq!(SET.map(|name| motor.get(name)), values);
        assert!(said("judged")[0].contains(words));
    }
    assert_eq!(slope(&motor, SET, [1, 2, 1], slopes), Status::Error);
    assert!(said("judged")[0].contains("order 2 of load_torque"));
    assert_eq!(slope(&motor, SET, [1; 3], [0.0, 0.0, f64::INFINITY]), Status::Discard);
    assert!(said("judged")[0].contains("fan_command"));
    // What was refused has led nowhere: the last good slopes hold.
    step(&motor, 0);
    for (name, (value, slope)) in SET.iter().zip(values.iter().zip(slopes)) {
        assert!((motor.get(name) - (value + 1e-3 * slope)).abs() < 1e-12, "{name}");
    }
    unsafe { assert_eq!(fmi2Terminate(motor.0), Status::Ok) };
    assert_eq!(set(&motor, SET, values), Status::Error);
    assert_eq!(slope(&motor, SET, [1; 3], slopes), Status::Error);
    said("judged");
}

/// A motor under reversing full voltage reduces its internal step and keeps the accepted step size as a discrete state. A saved
/// state, in memory or serialized, restores it.
#[test]
fn the_accepted_step_size_is_restored_to_the_bit() {
    let reversed = |motor: &Motor2, from: u32, to: u32| {
        let mut seen = Vec::new();
        for k in from..to {
            assert_eq!(motor.set("voltage", if k % 3 == 0 { 40.0 } else { -40.0 }), Status::Ok);
            assert_eq!(motor.step(f64::from(k) * 0.02, 0.02), Status::Ok);
            seen.extend(motor.outputs());
        }
        seen
    };
    let motor = Motor2::initialized("reversed");
    reversed(&motor, 0, 7);
    unsafe {
        let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
        assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok);
        let there = reversed(&motor, 7, 12);
        reversed(&motor, 12, 14);
        assert_eq!(fmi2SetFMUstate(motor.0, state), Status::Ok);
        assert_eq!(reversed(&motor, 7, 12), there, "from memory");

        assert_eq!(fmi2SerializedFMUstateSize(motor.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size];
        assert_eq!(fmi2SerializeFMUstate(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        let other = Motor2::initialized("other reversed");
        assert_eq!(fmi2DeSerializeFMUstate(other.0, bytes.as_ptr(), size, &mut copy), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other.0, copy), Status::Ok);
        assert_eq!(reversed(&other, 7, 12), there, "from bytes, in another instance");
        assert_eq!(fmi2FreeFMUstate(motor.0, &mut state), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(other.0, &mut copy), Status::Ok);
    }
}
