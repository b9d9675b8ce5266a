//! `cargo xtask fuzz [--seconds N] [--valgrind]`: calls without order into both C interfaces, with each model in turn.

use crate::{Outcome, shell, workspace::Workspace};
use std::process::{Command, Stdio};

/// How long, where nothing is said, s.
const SECONDS: &str = "60";
/// The program that sees what memory is touched.
const VALGRIND: &str = "valgrind";

/// Plays for so many seconds a model; a crash or an internal failure is told with the seed that led there.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let (mut seconds, mut watched) = (SECONDS.to_string(), false);
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--valgrind" => watched = true,
            "--seconds" => match words.next() {
                Some(number) if number.parse::<u32>().is_ok() => seconds.clone_from(number),
                _ => return Err("--seconds takes a whole number".to_string()),
            },
            other => return Err(format!("fuzz takes --seconds and --valgrind, not {other}")),
        }
    }
    if watched && !is_there(VALGRIND) {
        return Err("valgrind is not on the path; install it (Debian: apt-get install valgrind)".to_string());
    }
    shell::stage("calls without order");
    let build = ["build", "--release", "--quiet", "--package", "fmu", "--example", "fuzz"];
    shell::run(&mut workspace.cargo(&build))?;
    let program =
        workspace.target.join("release/examples").join(format!("fuzz{}", std::env::consts::EXE_SUFFIX));
    if !watched {
        return shell::run(Command::new(program).arg(seconds));
    }
    let mut command = Command::new(VALGRIND);
    command.args(["--quiet", "--error-exitcode=1", "--leak-check=full", "--errors-for-leak-kinds=definite"]);
    shell::run(command.arg(program).arg(seconds))
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}
