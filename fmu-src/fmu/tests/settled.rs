//! Output derivatives after steps far above the time constant of a state: it follows the others, and so does its derivative.

use crate::common::{CS2, Importer, MOTOR, Options, Succeeds, filled, shortened};
use physics::model::ModelType;

/// Steps before the derivative is read, and after it.
const FEW: u32 = shortened(20, 2) as u32;

fn step_on(of: &Importer, from: u32, to: u32, h: f64) {
    (from..to).for_each(|k| of.step(f64::from(k) * h, h).ok());
}

/// The derivative of `output` after some steps of `h` seconds, and its central difference over steps that are shorter by `finer`.
fn given_and_measured(kind: &ModelType, start: &[(&str, f64)], output: &str, h: f64, finer: u32) -> [f64; 2] {
    let instance = || Importer::instantiated(kind, CS2, Options::default()).started(start);
    let one = instance();
    step_on(&one, 0, FEW, h);
    let reference = one.reference(output);
    let given = filled(1, |slope| one.get_slopes(&[reference], &[1], slope))[0];
    let other = instance();
    let fine = h / f64::from(finer);
    step_on(&other, 0, finer * FEW - 1, fine);
    let before = other.get(output);
    step_on(&other, finer * FEW - 1, finer * FEW + 1, fine);
    [given, (other.get(output) - before) / (2.0 * fine)]
}

/// The current of motors whose L/R is far below the step, and the speed of one without inertia: f(x) is the error of the integrator,
/// divided by the time constant.
#[test]
#[cfg_attr(miri, ignore = "measures the accuracy of the integrator; the next test makes the same calls")]
fn settled_states_follow_the_others() {
    let imposed = |voltage: f64, l: f64| {
        vec![("voltage", voltage), ("motor.L", l), ("mechanical_mode", 2.0), ("imposed_speed", 60.0)]
    };
    let free = vec![("voltage", 12.0), ("motor.L", 1e-6), ("motor.J", 1e-7), ("load_torque", 0.1)];
    let cases = [
        (imposed(3.0, 1e-6), "current", 1.0, 0.01),
        (imposed(7.0, 3e-5), "current", 5.0, 0.02),
        (imposed(3.0, 1e-6), "power_electrical", 1.0, 0.01),
        (free.clone(), "current", 2.0, 0.02),
        (free, "shaft_speed", 2.0, 0.02),
    ];
    for (start, output, h, share) in cases {
        let [given, measured] = given_and_measured(MOTOR, &start, output, h, 1);
        assert!(
            (given - measured).abs() < share * measured.abs(),
            "{start:?} {output}: {given} and {measured}"
        );
    }
}

/// Where a step is not above the time constants, the derivative is that of the equations.
#[test]
fn others_have_the_derivative_of_the_equations() {
    for h in [1e-5, 1e-4, 1e-3].into_iter().take(shortened(3, 1)) {
        let start = [("voltage", 3.0), ("motor.L", 1e-3), ("mechanical_mode", 2.0), ("imposed_speed", 60.0)];
        let [given, measured] = given_and_measured(MOTOR, &start, "current", h, 20);
        assert!((given - measured).abs() < 1e-3 * given.abs(), "{h}: {given} and {measured}");
    }
}
