//! `cargo xtask mutants`: applies each mutation of a table to a copy of the sources and expects the tests to fail.
//!
//! A test can pass with the physics upside down; a mutant that survives shows a hole in the tests. All mutants are
//! compiled into one program, which reads from an environment variable the one that applies: a mutant then costs a run
//! of the tests and no compilation. A mutant must be an expression whose text occurs exactly once in its file.

mod copy;
pub mod removal;
mod schema;
mod table;

use crate::{
    Outcome,
    shell::{self, Ending},
    workspace::Workspace,
};
use copy::Copy;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// One way to break the code.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Name on the command line.
    name: String,
    /// The file, from the root of the workspace; the tests of its crate must notice.
    file: String,
    /// An expression that occurs there exactly once.
    text: String,
    /// What to put in its place.
    replacement: String,
    /// What is wrong then.
    breaks: String,
}

impl Mutant {
    /// The crate of the file.
    fn package(&self) -> &str {
        self.file.split('/').nth(1).unwrap_or_default()
    }
}

/// Test result of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Noticed,
    Survived,
    /// The tests did not end in time. No test has failed, so this counts as a failure.
    TimedOut,
}

/// A test program with the folder that it runs in, its crate, and how long it takes without a mutant.
struct Program {
    file: PathBuf,
    folder: PathBuf,
    package: String,
    time: Duration,
}

/// Runs the mutants named, or all.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let (closing, outcome) = summary(workspace, &choose(arguments)?);
    closing.iter().for_each(|line| println!("{line}"));
    outcome
}

/// All mutants, with the closing line.
pub fn all(workspace: &Workspace) -> (Vec<String>, Outcome) {
    summary(workspace, &table::all().collect::<Vec<_>>())
}

/// The mutants of files that differ from the last commit that the branch shares with `main`, committed or not. A clean
/// checkout of `main` has none.
pub fn changed(workspace: &Workspace) -> (Vec<String>, Outcome) {
    let files = match changed_files(workspace) {
        Ok(files) => files,
        Err(sentence) => return (Vec::new(), Err(sentence)),
    };
    let chosen: Vec<&Mutant> = table::all().filter(|m| files.contains(&m.file)).collect();
    if chosen.is_empty() {
        let closing = format!(
            "no file that has mutants differs from main, so none of the {} is run; `cargo xtask nightly` runs all",
            table::all().count()
        );
        return (vec![closing], Ok(()));
    }
    summary(workspace, &chosen)
}

/// Files of the working tree that differ from the last commit that HEAD shares with `main` (or `origin/main`).
fn changed_files(workspace: &Workspace) -> Outcome<BTreeSet<String>> {
    let git =
        |arguments: &[&str]| shell::output(Command::new("git").current_dir(&workspace.root).args(arguments));
    let Some(base) = ["main", "origin/main"].iter().find_map(|m| git(&["merge-base", "HEAD", m]).ok()) else {
        eprintln!("mutants: there is no branch main to compare with");
        return Ok(BTreeSet::new());
    };
    let text = git(&["diff", "--name-only", "--relative", &base])?;
    Ok(text.lines().map(String::from).collect())
}

fn summary(workspace: &Workspace, chosen: &[&Mutant]) -> (Vec<String>, Outcome) {
    let verdicts = match judge(workspace, chosen) {
        Ok(verdicts) => verdicts,
        Err(sentence) => return (Vec::new(), Err(sentence)),
    };
    let of = |wanted: Verdict| {
        let found = chosen.iter().zip(&verdicts).filter(move |(_, verdict)| **verdict == wanted);
        found.map(|(mutant, _)| mutant.name.as_str()).collect::<Vec<_>>()
    };
    let closing = format!("{} of {} mutants noticed", of(Verdict::Noticed).len(), chosen.len());
    let wrong: Vec<String> = [(Verdict::Survived, "survived"), (Verdict::TimedOut, "timed out")]
        .map(|(verdict, what)| (of(verdict), what))
        .iter()
        .filter(|(names, _)| !names.is_empty())
        .map(|(names, what)| format!("{what}: {}", names.join(", ")))
        .collect();
    (vec![closing], if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) })
}

fn judge(workspace: &Workspace, chosen: &[&Mutant]) -> Outcome<Vec<Verdict>> {
    let copy = Copy::of(workspace, "mutants")?;
    schema::apply(copy.root(), chosen)?;
    let packages: BTreeSet<&str> = chosen.iter().map(|m| m.package()).collect();
    shell::stage(&format!("mutants: compiling {} of them into {:?}", chosen.len(), packages));
    let mut programs = compile(workspace, copy.root(), &packages)?;
    shell::stage("mutants: the tests must pass without a mutant");
    for program in &mut programs {
        let begin = Instant::now();
        if run_one(program, 0, Duration::MAX)? != Verdict::Survived {
            return Err(format!("the tests of {} fail without a mutant", program.package));
        }
        program.time = begin.elapsed();
    }
    let mut verdicts = Vec::new();
    for (k, mutant) in chosen.iter().enumerate() {
        let begin = Instant::now();
        let verdict = verdict(mutant, k + 1, &programs)?;
        eprintln!(
            "{} of {}: {}: {verdict:?} after {:.0} s ({}, {})",
            k + 1,
            chosen.len(),
            mutant.name,
            begin.elapsed().as_secs_f64(),
            mutant.breaks,
            mutant.file
        );
        verdicts.push(verdict);
    }
    Ok(verdicts)
}

/// Runs the programs of the mutant's crate until one notices.
fn verdict(mutant: &Mutant, number: usize, programs: &[Program]) -> Outcome<Verdict> {
    let mut worst = Verdict::Survived;
    for program in programs.iter().filter(|p| p.package == mutant.package()) {
        // A mutant may slow a loop down or make it endless.
        match run_one(program, number, 5 * program.time + Duration::from_secs(30))? {
            Verdict::Noticed => return Ok(Verdict::Noticed),
            Verdict::TimedOut => worst = Verdict::TimedOut,
            Verdict::Survived => {}
        }
    }
    Ok(worst)
}

fn run_one(program: &Program, number: usize, limit: Duration) -> Outcome<Verdict> {
    let mut command = Command::new(&program.file);
    command.current_dir(&program.folder).env(schema::VARIABLE, number.to_string());
    // A mutant can make some tests endless: with a thread for each they do not keep others from failing.
    command.args(["--test-threads", "8"]);
    // One failed test is enough.
    let failed = |line: &str| line.starts_with("test ") && line.ends_with("FAILED");
    Ok(match shell::run_until(&mut command, failed, limit)? {
        Ending::Success => Verdict::Survived,
        Ending::Failure => Verdict::Noticed,
        Ending::TimeUp => Verdict::TimedOut,
    })
}

fn choose(names: &[String]) -> Outcome<Vec<&'static Mutant>> {
    if names.is_empty() {
        return Ok(table::all().collect());
    }
    let find = |name: &String| {
        table::all().find(|m| m.name == *name).ok_or_else(|| {
            let known: Vec<&str> = table::all().map(|m| m.name.as_str()).collect();
            format!("there is no mutant {name:?}; there are {}", known.join(", "))
        })
    };
    names.iter().map(find).collect()
}

/// Builds the tests of a copy. They share our target folder, so only crates of ours are compiled.
fn compile(workspace: &Workspace, root: &Path, packages: &BTreeSet<&str>) -> Outcome<Vec<Program>> {
    let mut build =
        workspace.cargo(&["test", "--release", "--no-run", "--message-format", "json-render-diagnostics"]);
    build.arg("--tests").args(packages.iter().flat_map(|p| ["--package", p]));
    build.current_dir(root).env("CARGO_TARGET_DIR", &workspace.target);
    let messages = shell::output(&mut build).map_err(|e| format!("the mutants do not compile: {e}"))?;
    let programs = programs(&messages);
    match packages.iter().find(|package| !programs.iter().any(|p| p.package == **package)) {
        Some(package) => Err(format!("{package} has no tests")),
        None => Ok(programs),
    }
}

/// Test programs that cargo has built, from cargo's messages.
fn programs(messages: &str) -> Vec<Program> {
    let parsed = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    parsed
        .filter(|message| message["profile"]["test"] == true)
        .filter_map(|message| {
            let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
            Some(Program {
                file: message["executable"].as_str()?.into(),
                folder: folder.into(),
                package: folder.file_name()?.to_str()?.into(),
                time: Duration::ZERO,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_fits_the_sources_of_now() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let workspace = Workspace::find().unwrap();
        let all: Vec<&Mutant> = table::all().collect();
        for (file, mutants) in schema::by_file(&all) {
            let text = schema::mutated(&crate::files::read(&root.join(file)).unwrap(), &mutants).unwrap();
            // The choice between two expressions is an expression; of anything else it is no Rust.
            assert!(syn::parse_file(&text).is_ok(), "a mutant of {file} is no expression");
        }
        for mutant in table::all() {
            for text in [&mutant.text, &mutant.replacement] {
                assert!(
                    syn::parse_str::<syn::Expr>(text).is_ok(),
                    "{}: {text:?} is no expression",
                    mutant.name
                );
            }
            assert_ne!(mutant.text, mutant.replacement, "{}", mutant.name);
            assert!(workspace.packages.iter().any(|p| p.name == mutant.package()), "{}", mutant.file);
        }
    }

    #[test]
    fn programs_are_found_among_cargos_messages() {
        let messages = r#"{"reason": "compiler-artifact", "manifest_path": "/w/a/Cargo.toml", "profile": {"test": true}, "executable": null}
{"reason": "compiler-artifact", "manifest_path": "/w/a/Cargo.toml", "profile": {"test": true}, "executable": "/t/a-1"}
{"reason": "compiler-artifact", "manifest_path": "/w/a/Cargo.toml", "profile": {"test": false}, "executable": "/t/a"}
{"reason": "build-finished", "success": true}"#;
        let found = programs(messages);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].file.to_str(), found[0].package.as_str()), (Some("/t/a-1"), "a"));
    }

    #[test]
    fn names_are_unique_and_an_unknown_one_is_an_error() {
        let names: BTreeSet<&str> = table::all().map(|m| m.name.as_str()).collect();
        assert_eq!(names.len(), table::all().count());
        assert!(choose(&["no-such-mutant".into()]).unwrap_err().contains("no-such-mutant"));
    }

    #[test]
    fn a_test_that_hangs_has_not_noticed() {
        let shell = |script: &str| {
            let folder =
                std::env::temp_dir().join(format!("mutants-{}-{}", std::process::id(), script.len()));
            std::fs::write(&folder, format!("#!/bin/sh\n{script}\n")).unwrap();
            let mut permissions = std::fs::metadata(&folder).unwrap().permissions();
            std::os::unix::fs::PermissionsExt::set_mode(&mut permissions, 0o755);
            std::fs::set_permissions(&folder, permissions).unwrap();
            Program { file: folder, folder: "/".into(), package: "a".into(), time: Duration::ZERO }
        };
        let cases = [
            ("exec sleep 60", Verdict::TimedOut),
            ("echo 'test a ... FAILED'; exec sleep 61", Verdict::Noticed),
            ("exit 101", Verdict::Noticed),
            ("echo 'test a ... ok'", Verdict::Survived),
        ];
        for (script, verdict) in cases {
            let program = shell(script);
            let found = run_one(&program, 1, Duration::from_millis(500));
            std::fs::remove_file(&program.file).unwrap();
            assert_eq!(found.unwrap(), verdict, "{script}");
        }
    }
}
