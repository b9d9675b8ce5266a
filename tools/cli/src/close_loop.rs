//! `motor-fmu close-loop`: finds the effect that the model lacks in bench data and adds it to the FMUs.

mod export;
mod page;
mod provenance;
mod replay;
mod text;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use crate::existing::{Force, head};
use crate::parent::complain;
use crate::progress::Progress;
use crate::{Failure, write};
use archive::build::{Standard, TermsFile, archive_path};
use calibrate::close_loop::{self, Extent, Options};
use calibrate::deadline::Deadline;
use calibrate::experiment::Experiment;
use calibrate::intake::{self, Illustration, Refusal, Unusable};
use calibrate::outcome::{Outcome, Verdict};
use calibrate::report::{Provenance, Replay, Report};
use describe::{Preset, models};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

/// Find the effects that the model lacks in bench data, add them to the FMUs and report the errors before and after.
///
/// Writes report.json and report.html, residuals.csv, preset.toml with the calibrated values, effects.json with the terms that were added, and
/// the FMUs of both standards, which are then run on the data.
/// Exit code 0 for every verdict except `unusable`; 1 if the data are unusable, the errors (RMSE) of an FMU differ from the report or the validator finds errors in it.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: Files,
}

/// Fit the declared parameters of a model to bench data, without a search for missing effects.
///
/// Reads the same experiment and writes the same files as close-loop, except effects.json.
/// Exit code 0 for a fit; 1 if the data are unusable, the errors (RMSE) of an FMU differ from the report or the validator finds errors in it.
#[derive(clap::Args)]
pub struct FitArgs {
    #[command(flatten)]
    files: Files,
}

#[derive(clap::Args)]
struct Files {
    /// The experiment: TOML file with the runs, their roles and the priors of the parameters
    #[arg(value_name = "EXPERIMENT.toml")]
    experiment: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print report.json
    #[arg(long)]
    json: bool,
    /// Wall time for everything, s: the computation ends in time for export and replay, with the best result so far
    #[arg(long, value_name = "SECONDS", default_value_t = 45.0, value_parser = crate::validate::seconds)]
    budget: f64,
}

/// Fraction of the progress that the search takes; the rest is export and replay.
const SEARCH: f64 = 0.9;
/// Fraction of the time budget that is kept for export, validation and replay.
const KEPT: f64 = 0.4;

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    calibrate(&args.files, false)
}

pub fn run_fit(args: &FitArgs) -> Result<ExitCode, Failure> {
    calibrate(&args.files, true)
}

fn calibrate(args: &Files, fit_only: bool) -> Result<ExitCode, Failure> {
    let begun = std::time::Instant::now();
    let mut experiment = Experiment::read(&args.experiment)?;
    let preset = preset(&experiment, &args.experiment)?;
    let made_of = provenance::of(&args.experiment, &experiment)?;
    may_write(args, &experiment, fit_only)?;
    // Before minutes of work: a folder that cannot be written to is bad input too.
    crate::make_folder(&args.out)?;
    let bar = Progress::new("checking the data");
    let read = experiment.clone();
    // Checks come before the search: what is found in data that were not checked may be an ordinary mistake.
    let checked = Deadline::after(Duration::from_secs_f64((1.0 - KEPT) * args.budget));
    let checked = intake::check(&mut experiment, &preset.starts.entries(), &checked);
    let searched = checked.and_then(|is_checked| {
        let left = (1.0 - KEPT) * args.budget - begun.elapsed().as_secs_f64();
        let options = Options {
            budget: Some(Duration::from_secs_f64(left.max(0.1))),
            extent: match (fit_only, is_checked) {
                (true, _) => Extent::Fit,
                (false, true) => Extent::Search,
                (false, false) => Extent::Unchecked,
            },
        };
        close_loop::run(&experiment, &preset.starts.entries(), options, &|share, what| {
            bar.set(what, SEARCH * share.clamp(0.0, 1.0));
        })
    });
    let outcome = match searched {
        Ok(outcome) => outcome,
        Err(Refusal::Input(error)) => return Err(error.into()),
        Err(Refusal::Unusable(why)) => {
            bar.finish();
            let time = Deadline::after(Duration::from_secs_f64(KEPT * args.budget));
            let found = intake::illustration(&read, &preset.starts.entries(), &why, &time);
            let why = (&why, found.as_ref());
            return unusable(args, &experiment, why, &made_of, begun.elapsed().as_secs_f64());
        }
    };
    // The file that was left out is no part of what is replayed and shown.
    let [experiment, read] = match &outcome.left_out {
        Some(file) => [experiment.without(file), read.without(file)],
        None => [experiment, read],
    };
    bar.set("export", SEARCH);
    let exported = export::export(&experiment, &outcome, &made_of, &args.out)?;
    bar.set("replay", 0.95);
    let (replay, findings) = thread::scope(|scope| {
        let findings = scope.spawn(|| exported.findings());
        let replay = replay::replay(&experiment, &outcome, &exported);
        (replay, findings.join().unwrap_or_else(|e| resume_unwind(e)))
    });
    let (replay, findings) = (replay?, findings?);
    bar.finish();
    let mut notes = outcome.notes.clone();
    if outcome.is_cut {
        notes.push(format!(
            "the time budget of {} s ended the search, after {:.0} s of checks and search (the rest is kept for export and replay): this is the \
             best answer so far; --budget sets another one",
            args.budget,
            (1.0 - KEPT) * args.budget
        ));
    }
    notes.extend(findings.iter().cloned());
    notes.extend(text::unused_inputs(exported.kind, &exported.preset.starts, &outcome.export.terms));
    if !replay.agrees {
        notes.push(text::replay(&replay));
    }
    let texts: Vec<&str> = notes.iter().map(String::as_str).collect();
    notes.extend(text::own_headers(&experiment, &texts));
    let report = Report::new(
        &outcome,
        &exported.names,
        Some(&replay),
        &notes,
        (begun.elapsed().as_secs_f64(), args.budget),
    )
    .made_of(&made_of);
    let json = format!("{}\n", serde_json::to_string_pretty(&report)?);
    write(&args.out.join("report.json"), &json)?;
    let declaration = (exported.kind.declaration)();
    let data = page::Data { used: &experiment, read: &read };
    let page = page::page(data, &outcome, &replay, &notes, declaration, &made_of);
    write(&args.out.join("report.html"), &page)?;
    write(&args.out.join("residuals.csv"), &text::residuals(&outcome))?;
    crate::say(&if args.json { json } else { summary(&outcome, &replay, &notes, &args.out) });
    outcome.endings.iter().for_each(|why| complain(&format!("error: {why}")));
    Ok(crate::outcome(replay.agrees && findings.is_empty() && outcome.endings.is_empty()))
}

/// Refuses files of a folder that are no earlier results of the same command and experiment.
fn may_write(args: &Files, experiment: &Experiment, fit_only: bool) -> Result<(), Failure> {
    let Experiment { name, model, .. } = experiment;
    let command = if fit_only { "fit" } else { "close-loop" };
    let what = format!("an earlier result of {command} for the experiment {name}");
    let (force, at) = (args.force, |file: &str| args.out.join(file));
    let fitted = Verdict::Fitted.name();
    force.check(&at("report.json"), &what, |path| {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let verdict = report["verdict"].as_str();
        report["name"].as_str() == Some(name)
            && (verdict == Some("unusable") || (verdict == Some(fitted)) == fit_only)
    })?;
    force.check_titled(&at("report.html"), &what, |title| *title == page::title(name))?;
    force.check(&at("preset.toml"), &what, |path| {
        let text = String::from_utf8_lossy(&head(path)).into_owned();
        let first = text.lines().next().unwrap_or_default();
        let is_fitted = text.contains(&format!("; verdict: {fitted}\""));
        first.starts_with(export::HEADER)
            && first.contains(&format!(" the experiment {name}, "))
            && is_fitted == fit_only
    })?;
    force.check(&at("effects.json"), &what, |path| TermsFile::load(path).is_ok())?;
    force.check(&at("residuals.csv"), &what, |path| {
        String::from_utf8_lossy(&head(path)).starts_with(text::RESIDUALS)
    })?;
    let model = models::by_name(model).map_or(model.as_str(), |kind| (kind.declaration)().name);
    Standard::ALL
        .iter()
        .try_for_each(|standard| force.check_fmu(&archive_path(&args.out, *standard, model), model))
}

/// Report and page on data of which nothing can be said. What an earlier run wrote beside them is no answer to these data.
fn unusable(
    args: &Files,
    experiment: &Experiment,
    (why, found): (&Unusable, Option<&Illustration>),
    made_of: &Provenance,
    seconds: f64,
) -> Result<ExitCode, Failure> {
    let kind = models::by_name(&experiment.model)
        .ok_or_else(|| Failure::new(format!("unknown model {}", experiment.model)))?;
    let model = (kind.declaration)().name;
    let archives = ["fmi2", "fmi3"].map(|folder| args.out.join(folder).join(format!("{model}.fmu")));
    for path in ["preset.toml", "effects.json", "residuals.csv"]
        .map(|file| args.out.join(file))
        .iter()
        .chain(&archives)
    {
        if path.is_file() {
            std::fs::remove_file(path).map_err(|e| crate::unwritten(path, &e))?;
        }
    }
    let report = Report::unusable((&experiment.name, model), why, &experiment.notes, (seconds, args.budget))
        .made_of(made_of);
    let json = format!("{}\n", serde_json::to_string_pretty(&report)?);
    write(&args.out.join("report.json"), &json)?;
    write(
        &args.out.join("report.html"),
        &page::unusable(experiment, (why, found), (kind.declaration)(), made_of),
    )?;
    let mut text =
        format!("{}: unusable: {}.\n{}.\n", experiment.name, why.reason, page::capital(&why.suggestion));
    for note in experiment.notes.iter().cloned().chain(text::own_headers(experiment, &[&why.reason])) {
        text += &format!("note: {note}\n");
    }
    crate::say(if args.json { &json } else { &text });
    Ok(crate::outcome(false))
}

/// The experiment's preset: a file beside the experiment, else a built-in one or a file from here.
fn preset(experiment: &Experiment, file: &Path) -> Result<Preset, Failure> {
    let beside = delimited::folder(file).join(&experiment.preset);
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
        "\n{:8} {:30} {:>10} {:>10} {:>10} {:>10} {:>10}\n",
        "role", "error (RMSE) of", "before", "refit", "after", "noise", "black box"
    );
    for e in &outcome.errors {
        let [before, refit, after, floor] = [e.before, e.refit, e.after, e.floor].map(text::number);
        let role = calibrate::report::role_name(e.role);
        let blackbox = e.blackbox.map_or(String::new(), text::number);
        text += &format!(
            "{role:8} {:30} {before:>10} {refit:>10} {after:>10} {floor:>10} {blackbox:>10}\n",
            e.column
        );
    }
    text += &text::parameters(outcome);
    text += &format!("\n{}\n", text::replay(replay));
    for note in notes.iter().filter(|n| **n != text::replay(replay)) {
        text += &format!("note: {note}\n");
    }
    text + &format!("{}: report.html, report.json, residuals.csv, preset.toml, fmi2, fmi3\n", out.display())
}
