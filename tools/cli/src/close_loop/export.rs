//! Export: the calibrated preset, the terms, and the FMUs of both standards with them.

use crate::{Failure, write};
use archive::build::{Contents, Library, Standard, TermText, TermsFile, build_all, library_path};
use archive::validate::{Severity, validate};
use calibrate::experiment::Experiment;
use calibrate::outcome::{Outcome, Setting};
use calibrate::report::Provenance;
use describe::preset::CALIBRATION;
use describe::{Declaration, Entry, Kind, ModelType, Preset, models};
use std::fmt::Write as _;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread;

/// The beginning of a calibrated preset.
pub const HEADER: &str = "# Calibrated by motor-fmu close-loop:";

pub struct Exported {
    pub kind: &'static ModelType,
    /// The FMU library that the archives are made with.
    pub library: PathBuf,
    pub preset: Preset,
    /// The archives with their standards.
    pub archives: Vec<(Standard, PathBuf)>,
    /// Their names relative to the folder.
    pub names: Vec<String>,
}

impl Exported {
    /// Errors that the validator finds in the archives, in sentences.
    pub fn findings(&self) -> Result<Vec<String>, Failure> {
        let program = crate::program()?;
        let wrong = |(name, (_, path)): (&String, &(Standard, PathBuf))| -> Result<Vec<String>, Failure> {
            let wrong = validate(path, &program)?.into_iter().filter(|f| f.severity == Severity::Error);
            Ok(wrong.map(|f| format!("{name}: {}: {}", f.place, f.message)).collect())
        };
        // Threads that wait for the validator's own processes.
        thread::scope(|scope| {
            let archives = self.names.iter().zip(&self.archives);
            let waiting: Vec<_> = archives.map(|archive| scope.spawn(move || wrong(archive))).collect();
            let all = waiting.into_iter().map(|thread| thread.join().unwrap_or_else(|e| resume_unwind(e)));
            all.collect::<Result<Vec<_>, _>>().map(|all| all.concat())
        })
    }
}

/// Writes preset.toml, effects.json where there are terms, and the archives.
pub fn export(
    experiment: &Experiment,
    outcome: &Outcome,
    made_of: &Provenance,
    out: &Path,
) -> Result<Exported, Failure> {
    let kind = models::by_name(outcome.model)
        .ok_or_else(|| Failure::new(format!("unknown model {}", outcome.model)))?;
    let file = out.join("preset.toml");
    write(&file, &preset_text(experiment, outcome, made_of, (kind.declaration)()))?;
    let preset = Preset::load(&file.to_string_lossy())?;
    let effects = terms(outcome, &outcome.export)?;
    let path = out.join("effects.json");
    match &effects {
        Some(effects) => write(&path, &effects.text())?,
        // Of an earlier run, which had terms.
        None if path.is_file() => std::fs::remove_file(&path).map_err(|e| crate::unwritten(&path, &e))?,
        None => {}
    }
    let library = library_path()?;
    let contents = Contents { preset: Some(&preset), effects: effects.as_ref(), ..Contents::default() };
    let paths = build_all(kind, &Standard::ALL, contents, &[Library::here(&library)], out)?;
    let archives: Vec<(Standard, PathBuf)> = Standard::ALL.into_iter().zip(paths).collect();
    let name = |(standard, _): &(Standard, _)| format!("{}/{}.fmu", standard.folder(), outcome.model);
    let names: Vec<String> = archives.iter().map(name).collect();
    Ok(Exported { kind, library, preset, archives, names })
}

/// What the preset and the metadata of the archives say of their calibration: data, verdict, error of each output before and after.
fn calibration(experiment: &Experiment, outcome: &Outcome, made_of: &Provenance) -> String {
    let entry = |keyword: &str, value: &str| (keyword.to_owned(), value.replace('\n', " "));
    let mut entries = vec![
        entry("experiment", &outcome.name),
        entry("program", &made_of.program),
        entry("SHA-256 of the data", &made_of.data_sha256),
        entry("preset before", &experiment.preset),
        entry("verdict", outcome.verdict.name()),
    ];
    entries.extend(outcome.effects.iter().map(|effect| entry("effect", &effect.id)));
    entries.extend(outcome.errors.iter().map(|e| {
        let [before, refit, after, floor] = [e.before, e.refit, e.after, e.floor].map(super::text::number);
        let keyword = format!("RMSE of {} ({})", e.column, calibrate::report::role_name(e.role));
        (keyword, format!("{after}; before {before}, after a fit of the parameters {refit}, noise {floor}"))
    }));
    entries.iter().map(|(keyword, value)| format!("{CALIBRATION}{keyword}: {value}\n")).collect()
}

/// The terms of a setting as a file; `None` where it has none.
pub fn terms(outcome: &Outcome, setting: &Setting) -> Result<Option<TermsFile>, Failure> {
    if setting.terms.is_empty() {
        return Ok(None);
    }
    let found: Vec<_> = outcome.effects.iter().filter_map(|e| e.term.as_ref().map(|t| (e, t))).collect();
    let text = |term| {
        let name = found.iter().find(|(_, t)| *t == term).map_or("unexplained", |(e, _)| e.id.as_str());
        TermText::of(name, term)
    };
    let file = TermsFile::new(setting.terms.iter().map(text).collect());
    file.terms()?;
    Ok(Some(file))
}

/// The values of the repaired model as a preset, each with where it is from.
fn preset_text(
    experiment: &Experiment,
    outcome: &Outcome,
    made_of: &Provenance,
    declaration: &Declaration,
) -> String {
    // JSON and TOML write a text between quotes in the same way.
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let name = &outcome.name;
    let mut text = format!(
        "{HEADER} the preset {} and the experiment {name}, as in {}.\n\
         name = {}\nmodel = {}\ndescription = {}\n\n{}\n[start]\n",
        experiment.preset.replace('\n', " "),
        outcome.export.file.replace('\n', " "),
        quoted(name),
        quoted(outcome.model),
        quoted(&format!(
            "{} after the experiment {name}; verdict: {}",
            experiment.preset,
            outcome.verdict.name()
        )),
        calibration(experiment, outcome, made_of)
    );
    for (name, value) in &outcome.export.values {
        let Some(entry) = declaration.by_name(name) else { continue };
        let _ = writeln!(
            text,
            "{} = {}  # {}",
            quoted(name),
            value_text(entry, *value),
            source(experiment, outcome, name)
        );
    }
    text
}

/// A value as a preset has it: enumerations by name, reals with their unit.
fn value_text(entry: &Entry, value: f64) -> String {
    match entry.row.kind {
        Kind::Enumeration(table) => {
            let item = table.items.iter().find(|i| f64::from(i.value) == value);
            item.map_or(format!("{value}"), |i| format!("\"{}\"", i.name))
        }
        Kind::Integer => format!("{value}"),
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Real => format!("{{ value = {value:?}, unit = \"{}\" }}", entry.row.unit.name()),
    }
}

/// The source of a value.
fn source(experiment: &Experiment, outcome: &Outcome, name: &str) -> String {
    let interval = |(low, high): (f64, f64)| {
        format!("95 % {} ... {}", super::text::number(low), super::text::number(high))
    };
    if let Some(p) = outcome.parameters.iter().find(|p| p.name == name) {
        return format!("fitted: {} before, {}", super::text::number(p.prior), interval(p.ci95));
    }
    if let Some((id, symbol)) = name.strip_prefix("effect.").and_then(|n| n.split_once('.'))
        && let Some(found) = outcome.effects.iter().find(|e| e.id == id)
    {
        let size = found.parameters.iter().find(|p| p.name == symbol);
        return size.map_or("part of the effect that was found".to_owned(), |p| {
            format!("found: {}", interval(p.ci95))
        });
    }
    if experiment.set.iter().any(|(n, _)| n == name) {
        return "from the experiment".to_owned();
    }
    "from the preset".to_owned()
}
