//! Duty 0 means the same in both motors: `drive.zero_duty` brakes or opens the bridge.

use physics::components::chopper::ZeroDuty;
use physics::effects::{BridgeDrop, DeadTime, Effects, PwmRipple};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};

fn slot(m: &dyn Model, name: &str) -> physics::model::Slot {
    m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot
}

fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = slot(m, name);
    m.get(slot)
}

fn set(m: &mut dyn Model, name: &str, value: f64) {
    let slot = slot(m, name);
    assert!(m.set(slot, value), "{name} {value}");
}

/// A motor at speed, with its drive at duty 0: its name and what it needs beside that.
const MOTORS: [(&str, &[(&str, f64)]); 2] = [
    ("AnnulusCooledMotor", &[("drive_mode", 2.0), ("voltage", 24.0), ("initial.shaft_speed", 500.0)]),
    ("BrushedGearmotor", &[("supply_voltage", 12.0), ("initial.shaft_speed", 8.0)]),
];

fn turning(name: &str, set_up: &[(&str, f64)], zero_duty: ZeroDuty) -> Box<dyn Model> {
    let mut m = (physics::models::by_name(name).unwrap().new)();
    for (name, value) in set_up.iter().chain(&[("drive.zero_duty", f64::from(zero_duty as i32))]) {
        set(&mut *m, name, *value);
    }
    m.start(0.0).unwrap();
    m
}

/// A braked motor slows down by its own current; one that coasts has none. The supply
/// gives and takes nothing in either case, and the energy balance closes.
#[test]
fn brake_and_coast_mean_the_same_in_both_motors() {
    for (name, set_up) in MOTORS {
        for zero_duty in [ZeroDuty::Brake, ZeroDuty::Coast] {
            let mut m = turning(name, set_up, zero_duty);
            let start = get(&mut *m, "shaft_speed");
            let mut braking = 0.0f64;
            for _ in 0..50 {
                m.step(m.time(), 1e-3).unwrap();
                braking = braking.min(get(&mut *m, "current"));
            }
            let left = get(&mut *m, "shaft_speed") / start;
            let supplied =
                get(&mut *m, if name == "BrushedGearmotor" { "energy_supply" } else { "energy_electrical" });
            match zero_duty {
                ZeroDuty::Brake => {
                    assert!(left < 0.95 && braking < -0.05, "{name} brakes: {left}, {braking} A");
                    if name == "BrushedGearmotor" {
                        // One switch and one diode.
                        assert!((get(&mut *m, "voltage") - 1.8).abs() < 1e-12);
                        assert!(get(&mut *m, "loss_drive") > 0.0);
                    } else {
                        assert_eq!(get(&mut *m, "terminal_voltage"), 0.0);
                    }
                }
                ZeroDuty::Coast => {
                    assert!(braking > -1e-12, "{name} coasts: {braking} A");
                    let (voltage, e) = if name == "BrushedGearmotor" {
                        (get(&mut *m, "voltage"), get(&mut *m, "voltage_mechanical"))
                    } else {
                        assert_eq!(left, 1.0, "{name} has no friction");
                        let e = get(&mut *m, "torque_constant") * get(&mut *m, "shaft_speed");
                        (get(&mut *m, "terminal_voltage"), e)
                    };
                    assert!((voltage - e).abs() < 1e-9 * e, "the terminals show the back-EMF: {voltage} {e}");
                }
            }
            assert!(supplied.abs() < 1e-12, "{name} {zero_duty:?}: {supplied} J");
            let (power, energy) = (get(&mut *m, "power_balance_error"), get(&mut *m, "energy_balance_error"));
            assert!(power.abs() < 1e-6 && energy.abs() < 1e-6, "{name} {zero_duty:?}: {power} W, {energy} J");
        }
    }
}

/// Beyond the supply's voltage the diodes of open switches rectify: R I = V_s - e.
#[test]
fn open_switches_rectify_a_back_emf_beyond_the_supply() {
    let mut m = AnnulusCooledMotor::default();
    let choices = &mut m.parameters.choices;
    (choices.drive_mode, choices.mechanical_mode) = (DriveMode::Pwm, MechanicalMode::ImposedSpeed);
    m.parameters.drive.zero_duty = ZeroDuty::Coast;
    m.parameters.motor.alpha = 0.0;
    m.parameters.motor.alpha_mag = 0.0;
    m.inputs.voltage = 24.0;
    for speed in [-1000.0, -800.0, 0.0, 800.0, 1000.0] {
        m.inputs.imposed_speed = speed;
        m.start(0.0).unwrap();
        m.step(0.0, 0.02).unwrap();
        let e: f64 = 0.0276 * speed;
        let expected = (e.clamp(-24.0, 24.0) - e) / 0.386;
        let current = get(&mut m, "current");
        assert!((current - expected).abs() < 1e-9, "{speed} rad/s: {current} A, {expected} A");
        // Rectified power flows into the supply.
        let power = get(&mut m, "power_electrical");
        assert!((power - 24.0f64.copysign(speed) * expected).abs() < 1e-6, "{power} W");
        assert!(get(&mut m, "power_balance_error").abs() < 1e-6);
        // The matrix that the integrator freezes is the derivative.
        let step = m.step_equations();
        let (x, t) = (physics::solver::split::Fast::new(0.3, speed), [310.0, 300.0].into());
        let by = physics::solver::split::Fast::new(0.0, 1e-3);
        use physics::solver::split::System;
        let difference = step.fast_rates(0.0, &(x + by), &t) - step.fast_rates(0.0, &(x - by), &t);
        let found = step.fast_matrix(0.0, &x, &t)[(0, 1)] * 2e-3;
        assert!((found - difference[0]).abs() <= 1e-6 * (1.0 + found.abs()), "{found} {}", difference[0]);
    }
}

/// With all losses of the drive: a coasting motor has no ripple and no dead time, and its current ends.
#[test]
fn open_switches_have_no_ripple_and_no_dead_time() {
    let mut m = AnnulusCooledMotor::default();
    m.parameters.choices.drive_mode = DriveMode::Pwm;
    m.parameters.drive.zero_duty = ZeroDuty::Coast;
    m.parameters.effects = Effects {
        pwm_ripple: PwmRipple { f: 5e4 },
        bridge_drop: BridgeDrop { V_0: 0.5, R_on: 0.05, ..Default::default() },
        dead_time: DeadTime { share: 0.02, ..Default::default() },
        ..Effects::default()
    };
    (m.inputs.voltage, m.inputs.duty) = (24.0, 0.6);
    m.start(0.0).unwrap();
    m.step(0.0, 0.1).unwrap();
    set(&mut m, "duty", 0.0);
    for k in 0..5 {
        m.step(0.1 + 1e-3 * f64::from(k), 1e-3).unwrap();
    }
    assert!(get(&mut m, "current").abs() < 1e-6 && get(&mut m, "loss_copper") < 1e-9);
    assert!(get(&mut m, "shaft_speed") > 400.0);
    let (error, energy) = (get(&mut m, "energy_balance_error"), get(&mut m, "energy_electrical"));
    assert!(error.abs() <= 1e-6 * energy, "{error} J of {energy} J");
}
