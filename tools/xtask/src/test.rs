//! `cargo xtask test`: every check there is. A failed stage does not stop the others.

use crate::{Outcome, mutants, product, shell, tidy, venv, workspace::Workspace};

/// What the stages have said.
#[derive(Default)]
struct Summary {
    lines: Vec<String>,
    failures: usize,
}

impl Summary {
    /// Runs a stage and keeps its closing lines.
    fn stage(&mut self, name: &str, run: impl FnOnce() -> (Vec<String>, Outcome)) -> bool {
        shell::stage(name);
        let (closing, outcome) = run();
        self.lines.extend(closing.into_iter().map(|line| format!("{name}: {line}")));
        match &outcome {
            Ok(()) => self.lines.push(format!("{name}: ok")),
            Err(sentence) => {
                self.failures += 1;
                eprintln!("{name}: {sentence}");
                self.lines.push(format!("{name}: FAILED: {sentence}"));
            }
        }
        outcome.is_ok()
    }
}

/// Runs all stages. Takes no arguments.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    if let Some(extra) = arguments.first() {
        return Err(format!("`test` takes no arguments, got {extra:?}"));
    }
    let mut summary = Summary::default();
    summary.stage("tidy", || (Vec::new(), tidy::run(workspace, &[])));
    summary.stage("cargo test", || {
        let mut command = workspace.cargo(&["test", "--release", "--workspace", "--no-fail-fast"]);
        shell::run_keeping(&mut command, |line| line.starts_with("test result:"))
    });
    let built = summary.stage("build", || {
        (Vec::new(), product::build(workspace).and_then(|()| product::archives(workspace)))
    });
    summary.stage("pytest", || match python_tests(workspace, built) {
        Ok(mut command) => shell::run_keeping(&mut command, is_pytest_closing),
        Err(sentence) => (Vec::new(), Err(sentence)),
    });
    summary.stage("removals", || mutants::removal::summary(workspace));
    summary.stage("mutants", || mutants::summary(workspace, &[]));

    shell::stage("summary");
    summary.lines.iter().for_each(|line| println!("{line}"));
    match summary.failures {
        0 => Ok(()),
        1 => Err("1 stage failed".into()),
        n => Err(format!("{n} stages failed")),
    }
}

fn python_tests(workspace: &Workspace, built: bool) -> Outcome<std::process::Command> {
    if !built {
        return Err("there are no fresh archives to test, because the build failed".into());
    }
    let mut command = product::python(workspace, &venv::python(workspace)?);
    command.args(["-m", "pytest", "tests/python"]);
    Ok(command)
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
    fn the_closing_line_is_told_from_others() {
        assert!(is_pytest_closing("12 passed in 3.41s"));
        assert!(is_pytest_closing("===== 1 failed, 11 passed in 3.41s ====="));
        assert!(!is_pytest_closing("tests/python/test_gait.py ....  [ 10%]"));
        assert!(!is_pytest_closing("E   assert 12 passed"));
    }

    #[test]
    fn a_failed_stage_is_counted_and_the_next_one_runs() {
        let mut summary = Summary::default();
        assert!(!summary.stage("a", || (vec!["1 failed".into()], Err("no".into()))));
        assert!(summary.stage("b", || (Vec::new(), Ok(()))));
        assert_eq!(summary.failures, 1);
        assert_eq!(summary.lines, ["a: 1 failed", "a: FAILED: no", "b: ok"]);
    }
}
