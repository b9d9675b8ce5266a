//! FMI 3.0: Model Exchange, and the event functions that it shares with Co-Simulation.

use super::{Boolean, InstanceHandle, sink};
use crate::boundary::{Instantiation, Out, array, copied, instantiate, write};
use crate::functions;
use crate::instance::{Instance, Interface, Part, Standard};
use crate::logger::Logger3;
use crate::refusal::Outcome;
use crate::resources::of_path;
use std::ffi::{c_char, c_void};

/// Creates an instance for Model Exchange.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: Boolean,
    logging_on: Boolean,
    environment: *mut c_void,
    log_message: Option<Logger3>,
) -> InstanceHandle {
    // SAFETY: by the crate's documentation; also for every block below.
    unsafe {
        instantiate(Instantiation {
            function: "fmi3InstantiateModelExchange",
            standard: Standard::Three,
            interface: Interface::ModelExchange,
            part: Part::default(),
            name,
            token,
            resources,
            locate: of_path,
            sink: sink(log_message, environment),
            logging_on: logging_on != 0,
            unsupported: None,
        })
    }
}

functions! {
    enter;
    /// Enters event mode.
    fn fmi3EnterEventMode() => Instance::enter_event;
    /// Has no effect: discrete states change in [`fmi3UpdateDiscreteStates`] only.
    fn fmi3EvaluateDiscreteStates() => |i| i.require_event();
    /// Updates the discrete outputs, which are constant between events.
    fn fmi3UpdateDiscreteStates(
        need_update: *mut Boolean, terminate: *mut Boolean, nominals_changed: *mut Boolean,
        values_changed: *mut Boolean, next_event_defined: *mut Boolean, next_event: *mut f64
    ) => |i| {
        let update = i.update()?;
        write(need_update, 0);
        write(terminate, Boolean::from(i.is_over()));
        write(nominals_changed, 0);
        write(values_changed, Boolean::from(update.states_changed));
        write(next_event_defined, Boolean::from(update.next_event.is_finite()));
        write(next_event, if update.next_event.is_finite() { update.next_event } else { 0.0 });
        Ok(())
    };
}

functions! {
    exchange;
    /// Enters continuous-time mode.
    fn fmi3EnterContinuousTimeMode() => Instance::enter_continuous;
    /// Completes an integrator step.
    fn fmi3CompletedIntegratorStep(
        _no_set_state_prior: Boolean, enter_event: *mut Boolean, terminate: *mut Boolean
    ) => |i| {
        let over = i.accept_step()?;
        write(enter_event, 0);
        write(terminate, Boolean::from(over));
        Ok(())
    };
    /// Sets the time.
    fn fmi3SetTime(time: f64) => |i| i.set_time(time);
    /// Sets the continuous states.
    fn fmi3SetContinuousStates(states: *const f64, n: usize) =>
        |i| i.set_states(array(states, n, "continuousStates")?);
    /// Derivatives of the continuous states.
    fn fmi3GetContinuousStateDerivatives(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::derivatives);
    /// Event indicators.
    fn fmi3GetEventIndicators(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::indicators);
    /// Continuous states.
    fn fmi3GetContinuousStates(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::states);
    /// Nominal values of the continuous states.
    fn fmi3GetNominalsOfContinuousStates(out: *mut f64, n: usize) => |i| copied(i, out, n, Instance::nominals);
}

/// Writes the number of states or indicators; 0 for an instance for Co-Simulation.
///
/// # Safety
/// As [`Out::variable`].
unsafe fn count(i: &mut Instance, n: *mut usize, number: fn(&Instance) -> usize) -> Outcome {
    let integrates = i.require_interface(Interface::ModelExchange).is_ok();
    // SAFETY: by contract.
    unsafe { Out::variable(n, "the number") }?.set(0, if integrates { number(i) } else { 0 });
    Ok(())
}

functions! {
    enter;
    /// Number of continuous states.
    fn fmi3GetNumberOfContinuousStates(n: *mut usize) => |i| count(i, n, Instance::number_of_states);
    /// Number of event indicators.
    fn fmi3GetNumberOfEventIndicators(n: *mut usize) => |i| count(i, n, Instance::number_of_indicators);
}
