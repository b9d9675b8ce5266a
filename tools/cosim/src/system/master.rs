//! The co-simulation master: instances, the values of all connections, and one communication step.
use super::batch::Batch;
use super::component_steps::{ComponentStep, component_steps, has_derivative, has_slope};
use super::connections::Connections;
use super::loops::LoopSolver;
use super::memory::Memory;
use super::order::{Algorithm, Loop, Order};
use super::parts::Parts;
use super::power_bonds::{PowerBonds, Stepped};
use super::side_by_side::SideBySide;
use super::units::Affine;
use crate::drive::Drive;
use crate::input::InputColumn;
use crate::simulate::initialise;
use crate::{Error, Experiment, InputTable, Instance, InterfaceType, Log, State, Step, Value, Variable};

/// One round of an exchange: read, then set.
#[derive(Debug, Default)]
struct Round {
    gets: Vec<Batch>,
    sets: Vec<Batch>,
}

/// Result of the steps of a run.
#[derive(Default)]
pub(crate) struct Outcome {
    pub(crate) steps: usize,
    pub(crate) rejected: usize,
    /// The component that requested the end, and the time.
    pub(crate) ended: Option<(usize, f64)>,
}

/// How a system is to be run.
pub(crate) struct Plan<'a> {
    pub(crate) algorithm: Algorithm,
    /// Input derivatives are set where the FMU takes them.
    pub(crate) derivatives: bool,
    pub(crate) start: f64,
    pub(crate) stop: f64,
    /// For the FMUs; each FMU's own proposal when absent.
    pub(crate) tolerance: Option<f64>,
    /// Threads in which components step.
    pub(crate) threads: usize,
    /// Inputs over time; times closer than `slack` (s) are the same.
    pub(crate) table: Option<&'a InputTable>,
    pub(crate) slack: f64,
    pub(crate) log: Log,
}

pub(crate) struct Master<'a> {
    pub(crate) instances: Vec<Instance>,
    /// Inputs over time.
    drive: Option<Drive<'a>>,
    memory: Memory,
    saved: Option<(Memory, Vec<State>)>,
    rounds: Vec<Round>,
    loops: Vec<LoopSolver>,
    /// Loops that the FMUs may close with a delay.
    pub(crate) notes: Vec<String>,
    /// All connected inputs, to set them after a rollback.
    all_inputs: Vec<Batch>,
    /// Inputs with derivatives, by component.
    derivative_sets: Vec<Batch>,
    /// For each input its source and conversion.
    sources: Vec<(usize, Affine)>,
    /// Whether an input gets a derivative.
    has_derivative: Vec<bool>,
    derivatives: Vec<f64>,
    before: Vec<f64>,
    algorithm: Algorithm,
    /// The order of steps; for Gauss-Seidel also the inputs set before and the outputs read after each step.
    component_steps: Vec<ComponentStep>,
    /// Where components step at the same time.
    side_by_side: Option<SideBySide>,
}

/// Largest number of iterations for consistent initial values.
const MAX_ITERATIONS: usize = 100;

impl<'a> Master<'a> {
    /// Instantiates and initialises all components; connected inputs and outputs agree afterwards.
    pub(crate) fn start(
        parts: Parts,
        connections: &Connections,
        order: &Order,
        plan: &Plan<'a>,
    ) -> Result<Self, Error> {
        let mut instances = Vec::new();
        for (index, component) in parts.structure.components.iter().enumerate() {
            let inputs = connections.inputs.iter().filter(|i| i.port.component == index);
            let inputs = inputs.filter(|i| has_derivative(parts, connections, i));
            let columns = plan.table.iter().flat_map(|table| table.columns());
            let columns = columns.filter(|c| c.component == index && has_slope(parts, c));
            let sloped = inputs.map(|i| parts.variable(i.port).value_reference);
            let sloped: Vec<u32> = sloped.chain(columns.map(|c| c.value_reference)).collect();
            let sloped = if plan.derivatives { &sloped[..] } else { &[] };
            let (archive, log) = (&parts.archives[index], plan.log.clone());
            let kind = InterfaceType::CoSimulation;
            instances.push(Instance::instantiate_as(archive, &component.name, log, kind, sloped)?);
        }
        let mut master = Self::new(parts, connections, order, plan, instances);
        if plan.threads > 1 {
            master.side_by_side = Some(SideBySide::new(plan.threads, &mut master.instances)?);
        }
        for (index, sets) in connections.sets.iter().enumerate() {
            let variables = &parts.description(index).variables;
            let sets: Vec<(&Variable, Value)> =
                sets.iter().map(|(v, value)| (&variables[*v], value.clone())).collect();
            let tolerance = plan.tolerance.or(parts.description(index).default_experiment.tolerance);
            let experiment = Experiment { start: plan.start, stop: Some(plan.stop), tolerance };
            initialise(&mut master.instances[index], &sets, &experiment)?;
        }
        master.find_initial_values(parts, connections)?;
        for instance in &mut master.instances {
            instance.exit_initialization()?;
        }
        // Some outputs have their values only now.
        master.exchange()?;
        master.check_loops(parts, plan.start)?;
        master.memory.earlier.copy_from_slice(&master.memory.inputs);
        Ok(master)
    }

    fn new(
        parts: Parts,
        connections: &Connections,
        order: &Order,
        plan: &Plan<'a>,
        instances: Vec<Instance>,
    ) -> Self {
        let algorithm = plan.algorithm;
        let delayed = algorithm == Algorithm::JacobiDelayed;
        let count = if delayed { order.rounds.min(1) } else { order.rounds };
        let mut rounds: Vec<Round> = (0..count).map(|_| Round::default()).collect();
        let loops = order.loops.iter().filter(|_| !delayed);
        let loops: Vec<LoopSolver> = loops.map(|l| LoopSolver::new(parts, connections, l)).collect();
        let solved = |of: fn(&Loop) -> &Vec<usize>, slot: &usize| {
            !delayed && order.loops.iter().any(|l| of(l).contains(slot))
        };
        for (slot, port) in connections.outputs.iter().enumerate() {
            if solved(|l| &l.outputs, &slot) {
                continue;
            }
            let round = if delayed { 0 } else { order.read[slot] };
            Batch::add(&mut rounds[round].gets, port.component, parts.variable(*port), slot);
        }
        let (mut all_inputs, mut derivative_sets) = (Vec::new(), Vec::new());
        let mut sloped = vec![false; connections.inputs.len()];
        for (slot, input) in connections.inputs.iter().enumerate() {
            let (component, variable) = (input.port.component, parts.variable(input.port));
            let round = if delayed { 0 } else { order.set[slot] };
            if !solved(|l| &l.inputs, &slot) {
                Batch::add(&mut rounds[round].sets, component, variable, slot);
            }
            Batch::add(&mut all_inputs, component, variable, slot);
            sloped[slot] = plan.derivatives && has_derivative(parts, connections, input);
            if sloped[slot] {
                Batch::add(&mut derivative_sets, component, variable, slot);
            }
        }
        let sources: Vec<(usize, Affine)> =
            connections.inputs.iter().map(|f| (f.source, f.convert)).collect();
        let component_steps = component_steps(parts, connections, order, algorithm, &sloped);
        let (outputs, inputs) = (connections.outputs.len(), connections.inputs.len());
        let takes_slope = |column: &InputColumn| plan.derivatives && has_slope(parts, column);
        Self {
            instances,
            drive: plan.table.map(|table| Drive::new(table, &takes_slope, plan.slack)),
            memory: Memory {
                time: plan.start,
                outputs: vec![0.0; outputs],
                integers: vec![0; outputs],
                inputs: vec![f64::NAN; inputs],
                earlier: vec![0.0; inputs],
                last_step: 0.0,
                bonds: PowerBonds::new(parts, connections),
            },
            saved: None,
            rounds,
            loops,
            notes: Vec::new(),
            all_inputs,
            derivative_sets,
            sources,
            has_derivative: sloped,
            derivatives: vec![0.0; inputs],
            before: vec![0.0; outputs],
            algorithm,
            component_steps,
            side_by_side: None,
        }
    }

    pub(crate) fn outputs(&self) -> &[f64] {
        &self.memory.outputs
    }

    /// The next row of the input table after `t` (s).
    pub(crate) fn next_row(&self, t: f64) -> Option<f64> {
        self.drive.as_ref()?.next_row(t)
    }

    /// Whether any input gets a derivative.
    pub(crate) fn has_derivatives(&self) -> bool {
        self.has_derivative.contains(&true)
    }

    /// The power bonds with their energies.
    pub(crate) fn bonds(&self) -> &PowerBonds {
        &self.memory.bonds
    }

    /// Reads all connected outputs and sets all connected inputs, in the order of the dependencies.
    fn exchange(&mut self) -> Result<(), Error> {
        if let Some(drive) = &mut self.drive {
            drive.set_values(&mut self.instances, self.memory.time)?;
        }
        let time = self.memory.time;
        let mut signals = self.memory.signals(&mut self.instances, &self.sources);
        for (place, round) in self.rounds.iter_mut().enumerate() {
            for batch in &mut round.gets {
                batch.read(&mut signals)?;
            }
            for solver in self.loops.iter_mut().filter(|l| l.round == place) {
                solver.solve(&mut signals, time)?;
            }
            for batch in &mut round.sets {
                batch.pass(&mut signals)?;
            }
        }
        Ok(())
    }

    /// Each loop has one solution, and components that only react in steps are noted.
    fn check_loops(&mut self, parts: Parts, start: f64) -> Result<(), Error> {
        let mut signals = self.memory.signals(&mut self.instances, &self.sources);
        for solver in &mut self.loops {
            if let Some((path, component)) = solver.check(&mut signals, start)? {
                let name = &parts.structure.components[component].name;
                self.notes.push(format!(
                    "algebraic loop: {path}: {name} does not react to its inputs at the start; if it evaluates its outputs in \
                     steps alone, its values are delayed by one step"
                ));
            }
        }
        Ok(())
    }

    /// Repeats the exchange until the inputs no longer change: initial values may depend on more than the declared
    /// dependencies.
    fn find_initial_values(&mut self, parts: Parts, connections: &Connections) -> Result<(), Error> {
        for _ in 0..MAX_ITERATIONS {
            self.keep_inputs();
            self.exchange()?;
            if self.changed_input().is_none() {
                return Ok(());
            }
        }
        let Some(input) = self.changed_input() else { return Ok(()) };
        let input = &connections.inputs[input];
        let connection = &parts.structure.connections[input.connection];
        Err(connection.place.fault(format!(
            "{connection}: no consistent initial values, {} still changes after {MAX_ITERATIONS} iterations",
            parts.name(input.port)
        )))
    }

    fn keep_inputs(&mut self) {
        self.memory.earlier.copy_from_slice(&self.memory.inputs);
    }

    /// An input that differs from the exchange before by more than rounding.
    fn changed_input(&self) -> Option<usize> {
        let moved = |(now, then): (&f64, &f64)| {
            let still = (now - then).abs() <= 1e-14 * now.abs().max(then.abs());
            !(still || now.to_bits() == then.to_bits())
        };
        self.memory.inputs.iter().zip(&self.memory.earlier).position(moved)
    }

    /// One communication step. `Some(component)` if a component requests the end.
    pub(crate) fn step(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        self.before.copy_from_slice(&self.memory.outputs);
        self.extrapolate();
        if let Some(drive) = &mut self.drive {
            drive.set_slopes(&mut self.instances, t, h)?;
        }
        let ended = match self.algorithm {
            Algorithm::GaussSeidel => self.step_in_sequence(t, h)?,
            Algorithm::Jacobi | Algorithm::JacobiDelayed => self.step_all(t, h)?,
        };
        if ended.is_some() {
            return Ok(ended);
        }
        // The energies need the inputs as they were set, before the exchange renews them.
        let Memory { inputs, earlier, .. } = &mut self.memory;
        std::mem::swap(inputs, earlier);
        (self.memory.time, self.memory.last_step) = (t + h, h);
        self.exchange()?;
        let Memory { outputs, earlier, bonds, .. } = &mut self.memory;
        bonds.add(&Stepped {
            h,
            before: &self.before,
            after: outputs,
            inputs: earlier,
            derivatives: &self.derivatives,
        });
        Ok(None)
    }

    /// Derivatives from the last step; 0 before the first.
    fn extrapolate(&mut self) {
        let Memory { inputs, earlier, last_step, .. } = &self.memory;
        for (slot, derivative) in self.derivatives.iter_mut().enumerate() {
            let known = self.has_derivative[slot] && *last_step > 0.0;
            *derivative = if known { (inputs[slot] - earlier[slot]) / last_step } else { 0.0 };
        }
    }

    fn step_all(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        for batch in &mut self.derivative_sets {
            batch.set_derivatives(&mut self.instances, &self.derivatives)?;
        }
        if let Some(side_by_side) = &mut self.side_by_side {
            side_by_side.step(&mut self.instances, &self.component_steps, t, h);
        }
        for place in 0..self.component_steps.len() {
            let component = self.component_steps[place].component;
            let stepped = self.side_by_side.as_mut().and_then(|all| all.take(component));
            if stepped.unwrap_or_else(|| self.advance(place, t, h))? == Step::Terminated {
                return Ok(Some(component));
            }
        }
        Ok(None)
    }

    /// The step of the component at this place of the order, or its shorter steps, in which inputs go on along their derivatives.
    fn advance(&mut self, place: usize, t: f64, h: f64) -> Result<Step, Error> {
        let (component, parts) =
            (self.component_steps[place].component, self.component_steps[place].parts(h));
        if parts == 1 {
            return self.instances[component].do_step(t, h);
        }
        let length = h / parts as f64;
        for part in 0..parts {
            let after = part as f64 * length;
            if part > 0 {
                let mut signals = self.memory.signals(&mut self.instances, &self.sources);
                for batch in self.derivative_sets.iter_mut().filter(|b| b.component == component) {
                    batch.set_line(&mut signals, &self.derivatives, after)?;
                }
            }
            if let Some(drive) = &mut self.drive {
                drive.set_component(&mut self.instances, component, t + after, length)?;
            }
            if self.instances[component].do_step(t + after, length)? == Step::Terminated {
                return Ok(Step::Terminated);
            }
        }
        Ok(Step::Done)
    }

    fn step_in_sequence(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        for place in 0..self.component_steps.len() {
            let component_step = &mut self.component_steps[place];
            let component = component_step.component;
            let mut signals = self.memory.signals(&mut self.instances, &self.sources);
            for &slot in &component_step.fresh {
                let (source, convert) = self.sources[slot];
                let end = convert.of(signals.outputs[source]);
                let inputs = &mut signals.inputs;
                if self.has_derivative[slot] {
                    self.derivatives[slot] = (end - inputs[slot]) / h;
                } else {
                    inputs[slot] = end;
                }
            }
            for batch in &mut component_step.sets {
                batch.set(&mut signals)?;
            }
            for batch in self.derivative_sets.iter_mut().filter(|b| b.component == component) {
                batch.set_derivatives(signals.instances, &self.derivatives)?;
            }
            if self.advance(place, t, h)? == Step::Terminated {
                return Ok(Some(component));
            }
            let mut signals = self.memory.signals(&mut self.instances, &self.sources);
            for batch in &mut self.component_steps[place].gets {
                batch.read(&mut signals)?;
            }
        }
        Ok(None)
    }

    /// Saves the state of the master and of all FMUs, for [`Self::roll_back`].
    pub(crate) fn save(&mut self) -> Result<(), Error> {
        match &mut self.saved {
            Some((memory, states)) => {
                memory.copy(&self.memory);
                for (instance, state) in self.instances.iter_mut().zip(states) {
                    instance.update_state(state)?;
                }
            }
            None => {
                let states = self.instances.iter_mut().map(Instance::get_state).collect::<Result<_, _>>()?;
                self.saved = Some((self.memory.clone(), states));
            }
        }
        Ok(())
    }

    /// Returns to the saved state.
    pub(crate) fn roll_back(&mut self) -> Result<(), Error> {
        let Some((memory, states)) = &self.saved else { return Ok(()) };
        self.memory.copy(memory);
        for (instance, state) in self.instances.iter_mut().zip(states) {
            instance.set_state(state)?;
        }
        // FMUs differ in whether inputs belong to the state.
        let mut signals = self.memory.signals(&mut self.instances, &self.sources);
        for batch in &mut self.all_inputs {
            batch.set(&mut signals)?;
        }
        match &mut self.drive {
            Some(drive) => drive.set_values(&mut self.instances, self.memory.time),
            None => Ok(()),
        }
    }

    /// Ends the simulation of all components.
    pub(crate) fn terminate(&mut self) -> Result<(), Error> {
        self.instances.iter_mut().try_for_each(Instance::terminate)
    }
}
