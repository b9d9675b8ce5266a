//! `cargo xtask nightly`: everything of `cargo xtask test`, and what takes too long for every change.

use crate::{
    Command, Outcome, mutants, page, shell,
    stages::Stages,
    test::{self, Extent},
    wheel,
    workspace::Workspace,
};
use clap::Parser;

/// The stages, the quick ones first: the tests of every day with the longer ones, then what `test` leaves out.
const STAGES: [&str; 12] = [
    "tests",
    "diffsol",
    "removals",
    "mutants",
    "fuzz",
    "miri",
    "cross",
    "importers",
    "page",
    "wheel",
    "blind",
    "bench",
];

/// Runs the stages named, or all.
pub fn run(workspace: &Workspace, names: &[String]) -> Outcome {
    if let Some(name) = names.iter().find(|name| !STAGES.contains(&name.as_str())) {
        return Err(format!("there is no stage {name:?}; there are {}", STAGES.join(", ")));
    }
    let mut stages = Stages::default();
    for name in STAGES.into_iter().filter(|own| names.is_empty() || names.iter().any(|name| name == own)) {
        if name == "tests" {
            test::common(workspace, Extent::Full, &mut stages);
            continue;
        }
        stages.keeping(name, || match name {
            "removals" => mutants::removal::summary(workspace),
            "mutants" => mutants::all(workspace),
            "diffsol" => (Vec::new(), diffsol(workspace)),
            "page" => (Vec::new(), page::test(workspace)),
            "wheel" => (Vec::new(), wheel::test(workspace)),
            // A command of its own.
            _ => (Vec::new(), crate::run(workspace, &Command::parse_from(["xtask", name]))),
        });
    }
    stages.finish()
}

/// The tests of the physics with diffsol as the reference.
fn diffsol(workspace: &Workspace) -> Outcome {
    let mut command =
        workspace.cargo(&["test", "--release", "--package", "physics", "--package", "reference"]);
    shell::run(command.args(["--test", "all", "--features", "reference/diffsol"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_stage_is_an_error() {
        let error = run(&Workspace::find().unwrap(), &["blnd".into()]).unwrap_err();
        assert!(error.contains("blnd") && error.contains("blind"), "{error}");
    }
}
