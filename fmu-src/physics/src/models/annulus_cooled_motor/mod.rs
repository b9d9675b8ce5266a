//! A motor with its cooling: terminals, shaft and heat.
//!
//! `variables.rs` says what goes in and out, `parameters.rs` what the motor is made of, `equations.rs` what holds between them,
//! `motor.rs` gives them to the runtime.

pub mod cooling;
mod equations;
mod initial;
mod march;
mod motor;
pub mod network;
mod parameters;
mod state_list;
mod states;
mod surroundings;
mod variables;

pub use crate::line::Line;
pub use equations::{Beyond, Constants, NODES, Point, STATES, Step, Temperatures};
pub use initial::Initial;
pub use motor::AnnulusCooledMotor;
pub use parameters::Parameters;
pub use variables::{Books, Choices, CoolingMode, DriveMode, Indicators, Inputs, MechanicalMode, Outputs};
