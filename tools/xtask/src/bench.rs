//! `cargo xtask bench`: the benches of every crate that has some.

use crate::{Outcome, product, shell, workspace::Workspace};

/// Runs them; `arguments` go to the benches (a name filter, `--save-baseline`, ...).
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let with_benches = workspace.packages.iter().filter(|p| p.has_benches);
    let mut command = workspace.cargo(&["bench", "--benches"]);
    let mut any = false;
    for package in with_benches {
        command.args(["--package", &package.name]);
        any = true;
    }
    if !any {
        return Err("no crate of the workspace has a bench".into());
    }
    // The benches load the library as an importer does.
    product::build(workspace)?;
    shell::stage("benchmarks");
    shell::run(command.arg("--").args(arguments))
}
