//! The gearmotor as a model: parameters, inputs, and the state it has reached.

use super::equations::{Constants, State, Step};
use super::held::Held;
use super::opening::Opening;
use super::parameters::{Parameters, unserved};
use super::states::{LIST, NODES};
use super::variables::{Indicators, Inputs, Outputs};
use crate::components::validity::Extremes;
use crate::effects::IMMINENT;
use crate::ending::{Halt, approach};
use crate::groups;
use crate::model::{Declaration, Declared, Fault, Model, ModelType, Slot};
use crate::solver::split::Split;
use crate::terms::Drivers;
use declare::Group;

/// The gearmotor: parameters, inputs, and the state it has reached.
#[derive(Clone, Debug)]
pub struct BrushedGearmotor {
    /// What the importer sets.
    pub inputs: Inputs,
    pub(super) outputs: Outputs,
    pub(super) indicators: Indicators,
    /// What the gearmotor is made of.
    pub parameters: Parameters,
    pub(super) constants: Constants,
    pub(super) slopes: Inputs,
    pub(super) time: f64,
    pub(super) state: State,
    /// The temperature at the start, K; stored heat counts from it.
    pub(super) t_start: f64,
    pub(super) opening: Opening,
    pub(super) split: Split<NODES>,
    /// What is held between events, where the caller integrates.
    pub(super) held: Option<Held>,
    /// Whether the last step ended at a limit of validity.
    pub(super) ended: bool,
    pub(super) outputs_are_stale: bool,
}

groups! {
    BrushedGearmotor {
        "" @ 0 => inputs: Inputs,
        "" @ 0 => outputs: Outputs,
        "event." @ 0 => indicators: Indicators,
    } then parameters: Parameters
}

/// Index of the inputs in the list of groups.
const INPUTS: usize = 0;
/// Index of the outputs in the list of groups.
const OUTPUTS: usize = 1;
/// Index of the event indicators in the list of groups; parameters follow.
const INDICATORS: usize = 2;

impl Default for BrushedGearmotor {
    fn default() -> Self {
        let parameters = Parameters::default();
        BrushedGearmotor {
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            indicators: Indicators::default(),
            parameters,
            constants: Constants::of(&parameters),
            slopes: Inputs::ZERO,
            time: 0.0,
            state: State::default(),
            t_start: 0.0,
            opening: Opening::default(),
            split: Split::default(),
            held: None,
            ended: false,
            outputs_are_stale: true,
        }
    }
}

impl BrushedGearmotor {
    /// The model in the list of models.
    pub const TYPE: ModelType = ModelType { declaration: Self::declared, new: || Box::new(Self::default()) };

    fn declared() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            Declaration::new(
                "BrushedGearmotor",
                "Brushed gearmotor behind a chopping H-bridge, in an insulated box: electrical, magnetic and \
                 mechanical voltage, power and work, and temperatures",
                Self::groups(),
                LIST,
                &unserved(),
            )
        })
    }

    /// The state at the present time: current, A, speed, rad/s, angle, rad, temperatures, K, energies, J.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The equations over the next step, with the inputs on their slopes.
    pub fn step_equations(&self) -> Step<'_> {
        let step = Step::new(&self.parameters, &self.constants, &self.inputs, &self.slopes, self.time);
        match &self.held {
            Some(held) => held.applied(step, self.inputs.duty),
            None => step,
        }
    }

    fn refresh_outputs(&mut self) {
        if self.outputs_are_stale {
            self.outputs = self.step_equations().outputs(&self.state, self.t_start, &self.opening);
            if let Some(held) = &self.held {
                self.outputs.over_temperature = held.over_temperature;
            }
            self.outputs_are_stale = false;
        }
    }

    /// A step without an event in it.
    fn advance(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let before = self.state;
        let step = Step::new(&self.parameters, &self.constants, &self.inputs, &self.slopes, time);
        self.split.advance(&step, &mut self.state, h).map_err(|stuck| {
            Fault(format!(
                "The gearmotor's equations have no solution {} s after {} s even with steps of {} s \
                 (current {} A, speed {} rad/s, winding {} K).",
                stuck.t, time, stuck.h, self.state.x[0], self.state.x[1], self.state.temperature[0]
            ))
        })?;
        if self.constants.limits().are_passed(&self.extremes()) {
            self.state = before;
            return Err(Halt::Limit);
        }
        if self.slopes != Inputs::ZERO {
            self.inputs = self.inputs.after(h, &self.slopes);
            self.slopes = Inputs::ZERO;
        }
        self.time = time + h;
        self.outputs_are_stale = true;
        Ok(())
    }

    /// The temperatures that are limited.
    pub(super) fn extremes(&self) -> Extremes {
        let (winding, magnets) = (self.state.temperature[0], self.state.temperature[1]);
        Extremes { winding, magnets, lowest: winding.min(magnets) }
    }

    /// Why the run ends at `time`, s.
    pub(super) fn ending_sentence(&mut self, time: f64) -> String {
        self.outputs_are_stale = true;
        self.refresh_outputs();
        let shown = &self.outputs;
        let flows = [shown.loss_copper + shown.loss_friction, shown.heat_to_ambient - shown.loss_drive];
        self.constants.limits().sentence(&self.extremes(), time, flows)
    }

    /// A step, cut at the events within it.
    fn step_over_events(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let end = time + h;
        let event = self.next_event(time);
        if event >= end - IMMINENT {
            return self.advance(time, h);
        }
        // An event within the step: up to it and on from it, or nothing of both.
        let (before, slopes) = (self.clone(), self.slopes);
        let outcome = self.advance(time, event - time).and_then(|()| {
            self.slopes = slopes;
            if event == time + Step::turns(before.inputs.duty, slopes.duty) {
                // Exactly zero, so that rounding finds no second turn.
                self.inputs.duty = 0.0;
            }
            self.step_over_events(event, end - event)
        });
        match outcome {
            Ok(()) => self.time = end,
            Err(_) => *self = before,
        }
        outcome
    }

    /// The first event after `time`, s: a port of the effects jumps, or the duty changes its sign.
    pub(super) fn next_event(&self, time: f64) -> f64 {
        let turn = time + Step::turns(self.inputs.duty, self.slopes.duty);
        let port = self.parameters.effects.next_event(time);
        if turn > time + IMMINENT { port.min(turn) } else { port }
    }
}

impl Model for BrushedGearmotor {
    fn declaration(&self) -> &'static Declaration {
        Self::declared()
    }

    #[inline]
    fn get(&mut self, slot: Slot) -> f64 {
        match slot.group as usize {
            OUTPUTS => self.refresh_outputs(),
            INDICATORS => self.indicators = self.indicate(),
            _ if slot.group >= Slot::STATES => return self.inside(slot),
            _ => {}
        }
        self.value(slot.group as usize, slot.row as usize)
    }

    #[inline]
    fn set(&mut self, slot: Slot, value: f64) -> bool {
        let group = slot.group as usize;
        // A parameter that changes on the way changes what the stores hold; the books start anew from there.
        let before = (group > INDICATORS).then(|| self.step_equations().opening(&self.state, self.t_start));
        let taken = self.set_value(group, slot.row as usize, value);
        if let Some(before) = before {
            self.constants = Constants::of(&self.parameters);
            self.opening = self.opening + self.step_equations().opening(&self.state, self.t_start) - before;
        }
        self.outputs_are_stale = true;
        taken
    }

    fn set_slope(&mut self, slot: Slot, slope: f64) {
        debug_assert_eq!(slot.group as usize, INPUTS);
        self.slopes.set(slot.row as usize, slope);
        self.outputs_are_stale = true;
    }

    fn slope(&self, slot: Slot) -> f64 {
        self.slopes.get(slot.row as usize)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        if let Some(fault) = self.parameters.initial.fault(&self.parameters.limits()) {
            return Err(Fault(fault));
        }
        self.time = time;
        let drift = self.parameters.effects.ambient_sensor() * time;
        self.t_start = self.inputs.ambient_temperature + drift;
        self.split = Split::default();
        self.constants = Constants::of(&self.parameters);
        self.state = self.parameters.initial.state(self.t_start);
        self.opening = self.step_equations().opening(&self.state, self.t_start);
        self.outputs_are_stale = true;
        self.hold_start();
        Ok(())
    }

    fn step(&mut self, time: f64, h: f64) -> Result<(), Fault> {
        self.ended = false;
        let slopes = self.slopes;
        let Err(halt) = self.step_over_events(time, h) else { return Ok(()) };
        let at = approach(self, (time, h), halt, |motor, at, h| {
            motor.slopes = slopes;
            motor.step_over_events(at, h)
        })?;
        (self.ended, self.slopes) = (true, Inputs::ZERO);
        Err(Fault(self.ending_sentence(at)))
    }

    fn ended(&self) -> bool {
        self.ended
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn save(&self, out: &mut Vec<f64>) {
        groups::save(self, &Self::declared().groups, out);
        out.extend(self.slopes.values());
        out.extend([self.time, self.t_start, f64::from(u8::from(self.outputs_are_stale))]);
        out.extend([self.opening.stored, self.opening.magnetic, self.opening.kinetic]);
        out.extend(self.state.to_numbers());
        out.extend(self.split.to_numbers());
        out.extend(self.held.iter().flat_map(|held| held.to_numbers()));
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let mut copy = self.clone();
        let mut rest = saved.iter().copied();
        let mut next = || rest.next();
        let mut read = || -> Option<()> {
            groups::restore(&mut copy, &Self::declared().groups, &mut next)?;
            copy.slopes.take_values(&mut next)?;
            copy.time = next()?;
            copy.t_start = next()?;
            copy.outputs_are_stale = next()? != 0.0;
            copy.opening = Opening { stored: next()?, magnetic: next()?, kinetic: next()? };
            copy.state = State::from_numbers(&mut next)?;
            copy.split = Split::from_numbers(&mut next)?;
            copy.held = match next() {
                Some(since) => Some(Held::from_numbers([since, next()?, next()?])),
                None => None,
            };
            next().is_none().then_some(())
        };
        let complete = read().is_some();
        if complete {
            copy.constants = Constants::of(&copy.parameters);
            *self = copy;
        }
        complete
    }

    /// Current, speed and the temperatures.
    fn states(&self, out: &mut Vec<f64>) {
        out.extend(self.state.x.iter().chain(self.state.temperature.iter()));
    }

    fn set_states(&mut self, time: f64, states: &[f64]) -> bool {
        let fits = states.len() == 2 + NODES;
        if fits {
            self.state.x.copy_from_slice(&states[..2]);
            self.state.temperature.copy_from_slice(&states[2..]);
            self.time = time;
            self.outputs_are_stale = true;
        }
        fits
    }

    fn rates(&mut self, out: &mut Vec<f64>) {
        let point = self.step_equations().point(0.0, &self.state.x, &self.state.temperature);
        out.extend(point.fast.iter().chain(point.warming.iter()));
    }

    fn scale_tolerances(&mut self, factor: f64) {
        self.split.scale_tolerances(factor);
    }

    fn rejected_steps(&self) -> u64 {
        self.split.rejected
    }

    fn ease(&mut self, factor: f64) {
        self.split.ease(factor);
    }

    fn drivers(&self) -> Drivers {
        let (x, temperature) = (&self.state.x, &self.state.temperature);
        Drivers {
            speed: x[1],
            current: x[0],
            load_torque: self.inputs.load_torque,
            winding_temperature: temperature[0],
            housing_temperature: temperature[1],
            ambient_temperature: self.inputs.ambient_temperature,
            time: self.time,
            ..Drivers::default()
        }
    }

    crate::copies!();
}
