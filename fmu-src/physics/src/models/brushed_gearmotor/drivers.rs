//! Terms from data in the gearmotor: their drivers, and what follows from them.

use super::equations::{ALL, Constants, State, Step};
use super::motor::{BrushedGearmotor, Gearmotor};
use super::nodes::{HOUSING, WINDING};
use super::parameters::Parameters;
use super::variables::Inputs;
use crate::effects::Effects;
use crate::runtime::{Driven, Halt, Lags};
use crate::terms::{Drivers, MOST_TERMS};

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

    fn lags_above(parameters: &Parameters) -> [f64; MOST_TERMS] {
        parameters.initial.term_lags()
    }

    fn lags(&self) -> &Lags {
        &self.lags
    }

    fn lags_mut(&mut self) -> &mut Lags {
        &mut self.lags
    }

    fn holds_states(&self) -> bool {
        self.constants.holds_states
    }

    fn has_fast_states(&self) -> bool {
        true
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

    fn improve_mean(run: &BrushedGearmotor, mean: &mut Drivers, h: f64) {
        let over_step = &run.own.state.integrals;
        mean.winding_temperature = over_step.temperature[WINDING] / h;
        mean.housing_temperature = over_step.temperature[HOUSING] / h;
        // A current may reach its new value in a small part of the step.
        (mean.current, mean.speed) = (over_step.fast[0] / h, over_step.fast[1] / h);
    }

    fn heat_flows(run: &BrushedGearmotor) -> [f64; 2] {
        run.step_equations().heat_flows(&run.own.state)
    }

    fn hold(run: &mut BrushedGearmotor, drivers: &Drivers) {
        run.parameters.effects.set_drivers(drivers);
    }

    fn follow_capacity(run: &mut BrushedGearmotor) {
        let factor = run.parameters.effects.capacity_factor();
        if factor != run.own.capacity_factor {
            let before = run.own.constants;
            run.own.capacity_factor = factor;
            run.follow_parameters();
            run.own.stored_at_start[0] += run.heat_gain(&before);
        }
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
    /// Applies changed parameters.
    pub(super) fn follow_parameters(&mut self) {
        self.own.constants = Constants::of(&self.parameters).with_capacity(self.own.capacity_factor);
    }

    /// Heat stored with the present heat capacities minus that with others, J; 0 in Model Exchange, where the stored energy is corrected
    /// only when the importer completes a step (`accept_step`).
    fn heat_gain(&self, other: &Constants) -> f64 {
        if self.pre.is_some() { 0.0 } else { self.heat(&self.own.constants) - self.heat(other) }
    }

    /// Heat stored with these heat capacities, J.
    pub(super) fn heat(&self, constants: &Constants) -> f64 {
        constants.heat(&self.own.state.temperature, self.own.t_start)
    }

    /// Result of `look` with the equations with the present drivers, and what is added to the energy stored at the start, J. The motor is
    /// unchanged: constant drivers belong to the steps, and reading an output must not change them.
    pub(super) fn observe<T>(&self, look: impl FnOnce(&Step, f64) -> T) -> T {
        if !self.is_told() {
            return look(&self.step_equations(), 0.0);
        }
        let mut parameters = self.parameters;
        parameters.effects.set_drivers(&self.drivers_after(self.time, 0.0));
        let factor = parameters.effects.capacity_factor();
        let constants = Constants::of(&parameters).with_capacity(factor);
        let gained =
            if self.pre.is_some() { 0.0 } else { self.heat(&constants) - self.heat(&self.own.constants) };
        look(&self.equations_of(&parameters, &constants), gained)
    }
}
