//! The master for one FMU: settings, initialization, steps, recording.
use crate::drive::Drive;
use crate::grid::Grid;
use crate::input::{InputColumn, InputTable};
use crate::integrator::{Inputs, Integrator};
use crate::system::Batch;
use crate::{
    Archive, Causality, Column, Error, Experiment, Instance, Interface, InterfaceType, Kind, Log,
    ModelDescription, Recording, Step, Value, Variable,
};
use std::slice::from_mut;
use std::time::Instant;

/// Options of a run of an FMU. `None` means the value of the FMU's default experiment.
#[derive(Clone, Debug)]
pub struct Options {
    /// Start time (s), else 0.
    pub start: Option<f64>,
    /// Stop time (s), else 1 s after the start.
    pub stop: Option<f64>,
    /// Communication step (s), else a 500th of the time span.
    pub step: Option<f64>,
    /// Parameters and inputs to set, as name and text, see [`ModelDescription::parse_value`].
    pub sets: Vec<(String, String)>,
    /// The interface type; else Co-Simulation where the FMU has it, else Model Exchange.
    pub interface: Option<InterfaceType>,
    /// Relative tolerance: given to the FMU, and kept in Model Exchange; else that of the default experiment, else 1e-6.
    pub tolerance: Option<f64>,
    /// Further variables to record.
    pub records: Vec<String>,
    /// Inputs over time.
    pub input: Option<InputTable>,
    /// Set the derivatives of continuous inputs of FMUs that take them (FMI 3: intermediate update); otherwise inputs are constant during a step.
    pub input_slopes: bool,
    /// Log of the FMU's messages.
    pub log: Log,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            start: None,
            stop: None,
            step: None,
            sets: Vec::new(),
            interface: None,
            tolerance: None,
            records: Vec::new(),
            input: None,
            input_slopes: true,
            log: Log::new(),
        }
    }
}

/// Elements of an array that are recorded.
const MAX_ELEMENTS: u64 = 100_000;

/// Runs an FMU from start to stop and records its outputs.
///
/// Parameters are set before initialization, inputs during it. At each communication point the inputs are set, then
/// the FMU steps, then the outputs are read, so an output with direct feedthrough depends on the input of the step that
/// ends there. `progress` gets the fraction of the time that is simulated, 0 ... 1, at most about 200 times.
///
/// # Errors
/// Bad options (see [`Options`] and [`ModelDescription::parse_value`]), and all that [`Instance`] reports.
pub fn simulate(
    archive: &Archive,
    options: &Options,
    progress: &mut dyn FnMut(f64),
) -> Result<Recording, Error> {
    let description = archive.description();
    let kind = chosen(description, options);
    let interface = description.interface(kind).cloned().unwrap_or_default();
    let sets = checked_sets(description, options)?;
    let grid = grid(description, &interface, options)?;

    let begun = Instant::now();
    let takes_slope = |column: &InputColumn| {
        options.input_slopes && description.takes_input_derivative(&description.variables[column.variable])
    };
    let columns = options.input.iter().flat_map(InputTable::columns);
    let sloped: Vec<u32> = columns.filter(|c| takes_slope(c)).map(|c| c.value_reference).collect();
    let (name, log) = (&description.model_name, options.log.clone());
    let mut instance = Instance::instantiate_as(archive, name, log, kind, &sloped)?;
    let tolerance = tolerance(description, options)?;
    initialise(&mut instance, &sets, &Experiment { start: grid.start, stop: Some(grid.stop), tolerance })?;
    let mut drive = options.input.as_ref().map(|table| Drive::new(table, &takes_slope, grid.slack));
    if let Some(drive) = &mut drive {
        drive.set_values(from_mut(&mut instance), grid.start)?;
    }
    instance.exit_initialization()?;

    let mut recorder = Recorder::new(description, &sets, &options.records, grid.steps + 1)?;
    let mut integrator = None;
    if kind == InterfaceType::ModelExchange {
        let tolerance = tolerance.unwrap_or(TOLERANCE);
        let reports = interface.needs_completed_step;
        integrator = Integrator::start(&mut instance, description, grid.start, tolerance, reports)?;
        if integrator.is_none() {
            return Err(Error::unsupported(
                &description.model_name,
                "requests the end of the simulation at its start",
            ));
        }
    }
    recorder.record(&mut instance, grid.start)?;
    // The solver of Model Exchange finds the jumps by itself.
    let divides = interface.can_handle_variable_step && integrator.is_none();
    let table = options.input.as_ref().filter(|_| divides);
    let (steps, ended_early) = grid.run(table, progress, |t, h, end, point| {
        let step = match (&mut integrator, &mut drive) {
            (Some(integrator), Some(drive)) => integrator.advance(&mut instance, end, drive)?,
            (Some(integrator), None) => integrator.advance(&mut instance, end, &mut NoInputs)?,
            (None, drive) => {
                if let Some(drive) = drive {
                    drive.set_values(from_mut(&mut instance), t)?;
                    drive.set_slopes(from_mut(&mut instance), t, h)?;
                }
                instance.do_step(t, h)?
            }
        };
        if step == Step::Terminated {
            return Ok(Some(t));
        }
        if point.is_some() {
            recorder.record(&mut instance, end)?;
        }
        Ok(None)
    })?;
    instance.terminate()?;
    drop(instance);
    Ok(Recording {
        model_name: description.model_name.clone(),
        times: recorder.times,
        columns: recorder.columns,
        steps,
        seconds_wall: begun.elapsed().as_secs_f64(),
        ended_early,
        messages: options.log.messages(),
    })
}

/// Relative tolerance of Model Exchange where nobody gives one.
const TOLERANCE: f64 = 1e-6;

/// The interface type of a run.
fn chosen(description: &ModelDescription, options: &Options) -> InterfaceType {
    let has = |kind| description.interface(kind).is_some();
    options.interface.unwrap_or_else(|| {
        let exchange = !has(InterfaceType::CoSimulation) && has(InterfaceType::ModelExchange);
        if exchange { InterfaceType::ModelExchange } else { InterfaceType::CoSimulation }
    })
}

/// The tolerance from the options, else from the default experiment.
fn tolerance(description: &ModelDescription, options: &Options) -> Result<Option<f64>, Error> {
    match options.tolerance {
        Some(tolerance) if !(tolerance > 0.0 && tolerance < 1.0) => {
            Err(Error::option("tolerance", tolerance, "must be above 0 and below 1"))
        }
        Some(tolerance) => Ok(Some(tolerance)),
        None => Ok(description.default_experiment.tolerance.filter(|t| *t > 0.0 && *t < 1.0)),
    }
}

/// The communication points of a run, from the options, else from the default experiment.
fn grid(description: &ModelDescription, interface: &Interface, options: &Options) -> Result<Grid, Error> {
    let default = &description.default_experiment;
    let start = options.start.or(default.start).unwrap_or(0.0);
    let stop = options.stop.or(default.stop).unwrap_or(start + 1.0);
    let step = options.step.or(default.step);
    let fallback = |span: f64| match interface.fixed_internal_step_size {
        Some(fixed) if fixed > 0.0 => fixed * (span / 500.0 / fixed).round().max(1.0),
        _ => span / 500.0,
    };
    let rigid = !interface.can_handle_variable_step && interface.kind == InterfaceType::CoSimulation;
    Grid::new(start, stop, step, fallback, rigid.then_some(description.model_name.as_str()))
}

/// The settings as variables and values; rejects repeated settings.
fn checked_sets<'a>(
    description: &'a ModelDescription,
    options: &Options,
) -> Result<Vec<(&'a Variable, Value)>, Error> {
    let mut sets: Vec<(&Variable, Value)> = Vec::new();
    for (name, text) in &options.sets {
        let set = description.parse_value(name, text)?;
        let reason = if sets.iter().any(|(v, _)| v.name == *name) {
            "is set twice"
        } else if options.input.iter().flat_map(InputTable::names).any(|n| n == name) {
            "is also a column of the input table"
        } else {
            sets.push(set);
            continue;
        };
        let reason = format!("is refused because {name} {reason}");
        return Err(Error::unsupported(format!("setting {name} = {text}"), reason));
    }
    Ok(sets)
}

/// Sets parameters, structural ones in configuration mode, enters initialization mode and sets inputs.
pub(crate) fn initialise(
    instance: &mut Instance,
    sets: &[(&Variable, Value)],
    experiment: &Experiment,
) -> Result<(), Error> {
    let set = |instance: &mut Instance, role: Causality| {
        let of_role = |(variable, _): &&(&Variable, Value)| variable.causality == role;
        sets.iter().filter(of_role).try_for_each(|(variable, value)| instance.set_value(variable, value))
    };
    if sets.iter().any(|(v, _)| v.causality == Causality::StructuralParameter) {
        instance.enter_configuration_mode()?;
        set(instance, Causality::StructuralParameter)?;
        instance.exit_configuration_mode()?;
    }
    instance.setup_experiment(experiment)?;
    set(instance, Causality::Parameter)?;
    instance.enter_initialization(experiment)?;
    set(instance, Causality::Input)
}

/// A run without inputs over time.
struct NoInputs;

impl Inputs for NoInputs {
    fn set_continuous(&mut self, _: &mut Instance, _: f64, _: f64) -> Result<(), Error> {
        Ok(())
    }

    fn set_all(&mut self, _: &mut Instance, _: f64) -> Result<(), Error> {
        Ok(())
    }

    fn next_break(&self, _: f64) -> Option<f64> {
        None
    }

    fn jumps(&self, _: f64) -> bool {
        false
    }
}

/// Reads the outputs and keeps them.
pub(crate) struct Recorder {
    pub(crate) times: Vec<f64>,
    pub(crate) columns: Vec<Column>,
    groups: Vec<Batch>,
    /// A row of 64-bit integers.
    integers: Vec<i128>,
}

impl Recorder {
    pub(crate) fn new(
        description: &ModelDescription,
        sets: &[(&Variable, Value)],
        records: &[String],
        rows: usize,
    ) -> Result<Self, Error> {
        let further = records.iter().map(|name| description.recordable(name));
        let further = further.collect::<Result<Vec<_>, _>>()?;
        let outputs = description.outputs().filter(|v| !further.iter().any(|f| f.name == v.name));
        let size_of = |reference: u32| {
            sets.iter().find_map(|(variable, value)| match value {
                Value::Integer(n)
                    if variable.value_reference == reference
                        && variable.causality == Causality::StructuralParameter =>
                {
                    u64::try_from(*n).ok()
                }
                _ => None,
            })
        };
        let mut recorder =
            Self { times: Vec::new(), columns: Vec::new(), groups: Vec::new(), integers: Vec::new() };
        let mut complete = recorder.times.try_reserve_exact(rows).is_ok();
        for variable in outputs.chain(further.iter().copied()).filter(|v| v.kind.is_numeric()) {
            let count = description.element_count(variable, &size_of);
            if count == 0 {
                continue;
            }
            if count > MAX_ELEMENTS {
                let reason =
                    format!("cannot be recorded: it has {count} elements, the limit is {MAX_ELEMENTS}");
                return Err(Error::unsupported(&variable.name, reason));
            }
            let group = Batch::of(&mut recorder.groups, 0, variable.kind);
            group.vrs.push(variable.value_reference);
            for element in 1..=count {
                group.push(recorder.columns.len());
                let mut values = Vec::new();
                complete &= values.try_reserve_exact(rows).is_ok();
                recorder.columns.push(Column {
                    name: if variable.dimensions.is_empty() {
                        variable.name.clone()
                    } else {
                        format!("{}[{element}]", variable.name)
                    },
                    kind: variable.kind,
                    unit: variable.unit.clone(),
                    display_unit: description.display_unit(variable),
                    values,
                    exact: Vec::new(),
                });
                if !complete {
                    let reason = format!("cannot be recorded: {rows} rows do not fit into memory");
                    return Err(Error::unsupported(&description.model_name, reason));
                }
            }
        }
        Ok(recorder)
    }

    pub(crate) fn record(&mut self, instance: &mut Instance, t: f64) -> Result<(), Error> {
        self.times.push(t);
        for group in &mut self.groups {
            if matches!(group.kind, Kind::Int64 | Kind::UInt64) {
                self.integers.resize(group.values.len(), 0);
                instance.get_integers(group.kind, &group.vrs, &mut self.integers)?;
                for ((exact, value), column) in self.integers.iter().zip(&mut group.values).zip(&group.slots)
                {
                    *value = *exact as f64;
                    self.columns[*column].exact.push(*exact);
                }
            } else {
                instance.get_number(group.kind, &group.vrs, &mut group.values)?;
            }
            for (value, column) in group.values.iter().zip(&group.slots) {
                self.columns[*column].values.push(*value);
            }
        }
        Ok(())
    }
}
