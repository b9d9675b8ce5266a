//! The run of a system: options, the fixed step, and the result. The variable step is in `variable_step.rs`.
use super::System;
use super::connections::resolve;
use super::inputs;
use super::master::{Master, Outcome, Plan};
use super::order::{Algorithm, order};
use super::parts::Parts;
use super::power_bonds::PowerBond;
use super::record::Record;
use super::times::{self, Times};
use super::variable_step::{self, Control};
use crate::{Error, InputTable, Log, Recording};
use std::path::PathBuf;
use std::time::Instant;

/// Options of a run of a system. `None` means the value of the system, else of its FMUs.
#[derive(Clone, Debug, Default)]
pub struct SystemOptions {
    /// Start time (s), else 0.
    pub start: Option<f64>,
    /// Stop time (s), else 1 s after the start.
    pub stop: Option<f64>,
    /// Communication step (s), else the shortest that an FMU proposes, else a 500th of the time. With a tolerance it is
    /// the first step.
    pub step: Option<f64>,
    /// Relative tolerance of the connected outputs: the step varies; each is taken once and repeated as two half steps.
    pub tolerance: Option<f64>,
    /// Settings `component.variable` or inputs of the system, as name and text; they win over the file's.
    pub sets: Vec<(String, String)>,
    /// CSV file of inputs over time, with columns `component.variable` or inputs of the system.
    pub input: Option<PathBuf>,
    /// Numbers without a unit in `sets` and columns without a unit in `input` are in the display unit of the variable, unless the
    /// connector of the system has another unit than the variable.
    pub display_units: bool,
    /// Coupling algorithm.
    pub algorithm: Algorithm,
    /// Hold all inputs constant during a step, also where an FMU takes input derivatives.
    pub held_inputs: bool,
    /// Threads in which components step at the same time; 0 or 1 steps one after the other. Results are the same bits.
    pub threads: usize,
    /// Communication points between rows of the recording; by default the least of 1, 2, 5, 10, 20, ... that keeps the
    /// rows at 100,000.
    pub every: Option<usize>,
    /// Further variables to record, `component.variable`.
    pub records: Vec<String>,
    /// Log of the FMUs' messages.
    pub log: Log,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct SystemRun {
    /// The outputs of all components as `component.output`, then those of the system.
    pub recording: Recording,
    /// Power bonds: pairs of connections that carry power.
    pub bonds: Vec<PowerBond>,
    /// Warnings: inputs without a source, loops closed with a delay of one step.
    pub notes: Vec<String>,
    /// The component that requested the end, if the run ended early.
    pub ended_by: Option<String>,
    /// Communication points between rows.
    pub every: usize,
    /// Names of the components in the order in which they step.
    pub order: Vec<String>,
    /// Rejected steps; 0 for a fixed step.
    pub rejected: usize,
    /// Input derivatives were set.
    pub input_derivatives: bool,
}

/// Runs a system from start to stop.
///
/// At every communication point all connections are updated, in an order that respects direct feedthrough (see [`Algorithm`] for
/// the exception). Then all components step.
/// `progress` gets the fraction of the time that is simulated, 0 ... 1, at most about 200 times.
///
/// # Errors
/// A connection, a setting or a component that does not fit, with its place in the file; an algebraic loop; bad times;
/// a failed call of an FMU, with its messages.
pub fn cosimulate(
    system: &System,
    options: &SystemOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<SystemRun, Error> {
    let parts = system.parts();
    let structure = parts.structure;
    let mut connections = resolve(parts, &options.sets, options.display_units)?;
    let table = options
        .input
        .as_deref()
        .map(|path| inputs::read(path, parts, &connections, options.display_units))
        .transpose()?;
    connections.check_open_inputs(parts, table.as_ref())?;
    connections.notes.extend(table.iter().flat_map(InputTable::notes).cloned());
    let order = order(parts, &connections, options.algorithm == Algorithm::JacobiDelayed);
    // A variable step has no fixed communication points.
    let is_fixed = options.tolerance.is_none();
    let rigid = rigid(parts).filter(|_| is_fixed);
    let asked = Times { start: options.start, stop: options.stop, step: options.step };
    let grid = times::grid(parts, asked, rigid)?;
    let (start, stop) = (grid.start, grid.stop);
    times::check_component_steps(parts, &grid, is_fixed)?;
    if options.every == Some(0) {
        return Err(Error::option("every", 0, "must be above 0"));
    }
    if let Some(tolerance) = options.tolerance {
        check_tolerance(parts, tolerance)?;
    }

    let started = Instant::now();
    let plan = Plan {
        algorithm: options.algorithm,
        derivatives: !options.held_inputs,
        start,
        stop,
        tolerance: options.tolerance,
        threads: options.threads,
        table: table.as_ref(),
        slack: grid.slack,
        log: options.log.clone(),
    };
    let mut master = Master::start(parts, &connections, &order, &plan)?;
    let points = options.tolerance.is_none().then_some(grid.steps);
    let mut record = Record::new(parts, &connections, points, options.every, &options.records)?;
    record.point(&mut master, start, false)?;
    let outcome = match options.tolerance {
        None => {
            let table = table.as_ref().filter(|_| rigid.is_none());
            let (steps, ended) = grid.run(table, progress, |t, h, end, point| {
                let ended = master.step(t, h)?.map(|component| (component, t));
                if let (None, Some(point)) = (ended, point) {
                    record.point(&mut master, end, point == grid.steps)?;
                }
                Ok(ended)
            })?;
            Outcome { steps, rejected: 0, ended }
        }
        Some(tolerance) => {
            let order = if master.has_derivatives() { 2 } else { 1 };
            let control = Control { tolerance, order, first: grid.step, start, stop };
            variable_step::run(&mut master, &mut record, &control, progress)?
        }
    };
    master.terminate()?;
    let input_derivatives = master.has_derivatives();
    let loop_notes = std::mem::take(&mut master.notes);
    let bonds = master.bonds().bonds.clone();
    drop(master);
    let every = record.every;
    let (times, columns) = record.columns(parts, &connections);
    let name = |index: usize| structure.components[index].name.clone();
    let sequence = match options.algorithm {
        Algorithm::GaussSeidel => order.components,
        Algorithm::Jacobi | Algorithm::JacobiDelayed => (0..structure.components.len()).collect(),
    };
    Ok(SystemRun {
        recording: Recording {
            model_name: structure.name.clone(),
            ended_early: outcome.ended.map(|(_, t)| t),
            times,
            columns,
            steps: outcome.steps,
            seconds_wall: started.elapsed().as_secs_f64(),
            messages: options.log.messages(),
        },
        bonds,
        notes: connections.notes.into_iter().chain(order.notes).chain(loop_notes).collect(),
        ended_by: outcome.ended.map(|(index, _)| name(index)),
        every,
        order: sequence.into_iter().map(name).collect(),
        rejected: outcome.rejected,
        input_derivatives,
    })
}

/// A component that cannot vary its step.
fn rigid(parts: Parts<'_>) -> Option<&str> {
    let can =
        |index: &usize| parts.description(*index).co_simulation().is_some_and(|c| c.can_handle_variable_step);
    let index = (0..parts.archives.len()).find(|index| !can(index))?;
    Some(&parts.structure.components[index].name)
}

/// A variable step needs FMUs with variable communication step size and rollback.
fn check_tolerance(parts: Parts, tolerance: f64) -> Result<(), Error> {
    let refuse = |reason: String| Err(Error::option("tolerance", tolerance, reason));
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return refuse("must be above 0 and below 1".to_owned());
    }
    if let Some(name) = rigid(parts) {
        return refuse(format!("requires a variable communication step, which {name} does not support"));
    }
    for (archive, component) in parts.archives.iter().zip(&parts.structure.components) {
        if !archive.description().co_simulation().is_some_and(|c| c.can_get_and_set_state) {
            return refuse(format!("requires rollback, but {} cannot save its state", component.name));
        }
    }
    Ok(())
}
