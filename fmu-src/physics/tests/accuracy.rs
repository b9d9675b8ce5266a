//! The split against diffsol (BDF at 1e-10) on the same equations, and what is left between them.

use crate::common::{Profile, compare, friction, motor};
use physics::effects::{Effects, StatorNode};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::terms::Driver;
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

/// Permitted error of temperatures and heat to ambient with effects that hold a driver over a step (`at Any`), as a fraction. A step is divided
/// where a held law changes by more than 1/32 of its span (`PARTS` in stepping.rs). The mean of a law with a derivative from -s to s over a
/// part differs from its value at the midpoint by at most 1/8 of 2 s times the part: 2/(8 x 32^2) of the span. Measured: 4.1e-5 at steps of
/// 10 ms, 6.6e-6 at 1 ms.
const HELD: f64 = 2.0 / (8.0 * 32.0 * 32.0);

/// What to do where an effect has a too large error.
const REMEDY: &str = "A value is constant over a step. An effect of drag, voltage, resistance or torque constant that depends on a \
    temperature or on another driver uses a port that gets all drivers (driven_drag, driven_voltage, ...). set_drivers with `at Any` is \
    for heat flows that change little within a step (docs/extending.md, \"Add an effect\").";

/// Effects that a run without a network compares: each of the table alone, then all together. The list is that of the
/// declaration, so that none is omitted. The stator node is not among the states of `Step::rates` (`network.rs` compares it);
/// terms come from a file (`terms.rs`).
fn examples() -> Effects {
    Effects { stator_node: StatorNode::default(), ..Effects::examples() }
}

/// Whether an effect holds a driver constant over a step.
fn holds_drivers(effects: &Effects) -> bool {
    Driver::ALL.iter().any(|driver| effects.holds(*driver))
}

/// Each of these effects alone, then all that hold no driver, then all together.
fn each_and_all() -> Vec<(String, Effects)> {
    let mut all = AnnulusCooledMotor::default();
    all.parameters.effects = examples();
    let entries = all.declaration().entries.iter().filter(|e| e.name.starts_with("effect."));
    let entries: Vec<_> = entries.map(|e| (e.name.split('.').nth(1).unwrap(), e.slot)).collect();
    let ids: BTreeSet<&str> = entries.iter().map(|(id, _)| *id).collect();
    assert!(ids.len() >= 27, "{ids:?}");
    let mut exact = AnnulusCooledMotor::default();
    let alone = ids.into_iter().map(|id| {
        let mut one = AnnulusCooledMotor::default();
        let values: Vec<_> =
            entries.iter().filter(|(of, _)| *of == id).map(|(_, slot)| (*slot, all.get(*slot))).collect();
        assert!(values.iter().all(|(slot, value)| one.set(*slot, *value)));
        if !holds_drivers(&one.parameters.effects) {
            assert!(values.iter().all(|(slot, value)| exact.set(*slot, *value)));
        }
        (id.to_string(), one.parameters.effects)
    });
    let mut cases: Vec<_> = alone.collect();
    cases.push(("all that hold no driver".to_string(), exact.parameters.effects));
    cases.push(("all".to_string(), all.parameters.effects));
    cases
}

/// Every effect alone and all together, in every drive and mechanical mode, with ramps of all inputs through the transitions of
/// all effects: no value is held over a step, except those of effects `at Any` at their mean. At 10 ms the integrator's tolerance leaves up
/// to 7e-6; a ripple that is held over the step errs by 1.2e-3.
#[test]
fn every_effect_follows_its_inputs_within_a_step() {
    for (name, effects) in each_and_all() {
        for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
            for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
                let stop = if name.starts_with("all") { 0.5 } else { 0.1 };
                assert_follows(&name, drive, mechanical, effects, (stop, 1e-2), 1e-5);
            }
        }
    }
}

/// All effects at a step of 1 ms.
#[test]
fn all_effects_on_ramps_in_every_mode() {
    for (name, effects) in each_and_all().into_iter().filter(|(name, _)| name.starts_with("all")) {
        for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
            for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
                assert_follows(&name, drive, mechanical, effects, (0.5, 1e-3), 1e-6);
            }
        }
    }
}

/// Compares a motor with these effects with the reference until `stop` with steps of `h`, s.
fn assert_follows(
    name: &str,
    drive: DriveMode,
    mechanical: MechanicalMode,
    effects: Effects,
    (stop, h): (f64, f64),
    tolerance: f64,
) {
    let mut m = motor(drive, mechanical);
    m.parameters.effects = effects;
    m.inputs.electrical_power = 10.0;
    if drive == DriveMode::Pwm {
        m.inputs.voltage = 24.0;
    }
    let error = compare(m, &Profile::ramps(0.05), stop, h);
    let of_heat = if holds_drivers(&effects) { HELD } else { tolerance };
    assert!(
        error.fast() <= tolerance && error.thermal() <= of_heat,
        "{name} {drive:?} {mechanical:?}: {error}\n{REMEDY}"
    );
}
