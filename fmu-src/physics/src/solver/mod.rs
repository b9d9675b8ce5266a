//! Numerics: the integrators of the FMUs. The crate `reference` has the independent integrator of the tests.

pub mod explicit;
pub mod lobatto;
pub mod phi;
pub mod split;
pub mod stabilized;

/// Largest number of steps in one communication step: a model whose parameters need more ends with an error instead of computing for
/// hours. CVODE has 500 by default (`mxstep`); a million take a few seconds.
pub(crate) const MOST_STEPS: u32 = 1_000_000;
