//! Terms from data in the gearmotor: their drivers, and what follows from them.

use super::equations::{ALL, Constants, State, Step};
use super::motor::{BrushedGearmotor, Gearmotor};
use super::nodes::{HOUSING, WINDING};
use super::parameters::Parameters;
use super::variables::Inputs;
use crate::effects::Effects;
use crate::runtime::{Driven, Halt, TermStates};
use crate::terms::{Drivers, LagStarts};

/// The gearmotor before a step that may be undone. The parameters, whose effects have other drivers since, are not a part of it: every step
/// sets the drivers.
pub struct Checkpoint {
    own: Gearmotor,
    inputs: [Inputs; 2],
    time: f64,
}

impl Driven<ALL> for Gearmotor {
    type Instant = State;
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
        &mut self.stored_at_start[0]
    }

    fn instant(run: &BrushedGearmotor) -> State {
        run.own.state
    }

    fn put_instant(run: &mut BrushedGearmotor, at: State) {
        run.own.state = at;
    }

    fn middle(run: &BrushedGearmotor, from: &State, h: f64) -> State {
        run.own.state.middle(from, h)
    }

    fn drivers_of(run: &BrushedGearmotor, time: f64, inputs: &Inputs, at: &State) -> Drivers {
        Drivers {
            speed: at.x[1],
            current: at.x[0],
            load_torque: inputs.load_torque,
            winding_temperature: at.temperature[WINDING],
            housing_temperature: at.temperature[HOUSING],
            ambient_temperature: inputs.ambient_temperature + run.parameters.effects.ambient_sensor() * time,
            time,
            ..Drivers::default()
        }
    }

    fn integrals(run: &BrushedGearmotor) -> Option<[f64; 4]> {
        Some(run.own.state.integrals.of_drivers())
    }

    fn heat_flows(run: &BrushedGearmotor) -> [f64; 2] {
        run.step_equations().heat_flows(&run.own.state)
    }

    fn hold(run: &mut BrushedGearmotor, drivers: &Drivers) {
        run.parameters.effects.set_drivers(drivers);
    }

    fn follow_parameters(run: &mut BrushedGearmotor) {
        run.own.constants = Constants::of(&run.parameters).with_capacity(run.own.terms.capacity_factor);
        run.own.terms.holds_states = run.parameters.effects.holds_states(true, true);
    }

    fn heat(run: &BrushedGearmotor, capacity_factor: f64) -> f64 {
        let capacity = Constants::of(&run.parameters).capacity.scaled(capacity_factor);
        capacity.heat(&run.own.state.temperature, run.own.t_start)
    }

    fn take(run: &mut BrushedGearmotor, time: f64, h: f64) -> Result<(), Halt> {
        run.take(time, h)
    }

    fn checkpoint(run: &mut BrushedGearmotor) -> Checkpoint {
        Checkpoint { own: run.own.clone(), inputs: [run.inputs, run.slopes], time: run.time }
    }

    fn return_to(run: &mut BrushedGearmotor, before: Checkpoint) {
        let [inputs, slopes] = before.inputs;
        (run.own, run.inputs, run.time) = (before.own, inputs, before.time);
        run.put_slopes(slopes);
        run.outdate();
    }
}

impl BrushedGearmotor {
    /// Result of `look` with the equations with the present drivers, and what is added to the energy stored at the start, J. The motor is
    /// unchanged: constant drivers belong to the steps, and reading an output must not change them.
    pub(super) fn observe<T>(&self, look: impl FnOnce(&Step, f64) -> T) -> T {
        if !self.has_driven_effects() {
            return look(&self.step_equations(), 0.0);
        }
        let mut parameters = self.parameters;
        parameters.effects.set_drivers(&self.drivers_after(self.time, 0.0));
        let factor = parameters.effects.capacity_factor();
        let constants = Constants::of(&parameters).with_capacity(factor);
        look(&self.equations_of(&parameters, &constants), self.heat_gained(factor))
    }
}
