//! A brushed gearmotor with an H-bridge, in an insulated box.
//!
//! `variables.rs` declares inputs and outputs, `parameters.rs` the parameters; `equations.rs` has the equations,
//! `drivers.rs` the drivers of terms,
//! `state_function.rs` the paper's state function, corrected and as published; `motor.rs` implements the interface of the
//! runtime. The default values are those of preset bdcm-37d.

mod drivers;
mod equations;
mod motor;
mod nodes;
mod parameters;
pub mod state_function;
mod variables;

pub use equations::{Constants, ENERGIES, Point, STATES, State, Step, Stored};
pub use motor::BrushedGearmotor;
pub use nodes::{Initial, NODES, Temperatures};
pub use parameters::Parameters;
pub use variables::{Indicators, Inputs, Outputs};
