//! `cargo xtask fuzz`: random calls of both C interfaces, with each model in turn.

use crate::{Outcome, shell, workspace::Workspace};
use std::process::Command;

/// The program that checks every access to memory.
const VALGRIND: &str = "valgrind";

/// How many calls, and whether memory is checked.
#[derive(clap::Args)]
pub struct Options {
    /// Calls of each model.
    #[arg(long, value_name = "N", default_value_t = 2_000_000)]
    calls: u32,
    /// Check every access to memory.
    #[arg(long)]
    valgrind: bool,
}

/// Makes so many calls of each model; a crash or an internal failure is reported with the seed that leads there.
pub fn run(workspace: &Workspace, options: &Options) -> Outcome {
    if options.valgrind && !shell::is_program(VALGRIND) {
        return Err("valgrind is not on the path; install it (Debian: apt-get install valgrind)".to_string());
    }
    shell::stage("random calls");
    let build = ["build", "--release", "--quiet", "--package", "fmu", "--example", "fuzz"];
    shell::run(&mut workspace.cargo(&build))?;
    let program = workspace.program("examples/fuzz");
    let mut command = if options.valgrind {
        let mut command = Command::new(VALGRIND);
        command.args([
            "--quiet",
            "--error-exitcode=1",
            "--leak-check=full",
            "--errors-for-leak-kinds=definite",
        ]);
        command.arg(program);
        command
    } else {
        Command::new(program)
    };
    shell::run(command.arg(options.calls.to_string()))
}
