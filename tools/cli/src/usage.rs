//! Errors of the command line: one sentence each, as all other errors.

use crate::parent::complain;
use clap::error::{Error, ErrorKind};

/// Prints help or version where they were asked for, else the error, and ends the program.
pub fn refuse(error: &Error) -> ! {
    use ErrorKind::{DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand, DisplayVersion};
    if matches!(error.kind(), DisplayHelp | DisplayHelpOnMissingArgumentOrSubcommand | DisplayVersion) {
        error.exit();
    }
    complain(&format!("error: {}", sentence(&error.render().to_string())));
    std::process::exit(2);
}

/// The paragraphs of a rendered error as one sentence: what is wrong, tips, and the command whose help has the options.
fn sentence(rendered: &str) -> String {
    let paragraphs = rendered.split("\n\n").map(|p| p.split_whitespace().collect::<Vec<_>>().join(" "));
    let mut text = String::new();
    let mut command = "motor-fmu".to_owned();
    for paragraph in paragraphs {
        if let Some(what) = paragraph.strip_prefix("error: ") {
            text += what;
        } else if let Some(usage) = paragraph.strip_prefix("Usage: ") {
            let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_lowercase());
            command = usage.split(' ').take_while(is_name).collect::<Vec<_>>().join(" ");
        } else if let Some(tip) = paragraph.strip_prefix("tip: ") {
            text += &format!("; {}", tip.replace(" tip: ", "; "));
        }
    }
    format!("{text}; `{command} --help` lists the options")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

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
            let arguments = ["motor-fmu", name, "--no-such-option"];
            let error = crate::Cli::command().try_get_matches_from(arguments).unwrap_err();
            let said = sentence(&error.render().to_string());
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
        ] {
            let line = std::iter::once("motor-fmu").chain(arguments.iter().copied());
            let error = crate::Cli::command().try_get_matches_from(line).unwrap_err();
            let said = sentence(&error.render().to_string());
            assert!(said.contains(words) && !said.contains('\n'), "{said}");
        }
    }
}
