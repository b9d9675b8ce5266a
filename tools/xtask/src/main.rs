//! Set-up, tests, demo, benchmarks and tidiness of the workspace: `cargo xtask <command>`.

mod bench;
mod blind;
mod cross;
mod demo;
mod describe;
mod fuzz;
mod importers;
mod licenses;
mod mutants;
mod nightly;
mod product;
mod shell;
mod stages;
mod test;
mod tidy;
mod venv;
mod workspace;

use std::process::ExitCode;
use workspace::Workspace;

/// A failure as one clear sentence.
type Outcome<T = ()> = Result<T, String>;

/// A command: its name, what it does, and the function that does it with the arguments that follow.
type Command = (&'static str, &'static str, fn(&Workspace, &[String]) -> Outcome);

/// In the order in which a newcomer needs them.
const COMMANDS: &[Command] = &[
    (
        "demo",
        "build and validate the FMUs, walk for 20 minutes, close the loop on bench data, write dist/index.html",
        demo::run,
    ),
    ("test", "runs the everyday tests: sources, Rust, FMUs, Python, mutants of changed files", test::run),
    (
        "nightly",
        "runs all tests: also removals, all mutants, fuzz, cross, importers, blind, bench",
        nightly::run,
    ),
    ("tidy", "format, lints, dependency arrows, file lengths, generated files", tidy::run),
    ("describe", "write model-description/ anew (with --check: compare only)", describe::run),
    (
        "licenses",
        "write the list of licences for the archives anew (with --check: compare only)",
        licenses::run,
    ),
    ("bench", "benchmarks; further arguments go to criterion", bench::run),
    (
        "blind",
        "a hundred and more synthetic benches through the closed loop, into docs/blind-suite.md",
        blind::run,
    ),
    (
        "fuzz",
        "random calls of both C interfaces, --calls 2000000 of each model; --valgrind checks memory",
        fuzz::run,
    ),
    ("importers", "the archives in other people's Rust importers", importers::run),
    (
        "cross",
        "one archive for three platforms, run on each; --toolchain DIR names a Rust with the sources of its library",
        cross::run,
    ),
    (
        "mutants",
        "apply each mutation of the table and expect the tests to fail; arguments name mutants",
        mutants::run,
    ),
    ("removals", "take each effect out in turn and see the physics compile", mutants::removal::run),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("error: {sentence}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: &[String]) -> Outcome {
    let (name, rest) = match arguments.split_first() {
        None => return Err(format!("no command given\n{}", usage())),
        Some((name, _)) if ["help", "-h", "--help"].contains(&name.as_str()) => {
            println!("{}", usage());
            return Ok(());
        }
        Some(split) => split,
    };
    match COMMANDS.iter().find(|(known, ..)| known == name) {
        Some((.., run)) => run(&Workspace::find()?, rest),
        None => Err(format!("there is no command {name:?}\n{}", usage())),
    }
}

fn usage() -> String {
    let mut text = String::from("usage: cargo xtask <command>");
    for (name, what, _) in COMMANDS {
        text += &format!("\n  {name:<9} {what}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_is_in_the_usage_once() {
        for (name, ..) in COMMANDS {
            assert_eq!(usage().matches(&format!("\n  {name} ")).count(), 1, "{name}");
        }
    }

    #[test]
    fn an_unknown_command_is_named() {
        let error = dispatch(&["frobnicate".into()]).unwrap_err();
        assert!(error.contains("\"frobnicate\"") && error.contains("usage"), "{error}");
    }
}
