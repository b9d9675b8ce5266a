//! What the declarations say, for everyone but the physics: both model descriptions, the parameter list, the
//! lock of value references, and presets checked against the table.
//!
//! Nothing is stated here a second time: every name, unit, limit and description comes from
//! [`physics::model::Declaration`], and dependencies are found by asking the model.

mod dependencies;
pub mod fmi2;
pub mod fmi3;
pub mod generated;
pub mod lock;
pub mod markdown;
pub mod preset;
pub mod usage;
mod xml;

pub use dependencies::{Dependencies, Unknown};
pub use physics::declare::{Causality, Kind};
pub use physics::model::{Declaration, Entry, Model, ModelType};
pub use physics::terms::{Driver, GenericTerm, Law, Port};
pub use physics::{models, start_values};
pub use preset::{Preset, StartValues};

/// Version of the product, as both model descriptions show it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Name of the tool that makes the archives.
pub const TOOL: &str = concat!("motor-fmu ", env!("CARGO_PKG_VERSION"));
/// Step that importers are offered, s.
pub const DEFAULT_STEP: f64 = 1e-3;
/// End of the run that importers are offered, s.
pub const DEFAULT_STOP: f64 = 1.0;
