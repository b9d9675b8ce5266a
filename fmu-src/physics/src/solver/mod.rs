//! Numerics: the integrators of the FMUs. The independent one that tests compare with is the crate `reference`.

pub mod explicit;
pub mod lobatto;
pub mod phi;
pub mod split;
pub mod stabilized;
