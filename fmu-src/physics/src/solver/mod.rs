//! Numerics: the integrators of the FMUs. The crate `reference` has the independent integrator of the tests.

pub mod explicit;
pub mod lobatto;
pub mod phi;
pub mod split;
pub mod stabilized;

use crate::fault::Fault;
use split::StepFailure;
use std::fmt;

/// Largest number of steps in one communication step: a model whose parameters need more ends with an error instead of computing for
/// hours. CVODE has 500 by default (`mxstep`); a million take a few seconds.
pub(crate) const MOST_STEPS: u32 = 1_000_000;

/// Why a step has no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// It needs more than [`MOST_STEPS`] steps of the integrator.
    Steps,
    /// The shortest step of the integrator is inaccurate.
    Inaccurate,
    /// A state, a rate or a derivative of it is not finite.
    NotFinite,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Cause::Steps => write!(f, "more than {MOST_STEPS} steps of the integrator are needed"),
            Cause::Inaccurate => f.write_str("no step is accurate"),
            Cause::NotFinite => f.write_str("a state or a rate is not finite"),
        }
    }
}

/// The sentence on a step of a motor, `machine`, that failed after `time`, s, with the state before it: current, A, speed, rad/s, winding
/// temperature, K.
#[cold]
pub(crate) fn no_solution(
    machine: &str,
    time: f64,
    failure: &StepFailure,
    [i, w, winding]: [f64; 3],
) -> Fault {
    let StepFailure { t, h, cause } = failure;
    let likely = match cause {
        Cause::NotFinite => "parameters, inputs or a law in effects.json",
        _ => "parameters or inputs",
    };
    Fault(format!(
        "The {machine}'s equations have no solution {t:.3e} s after {time} s: {cause}, the last was {h:.1e} s long (current {i} A, speed {w} \
         rad/s, winding {winding} K); {likely} are probably far from those of a motor."
    ))
}
