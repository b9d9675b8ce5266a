//! The energy books, instantaneous and integrated, in every mode.

use crate::common::{cooling_modes, friction, motor, with_terms};
use physics::declare::{Causality, Kind};
use physics::effects::Effects;
use physics::model::{Entry, Model};
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode};
use std::collections::BTreeSet;

const DRIVES: [DriveMode; 4] = [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power];
const COUPLINGS: [MechanicalMode; 2] = [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed];

fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

fn input(m: &mut AnnulusCooledMotor, name: &str, value: f64, slope: f64) {
    let slot = m.declaration().by_name(name).unwrap().slot;
    assert!(m.set(slot, value));
    m.set_slope(slot, slope);
}

/// Friction alone, every effect, and terms at every port.
fn cases() -> Vec<Effects> {
    let mut rubbing = Effects { coulomb_friction: friction(0.00983), ..Effects::default() };
    rubbing.viscous_friction.k = 3e-6;
    [rubbing, Effects::examples()].into_iter().chain(with_terms(rubbing, |_| true)).collect()
}

/// A second of everything at once: volts, amperes, load, fan and room on ramps, reversing under friction.
fn run(
    drive: DriveMode,
    coupling: MechanicalMode,
    effects: Effects,
    slopes: bool,
    mut each: impl FnMut(&mut AnnulusCooledMotor),
) {
    let mut m = motor(drive, coupling);
    m.parameters.effects = effects;
    m.start(0.0).unwrap();
    let h = 1e-3;
    for k in 0..1000 {
        let t = k as f64 * h;
        let mut drive = |name: &str, f: &dyn Fn(f64) -> f64| {
            input(&mut m, name, f(t), if slopes { (f(t + h) - f(t)) / h } else { 0.0 });
        };
        drive("voltage", &|t| 20.0 + 10.0 * (9.0 * t).sin());
        drive("duty", &|t| (7.0 * t).sin());
        drive("current_command", &|t| 6.0 * (8.0 * t).sin());
        drive("load_torque", &|t| 0.05 * (5.0 * t).cos());
        drive("imposed_speed", &|t| 900.0 * (4.0 * t).sin());
        drive("fan_command", &|t| 0.5 - 0.5 * (3.0 * t).cos());
        drive("ambient_temperature", &|t| 298.15 + 5.0 * t);
        drive("electrical_power", &|t| 20.0 + 15.0 * (6.0 * t).sin());
        drive("heat_power", &|t| 3.0 * (2.0 * t).sin());
        m.step(m.time(), h).unwrap();
        each(&mut m);
    }
}

#[test]
fn the_power_balance_closes_at_every_instant() {
    for drive in DRIVES {
        for coupling in COUPLINGS {
            for effects in cases() {
                run(drive, coupling, effects, true, |m| {
                    let error = output(m, "power_balance_error");
                    assert!(error.abs() <= 1e-6, "{drive:?} {coupling:?} at {} s: {error} W", m.time());
                });
            }
        }
    }
}

/// In minus out minus stored, as the model itself integrates them.
#[test]
fn the_energy_books_close_over_a_run() {
    for drive in DRIVES {
        for coupling in COUPLINGS {
            for (slopes, effects) in
                [true, false].into_iter().flat_map(|s| cases().into_iter().map(move |e| (s, e)))
            {
                let (mut worst, mut throughput) = (0.0f64, 0.0f64);
                run(drive, coupling, effects, slopes, |m| {
                    worst = worst.max(output(m, "energy_balance_error").abs());
                    throughput = throughput.max(output(m, "energy_electrical").abs());
                });
                assert!(throughput > 1.0, "{drive:?} {coupling:?}: nothing went through");
                assert!(worst <= 1e-6 * throughput, "{drive:?} {coupling:?}: {worst} J of {throughput} J");
            }
        }
    }
}

/// The energy balance from outside: an hour at 5 A, electrical energy by the caller's own quadrature of the power,
/// against heat stored by the temperatures and heat given away by the conductance.
#[test]
fn the_books_close_for_an_onlooker() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.inputs.current_command = 5.0;
    m.start(0.0).unwrap();
    let h = 1.0;
    let look = |m: &mut AnnulusCooledMotor| (output(m, "power_electrical"), output(m, "heat_to_ambient"));
    let (mut taken, mut given) = (0.0, 0.0);
    let mut before = look(&mut m);
    for _ in 0..3600 {
        // Simpson's rule with the half step seen on the way.
        m.step(m.time(), 0.5 * h).unwrap();
        let middle = look(&mut m);
        m.step(m.time(), 0.5 * h).unwrap();
        let after = look(&mut m);
        taken += h / 6.0 * (before.0 + 4.0 * middle.0 + after.0);
        given += h / 6.0 * (before.1 + 4.0 * middle.1 + after.1);
        before = after;
    }
    let rise = m.state().temperature.add_scalar(-298.15);
    let stored = m.parameters.thermal.C_w * rise[0] + m.parameters.thermal.C_h * rise[1];
    assert!(taken > 30e3);
    assert!((taken - given - stored).abs() <= 1e-6 * taken, "{taken} - {given} - {stored} J");
}

/// Heat runs from hot to cold, and friction only heats.
#[test]
fn signs() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.parameters.effects.coulomb_friction = friction(0.01);
    m.inputs.current_command = 5.0;
    m.inputs.imposed_speed = -500.0;
    m.start(0.0).unwrap();
    for _ in 0..60 {
        m.step(m.time(), 1.0).unwrap();
    }
    assert!(output(&mut m, "winding_temperature") > output(&mut m, "housing_temperature"));
    assert!(output(&mut m, "housing_temperature") > 298.15);
    assert!(output(&mut m, "heat_to_ambient") > 0.0);
    assert!(output(&mut m, "loss_friction") > 0.0);
    // A positive current against a negative speed brakes: the shaft gives power to the motor.
    assert!(output(&mut m, "power_mechanical") < 0.0);
    // k_t I + tau_c: at a negative speed friction pushes forward.
    let k_t = output(&mut m, "torque_constant");
    assert!((output(&mut m, "shaft_torque") - (5.0 * k_t + 0.01)).abs() < 1e-12);
    // Voltage of a braking motor: R I minus the back-EMF.
    let r = output(&mut m, "winding_resistance");
    assert!((output(&mut m, "terminal_voltage") - (5.0 * r - 500.0 * k_t)).abs() < 1e-12);
    assert!(r > 0.386 && k_t < 0.0276, "hot copper resists more, hot magnets pull less");
}

/// The residual resolves what a microampere stores in the inductance: energies count from the start and not from 0 K, where
/// the motor's 48 kJ of heat round to 7e-12 J.
#[test]
fn the_residual_is_not_the_rounding_of_heat_above_0_k() {
    for name in ["AnnulusCooledMotor", "BrushedGearmotor"] {
        let mut m = (physics::models::by_name(name).unwrap().new)();
        let slot = |name: &str| m.declaration().by_name(name).unwrap().slot;
        let (residual, inductance) = (slot("energy_balance_error"), slot("motor.L"));
        assert_eq!(m.declaration().by_name("energy_balance_error").unwrap().row.nominal, 1.0);
        m.enter_model_exchange();
        m.start(0.0).unwrap();
        let mut states = vec![0.0; m.declaration().states.len()];
        m.read_states(&mut states);
        let (i, aside) = (5.0, 5.0 + 1e-6);
        states[0] = i;
        m.write_states(&states);
        let first = m.get(residual);
        states[0] = aside;
        m.write_states(&states);
        let difference = m.get(residual) - first;
        let stored = 0.5 * m.get(inductance) * (aside * aside - i * i);
        assert!((difference / -stored - 1.0).abs() < 1e-5, "{name}: {difference} J instead of {} J", -stored);
    }
}

/// A small motor (Faulhaber 1524 006 SR) under a load that turns it back at 56,000 rpm, its winding warming by 1,000 K/s: the resistance
/// moves within each millisecond, and the energies are still those of one solution.
#[test]
fn the_books_close_while_the_winding_heats_fast() {
    for (load, voltage) in [(0.05, 24.0), (-0.03, -12.0), (0.0, 48.0)] {
        let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
        for (name, value) in [
            ("motor.R_ref", 5.1),
            ("motor.L", 1.1e-4),
            ("motor.k_t", 0.006),
            ("motor.J", 5.8e-8),
            ("thermal.R_wh", 10.0),
            ("thermal.C_w", 0.56),
            ("effect.coulomb_friction.tau_c", 7.8e-5),
        ] {
            input_parameter(&mut m, name, value);
        }
        (m.inputs.voltage, m.inputs.load_torque) = (voltage, load);
        m.start(0.0).unwrap();
        for _ in 0..80 {
            m.step(m.time(), 1e-3).unwrap();
        }
        let turned_over =
            output(&mut m, "energy_electrical").abs() + output(&mut m, "energy_mechanical").abs();
        let error = output(&mut m, "energy_balance_error");
        assert!(error.abs() < 5e-7 * turned_over, "{load} N.m: {error} J of {turned_over} J");
    }
}

/// A parameter tuned on the way does not put energy into the energy balance.
#[test]
fn tuning_a_parameter_keeps_the_books() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.inputs.current_command = 5.0;
    m.start(0.0).unwrap();
    m.step(m.time(), 100.0).unwrap();
    input_parameter(&mut m, "thermal.C_h", 300.0);
    m.step(m.time(), 100.0).unwrap();
    let error = output(&mut m, "energy_balance_error");
    assert!(error.abs() < 1e-6 * output(&mut m, "energy_electrical"), "{error} J");
}

fn input_parameter(m: &mut AnnulusCooledMotor, name: &str, value: f64) {
    let slot = m.declaration().by_name(name).unwrap().slot;
    assert!(m.set(slot, value));
}

/// A second in which everything moves; all outputs and states at its end, bit for bit.
fn bits(
    (drive, coupling): (DriveMode, MechanicalMode),
    cooling: CoolingMode,
    change: impl Fn(&Entry) -> Option<f64>,
) -> Vec<u64> {
    let mut m = motor(drive, coupling);
    m.parameters.choices.cooling_mode = cooling;
    let entries = || m.declaration().entries.iter().filter(|e| e.name.starts_with("effect."));
    let changes: Vec<_> = entries().filter_map(|e| change(e).map(|value| (e.slot, value))).collect();
    for (slot, value) in changes {
        assert!(m.set(slot, value));
    }
    m.inputs.load_torque = 0.03;
    m.inputs.electrical_power = 20.0;
    m.inputs.imposed_speed = 300.0;
    m.start(0.0).unwrap();
    for k in 0..100 {
        let x = f64::from(k);
        input(&mut m, "voltage", if drive == DriveMode::Pwm { 24.0 } else { 20.0 * (0.1 * x).sin() }, 0.0);
        input(&mut m, "duty", 0.8 * (0.1 * x).sin(), 3.0);
        input(&mut m, "current_command", 4.0 * (0.1 * x).sin(), 3.0);
        input(&mut m, "fan_command", 0.008 * x, 0.8);
        m.step(m.time(), 1e-2).unwrap();
    }
    let shown: Vec<_> = m
        .declaration()
        .entries
        .iter()
        .filter(|e| e.row.causality == Causality::Output)
        .map(|e| e.slot)
        .collect();
    let outputs: Vec<u64> = shown.into_iter().map(|slot| m.get(slot).to_bits()).collect();
    m.state().to_numbers().map(f64::to_bits).chain(outputs).collect()
}

/// A parameter that switches its effect: it starts at 0, where the effect is off.
fn is_switch(entry: &Entry) -> bool {
    entry.row.kind == Kind::Real && entry.row.start == 0.0 && entry.name != "effect.demagnetisation.time"
}

/// The effect of a parameter, `effect.ID.parameter`.
fn effect(entry: &Entry) -> &str {
    entry.name.split('.').nth(1).unwrap()
}

/// The greatest value of a number, the last choice of an enumeration.
fn extreme(entry: &Entry) -> f64 {
    match entry.row.kind {
        Kind::Enumeration(t) => t.items.last().map_or(1.0, |i| f64::from(i.value)),
        _ => entry.row.max,
    }
}

/// All effects are off by default, and their other parameters then do nothing, to the bit.
#[test]
fn an_effect_that_is_off_is_not_there() {
    for drive in DRIVES {
        for cooling in cooling_modes() {
            let modes = (drive, MechanicalMode::FreeShaft);
            let others = bits(modes, cooling, |e| (!is_switch(e)).then(|| extreme(e)));
            assert_eq!(bits(modes, cooling, |_| None), others, "{drive:?} {cooling:?}");
        }
    }
}

/// Each effect of the table has a switch, and with it on something moves: else the test above would show nothing.
#[test]
fn an_effect_that_is_on_is_seen() {
    let m = motor(DriveMode::Pwm, MechanicalMode::FreeShaft);
    let entries = m.declaration().entries.iter().filter(|e| e.name.starts_with("effect."));
    // Terms have a gain, which starts at 1, and no term.
    let ids: BTreeSet<&str> = entries.map(effect).filter(|id| *id != "generic_term").collect();
    assert!(ids.len() >= 22, "{ids:?}");
    for id in ids {
        let on = |e: &Entry| (effect(e) == id && is_switch(e)).then_some(e.row.nominal.min(0.5 * e.row.max));
        let moves = |modes| {
            bits(modes, CoolingMode::Conductance, |_| None) != bits(modes, CoolingMode::Conductance, on)
        };
        // A drive with its bridge, and one that has losses of its own; a shaft that is free, and one that is driven.
        let drives = [DriveMode::Pwm, DriveMode::Power].into_iter();
        let mut modes = drives.flat_map(|drive| COUPLINGS.map(|coupling| (drive, coupling)));
        assert!(modes.any(moves), "{id} does nothing");
    }
}

/// Read alone, some outputs are evaluated without the rest of the balance: the same value to the last bit.
#[test]
fn an_output_read_alone_is_that_of_the_balance() {
    for drive in DRIVES {
        for coupling in COUPLINGS {
            for effects in [Effects::default(), Effects::examples()] {
                let mut step = 0;
                run(drive, coupling, effects, true, |m| {
                    step += 1;
                    if step % 50 != 0 {
                        return;
                    }
                    let mut all = m.clone();
                    output(&mut all, "power_balance_error");
                    let entries = m.declaration().entries.iter();
                    for entry in entries.filter(|entry| entry.row.causality == Causality::Output) {
                        let (alone, in_balance) = (m.clone().get(entry.slot), all.get(entry.slot));
                        assert_eq!(
                            alone.to_bits(),
                            in_balance.to_bits(),
                            "{} {drive:?} {coupling:?}",
                            entry.name
                        );
                    }
                });
            }
        }
    }
}
