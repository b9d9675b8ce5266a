//! `cargo xtask tidy`: format, lints, links of the documentation, dependencies between crates, lengths of files, generated files, licences,
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

/// Checks that compile: a test of `describe` makes the last one at fewer points, and clippy compiles every package once more, which takes a minute and a
/// half from a fresh clone. They are a part of `cargo xtask tidy` and of the nightly run.
const FURTHER: &[Check] =
    &[("lints", lints), ("documentation", documentation), ("generated files", describe::check)];

/// Runs every check, failed or not.
pub fn run(workspace: &Workspace) -> Outcome {
    all(workspace, CHECKS.iter().chain(FURTHER))
}

/// Runs the checks that compile nothing.
pub fn sources(workspace: &Workspace) -> Outcome {
    all(workspace, CHECKS.iter())
}

fn lints(workspace: &Workspace) -> Outcome {
    let arguments =
        ["clippy", "--quiet", "--release", "--workspace", "--all-targets", "--", "--deny", "warnings"];
    shell::run(&mut workspace.cargo(&arguments))
}

/// A link to an item that does not exist, or to two, is a warning of rustdoc. The documentation is for those who change the code: it
/// contains private items, so links to them are right.
fn documentation(workspace: &Workspace) -> Outcome {
    let mut command = workspace.cargo(&[
        "doc",
        "--quiet",
        "--release",
        "--workspace",
        "--no-deps",
        "--document-private-items",
    ]);
    shell::run(command.env("RUSTDOCFLAGS", "--deny warnings --allow rustdoc::private_intra_doc_links"))
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
