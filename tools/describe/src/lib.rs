//! Files and checks that are generated from the declarations: both model descriptions, the parameter list, the
//! lock of value references, presets.
//!
//! Every name, unit, limit and description comes from [`physics::model::Declaration`]; dependencies are determined
//! numerically from the model.

mod dependencies;
pub mod experiment;
pub mod fmi2;
pub mod fmi3;
pub mod generated;
pub mod lock;
pub mod markdown;
pub mod plots;
pub mod preset;
pub mod usage;
pub mod xml;

pub use dependencies::{Dependencies, Unknown};
pub use physics::declare::{Causality, Kind};
pub use physics::model::{Declaration, Entry, Model, ModelType};
pub use physics::terms::{Driver, Factor, GenericTerm, Grid, Lag, Law, Port, Product};
pub use physics::token::{Contents, Token};
pub use physics::{load_table::LoadTable, resources::Resources};
pub use physics::{models, start_values};
pub use preset::{Preset, StartValues};

/// Version of the product in both model descriptions.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Name of the generation tool.
pub const TOOL: &str = concat!("motor-fmu ", env!("CARGO_PKG_VERSION"));
/// Authors, as in the file LICENSE.
pub const AUTHOR: &str = "the motor-fmu authors";
/// Licences as an SPDX expression: the code, the gait data of adults, the gait data of children (whose source names no version of
/// CC-BY-SA). The folder documentation/licenses has their texts and those of third-party libraries.
pub const LICENSE: &str = "MIT AND CC0-1.0 AND LicenseRef-CC-BY-SA";
/// Step size of the default experiment, s.
pub const DEFAULT_STEP: f64 = 1e-3;
/// Stop time of the default experiment, s.
pub const DEFAULT_STOP: f64 = 1.0;

/// GUID or instantiation token of an archive with these start values and resources.
pub fn token(declaration: &Declaration, starts: &StartValues, resources: &Resources) -> Token {
    declaration.token.with(resources.contents(starts.entries()))
}

/// The default experiment of an archive; it starts at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Stop time, s.
    pub stop: f64,
    /// Communication step, s.
    pub step: f64,
}

impl Default for Experiment {
    fn default() -> Experiment {
        Experiment { stop: DEFAULT_STOP, step: DEFAULT_STEP }
    }
}
