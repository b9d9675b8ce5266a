//! A brushed gearmotor behind an H-bridge, in an insulated box.
//!
//! `variables.rs` says what goes in and out, `parameters.rs` what the gearmotor is made of, `equations.rs` what holds between
//! them, `state_function.rs` is the paper's state function, corrected and as published, `motor.rs` gives them to the
//! runtime. The declared values are those of preset bdcm-37d.

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
