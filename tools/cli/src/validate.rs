//! `motor-fmu validate`: what is wrong with an FMU, ours or not.

use crate::Failure;
use archive::validate::{Finding, Severity, dynamic, validate};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Checks FMUs of FMI 2.0 and 3.0, statically and by running them.
///
/// Exit code 0: no errors. 1: a breach of the standard or of the FMU's own declarations. 2: not readable.
#[derive(clap::Args)]
pub struct Args {
    /// The FMUs.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    report(&args.files, args.json)
}

/// Validates files and prints what was found.
pub fn report(files: &[PathBuf], as_json: bool) -> Result<ExitCode, Failure> {
    let program =
        std::env::current_exe().map_err(|e| Failure::new(format!("this program is not to be found: {e}")))?;
    let mut reports = Vec::new();
    for file in files {
        reports.push((file, validate(file, &program)?));
    }
    if as_json {
        let list: Vec<_> = reports
            .iter()
            .map(|(file, findings)| json!({"file": file.to_string_lossy(), "findings": findings}))
            .collect();
        crate::say(&format!("{}\n", serde_json::Value::from(list)));
    } else {
        for (file, findings) in &reports {
            crate::say(&text(&file.to_string_lossy(), findings));
        }
    }
    let breach = reports.iter().flat_map(|(_, findings)| findings).any(|f| f.severity == Severity::Error);
    Ok(if breach { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

fn text(file: &str, findings: &[Finding]) -> String {
    let count = |severity| findings.iter().filter(|f| f.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let mut text = format!("{file}: {errors} errors, {warnings} warnings\n");
    for f in findings {
        let severity = format!("{:?}", f.severity).to_lowercase();
        text += &format!("  {severity} [{}] {}: {}\n", f.code, f.place, f.message);
    }
    text
}

/// The child of `validate`: loads and runs one FMU and prints what it saw.
#[derive(clap::Args)]
pub struct ProbeArgs {
    file: PathBuf,
}

/// Runs the child.
pub fn probe(args: &ProbeArgs) -> Result<ExitCode, Failure> {
    let seen = dynamic::probe(&args.file);
    crate::say(&serde_json::to_string(&seen)?);
    Ok(ExitCode::SUCCESS)
}
