//! Components of a motor and of its environment, one file each: equations as pure functions of their parameters.

pub mod annulus;
pub mod armature;
pub mod chopper;
pub mod commutation;
pub mod conductance;
pub mod enclosure;
pub mod fan;
pub mod gait;
pub mod gear;
pub mod housing;
pub mod initial;
pub mod jacket;
pub mod motor;
pub mod sensor;
pub mod springs;
pub mod supply;
pub mod thermal;
pub mod torque_control;
pub mod transmission;
pub mod validity;
