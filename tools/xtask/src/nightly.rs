//! `cargo xtask nightly`: everything of `cargo xtask test`, and what takes too long for every change.

use crate::{
    Command, Outcome, mutants, page, shell,
    stages::Stages,
    test::{self, Extent},
    wheel,
    workspace::Workspace,
};
use clap::Parser;

/// What `test` leaves out, the quick ones first; each is a command of its own.
const LONGER: [&str; 7] = ["fuzz", "cross", "importers", "page", "wheel", "blind", "bench"];

/// Runs all stages.
pub fn run(workspace: &Workspace) -> Outcome {
    let mut stages = Stages::default();
    test::common(workspace, Extent::Full, &mut stages);
    stages.run("physics against diffsol", || {
        let mut command =
            workspace.cargo(&["test", "--release", "--package", "physics", "--package", "reference"]);
        shell::run(command.args(["--test", "all", "--features", "reference/diffsol"]))
    });
    stages.keeping("removals", || mutants::removal::summary(workspace));
    stages.keeping("mutants", || mutants::all(workspace));
    for name in LONGER {
        stages.run(name, || match name {
            "page" => page::test(workspace),
            "wheel" => wheel::test(workspace),
            _ => crate::run(workspace, &Command::parse_from(["xtask", name])),
        });
    }
    stages.finish()
}
