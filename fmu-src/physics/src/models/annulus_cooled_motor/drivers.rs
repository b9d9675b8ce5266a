//! Drivers of the terms, changed parameters, temperature sensor of the housing, and initial state.

use super::equations::{Constants, NODES};
use super::motor::{AnnulusCooledMotor, Motor};
use super::network::{Body, Network};
use super::parameters::Parameters;
use super::state_list::ALL;
use super::stepping::Checkpoint;
use super::variables::{DriveMode, Inputs, MechanicalMode};
use crate::components::initial::temperature;
use crate::components::sensor::lagged;
use crate::effects::{Effects, PerNode};
use crate::runtime::{Driven, Equations, Halt, TermStates};
use crate::solver::split::{Fast, State, middle_of};
use crate::terms::{Drivers, LagStarts};

impl Driven<ALL> for Motor {
    /// With the temperature of the housing, K.
    type Instant = (State<NODES>, f64);
    type Checkpoint = Checkpoint;

    #[inline(always)]
    fn effects(parameters: &Parameters) -> &Effects {
        &parameters.effects
    }

    fn lag_starts(parameters: &Parameters) -> &LagStarts {
        &parameters.lag_starts
    }

    fn terms(&self) -> &TermStates {
        &self.terms
    }

    fn terms_mut(&mut self) -> &mut TermStates {
        &mut self.terms
    }

    fn stored_at_start(&mut self) -> &mut f64 {
        &mut self.stored_at_start
    }

    fn instant(run: &AnnulusCooledMotor) -> (State<NODES>, f64) {
        (run.own.state, run.housing_temperature())
    }

    fn put_instant(run: &mut AnnulusCooledMotor, (state, _): (State<NODES>, f64)) {
        run.own.state = state;
    }

    /// With a network, temperatures are linear in time.
    fn middle(
        run: &AnnulusCooledMotor,
        (from, housing): &(State<NODES>, f64),
        h: f64,
    ) -> (State<NODES>, f64) {
        let state = run.own.state;
        if run.own.network.is_none() {
            let middle = state.middle(from, h);
            return (middle, middle.temperature[1]);
        }
        let (x, temperature) = (0.5 * (from.x + state.x), 0.5 * (from.temperature + state.temperature));
        (State { x, temperature, ..state }, 0.5 * (housing + run.housing_temperature()))
    }

    fn drivers_of(
        run: &AnnulusCooledMotor,
        time: f64,
        inputs: &Inputs,
        (state, housing): &(State<NODES>, f64),
    ) -> Drivers {
        let (x, choices) = (&state.x, &run.parameters.choices);
        let imposed = choices.mechanical_mode == MechanicalMode::ImposedSpeed;
        let current = if choices.drive_mode == DriveMode::Current { inputs.current_command } else { x[0] };
        Drivers {
            speed: if imposed { inputs.imposed_speed } else { x[1] },
            current,
            load_torque: match choices.mechanical_mode {
                MechanicalMode::FreeShaft => inputs.load_torque,
                // Without the motor's drag, which may itself be the term that needs this driver.
                MechanicalMode::ImposedSpeed => run.parameters.motor.torque_constant(*housing) * current,
            },
            winding_temperature: state.temperature[0],
            housing_temperature: *housing,
            ambient_temperature: inputs.ambient_temperature + run.parameters.effects.ambient_sensor() * time,
            fan_command: inputs.fan_command,
            time,
            ..Drivers::default()
        }
    }

    fn integrals(run: &AnnulusCooledMotor) -> Option<[f64; 4]> {
        run.own.network.is_none().then(|| run.own.state.integrals.of_drivers())
    }

    fn heat_flows(run: &AnnulusCooledMotor) -> [f64; 2] {
        run.equations().heat_flows(&run.own.state)
    }

    fn hold(run: &mut AnnulusCooledMotor, drivers: &Drivers) {
        if !run.parameters.effects.set_drivers(drivers) {
            return;
        }
        run.own.fan = (f64::NAN, PerNode::default());
        if let Some(network) = &mut run.own.network {
            network.forget();
        }
    }

    fn follow_parameters(run: &mut AnnulusCooledMotor) {
        let Parameters { choices, effects, .. } = &run.parameters;
        let is_speed_free = choices.mechanical_mode == MechanicalMode::FreeShaft;
        run.own.terms.holds_states =
            effects.holds_states(choices.drive_mode != DriveMode::Current, is_speed_free);
        run.own.constants = Constants::of(&run.parameters).with_capacity(run.own.terms.capacity_factor);
        run.own.fan = (f64::NAN, PerNode::default());
        run.own.fault = Body::fault(&run.parameters);
        let body = Body::of(&run.parameters);
        run.own.network = match (run.own.network.take(), body) {
            (Some(mut network), Some(body)) if network.body.segments == body.segments => {
                network.follow(&run.parameters, body);
                Some(network)
            }
            // A new network starts at the temperature of the node that it replaces.
            (_, Some(body)) => {
                Some(Box::new(Network::new(&run.parameters, body, run.own.state.temperature[1])))
            }
            (_, None) => None,
        };
    }

    fn heat(run: &AnnulusCooledMotor, capacity_factor: f64) -> f64 {
        let capacity = Constants::of(&run.parameters).capacity.scaled(capacity_factor);
        capacity.heat(&run.own.state.temperature, run.own.t_start)
    }

    #[inline]
    fn take(run: &mut AnnulusCooledMotor, time: f64, h: f64) -> Result<(), Halt> {
        run.take_substeps(time, h)
    }

    fn checkpoint(run: &mut AnnulusCooledMotor) -> Checkpoint {
        run.checkpoint()
    }

    fn return_to(run: &mut AnnulusCooledMotor, before: Checkpoint) {
        run.return_to(before);
    }
}

impl AnnulusCooledMotor {
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
