//! The crate `fmi-rs`: both standards through its builders.

use crate::{Motor, Outcome};
use fmi_rs::fmi2::{CS, FMU2, builder::FMU2Builder, types::fmi2Status};
use fmi_rs::fmi3::{FMU3, builder::FMU3Builder, types::fmi3Status};
use std::path::Path;
use std::sync::Arc;

/// An FMI 2.0 instance.
pub struct Two {
    builder: FMU2Builder,
    instance: Arc<FMU2<CS>>,
}

/// An FMI 3.0 instance.
pub struct Three {
    builder: FMU3Builder,
    instance: Arc<FMU3>,
}

/// Opens an FMI 2.0 archive.
pub fn open2(archive: &Path) -> Outcome<Two> {
    let builder = FMU2Builder::new(&archive).map_err(|e| e.to_string())?;
    let instance = builder.instantiate_cs("motor").map_err(|e| e.to_string())?;
    Ok(Two { builder, instance })
}

/// Opens an FMI 3.0 archive. Events stay off: the drive has none.
pub fn open3(archive: &Path) -> Outcome<Three> {
    let mut builder = FMU3Builder::new(&archive).map_err(|e| e.to_string())?;
    builder.eventModeUsed = false;
    builder.earlyReturnAllowed = false;
    let instance = builder.instantiate_cs("motor").map_err(|e| e.to_string())?;
    Ok(Three { builder, instance })
}

fn told2(call: &str, status: fmi2Status) -> Outcome<()> {
    if matches!(status, fmi2Status::Ok) { Ok(()) } else { Err(format!("{call}: {status:?}")) }
}

fn told3(call: &str, status: fmi3Status) -> Outcome<()> {
    if matches!(status, fmi3Status::Ok) { Ok(()) } else { Err(format!("{call}: {status:?}")) }
}

impl Motor for Two {
    fn reference(&self, name: &str) -> Outcome<u32> {
        let found = self.builder.model_description.variable_by_name(name);
        found.map(|v| v.valueReference).map_err(|e| e.to_string())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()> {
        told2("setReal", self.instance.setReal(references, values))
    }

    fn initialize(&mut self) -> Outcome<()> {
        told2("setupExperiment", self.instance.setupExperiment(None, 0.0, None))?;
        told2("enterInitializationMode", self.instance.enterInitializationMode())?;
        told2("exitInitializationMode", self.instance.exitInitializationMode())
    }

    fn step(&mut self, point: f64, size: f64) -> Outcome<()> {
        told2("doStep", self.instance.doStep(point, size, 1))
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()> {
        told2("getReal", self.instance.getReal(references, values))
    }
}

impl Motor for Three {
    fn reference(&self, name: &str) -> Outcome<u32> {
        let found = self.builder.model_description.variable_by_name(name);
        found.map(|v| v.valueReference).map_err(|e| e.to_string())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()> {
        told3("setFloat64", self.instance.setFloat64(references, values))
    }

    fn initialize(&mut self) -> Outcome<()> {
        told3("enterInitializationMode", self.instance.enterInitializationMode(None, 0.0, None))?;
        told3("exitInitializationMode", self.instance.exitInitializationMode())
    }

    fn step(&mut self, point: f64, size: f64) -> Outcome<()> {
        let (mut event, mut end, mut early, mut reached) = Default::default();
        let status =
            self.instance.doStep(point, size, true, &mut event, &mut end, &mut early, &mut reached);
        told3("doStep", status)?;
        if end || early || reached != point + size {
            return Err(format!("doStep stopped at {reached} instead of {}", point + size));
        }
        Ok(())
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()> {
        told3("getFloat64", self.instance.getFloat64(references, values))
    }
}
