//! FMI 3.0: Co-Simulation, with event mode, early return and intermediate update if the importer uses them.

use super::{Boolean, InstanceHandle, sink};
use crate::boundary::{Instantiation, array, enter, instantiate, write};
use crate::functions;
use crate::instance::{
    Ended, Instance, Interface, IntermediateUpdate, IntermediateUpdates, Part, Standard, StepInParts,
};
use crate::logger::{Logger3, Status};
use crate::resources::of_path;
use std::ffi::{c_char, c_void};

/// Creates an instance for Co-Simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: Boolean,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    intermediate: *const u32,
    n_intermediate: usize,
    environment: *mut c_void,
    log_message: Option<Logger3>,
    intermediate_update: Option<IntermediateUpdate>,
) -> InstanceHandle {
    // SAFETY: by the crate's documentation; also for every block below.
    let references = unsafe { array(intermediate, n_intermediate, "requiredIntermediateVariables") };
    let (references, unsupported) = match (references, intermediate_update) {
        (Err(refused), _) => (Vec::new(), Some(refused.message)),
        (Ok([_, ..]), None) => {
            (Vec::new(), Some("there are intermediate variables and no intermediateUpdate.".to_string()))
        }
        (Ok(references), _) => (references.to_vec(), None),
    };
    let updates =
        intermediate_update.map(|callback| IntermediateUpdates { callback, environment, references });
    let part = Part { event_mode: event_mode_used != 0, early_return: early_return_allowed != 0, updates };
    unsafe {
        instantiate(Instantiation {
            function: "fmi3InstantiateCoSimulation",
            standard: Standard::Three,
            interface: Interface::CoSimulation,
            part,
            name,
            token,
            resources,
            locate: of_path,
            sink: sink(log_message, environment),
            logging_on: logging_on != 0,
            unsupported,
        })
    }
}

functions! {
    enter;
    /// Enters step mode.
    fn fmi3EnterStepMode() => Instance::enter_step;
}

/// Computes a step. If it reaches a limit of validity, `terminateSimulation` is true and the state is that at
/// `lastSuccessfulTime`, the last time within the limit. The status is OK, because `fmi3Discard` requires an unchanged state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: InstanceHandle,
    at: f64,
    h: f64,
    _no_set_state_prior: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> Status {
    let mut parts = None;
    let (mut ended, mut over) = (Ended::default(), false);
    unsafe {
        let mut status = enter(instance, "fmi3DoStep", |i| {
            let outcome = if i.has_intermediate_updates() {
                i.begin(at, h).map(|begun| parts = Some(begun))
            } else {
                i.stride(at, h).map(|there| ended = there)
            };
            write(last_successful_time, i.time());
            over = i.end().is_some();
            ended.early |= over && i.may_return_early();
            i.unless_over(outcome)
        });
        if let (Some(parts), Status::Ok) = (&mut parts, status) {
            status = step_with_updates(instance, parts, last_successful_time, &mut over);
            ended = parts.ended;
        }
        write(event_handling_needed, Boolean::from(ended.event));
        write(terminate_simulation, Boolean::from(over));
        write(early_return, Boolean::from(ended.early));
        status
    }
}

/// Computes a step in parts. No Rust reference to the instance exists during the intermediate update callback.
unsafe fn step_with_updates(
    instance: InstanceHandle,
    parts: &mut StepInParts,
    last_successful_time: *mut f64,
    over: &mut bool,
) -> Status {
    loop {
        let mut view = None;
        let status = unsafe {
            enter(instance, "fmi3DoStep", |i| {
                let outcome = i.part(parts).map(|seen| view = seen);
                write(last_successful_time, i.time());
                *over = i.end().is_some();
                parts.ended.early |= *over && i.may_return_early();
                i.unless_over(outcome)
            })
        };
        let Some(view) = view else { return status };
        let (mut requested, mut until) = (0, view.time);
        unsafe {
            (view.callback)(
                view.environment,
                view.time,
                Boolean::from(view.sets),
                1,
                1,
                Boolean::from(view.may_return),
                &mut requested,
                &mut until,
            );
        }
        let until = (requested != 0 && view.may_return).then_some(until);
        let status = unsafe {
            enter(instance, "fmi3DoStep", |i| {
                let outcome = i.after_update(parts, until);
                write(last_successful_time, i.time());
                *over = i.end().is_some();
                parts.ended.early |= *over && i.may_return_early();
                i.unless_over(outcome)
            })
        };
        if status != Status::Ok || *over {
            return status;
        }
    }
}
