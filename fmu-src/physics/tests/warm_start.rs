//! A motor that starts warm: every node where it was put, and books that close from there.

use crate::common::{all_effects, motor};
use physics::model::{Model, Node};
use physics::models::annulus_cooled_motor::{CoolingMode, DriveMode, MechanicalMode};
use physics::models::brushed_gearmotor::BrushedGearmotor;
use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product};

const MODES: [CoolingMode; 6] = [
    CoolingMode::Conductance,
    CoolingMode::Bare,
    CoolingMode::FanCrossflow,
    CoolingMode::AnnulusPush,
    CoolingMode::AnnulusPull,
    CoolingMode::WaterJacket,
];

fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

/// Runs a second and says what the books miss at worst, J.
fn books(m: &mut dyn Model) -> f64 {
    let mut worst = get(m, "energy_balance_error").abs();
    for k in 0..100 {
        m.step(0.01 * f64::from(k), 0.01).unwrap();
        worst = worst.max(get(m, "energy_balance_error").abs());
    }
    worst
}

#[test]
fn every_node_starts_where_it_was_put() {
    for mode in MODES {
        let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
        m.parameters.choices.cooling_mode = mode;
        m.inputs.ambient_temperature = 295.0;
        m.start(0.0).unwrap();
        let known =
            [(Node::Winding, 360.0), (Node::Housing, 330.0), (Node::Stator, 345.0), (Node::Magnets, 335.0)];
        assert!(m.warm_start(&known));
        assert_eq!(get(&mut m, "winding_temperature"), 360.0);
        assert_eq!(get(&mut m, "housing_temperature"), 330.0, "{mode:?}");
        // Two nodes have stator and magnets at the housing's temperature.
        let two = mode == CoolingMode::Conductance;
        assert_eq!(get(&mut m, "stator_temperature"), if two { 330.0 } else { 345.0 });
        assert_eq!(get(&mut m, "magnet_temperature"), if two { 330.0 } else { 335.0 });
        // Heat flows at once, by the law of the model.
        assert!(get(&mut m, "heat_to_ambient") > 0.1, "{mode:?}");
    }
}

#[test]
fn a_node_that_is_not_named_takes_the_nearest() {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = CoolingMode::AnnulusPush;
    m.start(0.0).unwrap();
    assert!(!m.warm_start(&[]));
    assert!(!m.warm_start(&[(Node::Box, 310.0)]), "there is no box");
    assert_eq!(get(&mut m, "winding_temperature"), m.inputs.ambient_temperature);
    assert!(m.warm_start(&[(Node::Winding, 360.0), (Node::Housing, 330.0)]));
    assert_eq!(get(&mut m, "stator_temperature"), 330.0);
    assert_eq!(get(&mut m, "magnet_temperature"), 330.0);
    assert!(m.warm_start(&[(Node::Winding, 350.0)]));
    for name in ["stator_temperature", "magnet_temperature", "housing_temperature"] {
        assert_eq!(get(&mut m, name), 350.0, "{name}");
    }
}

#[test]
fn the_books_close_from_a_warm_start() {
    for mode in MODES {
        let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
        m.parameters.choices.cooling_mode = mode;
        m.parameters.effects = all_effects();
        // Heat capacities that move with the temperature: the stores at the start depend on where it is.
        let factor =
            Factor { driver: Driver::WindingTemperature, offset: 250.0, reference: 50.0, exponent: 1.0 };
        let law = Law::Product(Product { coefficient: 0.1, factors: [Some(factor), None, None] });
        assert!(m.set_terms(&[GenericTerm { port: Port::HeatCapacity, law }]));
        m.inputs.voltage = 24.0;
        m.start(0.0).unwrap();
        assert!(m.warm_start(&[(Node::Winding, 360.0), (Node::Housing, 330.0)]));
        let worst = books(&mut m);
        assert!(worst < 1e-6, "{mode:?}: {worst} J");
    }
}

/// A start at the temperatures that another instance has reached goes on as that one does.
#[test]
fn a_warm_start_goes_on_where_another_motor_is() {
    let started = || {
        let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
        m.inputs.electrical_power = 20.0;
        m.inputs.ambient_temperature = 295.0;
        m.start(0.0).unwrap();
        m
    };
    let (mut first, mut second) = (started(), started());
    for k in 0..600 {
        first.step(f64::from(k), 1.0).unwrap();
    }
    let at = |m: &mut dyn Model| [get(m, "winding_temperature"), get(m, "housing_temperature")];
    let [winding, housing] = at(&mut first);
    second.start(600.0).unwrap();
    assert!(second.warm_start(&[(Node::Winding, winding), (Node::Housing, housing)]));
    for k in 600..900 {
        first.step(f64::from(k), 1.0).unwrap();
        second.step(f64::from(k), 1.0).unwrap();
    }
    let off = at(&mut first)[0] - at(&mut second)[0];
    assert!(off.abs() < 1e-7, "{off} K");
}

#[test]
fn a_gearmotor_starts_warm_in_its_box() {
    let mut m = BrushedGearmotor::default();
    m.inputs.duty = 0.8;
    m.start(0.0).unwrap();
    assert!(!m.warm_start(&[]));
    assert!(m.warm_start(&[(Node::Housing, 320.0)]));
    assert_eq!(["winding", "box"].map(|n| get(&mut m, &format!("{n}_temperature"))), [320.0; 2]);
    assert!(m.warm_start(&[(Node::Winding, 330.0), (Node::Housing, 320.0), (Node::Box, 305.0)]));
    assert_eq!(get(&mut m, "winding_temperature"), 330.0);
    assert_eq!(get(&mut m, "housing_temperature"), 320.0);
    assert_eq!(get(&mut m, "box_temperature"), 305.0);
    let worst = books(&mut m);
    assert!(worst < 1e-6, "{worst} J");
}
