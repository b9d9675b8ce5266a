//! Parts of a motor, one file each: equations as pure functions of their parameters.

pub mod annulus;
pub mod commutation;
pub mod conductance;
pub mod fan;
pub mod housing;
pub mod motor;
pub mod sensor;
pub mod thermal;
