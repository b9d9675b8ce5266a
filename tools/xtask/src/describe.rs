//! `cargo xtask describe`: the generated folder model-description/.

use crate::{Outcome, shell, workspace::Workspace};

/// Writes it; with `--check` compares only.
pub fn run(workspace: &Workspace, arguments: &[&str]) -> Outcome {
    let mut command = workspace.cargo(&["run", "--release", "--quiet", "--package", "describe", "--"]);
    shell::run(command.args(arguments))
}

/// Whether the committed files agree with the declarations.
pub fn check(workspace: &Workspace) -> Outcome {
    run(workspace, &["--check"])
        .map_err(|e| format!("model-description/ is not up to date, run `cargo xtask describe`: {e}"))
}
