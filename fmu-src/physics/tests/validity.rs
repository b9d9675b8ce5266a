//! A run ends at its limits of validity, in every mode, and the torque constant is positive up to there.

use crate::common::{cooling_modes, motor};
use physics::components::commutation::Commutation;
use physics::model::Model;
use physics::models;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode};

fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap().slot;
    m.get(slot)
}

fn set(m: &mut dyn Model, name: &str, value: f64) {
    let slot = m.declaration().by_name(name).unwrap().slot;
    assert!(m.set(slot, value), "{name}");
}

/// Steps until the model ends: the time, the sentence, and what was seen on the way of the torque constant.
fn run_to_the_end(m: &mut dyn Model, h: f64, most: f64) -> (f64, String, f64) {
    m.start(0.0).unwrap();
    let mut least = f64::INFINITY;
    let mut t = 0.0;
    while t < most {
        match m.step(t, h) {
            Ok(()) => t += h,
            Err(fault) => {
                assert!(m.ended(), "{fault}");
                least = least.min(get(m, "torque_constant"));
                return (m.time(), fault.0, least);
            }
        }
        least = least.min(get(m, "torque_constant"));
    }
    panic!("no end within {most} s: {} K", get(m, "winding_temperature"));
}

fn overloaded(cooling: CoolingMode, drive: DriveMode, mechanical: MechanicalMode) -> AnnulusCooledMotor {
    let mut m = motor(drive, mechanical);
    m.parameters.choices.cooling_mode = cooling;
    m.parameters.choices.commutation = Commutation::Block;
    m.inputs.fan_command = 0.3;
    match drive {
        DriveMode::Current => m.inputs.current_command = 25.0,
        DriveMode::Power => m.inputs.electrical_power = 300.0,
        DriveMode::Voltage => (m.inputs.voltage, m.inputs.load_torque) = (9.0, 0.4),
        DriveMode::Pwm => (m.inputs.voltage, m.inputs.duty, m.inputs.load_torque) = (36.0, 0.25, 0.4),
    }
    m
}

#[test]
fn a_runaway_ends_in_every_mode() {
    for cooling in cooling_modes() {
        for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
            for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
                // Voltage on a free shaft under a load that it cannot hold would turn it backwards for ever.
                let mechanical = if drive == DriveMode::Current || drive == DriveMode::Power {
                    mechanical
                } else {
                    MechanicalMode::ImposedSpeed
                };
                let mut m = overloaded(cooling, drive, mechanical);
                let (time, sentence, k_t) = run_to_the_end(&mut m, 1.0, 2e4);
                let case = format!("{cooling:?} {drive:?} {mechanical:?}: {sentence}");
                assert!(time > 1.0 && sentence.contains("validity.winding_temperature = 543.15 K"), "{case}");
                assert!(sentence.contains("runaway") && k_t > 0.0, "{case}");
                let hot = get(&mut m, "winding_hot_spot_temperature");
                assert!(hot < 543.15 && hot > 543.15 - 1e-3, "{hot} K, {case}");
                // Whoever tries again is told the same, and nothing moves.
                let again = m.step(time, 1.0).unwrap_err();
                assert!(m.ended() && m.time() - time < 1e-6, "{again}");
            }
        }
    }
}

/// One step of an hour ends where steps of 10 ms end.
#[test]
fn the_time_does_not_depend_on_the_step() {
    let end = |h: f64| {
        let mut m = overloaded(CoolingMode::Conductance, DriveMode::Current, MechanicalMode::ImposedSpeed);
        m.parameters.choices.commutation = Commutation::EquivalentDc;
        run_to_the_end(&mut m, h, 7200.0).0
    };
    let (fine, coarse) = (end(0.01), end(3600.0));
    assert!((fine / coarse - 1.0).abs() < 1e-5, "{fine} s and {coarse} s");
}

/// The seeds' extreme, alpha_mag of -0.004 1/K: the run ends before the linear law turns the torque round at 548.15 K.
#[test]
fn the_torque_constant_stays_positive() {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.motor.alpha_mag = -0.004;
    m.parameters.validity.winding_temperature = 1273.15;
    m.inputs.electrical_power = 100.0;
    let (time, sentence, k_t) = run_to_the_end(&mut m, 10.0, 1e5);
    assert!(sentence.contains("torque constant falls to 0") && sentence.contains("548.1"), "{sentence}");
    assert!(k_t > 0.0 && k_t < 1e-6 && time.is_finite(), "{k_t} N.m/A");
}

#[test]
fn heat_taken_out_ends_at_the_cold_side() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.inputs.heat_power = -500.0;
    let (_, sentence, _) = run_to_the_end(&mut m, 1.0, 1e5);
    assert!(sentence.contains("validity.lowest_temperature = 100 K"), "{sentence}");
}

#[test]
fn the_gearmotor_ends_too() {
    let mut m = (models::by_name("BrushedGearmotor").unwrap().new)();
    set(m.as_mut(), "duty", 1.0);
    set(m.as_mut(), "supply_voltage", 60.0);
    set(m.as_mut(), "load_torque", 5.0);
    let (time, sentence, k_t) = run_to_the_end(m.as_mut(), 1.0, 1e5);
    assert!(sentence.contains("validity.winding_temperature = 543.15 K") && time > 1.0, "{sentence}");
    assert!(k_t > 0.0);
}

/// Model Exchange: the indicator passes zero at the limit, and the event says that the run is over.
#[test]
fn an_importer_locates_the_end() {
    for name in ["AnnulusCooledMotor", "BrushedGearmotor"] {
        let mut m = (models::by_name(name).unwrap().new)();
        m.enter_model_exchange();
        m.start(0.0).unwrap();
        let names: Vec<String> =
            m.declaration().states.iter().map(|[k, _]| m.declaration().entries[*k].name.clone()).collect();
        let mut states = vec![0.0; names.len()];
        m.read_states(&mut states);
        let winding = names.iter().position(|n| n == "state.winding_temperature").unwrap();
        for (t, over) in [(500.0, false), (543.1, false), (543.15, true), (600.0, true)] {
            states[winding] = t;
            m.write_states(&states);
            m.accept_step();
            let indicator = get(m.as_mut(), "event.validity_limit");
            assert!((indicator - (t - 543.15)).abs() < 1e-9, "{name} at {t} K: {indicator}");
            assert_eq!(m.termination_reason().is_some(), over, "{name} at {t} K");
        }
    }
}
