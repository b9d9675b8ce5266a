//! The crate `fmi`: FMI 2.0 through its Co-Simulation instance.

use crate::{Motor, Outcome};
use fmi::CS;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, Instance};
use fmi::fmi3::import::Fmi3Import;
use fmi::traits::FmiImport;
use std::collections::HashMap;
use std::fmt::Debug;
use std::path::Path;

/// An instance, and the references that its importer has read.
pub struct Fmi {
    references: HashMap<String, u32>,
    instance: Instance<CS>,
    // The unzipped archive is removed with the import, so that stays until the instance has gone.
    _import: Fmi2Import,
}

fn checked<T, E: Debug>(call: &str, result: Result<T, E>) -> Outcome<()> {
    result.map(drop).map_err(|e| format!("{call}: {e:?}"))
}

/// Opens an FMI 2.0 archive.
pub fn open(archive: &Path) -> Outcome<Fmi> {
    let import: Fmi2Import = fmi::import::from_path(archive).map_err(|e| format!("import: {e:?}"))?;
    let variables = import.model_description().get_model_variables();
    let references = variables.map(|v| (v.name.clone(), v.value_reference)).collect();
    let instance =
        import.instantiate_cs("motor", false, true).map_err(|e| format!("instantiate: {e:?}"))?;
    Ok(Fmi { references, instance, _import: import })
}

/// Reads an FMI 3.0 archive, without an instance: what it says is in docs/comparison.md.
pub fn read3(archive: &Path) -> Outcome<()> {
    checked("import", fmi::import::from_path::<Fmi3Import>(archive))
}

impl Motor for Fmi {
    fn reference(&self, name: &str) -> Outcome<u32> {
        self.references.get(name).copied().ok_or_else(|| format!("no variable {name}"))
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()> {
        checked("set_real", self.instance.set_real(references, values))
    }

    fn initialize(&mut self) -> Outcome<()> {
        checked("setup_experiment", self.instance.setup_experiment(None, 0.0, None))?;
        checked("enter_initialization_mode", Common::enter_initialization_mode(&mut self.instance))?;
        checked("exit_initialization_mode", Common::exit_initialization_mode(&mut self.instance))
    }

    fn step(&mut self, point: f64, size: f64) -> Outcome<()> {
        checked("do_step", self.instance.do_step(point, size, true))
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()> {
        checked("get_real", self.instance.get_real(references, values))
    }
}
