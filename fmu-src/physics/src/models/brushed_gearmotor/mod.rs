//! A brushed gearmotor with an H-bridge, in an insulated box.
//!
//! `variables.rs` declares inputs and outputs, `parameters.rs` the parameters; `equations.rs` has the equations,
//! `state_function.rs` the paper's state function, corrected and as published; `motor.rs` implements the interface of the
//! runtime. The default values are those of preset bdcm-37d.

mod equations;
mod initial_energy;
mod motor;
mod parameters;
pub mod state_function;
mod states;
mod variables;

pub use equations::{Constants, ENERGIES, Point, STATES, State, Step};
pub use initial_energy::InitialEnergy;
pub use motor::BrushedGearmotor;
pub use parameters::Parameters;
pub use states::{Initial, NODES, Temperatures};
pub use variables::{Indicators, Inputs, Outputs};
