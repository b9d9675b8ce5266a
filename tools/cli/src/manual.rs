//! `motor-fmu completions` and `motor-fmu man`: completions of shells and manual pages, from the declaration of the commands.

use crate::existing::{Force, head};
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
    /// Folder to write to
    #[arg(long, value_name = "DIR", default_value = "man")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
}

pub fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "motor-fmu", &mut script);
    say(&String::from_utf8_lossy(&script));
    Ok(ExitCode::SUCCESS)
}

pub fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    crate::make_folder(&args.out)?;
    for entry in std::fs::read_dir(&args.out)?.flatten() {
        let name = entry.file_name();
        if name.to_string_lossy().starts_with("motor-fmu") {
            args.force.check(&entry.path(), "a manual page of motor-fmu", |path| {
                String::from_utf8_lossy(&head(path)).contains(".TH motor-fmu")
            })?;
        }
    }
    clap_mangen::generate_to(Cli::command(), &args.out)?;
    say(&format!("{}\n", args.out.display()));
    Ok(ExitCode::SUCCESS)
}
