//! `cargo xtask fuzz [--calls N] [--valgrind]`: random calls of both C interfaces, with each model in turn.

use crate::{Outcome, shell, workspace::Workspace};
use std::process::{Command, Stdio};

/// Calls of each model, by default.
const CALLS: &str = "2000000";
/// The program that checks every access to memory.
const VALGRIND: &str = "valgrind";

/// Makes so many calls of each model; a crash or an internal failure is reported with the seed that leads there.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let (mut calls, mut watched) = (CALLS.to_string(), false);
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--valgrind" => watched = true,
            "--calls" => match words.next() {
                Some(number) if number.parse::<u32>().is_ok() => calls.clone_from(number),
                _ => return Err("--calls takes a whole number".to_string()),
            },
            other => return Err(format!("fuzz takes --calls and --valgrind, not {other}")),
        }
    }
    if watched && !is_there(VALGRIND) {
        return Err("valgrind is not on the path; install it (Debian: apt-get install valgrind)".to_string());
    }
    shell::stage("random calls");
    let build = ["build", "--release", "--quiet", "--package", "fmu", "--example", "fuzz"];
    shell::run(&mut workspace.cargo(&build))?;
    let program =
        workspace.target.join("release/examples").join(format!("fuzz{}", std::env::consts::EXE_SUFFIX));
    if !watched {
        return shell::run(Command::new(program).arg(calls));
    }
    let mut command = Command::new(VALGRIND);
    command.args(["--quiet", "--error-exitcode=1", "--leak-check=full", "--errors-for-leak-kinds=definite"]);
    shell::run(command.arg(program).arg(calls))
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}
