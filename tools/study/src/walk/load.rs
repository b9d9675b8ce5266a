//! A load file: start values of the three models that walk together.
//!
//! ```toml
//! [gait]
//! "gait.body_mass" = 75
//! "gait.activity" = "stairs_up"
//! [actuator]
//! "transmission.ratio" = 200
//! [motor]                       # what differs from the preset and is not on the command line
//! cooling_mode = "annulus_push"
//! ```

use super::stride::Walker;
use crate::StudyError;
use crate::bench::Bench;
use describe::{Preset, StartValues, models};
use std::path::Path;

/// The motor that walks.
pub const MOTOR: &str = "AnnulusCooledMotor";
const ACTUATOR: &str = "SeriesElasticActuator";
const GAIT: &str = "GaitLoad";
/// Tables of the file, and the models that they belong to.
const TABLES: [(&str, &str); 3] = [("motor", MOTOR), ("actuator", ACTUATOR), ("gait", GAIT)];
/// What every walk begins with: the shaft is the actuator's.
const ALWAYS: (&str, &str) = ("mechanical_mode", "free_shaft");

/// The three models before they start.
#[derive(Clone)]
pub struct Load {
    benches: [Bench; 3],
}

impl Load {
    /// From a file; the motor starts from `preset`, and `sets` count last. A name in `sets` belongs to the first of motor,
    /// actuator and gait that has it.
    ///
    /// # Errors
    /// One sentence with file and line, or with name, value and limits.
    pub fn read(file: &Path, preset: Option<&Preset>, sets: &[(String, String)]) -> Result<Load, StudyError> {
        let name = file.display().to_string();
        let text = std::fs::read_to_string(file)
            .map_err(|e| StudyError::new(format!("the load {name} cannot be read ({e})")))?;
        Load::parse(&text, &name, preset, sets)
    }

    /// From the text of a file; `file` names it in errors.
    ///
    /// # Errors
    /// As [`read`](Load::read).
    pub fn parse(
        text: &str,
        file: &str,
        preset: Option<&Preset>,
        sets: &[(String, String)],
    ) -> Result<Load, StudyError> {
        let mut tables = Vec::new();
        for (table, model) in TABLES {
            if let Some(kind) = models::by_name(model) {
                tables.push((table, (kind.declaration)()));
            }
        }
        let values = StartValues::of_tables(text, file, &tables)?;
        let mut benches = [Bench::new(MOTOR, preset)?, Bench::new(ACTUATOR, None)?, Bench::new(GAIT, None)?];
        benches[0].set_text(ALWAYS.0, ALWAYS.1)?;
        for (bench, values) in benches.iter_mut().zip(&values) {
            bench.set_all(values)?;
        }
        let mut load = Load { benches };
        for (name, text) in sets {
            load.set_text(name, text)?;
        }
        Ok(load)
    }

    /// The first of the models that has the variable.
    ///
    /// # Errors
    /// None has it.
    pub fn owner(&self, name: &str) -> Result<&Bench, StudyError> {
        match self.benches.iter().find(|b| b.knows(name, None)) {
            Some(bench) => Ok(bench),
            // The sentence of the motor, with its nearest name.
            None => self.benches[0].entry(name).map(|_| &self.benches[0]),
        }
    }

    /// Sets a variable of the first model that has it, from text.
    ///
    /// # Errors
    /// No such variable, or a value that it does not take.
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), StudyError> {
        let place = self.benches.iter().position(|b| b.knows(name, None)).unwrap_or(0);
        self.benches[place].set_text(name, text)
    }

    /// The value of a parameter, of the first model that has it.
    ///
    /// # Errors
    /// No such variable.
    pub fn get(&self, name: &str) -> Result<f64, StudyError> {
        self.owner(name)?.clone().get(name)
    }

    /// Motor, actuator and gait, started together.
    ///
    /// # Errors
    /// Parameters that do not go together, a drive that does not follow an actuator, a gait that never repeats.
    pub fn walker(&self) -> Result<Walker, StudyError> {
        let [motor, actuator, gait] = self.benches.clone();
        Walker::start(motor, actuator, gait)
    }

    /// Mass of motor, fan and tube, kg.
    ///
    /// # Errors
    /// A motor that does not start.
    pub fn mass(&self) -> Result<f64, StudyError> {
        let mut held = self.benches[0].clone();
        held.set_text("drive_mode", "current")?;
        held.set_text("mechanical_mode", "imposed_speed")?;
        held.set("current_command", 1.0)?;
        held.start()?;
        Ok(held.get("shaft_torque")? / held.get("torque_density")?)
    }
}
