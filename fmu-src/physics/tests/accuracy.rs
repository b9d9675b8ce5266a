//! The split against diffsol (BDF at 1e-10) on the same equations, and what is left between them.

use crate::common::{Errors, Profile, compare, friction, motor};
use physics::effects::{Effects, SpeedConvection, StatorNode};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use std::collections::BTreeSet;

/// Volts on a locked rotor: the current rises in 0.17 ms steps' time, the winding heats at 15 K/s and more.
#[test]
fn locked_rotor_current_step() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::ImposedSpeed);
    m.inputs.voltage = 4.0;
    let error = compare(m, &Profile::constant(), 0.05, 1e-3);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// Volts on a free shaft under load and friction: current peak, speed, back-EMF.
#[test]
fn free_shaft_voltage_step_under_load() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.coulomb_friction = friction(0.00983);
    m.parameters.effects.viscous_friction.k = 2e-6;
    m.inputs.voltage = 24.0;
    m.inputs.load_torque = 0.05;
    let error = compare(m, &Profile::constant(), 0.2, 1e-3);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// One hour at 5 A, locked: the thesis's experiment.
#[test]
fn one_hour_at_five_amperes() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.inputs.current_command = 5.0;
    let error = compare(m, &Profile::constant(), 3600.0, 1.0);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// A drive cycle whose inputs run along lines of 50 ms, with the shaft reversing under friction.
#[test]
fn drive_cycle_with_linear_ramps() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.coulomb_friction = friction(0.00983);
    let error = compare(m, &Profile::ramps(0.05), 2.0, 1e-3);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// The same cycle with every input held for 1 ms, in both integrations.
#[test]
fn drive_cycle_with_inputs_held_for_a_millisecond() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.coulomb_friction = friction(0.00983);
    let error = compare(m, &Profile::held(0.05), 0.5, 1e-3);
    assert!(error.worst() <= 1e-5, "{error}");
}

/// Imposed current and speed along lines, as bench data are replayed, with the fan running up.
#[test]
fn imposed_current_and_speed_on_ramps() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.parameters.effects.coulomb_friction = friction(0.005);
    let error = compare(m, &Profile::ramps(2.0), 60.0, 0.5);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// Imposed current on a free shaft, and a chopped supply on an imposed one: the other two of the four blocks.
#[test]
fn the_mixed_modes() {
    let mut m = motor(DriveMode::Current, MechanicalMode::FreeShaft);
    m.parameters.effects.viscous_friction.k = 1e-5;
    let error = compare(m, &Profile::ramps(0.05), 0.5, 1e-3);
    assert!(error.worst() <= 1e-6, "{error}");

    let mut m = motor(DriveMode::Pwm, MechanicalMode::ImposedSpeed);
    m.inputs.voltage = 24.0;
    let error = compare(m, &Profile::ramps(0.05), 0.5, 1e-3);
    assert!(error.worst() <= 1e-6, "{error}");

    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.inputs.electrical_power = 10.0;
    let error = compare(m, &Profile::ramps(1.0), 100.0, 0.5);
    assert!(error.worst() <= 1e-6, "{error}");
}

/// The step that the caller chooses does not matter: 0.1 ms, 1 ms and 10 ms agree.
#[test]
fn the_callers_step_does_not_matter() {
    for h in [1e-4, 1e-2] {
        let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
        m.parameters.effects.coulomb_friction = friction(0.00983);
        let error = compare(m, &Profile::ramps(0.05), 0.5, h);
        assert!(error.worst() <= 1e-6, "{h} s: {error}");
    }
}

/// What to do where an effect has a too large error.
const REMEDY: &str = "A value is constant over a step. An effect of drag, voltage, resistance or torque constant that depends on a \
    temperature or on another driver uses a port that gets all drivers (driven_drag, driven_voltage, ...). set_drivers with `at Any` is \
    for quantities that change little within a step (docs/extending.md, \"Add an effect\").";

/// Effects that a run without a network compares: each of the table alone, then all together. The list is that of the
/// declaration, so that none is omitted. The stator node is not among the states of `Step::rates` (`network.rs` compares it);
/// terms come from a file (`terms.rs`), and what follows its driver in the middle of a step as they do is compared in
/// `rig_effects.rs`.
fn examples() -> Effects {
    Effects {
        stator_node: StatorNode::default(),
        speed_convection: SpeedConvection::default(),
        ..Effects::examples()
    }
}

/// Each of these effects alone, then all together.
fn each_and_all() -> Vec<(String, Effects)> {
    let mut all = AnnulusCooledMotor::default();
    all.parameters.effects = examples();
    let entries = all.declaration().entries.iter().filter(|e| e.name.starts_with("effect."));
    let entries: Vec<_> = entries.map(|e| (e.name.split('.').nth(1).unwrap(), e.slot)).collect();
    let ids: BTreeSet<&str> = entries.iter().map(|(id, _)| *id).collect();
    assert!(ids.len() >= 27, "{ids:?}");
    let alone = ids.into_iter().map(|id| {
        let mut one = AnnulusCooledMotor::default();
        for (_, slot) in entries.iter().filter(|(of, _)| *of == id) {
            let value = all.get(*slot);
            assert!(one.set(*slot, value));
        }
        (id.to_string(), one.parameters.effects)
    });
    let mut cases: Vec<_> = alone.collect();
    cases.push(("all".to_string(), all.parameters.effects));
    cases
}

/// Every effect alone and all together, in every drive and mechanical mode, with ramps of all inputs through the transitions of
/// all effects: no value is held over a step. At 10 ms the integrator's tolerance leaves up to 7e-6; a ripple that is held over the
/// step errs by 1.2e-3.
#[test]
fn every_effect_follows_its_inputs_within_a_step() {
    for (name, effects) in each_and_all() {
        for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
            for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
                let stop = if name == "all" { 0.5 } else { 0.1 };
                let error = with_effects(drive, mechanical, effects, (stop, 1e-2));
                assert!(error.worst() <= 1e-5, "{name} {drive:?} {mechanical:?}: {error}\n{REMEDY}");
            }
        }
    }
}

/// All effects at a step of 1 ms.
#[test]
fn all_effects_on_ramps_in_every_mode() {
    let effects = examples();
    for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
        for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
            let error = with_effects(drive, mechanical, effects, (0.5, 1e-3));
            assert!(error.worst() <= 1e-6, "{drive:?} {mechanical:?}: {error}\n{REMEDY}");
        }
    }
}

fn with_effects(
    drive: DriveMode,
    mechanical: MechanicalMode,
    effects: Effects,
    (stop, h): (f64, f64),
) -> Errors {
    let mut m = motor(drive, mechanical);
    m.parameters.effects = effects;
    m.inputs.electrical_power = 10.0;
    if drive == DriveMode::Pwm {
        m.inputs.voltage = 24.0;
    }
    compare(m, &Profile::ramps(0.05), stop, h)
}
