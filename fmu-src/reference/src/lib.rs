//! Reference integration of ordinary differential equations by third-party libraries, for tests and benchmarks.
//!
//! It uses the derivatives of all states and shares no code with the models' own integrators. It is a separate crate, so that the
//! models are compiled with one set of features and the FMU library never contains it.
//!
//! The default tests use the explicit Runge-Kutta method DOP853. With the feature `diffsol` the same tests and the benchmarks use
//! the variable-order BDF of diffsol, which takes two minutes of processor time to compile.

#[cfg(feature = "diffsol")]
mod bdf;
#[cfg(feature = "diffsol")]
use bdf as method;
#[cfg(not(feature = "diffsol"))]
mod dop853;
#[cfg(not(feature = "diffsol"))]
use dop853 as method;

/// Tolerances of the reference.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Relative.
    pub relative: f64,
    /// Absolute, in the unit of each state.
    pub absolute: f64,
}

/// Integrates y' = rates(t, y) from t = 0 and returns y at each of `times`, which are positive and ascending; on failure the
/// library's error message.
///
/// The rates must be smooth between 0 and the last time: restart the integration at a discontinuity of an input.
pub fn integrate<const S: usize>(
    rates: impl Fn(f64, &[f64; S]) -> [f64; S],
    y0: &[f64; S],
    times: &[f64],
    tolerance: Tolerance,
) -> Result<Vec<[f64; S]>, String> {
    method::solve(rates, y0, times, tolerance)
}
