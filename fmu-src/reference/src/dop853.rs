//! Runge-Kutta of order 8 with variable steps.
//!
//! Explicit: the fastest time constant of the motors, L/R of 0.1 ms, limits the step; one hour of simulated time is still feasible.
//!
//! *Source*: the crate differential-equations, DOP853 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, II.5).

use crate::Tolerance;
use differential_equations::prelude::*;

/// First step, s: a fraction of L/R. The library's own estimate may leave the limits of validity, outside which there are no
/// derivatives.
const FIRST: f64 = 1e-6;
/// Largest number of steps of an interval: a constant, and a number per second that is twenty times the need at L/R = 0.1 ms. A
/// solution that needs more diverges.
const MOST: (usize, f64) = (1_000, 1e5);

struct System<F>(F);

impl<const S: usize, F: Fn(f64, &[f64; S]) -> [f64; S]> ODE<f64, [f64; S]> for System<F> {
    fn diff(&self, t: f64, y: &[f64; S], dydt: &mut [f64; S]) {
        *dydt = (self.0)(t, y);
    }
}

/// The state at each of `times`. Every interval is a separate integration, because interpolation within a step is of lower order
/// than the step.
pub fn solve<const S: usize>(
    rates: impl Fn(f64, &[f64; S]) -> [f64; S],
    y0: &[f64; S],
    times: &[f64],
    tolerance: Tolerance,
) -> Result<Vec<[f64; S]>, String> {
    let system = System(rates);
    let (mut t, mut y) = (0.0, *y0);
    let mut found = Vec::with_capacity(times.len());
    for &end in times {
        let method = ExplicitRungeKutta::dop853()
            .rtol(tolerance.relative)
            .atol(tolerance.absolute)
            .h0(FIRST.min(end - t))
            .max_steps(MOST.0 + (MOST.1 * (end - t)) as usize);
        let mut solution =
            IVP::ode(&system, t, end, y).method(method).solve().map_err(|e| format!("{e:?}"))?;
        (t, y) = solution.pop().ok_or("DOP853 gave no state")?;
        found.push(y);
    }
    Ok(found)
}
