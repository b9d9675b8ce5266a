//! `cargo xtask tidy`: format, lints, dependencies between crates, lengths of files, generated files, licences.

mod arrows;
mod circles;
mod lengths;
mod modules;
mod words;

use crate::{Outcome, describe, licenses, shell, workspace::Workspace};

/// A check with its name.
type Check = (&'static str, fn(&Workspace) -> Outcome);

const CHECKS: &[Check] = &[
    ("format", |w| shell::run(&mut w.cargo(&["fmt", "--all", "--check"]))),
    ("dependency arrows", arrows::check),
    ("import circles", circles::check),
    ("file lengths", lengths::check),
    ("modules of tests", modules::check),
    ("words", words::check),
    ("lints", |w| {
        shell::run(&mut w.cargo(&[
            "clippy",
            "--quiet",
            "--release",
            "--workspace",
            "--all-targets",
            "--",
            "--deny",
            "warnings",
        ]))
    }),
    ("licences", licenses::check),
];

/// The tests of `describe` do the same, so `cargo xtask test` need not.
const GENERATED: Check = ("generated files", describe::check);

/// Runs every check, failed or not. Takes no arguments.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    crate::no_arguments("tidy", arguments)?;
    all(workspace, CHECKS.iter().chain([&GENERATED]))
}

/// Runs the checks that no test repeats.
pub fn sources(workspace: &Workspace) -> Outcome {
    all(workspace, CHECKS.iter())
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
