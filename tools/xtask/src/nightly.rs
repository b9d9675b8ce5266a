//! `cargo xtask nightly`: everything of `cargo xtask test`, and what takes too long for every change.

use crate::{
    Outcome, bench, blind, cross, fuzz, importers, mutants, page, shell,
    stages::Stages,
    test::{self, Extent},
    wheel,
    workspace::Workspace,
};

/// A stage that is a command of its own.
type Command = (&'static str, fn(&Workspace, &[String]) -> Outcome);

/// What `test` leaves out, the quick ones first.
const LONGER: [Command; 7] = [
    ("fuzz", fuzz::run),
    ("cross", cross::run),
    ("importers", importers::run),
    ("page", page::test),
    ("wheel", wheel::test),
    ("blind", blind::run),
    ("bench", bench::run),
];

/// Runs all stages. Takes no arguments.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    crate::no_arguments("nightly", arguments)?;
    let mut stages = Stages::default();
    test::common(workspace, Extent::Full, &mut stages);
    stages.run("physics against diffsol", || {
        let mut command =
            workspace.cargo(&["test", "--release", "--package", "physics", "--package", "reference"]);
        shell::run(command.args(["--test", "all", "--features", "reference/diffsol"]))
    });
    stages.keeping("removals", || mutants::removal::summary(workspace));
    stages.keeping("mutants", || mutants::all(workspace));
    for (name, command) in LONGER {
        stages.run(name, || command(workspace, &[]));
    }
    stages.finish()
}
