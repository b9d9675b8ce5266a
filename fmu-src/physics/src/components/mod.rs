//! Parts of a motor, one file each: equations as pure functions of their parameters.

pub mod conductance;
pub mod motor;
pub mod sensor;
pub mod thermal;
