//! `motor-fmu presets`: the built-in presets.

use crate::{Failure, say, say_json};
use describe::Preset;
use serde_json::json;
use std::process::ExitCode;

/// List the built-in presets: name, model, description
///
/// Each is a file of `examples/presets` with a source and a certainty for every value.
#[derive(clap::Args)]
pub struct Args {
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let presets = Preset::built_in()?;
    if args.json {
        let all =
            presets.iter().map(|p| json!({"name": p.name, "model": p.model, "description": p.description}));
        say_json(&all.collect::<Vec<_>>())?;
    } else {
        let width = |of: fn(&Preset) -> &str| presets.iter().map(|p| of(p).len()).max().unwrap_or(0);
        let (name, model) = (width(|p| &p.name), width(|p| &p.model));
        for p in &presets {
            say(&format!("{:name$}  {:model$}  {}\n", p.name, p.model, p.description));
        }
    }
    Ok(ExitCode::SUCCESS)
}
