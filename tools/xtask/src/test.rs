//! `cargo xtask test`: all tests of the everyday run. `cargo xtask nightly` adds those that take longer.

use crate::{Outcome, mutants, product, shell, stages::Stages, tidy, venv, workspace::Workspace};
use std::path::PathBuf;
use std::process::Command;

/// Members of the workspace that have tests. Benchmarks have none, and criterion takes as long to compile as all of ours.
pub const MEMBERS: [&str; 3] = ["--workspace", "--exclude", "bench"];

/// Targets that are compiled for the tests, so that no later stage compiles anything again.
const TARGETS: [&str; 4] = ["--release", "--lib", "--bins", "--tests"];
/// Those of them that are tests: a manifest may exclude a target without any, which `--lib` would compile once more.
const TESTS: [&str; 2] = ["--release", "--tests"];

/// Which tests of pytest, and which mutants.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Tests without the mark `nightly`; mutants of changed files.
    Everyday,
    /// All.
    Full,
}

/// Runs the everyday stages.
pub fn run(workspace: &Workspace) -> Outcome {
    let mut stages = Stages::default();
    common(workspace, Extent::Everyday, &mut stages);
    stages.keeping("mutants of changed files", || mutants::changed(workspace));
    stages.finish()
}

/// The stages that both runs have: compiler, checks of the sources, Rust tests, archives, Python tests.
pub fn common(workspace: &Workspace, extent: Extent, stages: &mut Stages) {
    std::thread::scope(|scope| {
        // Packages come from the network while the compiler has the processors.
        let python = scope.spawn(|| venv::python(workspace, venv::TESTS));
        let compiled =
            stages.run("compile", || shell::run(workspace.cargo(&["build"]).args(MEMBERS).args(TARGETS)));
        stages.run("tidy", || match extent {
            Extent::Everyday => tidy::sources(workspace),
            Extent::Full => tidy::run(workspace),
        });
        stages.keeping("cargo test", || {
            let mut command = workspace.cargo(&["test", "--no-fail-fast"]);
            shell::run_keeping(command.args(MEMBERS).args(TESTS), is_cargo_closing)
        });
        stages.keeping("cargo test --doc", || {
            let mut command = workspace.cargo(&["test", "--no-fail-fast", "--release", "--doc"]);
            shell::run_keeping(command.args(MEMBERS), is_cargo_closing)
        });
        let built = compiled && stages.run("archives", || product::archives(workspace));
        stages.keeping("pytest", || {
            let python = python.join().unwrap_or_else(|_| Err("the set-up of Python panicked".into()));
            match python_tests(workspace, built, extent, python) {
                Ok(mut command) => shell::run_keeping(&mut command, is_pytest_closing),
                Err(sentence) => (Vec::new(), Err(sentence)),
            }
        });
    });
}

fn python_tests(
    workspace: &Workspace,
    built: bool,
    extent: Extent,
    python: Outcome<PathBuf>,
) -> Outcome<Command> {
    if !built {
        return Err("there are no new archives to test, because the build failed".into());
    }
    let mut command = product::python(workspace, &python?);
    command.args(["-m", "pytest", "tests/python", "--durations=15", "--numprocesses=2", "--dist=loadgroup"]);
    if extent == Extent::Everyday {
        command.args(["-m", "not nightly"]);
    }
    Ok(command)
}

fn is_cargo_closing(line: &str) -> bool {
    line.starts_with("test result:")
}

/// pytest's last line, `12 passed in 3.4s` with or without a frame.
fn is_pytest_closing(line: &str) -> bool {
    let line = line.trim_matches(['=', ' ']);
    let counted = |word: &str| line.contains(&format!(" {word}"));
    line.starts_with(|c: char| c.is_ascii_digit())
        && line.contains(" in ")
        && (counted("passed") || counted("failed") || counted("error"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closing_line_is_distinguished_from_others() {
        assert!(is_pytest_closing("12 passed in 3.41s"));
        assert!(is_pytest_closing("===== 1 failed, 11 passed in 3.41s ====="));
        assert!(!is_pytest_closing("tests/python/test_gait.py ....  [ 10%]"));
        assert!(!is_pytest_closing("E   assert 12 passed"));
    }
}
