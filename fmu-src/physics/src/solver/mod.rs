//! Numerics: the integrators of the FMUs. The crate `reference` has the independent integrator of the tests.

pub mod explicit;
pub mod lobatto;
pub mod phi;
pub mod split;
pub mod stabilized;
