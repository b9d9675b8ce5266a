//! Numerics: the integrator of the FMUs, and the independent one that the tests hold it against.

pub mod explicit;
pub mod lobatto;
pub mod phi;
#[cfg(feature = "reference")]
pub mod reference;
pub mod split;
pub mod stabilized;
