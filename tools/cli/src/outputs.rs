//! Which outputs of a run are printed, written and drawn, and in which units.

use crate::Failure;
use crate::existing::is_stdout;
use crate::pattern::Patterns;
use clap::ValueEnum;
use cosim::{Column, Limit, ModelDescription, Recording, System};
use describe::{models, plots};
use std::path::Path;

/// A limit that is recorded with the run: variable, output, label, whether it holds in both directions.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Name of the recorded variable.
    pub variable: String,
    limit: plots::Limit,
    output: String,
}

/// The main outputs of an FMU of ours, and the limits of its outputs; names after `prefix`.
pub fn of_model(prefix: &str, description: &ModelDescription) -> Option<(Vec<String>, Vec<Recorded>)> {
    let ours = (models::by_token(&description.token)?.declaration)();
    let main = plots::main_outputs(ours.name).iter().map(|name| format!("{prefix}{name}"));
    let limits = plots::LIMITS
        .iter()
        .filter(|limit| ours.by_name(limit.variable).is_some() && ours.by_name(limit.output).is_some());
    let recorded = |limit: &plots::Limit| Recorded {
        variable: format!("{prefix}{}", limit.variable),
        limit: *limit,
        output: format!("{prefix}{}", limit.output),
    };
    Some((main.collect(), limits.map(recorded).collect()))
}

/// The same for all components of a system; no main outputs where an FMU is not ours.
pub fn of_system(system: &System) -> (Vec<String>, Vec<Recorded>) {
    let (mut main, mut limits, mut all_ours) = (Vec::new(), Vec::new(), true);
    for (name, description) in system.descriptions() {
        match of_model(&format!("{name}."), description) {
            Some((outputs, recorded)) => {
                main.extend(outputs);
                limits.extend(recorded);
            }
            None => all_ours = false,
        }
    }
    (if all_ours { main } else { Vec::new() }, limits)
}

/// Takes the recorded limits out of the recording, but for variables that the user records.
pub fn take_limits(recording: &mut Recording, limits: &[Recorded], kept: &[String]) -> Vec<Limit> {
    let mut found = Vec::new();
    for Recorded { variable, limit, output } in limits {
        let Some(column) = recording.column(variable).cloned() else { continue };
        if !kept.contains(variable) {
            recording.columns.retain(|c| c.name != *variable);
        }
        let mut opposite = column.clone();
        opposite.values.iter_mut().for_each(|value| *value = -*value);
        let line = |column, label: &str| Limit { of: output.clone(), label: label.to_owned(), column };
        found.push(line(column, limit.label));
        if limit.both_signs {
            found.push(line(opposite, limit.label));
        }
    }
    found
}

/// Options of `simulate` and `cosim`.
#[derive(Clone, Debug, clap::Args)]
pub struct Shown {
    /// Outputs to print, write and draw: names, or patterns with * and ?, separated by commas [default: all]
    #[arg(long, value_name = "NAME,...")]
    outputs: Vec<String>,
    /// Units of numbers in and out. si: the units of the FMU's interface (kelvin, rad/s) everywhere. datasheet: its display units (degC,
    /// rpm) everywhere, also for numbers of --set and columns of --input without unit; the CSV header names them. By default the printed values are in
    /// display units, everything else is in the units of the interface
    #[arg(long, value_enum)]
    units: Option<Units>,
}

/// A choice of units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Units {
    /// Units of the interface
    Si,
    /// Display units
    Datasheet,
}

impl Shown {
    /// Whether numbers without a unit are in display units.
    pub fn has_display_units(&self) -> bool {
        self.units == Some(Units::Datasheet)
    }

    /// Leaves the chosen outputs, in the order of the choice, in the chosen units. `why` explains a variable that is not recorded.
    pub fn apply(
        &self,
        recording: &mut Recording,
        why: &dyn Fn(&str) -> Option<String>,
    ) -> Result<(), Failure> {
        if !self.outputs.is_empty() {
            let names: Vec<&str> = recording.columns.iter().map(|c| c.name.as_str()).collect();
            let chosen = Patterns::new(&self.outputs)
                .choose(&names, why)
                .map_err(|e| Failure::new(format!("--outputs: {e}")))?;
            recording.columns = chosen.into_iter().map(|k| recording.columns[k].clone()).collect();
        }
        recording.columns.iter_mut().for_each(|column| self.convert(column));
        Ok(())
    }

    /// The column in the chosen unit.
    fn convert(&self, column: &mut Column) {
        match (self.units, column.display_unit.take()) {
            (None, display) => column.display_unit = display,
            (Some(Units::Datasheet), Some(display)) => {
                column.values.iter_mut().for_each(|value| *value = display.show(*value));
                column.unit = Some(display.name);
            }
            (Some(_), _) => {}
        }
    }

    /// The figure of a recording: the chosen outputs, else the main ones where they are known, else all.
    pub fn figure(
        &self,
        recording: &Recording,
        limits: &[Limit],
        main: &[String],
    ) -> Result<String, Failure> {
        let mut drawn = recording.clone();
        if self.outputs.is_empty() && !main.is_empty() {
            drawn.columns.retain(|column| main.contains(&column.name));
        }
        let limits: Vec<Limit> = limits.iter().cloned().map(|limit| self.converted(limit)).collect();
        Ok(drawn.svg(&limits)?)
    }

    /// A limit in the units of the recording.
    fn converted(&self, mut limit: Limit) -> Limit {
        self.convert(&mut limit.column);
        limit
    }

    /// Writes the table where it is wanted; gives it if that is the standard output.
    pub fn write(&self, recording: &Recording, path: Option<&Path>) -> Result<Option<String>, Failure> {
        match path {
            None => Ok(None),
            Some(path) if is_stdout(path) => Ok(Some(self.named(recording).csv())),
            Some(path) => Ok(self.named(recording).write_csv(path).map(|()| None)?),
        }
    }

    /// The recording with the units in the names of its columns, for a CSV file in display units.
    fn named(&self, recording: &Recording) -> Recording {
        let mut named = recording.clone();
        if self.has_display_units() {
            for column in &mut named.columns {
                if let Some(unit) = column.unit.as_deref().filter(|unit| *unit != "1") {
                    column.name = format!("{} [{unit}]", column.name);
                }
            }
        }
        named
    }

    /// Settings in the units of the interface: a number without a unit is in the chosen units.
    fn set(&self, name: &str, text: String, description: &ModelDescription) -> String {
        let variable = description.variable(name).filter(|v| v.kind.is_float() && self.has_display_units());
        let display = variable.and_then(|variable| description.display_unit(variable));
        match (display, units::split(&text)) {
            (Some(display), Some((number, ""))) => display.back(number).to_string(),
            _ => text,
        }
    }

    /// Settings of an FMU.
    pub fn sets(&self, sets: Vec<(String, String)>, description: &ModelDescription) -> Vec<(String, String)> {
        let convert = |(name, text): (String, String)| {
            let text = self.set(&name, text, description);
            (name, text)
        };
        sets.into_iter().map(convert).collect()
    }
}

/// Every n-th row of a recording, with the first and the last.
pub fn thin(recording: &mut Recording, every: usize) {
    let rows = recording.times.len();
    let kept: Vec<usize> = (0..rows).filter(|k| k % every == 0 || k + 1 == rows).collect();
    let pick = |values: &[f64]| kept.iter().map(|k| values[*k]).collect();
    recording.times = pick(&recording.times);
    for column in &mut recording.columns {
        column.values = pick(&column.values);
        if !column.exact.is_empty() {
            column.exact = kept.iter().map(|k| column.exact[*k]).collect();
        }
    }
}
