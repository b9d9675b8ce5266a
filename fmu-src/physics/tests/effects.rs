//! What single effects do to the motor as a whole, against numbers computed by hand.

use crate::common::motor;
use physics::effects::{ConvectionDriver, CooledNode, Effects, PerNode};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode, Temperatures,
};
use physics::solver::split::{Fast, System};
use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product};

pub fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

fn set(m: &mut AnnulusCooledMotor, name: &str, value: f64, slope: f64) {
    let slot = m.declaration().by_name(name).unwrap().slot;
    assert!(m.set(slot, value));
    m.set_slope(slot, slope);
}

/// 5 A imposed at this speed, rad/s.
fn running(speed: f64) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    (m.inputs.current_command, m.inputs.imposed_speed) = (5.0, speed);
    m
}

/// 10 W of heat.
pub fn heating() -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.inputs.electrical_power = 10.0;
    m
}

/// 10 W of heat for a long time.
fn heated(prepare: impl Fn(&mut AnnulusCooledMotor)) -> AnnulusCooledMotor {
    let mut m = heating();
    prepare(&mut m);
    m.start(0.0).unwrap();
    for _ in 0..100 {
        m.step(m.time(), 1000.0).unwrap();
    }
    m
}

pub fn close(got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance, "{got} instead of {wanted}");
}

/// 2e-4 sqrt(900) = 6 mN.m of iron and 1e-9 900^2 = 0.81 mN.m of air: 5.4 W and 0.729 W.
#[test]
fn iron_and_air_brake_and_heat() {
    let mut m = running(900.0);
    m.parameters.effects.iron_loss.k = 2e-4;
    m.parameters.effects.windage.k = 1e-9;
    m.start(0.0).unwrap();
    close(output(&mut m, "loss_iron"), 5.4, 5e-6);
    close(output(&mut m, "loss_friction"), 6.129, 5e-6);
    close(output(&mut m, "shaft_torque"), 5.0 * 0.0276 - 6.81e-3, 1e-8);
}

/// mu = 0.06: a driving motor keeps 1/1.06 of its torque for the load, a braking one takes 1/0.94.
#[test]
fn friction_of_the_load_drives_and_brakes() {
    for (speed, share) in [(500.0, 1.0 / 1.06), (-500.0, 1.0 / 0.94)] {
        let mut m = running(speed);
        m.parameters.effects.load_dependent_friction.mu = 0.06;
        m.start(0.0).unwrap();
        let torque = 5.0 * 0.0276 * share;
        close(output(&mut m, "shaft_torque"), torque, 1e-15);
        close(output(&mut m, "loss_friction"), 0.06 * torque * 500.0, 1e-12);
    }
    // On a free shaft the load is the torque handed over: 6 % of it brakes.
    let mut m = motor(DriveMode::Current, MechanicalMode::FreeShaft);
    (m.inputs.current_command, m.inputs.load_torque) = (5.0, 0.1);
    m.parameters.effects.load_dependent_friction.mu = 0.06;
    m.start(0.0).unwrap();
    m.step(0.0, 0.1).unwrap();
    let (k_t, w) = (output(&mut m, "torque_constant"), output(&mut m, "shaft_speed"));
    close(w, (5.0 * k_t - 0.106) / 33.3e-7 * 0.1, 1e-3 * w);
    close(output(&mut m, "loss_friction"), 0.006 * w, 1e-12 * w);
}

/// The drop adds to the terminals' voltage, whichever way the current runs, and heats the winding.
#[test]
fn the_contacts_take_volts() {
    for amperes in [5.0, -5.0] {
        let mut m = running(0.0);
        m.inputs.current_command = amperes;
        m.parameters.effects.contact_drop.V_b = 0.8;
        m.start(0.0).unwrap();
        close(output(&mut m, "terminal_voltage"), (5.0 * 0.386 + 0.8) * amperes.signum(), 1e-14);
        close(output(&mut m, "loss_copper"), 25.0 * 0.386 + 4.0, 1e-13);
    }
    // A voltage below the drop drives little: the passage's slope, 0.8 V / 0.05 A, stands in its way.
    let mut m = motor(DriveMode::Voltage, MechanicalMode::ImposedSpeed);
    m.parameters.effects.contact_drop.V_b = 0.8;
    m.inputs.voltage = 0.2;
    m.start(0.0).unwrap();
    m.step(0.0, 1.0).unwrap();
    let i = output(&mut m, "current");
    close(0.386 * i + 0.8 * (i / 0.05f64).tanh(), 0.2, 1e-6);
}

/// In balance at 10 W: G (T_h - T_a) + k (T_h^4 - T_a^4) = 10 W.
#[test]
fn radiation_cools() {
    let mut m = heated(|m| m.parameters.effects.housing_radiation.k = 6e-10);
    let t_h = output(&mut m, "housing_temperature");
    close(0.1351 * (t_h - 298.15) + 6e-10 * (t_h.powi(4) - 298.15f64.powi(4)), 10.0, 1e-7);
    close(output(&mut m, "heat_to_ambient"), 10.0, 1e-7);
    assert!(t_h < 298.15 + 10.0 / 0.1351 - 10.0);
}

/// In balance at 10 W: T_w - T_h = 10 W R_wh [1 + beta (T_w - 298.15)].
#[test]
fn the_interface_insulates() {
    let mut m = heated(|m| m.parameters.effects.interface_temperature.beta = 0.004);
    let (t_w, t_h) = (output(&mut m, "winding_temperature"), output(&mut m, "housing_temperature"));
    close(t_w - t_h, 2.1 * (1.0 + 0.004 * (t_w - 298.15)), 1e-6);
}

/// In balance at 10 W with half the fan that has lost 15 % of its flow, and air on the winding as well.
#[test]
fn air_on_the_winding_and_a_tired_fan() {
    let mut m = heated(|m| {
        m.inputs.fan_command = 0.5;
        let effects = &mut m.parameters.effects;
        effects.fan_back_pressure.k = 0.3;
        effects.forced_convection.G = 0.1;
        effects.forced_convection.node = CooledNode::Winding;
        effects.forced_convection.driver = ConvectionDriver::FanCommand;
    });
    let flow = 0.425f64.powf(0.8);
    let rise = |m: &mut AnnulusCooledMotor, node: &str| output(m, node) - 298.15;
    let (w, h) = (rise(&mut m, "winding_temperature"), rise(&mut m, "housing_temperature"));
    close(0.1 * flow * w + (w - h) / 0.21, 10.0, 1e-7);
    close((w - h) / 0.21, (0.1351 + 0.113 * flow) * h, 1e-7);
    close(output(&mut m, "heat_to_ambient"), 10.0, 1e-7);
}

/// 12 % of 10 W stay in the drive; the winding gets 8.8 W, the surroundings 10 W in the end.
#[test]
fn the_drive_keeps_its_share() {
    let mut m = heated(|m| m.parameters.effects.drive_loss.share = 0.12);
    close(output(&mut m, "loss_drive"), 1.2, 1e-15);
    close(output(&mut m, "loss_copper"), 8.8, 1e-14);
    close(output(&mut m, "power_electrical"), 10.0, 0.0);
    close(output(&mut m, "heat_to_ambient"), 10.0, 1e-7);
    close(output(&mut m, "housing_temperature"), 298.15 + 8.8 / 0.1351, 1e-6);
}

/// The sensor shows 25 degC for good; the room gains 1 mK each second, and an idle motor lags G and C behind.
#[test]
fn the_room_runs_away_from_what_is_shown() {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.effects.ambient_drift.rate = 1e-3;
    m.start(100.0).unwrap();
    close(m.state().temperature[1], 298.25, 1e-12);
    for _ in 0..40 {
        m.step(m.time(), 1000.0).unwrap();
    }
    // The whole capacity, 159.45 J/K, warms by 1 mK/s: 0.15945 W come in, 1.18 K below the room.
    close(output(&mut m, "heat_to_ambient"), -0.159_45, 1e-9);
    close(output(&mut m, "housing_temperature"), 298.15 + 40.1 - 0.159_45 / 0.1351, 1e-6);
}

/// Step of the runs with an event, s: times and volts on the way are exact in binary.
const H: f64 = 1.0 / 1024.0;

/// A tenth of the torque constant is lost in the middle of the fifth step.
fn weakening() -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.demagnetisation.fraction = 0.1;
    m.parameters.effects.demagnetisation.time = 4.5 * H;
    m.start(0.0).unwrap();
    m
}

/// Steps to `at` plus `h` with the volts on a ramp.
fn ramp(m: &mut AnnulusCooledMotor, h: f64) {
    let at = m.time();
    set(m, "voltage", 8.0 + 256.0 * at, 256.0);
    m.step(at, h).unwrap();
}

#[test]
fn a_step_is_cut_where_the_magnets_weaken() {
    let (mut whole, mut cut) = (weakening(), weakening());
    for _ in 0..4 {
        ramp(&mut whole, H);
        ramp(&mut cut, H);
    }
    let before = output(&mut whole, "torque_constant");
    ramp(&mut whole, H);
    let end = cut.time() + H;
    ramp(&mut cut, 0.5 * H);
    ramp(&mut cut, 0.5 * H);
    assert_eq!((whole.time(), cut.time()), (end, end));
    assert_eq!(whole.state(), cut.state());
    close(output(&mut whole, "torque_constant") / before, 0.9, 1e-5);
}

/// Taken back to before the event, the motor goes the same way again, to the bit.
#[test]
fn a_rollback_over_the_event_is_exact() {
    let mut m = weakening();
    (0..3).for_each(|_| ramp(&mut m, H));
    let mut saved = Vec::new();
    m.save(&mut saved);
    let mut bits = || {
        (0..4).for_each(|_| ramp(&mut m, H));
        let bits: Vec<u64> = m.state().to_numbers().chain([m.time()]).map(f64::to_bits).collect();
        assert!(m.restore(&saved));
        bits
    };
    assert_eq!(bits(), bits());
}

/// The matrices that the integrator freezes, with every effect on, against differences of the rates.
#[test]
fn the_matrices_are_the_derivatives() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects = Effects::examples();
    (m.inputs.load_torque, m.inputs.fan_command) = (0.05, 0.5);
    m.start(0.0).unwrap();
    let step = m.step_equations();
    let (x, temperature) = (Fast::new(0.03, 0.6), Temperatures::new(390.0, 340.0));
    for k in 0..2 {
        let mut by = Fast::zeros();
        by[k] = 1e-5;
        let fast =
            step.fast_rates(0.0, &(x + by), &temperature) - step.fast_rates(0.0, &(x - by), &temperature);
        let wanted = step.fast_matrix(0.0, &x, &temperature).column(k) * 2e-5;
        assert!((fast - wanted).norm() <= 1e-6 * wanted.norm(), "{fast} {wanted}");
        let by = by * 1e3;
        let heat =
            step.network_rates(0.0, &(temperature + by)) - step.network_rates(0.0, &(temperature - by));
        let wanted = step.network_matrix(0.0, &temperature).column(k) * 2e-2;
        assert!((heat - wanted).norm() <= 1e-6 * wanted.norm(), "{heat} {wanted}");
    }
}

/// `Effects::examples` has every effect on: a parameter that switches an effect is 0 where the effect is off.
#[test]
fn all_effects_are_on() {
    let mut m = motor(DriveMode::Pwm, MechanicalMode::FreeShaft);
    m.parameters.effects = Effects::examples();
    let switches = m.declaration().entries.iter();
    let switches = switches.filter(|e| e.name.starts_with("effect.") && e.row.start == 0.0);
    let off: Vec<&str> = switches.filter(|e| m.get(e.slot) == 0.0).map(|e| e.name.as_str()).collect();
    assert_eq!(off, Vec::<&str>::new());
}

/// The contract's list: every effect has its parameters, in the declaration of the motor, and is neutral at their
/// start values.
#[test]
fn every_effect_of_the_contract_is_declared_and_neutral() {
    const CONTRACT: &[(&str, &[&str])] = &[
        ("coulomb_friction", &["tau_c", "w_small"]),
        ("iron_loss", &["k"]),
        ("viscous_friction", &["k"]),
        ("windage", &["k"]),
        ("load_dependent_friction", &["mu"]),
        ("contact_drop", &["V_b", "I_small"]),
        ("housing_radiation", &["k"]),
        ("forced_convection", &["G", "node"]),
        ("fan_back_pressure", &["k"]),
        ("interface_temperature", &["beta"]),
        ("stator_node", &["C_s", "R_sh"]),
        ("demagnetisation", &["fraction", "time"]),
        ("ambient_drift", &["rate"]),
        ("housing_sensor_lag", &["tau"]),
        ("winding_sensor_lag", &["tau"]),
        ("winding_sensor_offset", &["offset"]),
        ("housing_sensor_offset", &["offset"]),
        ("winding_sensor_stem_loss", &["k"]),
        ("housing_sensor_stem_loss", &["k"]),
        ("drive_loss", &["share"]),
    ];
    let m = AnnulusCooledMotor::default();
    for (id, symbols) in CONTRACT {
        for (k, symbol) in symbols.iter().enumerate() {
            let name = format!("effect.{id}.{symbol}");
            let entry = m.declaration().by_name(&name).unwrap_or_else(|| panic!("no {name}"));
            // The first symbol is the switch.
            assert!(k > 0 || entry.row.start == 0.0, "{name} starts at {}", entry.row.start);
        }
    }
    let effects = Effects::default();
    assert!(!effects.is_on());
    assert_eq!(effects.drag_torque(300.0f64), 0.0);
    assert_eq!(effects.load_drag(300.0f64, 0.1), 0.0);
    assert_eq!(effects.terminal_voltage(5.0f64), 0.0);
    assert_eq!((effects.torque_constant(1e3), effects.next_event(0.0)), (1.0, f64::INFINITY));
    assert_eq!(effects.winding_housing_resistance(400.0f64), 1.0);
    assert_eq!(effects.ambient_conductance(1.0), PerNode::default());
    assert_eq!(effects.housing_to_ambient(400.0f64, 300.0), 0.0);
    assert_eq!((effects.fan_flow(0.7), effects.ambient_sensor(), effects.drive_loss()), (0.7, 0.0, 0.0));
    assert_eq!((effects.winding_sensor(400.0, 300.0), effects.housing_sensor(400.0, 300.0)), (400.0, 400.0));
    assert_eq!((effects.sensor_lag(), effects.iron_drag(300.0)), (PerNode::default(), 0.0));
}

/// A term: a coefficient times |(driver - offset) / reference|^exponent.
fn term(
    port: Port,
    coefficient: f64,
    driver: Driver,
    offset: f64,
    reference: f64,
    exponent: f64,
) -> GenericTerm {
    let factor = Factor { driver, offset, reference, exponent, range: Factor::UNLIMITED };
    GenericTerm::new(port, Law::Product(Product { coefficient, factors: [Some(factor), None, None] }))
}

/// What a term does at each port, by hand: 5 A at 500 rad/s with R = 0.386 Ohm and k_t = 27.6 mN.m/A at 25 degC.
#[test]
fn terms_act_at_their_ports() {
    let with = |term: GenericTerm| {
        let mut m = running(500.0);
        assert!(m.set_terms(&[term]));
        m.start(0.0).unwrap();
        m
    };
    // 4 mN.m at 500 rad/s, as the fourth root of the speed.
    let mut m = with(term(Port::DragTorque, 4e-3, Driver::Speed, 0.0, 500.0, 0.25));
    close(output(&mut m, "loss_friction"), 2.0, 1e-12);
    close(output(&mut m, "shaft_torque"), 5.0 * 0.0276 - 4e-3, 1e-15);
    let mut m = with(term(Port::TerminalVoltage, 0.2, Driver::Current, 0.0, 2.5, 2.0));
    close(output(&mut m, "terminal_voltage"), 5.0 * 0.386 + 0.8 + 500.0 * 0.0276, 1e-12);
    // Against 5 A a loss of 1 W; against -5 A the same voltage supplies 1 W.
    let mut m = with(term(Port::SeriesVoltage, 0.2, Driver::Speed, 0.0, 500.0, 1.0));
    close(output(&mut m, "terminal_voltage"), 5.0 * 0.386 + 0.2 + 500.0 * 0.0276, 1e-12);
    close(output(&mut m, "loss_copper"), 25.0 * 0.386 + 1.0, 1e-11);
    m.inputs.current_command = -5.0;
    m.start(0.0).unwrap();
    close(output(&mut m, "terminal_voltage"), -5.0 * 0.386 + 0.2 + 500.0 * 0.0276, 1e-12);
    close(output(&mut m, "loss_copper"), 25.0 * 0.386 - 1.0, 1e-11);
    let mut m = with(term(Port::WindingResistance, 0.25, Driver::Speed, 0.0, 250.0, 2.0));
    close(output(&mut m, "winding_resistance"), 2.0 * 0.386, 1e-12);
    close(output(&mut m, "loss_copper"), 25.0 * 2.0 * 0.386, 1e-11);
    let mut m = with(term(Port::TorqueConstant, -0.1, Driver::Current, 0.0, 5.0, 1.0));
    close(output(&mut m, "torque_constant"), 0.9 * 0.0276, 1e-15);
    let mut m = with(term(Port::AmbientSensor, 2.0, Driver::Speed, 0.0, 500.0, 1.0));
    close(output(&mut m, "stator_temperature"), 300.15, 1e-12);
    let mut m = with(term(Port::WindingSensor, 1.5, Driver::LoadTorque, 0.0, 0.138, 1.0));
    close(output(&mut m, "winding_temperature"), 299.65, 1e-12);
    close(output(&mut m, "stator_temperature"), 298.15, 1e-12);
    let mut m = with(term(Port::HousingSensor, -1.5, Driver::WindingTemperature, 290.15, 8.0, 1.0));
    close(output(&mut m, "housing_temperature"), 296.65, 1e-12);
}

/// In balance at 10 W: what leaves is what comes in, and each term is where it says.
#[test]
fn terms_act_on_the_heat() {
    let with = |terms: &[GenericTerm]| {
        heated(|m| {
            m.inputs.fan_command = 0.5;
            assert!(m.set_terms(terms));
        })
    };
    let g = 0.1351 + 0.113 * 0.5f64.powf(0.8);
    let rise = |m: &mut AnnulusCooledMotor, node: &str| output(m, node) - 298.15;
    let mut m = with(&[term(Port::WindingHeat, 2.0, Driver::FanCommand, 0.0, 0.5, 1.0)]);
    close(rise(&mut m, "housing_temperature"), 12.0 / g, 1e-6);
    close(rise(&mut m, "winding_temperature"), 12.0 / g + 12.0 * 0.21, 1e-6);
    let mut m = with(&[term(Port::HousingHeat, 2.0, Driver::FanCommand, 0.0, 0.5, 1.0)]);
    close(rise(&mut m, "housing_temperature"), 12.0 / g, 1e-6);
    close(rise(&mut m, "winding_temperature"), 12.0 / g + 2.1, 1e-6);
    close(output(&mut m, "heat_to_ambient"), 10.0, 1e-7);
    let mut m =
        with(&[term(Port::HousingAmbientConductance, 0.1, Driver::HousingTemperature, 298.15, 10.0, 0.25)]);
    let h = rise(&mut m, "housing_temperature");
    close((g + 0.1 * (h / 10.0).powf(0.25)) * h, 10.0, 1e-6);
    let mut m =
        with(&[term(Port::WindingHousingResistance, 0.1, Driver::WindingTemperature, 298.15, 10.0, 1.0)]);
    let (w, h) = (rise(&mut m, "winding_temperature"), rise(&mut m, "housing_temperature"));
    close(w - h, 2.1 * (1.0 + 0.1 * w / 10.0), 1e-6);
    let mut m = with(&[term(Port::FanFlow, -0.5, Driver::FanCommand, 0.0, 1.0, 1.0)]);
    close(rise(&mut m, "housing_temperature") * (0.1351 + 0.113 * 0.375f64.powf(0.8)), 10.0, 1e-6);
    // Off by their gain.
    let mut m = with(&[term(Port::WindingHeat, 2.0, Driver::FanCommand, 0.0, 0.5, 1.0)]);
    let gain = m.declaration().by_name("effect.generic_term.gain").unwrap().slot;
    assert!(m.set(gain, 0.0));
    (0..100).for_each(|_| m.step(m.time(), 1000.0).unwrap());
    close(rise(&mut m, "housing_temperature"), 10.0 / g, 1e-6);
}

/// Twice the capacity warms half as fast; as the gain goes up and down the energy balance close, and rollback is exact.
#[test]
fn a_capacity_may_change_on_the_way() {
    let mut m = heating();
    assert!(m.set_terms(&[term(Port::HeatCapacity, 1.0, Driver::FanCommand, 0.0, 1.0, 0.0)]));
    let mut plain = heating();
    plain.parameters.thermal.C_w *= 2.0;
    plain.parameters.thermal.C_h *= 2.0;
    for m in [&mut m, &mut plain] {
        m.start(0.0).unwrap();
        (0..100).for_each(|_| m.step(m.time(), 1.0).unwrap());
    }
    close(m.state().temperature[0], plain.state().temperature[0], 1e-12);
    let gain = m.declaration().by_name("effect.generic_term.gain").unwrap().slot;
    for value in [0.5, 0.0, 1.0] {
        assert!(m.set(gain, value));
        m.step(m.time(), 1.0).unwrap();
        close(output(&mut m, "energy_balance_error"), 0.0, 1e-6);
        let mut saved = Vec::new();
        m.save(&mut saved);
        m.step(m.time(), 1.0).unwrap();
        let there = m.state().temperature;
        assert!(m.restore(&saved));
        m.step(m.time(), 1.0).unwrap();
        assert_eq!(m.state().temperature, there);
    }
}

/// With a network beyond the two nodes, too: terms act, the energy balance close, and the sensor follows the housing.
#[test]
fn terms_and_sensors_in_a_network() {
    let make = |port: Port| {
        let mut m = heating();
        m.parameters.choices.cooling_mode = CoolingMode::Bare;
        m.parameters.effects.housing_sensor_lag.tau = 30.0;
        assert!(m.set_terms(&[term(port, 0.2, Driver::WindingTemperature, 290.0, 10.0, 1.0)]));
        m
    };
    for port in Port::ALL.iter().copied() {
        let mut m = make(port);
        m.start(0.0).unwrap();
        (0..100).for_each(|_| m.step(m.time(), 1.0).unwrap());
        let error = output(&mut m, "energy_balance_error");
        assert!(error.abs() < 1e-6 * output(&mut m, "energy_electrical"), "{port:?}: {error} J");
        close(output(&mut m, "power_balance_error"), 0.0, 1e-6);
    }
    // The lag is tau times the slope, 30 s or more behind nearly a line.
    let mut m = make(Port::TorqueConstant);
    m.start(0.0).unwrap();
    (0..300).for_each(|_| m.step(m.time(), 1.0).unwrap());
    let shown = output(&mut m, "housing_temperature");
    m.parameters.effects.housing_sensor_lag.tau = 0.0;
    m.step(m.time(), 1.0).unwrap();
    let now = output(&mut m, "housing_temperature");
    m.step(m.time(), 1.0).unwrap();
    let slope = output(&mut m, "housing_temperature") - now;
    assert!(slope > 1e-3);
    close((now - shown) / slope, 31.0, 2.0);
}
