//! Set-up, tests, demo, benchmarks and tidiness of the workspace: `cargo xtask <command>`.

mod bench;
mod blind;
mod cross;
mod demo;
mod describe;
mod files;
mod fuzz;
mod importers;
mod licenses;
mod miri;
mod mutants;
mod nightly;
mod page;
mod product;
mod shell;
mod stages;
mod test;
mod tidy;
mod venv;
mod wheel;
mod workspace;

use clap::Parser;
use std::path::PathBuf;
use std::process::ExitCode;
use workspace::Workspace;

/// A failure as one sentence.
type Outcome<T = ()> = Result<T, String>;

/// Commands in the order in which a new user needs them.
#[derive(Parser)]
#[command(name = "cargo xtask", about)]
enum Command {
    /// Build and validate the FMUs, simulate walking, close the loop on bench data, write dist/index.html.
    Demo(Force),
    /// Run the everyday tests: sources, Rust, FMUs, Python, mutants of changed files.
    Test,
    /// Run all tests: also removals, all mutants, fuzz, miri, cross, importers, page, wheel, blind, bench.
    Nightly {
        /// Stages, by default all.
        stages: Vec<String>,
    },
    /// Format, lints, dependency arrows, file lengths, generated files.
    Tidy,
    /// Write model-description/.
    Describe {
        /// Compare only.
        #[arg(long)]
        check: bool,
    },
    /// Write the list of licences for the archives.
    Licenses {
        /// Compare only.
        #[arg(long)]
        check: bool,
    },
    /// Run the benchmarks.
    Bench {
        /// Go to criterion: a name filter, `--save-baseline` ...
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Run close-loop on 400 synthetic benches of a new seed and write docs/blind-suite.md.
    Blind(blind::Options),
    /// Random calls of both C interfaces, with each model in turn.
    Fuzz(fuzz::Options),
    /// Tests of the C interface in Miri, which reports undefined behaviour.
    Miri,
    /// Run the archives in third-party Rust importers.
    Importers,
    /// Build one archive for three platforms and run it on each.
    Cross {
        /// A Rust with library sources.
        #[arg(long, value_name = "DIR")]
        toolchain: Option<PathBuf>,
    },
    /// Compile the models for WebAssembly and write dist/page.html, the interactive motor page.
    Page(Force),
    /// Pack a Python wheel with the program, the FMUs and the package motor_fmu into dist/.
    Wheel,
    /// Apply each mutation of the table and expect the tests to fail.
    Mutants {
        /// Mutants, by default all.
        names: Vec<String>,
    },
    /// Remove each effect in turn and compile the physics.
    Removals,
}

/// What may be overwritten in dist/.
#[derive(clap::Args)]
struct Force {
    /// Overwrite files that are no earlier results.
    #[arg(long)]
    force: bool,
}

fn main() -> ExitCode {
    let command = Command::parse();
    match Workspace::find().and_then(|workspace| run(&workspace, &command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("error: {sentence}");
            ExitCode::FAILURE
        }
    }
}

fn run(workspace: &Workspace, command: &Command) -> Outcome {
    match command {
        Command::Demo(Force { force }) => demo::run(workspace, *force),
        Command::Test => test::run(workspace),
        Command::Nightly { stages } => nightly::run(workspace, stages),
        Command::Tidy => tidy::run(workspace),
        Command::Describe { check: true } => describe::check(workspace),
        Command::Describe { check: false } => describe::run(workspace, &[]),
        Command::Licenses { check: true } => licenses::check(workspace),
        Command::Licenses { check: false } => licenses::write(workspace),
        Command::Bench { arguments } => bench::run(workspace, arguments),
        Command::Blind(options) => blind::run(workspace, options),
        Command::Fuzz(options) => fuzz::run(workspace, options),
        Command::Miri => miri::run(workspace),
        Command::Importers => importers::run(workspace),
        Command::Cross { toolchain } => cross::run(workspace, toolchain.as_deref()),
        Command::Page(Force { force }) => page::run(workspace, *force),
        Command::Wheel => wheel::run(workspace),
        Command::Mutants { names } => mutants::run(workspace, names),
        Command::Removals => mutants::removal::summary(workspace).1,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_commands_are_consistent() {
        <super::Command as clap::CommandFactory>::command().debug_assert();
    }
}
