//! `motor-fmu simulate`: run one FMU and show, record or draw its outputs.
use crate::Failure;
use crate::drawing;
use crate::existing::{Force, check_apart, check_place, is_stdout};
use crate::outputs::{self, Shown, thin};
use crate::parent::{self, complain};
use cosim::{Archive, Causality, InputTable, Log, ModelDescription, Options, Recording, Status};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// Messages of the FMU that are printed at most.
const MAX_MESSAGES: usize = 5;

/// Simulate one FMU (FMI 2.0 or 3.0, Co-Simulation or Model Exchange), of this project or of another tool.
///
/// Values set without effect in the selected modes are named on stderr; for FMUs of this project only.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The FMU
    pub file: PathBuf,
    /// Start time in s or with a unit [default: that of the FMU, else 0]
    #[arg(long, value_name = "S", value_parser = time, allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in s or with a unit, such as "10 min" [default: that of the FMU, else 1 s after the start]
    #[arg(long, value_name = "S", value_parser = time, allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Communication step in s or with a unit [default: that of the FMU, else a 500th of the time]
    #[arg(long, value_name = "H", value_parser = time, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Set a parameter or input: a number in its unit or with another unit of the quantity, such as "3000 rpm"; an enumeration by the
    /// name of an item. May be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    sets: Vec<(String, String)>,
    /// Interface type; auto takes Co-Simulation where the FMU has it
    #[arg(long, value_enum, default_value_t = Interface::Auto)]
    interface: Interface,
    /// Relative tolerance, passed to the FMU and used by the solver for Model Exchange [default: that of the FMU, else 1e-6]
    #[arg(long, value_name = "R")]
    tolerance: Option<f64>,
    /// Record this variable, too; local variables and parameters are not recorded otherwise. May be repeated
    #[arg(long = "record", value_name = "NAME")]
    records: Vec<String>,
    /// Inputs over time: CSV with the header time,<input names>, each with [unit] if wanted; reals are interpolated linearly, other inputs are constant between rows; two rows with one time are a discontinuity, at which a step ends if the FMU can vary its step; - reads the standard input
    #[arg(long, value_name = "F.csv")]
    pub input: Option<PathBuf>,
    /// Record every N-th communication point, and the last
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    #[command(flatten)]
    shown: Shown,
    /// Write time and the outputs as CSV with 17 digits; - prints the table in place of the final values
    #[arg(long, value_name = "F.csv")]
    output: Option<PathBuf>,
    /// Draw the outputs with their limits as SVG, PNG or HTML: those of --outputs, else the main ones
    #[arg(long, value_name = "F.svg|F.png|F.html")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Keep inputs constant over a step, also if the FMU accepts input derivatives
    #[arg(long, alias = "held-inputs")]
    no_input_derivatives: bool,
    /// Print the final values as JSON
    #[arg(long)]
    json: bool,
    /// Time limit of one call of the FMU
    #[arg(long, value_name = "SECONDS", default_value = parent::PATIENCE, value_parser = crate::validate::seconds)]
    pub patience: f64,
}

/// The interface types on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Interface {
    Auto,
    /// Co-Simulation
    Cs,
    /// Model Exchange, integrated with error control; events are located
    Me,
}

impl Interface {
    fn kind(self) -> Option<cosim::InterfaceType> {
        match self {
            Interface::Auto => None,
            Interface::Cs => Some(cosim::InterfaceType::CoSimulation),
            Interface::Me => Some(cosim::InterfaceType::ModelExchange),
        }
    }
}

/// Runs the command in this process.
pub fn run(args: Args) -> Result<u8, Failure> {
    let archive = Archive::open(&args.file)?;
    may_write(&args, archive.description())?;
    check_once(&args.sets)?;
    let sets = args.shown.sets(args.sets, archive.description());
    let read = |path| InputTable::read(path, archive.description(), args.shown.has_display_units());
    let input = args.input.as_deref().map(read).transpose()?;
    crate::remark(input.iter().flat_map(InputTable::notes).cloned().collect::<Vec<_>>().as_slice());
    let columns = input.iter().flat_map(|table| table.names());
    if let Some(sentence) = crate::unused::unserved("", archive.description(), &sets) {
        return Err(Failure::new(sentence));
    }
    let unused = crate::unused::note(&archive, &sets, columns);
    let ours = outputs::of_model("", archive.description());
    let (main, limits) = ours.filter(|_| args.plot.is_some()).unwrap_or_default();
    let further = limits.iter().map(|l| l.variable.clone()).filter(|name| !args.records.contains(name));
    let options = Options {
        start: args.start,
        stop: args.stop,
        step: args.step,
        sets,
        interface: args.interface.kind(),
        tolerance: args.tolerance,
        records: args.records.iter().cloned().chain(further).collect(),
        input,
        input_slopes: !args.no_input_derivatives,
        log: Log::new(),
    };
    let mut recording = cosim::simulate(&archive, &options, &mut parent::progress)?;
    let finite = is_a_number(&recording);
    thin(&mut recording, args.every as usize);
    let limits = outputs::take_limits(&mut recording, &limits, &args.records);
    args.shown.apply(&mut recording, &|name| {
        let causality = archive.description().variable(name)?.causality;
        Some(format!("{name} is no output (causality {causality}); --record {name} records it"))
    })?;

    let table = args.shown.write(&recording, args.output.as_deref())?;
    if let Some(path) = &args.plot {
        drawing::write(path, &args.shown.figure(&recording, &limits, &main)?)?;
    }
    let name = &recording.model_name;
    remarks(&recording, &format!("{name}: "), name, &format!("{name}: the FMU"));
    crate::remark(unused.as_slice());
    let text = if let Some(table) = table {
        table
    } else if args.json {
        let mut result = machine(&args.file.to_string_lossy(), &recording);
        result["notes"] = json!(unused.as_slice());
        format!("{result}\n")
    } else {
        summary(&recording)
    };
    crate::say(&text);
    Ok(crate::code(recording.ended_early.is_none() && finite))
}

/// Refuses files that are no earlier results of this FMU.
fn may_write(args: &Args, description: &ModelDescription) -> Result<(), Failure> {
    let model = &description.model_name;
    check_apart(args.output.as_deref(), args.plot.as_deref(), args.json)?;
    if let Some(path) = args.output.as_ref().filter(|path| !is_stdout(path)) {
        check_place(path)?;
        let is_column = |name: &str| {
            let known = |name: &str| {
                let variable = description.variable(name);
                let recorded = args.records.iter().any(|record| record == name);
                variable.is_some_and(|v| recorded || v.causality != Causality::Input)
            };
            known(name) || name.split_once('[').is_some_and(|(array, _)| known(array))
        };
        args.force.check_table(path, &format!("a table of outputs of {model}"), is_column)?;
    }
    let is_title = |title: &str| title == model;
    drawing::check(args.plot.as_deref(), args.force, &format!("a figure of {model}"), is_title)
}

/// Whether no output is NaN; the first that is goes to stderr.
pub fn is_a_number(recording: &Recording) -> bool {
    let nan = recording.first_nan();
    if let Some((output, time)) = nan {
        let (name, time) = (&recording.model_name, cosim::number(time));
        complain(&format!("error: {name}: output {output} is NaN (not a number) from t = {time} s on"));
    }
    nan.is_none()
}

/// Refuses settings that give a variable two values.
pub fn check_once(sets: &[(String, String)]) -> Result<(), Failure> {
    let other =
        |(k, (name, _)): (usize, &(String, String))| sets[..k].iter().position(|(other, _)| other == name);
    match sets.iter().enumerate().find_map(|set| Some((set.0, other(set)?))) {
        Some((k, j)) => {
            let [(name, first), (_, second)] = [&sets[j], &sets[k]];
            Err(Failure::new(format!("--set gives {name} two values: {first} and {second}")))
        }
        None => Ok(()),
    }
}

/// A time in s; the text may have another unit.
pub fn time(text: &str) -> Result<f64, String> {
    units::number(text, "s")
}

/// `name=value`; the value may have further equal signs.
pub fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected name=value".to_owned()),
    }
}

/// Prints the warnings and errors of FMUs to stderr, after `prefix`; if `who` ended the simulation, the last message is the reason,
/// and without a message the line says that `ending` did so.
pub fn remarks(recording: &Recording, prefix: &str, who: &str, ending: &str) {
    let mut complaints: Vec<_> = recording.messages.iter().filter(|m| m.status != Status::Ok).collect();
    let reason = recording.ended_early.and_then(|_| complaints.pop());
    for message in complaints.iter().take(MAX_MESSAGES) {
        complain(&format!("{prefix}{}: {}", message.status, message.text));
    }
    if complaints.len() > MAX_MESSAGES {
        complain(&format!("{prefix}{} more messages", complaints.len() - MAX_MESSAGES));
    }
    match (recording.ended_early, reason) {
        (Some(_), Some(reason)) => complain(&format!("error: {who}: {}", reason.text)),
        (Some(time), None) => {
            complain(&format!("error: {ending} ended the simulation in the step from t = {time} s"));
        }
        (None, _) => {}
    }
}

/// What ran, and the final values with their units.
fn summary(recording: &Recording) -> String {
    let last = recording.times.last().copied().unwrap_or(0.0);
    let mut text = format!(
        "{}: {} steps to t = {} s in {:.3} s\n",
        recording.model_name,
        recording.steps,
        rounded(last),
        recording.seconds_wall
    );
    text += &final_values(recording);
    text
}

/// A time without the rounding error of its steps.
pub fn rounded(time: f64) -> f64 {
    (time * 1e9).round() / 1e9
}

/// A line for each output with its last value, in its display unit.
pub fn final_values(recording: &Recording) -> String {
    let mut text = String::new();
    let width = recording.columns.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
    for column in &recording.columns {
        let Some((value, unit)) = column.last_shown() else { continue };
        let value = match column.kind {
            cosim::Kind::Boolean => format!("{}{}", value != 0.0, since(column, &recording.times)),
            kind if kind.is_float() => significant(value),
            _ => column.last_integer().map_or(value.to_string(), |integer| integer.to_string()),
        };
        let unit = if unit == "1" { "" } else { unit };
        text += format!("  {:width$}  {value:>12} {unit}", column.name).trim_end();
        text.push('\n');
    }
    text
}

/// Since when a flag is what it is, where it was not from the start.
fn since(column: &cosim::Column, times: &[f64]) -> String {
    let last = column.values.last().copied().unwrap_or(0.0);
    let place = column.values.iter().rposition(|value| *value != last);
    let time = place.and_then(|k| times.get(k + 1));
    time.map_or(String::new(), |time| format!(" since t = {} s", present::number(*time)))
}

pub fn significant(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() || (1e-3..1e6).contains(&size) {
        let digits =
            if size > 0.0 && size.is_finite() { (5.0 - size.log10().floor()).max(0.0) as usize } else { 0 };
        format!("{value:.digits$}")
    } else {
        format!("{value:.5e}")
    }
}

/// An output with its last value in its own unit and type, null for what is not finite.
pub fn last_value(column: &cosim::Column) -> (String, Value) {
    let value = column.values.last().copied().unwrap_or(f64::NAN);
    let value = match column.kind {
        cosim::Kind::Boolean => json!(value != 0.0),
        kind if kind.is_float() => json!(value),
        // JSON has no numbers beyond u64, and no integer type of FMI has either.
        _ => column.last_integer().map_or(Value::Null, |integer| match u64::try_from(integer) {
            Ok(integer) => json!(integer),
            Err(_) => json!(i64::try_from(integer).unwrap_or(i64::MIN)),
        }),
    };
    (column.name.clone(), value)
}

/// The result for a script: final values in the variables' own units and types, null for what is not finite.
fn machine(file: &str, recording: &Recording) -> Value {
    let finals: Map<String, Value> = recording.columns.iter().map(last_value).collect();
    let mut result = json!({
        "file": file,
        "steps": recording.steps,
        "seconds_wall": recording.seconds_wall,
        "final": finals,
    });
    if let Some(time) = recording.ended_early {
        result["ended_early"] = json!(time);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_split_at_the_first_equal_sign() {
        assert_eq!(setting("a.b = 1"), Ok(("a.b".to_owned(), "1".to_owned())));
        assert_eq!(setting("label=x=y"), Ok(("label".to_owned(), "x=y".to_owned())));
        assert!(setting("a").is_err() && setting("=1").is_err());
    }

    #[test]
    fn the_time_of_a_trip_is_printed() {
        let flag = |values: &[f64]| {
            let column = cosim::Column {
                name: "over".to_owned(),
                kind: cosim::Kind::Boolean,
                unit: None,
                display_unit: None,
                values: values.to_vec(),
                exact: Vec::new(),
            };
            since(&column, &[0.0, 0.1, 0.2, 0.30000000000000004])
        };
        assert_eq!(flag(&[0.0, 0.0, 1.0, 1.0]), " since t = 0.2 s");
        assert_eq!(flag(&[1.0, 0.0, 1.0, 0.0]), " since t = 0.3 s");
        assert_eq!(flag(&[1.0; 4]), "");
        assert_eq!(rounded(409.90000000000003), 409.9);
    }

    #[test]
    fn numbers_have_six_digits() {
        for (value, text) in [
            (0.0, "0"),
            (298.15, "298.150"),
            (-1.5e-7, "-1.50000e-7"),
            (f64::NAN, "NaN"),
            (123456.7, "123457"),
        ] {
            assert_eq!(significant(value), text);
        }
    }
}
