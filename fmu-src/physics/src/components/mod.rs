//! Parts of a motor, one file each: equations as pure functions of their parameters.

pub mod annulus;
pub mod armature;
pub mod chopper;
pub mod commutation;
pub mod conductance;
pub mod enclosure;
pub mod fan;
pub mod gear;
pub mod housing;
pub mod motor;
pub mod sensor;
pub mod thermal;
