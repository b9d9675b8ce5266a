//! The exported FMUs over the runs once more, through the C functions of the standards.
//!
//! Inputs are linear between rows: FMI 2 takes their derivatives with a call, FMI 3 in intermediate update mode. One step leads from row to row,
//! in both with the numbers of the native model.

use super::export::{Exported, terms};
use crate::Failure;
use archive::build::{Contents, Standard, build};
use calibrate::experiment::{Experiment, Role};
use calibrate::outcome::{Outcome, Setting};
use calibrate::report::{ROLES, Replay, ReplayedChannel, role_name};
use calibrate::simulate::Drive;
use cosim::{Archive, Causality, Instance, Kind, Log, ModelDescription, Step, Value, Variable};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Tolerance of the FMU's error relative to the model's, as a fraction of the channel's range.
const LIMIT: f64 = 1e-6;

/// Runs every test run (without readings in such, every validation run, else those that were fitted) with both archives.
pub fn replay(experiment: &Experiment, outcome: &Outcome, exported: &Exported) -> Result<Replay, Failure> {
    let has = |role: &Role| outcome.errors.iter().any(|e| e.role == *role);
    let role = ROLES.into_iter().rev().find(has).unwrap_or(Role::Fit);
    let of_role =
        || experiment.runs.iter().zip(&outcome.settings).enumerate().filter(|(_, (r, _))| r.role == role);
    let mut replayed: Vec<String> = of_role().map(|(_, (r, _))| r.file.clone()).collect();
    replayed.dedup();
    let open = |(standard, path): &(Standard, PathBuf)| Ok((*standard, Archive::open(path)?));
    let archives = exported.archives.iter().map(open).collect::<Result<Vec<_>, Failure>>()?;
    let (_, first) = archives.first().ok_or_else(|| Failure::new("no archive was exported"))?;
    let starts = |setting: &Setting| differences(experiment, setting, outcome, exported, first.description());
    let replay_one = |(standard, archive): &(Standard, Archive)| -> Result<Vec<ReplayedChannel>, Failure> {
        let mut sums: Vec<Sum> = experiment.outputs.iter().map(|_| Sum::default()).collect();
        for (place, (run, setting)) in of_role() {
            let drive = Drive::new(experiment, run)?;
            let shown = if carries(setting, outcome) {
                shown(archive, &starts(setting), experiment, &drive)?
            } else {
                // A run with its own terms needs a separate archive.
                let folder = tempfile::tempdir().map_err(|e| {
                    Failure::new(format!("no temporary folder to replay in (TMPDIR sets its place): {e}"))
                })?;
                let effects = terms(outcome, setting)?;
                let contents = Contents {
                    preset: Some(&exported.preset),
                    effects: effects.as_ref(),
                    ..Contents::default()
                };
                let path = build(exported.kind, *standard, contents, &exported.library, folder.path())?;
                shown(&Archive::open(&path)?, &starts(setting), experiment, &drive)?
            };
            compare(experiment, outcome, place, &shown, &mut sums);
        }
        let mut channels = Vec::new();
        for (n, (channel, sum)) in
            experiment.outputs.iter().zip(&sums).enumerate().filter(|(_, (_, s))| s.count > 0)
        {
            let error = outcome.errors.iter().find(|e| e.role == role && e.column == channel.column);
            let after = error.map_or(f64::NAN, |e| e.after);
            let rmse = (sum.squares / sum.count as f64).sqrt();
            // A single reading has no range; that of all runs is the scale then.
            let range = if sum.high > sum.low { sum.high - sum.low } else { span(experiment, n) };
            channels.push(ReplayedChannel {
                standard: standard.folder(),
                column: channel.column,
                rmse,
                after,
                range,
                difference: (rmse - after).abs() / range,
                difference_of_a_value: sum.apart / range,
            });
        }
        Ok(channels)
    };
    let channels = archives.par_iter().map(replay_one).collect::<Result<Vec<_>, _>>()?.concat();
    let greatest = |of: fn(&ReplayedChannel) -> f64| {
        // One that is no number is the worst.
        channels
            .iter()
            .map(of)
            .fold(0.0, |a: f64, b| if b.is_nan() || a.is_nan() { f64::NAN } else { a.max(b) })
    };
    let greatest_difference = greatest(|c| c.difference);
    // The part of a run behind a gap starts at other temperatures than the part before it.
    let mut start_values: BTreeMap<String, Vec<(String, f64)>> = BTreeMap::new();
    for (_, (run, setting)) in of_role() {
        let own = starts(setting);
        let is_other = start_values.get(&run.file).is_some_and(|known| *known != own);
        let from = if is_other { format!(" from {} s", run.table.time[0]) } else { String::new() };
        start_values.insert(format!("{}{from}", run.file), own);
    }
    Ok(Replay {
        greatest_difference,
        greatest_difference_of_a_value: greatest(|c| c.difference_of_a_value),
        limit: LIMIT,
        agrees: !channels.is_empty() && greatest_difference <= LIMIT,
        replayed,
        role: role_name(role),
        start_values: start_values.into_iter().map(|(name, own)| (name, own.into_iter().collect())).collect(),
        channels,
    })
}

/// Greatest less least reading of an output over all runs, above 0.
fn span(experiment: &Experiment, output: usize) -> f64 {
    let column = experiment.inputs.len() + output;
    let all = experiment.runs.iter().flat_map(|r| &r.table.columns[column]).filter(|v| v.is_finite());
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    (high - low).max(f64::MIN_POSITIVE)
}

/// The name of the parameter that scales all terms.
const GAIN: &str = "effect.generic_term.gain";

/// Whether the exported archive can simulate a run: it has the run's terms, or the run has none and they are switched off.
fn carries(setting: &Setting, outcome: &Outcome) -> bool {
    setting.terms == outcome.export.terms || setting.terms.is_empty()
}

/// Start values of a run that differ from those of the archives: its parameters, those that only the exported setting has, and the inputs
/// without a column, which the default experiment of the archives may have set.
fn differences(
    experiment: &Experiment,
    setting: &Setting,
    outcome: &Outcome,
    exported: &Exported,
    description: &ModelDescription,
) -> Vec<(String, f64)> {
    let of_run = |name: &str| setting.values.iter().find(|(n, _)| n == name).map(|(_, value)| *value);
    let is_exported = |name: &str| outcome.export.values.iter().any(|(n, _)| n == name);
    let is_column = |name: &str| experiment.inputs.iter().any(|channel| channel.input == Some(name));
    let value = |entry: &describe::Entry| {
        let name = entry.name.as_str();
        let is_open = entry.row.causality == describe::Causality::Input && !is_column(name);
        of_run(name)
            .or_else(|| is_exported(name).then_some(entry.row.start))
            .or_else(|| is_open.then(|| exported.preset.starts.of(entry)))
    };
    let differs = |entry: &describe::Entry| {
        let value = value(entry)?;
        let start = description.variable(&entry.name)?.start.as_deref()?;
        let start = start.parse().unwrap_or(f64::from(start == "true"));
        (value != start).then(|| (entry.name.clone(), value))
    };
    let mut all: Vec<(String, f64)> =
        (exported.kind.declaration)().entries.iter().filter_map(differs).collect();
    if setting.terms.is_empty() && !outcome.export.terms.is_empty() {
        all.retain(|(name, _)| name != GAIN);
        all.push((GAIN.to_owned(), 0.0));
    }
    all
}

/// Outputs of an archive at every row of a run: one column for each output, in SI units.
fn shown(
    archive: &Archive,
    starts: &[(String, f64)],
    experiment: &Experiment,
    drive: &Drive,
) -> Result<Vec<Vec<f64>>, Failure> {
    let description = archive.description();
    let inputs = references(description, experiment.inputs.iter().filter_map(|c| c.input))?;
    let outputs = references(description, experiment.outputs.iter().filter_map(|c| c.output))?;
    let mut fmu = Instance::instantiate_with_lines(archive, &description.model_name, Log::new(), &inputs)?;
    let from = cosim::Experiment { start: drive.time[0], ..Default::default() };
    fmu.setup_experiment(&from)?;
    set(&mut fmu, description, starts)?;
    fmu.enter_initialization(&from)?;
    let row = |k: usize| drive.inputs().iter().map(move |input| input[k]).collect::<Vec<f64>>();
    fmu.set_f64(&inputs, &row(0))?;
    fmu.exit_initialization()?;
    let rows = drive.time.len();
    let mut shown = vec![Vec::with_capacity(rows); outputs.len()];
    let mut values = vec![0.0; outputs.len()];
    let mut over = false;
    for k in 0..rows {
        fmu.get_f64(&outputs, &mut values)?;
        shown.iter_mut().zip(&values).for_each(|(column, value)| column.push(*value));
        let Some(next) = drive.time.get(k + 1) else { break };
        // An FMU that has reached a limit of validity stays there, as the native model does.
        if over {
            continue;
        }
        let (from, to, t, h) = (row(k), row(k + 1), drive.time[k], next - drive.time[k]);
        let slopes: Vec<f64> = from.iter().zip(&to).map(|(a, b)| slope(*a, *b, h)).collect();
        fmu.set_input_derivatives(&inputs, &slopes)?;
        over = fmu.do_step(t, h)? == Step::Terminated;
        if !over {
            fmu.set_f64(&inputs, &to)?;
        }
    }
    fmu.terminate()?;
    Ok(shown)
}

/// Slope from one value to another, which rounding does not exceed at the end: that may be a limit of the input.
fn slope(from: f64, to: f64, h: f64) -> f64 {
    let slope = (to - from) / h;
    let beyond = (from + slope * h - to) * (to - from).signum();
    if beyond > 0.0 { slope * (1.0 - 4.0 * f64::EPSILON) - slope.signum() * beyond / h } else { slope }
}

fn references<'a>(
    description: &ModelDescription,
    names: impl Iterator<Item = &'a str>,
) -> Result<Vec<u32>, Failure> {
    names.map(|name| Ok(variable(description, name)?.value_reference)).collect()
}

fn variable<'a>(description: &'a ModelDescription, name: &str) -> Result<&'a Variable, Failure> {
    let found = description.variable(name);
    found.ok_or_else(|| Failure::new(format!("the archive of {} has no {name}", description.model_name)))
}

/// Start values; structural parameters have a mode of their own.
fn set(fmu: &mut Instance, description: &ModelDescription, starts: &[(String, f64)]) -> Result<(), Failure> {
    let (mut structural, mut others) = (Vec::new(), Vec::new());
    for (name, number) in starts {
        let variable = variable(description, name)?;
        let value = match variable.kind {
            Kind::Boolean => Value::Boolean(*number != 0.0),
            kind if kind.is_float() => Value::Real(*number),
            _ => Value::Integer(*number as i128),
        };
        let of =
            if variable.causality == Causality::StructuralParameter { &mut structural } else { &mut others };
        of.push((variable, value));
    }
    if !structural.is_empty() {
        fmu.enter_configuration_mode()?;
        for (variable, value) in &structural {
            fmu.set_value(variable, value)?;
        }
        fmu.exit_configuration_mode()?;
    }
    for (variable, value) in &others {
        fmu.set_value(variable, value)?;
    }
    Ok(())
}

/// What is summed up over the counted rows of one output.
struct Sum {
    squares: f64,
    count: usize,
    low: f64,
    high: f64,
    /// Greatest difference from a value of the native model.
    apart: f64,
}

impl Default for Sum {
    fn default() -> Sum {
        Sum { squares: 0.0, count: 0, low: f64::INFINITY, high: f64::NEG_INFINITY, apart: 0.0 }
    }
}

/// Adds a run up: what the FMU shows against what was measured, and against the native model where that is kept.
fn compare(experiment: &Experiment, outcome: &Outcome, place: usize, shown: &[Vec<f64>], sums: &mut [Sum]) {
    let (inputs, run) = (experiment.inputs.len(), &experiment.runs[place]);
    let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let curves = outcome.curves.iter().find(|c| c.run == place);
    for (n, sum) in sums.iter_mut().enumerate() {
        let measured = &run.table.columns[inputs + n];
        let counts = |k: &usize| (from..=to).contains(&run.table.time[*k]) && measured[*k].is_finite();
        for k in (0..measured.len()).filter(counts) {
            sum.squares += (measured[k] - shown[n][k]).powi(2);
            sum.count += 1;
            (sum.low, sum.high) = (sum.low.min(measured[k]), sum.high.max(measured[k]));
        }
        let channel = experiment.outputs[n];
        let Some((curves, curve)) =
            curves.and_then(|c| Some((c, c.outputs.iter().find(|o| o.column == channel.column)?)))
        else {
            continue;
        };
        for (t, native) in curves.time.iter().zip(&curve.after).filter(|(_, v)| v.is_finite()) {
            // Points of decimated curves are rows of the data.
            if let Ok(k) = run.table.time.binary_search_by(|x| x.total_cmp(t)) {
                sum.apart = sum.apart.max((shown[n][k] - channel.offset - native).abs());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::slope;

    /// Down to a limit of 0 and up to one of 1, from values that are no binary fractions.
    #[test]
    fn a_line_to_a_limit_ends_within_it() {
        for k in 1..2000 {
            let (from, h) = (1e-5 / f64::from(k), 0.1 * f64::from(k % 37 + 1));
            assert!(from + slope(from, 0.0, h) * h >= 0.0, "{k}");
            assert!(1.0 - from + slope(1.0 - from, 1.0, h) * h <= 1.0, "{k}");
            assert!((slope(from, 0.0, h) * h / from + 1.0).abs() < 1e-12);
        }
    }
}
