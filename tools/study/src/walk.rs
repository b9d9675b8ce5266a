//! A motor in an actuator on a joint that walks: what its winding does over hours, and what it can walk for ever.
//!
//! | file | what is there |
//! |---|---|
//! | `load.rs` | `gait.toml`: the motor, the actuator and the gait, by name |
//! | `stride.rs` | the three models coupled, a stride at a time: the map of the temperatures over a stride |
//! | `cycle.rs` | where that map stands still, and where it leads over hours |
//! | `answer.rs` | the questions: for ever, for how long, how much torque |

mod answer;
mod cycle;
mod load;
mod stride;

pub use answer::{Forever, Walked, Walks, continuous_support, forever, walk};
pub use cycle::{Envelope, EnvelopePoint};
pub use load::{Load, MOTOR};
pub use stride::{Stride, Walker};
