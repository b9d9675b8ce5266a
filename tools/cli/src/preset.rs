//! `motor-fmu preset new`: a preset from a datasheet.

use crate::existing::{Force, check_file, head};
use crate::parent::complain;
use crate::{Failure, say, say_json};
use ::study::datasheet::{
    Certainty, Contradiction, Datasheet, Draft, Given, Implausible, QUANTITIES, Quantity, Value,
    contradictions, implausible, is_comparable,
};
use ::study::reproduce::significant;
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use serde_json::json;
use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Make a preset from a datasheet
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Preset,
}

#[derive(clap::Subcommand)]
enum Preset {
    New(New),
}

/// Write a preset of AnnulusCooledMotor from datasheet values
///
/// The values come from the options, from a TOML file (--from), or, on a terminal, from questions. A number without
/// unit is in the unit of the option; any unit of the quantity may be given: --torque-constant "8.54 oz-in/A".
///
/// The command lists each start value with its source (datasheet, derived with the formula, estimated) and each parameter that keeps
/// its default with the source of the default. It compares all datasheet values that determine each other; values that contradict each
/// other or that no motor has are listed with the numbers, and the exit code is then 1. The preset is written in both cases.
#[derive(clap::Args)]
struct New {
    /// Name of the preset
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// One line about the motor
    #[arg(long, value_name = "TEXT")]
    description: Option<String>,
    /// Source of the values: document, edition, page
    #[arg(long, value_name = "TEXT")]
    source: Option<String>,
    /// Datasheet as TOML: name, description, source and a table [datasheet] with the names of the options below, with underscores
    #[arg(long, value_name = "FILE.toml")]
    from: Option<PathBuf>,
    /// File to write [default: NAME.toml]
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print values and contradictions as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    printed: Printed,
}

/// The values from the options, one for each quantity.
struct Printed(Vec<(&'static Quantity, String)>);

impl FromArgMatches for Printed {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Printed, clap::Error> {
        let text = |q: &'static Quantity| Some((q, matches.get_one::<String>(q.key)?.clone()));
        Ok(Printed(QUANTITIES.iter().filter_map(text).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Printed::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Printed {
    fn augment_args(command: Command) -> Command {
        QUANTITIES.iter().fold(command, |command, q| {
            let arg = Arg::new(q.key).long(q.flag()).value_name(q.unit).help(q.words);
            let arg = arg.visible_aliases(q.other_flags());
            command.arg(arg.help_heading("Datasheet values"))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Printed::augment_args(command)
    }
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let Preset::New(args) = &args.command;
    let mut sheet = args.from.as_deref().map(Datasheet::read).transpose()?.unwrap_or_default();
    for (quantity, text) in &args.printed.0 {
        let value =
            Value::parse(quantity, text).map_err(|e| Failure::new(format!("--{}: {e}", quantity.flag())))?;
        sheet.put(value);
    }
    for (to, given) in [
        (&mut sheet.name, &args.name),
        (&mut sheet.description, &args.description),
        (&mut sheet.source, &args.source),
    ] {
        if let Some(given) = given {
            to.clone_from(given);
        }
    }
    if std::io::stdin().is_terminal() && args.from.is_none() {
        ask(&mut sheet)?;
    }
    if sheet.name.is_empty() {
        return Err(Failure::new("the preset has no name: give --name"));
    }
    let contradictions = contradictions(&sheet);
    let implausible = implausible(&sheet);
    let draft = Draft::new(&sheet).map_err(|e| {
        let mut lines = vec![e.to_string()];
        lines.extend(findings(&contradictions, &implausible));
        Failure::new(lines.join("\n"))
    })?;
    let path = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", sheet.name)));
    check_file(&path)?;
    let same =
        |from: &PathBuf| from.canonicalize().is_ok_and(|from| path.canonicalize().is_ok_and(|to| to == from));
    if args.from.as_ref().is_some_and(same) {
        return Err(Failure::new(format!(
            "the preset would overwrite its datasheet {}: give another file with --output",
            path.display()
        )));
    }
    let what = format!("a preset {} that this command wrote", sheet.name);
    args.force
        .check(&path, &what, |path| Draft::is_earlier(&sheet.name, &String::from_utf8_lossy(&head(path))))?;
    crate::write(&path, &draft.toml())?;
    let consistent = contradictions.is_empty() && implausible.is_empty();
    if args.json {
        say_json(&json!({
            "file": path,
            "preset": draft,
            "contradictions": contradictions,
            "implausible": implausible,
            "consistent": consistent,
        }))?;
    } else {
        say(&format!("{}: preset for {}\n", path.display(), draft.model));
        say(&summary(&draft));
        let lines = findings(&contradictions, &implausible);
        say(&match lines.is_empty() {
            true if is_comparable(&sheet) => "consistency: the datasheet values agree\n".to_owned(),
            true => "consistency: not checked, no datasheet value follows from the others\n".to_owned(),
            false => format!("consistency: the datasheet values do not agree\n  {}\n", lines.join("\n  ")),
        });
    }
    Ok(crate::outcome(consistent))
}

/// Asks for everything that is not there yet; an empty line leaves it out.
fn ask(sheet: &mut Datasheet) -> Result<(), Failure> {
    let question = |text: &str| -> Result<String, Failure> {
        let mut terminal = std::io::stderr();
        write!(terminal, "{text}: ")?;
        terminal.flush()?;
        let mut line = String::new();
        std::io::stdin().lock().read_line(&mut line)?;
        Ok(line.trim().to_owned())
    };
    if sheet.name.is_empty() {
        sheet.name = question("name of the preset")?;
    }
    if sheet.description.is_empty() {
        sheet.description = question("description of the motor, one line")?;
    }
    if sheet.source.is_empty() {
        sheet.source = question("source: document, edition, page")?;
    }
    complain(
        "Datasheet values: a number in the stated unit or with another unit; an empty line if the datasheet has no value.",
    );
    for quantity in QUANTITIES {
        while sheet.value(quantity.key).is_none() {
            let unit = if quantity.unit == "1" { String::new() } else { format!(" in {}", quantity.unit) };
            let text = question(&format!("{}{unit}", quantity.words))?;
            if text.is_empty() {
                break;
            }
            match Value::parse(quantity, &text) {
                Ok(value) => sheet.put(value),
                Err(sentence) => complain(&sentence),
            }
        }
    }
    Ok(())
}

/// The start values by certainty, with their sources.
fn summary(draft: &Draft) -> String {
    let mut text = String::new();
    let width = draft.values.iter().map(|v| v.name.len()).max().unwrap_or(0);
    let line = |v: &Given| {
        let value = format!("{}{}", v.shown(), v.unit_text());
        format!("  {:width$}  {value:18} {}\n", v.name, v.source)
    };
    for (certainty, heading) in [
        (Certainty::Datasheet, "datasheet"),
        (Certainty::Derived, "derived"),
        (Certainty::Estimate, "estimated"),
    ] {
        let lines: String = draft.of(certainty).map(line).collect();
        if !lines.is_empty() {
            text += &format!("{heading}\n{lines}");
        }
    }
    text += "default, not from this motor\n";
    text += &draft.defaults().map(line).collect::<String>();
    text += "  effects that are not named here are off\n";
    if !draft.not_used.is_empty() {
        text += &format!("not used: {}\n", draft.not_used.join(", "));
    }
    text
}

/// A sentence for each contradiction and each value that no motor has.
fn findings(contradictions: &[Vec<Contradiction>], implausible: &[Implausible]) -> Vec<String> {
    let one = |c: &Contradiction| {
        let formula = if c.formula.is_empty() { String::new() } else { format!(" ({})", c.formula) };
        let size = match c.ratio {
            r if (0.5..2.0).contains(&r) => format!("{:+.1} %", 100.0 * (r - 1.0)),
            r => format!("a factor of {}", significant(r)),
        };
        let hint = c.hint.map_or(String::new(), |hint| format!("; {hint}?"));
        let [printed, expected] = [c.printed, c.expected].map(significant);
        let Contradiction { words, unit, .. } = c;
        format!("{words} {printed} {unit}, the other values give {expected} {unit}{formula}: {size}{hint}")
    };
    let mut lines: Vec<String> = contradictions
        .iter()
        .map(|group| match &group[..] {
            [single] => one(single),
            several => {
                format!(
                    "one of these is wrong: {}",
                    several.iter().map(one).collect::<Vec<_>>().join("; or ")
                )
            }
        })
        .collect();
    lines.extend(implausible.iter().map(|i| {
        let unit = if i.unit == "1" { String::new() } else { format!(" {}", i.unit) };
        let [value, low, high] = [i.value, i.limits.0, i.limits.1].map(significant);
        format!("{}: {value}{unit}, outside {low} ... {high}{unit}", i.words)
    }));
    lines
}
