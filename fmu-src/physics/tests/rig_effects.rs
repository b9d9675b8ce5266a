//! Effects of test rigs in the equations: speed-dependent convection, losses in the stator, shaft power, zero of the torque sensor.

use crate::common::motor;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode};
use physics::models::brushed_gearmotor::BrushedGearmotor;

fn set(m: &mut dyn Model, name: &str, value: f64) {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    assert!(m.set(slot, value), "{name} = {value}");
}

fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

/// A motor with two nodes at an imposed speed, at 298.15 K.
fn two_nodes(drive: DriveMode, speed: f64) -> AnnulusCooledMotor {
    let mut m = motor(drive, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = CoolingMode::Conductance;
    (m.inputs.imposed_speed, m.inputs.ambient_temperature) = (speed, 298.15);
    m
}

fn settle(m: &mut dyn Model) {
    m.start(0.0).unwrap();
    (0..60).for_each(|_| m.step(m.time(), 1000.0).unwrap());
}

/// 6 W leave by G_still + G (|w|/w_ref)^n: with 0.05 W/K at 100 rad/s and n = 0.5, 0.1 W/K more at 400 rad/s, either way; none at
/// standstill.
#[test]
fn convection_grows_with_the_speed() {
    for (speed, further) in [(400.0, 0.1), (-400.0, 0.1), (100.0, 0.05), (0.0, 0.0)] {
        let mut m = two_nodes(DriveMode::Current, speed);
        m.inputs.heat_power = 6.0;
        set(&mut m, "effect.speed_convection.G", 0.05);
        set(&mut m, "effect.speed_convection.n", 0.5);
        settle(&mut m);
        let rise = get(&mut m, "housing_temperature") - 298.15;
        let expected = 6.0 / (m.parameters.conductance.G_still + further);
        assert!((rise / expected - 1.0).abs() < 1e-6, "{speed} rad/s: {rise} and {expected} K");
    }
}

/// With a network of nodes the housing is cooler at speed. At standstill the effect changes no heat flow at the same temperatures, and the
/// housing is as warm as without it within the error of the linearised cooling, 4e-6 (docs/architecture.md): a rounding error can move the
/// temperatures at which the cooling is linearised.
#[test]
fn convection_cools_a_network_as_well() {
    let settled = |speed: f64, conductance: f64| {
        let mut m = two_nodes(DriveMode::Current, speed);
        m.parameters.choices.cooling_mode = CoolingMode::Bare;
        m.inputs.heat_power = 6.0;
        set(&mut m, "effect.speed_convection.G", conductance);
        settle(&mut m);
        m
    };
    let rise =
        |speed: f64, conductance: f64| get(&mut settled(speed, conductance), "housing_temperature") - 298.15;
    let mut m = settled(0.0, 0.05);
    let with = get(&mut m, "heat_to_ambient");
    set(&mut m, "effect.speed_convection.G", 0.0);
    assert!((get(&mut m, "heat_to_ambient") / with - 1.0).abs() < 1e-12, "{with} W");
    let [still, moving, without] = [rise(0.0, 0.05), rise(100.0, 0.05), rise(100.0, 0.0)];
    assert!((still / rise(0.0, 0.0) - 1.0).abs() < 4e-6, "{still} K");
    assert!(moving < 0.9 * without, "{moving} and {without} K");
}

/// A step holds the speed in its middle: halving the step on a ramp from 100 to 500 rad/s quarters the error of the temperature. The steps
/// are too short to be divided.
#[test]
fn convection_on_a_ramp_is_of_second_order() {
    let end = |steps: u32| {
        let mut m = two_nodes(DriveMode::Current, 100.0);
        m.inputs.heat_power = 6.0;
        set(&mut m, "effect.speed_convection.G", 0.05);
        m.start(0.0).unwrap();
        let h = 400.0 / f64::from(steps);
        for _ in 0..steps {
            m.set_slope(m.declaration().by_name("imposed_speed").unwrap().slot, 1.0);
            m.step(m.time(), h).unwrap();
        }
        assert!(get(&mut m, "energy_balance_error").abs() < 1e-6);
        get(&mut m, "housing_temperature")
    };
    let truth = end(4096);
    let errors = [64, 128, 256].map(|steps| (end(steps) - truth).abs());
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 1.7, "order {order}, errors {errors:?} K");
    }
}

/// Of 20 W, 10 % stay in the drive, 25 % of the rest heat the housing, and 1e-8 w^2 w = 1.25 W leave by the shaft at 500 rad/s: the
/// winding gets 18 * 0.75 - 1.25 = 12.25 W, the housing 4.5 W. In steady state the winding is 12.25 W * R_wh above the housing, and
/// the housing 16.75 W / G above ambient.
#[test]
fn electrical_power_is_divided() {
    for speed in [500.0, -500.0] {
        let mut m = two_nodes(DriveMode::Power, speed);
        m.inputs.electrical_power = 20.0;
        for (name, value) in
            [("drive_loss.share", 0.1), ("stator_loss.fraction", 0.25), ("propeller_load.k", 1e-8)]
        {
            set(&mut m, &format!("effect.{name}"), value);
        }
        settle(&mut m);
        let [winding, housing] = ["winding_temperature", "housing_temperature"].map(|name| get(&mut m, name));
        let (r, g) = (m.parameters.thermal.R_wh, m.parameters.conductance.G_still);
        assert!(((winding - housing) / (12.25 * r) - 1.0).abs() < 1e-6, "{winding} and {housing} K");
        assert!(((housing - 298.15) * g / 16.75 - 1.0).abs() < 1e-6, "{housing} K");
        for (name, value) in [
            ("power_electrical", 20.0),
            ("power_mechanical", 1.25),
            ("shaft_torque", 2.5e-3 * speed.signum()),
            ("loss_copper", 12.25),
            ("loss_drive", 2.0),
            ("heat_to_ambient", 18.75),
            ("power_balance_error", 0.0),
        ] {
            let shown = get(&mut m, name);
            assert!((shown - value).abs() < 1e-5, "{name} at {speed} rad/s: {shown} and {value}");
        }
        let throughput = get(&mut m, "energy_electrical");
        assert!((get(&mut m, "energy_balance_error") / throughput).abs() < 1e-9);
    }
}

/// In the other modes the current carries the power: neither effect acts.
#[test]
fn power_is_divided_in_drive_mode_power_only() {
    let outputs = |effects: &[(&str, f64)]| {
        let mut m = two_nodes(DriveMode::Current, 500.0);
        (m.inputs.current_command, m.inputs.heat_power) = (4.0, 2.0);
        effects.iter().for_each(|(name, value)| set(&mut m, name, *value));
        m.start(0.0).unwrap();
        m.step(0.0, 100.0).unwrap();
        ["winding_temperature", "housing_temperature", "shaft_torque", "energy_electrical"]
            .map(|n| get(&mut m, n))
    };
    let with = outputs(&[("effect.stator_loss.fraction", 0.3), ("effect.propeller_load.k", 1e-8)]);
    assert_eq!(with, outputs(&[]));
}

/// The zero of the torque sensor changes the indicated torque of both motors by its value, and nothing else.
#[test]
fn the_zero_of_a_torque_sensor_is_only_indicated() {
    let run = |mut m: Box<dyn Model>, offset: f64| -> Vec<(String, f64)> {
        set(m.as_mut(), "effect.torque_sensor_offset.offset", offset);
        set(m.as_mut(), "load_torque", 0.02);
        m.start(0.0).unwrap();
        m.step(0.0, 0.5).unwrap();
        let outputs =
            m.declaration().entries.iter().filter(|e| e.row.causality == physics::declare::Causality::Output);
        let outputs: Vec<_> = outputs.map(|e| (e.name.clone(), e.slot)).collect();
        outputs.into_iter().map(|(name, slot)| (name, m.get(slot))).collect()
    };
    let mut motor = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    motor.inputs.voltage = 12.0;
    let mut gearmotor = BrushedGearmotor::default();
    (gearmotor.inputs.duty, gearmotor.inputs.supply_voltage) = (1.0, 12.0);
    let models: [Box<dyn Model>; 2] = [Box::new(motor), Box::new(gearmotor)];
    for model in models {
        let (without, with) = (run(model.boxed_clone(), 0.0), run(model.boxed_clone(), 0.003));
        for ((name, plain), (_, indicated)) in without.iter().zip(&with) {
            let expected = if name == "shaft_torque" { plain + 0.003 } else { *plain };
            assert_eq!(*indicated, expected, "{name}");
        }
        assert_eq!(
            without.iter().find(|(name, _)| name == "shaft_torque").map(|(_, torque)| *torque),
            Some(0.02)
        );
    }
}
