//! `cargo xtask tidy`: format, lints, dependencies between crates, lengths of files, generated files, licences,
//! reasons of numeric constants.

mod arrows;
mod circles;
mod features;
mod lengths;
mod modules;
mod numbers;
mod words;

use crate::{Outcome, describe, licenses, shell, workspace::Workspace};

/// A check with its name.
type Check = (&'static str, fn(&Workspace) -> Outcome);

const CHECKS: &[Check] = &[
    ("format", |w| shell::run(&mut w.cargo(&["fmt", "--all", "--check"]))),
    ("dependency arrows", arrows::check),
    ("import circles", circles::check),
    ("features", features::check),
    ("file lengths", lengths::check),
    ("modules of tests", modules::check),
    ("numbers", numbers::check),
    ("words", words::check),
    ("licences", licenses::check),
];

/// Everything.
const FURTHER: &[Check] =
    &[("lints", |w| lints(w, &["--all-targets"])), ("generated files", describe::check)];

/// The everyday run: the tests of `describe` compare the generated files, and the benchmarks need criterion and diffsol, which take
/// longer to compile than all of ours. Tests are linted with everything.
const EVERYDAY: &[Check] = &[("lints", |w| lints(w, &["--exclude", "bench", "--lib", "--bins"]))];

/// Runs every check, failed or not.
pub fn run(workspace: &Workspace) -> Outcome {
    all(workspace, CHECKS.iter().chain(FURTHER))
}

/// Runs the checks that no test repeats; lints without tests and benchmarks.
pub fn sources(workspace: &Workspace) -> Outcome {
    all(workspace, CHECKS.iter().chain(EVERYDAY))
}

fn lints(workspace: &Workspace, which: &[&str]) -> Outcome {
    let mut command = workspace.cargo(&["clippy", "--quiet", "--release", "--workspace"]);
    shell::run(command.args(which).args(["--", "--deny", "warnings"]))
}

fn all<'a>(workspace: &Workspace, checks: impl Iterator<Item = &'a Check>) -> Outcome {
    let mut failed = Vec::new();
    for (name, check) in checks {
        shell::stage(&format!("tidy: {name}"));
        if let Err(sentence) = check(workspace) {
            eprintln!("{name}: {sentence}");
            failed.push(*name);
        }
    }
    if failed.is_empty() { Ok(()) } else { Err(format!("not tidy: {}", failed.join(", "))) }
}
