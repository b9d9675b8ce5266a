//! Systems of FMUs: read from SSP or TOML, checked, run, written as SSP.
//!
//! | file | holds |
//! |---|---|
//! | `structure.rs` | content of a file, with line numbers; read by `text.rs` (TOML) and `ssd.rs`, `bindings.rs`, `flatten.rs` (SSP), written by `package.rs` |
//! | `connections.rs`, `ends.rs`, `settings.rs`, `units.rs` | their names resolved in the FMUs: sources of inputs, unit conversions, values |
//! | `inputs.rs` | tables of inputs over time |
//! | `order.rs`, `loops.rs` | what passes through without a step; algebraic loops and their solution |
//! | `master.rs`, `memory.rs`, `component_steps.rs`, `batch.rs` | instances and one communication step |
//! | `times.rs` | start, stop and communication steps, checked |
//! | `run.rs`, `variable_step.rs` | the run, with a fixed or a variable step |
//! | `power_bonds.rs`, `record.rs` | the bonds of the coupling; the rows that are kept |
mod batch;
mod bindings;
mod component_steps;
mod connections;
mod dictionary;
mod ends;
mod flatten;
mod inputs;
mod loops;
mod master;
mod memory;
mod order;
mod package;
mod parameter_files;
mod parts;
mod power_bonds;
mod record;
mod run;
mod settings;
mod side_by_side;
mod ssd;
mod structure;
mod tags;
mod text;
mod times;
mod units;
mod variable_step;

pub(crate) use batch::Batch;
pub use order::Algorithm;
pub use package::SspForm;
pub use power_bonds::PowerBond;
pub use run::{SystemOptions, SystemRun, cosimulate};
pub(crate) use units::{Affine, conversion, unit_of};

use crate::{Archive, Error, ModelDescription};
use parts::Parts;
use std::path::Path;
use structure::{Place, Structure};

/// A system of FMUs: components, connections, values. Each archive is unpacked once, however many components use it.
#[derive(Clone, Debug)]
pub struct System {
    structure: Structure,
    /// The archive of each component.
    archives: Vec<Archive>,
}

impl System {
    /// Reads the system at `path`, a TOML file if its name ends so, else an SSP archive, and opens all FMUs.
    ///
    /// # Errors
    /// What cannot be read, with file and line: the system itself, a component without FMU, an FMU without
    /// Co-Simulation. Connections and values are checked by [`cosimulate`] and [`System::write_ssp`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let structure = if toml { text::read(path)? } else { ssd::read(path)? };
        let mut archives: Vec<Archive> = Vec::new();
        for (index, component) in structure.components.iter().enumerate() {
            let fault =
                |message: String| component.place.fault(format!("component {}: {message}", component.name));
            let earlier = &structure.components[..index];
            if let Some(other) = earlier.iter().find(|c| c.name == component.name) {
                return Err(fault(format!("the name is taken, by the one in line {}", other.place.line)));
            }
            if !component.path.is_file() {
                return Err(fault(format!("there is no FMU {}", component.source)));
            }
            let archive = match earlier.iter().position(|c| c.path == component.path) {
                Some(same) => archives[same].clone(),
                // The path of the temporary folder is not useful to the user.
                None => Archive::open(&component.path).map_err(|e| {
                    fault(e.to_string().replace(&component.path.display().to_string(), &component.source))
                })?,
            };
            let Some(interface) = archive.description().co_simulation() else {
                return Err(fault(format!("{} has no Co-Simulation interface", component.source)));
            };
            if interface.only_once_per_process && earlier.iter().any(|c| c.path == component.path) {
                let message =
                    format!("{} allows one instance per process, and this is the second", component.source);
                return Err(fault(message));
            }
            archives.push(archive);
        }
        if archives.is_empty() {
            let place = Place { file: path.display().to_string().into(), line: 1 };
            return Err(place.fault("there are no components"));
        }
        Ok(Self { structure, archives })
    }

    /// The name of the system.
    pub fn name(&self) -> &str {
        &self.structure.name
    }

    /// Names of the components, in the order of the file.
    pub fn components(&self) -> impl Iterator<Item = &str> {
        self.structure.components.iter().map(|c| c.name.as_str())
    }

    /// Names and model descriptions of the components, in the order of the file.
    pub fn descriptions(&self) -> impl Iterator<Item = (&str, &ModelDescription)> {
        self.components().zip(self.archives.iter().map(Archive::description))
    }

    /// Whether the system has inputs or outputs of its own.
    pub fn has_connectors(&self) -> bool {
        self.structure.connections.iter().any(|c| !c.is_inner())
    }

    /// Writes the system as an SSP archive: its structure, and the FMUs as they are. The same system gives the same
    /// bytes.
    ///
    /// # Errors
    /// All that is wrong with connections and values; [`Error::Io`].
    pub fn write_ssp(&self, path: &Path, form: SspForm) -> Result<(), Error> {
        package::write(self.parts(), path, form)
    }

    /// Components whose name is a prefix of names of their variables, which OMSimulator cannot read.
    pub fn ambiguous_names(&self) -> impl Iterator<Item = &str> {
        let begins =
            |name: &str, v: &crate::Variable| v.name.strip_prefix(name).is_some_and(|r| r.starts_with('.'));
        let all = self.structure.components.iter().zip(&self.archives);
        all.filter(move |(c, a)| a.description().variables.iter().any(|v| begins(&c.name, v)))
            .map(|(c, _)| c.name.as_str())
    }

    fn parts(&self) -> Parts<'_> {
        Parts { structure: &self.structure, archives: &self.archives }
    }
}
