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

use std::process::ExitCode;
use workspace::Workspace;

/// A failure as one sentence.
type Outcome<T = ()> = Result<T, String>;

/// A command: name, description, and the function that takes the arguments.
type Command = (&'static str, &'static str, fn(&Workspace, &[String]) -> Outcome);

/// In the order in which a new user needs them.
const COMMANDS: &[Command] = &[
    (
        "demo",
        "build and validate the FMUs, walk for 20 minutes, close the loop on bench data, write dist/index.html",
        demo::run,
    ),
    ("test", "runs the everyday tests: sources, Rust, FMUs, Python, mutants of changed files", test::run),
    (
        "nightly",
        "runs all tests: also removals, all mutants, fuzz, cross, importers, page, wheel, blind, bench",
        nightly::run,
    ),
    ("tidy", "format, lints, dependency arrows, file lengths, generated files", tidy::run),
    ("describe", "write model-description/ (with --check: compare only)", describe::run),
    ("licenses", "write the list of licences for the archives (with --check: compare only)", licenses::run),
    ("bench", "run the benchmarks; further arguments go to criterion", bench::run),
    ("blind", "run close-loop on 120 synthetic benches and write docs/blind-suite.md", blind::run),
    (
        "fuzz",
        "random calls of both C interfaces, --calls 2000000 of each model; --valgrind checks memory",
        fuzz::run,
    ),
    ("importers", "run the archives in third-party Rust importers", importers::run),
    (
        "cross",
        "build one archive for three platforms and run it on each; --toolchain DIR names a Rust with library sources",
        cross::run,
    ),
    ("page", "compile the models for WebAssembly and write dist/page.html, a page to try motors", page::run),
    (
        "wheel",
        "pack a Python wheel with the program, the FMUs and the package motor_fmu into dist/",
        wheel::run,
    ),
    (
        "mutants",
        "apply each mutation of the table and expect the tests to fail; arguments name mutants",
        mutants::run,
    ),
    ("removals", "remove each effect in turn and compile the physics", mutants::removal::run),
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

/// An error where a command that takes no arguments is given one.
fn no_arguments(name: &str, arguments: &[String]) -> Outcome {
    match arguments.first() {
        Some(extra) => Err(format!("`{name}` takes no arguments, got {extra:?}")),
        None => Ok(()),
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
