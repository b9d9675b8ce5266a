//! `motor-fmu steady` and `motor-fmu sweep`: studies with the native models.

mod walk;

use crate::drawing;
use crate::existing::{Force, check_apart, check_file, header};
use crate::progress::Progress;
use crate::{Failure, write};
use ::study::StudyError;
use ::study::reproduce::significant;
use ::study::steady::{Setup, continuous_torque, steady};
use ::study::sweep::{
    Case, Choice, ConstantInputs, Constraint, Goal, PRESET, Point, Shown, Sweep, Target, Vary, Walking,
    check_figure, count, edges, sweep,
};
use ::study::walk::Load;
use serde_json::json;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The model of a periodic load.
const PERIODIC: &str = "GaitLoad";

/// Model, preset and values of a study.
#[derive(clap::Args)]
pub struct Start {
    /// Model
    #[arg(long, value_name = "M", default_value = "AnnulusCooledMotor")]
    model: String,
    /// Start values: a built-in preset's name or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    preset: Option<String>,
    /// Set a parameter or input, in SI units or with any unit of the quantity (`"3000 rpm"`); an enumeration by the name of an item. May be
    /// repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = crate::simulate::setting)]
    sets: Vec<(String, String)>,
}

/// A periodic load.
#[derive(clap::Args)]
pub struct LoadArgs {
    /// Periodic load: a TOML file with the tables [motor], [actuator] and [gait], or [cycle] with torque and speed from a CSV file, or
    /// [mix] with phases of several loads and rest (docs/loads.md)
    #[arg(long, value_name = "load.toml")]
    pub load: Option<PathBuf>,
    /// Longest simulated time in hours, with --load
    #[arg(long, value_name = "H", default_value_t = 2.0, requires = "load")]
    pub hours: f64,
}

impl Start {
    /// Motor with its preset, actuator and gait, and the settings.
    pub fn load(&self, file: &Path) -> Result<Load, Failure> {
        if self.model != ::study::walk::MOTOR {
            return Err(Failure::new(format!(
                "--load takes the motor {}, not {}",
                ::study::walk::MOTOR,
                self.model
            )));
        }
        let preset = self.checked()?;
        Ok(Load::read(file, preset.as_ref(), &self.sets)?)
    }

    fn setup(&self) -> Result<Setup, Failure> {
        Ok(Setup { model: self.model.clone(), preset: self.checked()?, sets: self.sets.clone() })
    }

    /// The preset, with settings that are each given once.
    fn checked(&self) -> Result<Option<describe::Preset>, Failure> {
        crate::simulate::check_once(&self.sets)?;
        Ok(self.preset.as_deref().map(describe::Preset::load).transpose()?)
    }
}

/// Compute the thermal steady state and the continuous torque at the winding's temperature limit.
///
/// Modes that are not set follow from the inputs: electrical_power selects drive_mode power, current_command
/// current, voltage voltage, duty pwm; without any of them a motor with imposed_speed carries no current. The shaft turns at imposed_speed, 0 if not set, unless load_torque is set.
/// Notes on stderr, and in JSON, name values that have no effect in the selected modes.
///
/// With --load the motor drives an actuator on a walking joint: periodic steady state, time to the winding's limit from a
/// cold start, and the continuous support, the fraction of the biological torque that the actuator can deliver continuously. The
/// control's motor data follow from the motor unless they are set. A name in --set belongs to the first of motor, actuator
/// and gait that has it.
#[derive(clap::Args)]
pub struct SteadyArgs {
    #[command(flatten)]
    pub start: Start,
    #[command(flatten)]
    pub load: LoadArgs,
    /// With --load: plot the winding temperature over the simulated time, as SVG, PNG or HTML
    #[arg(long, value_name = "F.svg|F.png|F.html", requires = "load")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub force: Force,
    /// Print everything as JSON
    #[arg(long)]
    pub json: bool,
}

pub fn run_steady(args: &SteadyArgs) -> Result<ExitCode, Failure> {
    if let Some(file) = &args.load.load {
        return walk::run(args, file);
    }
    // Its outputs are those of an instant of the cycle.
    if args.start.model == PERIODIC {
        return Err(Failure::new(format!(
            "{PERIODIC} is a periodic load and has no steady state; with steady --load FILE it is the load of a motor"
        )));
    }
    let setup = args.start.setup()?;
    let mut bench = setup.bench()?;
    let continuous = continuous_torque(&bench);
    let found = match steady(&mut bench) {
        Err(StudyError::Unsettled(sentence)) => {
            crate::parent::complain(&format!("error: {sentence}"));
            return Ok(crate::outcome(false));
        }
        found => found?,
    };
    let mut notes = setup.notes()?;
    notes.extend(found.get("winding_margin").filter(|margin| *margin < -5e-4).map(|margin| {
        format!(
            "the winding is {} K above its limit thermal.T_w_max: no continuous operation",
            rounded(-margin)
        )
    }));
    crate::remark(&notes);
    if args.json {
        let outputs: serde_json::Map<_, _> =
            found.outputs.iter().map(|v| (v.name.clone(), json!(v.value))).collect();
        let result = json!({
            "model": args.start.model,
            "steady": outputs,
            "R_ha": found.r_ha,
            "continuous": continuous.as_ref().ok(),
            "no_continuous_torque": continuous.as_ref().err().map(ToString::to_string),
            "notes": notes,
        });
        crate::say_json(&result)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!("{} in steady state\n", args.start.model);
    for unit in ["rad/s", "N.m", "A", "V", "K", "W"] {
        for v in found.of_unit(unit) {
            let also = match unit {
                "rad/s" => format!("  ({} rpm)", rounded(v.value * 30.0 / PI)),
                "K" if !v.name.ends_with("margin") => format!("  ({:.2} degC)", v.value - 273.15),
                _ => String::new(),
            };
            text += &format!("  {:30} {:>12} {unit}{also}\n", v.name, rounded(v.value));
        }
    }
    if let Some(r_ha) = found.r_ha {
        text += &format!("  {:30} {:>12} K/W\n", "R_ha", significant(r_ha));
    }
    text += &match continuous {
        Ok(c) => format!(
            "continuous torque {} N.m at {} rad/s and {} A{}, with the winding at {:.2} K ({:.2} degC)\n",
            significant(c.torque),
            significant(c.speed),
            significant(c.current),
            c.torque_density.map_or(String::new(), |density| format!(", {} N.m/kg", significant(density))),
            c.winding_temperature,
            c.winding_temperature - 273.15
        ),
        Err(reason) => format!("{reason}\n"),
    };
    crate::say(&text);
    Ok(ExitCode::SUCCESS)
}

/// Three decimals; rounding noise is 0.
pub fn rounded(value: f64) -> String {
    if value.abs() < 5e-4 { "0".to_owned() } else { format!("{value:.3}") }
}

/// Vary inputs, parameters, modes and motors over a grid and find the best points.
///
/// With several objectives the Pareto set is listed: the feasible points for which no other point is at least as good in all objectives and
/// better in one. The first objective decides which point is the best. Points without steady state or beyond a constraint are listed as
/// infeasible.
#[derive(clap::Args)]
pub struct SweepArgs {
    #[command(flatten)]
    start: Start,
    #[command(flatten)]
    load: LoadArgs,
    /// A variable and its values: a range with both ends, such as "imposed_speed=0:3000 rpm:4", or a list of numbers (both in SI units, or
    /// with any unit of the quantity) or items, such as cooling_mode=bare,annulus_push or gait.activity=walk,stairs_up; preset=NAME,FILE,... varies the motor. May be repeated
    #[arg(long = "vary", required = true, value_name = "NAME=FROM:TO:N|V,V,...")]
    vary: Vec<String>,
    /// continuous_torque, torque_density (both at the winding's limit and the speed of the point), or an output in steady state; with --load
    /// continuous_torque and torque_density at the joint, continuous_support, winding_temperature, supply_power,
    /// torque_error or time_to_limit. Behind the name :min or :max states the direction; otherwise temperatures, powers and energies
    /// other than mechanical ones, losses, pressure drops, voltages, currents, resistances and errors are minimized and all others maximized. May be repeated
    #[arg(long = "objective", value_name = "NAME[:min|:max]", default_value = "continuous_torque")]
    objectives: Vec<String>,
    /// A limit of any quantity that can be an objective; the value may have a unit. May be repeated
    #[arg(long = "constraint", value_name = "NAME<=VALUE|NAME>=VALUE")]
    constraints: Vec<String>,
    /// Write all points as CSV with 17 digits
    #[arg(long, value_name = "F.csv")]
    output: Option<PathBuf>,
    /// Plot the objective over the first variable, a line for each combination of the others, as SVG, PNG or HTML
    #[arg(long, value_name = "F.svg|F.png|F.html")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

pub fn run_sweep(args: &SweepArgs) -> Result<ExitCode, Failure> {
    let vary = args.vary.iter().map(|text| Vary::parse(text)).collect::<Result<Vec<_>, _>>()?;
    may_write(args, &vary)?;
    let points = count(&vary);
    let bar = Progress::new(&format!("{points} points"));
    let done = |n: usize| bar.at(n as f64 / points as f64);
    let case: Box<dyn Case> = match &args.load.load {
        Some(file) => Box::new(Walking { load: args.start.load(file)?, hours: args.load.hours }),
        None => Box::new(ConstantInputs { setup: args.start.setup()? }),
    };
    let vary = vary
        .iter()
        .map(|v| v.resolved(|name, unit| case.conversion(name, unit)))
        .collect::<Result<Vec<_>, _>>()?;
    let constraints =
        args.constraints.iter().map(|text| Constraint::parse(text)).collect::<Result<_, _>>()?;
    let goal = Goal { objectives: args.objectives.clone(), constraints };
    let found = sweep(case.as_ref(), &vary, &goal, done);
    bar.finish();
    let found = found?;
    let notes = [replaced(args, &vary), case.notes(&vary)?].concat();
    crate::remark(&notes);
    if let Some(path) = &args.output {
        write(path, &found.csv())?;
    }
    if let Some(path) = &args.plot {
        drawing::write(path, &found.figure()?.svg())?;
    }
    if args.json {
        let mut result = serde_json::to_value(&found)?;
        result["notes"] = json!(notes);
        crate::say_json(&result)?;
    } else {
        crate::say(&summary(&found, &vary, case.as_ref()));
    }
    Ok(ExitCode::SUCCESS)
}

/// What --vary replaces.
fn replaced(args: &SweepArgs, vary: &[Vary]) -> Vec<String> {
    let is_varied = |name: &str| vary.iter().any(|v| v.name == name);
    let sets = args.start.sets.iter().filter(|(name, _)| is_varied(name));
    let preset = args.start.preset.as_ref().filter(|_| is_varied(PRESET));
    let replaced = sets.map(|(name, text)| format!("--set {name}={text}"));
    let replaced = replaced.chain(preset.map(|name| format!("--preset {name}")));
    replaced.map(|what| format!("{what} has no effect: --vary gives other values")).collect()
}

/// Refuses files that are no earlier results of a sweep over the same variables.
fn may_write(args: &SweepArgs, vary: &[Vary]) -> Result<(), Failure> {
    let varied: Vec<&str> = vary.iter().map(|v| v.name.as_str()).collect();
    let names = varied.join(", ");
    check_apart(args.output.as_deref(), args.plot.as_deref(), false)?;
    if let Some(path) = &args.output {
        check_file(path)?;
        args.force.check(path, &format!("a table of a sweep over {names}"), |path| {
            let columns = header(path);
            columns.len() > varied.len() && columns.iter().zip(&varied).all(|(column, name)| column == name)
        })?;
    }
    if args.plot.is_some() {
        check_figure(vary)?;
    }
    let is_title = |title: &str| title.contains(" over ");
    drawing::check(args.plot.as_deref(), args.force, "a figure of a sweep", is_title)
}

fn summary(found: &Sweep, vary: &[Vary], case: &dyn Case) -> String {
    let mut text = format!("{} points\n", found.points.len());
    if let Some(source) = &found.source {
        text += &format!("load: {source}\n");
    }
    let infeasible = found.infeasible_points(LISTED, |values| found.place(values));
    // The reasons are a list below their number.
    text += &infeasible.join("\n  ");
    text += if infeasible.is_empty() { "" } else { "\n" };
    let objectives = found.objectives.iter().map(|o| {
        let goal = if o.least_is_best { "minimum" } else { "maximum" };
        format!("{goal} of {}", o.name)
    });
    text += &format!("objective: {}\n", objectives.collect::<Vec<_>>().join(", "));
    for constraint in &found.constraints {
        text += &format!("constraint: {}\n", constraint.words());
    }
    if let Some(best) = &found.best {
        let (shown, places) = (found.objectives[0].shown(), found.place(&best.values));
        let value = best.objective.map_or(String::new(), |value| significant(shown.of(value)));
        let later = found.objectives[0].most.filter(|most| best.objective == Some(*most));
        let later = later.map_or("", |_| " (the limit is not reached in the simulated time)");
        text += &format!("best {} = {value}{}{later} at {places}\n", found.objective, shown.unit(" "));
    }
    for edge in &found.best_at_edge {
        let shown = found.varied.iter().zip(&found.shown).find(|(name, _)| **name == edge.name);
        let value = shown.map_or(String::new(), |(_, shown)| Choice::Number(edge.value).with_unit(shown));
        text += &format!(
            "{} = {value} is the {} end of its range: the optimum may lie outside\n",
            edge.name, edge.end
        );
    }
    if found.objectives.len() > 1 {
        text += &pareto(found, vary, case);
    }
    text
}

/// Reasons of infeasible points that the summary lists.
const LISTED: usize = 12;

/// The Pareto set as a table, best first in the first objective. A star marks a value at an end of its range.
fn pareto(found: &Sweep, vary: &[Vary], case: &dyn Case) -> String {
    let mut points: Vec<&Point> = found.points.iter().filter(|p| p.pareto).collect();
    points.sort_by(|a, b| a.objectives[0].total_cmp(&b.objectives[0]));
    if !found.objectives[0].least_is_best {
        points.reverse();
    }
    let shown: Vec<Shown> = found.objectives.iter().map(Target::shown).collect();
    let names = found.varied.iter().chain(found.objectives.iter().map(|o| &o.name));
    let heads =
        names.zip(found.shown.iter().chain(&shown)).map(|(name, u)| format!("{name}{}", u.unit(" in ")));
    let mut rows: Vec<Vec<String>> = vec![heads.collect()];
    for point in &points {
        let ends = edges(case, vary, &point.values);
        let at_end = |k: usize| ends.iter().any(|e| e.name == found.varied[k]);
        let values = found.shown.iter().zip(&point.values).enumerate();
        let values = values.map(|(k, (u, v))| format!("{}{}", v.shown(u), if at_end(k) { "*" } else { "" }));
        let objectives = shown.iter().zip(&point.objectives).map(|(u, value)| significant(u.of(*value)));
        rows.push(values.chain(objectives).collect());
    }
    let width = |k: usize| rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let mut text =
        format!("Pareto set: {} of {} points; * at an end of the range\n", points.len(), found.points.len());
    for row in &rows {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        text += &format!("  {}\n", cells.join("  ").trim_end());
    }
    text
}
