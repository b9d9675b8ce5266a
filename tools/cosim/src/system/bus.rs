//! The running system: instances, the values on all connections, and one macro step.
use super::batch::Batch;
use super::energy::{Books, Stepped};
use super::order::Order;
use super::units::Affine;
use super::wiring::{Parts, Wiring};
use crate::simulate::set_structural;
use crate::{Causality, Error, FmiVersion, Instance, Kind, Log, State, Step, Value, Variability, Variable};

/// How components see each other during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Algorithm {
    /// All step at once, each with what the others showed at the beginning. What passes through a component arrives in
    /// the same communication point.
    #[default]
    Jacobi,
    /// One after the other; who comes later sees the ends of the steps of those before.
    GaussSeidel,
    /// As Jacobi, but all outputs are read once after the step: what passes through a component arrives a step later.
    /// Many masters do so.
    JacobiDelayed,
}

/// One round of a sweep: read, then set.
#[derive(Debug, Default)]
struct Round {
    gets: Vec<Batch>,
    sets: Vec<Batch>,
}

/// What the master itself remembers, beside the states of the FMUs.
#[derive(Clone, Debug)]
struct Memory {
    /// Connected outputs now.
    outputs: Vec<f64>,
    /// Fed inputs now, in the units of the inputs.
    inputs: Vec<f64>,
    /// Inputs one step ago, and the length of that step; 0 before the first.
    earlier: Vec<f64>,
    last_step: f64,
    books: Books,
}

impl Memory {
    /// As `clone_from`, without allocation.
    fn copy(&mut self, other: &Self) {
        self.outputs.copy_from_slice(&other.outputs);
        self.inputs.copy_from_slice(&other.inputs);
        self.earlier.copy_from_slice(&other.earlier);
        self.last_step = other.last_step;
        for (own, bond) in self.books.bonds.iter_mut().zip(&other.books.bonds) {
            (own.energy, own.throughput) = (bond.energy, bond.throughput);
            (own.error, own.gross_error) = (bond.error, bond.gross_error);
        }
    }
}

/// How a system is to be run.
pub(crate) struct Plan {
    pub(crate) algorithm: Algorithm,
    /// Inputs get slopes where the FMU takes them.
    pub(crate) slopes: bool,
    pub(crate) start: f64,
    pub(crate) stop: f64,
    /// Told to the FMUs; each FMU's own proposal when absent.
    pub(crate) tolerance: Option<f64>,
    pub(crate) log: Log,
}

/// A system that runs.
pub(crate) struct Bus {
    pub(crate) instances: Vec<Instance>,
    memory: Memory,
    saved: Option<(Memory, Vec<State>)>,
    rounds: Vec<Round>,
    /// All sets in one list, to give inputs again.
    again: Vec<Batch>,
    /// Inputs that take slopes, by component.
    ramps: Vec<Batch>,
    /// For each input its source and conversion.
    sources: Vec<(usize, Affine)>,
    /// Whether an input gets slopes.
    smooth: Vec<bool>,
    slopes: Vec<f64>,
    before: Vec<f64>,
    algorithm: Algorithm,
    /// The order of steps, and for Gauss and Seidel what each component needs before and shows after its step.
    turns: Vec<Turn>,
}

#[derive(Debug)]
struct Turn {
    component: usize,
    /// Inputs from components that have had their turn.
    fresh: Vec<usize>,
    /// The same inputs as far as they hold their values, to be set.
    sets: Vec<Batch>,
    gets: Vec<Batch>,
}

/// A sweep over the connections is repeated until nothing changes, this often at most.
const MAX_SWEEPS: usize = 100;

impl Bus {
    /// Instantiates and initialises all components; connected inputs and outputs agree afterwards.
    pub(crate) fn start(parts: Parts, wiring: &Wiring, order: &Order, plan: &Plan) -> Result<Self, Error> {
        let mut instances = Vec::new();
        for (index, component) in parts.structure.components.iter().enumerate() {
            instances.push(Instance::instantiate(&parts.archives[index], &component.name, plan.log.clone())?);
        }
        let mut bus = Self::wire(parts, wiring, order, plan, instances);
        for (index, sets) in wiring.sets.iter().enumerate() {
            let variables = &parts.description(index).variables;
            let sets: Vec<(&Variable, Value)> =
                sets.iter().map(|(v, value)| (&variables[*v], value.clone())).collect();
            let instance = &mut bus.instances[index];
            set_structural(instance, &sets)?;
            for (variable, value) in sets.iter().filter(|(v, _)| v.causality == Causality::Parameter) {
                instance.set_value(variable, value)?;
            }
            let own = parts.description(index).default_experiment.tolerance;
            instance.enter_initialization(plan.start, Some(plan.stop), plan.tolerance.or(own))?;
            for (variable, value) in sets.iter().filter(|(v, _)| v.causality == Causality::Input) {
                instance.set_value(variable, value)?;
            }
        }
        bus.agree(parts, wiring)?;
        for instance in &mut bus.instances {
            instance.exit_initialization()?;
        }
        // Some outputs show their values only now.
        bus.sweep()?;
        bus.memory.earlier.copy_from_slice(&bus.memory.inputs);
        Ok(bus)
    }

    fn wire(parts: Parts, wiring: &Wiring, order: &Order, plan: &Plan, instances: Vec<Instance>) -> Self {
        let algorithm = plan.algorithm;
        let delayed = algorithm == Algorithm::JacobiDelayed;
        let count = if delayed { order.rounds.min(1) } else { order.rounds };
        let mut rounds: Vec<Round> = (0..count).map(|_| Round::default()).collect();
        for (slot, port) in wiring.outputs.iter().enumerate() {
            let round = if delayed { 0 } else { order.read[slot] };
            Batch::add(&mut rounds[round].gets, port.component, parts.variable(*port), slot);
        }
        let (mut again, mut ramps) = (Vec::new(), Vec::new());
        let mut smooth = vec![false; wiring.feeds.len()];
        for (slot, feed) in wiring.feeds.iter().enumerate() {
            let (component, variable) = (feed.port.component, parts.variable(feed.port));
            let round = if delayed { 0 } else { order.set[slot] };
            Batch::add(&mut rounds[round].sets, component, variable, slot);
            Batch::add(&mut again, component, variable, slot);
            let description = parts.description(component);
            smooth[slot] = plan.slopes
                && description.fmi_version == FmiVersion::V2
                && description.co_simulation.as_ref().is_some_and(|c| c.can_interpolate_inputs)
                && variable.kind == Kind::Float64
                && variable.variability == Variability::Continuous
                && parts.variable(wiring.outputs[feed.source]).variability == Variability::Continuous;
            if smooth[slot] {
                Batch::add(&mut ramps, component, variable, slot);
            }
        }
        let sources: Vec<(usize, Affine)> = wiring.feeds.iter().map(|f| (f.source, f.convert)).collect();
        let turns = turns(parts, wiring, order, algorithm, &smooth);
        let (outputs, inputs) = (wiring.outputs.len(), wiring.feeds.len());
        Self {
            instances,
            memory: Memory {
                outputs: vec![0.0; outputs],
                inputs: vec![f64::NAN; inputs],
                earlier: vec![0.0; inputs],
                last_step: 0.0,
                books: Books::new(parts, wiring),
            },
            saved: None,
            rounds,
            again,
            ramps,
            sources,
            smooth,
            slopes: vec![0.0; inputs],
            before: vec![0.0; outputs],
            algorithm,
            turns,
        }
    }

    /// The connected outputs.
    pub(crate) fn outputs(&self) -> &[f64] {
        &self.memory.outputs
    }

    /// Whether any input gets slopes.
    pub(crate) fn has_slopes(&self) -> bool {
        self.smooth.contains(&true)
    }

    /// The energy books.
    pub(crate) fn books(&self) -> &Books {
        &self.memory.books
    }

    /// Reads and sets everything that is connected, in the order in which values pass through.
    fn sweep(&mut self) -> Result<(), Error> {
        let Memory { outputs, inputs, .. } = &mut self.memory;
        for round in &mut self.rounds {
            for batch in &mut round.gets {
                batch.read(&mut self.instances, outputs)?;
            }
            for batch in &mut round.sets {
                batch.pass(&mut self.instances, &self.sources, outputs, inputs)?;
            }
        }
        Ok(())
    }

    /// Sweeps until the inputs stand still: initial values may depend on more than the declared dependencies say.
    fn agree(&mut self, parts: Parts, wiring: &Wiring) -> Result<(), Error> {
        for _ in 0..MAX_SWEEPS {
            self.before_inputs();
            self.sweep()?;
            if self.moving().is_none() {
                return Ok(());
            }
        }
        let Some(input) = self.moving() else { return Ok(()) };
        let feed = &wiring.feeds[input];
        let connection = &parts.structure.connections[feed.connection];
        Err(connection.place.fault(format!(
            "{connection}: no consistent initial values, {} still changes after {MAX_SWEEPS} rounds",
            parts.name(feed.port)
        )))
    }

    fn before_inputs(&mut self) {
        self.memory.earlier.copy_from_slice(&self.memory.inputs);
    }

    /// An input that differs from the sweep before, beyond rounding.
    fn moving(&self) -> Option<usize> {
        let moved = |(now, then): (&f64, &f64)| {
            let still = (now - then).abs() <= 1e-14 * now.abs().max(then.abs());
            !(still || now.to_bits() == then.to_bits())
        };
        self.memory.inputs.iter().zip(&self.memory.earlier).position(moved)
    }

    /// One macro step. `Some(component)` if a component asks for the end.
    pub(crate) fn step(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        self.before.copy_from_slice(&self.memory.outputs);
        self.extrapolate();
        let ended = match self.algorithm {
            Algorithm::GaussSeidel => self.in_turns(t, h)?,
            Algorithm::Jacobi | Algorithm::JacobiDelayed => self.at_once(t, h)?,
        };
        if ended.is_some() {
            return Ok(ended);
        }
        // The inputs as given go to the books before the sweep renews them.
        let Memory { inputs, earlier, .. } = &mut self.memory;
        std::mem::swap(inputs, earlier);
        self.memory.last_step = h;
        self.sweep()?;
        let Memory { outputs, earlier, books, .. } = &mut self.memory;
        books.add(&Stepped {
            h,
            before: &self.before,
            after: outputs,
            inputs: earlier,
            slopes: &self.slopes,
        });
        Ok(None)
    }

    /// Slopes from the last step; none before the first.
    fn extrapolate(&mut self) {
        let Memory { inputs, earlier, last_step, .. } = &self.memory;
        for (slot, slope) in self.slopes.iter_mut().enumerate() {
            let known = self.smooth[slot] && *last_step > 0.0;
            *slope = if known { (inputs[slot] - earlier[slot]) / last_step } else { 0.0 };
        }
    }

    fn at_once(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        for batch in &mut self.ramps {
            batch.give_slopes(&mut self.instances, &self.slopes)?;
        }
        for turn in &self.turns {
            if self.instances[turn.component].do_step(t, h)? == Step::Terminated {
                return Ok(Some(turn.component));
            }
        }
        Ok(None)
    }

    fn in_turns(&mut self, t: f64, h: f64) -> Result<Option<usize>, Error> {
        for turn in &mut self.turns {
            let Memory { outputs, inputs, .. } = &mut self.memory;
            for &slot in &turn.fresh {
                let (source, convert) = self.sources[slot];
                let end = convert.of(outputs[source]);
                if self.smooth[slot] {
                    self.slopes[slot] = (end - inputs[slot]) / h;
                } else {
                    inputs[slot] = end;
                }
            }
            for batch in &mut turn.sets {
                batch.give(&mut self.instances, inputs)?;
            }
            for batch in self.ramps.iter_mut().filter(|b| b.component == turn.component) {
                batch.give_slopes(&mut self.instances, &self.slopes)?;
            }
            if self.instances[turn.component].do_step(t, h)? == Step::Terminated {
                return Ok(Some(turn.component));
            }
            for batch in &mut turn.gets {
                batch.read(&mut self.instances, outputs)?;
            }
        }
        Ok(None)
    }

    /// Remembers everything, for [`Self::back`].
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

    /// Goes back to what was saved.
    pub(crate) fn back(&mut self) -> Result<(), Error> {
        let Some((memory, states)) = &self.saved else { return Ok(()) };
        self.memory.copy(memory);
        for (instance, state) in self.instances.iter_mut().zip(states) {
            instance.set_state(state)?;
        }
        // Whether inputs belong to the state is seen differently.
        for batch in &mut self.again {
            batch.give(&mut self.instances, &self.memory.inputs)?;
        }
        Ok(())
    }

    /// Ends the simulation of all components.
    pub(crate) fn terminate(&mut self) -> Result<(), Error> {
        self.instances.iter_mut().try_for_each(Instance::terminate)
    }
}

/// Who steps when, and what is exchanged in between.
fn turns(parts: Parts, wiring: &Wiring, order: &Order, algorithm: Algorithm, smooth: &[bool]) -> Vec<Turn> {
    let in_file: Vec<usize> = (0..parts.structure.components.len()).collect();
    let sequence = if algorithm == Algorithm::GaussSeidel { &order.components } else { &in_file };
    let mut turns: Vec<Turn> = Vec::new();
    for &component in sequence {
        let mut turn = Turn { component, fresh: Vec::new(), sets: Vec::new(), gets: Vec::new() };
        for (slot, feed) in wiring.feeds.iter().enumerate().filter(|(_, f)| f.port.component == component) {
            let source = wiring.outputs[feed.source].component;
            if turns.iter().any(|t| t.component == source) {
                turn.fresh.push(slot);
                if !smooth[slot] {
                    Batch::add(&mut turn.sets, component, parts.variable(feed.port), slot);
                }
            }
        }
        for (slot, port) in wiring.outputs.iter().enumerate().filter(|(_, p)| p.component == component) {
            Batch::add(&mut turn.gets, component, parts.variable(*port), slot);
        }
        turns.push(turn);
    }
    turns
}
