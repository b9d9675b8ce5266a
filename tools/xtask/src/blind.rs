//! `cargo xtask blind`: the closed loop on many synthetic experiments with known answers.
//!
//! Python generates and evaluates the sets (`tests/python/blind`), independently of the equations of the product. Sets
//! and reports stay in the target folder: an interrupted run continues, and a set that the same program has already
//! evaluated is not run again. The table of each seed stays in the documentation.

use crate::{Outcome, product, shell, venv, workspace::Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The page in the documentation.
const PAGE: &str = "docs/blind-suite.md";
/// The results of all seeds, of which the page is made.
const TABLES: &str = "tests/reference/blind-suite";
/// Sets, number of parallel processes, program, output page.
#[derive(clap::Args, Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Any seed; by default the number of the day, so that each table has sets that nobody has seen.
    #[arg(long, default_value_t = today())]
    seed: u32,
    #[arg(long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    jobs: u32,
    /// A program to use instead of building `motor-fmu`.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    #[arg(long, value_name = "FILE", default_value = PAGE)]
    page: PathBuf,
    #[arg(long, value_name = "DIR", default_value = TABLES)]
    tables: PathBuf,
    /// Wall time for each set instead of the default of the program, on a machine that others use too.
    #[arg(long, value_name = "SECONDS")]
    budget: Option<u32>,
}

/// Days since 1970.
fn today() -> u32 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    u32::try_from(now.as_secs() / 86_400).unwrap_or_default()
}

impl Options {
    /// The command that repeats this run, for the page. With parallel processes each takes longer.
    fn spelled(&self) -> String {
        let budget = self.budget.map(|s| format!(" --budget {s}")).unwrap_or_default();
        format!("cargo xtask blind --seed {} --count {} --jobs {}{budget}", self.seed, self.count, self.jobs)
    }
}

/// Generates the sets, runs the program on each and evaluates the reports; an error if a criterion is not met.
pub fn run(workspace: &Workspace, options: &Options) -> Outcome {
    // First: a missing Python is reported before minutes of compiling.
    let python = venv::python(workspace, venv::TESTS)?;
    let program = match &options.program {
        Some(program) => std::path::absolute(program)
            .map_err(|e| format!("--program {} is no path: {e}", program.display()))?,
        None => {
            shell::stage("building");
            product::build(workspace)?;
            workspace.program("motor-fmu")
        }
    };
    let sets = workspace.target.join("blind").join(options.seed.to_string());
    for (what, mut command) in steps(workspace, &python, &program, &sets, options)? {
        shell::stage(&what);
        shell::run(&mut command)?;
    }
    Ok(())
}

/// Each step with its label.
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
    let mut generate = module("blind.make");
    generate.arg("--seed").arg(options.seed.to_string()).arg("--out").arg(sets);
    generate.args(["--count", &count, "--jobs", &jobs, "--keep"]);
    let mut run = module("blind.run");
    run.arg(sets).arg("--program").arg(program).args(["--count", &count, "--jobs", &jobs]);
    if let Some(budget) = options.budget {
        run.args(["--budget", &budget.to_string()]);
    }
    let mut score = module("blind.score");
    score.arg(sets).args(["--count", &count]).arg("--page").arg(page);
    score.arg("--tables").arg(workspace.root.join(&options.tables));
    score.arg("--command").arg(options.spelled());
    Ok(vec![
        (format!("generating {count} sets of seed {} into {}", options.seed, sets.display()), generate),
        ("running the program on each set".into(), run),
        (format!("evaluating, into {}", options.page.display()), score),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn parsed(text: &str) -> Options {
        match crate::Command::parse_from(text.split_whitespace()) {
            crate::Command::Blind(options) => options,
            _ => panic!("{text}"),
        }
    }

    #[test]
    fn the_command_on_the_page_gives_the_same_options() {
        let options = parsed("xtask blind --seed 7 --count 3 --jobs 1 --budget 90");
        assert_eq!((options.seed, options.count, options.jobs, options.budget), (7, 3, 1, Some(90)));
        assert!(parsed("xtask blind").seed > 20_000);
        assert_eq!(parsed(options.spelled().trim_start_matches("cargo ")), options);
    }

    #[test]
    fn every_step_is_a_module_of_the_suite_and_works_on_the_same_sets() {
        let workspace = Workspace::find().unwrap();
        let (python, program, sets) = (Path::new("python"), Path::new("motor-fmu"), Path::new("sets"));
        let steps = steps(&workspace, python, program, sets, &parsed("xtask blind --count 3")).unwrap();
        assert_eq!(steps.len(), 3);
        for (_, command) in steps {
            let arguments: Vec<_> = command.get_args().map(|a| a.to_str().unwrap()).collect();
            let module = arguments[1].strip_prefix("blind.").unwrap();
            assert!(
                command.get_current_dir().unwrap().join("blind").join(module).with_extension("py").is_file()
            );
            assert!(arguments.contains(&"sets") && arguments.contains(&"3"), "{arguments:?}");
        }
    }
}
