//! `motor-fmu validate`: checks of any FMU.

use crate::Failure;
use crate::progress::Progress;
use archive::validate::{Finding, PATIENCE, Severity, dynamic, validate_within};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Check FMUs of FMI 2.0 and 3.0 statically and by running them.
///
/// Exit code 0: no errors. 1: the FMU violates the standard or its own declarations, or its archive is dangerous. 2: it cannot be read.
#[derive(clap::Args)]
pub struct Args {
    /// The FMUs.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
    /// Time limit of a call; a longer call is reported as a hang.
    #[arg(long, value_name = "SECONDS", default_value_t = PATIENCE.as_secs_f64(), value_parser = seconds)]
    patience: f64,
}

/// A time limit in s; the text may have another unit.
pub fn seconds(text: &str) -> Result<f64, String> {
    match units::number(text, "s") {
        Ok(s) if s > 0.0 && s <= 86_400.0 => Ok(s),
        _ => Err("it must be a number of seconds above 0, at most 86400".to_owned()),
    }
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    report_within(&args.files, args.json, args.patience)
}

/// Validates files and prints what was found.
pub fn report(files: &[PathBuf], as_json: bool) -> Result<ExitCode, Failure> {
    report_within(files, as_json, PATIENCE.as_secs_f64())
}

fn report_within(files: &[PathBuf], as_json: bool, patience: f64) -> Result<ExitCode, Failure> {
    let program = crate::program()?;
    let mut reports = Vec::new();
    let bar = Progress::new("validating");
    for (k, file) in files.iter().enumerate() {
        bar.set(&format!("validating {}", file.display()), k as f64 / files.len() as f64);
        reports.push((file, validate_within(file, &program, Duration::from_secs_f64(patience))));
    }
    bar.finish();
    if as_json {
        let entry = |(file, report): &(&PathBuf, Result<Vec<Finding>, _>)| match report {
            Ok(findings) => json!({"file": file.to_string_lossy(), "findings": findings}),
            Err(why) => json!({"file": file.to_string_lossy(), "findings": [], "error": format!("{why}")}),
        };
        let list: Vec<_> = reports.iter().map(entry).collect();
        crate::say(&format!("{}\n", serde_json::Value::from(list)));
    } else {
        for (file, findings) in
            reports.iter().filter_map(|(file, report)| Some((file, report.as_ref().ok()?)))
        {
            crate::say(&text(&file.to_string_lossy(), findings));
        }
    }
    // Files that cannot be validated do not hide the reports of the others.
    let failed: Vec<String> =
        reports.iter().filter_map(|(_, r)| Some(r.as_ref().err()?.to_string())).collect();
    if !failed.is_empty() {
        return Err(Failure::new(failed.join("\n")));
    }
    let found = reports.iter().filter_map(|(_, report)| report.as_ref().ok()).flatten();
    let breach = found.into_iter().any(|f| f.severity == Severity::Error);
    Ok(crate::outcome(!breach))
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

/// The child process of `validate`: loads and runs one FMU and prints each finding immediately.
#[derive(clap::Args)]
pub struct ProbeArgs {
    file: PathBuf,
    /// The stage to begin with.
    from: usize,
}

pub fn probe(args: &ProbeArgs) -> Result<ExitCode, Failure> {
    let channel = cosim::child::enter()?;
    dynamic::probe(&args.file, args.from, &mut |event| {
        channel.send(&serde_json::to_string(&event).unwrap_or_default());
    });
    channel.end()
}
