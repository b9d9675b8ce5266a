//! `cargo xtask miri`: the tests of the C interface in Miri, the interpreter that reports undefined behaviour: pointers, aliasing,
//! uninitialised memory, data races, leaks.
//!
//! Miri takes a thousand times as long as the compiled tests, so `cfg!(miri)` shortens their runs (`shortened` in
//! `fmu-src/fmu/tests/common`). Every function of both interfaces is called. These tests are ignored, with the reason beside them:
//! - `an_absurd_input_derivative_ends_the_step` and `a_step_without_solution_is_discarded_and_changes_nothing` take up to a million steps
//!   of the integrator until a step fails;
//! - `the_error_follows_the_tolerance` and `settled_states_follow_the_others` measure the accuracy of the integrator; the other tests beside
//!   them make the same calls.

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
    let mut command = Command::new("rustup");
    command.args(["run", TOOLCHAIN, "cargo", "miri", "test", "--package", "fmu", "--test", "all"]);
    // The toolchain that runs this program must not reach into the other one.
    for name in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
        command.env_remove(name);
    }
    shell::run(command.env("MIRIFLAGS", FLAGS).current_dir(&workspace.root))
}
