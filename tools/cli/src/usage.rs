//! Errors of the command line: one sentence each, as all other errors.

use crate::Cli;
use crate::parent::complain;
use clap::error::{Error, ErrorKind};
use clap::{Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// The command line. Every option with a value takes negative numbers, so that its limits are named and not an unknown argument.
pub fn parse(line: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result<Cli, Error> {
    Cli::from_arg_matches(&command().try_get_matches_from(line)?)
}

fn command() -> Command {
    fn negative(command: Command) -> Command {
        let takes = |arg: &clap::Arg| !arg.is_positional() && arg.get_action().takes_values();
        let all = command.mut_args(|arg| if takes(&arg) { arg.allow_negative_numbers(true) } else { arg });
        all.mut_subcommands(negative)
    }
    negative(Cli::command())
}

/// Prints help or version where they were asked for, else the error, and ends the program.
pub fn refuse(error: &Error) -> ! {
    use ErrorKind::{DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand, DisplayVersion};
    if matches!(error.kind(), DisplayHelp | DisplayHelpOnMissingArgumentOrSubcommand | DisplayVersion) {
        error.exit();
    }
    complain(&format!("error: {}", sentence(&error.render().to_string(), std::env::args())));
    std::process::exit(2);
}

/// The paragraphs of a rendered error as one sentence: what is wrong, tips, and the command whose help has the options.
fn sentence(rendered: &str, line: impl Iterator<Item = String>) -> String {
    let paragraphs = rendered.split("\n\n").map(|p| p.split_whitespace().collect::<Vec<_>>().join(" "));
    let mut text = String::new();
    // An error of a value has no paragraph of the usage.
    let mut command = called(line);
    for paragraph in paragraphs {
        if let Some(what) = paragraph.strip_prefix("error: ") {
            // Rust's words for a number that cannot be read.
            text += &what.replace("invalid float literal", "expected a number");
            text = text.replace("invalid digit found in string", "expected a whole number");
        } else if let Some(usage) = paragraph.strip_prefix("Usage: ") {
            let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_lowercase());
            command = usage.split(' ').take_while(is_name).collect::<Vec<_>>().join(" ");
        } else if let Some(tip) = paragraph.strip_prefix("tip: ") {
            text += &format!("; {}", tip.replace(" tip: ", "; "));
        }
    }
    format!("{text}; `{command} --help` lists the options")
}

/// The command with its subcommands in a command line.
fn called(line: impl Iterator<Item = String>) -> String {
    let (mut command, mut name) = (Cli::command(), "motor-fmu".to_owned());
    for word in line.skip(1) {
        let Some(inner) = command.find_subcommand(&word) else { break };
        name += &format!(" {word}");
        command = inner.clone();
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(arguments: &[&str]) -> String {
        let line: Vec<String> =
            ["motor-fmu"].iter().chain(arguments).map(|word| (*word).to_owned()).collect();
        let error = command().try_get_matches_from(&line).unwrap_err();
        sentence(&error.render().to_string(), line.into_iter())
    }

    /// For every subcommand: an unknown option, which is the case of every typing error.
    #[test]
    fn each_refusal_is_one_sentence() {
        let names: Vec<String> = crate::Cli::command()
            .get_subcommands()
            .filter(|c| !c.is_hide_set())
            .map(|c| c.get_name().to_owned())
            .collect();
        assert!(names.len() > 10);
        for name in &names {
            let said = said(&[name, "--no-such-option"]);
            assert!(said.starts_with("unexpected argument '--no-such-option' found"), "{said}");
            assert!(said.ends_with(&format!("`motor-fmu {name} --help` lists the options")), "{said}");
            assert!(!said.contains('\n'));
        }
        for (arguments, words) in [
            (&["steady", "--pre-set", "x"][..], "; a similar argument exists: '--preset';"),
            (&["sweep"], "the following required arguments were not provided: --vary"),
            (
                &["stedy"],
                "unrecognized subcommand 'stedy'; a similar subcommand exists: 'steady'; `motor-fmu --help`",
            ),
            (&["build", "--fmi", "4"], "invalid value '4' for '--fmi"),
            (
                &["steady", "--plot", "x.png"],
                "were not provided: --load <load.toml>; `motor-fmu steady --help`",
            ),
            (&["preset", "new", "--torque", "3"], "`motor-fmu preset new --help`"),
            (&["simulate", "x", "--set", "voltage"], "expected name=value; `motor-fmu simulate --help`"),
            (&["simulate", "x", "--stop", "soon"], "expected a number in s; `motor-fmu simulate --help`"),
            (&["simulate", "x", "--every", "-1"], "-1 is not in 1.."),
            (&["simulate", "x", "--patience", "-3"], "above 0, at most 86400"),
            (&["cosim", "x", "--every", "0"], "0 is not in 1.."),
            (&["cosim", "x", "--threads", "0"], "0 is not in 1..=1024"),
            (&["cosim", "x", "--threads", "2000"], "2000 is not in 1..=1024"),
            (&["cosim", "x", "--threads", "two"], "expected a whole number"),
            (&["fit", "x", "--budget", "-1"], "'-1' for '--budget <SECONDS>'"),
        ] {
            let said = said(arguments);
            assert!(said.contains(words) && !said.contains('\n'), "{said}");
        }
    }
}
