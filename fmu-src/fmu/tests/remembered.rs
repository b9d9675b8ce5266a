//! Cached data of an instance do not change values: lists of value references, and the accepted step size.

use crate::common::{CS2, Importer, Succeeds, shortened, vr};
use motor_fmu::logger::Status;

/// What a master sets, reads and lets run along slopes at every step.
const SET: [&str; 3] = ["voltage", "load_torque", "fan_command"];
const READ: [&str; 4] = ["shaft_speed", "current", "power_balance_error", "winding_temperature"];

fn set<const N: usize>(motor: &Importer, names: [&str; N], values: [f64; N]) -> Status {
    motor.set_reals(&names.map(vr), &values)
}

fn slope<const N: usize>(motor: &Importer, names: [&str; N], orders: [i32; N], slopes: [f64; N]) -> Status {
    motor.set_slopes(&names.map(vr), &orders, &slopes)
}

fn get<const N: usize>(motor: &Importer, names: [&str; N]) -> [u64; N] {
    let mut values = [f64::NAN; N];
    motor.get_reals(&names.map(vr), &mut values).ok();
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

fn step(motor: &Importer, k: u32) {
    motor.step(f64::from(k) * 1e-3, 1e-3).ok();
}

/// Setting variables in lists gives the same result as setting them one by one, also with other lists in between.
#[test]
fn a_list_that_is_known_is_that_of_its_variables() {
    let (lists, single) = (Importer::motor(CS2).started(&[]), Importer::motor(CS2).started(&[]));
    let half = shortened(20, 4) as u32;
    for k in 0..2 * half {
        if k == half {
            for motor in [&lists, &single] {
                motor.reset().ok();
                motor.initialize();
            }
        }
        let at = k % half;
        let (values, slopes) = inputs(at);
        // Every third list is another one: the same names in another order, and one name less.
        match k % 3 {
            0 => set(&lists, ["fan_command", "load_torque"], [values[2], values[1]]).ok(),
            1 => set(&lists, [SET[1], SET[0], SET[2]], [values[1], values[0], values[2]]).ok(),
            _ => {}
        }
        set(&lists, SET, values).ok();
        assert_eq!(slope(&lists, SET, [1; 3], slopes), Status::Ok);
        for (name, (value, slope)) in SET.iter().zip(values.iter().zip(slopes)) {
            single.set(name, *value).ok();
            self::slope(&single, [name], [1], [slope]).ok();
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
    let motor = Importer::motor(CS2).started(&[]);
    let (values, slopes) = inputs(3);
    for _ in 0..2 {
        set(&motor, SET, values).ok();
        assert_eq!(slope(&motor, SET, [1; 3], slopes), Status::Ok);
    }
    for (bad, words) in [(f64::NAN, "NaN"), (1e5, "load_torque = 100000"), (-2e4, "load_torque = -20000")] {
        assert_eq!(set(&motor, SET, [1.0, bad, 0.1]), Status::Discard);
        assert_eq!(SET.map(|name| motor.get(name)), values);
        assert!(motor.said()[0].text.contains(words));
    }
    assert_eq!(slope(&motor, SET, [1, 2, 1], slopes), Status::Error);
    assert!(motor.said()[0].text.contains("order 2 of load_torque"));
    assert_eq!(slope(&motor, SET, [1; 3], [0.0, 0.0, f64::INFINITY]), Status::Discard);
    assert!(motor.said()[0].text.contains("fan_command"));
    // What was refused has led nowhere: the last good slopes hold.
    step(&motor, 0);
    for (name, (value, slope)) in SET.iter().zip(values.iter().zip(slopes)) {
        assert!((motor.get(name) - (value + 1e-3 * slope)).abs() < 1e-12, "{name}");
    }
    motor.terminate().ok();
    assert_eq!(set(&motor, SET, values), Status::Error);
    assert_eq!(slope(&motor, SET, [1; 3], slopes), Status::Error);
}

/// A motor under reversing full voltage reduces its internal step and keeps the accepted step size as a discrete state. A saved
/// state, in memory or serialized, restores it.
#[test]
fn the_accepted_step_size_is_restored_to_the_bit() {
    let reversed = |motor: &Importer, from: u32, to: u32| {
        let mut seen = Vec::new();
        for k in from..to {
            motor.set("voltage", if k % 3 == 0 { 40.0 } else { -40.0 }).ok();
            motor.step(f64::from(k) * 0.02, 0.02).ok();
            seen.extend(motor.outputs());
        }
        seen
    };
    let motor = Importer::motor(CS2).started(&[]);
    let [saved_at, end, later] = if cfg!(miri) { [1, 2, 3] } else { [7, 12, 14] };
    reversed(&motor, 0, saved_at);
    let saved = motor.save();
    let there = reversed(&motor, saved_at, end);
    reversed(&motor, end, later);
    motor.restore(&saved).ok();
    assert_eq!(reversed(&motor, saved_at, end), there, "from memory");

    let other = Importer::motor(CS2).started(&[]);
    other.restore(&other.read(&saved.bytes()).unwrap()).ok();
    assert_eq!(reversed(&other, saved_at, end), there, "from bytes, in another instance");
}
