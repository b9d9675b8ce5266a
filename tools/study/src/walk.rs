//! A motor in an actuator on a walking joint: temperature of its winding over hours, and the continuous torque.
//!
//! | file | content |
//! |---|---|
//! | `load.rs` | `gait.toml`: the motor, the actuator and the gait, by name |
//! | `stride.rs` | the three models coupled, one stride at a time: the map of the temperatures over a stride |
//! | `cycle.rs` | fixed point of that map, and its iteration over hours |
//! | `answer.rs` | periodic steady state, time to the winding's limit, continuous support |

mod answer;
mod cycle;
mod load;
mod stride;

pub use answer::{Continuous, Limit, Objective, Walked, continuous_support, periodic, walk};
pub use cycle::{Envelope, EnvelopePoint};
pub use load::{Derived, Load, MOTOR};
pub use stride::{Periodic, Walker};
