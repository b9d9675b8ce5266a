//! `cargo xtask mutants`: breaks a copy of the physics by hand, one way at a time, and expects its tests to fail.
//!
//! A test can pass with the physics upside down. Each mutant of the table is one such physics; one that survives
//! shows a hole in the tests. A mutant must compile (else nothing is shown) and its text must stand in the source
//! exactly once (else it breaks something other than it says).

mod copy;
pub mod removal;
mod table;

use crate::{
    Outcome,
    shell::{self, Ending},
    workspace::Workspace,
};
use copy::Copy;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The crate whose tests must notice.
const PACKAGE: &str = "physics";
/// A mutant may make a loop endless. The honest tests take seconds.
const TIME_LIMIT: Duration = Duration::from_secs(120);

/// One way to break the physics.
#[derive(Clone, Copy, Debug)]
pub struct Mutant {
    /// What to call it on the command line.
    name: &'static str,
    /// The file, from the root of the workspace.
    file: &'static str,
    /// A text that stands there exactly once.
    text: &'static str,
    /// What to put in its place.
    replacement: &'static str,
    /// The physics that is wrong then.
    breaks: &'static str,
}

/// Runs the mutants named, or all.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let (closing, outcome) = summary(workspace, arguments);
    closing.iter().for_each(|line| println!("{line}"));
    outcome
}

/// The same, with the closing line for a summary.
pub fn summary(workspace: &Workspace, arguments: &[String]) -> (Vec<String>, Outcome) {
    match try_all(workspace, arguments) {
        Ok((tried, survivors)) => {
            let closing = format!("{} of {tried} mutants noticed", tried - survivors.len());
            let outcome = match survivors.as_slice() {
                [] => Ok(()),
                some => Err(format!("the tests of {PACKAGE} do not notice {}", some.join(", "))),
            };
            (vec![closing], outcome)
        }
        Err(sentence) => (Vec::new(), Err(sentence)),
    }
}

fn try_all(workspace: &Workspace, names: &[String]) -> Outcome<(usize, Vec<String>)> {
    let chosen = choose(names)?;
    // All texts first: a table that is out of date should not be found out after minutes.
    for mutant in &chosen {
        let source = read(&workspace.root.join(mutant.file))?;
        mutated(mutant, &source)?;
    }
    let copy = Copy::of(workspace, "mutants")?;
    shell::stage("mutants: the unbroken copy must pass");
    match test(workspace, copy.root())? {
        Ending::Success => {}
        _ => return Err(format!("the tests of {PACKAGE} fail without any mutant, so they cannot show one")),
    }
    let mut survivors = Vec::new();
    for (k, mutant) in chosen.iter().enumerate() {
        shell::stage(&format!("mutant {} of {}: {}: {}", k + 1, chosen.len(), mutant.name, mutant.breaks));
        let path = copy.root().join(mutant.file);
        let original = read(&path)?;
        write(&path, &mutated(mutant, &original)?)?;
        let ending = test(workspace, copy.root());
        write(&path, &original)?;
        match ending.map_err(|e| format!("mutant {}: {e}", mutant.name))? {
            Ending::Success => {
                eprintln!("survived: {} ({})", mutant.name, mutant.file);
                survivors.push(mutant.name.to_owned());
            }
            Ending::Failure => eprintln!("noticed"),
            Ending::TimeUp => eprintln!("noticed: the tests did not end within {} s", TIME_LIMIT.as_secs()),
        }
    }
    Ok((chosen.len(), survivors))
}

fn choose(names: &[String]) -> Outcome<Vec<&'static Mutant>> {
    if names.is_empty() {
        return Ok(table::MUTANTS.iter().collect());
    }
    let find = |name: &String| {
        table::MUTANTS.iter().find(|m| m.name == name).ok_or_else(|| {
            let known: Vec<&str> = table::MUTANTS.iter().map(|m| m.name).collect();
            format!("there is no mutant {name:?}; there are {}", known.join(", "))
        })
    };
    names.iter().map(find).collect()
}

/// A source with the mutant in it.
fn mutated(mutant: &Mutant, source: &str) -> Outcome<String> {
    match source.matches(mutant.text).count() {
        1 => Ok(source.replacen(mutant.text, mutant.replacement, 1)),
        n => Err(format!(
            "mutant {}: {:?} stands {n} times in {}, not once; bring tools/xtask/src/mutants/table.rs up to date",
            mutant.name, mutant.text, mutant.file
        )),
    }
}

/// Builds and runs the tests in a folder. They share our target folder, so only the changed crates are built.
fn test(workspace: &Workspace, root: &Path) -> Outcome<Ending> {
    let mut build = workspace.cargo(&["test", "--release", "--no-run", "--message-format", "json"]);
    // Doc examples say nothing about physics and take as long as all else.
    build.args(["--package", PACKAGE, "--lib", "--tests"]);
    build.current_dir(root).env("CARGO_TARGET_DIR", &workspace.target);
    let messages = shell::output(&mut build).map_err(|e| format!("the tests do not compile: {e}"))?;
    let programs = programs(&messages);
    if programs.is_empty() {
        return Err(format!("{PACKAGE} has no tests"));
    }
    // Run without cargo in between, so that one which hangs can be stopped.
    for (program, folder) in programs {
        let ending = shell::run_for(Command::new(program).current_dir(folder), TIME_LIMIT)?;
        if ending != Ending::Success {
            return Ok(ending);
        }
    }
    Ok(Ending::Success)
}

/// Test programs that cargo has built, each with the folder of its crate, from cargo's messages.
fn programs(messages: &str) -> Vec<(PathBuf, PathBuf)> {
    let parsed = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    parsed
        .filter_map(|message| {
            let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
            Some((message["executable"].as_str()?.into(), folder.into()))
        })
        .collect()
}

fn read(path: &Path) -> Outcome<String> {
    std::fs::read_to_string(path).map_err(|e| format!("{} cannot be read: {e}", path.display()))
}

fn write(path: &Path, text: &str) -> Outcome {
    std::fs::write(path, text).map_err(|e| format!("{} cannot be written: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const SWAP: Mutant =
        Mutant { name: "swap", file: "a.rs", text: "a - b", replacement: "b - a", breaks: "the direction" };

    #[test]
    fn a_text_that_stands_once_is_replaced() {
        assert_eq!(mutated(&SWAP, "let q = (a - b) / r;").unwrap(), "let q = (b - a) / r;");
    }

    #[test]
    fn a_text_that_is_gone_or_not_alone_is_an_error() {
        for source in ["nothing", "a - b; a - b"] {
            let error = mutated(&SWAP, source).unwrap_err();
            assert!(error.contains("swap") && error.contains("a.rs"), "{error}");
        }
    }

    #[test]
    fn the_table_fits_the_sources_of_now() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for mutant in table::MUTANTS {
            mutated(mutant, &read(&root.join(mutant.file)).unwrap()).unwrap();
            assert_ne!(mutant.text, mutant.replacement, "{}", mutant.name);
        }
    }

    #[test]
    fn programs_are_found_among_cargos_messages() {
        let messages = r#"{"reason": "compiler-artifact", "manifest_path": "/w/a/Cargo.toml", "executable": null}
{"reason": "compiler-artifact", "manifest_path": "/w/a/Cargo.toml", "executable": "/t/a-1"}
{"reason": "build-finished", "success": true}"#;
        assert_eq!(programs(messages), [("/t/a-1".into(), "/w/a".into())]);
    }

    #[test]
    fn names_are_unique_and_an_unknown_one_is_an_error() {
        let names: BTreeSet<&str> = table::MUTANTS.iter().map(|m| m.name).collect();
        assert_eq!(names.len(), table::MUTANTS.len());
        assert!(choose(&["no-such-mutant".into()]).unwrap_err().contains("no-such-mutant"));
    }
}
