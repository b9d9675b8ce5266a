//! A load file: start values of motor, actuator and gait. The control of the actuator derives its motor data from the
//! motor (`MOTOR_DATA` of the actuator) unless the file or a setting gives them.
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
pub use describe::preset::MOTOR;
use describe::preset::motor_data;
use describe::{Kind, Preset, StartValues, models};
use physics::models::series_elastic_actuator::MOTOR_DATA;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;

const ACTUATOR: &str = "SeriesElasticActuator";
const GAIT: &str = "GaitLoad";
/// Tables of the file, and the models that they belong to.
const TABLES: [(&str, &str); 3] = [("motor", MOTOR), ("actuator", ACTUATOR), ("gait", GAIT)];
/// The motor's shaft turns freely in the actuator.
const FREE_SHAFT: (&str, &str) = ("mechanical_mode", "free_shaft");
/// The actuator's supply power is that of the connected motor.
const POWER_SOURCE: (&str, &str) = ("drive.power_source", "motor_power");
const ACTIVITY: &str = "gait.activity";
/// Index of the actuator among the three models.
const THE_ACTUATOR: usize = 1;

/// Motor, actuator and gait before they start.
#[derive(Clone)]
pub struct Load {
    benches: [Bench; 3],
    /// Variables of the actuator that were set explicitly.
    explicit: BTreeSet<String>,
}

/// A value of the actuator that follows from its motor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Derived {
    /// Variable of the actuator.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Variable of the motor.
    pub from: &'static str,
}

impl Load {
    /// From a file; the motor starts from `preset`, and `sets` override both. A name in `sets` belongs to the first of motor,
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
        benches[0].set_text(FREE_SHAFT.0, FREE_SHAFT.1)?;
        benches[THE_ACTUATOR].set_text(POWER_SOURCE.0, POWER_SOURCE.1)?;
        for (bench, values) in benches.iter_mut().zip(&values) {
            bench.set_all(values)?;
        }
        let declaration = benches[THE_ACTUATOR].declaration();
        let given = values[THE_ACTUATOR].entries();
        let names = given.iter().filter_map(|(reference, _)| declaration.by_reference(*reference));
        let explicit = names.map(|entry| entry.name.clone()).collect();
        let mut load = Load { benches, explicit };
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
        self.benches[place].set_text(name, text)?;
        if place == THE_ACTUATOR {
            self.explicit.insert(name.to_owned());
        }
        Ok(())
    }

    /// The values of the actuator that follow from its motor.
    ///
    /// # Errors
    /// None with declared names.
    pub fn derived(&self) -> Result<Vec<Derived>, StudyError> {
        let motor = &self.benches[0];
        let actuator = self.benches[THE_ACTUATOR].declaration();
        let starts = motor_data(actuator, |name| motor.clone().get(name).ok());
        let mut found = Vec::new();
        for (reference, value) in starts.entries() {
            let Some(entry) = actuator.by_reference(reference) else { continue };
            let row = MOTOR_DATA.iter().find(|(own, _)| *own == entry.name);
            if let Some(&(name, from)) = row.filter(|_| !self.explicit.contains(&entry.name)) {
                found.push(Derived { name, value, unit: entry.row.unit.name(), from });
            }
        }
        Ok(found)
    }

    /// The three models with the derived values.
    fn prepared(&self) -> Result<[Bench; 3], StudyError> {
        let mut benches = self.benches.clone();
        for derived in self.derived()? {
            benches[THE_ACTUATOR].set(derived.name, derived.value)?;
        }
        Ok(benches)
    }

    /// Subjects and publication of the gait's data, from the declaration of its activity.
    ///
    /// # Errors
    /// None with declared activities.
    pub fn source(&self) -> Result<String, StudyError> {
        let value = self.get(ACTIVITY)?;
        match self.owner(ACTIVITY)?.entry(ACTIVITY)?.row.kind {
            Kind::Enumeration(t) => t.items.iter().find(|i| f64::from(i.value) == value),
            _ => None,
        }
        .map(|item| item.doc.trim().to_owned())
        .ok_or_else(|| StudyError::new(format!("{ACTIVITY} = {value} has no description")))
    }

    /// The value of a parameter, of the first model that has it.
    ///
    /// # Errors
    /// No such variable.
    pub fn get(&self, name: &str) -> Result<f64, StudyError> {
        let owner = self.owner(name)?.declaration().name;
        let benches = self.prepared()?;
        let mut bench = benches.into_iter().find(|b| b.declaration().name == owner);
        bench.as_mut().map_or_else(|| Err(StudyError::new(format!("no variable {name}"))), |b| b.get(name))
    }

    /// Motor, actuator and gait, started together.
    ///
    /// # Errors
    /// Parameters that do not go together, a drive that does not follow an actuator, a gait that never repeats.
    pub fn walker(&self) -> Result<Walker, StudyError> {
        let [motor, actuator, gait] = self.prepared()?;
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
