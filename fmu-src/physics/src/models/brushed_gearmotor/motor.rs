//! The gearmotor as [`Equations`] of the runtime: steps, states and events.

use super::equations::{Constants, STATES, State, Step, Stored};
use super::nodes::{HOUSING, LIST, Losses, NODES, WINDING};
use super::parameters::{Parameters, unserved};
use super::variables::{Indicators, Inputs, Outputs};
use crate::components::validity::Extremes;
use crate::effects::IMMINENT;
use crate::exchange::is_above;
use crate::model::{Declaration, Declared, Fault};
use crate::runtime::{Equations, Halt, NoVariables, Runtime};
use crate::saved;
use crate::solver::no_solution;
use crate::solver::split::Split;
use crate::terms::Drivers;
use declare::{Named, State as Declare, index_of};

/// Indices of the states: current and speed, angle, temperatures, energies.
const ANGLE: usize = index_of(LIST, "state.shaft_angle");
const FIRST_NODE: usize = index_of(LIST, "state.winding_temperature");
const FIRST_ENERGY: usize = index_of(LIST, "state.energy_supply");
const _: () = assert!(FIRST_ENERGY == FIRST_NODE + NODES);

/// The rows of the outputs by name.
type Output = <Outputs as Named>::Row;

/// The gearmotor.
pub type BrushedGearmotor = Runtime<Gearmotor, STATES>;

/// State between communication points.
#[derive(Clone, Debug)]
pub struct Gearmotor {
    constants: Constants,
    state: State,
    /// Initial ambient temperature, K; reference of the stored heat.
    t_start: f64,
    stored_at_start: Stored,
    split: Split<NODES>,
}

saved!(Gearmotor { t_start, stored_at_start, state, split });

/// Discrete states in Model Exchange.
#[derive(Clone, Copy, Debug, Default)]
pub struct Discrete {
    /// Sign of the duty at the last event.
    direction: f64,
    /// Whether the winding was above its limit at the last event.
    over_temperature: bool,
}

saved!(Discrete { direction, over_temperature });

impl BrushedGearmotor {
    /// The state at the present time: current, A, speed, rad/s, angle, rad, temperatures, K, energies, J.
    pub fn state(&self) -> &State {
        &self.own.state
    }

    /// The equations over the next step, with linear inputs.
    pub fn step_equations(&self) -> Step<'_> {
        let step = self.equations(self.time);
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

    fn equations(&self, time: f64) -> Step<'_> {
        Step::new(&self.parameters, &self.own.constants, &self.inputs, &self.slopes, time)
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

impl Equations<STATES> for Gearmotor {
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
            split: Split::default(),
        }
    }

    fn start(run: &mut BrushedGearmotor) -> Result<(), Fault> {
        let parameters = &run.parameters;
        if let Some(fault) = parameters.initial.fault(&parameters.limits()) {
            return Err(Fault(fault));
        }
        let drift = parameters.effects.ambient_sensor() * run.time;
        let t_start = run.inputs.ambient_temperature + drift;
        let state = parameters.initial.state(t_start);
        run.own = Gearmotor { state, t_start, ..Gearmotor::new(parameters) };
        run.own.stored_at_start = run.stored();
        Ok(())
    }

    fn advance(run: &mut BrushedGearmotor, time: f64, h: f64) -> Result<(), Halt> {
        let Runtime { parameters, inputs, slopes, own, .. } = &mut *run;
        let Gearmotor { constants, state, split, .. } = own;
        let before = *state;
        let step = Step::new(parameters, constants, inputs, slopes, time);
        if let Err(failure) = split.advance(&step, state, h) {
            *state = before;
            let now = [before.x[0], before.x[1], before.temperature[WINDING]];
            return Err(no_solution("gearmotor", time, &failure, now).into());
        }
        if run.own.constants.limits().are_passed(&run.extremes()) {
            run.own.state = before;
            return Err(Halt::Limit);
        }
        run.arrive(time + h, h);
        Ok(())
    }

    fn point(_: &BrushedGearmotor) {}

    fn outputs(run: &BrushedGearmotor, (): &()) -> Outputs {
        let own = &run.own;
        let mut outputs = run.step_equations().outputs(&own.state, own.t_start, &own.stored_at_start);
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
                let node = Outputs::node(output)?;
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
        run.own.constants = Constants::of(&run.parameters);
        run.own.stored_at_start = run.own.stored_at_start + run.stored() - before;
        taken
    }

    fn state(run: &BrushedGearmotor, k: usize) -> f64 {
        let state = &run.own.state;
        match k {
            0 | 1 => state.x[k],
            ANGLE => state.angle,
            FIRST_NODE..FIRST_ENERGY => state.temperature[k - FIRST_NODE],
            _ => state.energy[k - FIRST_ENERGY],
        }
    }

    fn put_state(run: &mut BrushedGearmotor, k: usize, value: f64) {
        let state = &mut run.own.state;
        match k {
            0 | 1 => state.x[k] = value,
            ANGLE => state.angle = value,
            FIRST_NODE..FIRST_ENERGY => state.temperature[k - FIRST_NODE] = value,
            _ => state.energy[k - FIRST_ENERGY] = value,
        }
    }

    fn is_coupled(k: usize) -> bool {
        k != ANGLE && k < FIRST_ENERGY
    }

    fn rates(run: &BrushedGearmotor, (): &()) -> Result<[f64; STATES], Fault> {
        let all = std::array::from_fn(|k| Self::state(run, k));
        Ok(run.step_equations().rates(0.0, &all))
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

    fn discrete(run: &BrushedGearmotor, _: &Discrete) -> Discrete {
        let duty = run.inputs.duty;
        let warming = || Self::rates(run, &()).map_or(f64::NAN, |rates| rates[FIRST_NODE + WINDING]);
        Discrete {
            direction: if duty == 0.0 { 0.0 } else { duty.signum() },
            over_temperature: is_above(Self::indicators(run, &()).over_temperature, warming),
        }
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
        run.own.constants = Constants::of(&run.parameters);
        Some(())
    }

    fn ease(run: &mut BrushedGearmotor, factor: f64) {
        run.own.split.ease(factor);
    }

    fn scale_tolerances(run: &mut BrushedGearmotor, factor: f64) {
        run.own.split.scale_tolerances(factor);
    }

    fn rejected_steps(run: &BrushedGearmotor) -> u64 {
        run.own.split.rejected
    }

    fn drivers(run: &BrushedGearmotor) -> Drivers {
        let (x, temperature) = (&run.own.state.x, &run.own.state.temperature);
        Drivers {
            speed: x[1],
            current: x[0],
            load_torque: run.inputs.load_torque,
            winding_temperature: temperature[WINDING],
            housing_temperature: temperature[HOUSING],
            ambient_temperature: run.inputs.ambient_temperature,
            time: run.time,
            ..Drivers::default()
        }
    }
}
