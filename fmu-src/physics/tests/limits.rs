//! Cases with a known answer: closed forms, the matrix exponential, and the order of the split.

use crate::common::{busy_inputs, cooling_modes, friction, motor};
use nalgebra::{Matrix2, Vector2};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::solver::split::Split;

/// A locked rotor with a winding that does not answer to its temperature is an R-L circuit:
/// I = V/R (1 - e^(-t R/L)).
#[test]
fn a_locked_rotor_is_an_rl_circuit() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::ImposedSpeed);
    m.parameters.motor.alpha = 0.0;
    m.inputs.voltage = 2.0;
    m.start(0.0).unwrap();
    let (r, l) = (m.parameters.motor.R_ref, m.parameters.motor.L);
    for k in 1..=20 {
        m.step(m.time(), 1e-4).unwrap();
        let exact = 2.0 / r * (1.0 - (-k as f64 * 1e-4 * r / l).exp());
        assert!((m.state().x[0] - exact).abs() < 1e-11, "step {k}: {} {exact}", m.state().x[0]);
    }
}

/// With a constant heat flow the two nodes are linear: T = T_a + M^-1 (e^(Mt) - 1) q, M^-1 by hand, e^(Mt) by
/// nalgebra's Pade approximation.
#[test]
fn two_nodes_follow_the_matrix_exponential() {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.inputs.electrical_power = 10.0;
    m.inputs.fan_command = 0.3;
    m.start(0.0).unwrap();
    let p = m.parameters;
    let (r, c_w, c_h) = (p.thermal.R_wh, p.thermal.C_w, p.thermal.C_h);
    let g = p.conductance.G_still + p.conductance.G_forced * 0.3f64.powf(0.8);
    let a = Matrix2::new(-1.0 / (r * c_w), 1.0 / (r * c_w), 1.0 / (r * c_h), -(1.0 / r + g) / c_h);
    let q = Vector2::new(10.0 / c_w, 0.0);
    let mut t = 0.0;
    for h in [1e-3, 0.5, 2.0, 30.0, 600.0, 3600.0] {
        m.step(m.time(), h).unwrap();
        t += h;
        let exact = a.try_inverse().unwrap() * ((a * t).exp() - Matrix2::identity()) * q;
        let rise = m.state().temperature.add_scalar(-298.15);
        assert!((rise - exact).norm() <= 1e-9 * exact.norm().max(1e-3), "{t} s: {rise} {exact}");
    }
}

/// At the end of a long run at 10 W: T_h - T_a = P/G and T_w - T_h = P R_wh.
#[test]
fn the_steady_state_is_ohms_law_of_heat() {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.inputs.electrical_power = 10.0;
    m.start(0.0).unwrap();
    for _ in 0..100 {
        m.step(m.time(), 1000.0).unwrap();
    }
    let t = m.state().temperature;
    assert!((t[1] - 298.15 - 10.0 / 0.1351).abs() < 1e-6, "{t}");
    assert!((t[0] - t[1] - 2.1).abs() < 1e-6, "{t}");
}

/// No load, no friction: the speed at which the back-EMF meets the supply, without current.
#[test]
fn an_unloaded_motor_runs_until_the_back_emf_meets_the_supply() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.inputs.voltage = 48.0;
    m.start(0.0).unwrap();
    for _ in 0..1000 {
        m.step(m.time(), 1e-3).unwrap();
    }
    let k_t = m.parameters.motor.torque_constant(m.state().temperature[1]);
    assert!((m.state().x[1] - 48.0 / k_t).abs() < 1e-3, "{}", m.state().x[1]);
    assert!(m.state().x[0].abs() < 1e-3);
}

/// The datasheet's no-load point: 0.356 A and 16 500 rpm at 48 V with the loss as dry friction. The cold
/// resistance and k_t give 16 558 rpm; the catalogue rounds.
#[test]
fn the_no_load_point_of_the_datasheet() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.coulomb_friction = friction(0.0276 * 0.356);
    m.inputs.voltage = 48.0;
    m.start(0.0).unwrap();
    for _ in 0..200 {
        m.step(m.time(), 1e-3).unwrap();
    }
    assert!((m.state().x[0] - 0.356).abs() < 1e-3, "{} A", m.state().x[0]);
    let rpm = m.state().x[1] * 30.0 / std::f64::consts::PI;
    assert!((rpm / 16500.0 - 1.0).abs() < 0.006, "{rpm} rpm");
}

/// Current and speed, and the energy balance residual, J, of a motor that starts with steps of `h`, s, without error control.
fn started(h: f64) -> (Vector2<f64>, f64) {
    // Smooth and nonlinear: through the passage of a wide friction curve. Without answer to temperature, since
    // the rounds between the blocks end at a tolerance and not at an order.
    let mut m = AnnulusCooledMotor::default();
    m.parameters.effects.coulomb_friction = friction(0.02);
    m.parameters.effects.coulomb_friction.w_small = 100.0;
    (m.parameters.motor.alpha, m.parameters.motor.alpha_mag) = (0.0, 0.0);
    // Small capacities, so that the rounding of temperatures is no energy.
    (m.parameters.thermal.C_w, m.parameters.thermal.C_h) = (0.1, 0.1);
    m.inputs.voltage = 12.0;
    m.start(0.0).unwrap();
    let mut state = *m.state();
    let step = m.step_equations();
    let stored = step.stored(&state, 298.15);
    for _ in 0..(4e-3 / h).round() as usize {
        // A new integrator for each step has its Jacobians at the step's own start.
        state = Split::default().single_step(&step, &state, h);
    }
    let [electrical, mechanical, to_ambient] = state.energy;
    (state.x, electrical - mechanical - to_ambient - (step.stored(&state, 298.15) - stored))
}

/// Error of current and speed after steps of `h`, s, against those of `h`/8.
fn error_of(h: f64) -> f64 {
    (started(h).0 - started(h / 8.0).0).norm()
}

/// ETD3RK is of third order with any frozen matrix; with the Jacobian of the step's start it gains one. Halving the
/// step divides the error by 2^4, within 2^0.3, once the step resolves the electrical time constant.
#[test]
fn the_order_of_the_split() {
    let errors: Vec<f64> = [1e-4, 5e-5, 2.5e-5].iter().map(|h| error_of(*h)).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 4.0).abs() < 0.3, "order {order}, errors {errors:?}");
    }
}

/// The energy balance residual is the error of the steps: it vanishes with the fourth order of the step, and not by construction. At
/// these steps it comes down to its asymptote from above.
#[test]
fn the_order_of_the_energy_balance() {
    let residuals: Vec<f64> = [1e-4, 5e-5, 2.5e-5].iter().map(|h| started(*h).1.abs()).collect();
    for pair in residuals.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 3.7 && order < 5.0, "order {order}, residuals {residuals:?}");
    }
}

/// A step as short as the rounding of the time, as a division of a step at an event leaves it, changes nothing for the steps
/// that follow, however long.
#[test]
fn a_step_of_the_rounding_of_the_time_is_a_step() {
    for mode in cooling_modes() {
        for stator_node in [0.0, 40.0] {
            let mut plain = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
            plain.parameters.choices.cooling_mode = mode;
            plain.parameters.effects.stator_node.C_s = stator_node;
            plain.parameters.effects.stator_node.R_sh = if stator_node > 0.0 { 0.1 } else { 0.0 };
            plain.inputs = busy_inputs();
            plain.inputs.current_command = 3.0;
            plain.inputs.imposed_speed = 200.0;
            plain.start(33_000.0).unwrap();
            plain.step(33_000.0, 2.0).unwrap();
            let mut divided = plain.clone();
            for (k, short) in [1e-15, 3e-12, 1e-10, 2e-16].into_iter().enumerate() {
                let long = [2.0, 40.0, 0.01, 600.0][k];
                divided.step(divided.time(), short).unwrap();
                divided.step(divided.time(), long).unwrap_or_else(|e| panic!("{mode:?}, {short} s: {e:?}"));
                plain.step(plain.time(), long).unwrap();
            }
            let apart = (divided.state().temperature - plain.state().temperature).amax();
            assert!(apart <= 1e-5, "{mode:?}, stator node {stator_node}: {apart} K");
        }
    }
}

/// The sentence on a failed step says why it failed.
#[test]
fn a_step_without_solution_states_its_cause() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.start(0.0).unwrap();
    m.inputs.voltage = f64::NAN;
    let sentence = m.step(0.0, 0.01).unwrap_err().0;
    assert!(
        sentence.contains("a state or a rate is not finite") && sentence.contains("effects.json"),
        "{sentence}"
    );
}
