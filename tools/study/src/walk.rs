//! A motor under a periodic load, such as an actuator on a walking joint: temperature of its winding over hours, and the continuous torque.
//!
//! | file | content |
//! |---|---|
//! | `load.rs`, `load/file.rs` | `gait.toml`: the motor, the actuator and the gait, by name |
//! | `walker.rs`, `periodic.rs`, `motor_state.rs` | what moves the motor over a period: one of the following three; its means and peaks; its temperatures |
//! | `stride.rs` | the three models coupled, one stride at a time: the map of the temperatures over a stride |
//! | `shaft.rs`, `cycle_file.rs`, `cycle_file/usual.rs` | a motor under a cycle of torque and speed from a CSV file |
//! | `mix.rs`, `mix_file.rs` | phases of several loads and rest |
//! | `cycle.rs`, `envelope.rs` | fixed point of that map, and its iteration over hours |
//! | `answer.rs` | periodic steady state, time to the winding's limit, objectives of sweeps |
//! | `support.rs`, `speed.rs` | continuous support; whether the supply voltage suffices for the speed |

mod answer;
mod cycle;
mod cycle_file;
mod envelope;
mod load;
mod mix;
mod mix_file;
mod motor_state;
mod periodic;
mod shaft;
mod speed;
mod stride;
mod support;
#[cfg(test)]
mod tests;
mod walker;

pub use answer::{Known, Objective, TIME_TO_LIMIT, Walked, check_hours, periodic, walk};
pub use cycle_file::{Drive, SETTINGS, Setting};
pub use envelope::{Envelope, EnvelopePoint};
pub use load::{Derived, Load, MOTOR, Words};
pub use periodic::Periodic;
pub use support::{Continuous, Limit, continuous_support};
pub use walker::{Period, Walker};
