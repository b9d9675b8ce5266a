//! The gear of the gearmotor as a node with a temperature of its own, and friction that depends on it.

use physics::model::Model;
use physics::models::brushed_gearmotor::BrushedGearmotor;

fn get(m: &mut BrushedGearmotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

fn run(m: &mut BrushedGearmotor, steps: usize, h: f64) {
    for _ in 0..steps {
        m.step(m.time(), h).unwrap();
    }
}

#[track_caller]
fn near(found: f64, by_hand: f64, relative: f64) {
    assert!((found - by_hand).abs() <= relative * by_hand.abs(), "{found}, by hand {by_hand}");
}

/// By hand: a gear of 20 J/K with R_gh = 3 K/W that 0.75 of the friction P heats. It warms by 0.75 P - (T_g - T_h)/R_gh over C_g, in
/// the end T_g - T_h = 0.75 P R_gh. Viscous friction falls by v = exp[B (1/T_g - 1/T_ref)], and K I = tau_c + k v w.
#[test]
fn a_gear_with_a_temperature_of_its_own() {
    let mut m = BrushedGearmotor::default();
    let p = &mut m.parameters;
    (p.thermal.C_g, p.thermal.R_gh, p.thermal.friction_to_gear, p.gear.B) = (20.0, 3.0, 0.75, 4000.0);
    m.inputs.duty = 1.0;
    m.start(0.0).unwrap();
    run(&mut m, 1000, 1e-3);
    let look = |m: &mut BrushedGearmotor| {
        ["gear_temperature", "housing_temperature", "loss_friction"].map(|n| get(m, n))
    };
    let [t_g, t_h, loss] = look(&mut m);
    run(&mut m, 1, 0.1);
    let [after, housing, loss_after] = look(&mut m);
    let to_housing = 0.5 * (t_g - t_h + after - housing) / 3.0;
    near((after - t_g) / 0.1, (0.75 * 0.5 * (loss + loss_after) - to_housing) / 20.0, 1e-3);
    run(&mut m, 600, 60.0);
    let (t_g, t_h) = (get(&mut m, "gear_temperature"), get(&mut m, "housing_temperature"));
    let (w, loss) = (get(&mut m, "shaft_speed"), get(&mut m, "loss_friction"));
    near(t_g - t_h, 0.75 * loss * 3.0, 1e-6);
    let viscosity = (4000.0 * (1.0 / t_g - 1.0 / 293.15)).exp();
    assert!(viscosity < 0.6, "{viscosity}");
    let drag = 0.0769 + 0.01267 * viscosity * w;
    near(get(&mut m, "torque_constant") * get(&mut m, "current"), drag, 1e-6);
    near(loss, drag * w, 1e-6);
    // All power but that of the bridge passes housing and box.
    let power = get(&mut m, "power_total");
    near(t_h - 293.15, 2.0 * power / 0.15, 1e-4);
    assert!(get(&mut m, "energy_balance_error").abs() < 1e-6 * get(&mut m, "energy_supply"));
}

/// Without thermal.C_g the gear has the housing's temperature, and its node stands still.
#[test]
fn a_gear_in_the_housing() {
    let mut m = BrushedGearmotor::default();
    (m.parameters.gear.B, m.parameters.initial.gear_temperature) = (4000.0, 350.0);
    m.inputs.duty = 1.0;
    m.start(0.0).unwrap();
    run(&mut m, 100, 10.0);
    assert_eq!(get(&mut m, "gear_temperature"), get(&mut m, "housing_temperature"));
    assert!(get(&mut m, "gear_temperature") > 300.0);
    assert_eq!(
        (get(&mut m, "state.gear_temperature"), get(&mut m, "der(state.gear_temperature)")),
        (350.0, 0.0)
    );
    assert!(get(&mut m, "energy_balance_error").abs() < 1e-6 * get(&mut m, "energy_supply"));
}
