//! FMI 2.0: the functions of Model Exchange, section 3.2 of the standard.

use super::Boolean;
use crate::boundary::{Out, array, copied};
use crate::functions;
use crate::instance::Instance;

/// Result of an event iteration.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct EventInfo {
    /// Another event iteration is needed.
    pub new_discrete_states_needed: Boolean,
    /// The model requests the end of the simulation.
    pub terminate_simulation: Boolean,
    /// Nominal values have changed.
    pub nominals_changed: Boolean,
    /// States have changed.
    pub values_changed: Boolean,
    /// A next time event is defined.
    pub next_event_time_defined: Boolean,
    /// Its time, s.
    pub next_event_time: f64,
}

functions! {
    exchange;
    /// Enters event mode; section 3.2.2.
    fn fmi2EnterEventMode() => Instance::enter_event;
    /// Updates the discrete variables; section 3.2.2.
    fn fmi2NewDiscreteStates(info: *mut EventInfo) => |i| {
        let info = Out::variable(info, "eventInfo")?;
        let update = i.update()?;
        info.set(0, EventInfo {
            new_discrete_states_needed: 0,
            terminate_simulation: Boolean::from(i.is_over()),
            nominals_changed: 0,
            values_changed: Boolean::from(update.states_changed),
            next_event_time_defined: Boolean::from(update.next_event.is_finite()),
            next_event_time: if update.next_event.is_finite() { update.next_event } else { 0.0 },
        });
        Ok(())
    };
    /// Enters continuous-time mode; section 3.2.2.
    fn fmi2EnterContinuousTimeMode() => Instance::enter_continuous;
    /// Completes an integrator step; section 3.2.2.
    fn fmi2CompletedIntegratorStep(
        _no_set_state_prior: Boolean, enter_event: *mut Boolean, terminate: *mut Boolean
    ) => |i| {
        let (enter_event, terminate) =
            (Out::variable(enter_event, "enterEventMode")?, Out::variable(terminate, "terminateSimulation")?);
        let over = i.accept_step()?;
        enter_event.set(0, 0);
        terminate.set(0, Boolean::from(over));
        Ok(())
    };
    /// Sets the time; section 3.2.1.
    fn fmi2SetTime(time: f64) => |i| i.set_time(time);
    /// Sets the continuous states; section 3.2.1.
    fn fmi2SetContinuousStates(x: *const f64, n: usize) => |i| i.set_states(array(x, n, "x")?);
    /// Derivatives of the continuous states; section 3.2.2.
    fn fmi2GetDerivatives(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::derivatives);
    /// Event indicators; section 3.2.2.
    fn fmi2GetEventIndicators(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::indicators);
    /// Continuous states; section 3.2.2.
    fn fmi2GetContinuousStates(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::states);
    /// Nominal values of the continuous states; section 3.2.2.
    fn fmi2GetNominalsOfContinuousStates(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::nominals);
}
