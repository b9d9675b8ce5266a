//! `motor-fmu variables`: the variables of a model, a preset or an FMU.

use crate::pattern::Patterns;
use crate::{Failure, say, say_json};
use cosim::{Archive, ModelDescription};
use describe::preset::nearest;
use describe::{
    Causality, Entry, Experiment, Kind, ModelType, Preset, Resources, StartValues, experiment, models,
};
use present::number;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// List the variables of a model, a preset or any FMU
///
/// Name, causality, type, unit, start value, limits and description; enumerations with the numbers of their items, which some importers
/// need. Start values are those of an FMU of the model or the preset, with the commands of its default experiment. Units are those of the FMI interface (SI).
#[derive(clap::Args)]
pub struct Args {
    /// Name of a model, name or file of a preset, or FMU
    #[arg(value_name = "MODEL|PRESET|FILE")]
    of: String,
    /// Names or patterns with * and ?; all if none is given
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Only this causality: input, output, parameter, local, ...
    #[arg(long, value_name = "CAUSALITY")]
    causality: Option<String>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// A variable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub name: String,
    pub causality: String,
    pub variability: String,
    #[serde(rename = "type")]
    pub kind: String,
    pub unit: String,
    /// As text: a number, an item, true or false.
    pub start: Option<String>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub description: String,
    /// Items of an enumeration and their numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub items: Vec<Item>,
}

/// An item of an enumeration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Item {
    pub name: String,
    pub value: i64,
}

/// What a name or a file means.
pub enum Subject {
    /// A model at its default start values.
    Model(&'static ModelType),
    /// A preset, built in or from this file.
    Preset(Preset, Option<PathBuf>),
    /// An FMU.
    Fmu(Box<Archive>),
}

impl Subject {
    /// The model, the preset or the FMU of a name or a file.
    pub fn find(text: &str) -> Result<Subject, Failure> {
        if let Some(kind) = models::by_name(text) {
            return Ok(Subject::Model(kind));
        }
        let path = Path::new(text);
        if path.is_file() {
            // An archive begins with the signature of zip, whatever its name.
            let mut start = [0u8; 2];
            let zip = std::fs::File::open(path)
                .and_then(|mut file| std::io::Read::read_exact(&mut file, &mut start))
                .is_ok_and(|()| &start == b"PK");
            return match zip || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("fmu")) {
                true => Ok(Subject::Fmu(Box::new(Archive::open(path)?))),
                false => Ok(Subject::Preset(Preset::load(text)?, Some(path.to_owned()))),
            };
        }
        let presets = Preset::built_in()?;
        if let Some(preset) = presets.iter().find(|p| p.name == text) {
            return Ok(Subject::Preset(preset.clone(), None));
        }
        let known =
            models::ALL.iter().map(|m| (m.declaration)().name).chain(presets.iter().map(|p| p.name.as_str()));
        Err(Failure::new(format!(
            "{text} is neither a model nor a built-in preset nor a readable file{}",
            nearest(text, known)
        )))
    }

    /// Its variables.
    pub fn rows(&self) -> Result<Vec<Row>, Failure> {
        Ok(match self {
            Subject::Model(kind) => declared(kind, &StartValues::default(), None),
            Subject::Preset(preset, _) => {
                let kind = models::by_name(&preset.model).ok_or_else(|| {
                    Failure::new(format!("preset {}: no model {}", preset.name, preset.model))
                })?;
                declared(kind, &preset.starts, preset.experiment)
            }
            Subject::Fmu(archive) => described(archive.description()),
        })
    }
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut rows = Subject::find(&args.of)?.rows()?;
    if let Some(causality) = &args.causality {
        let mut known: Vec<&str> = rows.iter().map(|r| r.causality.as_str()).collect();
        known.dedup();
        if !known.contains(&causality.as_str()) {
            known.sort_unstable();
            known.dedup();
            return Err(Failure::new(format!(
                "--causality {causality}: {} has {}",
                args.of,
                known.join(", ")
            )));
        }
        rows.retain(|r| r.causality == *causality);
    }
    if !args.names.is_empty() {
        let names: Vec<&str> = rows.iter().map(|r| r.name.as_str()).collect();
        let chosen = Patterns::new(&args.names)
            .choose(&names, &|_| None)
            .map_err(|e| Failure::new(format!("{}: {e}", args.of)))?;
        let chosen: Vec<String> = chosen.into_iter().map(|k| rows[k].name.clone()).collect();
        rows.retain(|r| chosen.contains(&r.name));
    }
    if args.json {
        say_json(&rows)?;
    } else {
        say(&table(&rows));
    }
    Ok(ExitCode::SUCCESS)
}

/// Columns of equal width; the description is the last.
fn table(rows: &[Row]) -> String {
    let limits = |r: &Row| match (r.min, r.max) {
        _ if !r.items.is_empty() => {
            r.items.iter().map(|i| format!("{} = {}", i.value, i.name)).collect::<Vec<_>>().join(", ")
        }
        (Some(min), Some(max)) => format!("{min} ... {max}"),
        (Some(min), None) => format!("{min} ..."),
        (None, Some(max)) => format!("... {max}"),
        (None, None) => String::new(),
    };
    let start = |r: &Row| r.start.as_deref().map_or(String::new(), exact);
    let cells: Vec<[String; 5]> =
        std::iter::once(["name", "causality", "start", "unit", "limits or items"].map(str::to_owned))
            .chain(rows.iter().map(|r| {
                let unit = if r.unit == "1" { String::new() } else { r.unit.clone() };
                [r.name.clone(), r.causality.clone(), start(r), unit, limits(r)]
            }))
            .collect();
    let widths: [usize; 5] =
        std::array::from_fn(|k| cells.iter().map(|c| c[k].chars().count()).max().unwrap_or(0).min(44));
    let mut text = String::new();
    let descriptions = std::iter::once("description").chain(rows.iter().map(|r| r.description.as_str()));
    for (cells, description) in cells.iter().zip(descriptions) {
        for (cell, width) in cells.iter().zip(widths) {
            text += &format!("{cell:width$}  ");
        }
        text += description;
        text.push('\n');
    }
    text
}

/// A start value with the fewest digits that are read as the same number, because a user copies it; words as they are.
fn exact(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(number) if number != 0.0 && !(1e-4..1e7).contains(&number.abs()) => format!("{number:e}"),
        Ok(number) => number.to_string(),
        Err(_) => text.to_owned(),
    }
}

/// A start value with four digits; words as they are.
pub fn short(text: &str) -> String {
    text.parse::<f64>().map_or_else(|_| text.to_owned(), number)
}

/// The variables of the archive that `build` makes of these start values, with the commands of its default experiment.
fn declared(kind: &ModelType, starts: &StartValues, given: Option<Experiment>) -> Vec<Row> {
    let declaration = (kind.declaration)();
    let (starts, _) = &experiment::of(kind, starts, &Resources::default(), given);
    let shown = declaration.entries.iter().filter(|e| starts.shows(declaration, e));
    shown.map(|entry| row(entry, starts)).collect()
}

fn row(entry: &Entry, starts: &StartValues) -> Row {
    let row = entry.row;
    let value = starts.of(entry);
    let (kind, start, items) = match row.kind {
        Kind::Real => ("real", value.to_string(), Vec::new()),
        Kind::Integer => ("integer", value.to_string(), Vec::new()),
        Kind::Boolean => ("boolean", (value != 0.0).to_string(), Vec::new()),
        Kind::Enumeration(t) => {
            let name = t.items.iter().find(|i| f64::from(i.value) == value).map(|i| i.name.to_owned());
            let items = t.items.iter().map(|i| Item { name: i.name.to_owned(), value: i.value.into() });
            ("enumeration", name.unwrap_or_default(), items.collect())
        }
    };
    let causality = match row.causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    };
    let limit = |x: f64| Some(x).filter(|x| x.is_finite() && items.is_empty());
    Row {
        name: entry.name.clone(),
        causality: causality.to_owned(),
        variability: format!("{:?}", row.variability).to_lowercase(),
        kind: kind.to_owned(),
        unit: if row.kind == Kind::Real { row.unit.name().to_owned() } else { String::new() },
        start: (entry.is_settable() && value.is_finite()).then_some(start),
        min: limit(row.min),
        max: limit(row.max),
        description: row.doc.split_whitespace().collect::<Vec<_>>().join(" "),
        items,
    }
}

fn described(description: &ModelDescription) -> Vec<Row> {
    let of = |v: &cosim::Variable| {
        let items: Vec<Item> = description
            .enumeration(v)
            .map(|e| e.items.iter().map(|i| Item { name: i.name.clone(), value: i.value }).collect())
            .unwrap_or_default();
        // The XML has the number of an item; the name is what a person looks for.
        let item =
            |text: &String| items.iter().find(|i| i.value.to_string() == *text).map(|i| i.name.clone());
        Row {
            name: v.name.clone(),
            causality: v.causality.to_string(),
            variability: v.variability.to_string(),
            kind: format!("{:?}", v.kind).to_lowercase(),
            unit: v.unit.clone().unwrap_or_default(),
            start: v.start.as_ref().map(|text| item(text).unwrap_or_else(|| text.clone())),
            min: v.min,
            max: v.max,
            description: v.description.clone().unwrap_or_default(),
            items,
        }
    };
    description.variables.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_values_are_exact() {
        for (start, text) in [
            ("428.15", "428.15"),
            ("101325", "101325"),
            ("0", "0"),
            ("-0.00983", "-0.00983"),
            ("0.0000000123456", "1.23456e-8"),
            ("true", "true"),
            ("voltage", "voltage"),
        ] {
            assert_eq!(exact(start), text);
        }
        let motor = &models::ALL[0];
        let rows = declared(motor, &StartValues::default(), None);
        let limit = table(&rows);
        let limit = limit.lines().find(|line| line.starts_with("thermal.T_w_max ")).unwrap();
        assert!(limit.contains(" 428.15 "), "{limit}");
    }
}
