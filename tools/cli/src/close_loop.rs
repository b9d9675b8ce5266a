//! `motor-fmu close-loop`: finds the effect that the model lacks in bench data and adds it to the FMUs.

mod export;
mod page;
mod replay;
mod text;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use crate::{Failure, write};
use calibrate::experiment::Experiment;
use calibrate::outcome::Outcome;
use calibrate::report::{Replay, Report};
use describe::Preset;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

/// Find the effects that the model lacks in bench data, add them to the FMUs and report the errors before and after.
///
/// Writes report.json and report.html, preset.toml with the calibrated values, effects.json with the terms that were added, and
/// the FMUs of both standards, which are then run on the data.
/// Exit code 0 for any verdict; 1 if the outputs of an FMU differ from the report or the validator finds errors in it.
#[derive(clap::Args)]
pub struct Args {
    /// The experiment: TOML file with the runs, their roles and the priors of the parameters
    #[arg(value_name = "EXPERIMENT.toml")]
    experiment: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print report.json
    #[arg(long)]
    json: bool,
}

/// Fraction of the progress that the search takes; the rest is export and replay.
const SEARCH: f64 = 0.9;

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let begun = std::time::Instant::now();
    let experiment = Experiment::read(&args.experiment)?;
    let preset = preset(&experiment, &args.experiment)?;
    // Before minutes of work: a folder that cannot be written to is bad input too.
    crate::make_folder(&args.out)?;
    let bar = crate::progress_bar(1000, "{wide_bar} {percent:>3} %  {msg}");
    let outcome = calibrate::close_loop::run(&experiment, &preset.starts.entries(), &|share, what| {
        bar.set_message(what.to_owned());
        bar.set_position((1000.0 * SEARCH * share.clamp(0.0, 1.0)) as u64);
    })?;
    bar.set_message("export");
    let exported = export::export(&experiment, &outcome, &args.out)?;
    bar.set_position(950);
    bar.set_message("replay");
    let (replay, findings) = thread::scope(|scope| {
        let findings = scope.spawn(|| exported.findings());
        let replay = replay::replay(&experiment, &outcome, &exported);
        (replay, findings.join().unwrap_or_else(|e| resume_unwind(e)))
    });
    let (replay, findings) = (replay?, findings?);
    bar.finish_and_clear();
    let mut notes = outcome.notes.clone();
    notes.extend(findings.iter().cloned());
    notes.extend(text::unused_inputs(exported.kind, &exported.preset.starts, &outcome.export.terms));
    if !replay.agrees || !replay.left_out.is_empty() || replay.channels.is_empty() {
        notes.push(text::replay(&replay));
    }
    let report = Report::new(&outcome, &exported.names, Some(&replay), &notes, begun.elapsed().as_secs_f64());
    let json = format!("{}\n", serde_json::to_string_pretty(&report)?);
    write(&args.out.join("report.json"), &json)?;
    let page = page::page(&experiment, &outcome, &replay, &notes, (exported.kind.declaration)());
    write(&args.out.join("report.html"), &page)?;
    crate::say(&if args.json { json } else { summary(&outcome, &replay, &notes, &args.out) });
    // FMI 3 has no input derivatives: a term with constant drivers over a row has them constant over each substep there.
    let faithful = replay.channels.iter().all(|c| c.standard != "fmi2" || c.difference <= replay.limit);
    outcome.endings.iter().for_each(|why| eprintln!("error: {why}"));
    Ok(crate::outcome(faithful && findings.is_empty() && outcome.endings.is_empty()))
}

/// The experiment's preset: a file beside the experiment, else a built-in one or a file from here.
fn preset(experiment: &Experiment, file: &Path) -> Result<Preset, Failure> {
    let beside = file.parent().unwrap_or(Path::new("")).join(&experiment.preset);
    let name =
        if beside.is_file() { beside.to_string_lossy().into_owned() } else { experiment.preset.clone() };
    let preset = Preset::load(&name).map_err(|e| Failure::new(format!("{}: {e}", file.display())))?;
    if preset.model != experiment.model {
        return Err(Failure::new(format!(
            "{}: the preset {} is for {} and not for {}",
            file.display(),
            preset.name,
            preset.model,
            experiment.model
        )));
    }
    Ok(preset)
}

/// The text on the terminal.
fn summary(outcome: &Outcome, replay: &Replay, notes: &[String], out: &Path) -> String {
    let mut text = format!("{}: {}\n", outcome.name, text::verdict(outcome));
    text += &format!(
        "\n{:8} {:30} {:>10} {:>10} {:>10} {:>10}\n",
        "role", "error (RMSE) of", "before", "refit", "after", "noise"
    );
    for e in &outcome.errors {
        let [before, refit, after, floor] = [e.before, e.refit, e.after, e.floor].map(text::number);
        let role = calibrate::report::role_name(e.role);
        text += &format!("{role:8} {:30} {before:>10} {refit:>10} {after:>10} {floor:>10}\n", e.column);
    }
    text += &format!("\n{}\n", text::replay(replay));
    for note in notes.iter().filter(|n| **n != text::replay(replay)) {
        text += &format!("note: {note}\n");
    }
    text + &format!("{}: report.html, report.json, preset.toml, fmi2, fmi3\n", out.display())
}
