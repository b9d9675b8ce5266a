//! Drivers of the terms, temperature sensor of the housing, and initial state.

use super::equations::{Constants, NODES};
use super::motor::{AnnulusCooledMotor, Motor};
use super::network::Network;
use super::parameters::Parameters;
use super::variables::{DriveMode, Inputs, MechanicalMode};
use crate::components::initial::temperature;
use crate::components::sensor::{lagged, mean_lagged};
use crate::effects::{EffectPort, PerNode};
use crate::line::Line;
use crate::runtime::{Equations, Halt};
use crate::solver::split::{Fast, State};
use crate::terms::{Drivers, Lag, MOST_TERMS};
use declare::Group;

/// Start of a step, for the lag states.
pub(super) struct LagStart {
    /// Input of each lag.
    sources: [f64; MOST_TERMS],
    /// Inputs of the motor in the middle of the step.
    middle: Inputs,
    state: State<NODES>,
    /// Temperature of the housing, K.
    housing: f64,
}

impl AnnulusCooledMotor {
    /// Sets the drivers of the terms to their values at `time` and updates the heat capacities.
    #[inline]
    pub(super) fn set_drivers(&mut self, time: f64) {
        if self.parameters.effects.acts_at(EffectPort::Any) {
            self.pass_drivers(&self.drivers_after(time, 0.0));
        }
        self.follow_capacity();
    }

    /// Sets the drivers that a step holds and updates the heat capacities.
    pub(super) fn hold_drivers(&mut self, mean: &Drivers) {
        self.pass_drivers(mean);
        self.follow_capacity();
    }

    fn pass_drivers(&mut self, drivers: &Drivers) {
        if !self.parameters.effects.set_drivers(drivers) {
            return;
        }
        self.own.fan = (f64::NAN, PerNode::default());
        if let Some(network) = &mut self.own.network {
            network.forget();
        }
    }

    #[inline]
    pub(super) fn follow_capacity(&mut self) {
        if let Some(factor) = self.capacity_change(&self.parameters) {
            self.change_capacity(factor);
        }
    }

    /// Not inlined, because hardly any step changes the heat capacities.
    #[inline(never)]
    fn change_capacity(&mut self, factor: f64) {
        let before = self.own.constants;
        self.own.capacity_factor = factor;
        self.follow_parameters();
        self.own.stored_at_start -= self.heat_gain(&before);
    }

    /// The factor on the heat capacities with these parameters, if it has changed.
    #[inline]
    pub(super) fn capacity_change(&self, parameters: &Parameters) -> Option<f64> {
        let effects = &parameters.effects;
        let factor = if effects.acts_at(EffectPort::HeatCapacity) { effects.heat_capacity() } else { 1.0 };
        (factor != self.own.capacity_factor).then_some(factor)
    }

    /// Heat stored with other heat capacities minus that with the present ones, J; 0 in Model Exchange, where the stored energy is
    /// corrected only when the importer completes a step (`accept_step`).
    pub(super) fn heat_gain(&self, other: &Constants) -> f64 {
        let heat = |c: &Constants| c.heat(&self.own.state.temperature, self.own.t_start);
        if self.pre.is_none() { heat(other) - heat(&self.own.constants) } else { 0.0 }
    }

    /// The lag of each term, if it has one.
    fn lags_of_terms(&self) -> [Option<Lag>; MOST_TERMS] {
        std::array::from_fn(|k| self.parameters.effects.lag(k))
    }

    /// Whether a term follows a lag of a heat flow.
    fn lags_a_heat(&self) -> bool {
        self.lags_of_terms().iter().flatten().any(|lag| lag.driver.is_heat())
    }

    /// Drivers of the terms at the start, on average and at the end of a step of `h` seconds. Where they follow states, a trial step gives
    /// the others, so that constant drivers are of second order in the step, also if they follow a current that changes within milliseconds.
    pub(super) fn drivers_along(&mut self, time: f64, h: f64) -> Result<[Drivers; 3], Halt> {
        let from = self.drivers_after(time, 0.0);
        let mut to = self.drivers_after(time, h);
        let mut mean = from.middle(&to);
        let (lags, holds_states) = (self.lags_of_terms(), self.own.constants.holds_states);
        // First estimate of the lags of states: their drivers stay as they are.
        let present = if holds_states { self.lag_sources() } else { [0.0; MOST_TERMS] };
        for (k, lag) in lags.iter().enumerate() {
            let Some(Lag { driver, tau, .. }) = *lag else { continue };
            let source = match holds_states {
                true => [present[k]; 3],
                false => [&from, &mean, &to].map(|drivers| drivers.of(driver)),
            };
            to.lagged[k] = lagged(from.lagged[k], tau, source, h);
            mean.lagged[k] = mean_lagged([from.lagged[k], to.lagged[k]], tau, source, h);
        }
        if !holds_states {
            return Ok([from, mean, to]);
        }
        let before = self.checkpoint();
        let taken = self.take_along(time, h, &[from, mean, to]);
        to = self.drivers_after(time + h, 0.0);
        mean = Drivers { lagged: self.own.mean_lags, ..from.middle(&to) };
        if self.own.network.is_none() {
            let over_step = &self.own.state.integrals;
            mean.winding_temperature = over_step.temperature[0] / h;
            mean.housing_temperature = over_step.temperature[1] / h;
            // A current may reach its new value in a small part of the step.
            (mean.current, mean.speed) = (over_step.fast[0] / h, over_step.fast[1] / h);
        }
        self.return_to(before);
        taken?;
        Ok([from, mean, to])
    }

    /// Drivers of the terms with the present states and the inputs `h` seconds after `time`.
    pub(super) fn drivers_after(&self, time: f64, h: f64) -> Drivers {
        let inputs =
            if h > 0.0 && self.is_sloping() { self.inputs.after(h, &self.slopes) } else { self.inputs };
        self.drivers_at(time + h, &inputs, &self.own.state, self.housing_temperature())
    }

    /// Drivers of the terms with these inputs and states, and the housing at this temperature, K.
    fn drivers_at(&self, time: f64, inputs: &Inputs, state: &State<NODES>, housing: f64) -> Drivers {
        let (x, choices) = (&state.x, &self.parameters.choices);
        let imposed = choices.mechanical_mode == MechanicalMode::ImposedSpeed;
        let current = if choices.drive_mode == DriveMode::Current { inputs.current_command } else { x[0] };
        Drivers {
            speed: if imposed { inputs.imposed_speed } else { x[1] },
            current,
            load_torque: match choices.mechanical_mode {
                MechanicalMode::FreeShaft => inputs.load_torque,
                // Without the motor's drag, which may itself be the term that needs this driver.
                MechanicalMode::ImposedSpeed => self.parameters.motor.torque_constant(housing) * current,
            },
            winding_temperature: state.temperature[0],
            housing_temperature: housing,
            ambient_temperature: inputs.ambient_temperature + self.parameters.effects.ambient_sensor() * time,
            fan_command: inputs.fan_command,
            time,
            // Available only after the effects have their drivers; used only by lags ([`Self::lag_sources`]).
            copper_loss: 0.0,
            friction_loss: 0.0,
            lagged: self.own.term_lags,
        }
    }

    /// Present drivers of the terms, with these heat flows.
    pub(super) fn drivers_with(&self, [copper_loss, friction_loss]: [f64; 2]) -> Drivers {
        Drivers { copper_loss, friction_loss, ..self.drivers_after(self.time, 0.0) }
    }

    /// The lags from `time` on: lines within a step, constant between the steps.
    pub(super) fn lags_from(&self, time: f64) -> [Line; MOST_TERMS] {
        match &self.own.lag_lines {
            Some((lines, since)) => lines.map(|line| Line { start: line.at(time - since), ..line }),
            None => self.own.term_lags.map(|start| Line { start, slope: 0.0 }),
        }
    }

    /// Present input of each term's lag; 0 without a lag.
    pub(super) fn lag_sources(&self) -> [f64; MOST_TERMS] {
        self.lag_sources_with(|| self.equations().heat_flows(&self.own.state))
    }

    /// The same with the heat flows from elsewhere.
    pub(super) fn lag_sources_with(&self, heat_flows: impl FnOnce() -> [f64; 2]) -> [f64; MOST_TERMS] {
        self.sources_of(self.drivers_after(self.time, 0.0), heat_flows)
    }

    /// Input of each term's lag with these drivers; the heat flows are evaluated only for a lag that needs them.
    fn sources_of(&self, mut drivers: Drivers, heat_flows: impl FnOnce() -> [f64; 2]) -> [f64; MOST_TERMS] {
        if self.lags_a_heat() {
            [drivers.copper_loss, drivers.friction_loss] = heat_flows();
        }
        self.lags_of_terms().map(|lag| lag.map_or(0.0, |lag| drivers.of(lag.driver)))
    }

    /// Initialises each lag at the value of its driver and what `initial.term_lag_*` add to it.
    pub(super) fn start_lags(&mut self) {
        if !self.parameters.effects.has_lags() {
            return;
        }
        self.own.term_lags = [0.0; MOST_TERMS];
        self.set_drivers(self.time);
        // Two passes: heat flows may depend on the drivers.
        let above = self.parameters.initial.term_lags();
        for _ in 0..2 {
            let sources = self.lag_sources();
            self.own.term_lags = std::array::from_fn(|k| sources[k] + above[k] * self.lag_size(k));
            self.set_drivers(self.time);
        }
    }

    /// What the lag states need of the start of a step of `h` seconds.
    pub(super) fn lag_start(&self, h: f64) -> LagStart {
        let inputs = if self.is_sloping() { self.inputs.after(0.5 * h, &self.slopes) } else { self.inputs };
        LagStart {
            sources: self.lag_sources(),
            middle: inputs,
            state: self.own.state,
            housing: self.housing_temperature(),
        }
    }

    /// Advances the lag states over a step of `h` seconds that began there.
    pub(super) fn follow_lags(&mut self, start: &LagStart, h: f64) {
        let (middle, after) = (self.middle_sources(start, h), self.lag_sources());
        for (k, lag) in self.lags_of_terms().iter().enumerate() {
            if let Some(lag) = lag {
                let source = [start.sources[k], middle[k], after[k]];
                let before = self.own.term_lags[k];
                let reached = lagged(before, lag.tau, source, h);
                self.own.term_lags[k] = reached;
                self.own.mean_lags[k] = mean_lagged([before, reached], lag.tau, source, h);
            }
        }
    }

    /// Inputs of the lags in the middle of the step. With a network, temperatures are linear in time.
    fn middle_sources(&mut self, start: &LagStart, h: f64) -> [f64; MOST_TERMS] {
        let has_network = self.own.network.is_some();
        let mut state = self.own.state;
        state.x = match has_network {
            true => 0.5 * (start.state.x + state.x),
            false => middle_of(start.state.x, state.integrals.fast, state.x, h),
        };
        for n in 0..NODES {
            let from = start.state.temperature[n];
            state.temperature[n] =
                if has_network { 0.5 * (from + state.temperature[n]) } else { self.middle_of(n, from, h) };
        }
        let housing = match has_network {
            true => 0.5 * (start.housing + self.housing_temperature()),
            false => state.temperature[1],
        };
        let drivers = self.drivers_at(self.time - 0.5 * h, &start.middle, &state, housing);
        let middle = self.time - 0.5 * h;
        let heat_flows = self.lags_a_heat().then(|| self.heat_flows_with(middle, start.middle, state));
        self.sources_of(drivers, || heat_flows.unwrap_or_default())
    }

    /// Heat flows at another time with other inputs and another state of the two nodes.
    fn heat_flows_with(&mut self, time: f64, inputs: Inputs, state: State<NODES>) -> [f64; 2] {
        let time = std::mem::replace(&mut self.time, time);
        let inputs = std::mem::replace(&mut self.inputs, inputs);
        let state = std::mem::replace(&mut self.own.state, state);
        Motor::follow_inputs(self);
        let heat_flows = self.equations().heat_flows(&self.own.state);
        (self.time, self.inputs, self.own.state) = (time, inputs, state);
        heat_flows
    }

    /// Temperature of a node in the middle of the last `h` seconds, K, in which it was a parabola with the mean that the integrator found;
    /// `from` is that at the start.
    fn middle_of(&self, node: usize, from: f64, h: f64) -> f64 {
        let state = &self.own.state;
        middle_of(from, state.integrals.temperature[node], state.temperature[node], h)
    }

    /// True temperature of the housing, K.
    pub(super) fn housing_temperature(&self) -> f64 {
        self.own.network.as_deref().map_or(self.own.state.temperature[1], Network::housing_temperature)
    }

    /// Advances the sensors over the last integration step, of `h` seconds; `before` are the temperatures of their nodes at its start, K. With
    /// a network, that of the housing is linear in time.
    #[inline]
    pub(super) fn follow_sensors(&mut self, before: PerNode, h: f64) {
        let lag = self.parameters.effects.sensor_lag();
        if lag == PerNode::default() {
            self.own.sensors = self.sensed();
        } else {
            self.follow_lagging_sensors(lag, before, h);
        }
    }

    #[inline(never)]
    fn follow_lagging_sensors(&mut self, lag: PerNode, before: PerNode, h: f64) {
        let after = self.sensed();
        let middle = PerNode {
            winding: self.middle_of(0, before.winding, h),
            housing: match self.own.network.is_some() {
                true => 0.5 * (before.housing + after.housing),
                false => self.middle_of(1, before.housing, h),
            },
        };
        let shown = &mut self.own.sensors;
        shown.winding =
            lagged(shown.winding, lag.winding, [before.winding, middle.winding, after.winding], h);
        shown.housing =
            lagged(shown.housing, lag.housing, [before.housing, middle.housing, after.housing], h);
    }

    /// Sets the initial state; nodes without an initial value start at `ambient`, K.
    pub(super) fn put_initial(&mut self, ambient: f64) {
        let i = self.parameters.initial;
        let choices = &self.parameters.choices;
        let is_driven = matches!(choices.drive_mode, DriveMode::Voltage | DriveMode::Pwm);
        let is_free = choices.mechanical_mode == MechanicalMode::FreeShaft;
        let or_zero = |applies: bool, value: f64| if applies { value } else { 0.0 };
        self.own.state.x = Fast::new(or_zero(is_driven, i.current), or_zero(is_free, i.shaft_speed));
        self.own.state.angle = i.shaft_angle;
        let housing = temperature(i.housing_temperature, ambient);
        // With two nodes only, the second is the whole housing.
        let core =
            if self.own.network.is_some() { temperature(i.stator_temperature, ambient) } else { housing };
        self.own.state.temperature = [temperature(i.winding_temperature, ambient), core].into();
        if let Some(network) = &mut self.own.network {
            let [rotor, tube] = [i.magnet_temperature, i.tube_temperature].map(|t| temperature(t, ambient));
            network.put_temperatures(rotor, housing, tube);
        }
        let lag = self.parameters.effects.sensor_lag();
        let shown =
            |lags: bool, initial: f64, node: f64| if lags { temperature(initial, node) } else { node };
        let winding = self.own.state.temperature[0];
        self.own.sensors = PerNode {
            winding: shown(lag.winding > 0.0, i.winding_sensor_temperature, winding),
            housing: shown(lag.housing > 0.0, i.sensor_temperature, housing),
        };
        Motor::follow_inputs(self);
    }
}

/// Middle value of a parabola between two values with this integral over `h` seconds.
fn middle_of<T>(from: T, integral: T, to: T, h: f64) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Div<f64, Output = T> + std::ops::Sub<Output = T>,
{
    (integral * 6.0 / h - from - to) * 0.25
}
