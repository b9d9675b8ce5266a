//! `motor-fmu cosim` runs a system of FMUs, `motor-fmu ssp` writes one as an SSP archive.
use crate::Failure;
use crate::drawing;
use crate::existing::{Force, check_apart, check_place, is_stdout};
use crate::outputs::{self, Shown};
use crate::parent;
use crate::simulate::{check_once, is_a_number, remarks, rounded, setting, significant, time};
use clap::ValueEnum;
use cosim::{Algorithm, Log, PowerBond, SspForm, System, SystemOptions, SystemRun, cosimulate};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Run a system of Co-Simulation FMUs: SSP 1.0 or 2.0, or the TOML file that `motor-fmu ssp` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The system: SYSTEM.ssp or SYSTEM.toml
    pub system: PathBuf,
    /// Start time in s or with a unit [default: that of the system, else 0]
    #[arg(long, value_name = "S", value_parser = time, allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in s or with a unit, such as "10 min" [default: that of the system, else 1 s after the start]
    #[arg(long, value_name = "S", value_parser = time, allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Communication step in s or with a unit [default: that of the system, else the shortest that an FMU proposes]
    #[arg(long, value_name = "H", value_parser = time, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Set a parameter or input of a component, or an input of the system: a number in its unit, of a component also with another unit
    /// of the quantity, such as "35 degC". May be repeated
    #[arg(long = "set", value_name = "COMPONENT.VARIABLE=VALUE", value_parser = setting)]
    sets: Vec<(String, String)>,
    /// Inputs over time: CSV with the header time,<component.variable or input of the system>, each with [unit] if wanted; reals are
    /// interpolated linearly, other inputs are constant between rows; - reads the standard input
    #[arg(long, value_name = "F.csv")]
    pub input: Option<PathBuf>,
    /// Coupling algorithm
    #[arg(long, value_enum, default_value_t = Scheme::Jacobi)]
    algorithm: Scheme,
    /// Keep inputs constant over a step, also if an FMU accepts input derivatives
    #[arg(long, alias = "no-slopes")]
    no_input_derivatives: bool,
    /// Variable communication step with this relative error of the connected outputs; the FMUs must support rollback
    #[arg(long, value_name = "R")]
    tolerance: Option<f64>,
    /// Step components at the same time in N threads, with `jacobi` and `jacobi-delayed`. The results are the same bits. Faster where
    /// a step of a component takes more than about 20 us. Do not use with FMUs whose instances share global data; the FMUs of this
    /// project share none
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: u32,
    /// Record every N-th communication point [default: the least of 1, 2, 5, 10, ... for 100,000 rows at most]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,
    #[command(flatten)]
    shown: Shown,
    /// Write time and the outputs as CSV with 17 digits: time,<component>.<output>; - prints the table in place of the final values
    #[arg(long, value_name = "F.csv")]
    output: Option<PathBuf>,
    /// Draw the outputs with their limits as SVG, PNG or HTML: those of --outputs, else the main ones
    #[arg(long, value_name = "F.svg|F.png|F.html")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print final values and the coupling energy residuals of the power bonds as JSON
    #[arg(long)]
    json: bool,
    /// Time limit of one call of an FMU
    #[arg(long, value_name = "SECONDS", default_value = parent::PATIENCE, value_parser = crate::validate::seconds)]
    pub patience: f64,
}

/// Write a system, described in a small TOML file or an SSP file, as an SSP 1.0 archive with its FMUs.
#[derive(Debug, clap::Args)]
pub struct SspArgs {
    /// The description: SYSTEM.toml or SYSTEM.ssp
    system: PathBuf,
    /// The archive [default: the name of SYSTEM.toml with .ssp; required for SYSTEM.ssp]
    #[arg(long, value_name = "FILE.ssp")]
    out: Option<PathBuf>,
    /// Leave out the inputs and outputs of the system itself: for ecos, which reads connections between components only
    #[arg(long)]
    components_only: bool,
    /// Connect the components through a signal dictionary (SSB) in a file of its own. Not for ecos and libcosim
    #[arg(long)]
    dictionary: bool,
    #[command(flatten)]
    force: Force,
}

/// The names of the algorithms on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Scheme {
    /// Parallel: all components step from the same inputs; direct feedthrough is resolved at the same communication point
    Jacobi,
    /// Sequential: later components use the end values of the earlier ones
    GaussSeidel,
    /// As jacobi, but a value with direct feedthrough is delayed by one step, as in many other masters
    JacobiDelayed,
}

impl From<Scheme> for Algorithm {
    fn from(scheme: Scheme) -> Algorithm {
        match scheme {
            Scheme::Jacobi => Algorithm::Jacobi,
            Scheme::GaussSeidel => Algorithm::GaussSeidel,
            Scheme::JacobiDelayed => Algorithm::JacobiDelayed,
        }
    }
}

/// Runs the command in this process.
pub fn run(args: Args) -> Result<u8, Failure> {
    let system = System::open(&args.system)?;
    may_write(&args, &system)?;
    check_once(&args.sets)?;
    for (name, description) in system.descriptions() {
        let sentence = crate::unused::unserved(&format!("{name}."), description, &args.sets);
        sentence.map_or(Ok(()), |sentence| Err(Failure::new(format!("component {name}: {sentence}"))))?;
    }
    let (main, limits) = match &args.plot {
        Some(_) => outputs::of_system(&system),
        None => Default::default(),
    };
    let options = SystemOptions {
        records: limits.iter().map(|l| l.variable.clone()).collect(),
        start: args.start,
        stop: args.stop,
        step: args.step,
        tolerance: args.tolerance,
        sets: args.sets,
        input: args.input,
        display_units: args.shown.has_display_units(),
        algorithm: args.algorithm.into(),
        held_inputs: args.no_input_derivatives,
        every: args.every.map(|every| every as usize),
        threads: args.threads as usize,
        log: Log::new(),
    };
    let mut run = cosimulate(&system, &options, &mut parent::progress)?;
    let limits = outputs::take_limits(&mut run.recording, &limits, &[]);
    let finite = is_a_number(&run.recording);
    args.shown.apply(&mut run.recording, &|name| {
        let inner = |(component, _): &(&str, _)| name.strip_prefix(component)?.strip_prefix('.');
        let found = system.descriptions().find_map(|part| part.1.variable(inner(&part)?));
        found.map(|v| format!("{name} is no output (causality {}); cosim records outputs only", v.causality))
    })?;
    let table = args.shown.write(&run.recording, args.output.as_deref())?;
    if let Some(path) = &args.plot {
        drawing::write(path, &args.shown.figure(&run.recording, &limits, &main)?)?;
    }
    crate::remark(&run.notes);
    let ended_by = run.ended_by.as_deref().unwrap_or_default();
    remarks(&run.recording, "", ended_by, ended_by);
    let text = if let Some(table) = table {
        table
    } else if args.json {
        format!("{}\n", machine(&args.system.to_string_lossy(), &run))
    } else {
        summary(&run)
    };
    crate::say(&text);
    Ok(crate::code(run.recording.ended_early.is_none() && finite))
}

/// Refuses files that are no earlier results of this system.
fn may_write(args: &Args, system: &System) -> Result<(), Failure> {
    let name = system.name();
    check_apart(args.output.as_deref(), args.plot.as_deref(), args.json)?;
    if let Some(path) = args.output.as_ref().filter(|path| !is_stdout(path)) {
        check_place(path)?;
        // Outputs of the system have names of their own.
        let is_column = |column: &str| {
            column
                .split_once('.')
                .is_none_or(|(component, _)| system.components().any(|known| known == component))
        };
        args.force.check_table(path, &format!("a table of outputs of {name}"), is_column)?;
    }
    let is_title = |title: &str| title == name;
    drawing::check(args.plot.as_deref(), args.force, &format!("a figure of {name}"), is_title)
}

pub fn run_ssp(args: &SspArgs) -> Result<ExitCode, Failure> {
    let out = args.out.clone().unwrap_or_else(|| args.system.with_extension("ssp"));
    if out == args.system {
        return Err(Failure::new(format!("{} would be written over itself, give --out", out.display())));
    }
    let system = System::open(&args.system)?;
    check_place(&out)?;
    args.force.check(&out, &format!("an SSP archive of {}", system.name()), |path| {
        System::open(path).is_ok_and(|earlier| earlier.name() == system.name())
    })?;
    let form = SspForm { components_only: args.components_only, dictionary: args.dictionary };
    system.write_ssp(&out, form)?;
    let note = |name: &str| {
        format!(
            "component {name} has variables that begin with {name}., and OMSimulator cannot read such a system; rename it for this tool"
        )
    };
    let mut notes: Vec<String> = system.ambiguous_names().map(note).collect();
    if system.has_connectors() && !args.components_only {
        notes.push(
            "the system has inputs or outputs of its own, and ecos reads connections between components only; --components-only leaves them out"
                .to_owned(),
        );
    }
    crate::remark(&notes);
    crate::say(&format!("{}\n", out.display()));
    Ok(ExitCode::SUCCESS)
}

fn summary(run: &SystemRun) -> String {
    let recording = &run.recording;
    let last = recording.times.last().copied().unwrap_or(0.0);
    let mut text = format!(
        "{}: {} components, {} steps to t = {} s in {:.3} s",
        recording.model_name,
        run.order.len(),
        recording.steps,
        rounded(last),
        recording.seconds_wall
    );
    if run.rejected > 0 {
        text += &format!(", {} made again shorter", run.rejected);
    }
    text.push('\n');
    if run.every > 1 {
        text += &format!("one row for every {} communication points\n", run.every);
    }
    text += &crate::simulate::final_values(recording);
    text + &power_bonds(&run.bonds)
}

/// The power bonds as a table.
fn power_bonds(bonds: &[PowerBond]) -> String {
    if bonds.is_empty() {
        return String::new();
    }
    let names: Vec<String> = bonds.iter().map(|b| format!("{} | {}", b.forth, b.back)).collect();
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
    let mut text = format!(
        "power bonds\n  {:width$}  {:>12} {:>12} {:>12} {:>10} {:>10}\n",
        "", "energy J", "throughput J", "residual J", "relative", "gross"
    );
    for (name, bond) in names.iter().zip(bonds) {
        text += &format!(
            "  {name:width$}  {:>12} {:>12} {:>12} {:>8.4} % {:>8.4} %\n",
            significant(bond.energy),
            significant(bond.throughput),
            significant(bond.residual),
            100.0 * bond.relative_residual(),
            100.0 * bond.relative_gross_residual()
        );
    }
    text
}

/// The result for a script.
fn machine(file: &str, run: &SystemRun) -> Value {
    let recording = &run.recording;
    let finals: Map<String, Value> = recording.columns.iter().map(crate::simulate::last_value).collect();
    let bonds: Vec<Value> = run
        .bonds
        .iter()
        .map(|b| {
            json!({
                "forth": b.forth, "back": b.back,
                "energy_J": b.energy, "throughput_J": b.throughput,
                "error_J": b.residual, "gross_error_J": b.gross_residual,
                "share": b.relative_residual(), "gross_share": b.relative_gross_residual(),
            })
        })
        .collect();
    let mut result = json!({
        "file": file,
        "system": recording.model_name,
        "order": run.order,
        "steps": recording.steps,
        "rejected": run.rejected,
        "slopes": run.input_derivatives,
        "every": run.every,
        "rows": recording.times.len(),
        "seconds_wall": recording.seconds_wall,
        "notes": run.notes,
        "energy": bonds,
        "final": finals,
    });
    if let (Some(name), Some(time)) = (&run.ended_by, recording.ended_early) {
        result["ended_early"] = json!(time);
        result["ended_by"] = json!(name);
    }
    result
}
