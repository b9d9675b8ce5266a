//! The gearmotor as [`Equations`] of the runtime: steps, states and events.

use super::equations::{ALL, Constants, State, Step, Stored};
use super::nodes::{HOUSING, LIST, Losses, NODES, WINDING};
use super::parameters::{Parameters, refusal, unserved};
use super::variables::{Indicators, Inputs, Outputs};
use crate::components::validity::Extremes;
use crate::effects::IMMINENT;
use crate::exchange::is_above;
use crate::model::{Declaration, Declared, Fault};
use crate::runtime::{Driven, Equations, Halt, NoVariables, Runtime, TermStates};
use crate::saved;
use crate::solver::no_solution;
use crate::solver::split::Split;
use crate::terms::{Drivers, GenericTerm};
use declare::{Named, State as Declare, index_of};

/// Indices of the states: current and speed, angle, temperatures, energies.
const ANGLE: usize = index_of(LIST, "state.shaft_angle");
const FIRST_NODE: usize = index_of(LIST, "state.winding_temperature");
const FIRST_ENERGY: usize = index_of(LIST, "state.energy_supply");
const FIRST_LAG: usize = index_of(LIST, "state.term_lag");
const _: () = assert!(FIRST_ENERGY == FIRST_NODE + NODES);

/// The rows of the outputs by name.
type Output = <Outputs as Named>::Row;

/// The gearmotor.
pub type BrushedGearmotor = Runtime<Gearmotor, ALL>;

/// State between communication points.
#[derive(Clone, Debug)]
pub struct Gearmotor {
    pub(super) constants: Constants,
    pub(super) state: State,
    /// Initial ambient temperature, K; reference of the stored heat.
    pub(super) t_start: f64,
    pub(super) stored_at_start: Stored,
    /// States of the terms.
    pub(super) terms: TermStates,
    split: Split<NODES>,
}

saved!(Gearmotor { t_start, stored_at_start, terms, state, split });

/// Discrete states in Model Exchange.
#[derive(Clone, Copy, Debug, Default)]
pub struct Discrete {
    /// Sign of the duty at the last event.
    direction: f64,
    /// Whether the winding was above its limit at the last event.
    over_temperature: bool,
    /// Factor on the heat capacities that the energy balance contains.
    booked: f64,
}

saved!(Discrete { direction, over_temperature, booked });

impl BrushedGearmotor {
    /// The state at the present time: current, A, speed, rad/s, angle, rad, temperatures, K, energies, J.
    pub fn state(&self) -> &State {
        &self.own.state
    }

    /// The equations over the next step, with linear inputs.
    pub fn step_equations(&self) -> Step<'_> {
        self.equations_of(&self.parameters, &self.own.constants)
    }

    /// The equations in the present state with other parameters, and what follows from them.
    pub(super) fn equations_of<'a>(
        &'a self,
        parameters: &'a Parameters,
        constants: &'a Constants,
    ) -> Step<'a> {
        let mut step = Step::new(parameters, constants, &self.inputs, &self.slopes, self.time);
        step.lags = self.own.terms.lags_after(self.time);
        match &self.pre {
            Some(pre) => {
                // A duty that has just left zero determines the direction by its sign.
                let (direction, duty) = (pre.discrete.direction, self.inputs.duty);
                let direction = if direction == 0.0 && duty != 0.0 { duty.signum() } else { direction };
                step.with_events(direction, pre.since)
            }
            None => step,
        }
    }

    /// A step without an event inside, with the drivers of terms already set.
    pub(super) fn take(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let Runtime { parameters, inputs, slopes, own, .. } = &mut *self;
        let Gearmotor { constants, state, split, terms, .. } = own;
        let before = *state;
        let mut step = Step::new(parameters, constants, inputs, slopes, time);
        step.lags = terms.lags_after(time);
        if let Err(failure) = split.advance(&step, state, h) {
            *state = before;
            let now = [before.x[0], before.x[1], before.temperature[WINDING]];
            return Err(no_solution("gearmotor", time, &failure, now).into());
        }
        if self.own.constants.limits().are_passed(&self.extremes()) {
            self.own.state = before;
            return Err(Halt::Limit);
        }
        self.arrive(time + h, h);
        Ok(())
    }

    /// Present stored energies, as a reference of the energy balance.
    fn stored(&self) -> Stored {
        self.step_equations().stored_energies(&self.own.state, self.own.t_start)
    }

    /// Temperatures with limits of validity.
    fn extremes(&self) -> Extremes {
        let (winding, magnets) = (self.own.state.temperature[WINDING], self.own.state.temperature[HOUSING]);
        Extremes { winding, magnets, lowest: winding.min(magnets) }
    }
}

impl Equations<ALL> for Gearmotor {
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Balance = NoVariables;
    type Indicators = Indicators;
    type Point = ();
    type Discrete = Discrete;
    const LIST: &'static [Declare] = LIST;
    const IS_LIMITED: bool = true;

    fn declaration() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            BrushedGearmotor::declare(
                "BrushedGearmotor",
                "Brushed gearmotor behind a chopping H-bridge, in an insulated box: electrical, magnetic and \
                 mechanical voltage, power and work, and temperatures",
                &unserved(),
            )
        })
    }

    fn new(parameters: &Parameters) -> Gearmotor {
        Gearmotor {
            constants: Constants::of(parameters),
            state: State::default(),
            t_start: 0.0,
            stored_at_start: Stored::zeros(),
            terms: TermStates::default(),
            split: Split::default(),
        }
    }

    fn start(run: &mut BrushedGearmotor) -> Result<(), Fault> {
        let parameters = &run.parameters;
        if let Some(fault) = parameters.initial.fault(&parameters.limits()) {
            return Err(Fault(fault));
        }
        let drift = parameters.effects.ambient_sensor() * run.time;
        let indicated = run.inputs.ambient_temperature + drift;
        let initial = |run: &BrushedGearmotor, ambient| run.parameters.initial.state(ambient);
        run.own = Gearmotor { state: initial(run, indicated), ..Gearmotor::new(&run.parameters) };
        Self::follow_parameters(run);
        // Terms may change the ambient temperature, and depend on the initial temperatures.
        run.set_drivers(run.time);
        let t_start = indicated + run.parameters.effects.ambient_offset();
        (run.own.state, run.own.t_start) = (initial(run, t_start), t_start);
        run.set_drivers(run.time);
        run.start_lags();
        run.own.stored_at_start = run.stored();
        Ok(())
    }

    fn advance(run: &mut BrushedGearmotor, time: f64, h: f64) -> Result<(), Halt> {
        run.advance_driven(time, h)
    }

    fn point(_: &BrushedGearmotor) {}

    fn outputs(run: &BrushedGearmotor, (): &()) -> Outputs {
        let own = &run.own;
        let mut outputs = run.observe(|step, gained| {
            let at_start = own.stored_at_start + Stored::new(gained, 0.0, 0.0);
            step.outputs(&own.state, own.t_start, &at_start)
        });
        if let Some(pre) = &run.pre {
            outputs.over_temperature = pre.discrete.over_temperature;
        }
        outputs
    }

    /// Outputs that need no evaluation of the equations: states and sensor values.
    #[inline]
    fn output(run: &BrushedGearmotor, row: usize) -> Option<f64> {
        let state = &run.own.state;
        let output = Outputs::row(row)?;
        match output {
            Output::current => Some(state.x[0]),
            Output::shaft_angle => Some(state.angle),
            Output::shaft_speed => Some(state.x[1]),
            _ => {
                let node = Outputs::node(output).filter(|_| !run.has_driven_effects())?;
                Some(run.own.constants.nodes(&run.parameters).indicated(node, &state.temperature))
            }
        }
    }

    fn balance(_: &BrushedGearmotor, (): &()) -> NoVariables {
        NoVariables
    }

    fn indicators(run: &BrushedGearmotor, (): &()) -> Indicators {
        Indicators {
            over_temperature: run.own.state.temperature[WINDING] - run.parameters.thermal.T_w_max,
            bridge_direction: run.inputs.duty,
            validity_limit: Self::excess(run),
        }
    }

    /// The energy balance excludes the change of stored energy by a tunable parameter.
    fn set_parameter(run: &mut BrushedGearmotor, set: impl FnOnce(&mut Parameters) -> bool) -> bool {
        let before = run.stored();
        let taken = set(&mut run.parameters);
        Self::follow_parameters(run);
        run.own.stored_at_start = run.own.stored_at_start + run.stored() - before;
        taken
    }

    fn refusal(term: &GenericTerm) -> Option<&'static str> {
        refusal(term)
    }

    fn set_terms(run: &mut BrushedGearmotor, terms: &[GenericTerm]) -> bool {
        let taken = run.parameters.effects.take_terms(terms);
        Self::follow_parameters(run);
        taken
    }

    fn state(run: &BrushedGearmotor, k: usize) -> f64 {
        let state = &run.own.state;
        match k {
            0 | 1 => state.x[k],
            ANGLE => state.angle,
            FIRST_NODE..FIRST_ENERGY => state.temperature[k - FIRST_NODE],
            FIRST_ENERGY..FIRST_LAG => state.energy[k - FIRST_ENERGY],
            _ => run.lag_state(k - FIRST_LAG),
        }
    }

    fn put_state(run: &mut BrushedGearmotor, k: usize, value: f64) {
        let state = &mut run.own.state;
        match k {
            0 | 1 => state.x[k] = value,
            ANGLE => state.angle = value,
            FIRST_NODE..FIRST_ENERGY => state.temperature[k - FIRST_NODE] = value,
            FIRST_ENERGY..FIRST_LAG => state.energy[k - FIRST_ENERGY] = value,
            _ => run.put_lag_state(k - FIRST_LAG, value),
        }
    }

    fn moves(run: &BrushedGearmotor, k: usize) -> bool {
        k < FIRST_LAG || run.has_lag(k - FIRST_LAG)
    }

    fn is_coupled(k: usize) -> bool {
        k != ANGLE && !(FIRST_ENERGY..FIRST_LAG).contains(&k)
    }

    fn rates(run: &BrushedGearmotor, (): &()) -> Result<[f64; ALL], Fault> {
        Ok(run.observe(|step, _| {
            let now = std::array::from_fn(|k| Self::state(run, k));
            let mut all = [0.0; ALL];
            all[..FIRST_LAG].copy_from_slice(&step.rates(0.0, &now));
            all[FIRST_LAG..].copy_from_slice(&run.lag_rates(|| step.heat_flows(&run.own.state)));
            all
        }))
    }

    fn next_event(run: &BrushedGearmotor, time: f64) -> f64 {
        run.parameters.effects.next_event(time)
    }

    /// Next time event of the effects or sign change of the duty.
    fn next_division(run: &BrushedGearmotor, time: f64) -> f64 {
        let turn = time + Step::turns(run.inputs.duty, run.slopes.duty);
        let port = Self::next_event(run, time);
        if turn > time + IMMINENT { port.min(turn) } else { port }
    }

    /// Sets the duty to exactly zero, so that rounding causes no second sign change.
    fn pass_event(run: &mut BrushedGearmotor, before: &BrushedGearmotor, time: f64, event: f64) {
        if event == time + Step::turns(before.inputs.duty, before.slopes.duty) {
            run.inputs.duty = 0.0;
        }
    }

    fn discrete_before(run: &BrushedGearmotor) -> Discrete {
        Discrete { booked: run.own.terms.capacity_factor, ..Discrete::default() }
    }

    fn discrete(run: &BrushedGearmotor, before: &Discrete) -> Discrete {
        let duty = run.inputs.duty;
        let warming = || Self::rates(run, &()).map_or(f64::NAN, |rates| rates[FIRST_NODE + WINDING]);
        Discrete {
            direction: if duty == 0.0 { 0.0 } else { duty.signum() },
            over_temperature: is_above(Self::indicators(run, &()).over_temperature, warming),
            booked: before.booked,
        }
    }

    /// The energy balance excludes the change of stored heat when a term changes the heat capacities.
    fn accept_step(run: &mut BrushedGearmotor) {
        run.book_capacity(|discrete| &mut discrete.booked);
    }

    fn excess(run: &BrushedGearmotor) -> f64 {
        run.own.constants.limits().excess(&run.extremes())
    }

    fn termination_reason(run: &BrushedGearmotor, time: f64) -> String {
        let outputs = Self::outputs(run, &());
        let Outputs { loss_copper: winding, loss_friction: friction, loss_drive: bridge, .. } = outputs;
        let (heat, rest) =
            run.own.constants.nodes(&run.parameters).heats(&Losses { winding, friction, bridge });
        let flows = [heat.sum(), outputs.heat_to_ambient - rest];
        run.own.constants.limits().sentence(&run.extremes(), time, flows)
    }

    fn passed_limit(run: &BrushedGearmotor) -> String {
        run.own.constants.limits().passed(&run.extremes())
    }

    fn restored(run: &mut BrushedGearmotor, _: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        Self::follow_parameters(run);
        Some(())
    }

    fn ease(run: &mut BrushedGearmotor, factors: [f64; 2]) {
        run.own.split.ease(factors);
    }

    fn scale_tolerances(run: &mut BrushedGearmotor, factor: f64) {
        run.own.split.scale_tolerances(factor);
    }

    fn rejected_steps(run: &BrushedGearmotor) -> u64 {
        run.own.split.rejected
    }

    fn drivers(run: &BrushedGearmotor) -> Drivers {
        run.observe(|step, _| run.drivers_with(step.heat_flows(&run.own.state)))
    }
}
