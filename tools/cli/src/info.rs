//! `motor-fmu info`: properties of an FMU or a preset.

use crate::variables::{Row, Subject, short};
use crate::{Failure, say, say_json};
use archive::build::{EFFECTS_FILE, LOAD_FILE, LoadFile, TermsFile};
use cosim::Archive;
use describe::{Preset, models};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;

/// Show model, standard, interface types, changed start values and sources of an FMU or a preset
#[derive(clap::Args)]
pub struct Args {
    /// FMU, file or name of a preset, or name of a model
    #[arg(value_name = "FILE|PRESET|MODEL")]
    of: String,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// A start value that differs from the declared one.
#[derive(Serialize)]
struct Changed {
    name: String,
    start: String,
    default: String,
    unit: String,
    /// The comment beside the value in a preset.
    source: Option<String>,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let subject = Subject::find(&args.of)?;
    let rows = subject.rows()?;
    let (facts, changed) = match &subject {
        Subject::Model(kind) => {
            let declaration = (kind.declaration)();
            (vec![fact("model", declaration.name), fact("description", declaration.description)], Vec::new())
        }
        Subject::Preset(preset, path) => preset_facts(preset, path.as_deref(), &rows)?,
        Subject::Fmu(archive) => fmu_facts(archive, &rows)?,
    };
    let mut facts = facts;
    facts.push(("variables", json!(counts(&rows))));
    if args.json {
        let mut result: serde_json::Map<String, Value> =
            facts.into_iter().map(|(name, value)| (name.replace([' ', '-'], "_"), value)).collect();
        result.insert("start_values".to_owned(), json!(changed));
        say_json(&result)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = String::new();
    for (name, value) in facts {
        let value = match value {
            Value::String(text) => text,
            Value::Array(items) => items.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(", "),
            other => other.to_string(),
        };
        if !value.is_empty() {
            text += &format!("{name:18} {value}\n");
        }
    }
    if !changed.is_empty() {
        text += "start values that differ from the model's defaults\n";
        let width = changed.iter().map(|c| c.name.len()).max().unwrap_or(0);
        for c in &changed {
            let unit =
                if c.unit.is_empty() || c.unit == "1" { String::new() } else { format!(" {}", c.unit) };
            let value = format!("{}{unit}", short(&c.start));
            let source = c.source.as_ref().map_or(String::new(), |s| format!("; {s}"));
            text += &format!("  {:width$}  {value:20} (default {}{source})\n", c.name, short(&c.default));
        }
    }
    say(&text);
    Ok(ExitCode::SUCCESS)
}

type Fact = (&'static str, Value);

fn fact(name: &'static str, text: &str) -> Fact {
    (name, json!(text.trim()))
}

/// How many variables of each causality.
fn counts(rows: &[Row]) -> Vec<String> {
    let mut found: Vec<(&str, usize)> = Vec::new();
    for row in rows {
        match found.iter_mut().find(|(known, _)| *known == row.causality) {
            Some((_, count)) => *count += 1,
            None => found.push((&row.causality, 1)),
        }
    }
    found.iter().map(|(causality, count)| format!("{count} {causality}")).collect()
}

fn preset_facts(
    preset: &Preset,
    path: Option<&Path>,
    rows: &[Row],
) -> Result<(Vec<Fact>, Vec<Changed>), Failure> {
    let text = match path {
        Some(path) => delimited::read_text(path)?,
        None => Preset::text(&preset.name).unwrap_or_default().to_owned(),
    };
    let mut changed = differing(&preset.model, rows);
    for value in &mut changed {
        value.source = preset.source_of(&value.name);
    }
    let facts = vec![
        fact("preset", &preset.name),
        fact("model", &preset.model),
        fact("description", &preset.description),
        fact("source", &head(&text)),
    ];
    Ok((facts, changed))
}

/// The comment at the head of a file, up to its end or to the word about the values' comments.
fn head(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix('#').map(str::trim));
    lines.take_while(|line| !line.starts_with("Each comment")).collect::<Vec<_>>().join(" ")
}

/// The rows whose start value is not the declared one of the model.
fn differing(model: &str, rows: &[Row]) -> Vec<Changed> {
    let Some(kind) = models::by_name(model) else { return Vec::new() };
    let Ok(declared) = Subject::Model(kind).rows() else { return Vec::new() };
    let same =
        |a: &str, b: &str| a == b || matches!((a.parse::<f64>(), b.parse::<f64>()), (Ok(a), Ok(b)) if a == b);
    let of = |row: &Row| {
        let default = declared.iter().find(|d| d.name == row.name)?.start.clone()?;
        let start = row.start.clone().filter(|start| !same(start, &default))?;
        Some(Changed { name: row.name.clone(), start, default, unit: row.unit.clone(), source: None })
    };
    rows.iter().filter_map(of).collect()
}

fn fmu_facts(archive: &Archive, rows: &[Row]) -> Result<(Vec<Fact>, Vec<Changed>), Failure> {
    let description = archive.description();
    let interfaces: Vec<String> = description.interfaces.iter().map(|i| i.kind.to_string()).collect();
    let experiment = description.default_experiment;
    let times = [("start", experiment.start), ("stop", experiment.stop), ("step", experiment.step)];
    let times: Vec<String> =
        times.iter().filter_map(|(name, time)| time.map(|time| format!("{name} {time} s"))).collect();
    let mut facts = vec![
        fact("model", &description.model_name),
        fact("description", description.description.as_deref().unwrap_or_default()),
        fact("standard", &format!("FMI {}", description.fmi_version)),
        ("interface types", json!(interfaces)),
        ("platforms", json!(archive.platforms())),
        fact("generated by", description.generation_tool.as_deref().unwrap_or_default()),
        ("default experiment", json!(times)),
    ];
    let ours = models::by_token(&description.token);
    let mut changed = Vec::new();
    if let Some(kind) = ours {
        let declaration = (kind.declaration)();
        changed = differing(declaration.name, rows);
        let like: Vec<String> = Preset::built_in()?
            .into_iter()
            .filter(|p| is_like(p, declaration.name, rows))
            .map(|p| p.name)
            .collect();
        if !like.is_empty() {
            facts.push(("built with preset", json!(like)));
        }
        let file = |name: &str| archive.dir().join("resources").join(name);
        if let Ok(terms) = TermsFile::load(&file(EFFECTS_FILE)).and_then(|file| file.terms()) {
            facts.push(("terms from data", json!(terms.len())));
        }
        if let Ok(load) = LoadFile::load(&file(LOAD_FILE)) {
            let text = format!("{} rows, period {} s, from {}", load.rows.len(), load.period, load.source);
            facts.push(("load table", json!(text)));
        }
    }
    Ok((facts, changed))
}

/// Whether the start values are those of a preset.
fn is_like(preset: &Preset, model: &str, rows: &[Row]) -> bool {
    let Some(kind) = models::by_name(model) else { return false };
    let declaration = (kind.declaration)();
    preset.model == model
        && declaration.entries.iter().filter(|e| e.is_settable()).all(|entry| {
            let start = rows.iter().find(|r| r.name == entry.name).and_then(|r| r.start.as_deref());
            let value = start.and_then(|text| describe::preset::from_text(entry, text, false).ok());
            value.is_none_or(|value| value == preset.starts.of(entry))
        })
}
