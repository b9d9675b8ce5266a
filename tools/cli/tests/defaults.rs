//! One set of start values: the declarations, the archives of a plain `motor-fmu build`, parameters.md and the model that
//! `motor-fmu steady` starts from. Only the command of a drive differs in archives, for their default experiment.

use cosim::Archive;
use physics::declare::{Causality, Kind};
use physics::effects::Effects;
use physics::model::{Declaration, Entry};
use std::path::{Path, PathBuf};
use std::process::Command;
use study::steady::Setup;

fn declarations() -> impl Iterator<Item = &'static Declaration> {
    describe::models::ALL.iter().map(|kind| (kind.declaration)())
}

fn settable(declaration: &'static Declaration) -> impl Iterator<Item = &'static Entry> {
    declaration.entries.iter().filter(|entry| entry.is_settable())
}

/// Inputs that start the default experiment of an archive.
const COMMANDS: [&str; 3] = ["voltage", "duty", "torque_demand"];

/// The start value in an archive without preset: the declared one, but for commands.
fn start_of(declaration: &Declaration, entry: &Entry) -> f64 {
    if !COMMANDS.contains(&entry.name.as_str()) {
        return entry.row.start;
    }
    let kind = describe::models::by_name(declaration.name).unwrap();
    let none = describe::StartValues::default();
    describe::experiment::of(kind, &none, &describe::Resources::default(), None).0.of(entry)
}

/// The start value as parameters.md writes it.
fn written(declaration: &Declaration, entry: &Entry) -> String {
    let start = start_of(declaration, entry);
    match entry.row.kind {
        Kind::Enumeration(t) => {
            t.items.iter().find(|i| f64::from(i.value) == start).unwrap().name.to_string()
        }
        _ => start.to_string(),
    }
}

/// The archives of a build without a preset, below `folder`.
fn plain_build(folder: &Path) -> Vec<PathBuf> {
    let build =
        Command::new(env!("CARGO_BIN_EXE_motor-fmu")).args(["build", "--out"]).arg(folder).output().unwrap();
    let said = [&build.stdout[..], &build.stderr].concat();
    assert!(build.status.success(), "{}", String::from_utf8_lossy(&said));
    let archives = declarations().flat_map(|d| ["fmi2", "fmi3"].map(|s| (s, d.name)));
    archives.map(|(standard, name)| folder.join(standard).join(format!("{name}.fmu"))).collect()
}

#[test]
fn a_plain_build_has_the_declared_start_values() {
    let folder = tempfile::tempdir().unwrap();
    let archives = plain_build(folder.path());
    let both = declarations().flat_map(|d| [d, d]);
    for (path, declaration) in archives.iter().zip(both) {
        let archive = Archive::open(path).unwrap();
        let mut compared = 0;
        for entry in settable(declaration) {
            let variable = archive.description().variable(&entry.name).unwrap();
            let value = match variable.start.as_deref().unwrap() {
                "true" => 1.0,
                "false" => 0.0,
                number => number.parse::<f64>().unwrap(),
            };
            assert_eq!(value, start_of(declaration, entry), "{} in {}", entry.name, path.display());
            compared += 1;
        }
        assert!(compared > 10, "{}", path.display());
    }
}

#[test]
fn parameters_md_has_the_declared_start_values() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model-description");
    for declaration in declarations() {
        let text = std::fs::read_to_string(folder.join(declaration.name).join("parameters.md")).unwrap();
        for entry in settable(declaration) {
            let row = text.lines().find(|line| line.starts_with(&format!("| `{}` |", entry.name)));
            let cells: Vec<&str> = row.unwrap().split('|').map(str::trim).collect();
            assert_eq!(cells[3], written(declaration, entry), "{} of {}", entry.name, declaration.name);
            let source = entry.row.source;
            assert!(cells[6].ends_with(source), "{} of {}: {source:?}", entry.name, declaration.name);
        }
    }
}

#[test]
fn studies_start_from_the_declared_values() {
    for declaration in declarations() {
        let mut bench = Setup { model: declaration.name.to_owned(), ..Setup::default() }.bench().unwrap();
        // A study asks for a shaft at an imposed speed; see Setup::bench.
        for entry in settable(declaration).filter(|entry| entry.name != "mechanical_mode") {
            assert_eq!(bench.get(&entry.name).unwrap(), entry.row.start, "{}", entry.name);
        }
    }
}

/// Every start value that is neither zero nor an enumeration names its source; an effect is neutral, so that a value of
/// its own that is not zero can only be a regularisation or a neutral factor.
#[test]
fn start_values_have_sources_and_effects_are_neutral() {
    assert!(!Effects::default().is_on());
    for declaration in declarations() {
        let numbers = settable(declaration).filter(|e| matches!(e.row.kind, Kind::Real | Kind::Integer));
        for entry in numbers.filter(|e| e.row.start != 0.0) {
            let (name, source) = (&entry.name, entry.row.source);
            assert!(!source.is_empty(), "{name} = {} of {} has no source", entry.row.start, declaration.name);
            if name.starts_with("effect.") {
                let neutral = ["regularisation", "neutral"].iter().any(|word| source.starts_with(word));
                assert!(entry.row.causality == Causality::Parameter && neutral, "{name}: {source}");
            }
        }
    }
}
