//! A motor with its cooling: terminals, shaft and thermal network.
//!
//! `variables.rs` declares inputs and outputs, `parameters.rs` the parameters, `equations.rs` has the equations, `motor.rs`
//! implements the interface of the runtime.

pub mod cooling;
mod drivers;
mod equations;
mod initial;
mod motor;
pub mod network;
mod parameters;
mod reading;
mod state_list;
mod states;
mod stepping;
mod variables;

pub use crate::line::Line;
pub use cooling::CoolingMode;
pub use equations::{Constants, NODES, Point, STATES, Step, Temperatures, ThermalCoupling};
pub use initial::Initial;
pub use motor::AnnulusCooledMotor;
pub use parameters::{Choices, Parameters};
pub use variables::{DriveMode, EnergyBalance, Indicators, Inputs, MechanicalMode, Outputs};
