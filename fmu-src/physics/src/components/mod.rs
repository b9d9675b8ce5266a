//! Parts of a motor, one file each: equations as pure functions of their parameters.

pub mod armature;
pub mod chopper;
pub mod conductance;
pub mod enclosure;
pub mod gear;
pub mod motor;
pub mod thermal;
