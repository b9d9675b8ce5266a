//! `cargo xtask blind`: many synthetic experiments with a known cause, and the verdict of `close-loop` on each.
//!
//! Python generates, runs and scores the sets (`tests/python/bench`), independently of the product's equations. Sets and
//! reports stay in the target folder, so an interrupted run continues and no set is run twice with the same program.

use crate::{Outcome, product, shell, venv, workspace::Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The page with the table of results.
const PAGE: &str = "docs/blind-suite.md";
const HELP: &str =
    "usage: cargo xtask blind [--seed N] [--count K] [--jobs J] [--program FILE] [--page FILE]";

/// Which sets, how many processes, which program, which page.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Options {
    seed: u32,
    count: u32,
    jobs: u32,
    /// A program to test in place of the one that is built here.
    program: Option<PathBuf>,
    page: PathBuf,
}

impl Default for Options {
    fn default() -> Self {
        // A fixed seed makes two tables comparable.
        Options { seed: 2026, count: 120, jobs: 2, program: None, page: PAGE.into() }
    }
}

impl Options {
    fn parse(arguments: &[String]) -> Outcome<Self> {
        let mut options = Self::default();
        let mut rest = arguments.iter();
        while let Some(name) = rest.next() {
            if !["--seed", "--count", "--jobs", "--program", "--page"].contains(&name.as_str()) {
                return Err(format!("`blind` has no argument {name:?}\n{HELP}"));
            }
            let value = rest.next().ok_or_else(|| format!("{name} needs a value\n{HELP}"))?;
            let number = |least: u32| {
                value.parse().ok().filter(|n| *n >= least).ok_or_else(|| {
                    format!("{name} is {value:?}; it must be a whole number from {least} to {}", u32::MAX)
                })
            };
            match name.as_str() {
                "--seed" => options.seed = number(0)?,
                "--count" => options.count = number(1)?,
                "--jobs" => options.jobs = number(1)?,
                "--program" => options.program = Some(value.into()),
                _ => options.page = value.into(),
            }
        }
        Ok(options)
    }

    /// The command that repeats the run, for the page. The number of jobs belongs to it: it changes the times.
    fn spelled(&self) -> String {
        format!("cargo xtask blind --seed {} --count {} --jobs {}", self.seed, self.count, self.jobs)
    }
}

/// Generates the sets, runs the program on each, and scores; an error when a required rate is missed.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    let options = Options::parse(arguments)?;
    // First, so that a missing Python is reported before minutes of compiling.
    let python = venv::python(workspace)?;
    let program = match &options.program {
        Some(program) => std::path::absolute(program)
            .map_err(|e| format!("--program {} is no path: {e}", program.display()))?,
        None => {
            shell::stage("building everything");
            product::build(workspace)?;
            workspace.program("motor-fmu")
        }
    };
    let sets = workspace.target.join("blind").join(options.seed.to_string());
    for (what, mut command) in steps(workspace, &python, &program, &sets, &options)? {
        shell::stage(&what);
        shell::run(&mut command)?;
    }
    Ok(())
}

/// Each step with its title.
fn steps(
    workspace: &Workspace,
    python: &Path,
    program: &Path,
    sets: &Path,
    options: &Options,
) -> Outcome<Vec<(String, Command)>> {
    let page = std::path::absolute(workspace.root.join(&options.page))
        .map_err(|e| format!("--page {} is no path: {e}", options.page.display()))?;
    let (count, jobs) = (options.count.to_string(), options.jobs.to_string());
    let module = |name: &str| {
        let mut command = product::python(workspace, python);
        command.args(["-m", name]).current_dir(workspace.root.join("tests/python"));
        command
    };
    let mut draw = module("bench.make");
    draw.arg("--seed").arg(options.seed.to_string()).arg("--out").arg(sets);
    draw.args(["--count", &count, "--jobs", &jobs, "--keep"]);
    let mut ask = module("bench.run");
    ask.arg(sets).arg("--program").arg(program).args(["--count", &count, "--jobs", &jobs]);
    let mut score = module("bench.score");
    score.arg(sets).args(["--count", &count]).arg("--page").arg(page);
    score.arg("--command").arg(options.spelled());
    Ok(vec![
        (format!("drawing {count} sets of seed {} into {}", options.seed, sets.display()), draw),
        ("asking about each".into(), ask),
        (format!("counting, into {}", options.page.display()), score),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Outcome<Options> {
        Options::parse(&text.split_whitespace().map(String::from).collect::<Vec<_>>())
    }

    #[test]
    fn arguments_replace_what_is_fixed() {
        assert_eq!(parsed("").unwrap(), Options::default());
        let options = parsed("--seed 7 --count 3 --jobs 1 --program p --page q.md").unwrap();
        assert_eq!((options.seed, options.count, options.jobs), (7, 3, 1));
        assert_eq!((options.program, options.page), (Some("p".into()), "q.md".into()));
    }

    #[test]
    fn an_argument_that_is_none_is_named() {
        for (text, part) in [
            ("--sets 3", "\"--sets\""),
            ("--seed", "--seed needs a value"),
            ("--count 0", "from 1"),
            ("--jobs many", "--jobs is \"many\""),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn the_command_on_the_page_makes_the_same_sets() {
        let options = parsed("--seed 7 --count 3 --jobs 1").unwrap();
        let again = options.spelled();
        assert_eq!(parsed(again.trim_start_matches("cargo xtask blind")).unwrap(), options);
    }

    #[test]
    fn every_step_is_a_module_of_the_bench_and_works_on_the_same_sets() {
        let workspace = Workspace::find().unwrap();
        let (python, program, sets) = (Path::new("python"), Path::new("motor-fmu"), Path::new("sets"));
        let steps = steps(&workspace, python, program, sets, &parsed("--count 3").unwrap()).unwrap();
        assert_eq!(steps.len(), 3);
        for (_, command) in steps {
            let arguments: Vec<_> = command.get_args().map(|a| a.to_str().unwrap()).collect();
            let module = arguments[1].strip_prefix("bench.").unwrap();
            assert!(
                command.get_current_dir().unwrap().join("bench").join(module).with_extension("py").is_file()
            );
            assert!(arguments.contains(&"sets") && arguments.contains(&"3"), "{arguments:?}");
        }
    }
}
