//! FMI 2.0: the functions of Model Exchange, section 3.2 of the standard.

use super::{Boolean, Component};
use crate::boundary::{array, array_mut, enter, place};
use crate::instance::{Instance, Interface};
use crate::logger::Status;
use crate::refusal::Outcome;

/// Result of an event iteration.
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
    /// A time event is known.
    pub next_event_time_defined: Boolean,
    /// Its time, s.
    pub next_event_time: f64,
}

/// Runs an operation of Model Exchange.
///
/// # Safety
/// As [`enter`].
unsafe fn exchange(c: Component, name: &str, operation: impl FnOnce(&mut Instance) -> Outcome) -> Status {
    // SAFETY: by contract.
    unsafe {
        enter(c, name, |i| {
            i.require_interface(Interface::ModelExchange)?;
            operation(i)
        })
    }
}

/// Begins an event; section 3.2.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: Component) -> Status {
    // SAFETY: as the crate's documentation says; so for every block below.
    unsafe { exchange(c, "fmi2EnterEventMode", Instance::enter_event) }
}

/// Updates the discrete variables; section 3.2.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: Component, info: *mut EventInfo) -> Status {
    unsafe {
        exchange(c, "fmi2NewDiscreteStates", |i| {
            let info = place(info, "eventInfo")?;
            let update = i.update()?;
            *info = EventInfo {
                new_discrete_states_needed: 0,
                terminate_simulation: Boolean::from(i.is_over()),
                nominals_changed: 0,
                values_changed: Boolean::from(update.states_changed),
                next_event_time_defined: Boolean::from(update.next_event.is_finite()),
                next_event_time: if update.next_event.is_finite() { update.next_event } else { 0.0 },
            };
            Ok(())
        })
    }
}

/// Ends an event; section 3.2.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: Component) -> Status {
    unsafe { exchange(c, "fmi2EnterContinuousTimeMode", Instance::enter_continuous) }
}

/// Completes an integrator step; section 3.2.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: Component,
    _no_set_state_prior: Boolean,
    enter_event: *mut Boolean,
    terminate: *mut Boolean,
) -> Status {
    unsafe {
        exchange(c, "fmi2CompletedIntegratorStep", |i| {
            let (enter_event, terminate) =
                (place(enter_event, "enterEventMode")?, place(terminate, "terminateSimulation")?);
            let over = i.accept_step()?;
            (*enter_event, *terminate) = (0, Boolean::from(over));
            Ok(())
        })
    }
}

/// Sets the time; section 3.2.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: Component, time: f64) -> Status {
    unsafe { exchange(c, "fmi2SetTime", |i| i.set_time(time)) }
}

/// Sets the continuous states; section 3.2.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: Component, x: *const f64, n: usize) -> Status {
    unsafe { exchange(c, "fmi2SetContinuousStates", |i| i.set_states(array(x, n, "x")?)) }
}

/// Functions that fill an array.
macro_rules! fill {
    ($($(#[doc = $doc:literal])* $name:ident => $method:ident;)*) => {$(
        $(#[doc = $doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: Component, out: *mut f64, n: usize) -> Status {
            unsafe { exchange(c, stringify!($name), |i| i.$method(array_mut(out, n, "the array")?)) }
        }
    )*};
}

fill! {
    /// Derivatives of the continuous states; section 3.2.2.
    fmi2GetDerivatives => derivatives;
    /// Event indicators; section 3.2.2.
    fmi2GetEventIndicators => indicators;
    /// Continuous states; section 3.2.2.
    fmi2GetContinuousStates => states;
    /// Typical sizes of the continuous states; section 3.2.2.
    fmi2GetNominalsOfContinuousStates => nominals;
}
