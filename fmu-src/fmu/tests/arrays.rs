//! FMI 3 arrays: the segments of the housing, whose number is a structural parameter.

use crate::common::{CS3, Importer, ME3, Succeeds, filled, shortened, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;

/// A motor in a tube, whose segments grow warm one after the other.
const PUSHED: &[(&str, f64)] =
    &[("cooling_mode", 4.0), ("drive_mode", 4.0), ("electrical_power", 20.0), ("fan_command", 0.8)];

/// The temperatures of the housing's segments.
fn housing(motor: &Importer, count: usize) -> Vec<f64> {
    filled(count, |all| motor.get_reals(&[vr("T_housing[1]")], all))
}

fn refusal(motor: &Importer, name: &str, count: usize) {
    assert_eq!(motor.get_reals(&[vr(name)], &mut vec![0.0; count]), Status::Error, "{count} of {name}");
}

#[test]
fn an_array_has_as_many_values_as_the_parameter_says() {
    for count in [1, 5, 8, 13, 64].into_iter().take(shortened(5, 3)) {
        let motor = Importer::motor(CS3).segments(count).started(PUSHED);
        // In Miri too short for a difference in temperature.
        let end = if cfg!(miri) { 0.1 } else { 60.0 };
        motor.ended(0.0, end);
        let n = count as usize;
        let warm = housing(&motor, n);
        // Air that has passed over warm segments cools the next ones less.
        assert!(cfg!(miri) || warm.iter().all(|t| *t > 300.0), "{warm:?}");
        assert!(cfg!(miri) || warm[1..].iter().all(|t| *t > warm[0]), "{warm:?}");
        refusal(&motor, "T_housing[1]", n - 1);
        refusal(&motor, "T_housing[1]", n + 1);
        // Among others, in the order of the references.
        let references = [vr("winding_temperature"), vr("T_housing[1]"), vr("der(T_housing[1])"), 0];
        let all = filled(2 * n + 2, |all| motor.get_reals(&references, all));
        assert_eq!((all[0], &all[1..=n], all[2 * n + 1]), (motor.get("winding_temperature"), &warm[..], end));
        assert!(cfg!(miri) || all[n + 1..=2 * n].iter().all(|rate| *rate > 0.0), "{all:?}");
    }
}

#[test]
fn the_parameter_has_a_mode_and_a_type_of_its_own() {
    let motor = Importer::motor(CS3);
    let size = vr("air_segments");
    let set = |count: u64| unsafe { fmi3SetUInt64(motor.handle, &size, 1, &count, 1) };
    unsafe {
        assert_eq!(set(5), Status::Error, "not configured");
        assert_eq!(fmi3ExitConfigurationMode(motor.handle), Status::Error);
        fmi3EnterConfigurationMode(motor.handle).ok();
        assert_eq!(motor.set_whole(&[size], &[5]), Status::Error, "another type");
        assert_eq!(motor.set("voltage", 1.0), Status::Error, "no structural parameter");
        assert_eq!([0, 65, u64::MAX].map(set), [Status::Discard; 3]);
        set(5).ok();
        assert_eq!(motor.enter(None, 0.0), Status::Error);
        fmi3ExitConfigurationMode(motor.handle).ok();
        let mut there = 0;
        assert_eq!(fmi3GetUInt64(motor.handle, &size, 1, &mut there, 1), Status::Ok, "before initialization");
        assert_eq!(there, 5);
        // Computed from initialization on.
        refusal(&motor, "T_housing[1]", 5);
    }
    let motor = motor.started(PUSHED);
    assert_eq!(unsafe { fmi3EnterConfigurationMode(motor.handle) }, Status::Error, "fixed, so too late");
    assert_eq!(motor.set_reals(&[vr("T_housing[1]")], &[0.0; 5]), Status::Error);
    // No variable of its own.
    refusal(&motor, "T_housing[2]", 1);
    housing(&motor, 5);
    motor.reset().ok();
    housing(&motor.started(&[]), 8);
}

#[test]
fn states_of_any_number_are_saved_through_bytes() {
    for count in [1, 13, 64] {
        let pushed = Importer::motor(CS3).segments(count).started(PUSHED);
        let h = if cfg!(miri) { 0.02 } else { 5.0 };
        pushed.ended(0.0, h);
        // One that was made with eight.
        let other = Importer::motor(CS3);
        other.take_over(*pushed);
        let [one, two] = [&pushed, &other].map(|motor| {
            motor.ended(h, h);
            housing(motor, count as usize).into_iter().map(f64::to_bits).collect::<Vec<_>>()
        });
        assert_eq!(one, two);
    }
}

/// The number of continuous states follows the array size, and derivatives of arrays are given element by element.
#[test]
fn states_and_derivatives_follow_the_number() {
    let motor = Importer::motor(ME3).segments(3).initialized(PUSHED);
    let mut n = 0;
    unsafe { fmi3GetNumberOfContinuousStates(motor.handle, &mut n) }.ok();
    assert_eq!((n, motor.states().len()), (18 + 3, n));
    assert_eq!(motor.get_states(&mut vec![0.0; n - 1]), Status::Error);
    let knowns = [vr("T_housing[1]"), vr("state.winding_temperature")];
    let unknown = [vr("der(T_housing[1])")];
    let seed = [1.0, 0.0, 0.0, 0.0];
    let all = filled(3, |all| motor.directional(&unknown, &knowns, &seed, all));
    // A warmer first segment cools, and warms its neighbour by conduction; the last it reaches by the air alone.
    assert!(all[0] < 0.0 && all[1] > 0.0 && all[1] > 10.0 * all[2].abs(), "{all:?}");
    let ask = |seed, n_out| motor.directional(&unknown, &knowns, seed, &mut vec![0.0; n_out]);
    assert_eq!(ask(&seed[..2], 3), Status::Error, "a seed for each element");
    assert_eq!(ask(&seed, 1), Status::Error, "a place for each element");
    let back = |rows: [f64; 3]| {
        filled(4, |back| unsafe {
            let (unknown, knowns, rows) = (unknown.as_ptr(), knowns.as_ptr(), rows.as_ptr());
            fmi3GetAdjointDerivative(motor.handle, unknown, 1, knowns, 2, rows, 3, back.as_mut_ptr(), 4)
        })
    };
    assert_eq!(back([0.0, 1.0, 0.0])[0], all[1], "the transpose");
    let seeds = [2.0, -0.5, 0.25];
    let sum: f64 = seeds.iter().zip(&all).map(|(seed, slope)| seed * slope).sum();
    assert!((back(seeds)[0] - sum).abs() < 1e-12 * sum.abs(), "the sum with the seeds");
}
