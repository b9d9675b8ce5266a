//! `motor-fmu completions` and `motor-fmu man`: completions of shells and manual pages, from the declaration of the commands.

use crate::{Cli, Failure, say};
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::PathBuf;
use std::process::ExitCode;

/// Print the completions for a shell
///
/// For bash: motor-fmu completions bash > ~/.local/share/bash-completion/completions/motor-fmu
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Write the manual pages, motor-fmu.1 and one for each command
#[derive(clap::Args)]
pub struct ManArgs {
    /// Folder to write to; existing pages are replaced
    #[arg(long, value_name = "DIR", default_value = "man")]
    out: PathBuf,
}

pub fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "motor-fmu", &mut script);
    say(&String::from_utf8_lossy(&script));
    Ok(ExitCode::SUCCESS)
}

pub fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    crate::make_folder(&args.out)?;
    clap_mangen::generate_to(Cli::command(), &args.out)?;
    say(&format!("{}\n", args.out.display()));
    Ok(ExitCode::SUCCESS)
}
