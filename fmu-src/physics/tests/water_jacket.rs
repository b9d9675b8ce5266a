//! The motor in a water jacket: effectiveness, balance, continuity over the flow, and a pump that stops.

use crate::common::motor;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode};

const INLET: f64 = 288.15;

fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

/// 60 W in the winding at standstill, with a volume flow of water, m3/s.
fn heated(flow: f64) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = CoolingMode::WaterJacket;
    m.inputs.electrical_power = 60.0;
    (m.inputs.coolant_inlet_temperature, m.inputs.coolant_flow_rate) = (INLET, flow);
    m
}

fn settled(flow: f64, segments: i32) -> AnnulusCooledMotor {
    let mut m = heated(flow);
    m.parameters.choices.air_segments = segments;
    m.start(0.0).unwrap();
    for k in 0..60 {
        m.step(f64::from(k) * 100.0, 100.0).unwrap();
    }
    m
}

/// One segment is a wall of one temperature: the outlet is that of the effectiveness 1 - exp(-NTU), the heat that of the stream.
#[test]
fn the_outlet_follows_the_effectiveness() {
    for flow in [1e-6, 1e-5, 5e-5, 2e-4] {
        let mut m = settled(flow, 1);
        let housing = get(&mut m, "housing_temperature");
        let water = m.parameters.cooling.jacket.coolant(flow, INLET, housing);
        let effectiveness = 1.0 - (-water.conductance / water.m_flow_cp).exp();
        let outlet = INLET + effectiveness * (housing - INLET);
        assert!((get(&mut m, "coolant_outlet_temperature") - outlet).abs() < 1e-3, "{flow}");
        let heat = get(&mut m, "heat_to_coolant");
        assert!((heat - water.m_flow_cp * (outlet - INLET)).abs() < 1e-3 * heat, "{flow}");
        assert!(heat > 50.0 && heat <= get(&mut m, "heat_to_ambient") + 1.0, "{flow}: {heat} W");
        assert!((get(&mut m, "heat_to_ambient") - 60.0).abs() < 1e-3);
        let pump = get(&mut m, "coolant_pressure_drop") * flow;
        assert!((get(&mut m, "pump_power") - pump).abs() <= 1e-9 * pump && pump > 0.0);
        assert_eq!(get(&mut m, "air_outlet_temperature"), m.inputs.ambient_temperature);
    }
}

/// The flow ramps up and down, the inlet warms and the pump stops: the balance residuals are those of rounding.
#[test]
fn the_balance_closes_while_the_flow_changes() {
    let mut m = heated(0.0);
    m.start(0.0).unwrap();
    let slots =
        ["coolant_flow_rate", "coolant_inlet_temperature"].map(|n| m.declaration().by_name(n).unwrap().slot);
    let h = 0.02;
    for k in 0..3000 {
        let t = f64::from(k) * h;
        let wave = (0.3 * t).sin();
        let (flow, rate) = if wave > 0.0 { (5e-5 * wave, 1.5e-5 * (0.3 * t).cos()) } else { (0.0, 0.0) };
        m.set(slots[0], flow);
        m.set_slope(slots[0], rate.max(-flow / h));
        m.set(slots[1], 290.0 + 0.1 * t);
        m.set_slope(slots[1], 0.1);
        m.step(t, h).unwrap();
        assert!(get(&mut m, "power_balance_error").abs() < 1e-6, "{t} s");
        assert!(get(&mut m, "energy_balance_error").abs() < 1e-6, "{t} s");
    }
}

/// More flow cools more, and nothing jumps: not at rest, not where the flow becomes turbulent.
#[test]
fn the_winding_is_continuous_over_the_flow() {
    let winding = |flow: f64| get(&mut settled(flow, 4), "winding_temperature");
    let flows: Vec<f64> = (0..40).map(|k| 1e-6 * 1.2f64.powi(k)).collect();
    let all: Vec<f64> = flows.iter().map(|&q| winding(q)).collect();
    for (pair, q) in all.windows(2).zip(&flows) {
        assert!(pair[1] < pair[0], "at {q} m3/s: {} K after {} K", pair[1], pair[0]);
        assert!(pair[0] - pair[1] < 0.2 * (pair[0] - INLET), "a jump at {q} m3/s");
    }
    // The flow of 8 channels of 3 mm at Re = 2300 and 4000 is near 50 and 90 mL/s; each step of 1e-4 changes millikelvins.
    for k in 0..40 {
        let q = 4e-5 + 1.5e-6 * f64::from(k);
        assert!((winding(q) - winding(1.0001 * q)).abs() < 5e-3, "{q} m3/s");
    }
}

/// Without flow the water takes no heat, has the housing's temperature at the outlet, and all heat leaves by ends and leads.
#[test]
fn a_pump_that_stops() {
    let mut m = heated(0.0);
    m.inputs.electrical_power = 1.0;
    m.start(0.0).unwrap();
    for k in 0..100 {
        m.step(f64::from(k) * 300.0, 300.0).unwrap();
    }
    assert_eq!(["heat_to_coolant", "pump_power", "coolant_pressure_drop"].map(|n| get(&mut m, n)), [0.0; 3]);
    let [outlet, housing] = ["coolant_outlet_temperature", "housing_temperature"].map(|n| get(&mut m, n));
    assert!((outlet - housing).abs() < 1.0 && outlet.is_finite(), "{outlet} {housing}");
    // A trickle of a thousandth of a millilitre per second makes no difference.
    let mut trickle = heated(1e-12);
    trickle.inputs.electrical_power = 1.0;
    trickle.start(0.0).unwrap();
    for k in 0..100 {
        trickle.step(f64::from(k) * 300.0, 300.0).unwrap();
    }
    let off = get(&mut trickle, "winding_temperature") - get(&mut m, "winding_temperature");
    assert!(off.abs() < 1e-2, "{off} K");
}

/// A measured flow that stops is a little negative at times, and a line between two rows passes zero: as no flow.
#[test]
fn a_flow_that_is_negative_by_noise_is_none() {
    let [mut noisy, mut still] = [heated(0.0), heated(0.0)];
    for m in [&mut noisy, &mut still] {
        m.inputs.electrical_power = 20.0;
        m.start(0.0).unwrap();
    }
    let slot = noisy.declaration().by_name("coolant_flow_rate").unwrap().slot;
    for k in 0..400 {
        // From -2e-6 to 2e-6 m3/s and back: the mean of what is above zero is 0.5e-6.
        let (from, slope) = if k % 2 == 0 { (-2e-6, 2e-6) } else { (2e-6, -2e-6) };
        noisy.inputs.coolant_flow_rate = from;
        noisy.set_slope(slot, slope);
        noisy.step(2.0 * f64::from(k), 2.0).unwrap();
        still.step(2.0 * f64::from(k), 2.0).unwrap();
    }
    let [with, without] = [&mut noisy, &mut still].map(|m| get(m, "housing_temperature"));
    assert!(with < without - 1.0 && with > INLET, "{with} K with a flow in turns, {without} K without");
}
