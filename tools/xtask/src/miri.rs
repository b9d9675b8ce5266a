//! `cargo xtask miri`: the tests of the C interface in Miri, the interpreter that reports undefined behaviour: pointers, aliasing,
//! uninitialised memory, data races, leaks.
//!
//! Miri takes a thousand times as long as the compiled tests, so `cfg!(miri)` shortens their runs (`shortened` in
//! `fmu-src/fmu/tests/common`). Every function of both interfaces is called. These tests are ignored, with the reason beside them:
//! - `an_absurd_input_derivative_ends_the_step` and `a_step_without_solution_is_discarded_and_changes_nothing` take up to a million steps
//!   of the integrator until a step fails;
//! - `the_error_follows_the_tolerance` and `settled_states_follow_the_others` measure the accuracy of the integrator; the other tests beside
//!   them make the same calls.
//!
//! An interpreter uses one core, so each test has a process of its own, as many at a time as there are cores. The tests with threads
//! have all their threads in one process.

use crate::{Outcome, shell, workspace::Workspace};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

/// The toolchain that has Miri.
const TOOLCHAIN: &str = "nightly";
/// The tests of resources read files; a number does not depend on Miri's random rounding of functions, because tests compare bits.
const FLAGS: &str = "-Zmiri-disable-isolation -Zmiri-deterministic-floats";

/// Runs the tests; undefined behaviour and a leak are failures.
pub fn run(workspace: &Workspace) -> Outcome {
    if shell::output(Command::new("rustup").args(["run", TOOLCHAIN, "cargo", "miri", "--version"])).is_err() {
        return Err(format!(
            "Miri is not installed; `rustup toolchain install {TOOLCHAIN} --component miri` installs it"
        ));
    }
    shell::stage("tests of the C interface in Miri");
    let names = names(workspace)?;
    let queue = Mutex::new(names.iter());
    let failed = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let Some(name) = queue.lock().expect("no worker panics").next() else { break };
                    let begin = Instant::now();
                    let outcome = one(workspace, name);
                    let time = begin.elapsed().as_secs();
                    println!("{name}: {} ({time} s)", if outcome.is_ok() { "ok" } else { "FAILED" });
                    if let Err(text) = outcome {
                        eprintln!("{text}");
                        failed.lock().expect("no worker panics").push(name.as_str());
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().expect("no worker panics");
    println!("Miri: {} of {} tests passed", names.len() - failed.len(), names.len());
    if failed.is_empty() { Ok(()) } else { Err(format!("in Miri failed: {}", failed.join(", "))) }
}

/// `cargo miri test` of the C interface with arguments of the test program.
fn command(workspace: &Workspace, arguments: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command.args([
        "run",
        TOOLCHAIN,
        "cargo",
        "miri",
        "test",
        "--quiet",
        "--package",
        "fmu",
        "--test",
        "all",
        "--",
    ]);
    // The toolchain that runs this program must not reach into the other one.
    for name in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
        command.env_remove(name);
    }
    command.args(arguments).env("MIRIFLAGS", FLAGS).current_dir(&workspace.root);
    command
}

/// The names of the tests that Miri runs.
fn names(workspace: &Workspace) -> Outcome<Vec<String>> {
    let list = |arguments: &[&str]| -> Outcome<Vec<String>> {
        let text =
            shell::output(&mut command(workspace, &[&["--list", "--format", "terse"], arguments].concat()))?;
        Ok(text.lines().filter_map(|line| Some(line.strip_suffix(": test")?.to_owned())).collect())
    };
    let ignored = list(&["--ignored"])?;
    Ok(list(&[])?.into_iter().filter(|name| !ignored.contains(name)).collect())
}

/// Runs one test; an error is all that it wrote.
fn one(workspace: &Workspace, name: &str) -> Outcome {
    let done = command(workspace, &["--exact", name])
        .output()
        .map_err(|e| format!("Miri cannot be started: {e}"))?;
    if done.status.success() {
        return Ok(());
    }
    Err([done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat())
}
