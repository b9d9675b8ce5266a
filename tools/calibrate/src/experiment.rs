//! An experiment: `EXPERIMENT.toml` and the runs that it lists.

mod channel;
mod clock;
mod columns;
mod copied_rows;
mod drive;
mod settings;
mod shared_rows;
mod stamp;
mod table;
pub mod units;

pub use channel::{CELSIUS, CHANNELS, Channel};
pub(crate) use stamp::LONGEST_RUN;
pub use table::Table;

use crate::CalibrateError;
use physics::model::{Declaration, ModelType};
use serde::Deserialize;
use settings::{parameter, settings};
use std::collections::BTreeMap;
use std::path::Path;
use toml::{Spanned, Value};

/// The column of the ambient temperature.
const AMBIENT: &str = "ambient_temperature_degC";

/// Role of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters and terms are fitted to this run.
    Fit,
    /// Held-out run: a term is accepted only if the validation error decreases.
    Validate,
    /// Held-out run that is evaluated once, after the search.
    Test,
}

/// Initial temperatures of the nodes of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// Ambient temperature of the first row.
    #[default]
    Ambient,
    /// Measured temperatures of the first row.
    Measured,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// File name as written in the experiment.
    pub file: String,
    /// Role of the run.
    pub role: Role,
    /// Start and end of the evaluated rows, s. The whole run is simulated.
    pub window: Option<(f64, f64)>,
    /// Initial temperatures of the nodes.
    pub start: Start,
    /// Start values of this run only: name and value.
    pub set: Vec<(String, f64)>,
    /// Priors of parameters that are unknown in this run only.
    pub priors: Vec<Prior>,
    /// Inputs, then outputs, in the order of the experiment.
    pub table: Table,
}

/// Prior of a parameter that may vary between specimens.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Its name.
    pub name: String,
    /// Standard deviation.
    pub deviation: Deviation,
}

/// A standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// Relative to the parameter's value, or to its nominal value if the value is 0.
    Relative(f64),
    /// In the parameter's unit.
    Absolute(f64),
}

impl Deviation {
    /// Standard deviation in the parameter's unit, for this value and nominal value.
    pub fn of(self, value: f64, nominal: f64) -> f64 {
        match self {
            Deviation::Relative(share) => (share * if value == 0.0 { nominal } else { value }).abs(),
            Deviation::Absolute(size) => size,
        }
    }
}

/// A prior in a file: a relative standard deviation, or one with a unit.
#[derive(Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "a relative standard deviation such as 0.1, or one with a unit such as \"0.5 K\""
)]
enum PriorText {
    Relative(f64),
    Absolute(String),
}

/// An experiment that has been read and checked.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Its name.
    pub name: String,
    /// The model's name.
    pub model: String,
    /// The preset, a name or a file; its values are the prior means.
    pub preset: String,
    /// Columns that drive the model.
    pub inputs: Vec<&'static Channel>,
    /// Columns that the model's outputs are compared with.
    pub outputs: Vec<&'static Channel>,
    /// Start values that differ from the preset: name and value. Modes implied by the inputs come first.
    pub set: Vec<(String, f64)>,
    /// Parameters that may be fitted.
    pub priors: Vec<Prior>,
    /// Those of them that the file does not mention: their values in the preset contradict the data.
    pub released: Vec<String>,
    /// Standard deviation of the noise of columns, in the column's unit, where the experiment declares it.
    pub noise: BTreeMap<&'static str, f64>,
    /// The runs.
    pub runs: Vec<Run>,
    /// The file without which the declared parameters describe all other fit and validation runs, if there is one.
    pub odd_file: Option<OddFile>,
    /// Warnings.
    pub notes: Vec<String>,
    /// Columns and their headers from `[columns]`.
    pub headers: Vec<(&'static str, String)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the tables of an experiment")]
struct Document {
    experiment: Head,
    #[serde(default)]
    columns: BTreeMap<Spanned<String>, Value>,
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
    #[serde(default)]
    prior: BTreeMap<Spanned<String>, PriorText>,
    #[serde(default)]
    noise: BTreeMap<Spanned<String>, f64>,
    run: Vec<Spanned<RunText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [experiment]")]
struct Head {
    name: String,
    model: Spanned<String>,
    preset: String,
    inputs: Vec<Spanned<String>>,
    outputs: Spanned<Vec<Spanned<String>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[run]]")]
struct RunText {
    file: String,
    role: Role,
    window_s: Option<(f64, f64)>,
    #[serde(default)]
    start: Start,
    #[serde(default)]
    prior: BTreeMap<Spanned<String>, PriorText>,
    #[serde(default)]
    not_measured: Vec<Spanned<String>>,
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
}

/// Formats an error message with file and line.
struct Place<'a> {
    file: String,
    text: &'a str,
}

impl Place<'_> {
    fn at(&self, offset: usize, message: &str) -> CalibrateError {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        CalibrateError(format!("{}:{line}: {message}", self.file))
    }
}

/// A file that disagrees with all others.
#[derive(Clone, Debug)]
pub struct OddFile {
    /// Its name.
    pub name: String,
    /// The warning that names it, dropped if the final model describes all runs.
    pub note: String,
}

impl Experiment {
    /// Whether it sets this variable, in all runs or in one.
    pub fn sets(&self, name: &str) -> bool {
        let of_runs = self.runs.iter().flat_map(|run| &run.set);
        self.set.iter().chain(of_runs).any(|(own, _)| own == name)
    }

    /// Reads an experiment and all of its runs; file names are relative to the experiment's folder.
    ///
    /// # Errors
    /// One sentence with file and line: a missing or unknown entry, an invalid number or a violated rule.
    pub fn read(path: &Path) -> Result<Experiment, CalibrateError> {
        let file = path.display().to_string();
        let text =
            delimited::read_text(path).map_err(|e| CalibrateError(format!("{file} cannot be read: {e}")))?;
        Experiment::parse(&text, file, delimited::folder(path))
    }

    /// Index of an output's column in the table of a run.
    pub fn place_of(&self, output: usize) -> usize {
        self.inputs.len() + output
    }

    /// The experiment without the runs of a file.
    pub fn without(&self, file: &str) -> Experiment {
        let mut other = self.clone();
        other.runs.retain(|run| run.file != file);
        other.odd_file = other.odd_file.filter(|odd| odd.name != file);
        other
    }

    /// The outputs that are temperatures.
    pub fn thermometers(&self) -> Vec<usize> {
        (0..self.outputs.len()).filter(|k| self.outputs[*k].is_temperature()).collect()
    }

    /// Readings of an output in a run, row by row; NaN where there is none.
    pub fn readings(&self, run: usize, output: usize) -> &[f64] {
        &self.runs[run].table.columns[self.place_of(output)]
    }

    /// Indices of the runs with a role.
    pub fn of_role(&self, role: Role) -> Vec<usize> {
        (0..self.runs.len()).filter(|r| self.runs[*r].role == role).collect()
    }

    fn parse(text: &str, file: String, folder: &Path) -> Result<Experiment, CalibrateError> {
        let place = Place { file, text };
        let document: Document = toml::from_str(text)
            .map_err(|e| place.at(e.span().map_or(0, |s| s.start), &e.message().replace('\n', " ")))?;
        let head = &document.experiment;
        let kind = model(&head.model, &place)?;
        let declaration = (kind.declaration)();
        let inputs =
            channels(&head.inputs, "input", Channel::inputs_of(declaration).collect(), declaration, &place)?;
        let (wanted, possible) = (head.outputs.get_ref(), Channel::outputs_of(declaration).collect());
        let outputs = channels(wanted, "output", possible, declaration, &place)?;
        if outputs.is_empty() {
            let start = head.outputs.span().start;
            return Err(place.at(start, "outputs is empty: it names the measured columns"));
        }
        // The model predicts temperature rises above ambient, so ambient has no default.
        if inputs.iter().all(|c| c.column != AMBIENT)
            && let Some(ambient) = Channel::inputs_of(declaration).find(|c| c.column == AMBIENT)
        {
            let message = format!(
                "{} is not among the inputs; measure it, or add a column with its value, since all temperatures rise above it",
                ambient.column
            );
            return Err(place.at(head.inputs.first().map_or(0, |i| i.span().start), &message));
        }
        let start = head.outputs.span().start;
        drive::check(&inputs, &outputs).map_err(|message| place.at(start, &message))?;
        let mapped = columns::read(&document.columns, &place)?;
        let mut set = drive::modes(&inputs, declaration);
        set.extend(settings(&document.set, &inputs, declaration, &place)?);
        let priors = priors_of(&document.prior, declaration, &place)?;
        let all: Vec<&'static Channel> = inputs.iter().chain(&outputs).copied().collect();
        let mut noise = BTreeMap::new();
        for (name, &deviation) in &document.noise {
            let channel = all.iter().find(|c| c.is_named(name.get_ref())).ok_or_else(|| {
                place.at(
                    name.span().start,
                    &format!("{} is no input or output of the experiment", name.get_ref()),
                )
            })?;
            if !(deviation >= 0.0 && deviation.is_finite()) {
                let message =
                    format!("the noise of {} is {deviation}; it must not be negative", channel.column);
                return Err(place.at(name.span().start, &message));
            }
            noise.insert(channel.column, deviation);
        }
        let mut runs = Vec::new();
        for run in &document.run {
            let start = run.span().start;
            let run = run.get_ref();
            if let Some((from, to)) = run.window_s.filter(|(from, to)| from >= to) {
                return Err(place.at(start, &format!("window_s = [{from}, {to}] is empty in {}", run.file)));
            }
            let path = folder.join(&run.file);
            let blank = not_measured(&run.not_measured, &all[inputs.len()..], &run.file, &place)?;
            let table = Table::read(&path, &all, inputs.len(), &mapped, &blank)?;
            let set = settings(&run.set, &inputs, declaration, &place)?;
            let own = priors_of(&run.prior, declaration, &place)?;
            for name in run.set.keys().chain(run.prior.keys()) {
                if priors.iter().any(|p| p.name == *name.get_ref()) {
                    let message = format!(
                        "{} has a prior in [prior], so it is one number for all runs, and cannot be set or fitted in {} alone",
                        name.get_ref(),
                        run.file
                    );
                    return Err(place.at(name.span().start, &message));
                }
            }
            let measured = |k: usize| table.columns[inputs.len() + k].iter().any(|v| v.is_finite());
            if run.start == Start::Measured
                && !outputs.iter().enumerate().any(|(k, c)| c.node().is_some() && measured(k))
            {
                let message = format!(
                    "{} is to start as measured, and no temperature of the motor is measured in it",
                    run.file
                );
                return Err(place.at(start, &message));
            }
            let (file, role, window, start) = (run.file.clone(), run.role, run.window_s, run.start);
            runs.push(Run { file, role, window, start, set, priors: own, table });
        }
        if !runs.iter().any(|r| r.role == Role::Fit) {
            return Err(CalibrateError(format!("{}: no run has role = \"fit\"", place.file)));
        }
        since_midnight(&mut runs);
        for (run, text) in runs.iter().zip(&document.run) {
            let time = &run.table.time;
            if let Some((from, to)) = run.window
                && !time.iter().any(|t| (from..=to).contains(t))
            {
                let (first, last) = (time[0], time[time.len() - 1]);
                let message = format!(
                    "window_s = [{from}, {to}] holds no row of {}, which runs from {first} s to {last} s",
                    run.file
                );
                return Err(place.at(text.span().start, &message));
            }
        }
        let mut notes: Vec<String> = Vec::new();
        for note in runs.iter().flat_map(|r| &r.table.notes) {
            // A file may appear in several roles; its note is reported once.
            if !notes.contains(note) {
                notes.push(note.clone());
            }
        }
        notes.extend(shared_rows::notes(inputs.len(), &runs));
        notes.extend(clock::notes(&inputs, &outputs, &runs));
        Ok(Experiment {
            name: head.name.clone(),
            model: declaration.name.to_string(),
            preset: head.preset.clone(),
            inputs,
            outputs,
            set,
            priors,
            released: Vec::new(),
            odd_file: None,
            noise,
            runs,
            notes,
            headers: mapped.into_iter().map(|c| (c.column, c.header)).collect(),
        })
    }
}

/// Converts dates to seconds since the midnight before the earliest date, one origin for all files.
fn since_midnight(runs: &mut [Run]) {
    let dated = || runs.iter().filter(|r| r.table.dated).map(|r| r.table.time[0]);
    let first = dated().fold(f64::INFINITY, f64::min);
    let midnight = (first / stamp::DAY).floor() * stamp::DAY;
    for run in runs.iter_mut().filter(|r| r.table.dated) {
        run.table.time.iter_mut().for_each(|t| *t -= midnight);
    }
}

fn model(name: &Spanned<String>, place: &Place) -> Result<&'static ModelType, CalibrateError> {
    physics::models::by_name(name.get_ref()).ok_or_else(|| {
        let known: Vec<&str> = physics::models::ALL.iter().map(|m| (m.declaration)().name).collect();
        place.at(name.span().start, &format!("{} is no model; there is {}", name.get_ref(), known.join(", ")))
    })
}

/// The channels of a list of columns; `possible` are those with a variable of the model in this role.
fn channels(
    columns: &[Spanned<String>],
    word: &str,
    possible: Vec<&'static Channel>,
    declaration: &Declaration,
    place: &Place,
) -> Result<Vec<&'static Channel>, CalibrateError> {
    let mut found: Vec<&'static Channel> = Vec::new();
    // A model has one input of each quantity, but the bench may have several sensors for one output.
    let further: Vec<&'static Channel> = if word == "output" { possible.clone() } else { Vec::new() };
    for column in columns {
        let name = column.get_ref();
        let first = possible.iter().find(|c| c.is_named(name)).copied();
        let channel = first.or_else(|| Channel::further(name, &further)).ok_or_else(|| {
            let all: Vec<&str> = possible.iter().map(|c| c.column).collect();
            let message = columns::other_unit(name, possible.iter().copied()).unwrap_or_else(|| {
                format!("{name} is no {word} of {}; there is {}", declaration.name, all.join(", "))
            });
            place.at(column.span().start, &message)
        })?;
        if found.contains(&channel) {
            return Err(place.at(column.span().start, &format!("{name} stands twice among the {word}s")));
        }
        found.push(channel);
    }
    Ok(found)
}

/// Reads a table of priors.
fn priors_of(
    table: &BTreeMap<Spanned<String>, PriorText>,
    declaration: &Declaration,
    place: &Place,
) -> Result<Vec<Prior>, CalibrateError> {
    let one = |(name, text): (&Spanned<String>, &PriorText)| {
        let entry = parameter(name, declaration, place)?;
        let wrong = |message: String| place.at(name.span().start, &message);
        let (deviation, size) = match text {
            PriorText::Relative(share) => (Deviation::Relative(*share), *share),
            PriorText::Absolute(text) => {
                let own = entry.row.unit.name();
                let (number, unit) = ::units::split(text).ok_or_else(|| {
                    let message = format!(
                        "the prior of {} is \"{text}\"; it is a relative standard deviation such as 0.1, or one with a unit such as \
                         \"0.1 {own}\"",
                        entry.name
                    );
                    wrong(message)
                })?;
                let way = ::units::conversion(unit, own, true);
                let way = way.map_err(|e| wrong(format!("the prior of {}: {e}", entry.name)))?;
                (Deviation::Absolute(way.of(number)), number)
            }
        };
        if !(size > 0.0 && size.is_finite()) {
            return Err(wrong(format!("the prior of {} is {size}; it must be above 0", entry.name)));
        }
        Ok(Prior { name: entry.name.clone(), deviation })
    };
    table.iter().map(one).collect()
}

/// The outputs that are not recorded in a file.
fn not_measured(
    names: &[Spanned<String>],
    outputs: &[&'static Channel],
    file: &str,
    place: &Place,
) -> Result<Vec<&'static str>, CalibrateError> {
    let one = |name: &Spanned<String>| {
        let found = outputs.iter().find(|c| c.is_named(name.get_ref()));
        found.map(|c| c.column).ok_or_else(|| {
            let known: Vec<&str> = outputs.iter().map(|c| c.column).collect();
            let message = format!(
                "not_measured of {file} names {}, which is no output of the experiment; there is {}",
                name.get_ref(),
                known.join(", ")
            );
            place.at(name.span().start, &message)
        })
    };
    names.iter().map(one).collect()
}

#[cfg(test)]
mod tests;
