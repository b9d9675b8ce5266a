//! The motor-fmu command.

mod build;
mod close_loop;
mod cosim;
mod reproduce;
mod simulate;
mod study;
mod unused;
mod validate;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// FMUs of a thermo-electromechanical motor: build, validate, simulate, calibrate.
///
/// Exit codes: 0 = success, 1 = check failed, 2 = could not run.
#[derive(Parser)]
#[command(name = "motor-fmu", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Build(build::Args),
    Validate(validate::Args),
    Simulate(simulate::Args),
    Cosim(cosim::Args),
    Ssp(cosim::SspArgs),
    Steady(study::SteadyArgs),
    Sweep(study::SweepArgs),
    Reproduce(reproduce::Args),
    CloseLoop(close_loop::Args),
    #[command(hide = true)]
    Probe(validate::ProbeArgs),
}

/// Why a command could not run: one sentence.
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

/// Prints to stdout. A closed pipe is no failure; `print!` would panic.
pub fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// Prints notes to stderr, a line each.
pub fn remark(notes: &[String]) {
    for note in notes {
        eprintln!("note: {note}");
    }
}

/// 0, or 1 where the command was carried out and a check failed, or a simulation ended before its stop time.
pub fn outcome(yes: bool) -> ExitCode {
    ExitCode::from(u8::from(!yes))
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Build(args) => build::run(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Simulate(args) => simulate::run(args),
        Command::Cosim(args) => cosim::run(args),
        Command::Ssp(args) => cosim::run_ssp(&args),
        Command::Steady(args) => study::run_steady(&args),
        Command::Sweep(args) => study::run_sweep(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::CloseLoop(args) => close_loop::run(&args),
        Command::Probe(args) => validate::probe(&args),
    };
    outcome.unwrap_or_else(|Failure(sentence)| {
        eprintln!("error: {sentence}");
        ExitCode::from(2)
    })
}
