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
//!
//! A table `[cycle]` is a load from a CSV file (`cycle_file.rs`): in place of actuator and gait, or, in a file with a table `[actuator]`, at
//! the joint of the actuator, where it is the load table of the gait. A CSV file alone is such a cycle. A mix has phases, each with a load of its own:
//!
//! ```toml
//! [mix]
//! period = "10 min"
//! phase = [
//!     { fraction = "60 %", "gait.activity" = "walk" },       # values that differ from the rest of the file
//!     { fraction = 0.1, load = "stairs.toml" },              # another load file
//!     { fraction = 0.3, rest = true },
//! ]
//! ```

mod file;
mod notes;

use super::cycle_file::{Cycle, Drive, SCALE, SETTINGS, Setting};
use super::mix::Mix;
use super::mix_file::{MixFile, Phase};
use super::shaft::Shaft;
use super::stride::Coupled;
use super::walker::Walker;
use crate::StudyError;
use crate::bench::Bench;
pub use describe::preset::MOTOR;
use describe::preset::{motor_data, nearest};
use describe::{Entry, Kind, Preset, StartValues, models};
use file::without_effect;
use physics::load_table::LoadTable;
use physics::models::series_elastic_actuator::MOTOR_DATA;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

const ACTUATOR: &str = "SeriesElasticActuator";
const GAIT: &str = "GaitLoad";
/// Tables of the file, and the models that they belong to.
const TABLES: [(&str, &str); 3] = [("motor", MOTOR), ("actuator", ACTUATOR), ("gait", GAIT)];
/// The motor's shaft turns freely in the actuator.
const FREE_SHAFT: (&str, &str) = ("mechanical_mode", "free_shaft");
/// The actuator's supply power is that of the connected motor.
const POWER_SOURCE: (&str, &str) = ("drive.power_source", "motor_power");
const ACTIVITY: &str = "gait.activity";
/// The activity that is a load table.
const TABLE: &str = "table";
/// The fraction of the biological torque that is demanded.
const SUPPORT: &str = "gait.support";
/// Period of a rest: the longest step that resolves the winding's temperature.
const REST: f64 = 1.0;
/// Index of the actuator among the three models.
const THE_ACTUATOR: usize = 1;
const THE_GAIT: usize = 2;

/// Motor, actuator and gait, or a motor with a cycle, before they start.
#[derive(Clone)]
pub struct Load {
    benches: [Bench; 3],
    /// Variables of the motor and the actuator that the file or a setting gives.
    pub(super) explicit: BTreeSet<String>,
    /// In place of actuator and gait.
    cycle: Option<(Arc<Cycle>, Drive)>,
    /// At the joint of the actuator.
    at_joint: Option<Arc<Cycle>>,
    mix: Option<MixFile<Load>>,
    origin: Arc<Origin>,
}

/// What a load was made from, for the same load of another motor.
struct Origin {
    text: String,
    file: String,
    preset: Option<Preset>,
    sets: Vec<(String, String)>,
}

/// What a load moves: words for reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// Of the period: stride, cycle or period of the mix.
    pub period: &'static str,
    /// Of the factor that is increased until the winding is at its limit, before and after its value.
    pub factor: [&'static str; 2],
    /// Of the place of the torque.
    pub place: &'static str,
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
    /// The same load of another motor.
    ///
    /// # Errors
    /// As [`read`](Load::read).
    pub fn with_preset(&self, preset: &Preset) -> Result<Load, StudyError> {
        Load::parse(&self.origin.text, &self.origin.file, Some(preset), &self.origin.sets)
    }

    /// The loads of the phases, or this one.
    pub(super) fn parts(&self) -> Vec<&Load> {
        match &self.mix {
            Some(mix) => mix.phases.iter().filter(|p| !p.rest).filter_map(|p| p.load.as_deref()).collect(),
            None => vec![self],
        }
    }

    /// Words for reports.
    pub fn words(&self) -> Words {
        let parts = self.parts();
        let of_file = |part: &&Load| part.cycle.is_some() || part.at_joint.is_some();
        let factor = match parts.iter().all(of_file) {
            true => ["factor", "on the torque of the cycle"],
            false => ["support", "of the biological torque"],
        };
        let place = if parts.iter().all(|part| part.cycle.is_some()) { "cycle" } else { "joint" };
        let period = match &self.mix {
            Some(_) => "period of the mix",
            None if of_file(&self) => "cycle",
            None => "stride",
        };
        Words { period, factor, place }
    }

    /// Name and greatest value of the factor on the torque.
    pub(super) fn support_most(&self) -> Result<f64, StudyError> {
        let mut most = f64::INFINITY;
        for part in self.parts() {
            most = most.min(match (&part.cycle, Setting::named(SCALE)) {
                (Some(_), Some(scale)) => scale.limits().1,
                _ => part.benches[THE_GAIT].entry(SUPPORT)?.row.max,
            });
        }
        Ok(most)
    }

    /// Sets the factor on the torque.
    pub(super) fn set_support(&mut self, factor: f64) -> Result<(), StudyError> {
        let text = factor.to_string();
        let set = |load: &mut Load| load.set_text(if load.cycle.is_some() { SCALE } else { SUPPORT }, &text);
        match &mut self.mix {
            // A rest has no load; its own would not know the factor if the phases have theirs from other files.
            Some(mix) => {
                let loads = mix.phases.iter_mut().filter(|p| !p.rest).filter_map(|p| p.load.as_deref_mut());
                loads.into_iter().try_for_each(set)
            }
            None => set(self),
        }
    }

    /// The setting of a cycle, where the load has one.
    fn setting(&self, name: &str) -> Option<(&'static Setting, &Drive)> {
        let setting = Setting::named(name)?;
        let drive = self.parts().into_iter().find_map(|part| part.cycle.as_ref())?;
        Some((setting, &drive.1))
    }

    /// Unit of a variable, and its declaration where it has one.
    ///
    /// # Errors
    /// None has it.
    pub fn unit(&self, name: &str) -> Result<(&'static str, Option<&'static Entry>), StudyError> {
        if let Some((setting, _)) = self.setting(name) {
            return Ok((setting.unit, None));
        }
        let entry = self.owner(name)?.entry(name)?;
        Ok((entry.row.unit.name(), Some(entry)))
    }

    /// The first of the models that has the variable.
    ///
    /// # Errors
    /// None has it.
    pub fn owner(&self, name: &str) -> Result<&Bench, StudyError> {
        match self.benches.iter().find(|b| b.knows(name, None)) {
            Some(bench) => Ok(bench),
            None => Err(self.unknown(name)),
        }
    }

    /// One sentence about a name that neither the models nor the cycle know.
    fn unknown(&self, name: &str) -> StudyError {
        let parts = self.parts();
        let has_cycle = parts.iter().any(|part| part.cycle.is_some());
        let has_actuator = parts.iter().any(|part| part.cycle.is_none());
        if Setting::named(name).is_some() {
            return StudyError::new(format!("{name} has no effect: the load has no [cycle] at the motor"));
        }
        let benches = if has_actuator { &self.benches[..] } else { &self.benches[..1] };
        let entries = benches.iter().flat_map(|bench| &bench.declaration().entries);
        let settings = SETTINGS.iter().filter(|_| has_cycle).map(|s| s.name);
        let known = settings.chain(entries.map(|entry| entry.name.as_str()));
        let owners = match (has_actuator, has_cycle) {
            (true, false) => "neither motor nor actuator or gait has",
            (false, true) => "neither motor nor cycle has",
            _ => "neither motor nor actuator, gait or cycle has",
        };
        StudyError::new(format!("{owners} a variable {name}{}", nearest(name, known)))
    }

    /// Sets a variable of the first model that has it, from text.
    ///
    /// # Errors
    /// No such variable, or a value that it does not take.
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), StudyError> {
        if let Some(mix) = &mut self.mix {
            // What a phase sets itself stays.
            let mut taken = Err(None);
            for phase in &mut mix.phases {
                // A rest has the motor alone.
                let of_motor = phase.load.as_deref().is_some_and(|load| load.benches[0].knows(name, None));
                let own = phase.sets.iter().any(|(set, _)| set == name) || (phase.rest && !of_motor);
                let Some(load) = phase.load.as_deref_mut().filter(|_| !own) else { continue };
                match load.set_text(name, text) {
                    Ok(()) => taken = Ok(()),
                    Err(error) if taken.is_err() => taken = Err(Some(error)),
                    Err(_) => {}
                }
            }
            return taken.map_err(|error| {
                error.unwrap_or_else(|| StudyError::new(format!("every phase of the mix has its own {name}")))
            });
        }
        if let (Some((_, drive)), Some(setting)) = (&mut self.cycle, Setting::named(name)) {
            return setting.set(drive, text).map_err(StudyError::new);
        }
        if let Some(instead) = self.at_joint.as_ref().and_then(|_| without_effect(name)) {
            return Err(StudyError::new(format!(
                "{name} has no effect with a [cycle] at the joint{instead}"
            )));
        }
        let place =
            self.benches.iter().position(|b| b.knows(name, None)).ok_or_else(|| self.unknown(name))?;
        if self.cycle.is_some() && place != 0 {
            return Err(StudyError::new(format!(
                "{name} has no effect: the load has a [cycle] and no actuator or gait"
            )));
        }
        self.benches[place].set_text(name, text)?;
        self.explicit.insert(name.to_owned());
        Ok(())
    }

    /// The values of the actuator that follow from its motor.
    ///
    /// # Errors
    /// None with declared names.
    pub fn derived(&self) -> Result<Vec<Derived>, StudyError> {
        if let Some(mix) = &self.mix {
            let gait = mix.phases.iter().filter_map(|p| p.load.as_deref()).find(|load| load.cycle.is_none());
            return gait.map_or(Ok(Vec::new()), Load::derived);
        }
        if self.cycle.is_some() {
            return Ok(Vec::new());
        }
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

    /// The load table of a cycle, for an FMU, with file and columns, and the gear and supply that are not part of it.
    pub fn table(&self) -> Option<(LoadTable, &str, Drive)> {
        match (&self.cycle, &self.at_joint) {
            (Some((cycle, drive)), _) => Some((cycle.table(drive.scale), &cycle.source, *drive)),
            (None, Some(cycle)) => Some((cycle.table(1.0), &cycle.source, Drive::default())),
            (None, None) => None,
        }
    }

    /// The three models with the derived values.
    pub(super) fn prepared(&self) -> Result<[Bench; 3], StudyError> {
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
        if let Some(mix) = &self.mix {
            let parts = mix.phases.iter().map(|phase| {
                let source = match &phase.load {
                    Some(load) if !phase.rest => load.source()?,
                    _ => "rest".to_owned(),
                };
                Ok(format!("{} %: {source}", 100.0 * phase.fraction))
            });
            return Ok(parts.collect::<Result<Vec<_>, StudyError>>()?.join("; "));
        }
        if let Some(cycle) = self.cycle.as_ref().map(|(cycle, _)| cycle).or(self.at_joint.as_ref()) {
            return Ok(cycle.source.clone());
        }
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
        if let Some(part) = self.mix.as_ref().and_then(|_| self.parts().first().copied()) {
            return part.get(name);
        }
        if let Some((setting, drive)) = self.setting(name) {
            return Ok(setting.get(drive));
        }
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
        if let Some(mix) = &self.mix {
            let walkers = mix.phases.iter().map(|phase: &Phase<Load>| {
                let load = phase.load.as_deref().unwrap_or(self);
                Ok((phase.fraction, if phase.rest { load.resting()? } else { load.walker()? }))
            });
            return Ok(Walker::new(Mix::start(walkers.collect::<Result<_, StudyError>>()?, mix.period)?));
        }
        let [motor, actuator, gait] = self.prepared()?;
        Ok(match &self.cycle {
            Some((cycle, drive)) => Walker::new(Shaft::start(motor, Arc::clone(cycle), *drive)?),
            None => Walker::new(Coupled::start(motor, actuator, gait)?),
        })
    }

    /// The motor without current at standstill.
    fn resting(&self) -> Result<Walker, StudyError> {
        let [motor, ..] = self.prepared()?;
        Ok(Walker::new(Shaft::start(motor, Arc::new(Cycle::rest(REST)), Drive::default())?))
    }

    /// Mass of motor, fan and tube, kg.
    ///
    /// # Errors
    /// A motor that does not start.
    pub fn mass(&self) -> Result<f64, StudyError> {
        let part = self.parts().first().copied().unwrap_or(self);
        let mut held = part.benches[0].clone();
        held.set_text("drive_mode", "current")?;
        held.set_text("mechanical_mode", "imposed_speed")?;
        held.set("current_command", 1.0)?;
        held.start()?;
        Ok(held.get("shaft_torque")? / held.get("torque_density")?)
    }
}
