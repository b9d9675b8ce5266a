//! The solver of ordinary differential equations against closed forms.
use cosim::ode::{Equations, Solver};
use std::convert::Infallible;

/// Derivatives, and an event indicator.
struct Problem<F, G> {
    rates: F,
    indicator: G,
}

impl<F: FnMut(f64, &[f64], &mut [f64]) -> bool, G: FnMut(f64, &[f64]) -> f64> Equations for Problem<F, G> {
    type Error = Infallible;

    fn derivatives(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<bool, Infallible> {
        Ok((self.rates)(t, x, out))
    }

    fn indicators(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<(), Infallible> {
        out.fill((self.indicator)(t, x));
        Ok(())
    }
}

fn no_event(_: f64, _: &[f64]) -> f64 {
    1.0
}

/// States at multiples of `interval`, and the number of evaluations.
fn integrate(
    rates: impl FnMut(f64, &[f64], &mut [f64]) -> bool,
    start: &[f64],
    (interval, count): (f64, usize),
    tolerance: f64,
    sizes: &[f64],
) -> (Vec<Vec<f64>>, usize) {
    let mut problem = Problem { rates, indicator: no_event };
    let mut solver = Solver::new(tolerance);
    solver.restart(sizes.to_vec(), vec![]);
    let (mut t, mut x, mut rows) = (0.0, start.to_vec(), Vec::new());
    for k in 1..=count {
        while t < interval * k as f64 {
            let taken = solver.step(&mut problem, (t, &x), interval * k as f64, 1_000_000).unwrap().unwrap();
            (t, x) = (taken.end, taken.x);
        }
        rows.push(x.clone());
    }
    (rows, solver.evaluations())
}

/// The power of a periodic load over its phase: three pulses, and nothing between them.
const PULSES: [(f64, f64, f64); 3] = [(-20.0, 0.2, 0.03), (-60.0, 0.4, 0.08), (250.0, 0.54, 0.035)];
const PERIOD: f64 = 1.1;

fn power(phase: f64) -> f64 {
    PULSES.iter().map(|(height, at, width)| height * (-((phase.fract() - at) / width).powi(2)).exp()).sum()
}

/// A load that rests for nearly half of each period: a solver that sees the rest lengthens its steps and must not step over the pulses.
#[test]
fn a_periodic_load_with_rests_is_not_stepped_over() {
    // Far from both ends of the period a pulse's integral is that of a Gaussian.
    let work: f64 = PULSES.iter().map(|(height, _, width)| height * width).sum();
    let period = work * std::f64::consts::PI.sqrt() * PERIOD;
    let sizes = [1.0, period];
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[1.0 / PERIOD, power(x[0])]);
        true
    };
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        for parts in [1, 2, 5, 10] {
            let interval = PERIOD / f64::from(parts);
            let (rows, evaluations) =
                integrate(rates, &[0.75, 0.0], (interval, 20 * parts as usize), tolerance, &sizes);
            let expected = 20.0 * period;
            let error = (rows.last().unwrap()[1] - expected).abs() / expected;
            // The tolerance of a step is relative to the sum; errors of some steps of a period add up.
            assert!(error <= 10.0 * tolerance, "{tolerance} {parts}: {error:e}, {evaluations} evaluations");
        }
    }
}

/// The problem of Prothero and Robinson: the solution is sin t, whatever the stiffness.
#[test]
fn stiff_states_cost_no_short_steps() {
    for stiffness in [1.0, 1e3, 1e6] {
        let rates = |t: f64, x: &[f64], out: &mut [f64]| {
            out[0] = -stiffness * (x[0] - t.sin()) + t.cos();
            true
        };
        let (rows, evaluations) = integrate(rates, &[0.0], (0.5, 20), 1e-6, &[1.0]);
        for (k, x) in rows.iter().enumerate() {
            let exact = (0.5 * (k + 1) as f64).sin();
            assert!((x[0] - exact).abs() < 1e-5, "{stiffness}: {} {exact}", x[0]);
        }
        // An explicit method needs 10 stiffness / 3 steps.
        assert!(evaluations < 3000, "{stiffness}: {evaluations}");
    }
}

#[test]
fn many_states_are_integrated_without_a_jacobian() {
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        out.iter_mut().zip(x).for_each(|(out, x)| *out = -x);
        true
    };
    let start = vec![1.0; 5000];
    let (rows, evaluations) = integrate(rates, &start, (1.0, 1), 1e-8, &start);
    assert!(rows[0].iter().all(|x| (x - (-1.0_f64).exp()).abs() < 1e-7));
    assert!(evaluations < 5000, "{evaluations}");
}

/// The height of a falling body crosses zero; the step ends just behind the crossing.
#[test]
fn a_sign_change_ends_the_step_where_it_is() {
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[x[1], -9.81]);
        true
    };
    let mut problem = Problem { rates, indicator: |_: f64, x: &[f64]| x[0] };
    let mut solver = Solver::new(1e-6);
    solver.restart(vec![1.0, 1.0], vec![1.0]);
    let (mut t, mut x) = (0.0, vec![1.0, 0.0]);
    loop {
        let taken = solver.step(&mut problem, (t, &x), 10.0, 10_000).unwrap().unwrap();
        (t, x) = (taken.end, taken.x);
        if taken.event {
            break;
        }
        assert!(t < 1.0 && x[0] > 0.0, "{t} {x:?}");
    }
    assert!((t - (2.0_f64 / 9.81).sqrt()).abs() < 1e-6 && x[0] <= 0.0 && x[0] > -1e-6, "{t} {x:?}");
}

/// Derivatives that do not exist beyond a boundary which the solution does not reach.
#[test]
fn steps_stay_where_derivatives_exist() {
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        if x[0] < 0.0 {
            return false;
        }
        out[0] = -x[0].sqrt();
        true
    };
    let (rows, _) = integrate(rates, &[1.0], (0.5, 3), 1e-6, &[1.0]);
    for (k, x) in rows.iter().enumerate() {
        let exact = (1.0 - 0.25 * (k + 1) as f64).powi(2);
        assert!((x[0] - exact).abs() < 1e-5, "{} {exact}", x[0]);
    }
}

#[test]
fn an_endless_integration_is_given_up() {
    // Grows without limit at t = 1.
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        out[0] = x[0] * x[0];
        true
    };
    let mut problem = Problem { rates, indicator: no_event };
    let mut solver = Solver::new(1e-6);
    solver.restart(vec![1.0], vec![]);
    let (mut t, mut x) = (0.0, vec![1.0]);
    while let Some(taken) = solver.step(&mut problem, (t, &x), 2.0, 100_000).unwrap() {
        (t, x) = (taken.end, taken.x);
        assert!(t < 1.0);
    }
    assert!((t - 1.0).abs() < 1e-5, "{t}");
}
