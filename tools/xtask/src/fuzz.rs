//! `cargo xtask fuzz [--seconds N]`: calls without order into both C interfaces.

use crate::{Outcome, shell, workspace::Workspace};

/// How long, where nothing is said, s.
const SECONDS: &str = "60";

/// Plays for so many seconds; a crash or an internal failure is told with the seed that led there.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let seconds = match arguments {
        [] => SECONDS,
        [name, seconds] if name == "--seconds" && seconds.parse::<u32>().is_ok() => seconds,
        _ => return Err(format!("fuzz takes --seconds and a whole number, not {}", arguments.join(" "))),
    };
    shell::stage("calls without order");
    let words = ["run", "--release", "--quiet", "--package", "fmu", "--example", "fuzz", "--", seconds];
    shell::run(&mut workspace.cargo(&words))
}
