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
//! An interpreter uses one core, so the tests are divided among as many processes as there are cores. What the models initialize once takes
//! tens of seconds in each of them.

use crate::{Outcome, shell, workspace::Workspace};
use std::process::Command;

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
    let parts = std::thread::available_parallelism().map_or(1, usize::from).min(names.len());
    let part = |k: usize| {
        let own = names.iter().skip(k).step_by(parts).map(String::as_str);
        let mut command = command(workspace, &own.chain(["--exact"]).collect::<Vec<_>>());
        shell::run_keeping(&mut command, |_| false).1
    };
    let outcomes: Vec<Outcome> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..parts).map(|k| scope.spawn(move || part(k))).collect();
        started.into_iter().map(|one| one.join().expect("no part panics")).collect()
    });
    println!("Miri: {} tests in {parts} processes", names.len());
    outcomes.into_iter().collect()
}

/// `cargo miri test` of the C interface with arguments of the test program.
fn command(workspace: &Workspace, arguments: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", TOOLCHAIN, "cargo", "miri", "test", "--package", "fmu", "--test", "all", "--"]);
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
