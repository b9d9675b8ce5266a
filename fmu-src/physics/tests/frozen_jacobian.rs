//! Jacobians that a step keeps although they are outdated: the step differs from one with its own Jacobian by less than its tolerance.

use crate::common::{friction, motor};
use physics::model::Model;
use physics::models::annulus_cooled_motor::{DriveMode, MechanicalMode};
use physics::solver::split::{Split, State};

/// Relative tolerance of a step. What the step estimates of an outdated Jacobian is of the next lower order; the largest
/// error below is 4.6 times what it permits, in a step of a hundred time constants from rest.
const TOLERANCE: f64 = 1e-7;
const WITHIN: f64 = 5.0;

/// Largest difference that a Jacobian of `colder` kelvin below makes, relative to the size of current and speed, and whether the step kept
/// it. The step is one of `h` seconds from `part` of the current and speed at which this voltage, V, and load, N.m, are in equilibrium.
fn error_of(colder: f64, h: f64, [volts, load]: [f64; 2], part: f64) -> (f64, bool) {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.coulomb_friction = friction(0.005);
    m.parameters.effects.viscous_friction.k = 2e-6;
    (m.inputs.voltage, m.inputs.load_torque) = (volts, load);
    m.start(0.0).unwrap();
    for k in 0..100 {
        m.step(0.01 * f64::from(k), 0.01).unwrap();
    }
    let mut state = *m.state();
    state.x *= part;
    let step = m.step_equations();
    let mut cold = state;
    cold.temperature[0] -= colder;
    let mut outdated = Split::default();
    outdated.single_step(&step, &cold, h);
    let jacobian = |split: &Split<2>| -> Vec<f64> { split.to_numbers().take(4).collect() };
    let before = jacobian(&outdated);
    let size = |state: &State<2>| [state.x[0].abs().max(1.0), state.x[1].abs().max(10.0)];
    let (found, fresh) =
        (outdated.single_step(&step, &state, h), Split::default().single_step(&step, &state, h));
    let errors = [0, 1].map(|k| (found.x[k] - fresh.x[k]).abs() / size(&fresh)[k].max(size(&state)[k]));
    (errors[0].max(errors[1]), jacobian(&outdated) == before)
}

/// Of 1512 steps, those far from equilibrium and those after much warming update their Jacobian.
#[test]
fn an_outdated_jacobian_is_kept_where_it_changes_nothing() {
    let (mut kept, mut updated) = (0, 0);
    // Windings that warmed since by 0.2 mK to 1 K.
    for colder in [2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 7e-3, 0.01, 0.1, 1.0] {
        for h in [1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.1, 1.0] {
            for source in [[24.0, 0.05], [10.0, 0.1], [-20.0, 0.02]] {
                for part in [0.0, 0.5, 0.9, 0.99, 0.999, 1.0, 1.001, 1.1] {
                    let (error, is_kept) = error_of(colder, h, source, part);
                    *if is_kept { &mut kept } else { &mut updated } += 1;
                    assert!(
                        error <= WITHIN * TOLERANCE,
                        "{colder} K, step of {h} s, {source:?}, {part} of the equilibrium: {error:e}"
                    );
                }
            }
        }
    }
    // Neither all nor none.
    assert!(kept > 300 && updated > 300, "{kept} steps kept their Jacobian, {updated} did not");
}
