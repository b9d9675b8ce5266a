//! The motor-fmu command.

mod build;
mod close_loop;
mod cosim;
mod drawing;
mod existing;
mod info;
mod manual;
mod outputs;
mod parent;
mod pattern;
mod preset;
mod presets;
mod progress;
mod reproduce;
mod simulate;
mod study;
mod supervised;
mod unused;
mod usage;
mod validate;
mod variables;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// FMUs of a thermo-electromechanical motor: build, validate, simulate, calibrate.
///
/// Exit codes: 0 = success, 1 = check failed, 2 = could not run.
#[derive(Parser)]
#[command(name = "motor-fmu", bin_name = "motor-fmu", display_name = "motor-fmu", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Build(build::Args),
    Preset(preset::Args),
    Presets(presets::Args),
    Info(info::Args),
    Variables(variables::Args),
    Validate(validate::Args),
    Simulate(simulate::Args),
    Cosim(cosim::Args),
    Ssp(cosim::SspArgs),
    Steady(study::SteadyArgs),
    Sweep(study::SweepArgs),
    Reproduce(reproduce::Args),
    Fit(close_loop::FitArgs),
    CloseLoop(close_loop::Args),
    Completions(manual::CompletionsArgs),
    Man(manual::ManArgs),
    #[command(hide = true)]
    Probe(validate::ProbeArgs),
    #[command(hide = true)]
    Work(supervised::WorkArgs),
}

/// Why a command could not run: one sentence.
#[derive(Debug)]
pub struct Failure(String);

impl Failure {
    /// The failure with this sentence.
    pub fn new(sentence: impl Into<String>) -> Failure {
        Failure(sentence.into())
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Failure {
        Failure(error.to_string())
    }
}

/// Prints to stdout. A closed pipe is no failure; a full disk ends the command.
pub fn say(text: &str) {
    if parent::say(text) {
        return;
    }
    let mut out = std::io::stdout();
    let printed = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    if let Some(error) = printed.err().filter(|e| e.kind() != std::io::ErrorKind::BrokenPipe) {
        parent::complain(&format!("error: the standard output cannot be written: {error}"));
        std::process::exit(2);
    }
}

/// Prints notes to stderr, a line each.
pub fn remark(notes: &[String]) {
    for note in notes {
        parent::complain(&format!("note: {note}"));
    }
}

/// Prints a result for a script, indented.
pub fn say_json(result: &impl serde::Serialize) -> Result<(), Failure> {
    say(&format!("{}\n", serde_json::to_string_pretty(result)?));
    Ok(())
}

/// Writes a file.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|e| unwritten(path, &e))
}

/// Makes a folder where it is missing.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|e| unwritten(path, &e))
}

/// The failure to write a file or folder.
pub fn unwritten(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(format!("{} cannot be written: {error}", path.display()))
}

/// This program, which validates in processes of its own.
pub fn program() -> Result<PathBuf, Failure> {
    std::env::current_exe()
        .map_err(|e| Failure::new(format!("the path of this program cannot be determined: {e}")))
}

/// 0, or 1 where the command was carried out and a check failed, or a simulation ended before its stop time.
pub fn outcome(yes: bool) -> ExitCode {
    ExitCode::from(code(yes))
}

/// The number of [`outcome`].
pub fn code(yes: bool) -> u8 {
    u8::from(!yes)
}

fn main() -> ExitCode {
    let cli = usage::parse(std::env::args_os()).unwrap_or_else(|error| usage::refuse(&error));
    let outcome = match cli.command {
        Command::Build(args) => build::run(&args),
        Command::Preset(args) => preset::run(&args),
        Command::Presets(args) => presets::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Variables(args) => variables::run(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Simulate(args) => supervised::run(&args.file, args.input.as_deref(), args.patience),
        Command::Cosim(args) => supervised::run(&args.system, args.input.as_deref(), args.patience),
        Command::Ssp(args) => cosim::run_ssp(&args),
        Command::Steady(args) => study::run_steady(&args),
        Command::Sweep(args) => study::run_sweep(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Fit(args) => close_loop::run_fit(&args),
        Command::CloseLoop(args) => close_loop::run(&args),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
        Command::Probe(args) => validate::probe(&args),
        Command::Work(args) => supervised::work(&args),
    };
    outcome.unwrap_or_else(|Failure(sentence)| {
        parent::complain(&format!("error: {sentence}"));
        ExitCode::from(2)
    })
}
