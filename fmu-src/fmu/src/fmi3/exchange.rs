//! FMI 3.0: Model Exchange, and the events that it shares with Co-Simulation.

use super::{Boolean, InstanceHandle, sink};
use crate::boundary::{Instantiation, array, array_mut, enter, instantiate, place, write};
use crate::instance::{Instance, Interface, Part, Standard};
use crate::logger::{Logger3, Status};
use crate::refusal::Outcome;
use crate::resources::of_path;
use std::ffi::{c_char, c_void};

/// Makes an instance for Model Exchange.
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
    // SAFETY: as the crate's documentation says; so for every block below.
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

/// Runs an operation of Model Exchange.
///
/// # Safety
/// As [`enter`].
unsafe fn exchange(
    instance: InstanceHandle,
    name: &str,
    operation: impl FnOnce(&mut Instance) -> Outcome,
) -> Status {
    // SAFETY: by contract.
    unsafe {
        enter(instance, name, |i| {
            i.require_interface(Interface::ModelExchange)?;
            operation(i)
        })
    }
}

/// Begins an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: InstanceHandle) -> Status {
    unsafe { enter(instance, "fmi3EnterEventMode", Instance::enter_event) }
}

/// Has no effect: discrete states change in [`fmi3UpdateDiscreteStates`] only.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EvaluateDiscreteStates(instance: InstanceHandle) -> Status {
    unsafe { enter(instance, "fmi3EvaluateDiscreteStates", |i| i.require_event()) }
}

/// Updates the discrete outputs, which are constant between events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: InstanceHandle,
    need_update: *mut Boolean,
    terminate: *mut Boolean,
    nominals_changed: *mut Boolean,
    values_changed: *mut Boolean,
    next_event_defined: *mut Boolean,
    next_event: *mut f64,
) -> Status {
    unsafe {
        enter(instance, "fmi3UpdateDiscreteStates", |i| {
            let update = i.update()?;
            write(need_update, 0);
            write(terminate, Boolean::from(i.is_over()));
            write(nominals_changed, 0);
            write(values_changed, Boolean::from(update.states_changed));
            write(next_event_defined, Boolean::from(update.next_event.is_finite()));
            write(next_event, if update.next_event.is_finite() { update.next_event } else { 0.0 });
            Ok(())
        })
    }
}

/// Ends an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: InstanceHandle) -> Status {
    unsafe { exchange(instance, "fmi3EnterContinuousTimeMode", Instance::enter_continuous) }
}

/// Completes an integrator step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: InstanceHandle,
    _no_set_state_prior: Boolean,
    enter_event: *mut Boolean,
    terminate: *mut Boolean,
) -> Status {
    unsafe {
        exchange(instance, "fmi3CompletedIntegratorStep", |i| {
            let over = i.accept_step()?;
            write(enter_event, 0);
            write(terminate, Boolean::from(over));
            Ok(())
        })
    }
}

/// Sets the time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: InstanceHandle, time: f64) -> Status {
    unsafe { exchange(instance, "fmi3SetTime", |i| i.set_time(time)) }
}

/// Sets the continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(
    instance: InstanceHandle,
    states: *const f64,
    n: usize,
) -> Status {
    unsafe {
        exchange(instance, "fmi3SetContinuousStates", |i| i.set_states(array(states, n, "continuousStates")?))
    }
}

/// Functions that fill an array.
macro_rules! fill {
    ($($(#[doc = $doc:literal])* $name:ident => $method:ident;)*) => {$(
        $(#[doc = $doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: InstanceHandle, out: *mut f64, n: usize) -> Status {
            unsafe { exchange(instance, stringify!($name), |i| i.$method(array_mut(out, n, "the array")?)) }
        }
    )*};
}

fill! {
    /// Derivatives of the continuous states.
    fmi3GetContinuousStateDerivatives => derivatives;
    /// Event indicators.
    fmi3GetEventIndicators => indicators;
    /// Continuous states.
    fmi3GetContinuousStates => states;
    /// Typical sizes of the continuous states.
    fmi3GetNominalsOfContinuousStates => nominals;
}

/// Functions that count.
macro_rules! count {
    ($($(#[doc = $doc:literal])* $name:ident => $method:ident;)*) => {$(
        $(#[doc = $doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: InstanceHandle, n: *mut usize) -> Status {
            unsafe {
                enter(instance, stringify!($name), |i| {
                    // An instance for Co-Simulation has none.
                    let integrates = i.require_interface(Interface::ModelExchange).is_err();
                    *place(n, "the number")? = if integrates { 0 } else { i.$method() };
                    Ok(())
                })
            }
        }
    )*};
}

count! {
    /// Number of continuous states.
    fmi3GetNumberOfContinuousStates => number_of_states;
    /// Number of event indicators.
    fmi3GetNumberOfEventIndicators => number_of_indicators;
}
