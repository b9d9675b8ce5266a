//! `cargo xtask tidy`: what a reader relies on without looking.

mod arrows;
mod circles;
mod lengths;

use crate::{Outcome, describe, licenses, shell, workspace::Workspace};

/// A check: what it is called while it runs, and the check.
type Check = (&'static str, fn(&Workspace) -> Outcome);

const CHECKS: &[Check] = &[
    ("format", |w| shell::run(&mut w.cargo(&["fmt", "--all", "--check"]))),
    ("dependency arrows", arrows::check),
    ("import circles", circles::check),
    ("file lengths", lengths::check),
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
    ("generated files", describe::check),
    ("licences", licenses::check),
];

/// Runs every check, failed or not. Takes no arguments.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    if let Some(extra) = arguments.first() {
        return Err(format!("`tidy` takes no arguments, got {extra:?}"));
    }
    let mut failed = Vec::new();
    for (name, check) in CHECKS {
        shell::stage(&format!("tidy: {name}"));
        if let Err(sentence) = check(workspace) {
            eprintln!("{name}: {sentence}");
            failed.push(*name);
        }
    }
    if failed.is_empty() { Ok(()) } else { Err(format!("not tidy: {}", failed.join(", "))) }
}
