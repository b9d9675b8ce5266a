//! FMI 3 arrays: the segments of the housing, whose number is a structural parameter.

use crate::common::three::Three;
use crate::common::vr;
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ptr::null_mut;

/// A motor in a tube, whose segments grow warm one after the other.
const PUSHED: &[(&str, f64)] =
    &[("cooling_mode", 4.0), ("drive_mode", 4.0), ("electrical_power", 20.0), ("fan_command", 0.8)];

fn read(motor: &Three, name: &str, count: usize) -> (Status, Vec<f64>) {
    let mut all = vec![f64::NAN; count];
    (unsafe { fmi3GetFloat64(motor.0, &vr(name), 1, all.as_mut_ptr(), count) }, all)
}

#[test]
fn an_array_has_as_many_values_as_the_parameter_says() {
    for count in [1, 5, 8, 13, 64] {
        let motor = Three::with(false, false, None).segments(count).started(PUSHED);
        motor.step(0.0, 60.0);
        let n = count as usize;
        let warm = motor.housing(n);
        // Air that has passed over warm segments cools the next ones less.
        assert!(warm.iter().all(|t| *t > 300.0), "{warm:?}");
        assert!(warm[1..].iter().all(|t| *t > warm[0]), "{warm:?}");
        for wrong in [n - 1, n + 1] {
            assert_eq!(read(&motor, "T_housing[1]", wrong).0, Status::Error, "{wrong}");
        }
        // Among others, in the order of the references.
        let references = [vr("winding_temperature"), vr("T_housing[1]"), vr("der(T_housing[1])"), 0];
        let mut all = vec![f64::NAN; 2 * n + 2];
        let status = unsafe { fmi3GetFloat64(motor.0, references.as_ptr(), 4, all.as_mut_ptr(), all.len()) };
        assert_eq!(status, Status::Ok);
        assert_eq!(
            (all[0], &all[1..=n], all[2 * n + 1]),
            (motor.get("winding_temperature"), &warm[..], 60.0)
        );
        assert!(all[n + 1..=2 * n].iter().all(|rate| *rate > 0.0), "{all:?}");
    }
}

#[test]
fn the_parameter_has_a_mode_and_a_type_of_its_own() {
    let motor = Three::with(false, false, None);
    let size = vr("air_segments");
    let set = |count: u64| unsafe { fmi3SetUInt64(motor.0, &size, 1, &count, 1) };
    unsafe {
        assert_eq!(set(5), Status::Error, "not configured");
        assert_eq!(fmi3ExitConfigurationMode(motor.0), Status::Error);
        assert_eq!(fmi3EnterConfigurationMode(motor.0), Status::Ok);
        assert_eq!(fmi3SetInt64(motor.0, &size, 1, &5, 1), Status::Error, "another type");
        assert_eq!(motor.set("voltage", 1.0), Status::Error, "no structural parameter");
        assert_eq!((set(0), set(65), set(u64::MAX)), (Status::Discard, Status::Discard, Status::Discard));
        assert_eq!(set(5), Status::Ok);
        assert_eq!(fmi3EnterInitializationMode(motor.0, 0, 0.0, 0.0, 0, 0.0), Status::Error);
        assert_eq!(fmi3ExitConfigurationMode(motor.0), Status::Ok);
        let mut there = 0;
        assert_eq!(fmi3GetUInt64(motor.0, &size, 1, &mut there, 1), Status::Ok, "before initialization");
        assert_eq!(there, 5);
    }
    assert_eq!(read(&motor, "T_housing[1]", 5).0, Status::Error, "computed from initialization on");
    let motor = motor.started(PUSHED);
    unsafe {
        assert_eq!(fmi3EnterConfigurationMode(motor.0), Status::Error, "fixed, so too late");
        assert_eq!(fmi3SetFloat64(motor.0, &vr("T_housing[1]"), 1, [0.0; 5].as_ptr(), 5), Status::Error);
        assert_eq!(read(&motor, "T_housing[2]", 1).0, Status::Error, "no variable of its own");
        motor.housing(5);
        assert_eq!(fmi3Reset(motor.0), Status::Ok);
    }
    motor.started(&[]).housing(8);
}

#[test]
fn states_of_any_number_are_saved_through_bytes() {
    for count in [1, 13, 64] {
        let motor = Three::with(false, false, None).segments(count).started(PUSHED);
        motor.step(0.0, 5.0);
        unsafe {
            let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
            assert_eq!(fmi3GetFMUState(motor.0, &mut state), Status::Ok);
            assert_eq!(fmi3SerializedFMUStateSize(motor.0, state, &mut size), Status::Ok);
            let mut bytes = vec![0u8; size];
            assert_eq!(fmi3SerializeFMUState(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
            // One that was made with eight.
            let other = Three::with(false, false, None);
            assert_eq!(fmi3DeserializeFMUState(other.0, bytes.as_ptr(), size, &mut copy), Status::Ok);
            assert_eq!(fmi3SetFMUState(other.0, copy), Status::Ok);
            motor.step(5.0, 5.0);
            other.step(5.0, 5.0);
            let bits =
                |of: &Three| of.housing(count as usize).into_iter().map(f64::to_bits).collect::<Vec<_>>();
            assert_eq!(bits(&motor), bits(&other));
            assert_eq!(fmi3FreeFMUState(motor.0, &mut state), Status::Ok);
            assert_eq!(fmi3FreeFMUState(other.0, &mut copy), Status::Ok);
        }
    }
}

/// The number of continuous states follows the array size, and derivatives of arrays are given element by element.
#[test]
fn states_and_derivatives_follow_the_number() {
    let motor = Three::exchanged().segments(3).started(PUSHED);
    let mut n = 0;
    let knowns = [vr("T_housing[1]"), vr("state.winding_temperature")];
    let mut all = [f64::NAN; 3];
    unsafe {
        assert_eq!(fmi3GetNumberOfContinuousStates(motor.0, &mut n), Status::Ok);
        assert_eq!(n, 14 + 3);
        let mut x = vec![0.0; n];
        assert_eq!(fmi3GetContinuousStates(motor.0, x.as_mut_ptr(), n), Status::Ok);
        assert_eq!(fmi3GetContinuousStates(motor.0, x.as_mut_ptr(), n - 1), Status::Error);
        let unknown = vr("der(T_housing[1])");
        let seed = [1.0, 0.0, 0.0, 0.0];
        let ask = |n_known, n_seed, out: &mut [f64; 3], n_out| {
            let (knowns, seed) = (knowns.as_ptr(), seed.as_ptr());
            fmi3GetDirectionalDerivative(
                motor.0,
                &unknown,
                1,
                knowns,
                n_known,
                seed,
                n_seed,
                out.as_mut_ptr(),
                n_out,
            )
        };
        assert_eq!(ask(2, 4, &mut all, 3), Status::Ok);
        // A warmer first segment cools, and warms its neighbour by conduction; the last it reaches by the air alone.
        assert!(all[0] < 0.0 && all[1] > 0.0 && all[1] > 10.0 * all[2].abs(), "{all:?}");
        assert_eq!(ask(2, 2, &mut all, 3), Status::Error, "a seed for each element");
        assert_eq!(ask(2, 4, &mut all, 1), Status::Error, "a place for each element");
        let (mut back, rows) = ([f64::NAN; 4], [0.0, 1.0, 0.0]);
        let status = fmi3GetAdjointDerivative(
            motor.0,
            &unknown,
            1,
            knowns.as_ptr(),
            2,
            rows.as_ptr(),
            3,
            back.as_mut_ptr(),
            4,
        );
        assert_eq!(status, Status::Ok);
        assert_eq!(back[0], all[1], "the transpose");
    }
}
