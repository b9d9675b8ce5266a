//! The life cycle, steps, and saved states.
use super::functions::ids;
use super::{RawInstance, c_string};
use crate::{FmiVersion, Status};
use std::ffi::c_void;
use std::ptr;

/// A saved state, or none. It must be given back with [`RawInstance::free_state`].
#[derive(Debug)]
pub struct RawState(*mut c_void);

impl RawState {
    /// No state yet: NULL, as the standards require for the first save.
    pub const NONE: Self = Self(ptr::null_mut());

    /// Whether there is no state.
    pub fn is_none(&self) -> bool {
        self.0.is_null()
    }
}

/// The experiment that is set before initialization.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Start time (s).
    pub start: f64,
    /// Stop time (s).
    pub stop: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
}

/// An optional number as the standards pass it: a flag and the number.
fn optional(number: Option<f64>) -> (bool, f64) {
    (number.is_some(), number.unwrap_or(0.0))
}

/// How a communication step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawStep {
    /// The status of the call.
    pub status: Status,
    /// The FMU requests the end of the simulation.
    pub terminated: bool,
    /// FMI 3: the FMU requests event mode.
    pub event: bool,
    /// FMI 3: the FMU stopped before the end of the step.
    pub early: bool,
    /// FMI 3: the last successful time (s).
    pub reached: Option<f64>,
}

impl RawInstance {
    /// Requests the reasons of refused calls, without debug messages, which may be slow; `categories` are those of the model
    /// description.
    pub fn enable_reasons(&mut self, categories: &[String]) {
        let reasons: Vec<&str> =
            categories.iter().map(String::as_str).filter(|name| name.starts_with("logStatus")).collect();
        if !reasons.is_empty() {
            self.enable_categories(&reasons);
        }
    }

    /// Enables log categories, by their names in the model description; OK without that function.
    pub fn enable_categories(&mut self, categories: &[&str]) -> Status {
        let names: Vec<_> = categories.iter().map(|name| c_string(name)).collect();
        let pointers: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
        let (n, pointers) = (pointers.len(), pointers.as_ptr());
        let two = self.loaded.version == FmiVersion::V2;
        let function = if two { ids::set_logging2 } else { ids::set_logging3 };
        // SAFETY: the handle is alive, and the C strings outlive the call.
        self.status(function, |f, h| match (f.set_logging2, f.set_logging3) {
            // SAFETY: see above.
            (Some(set), _) => Some(unsafe { set(h, 1, n, pointers) }),
            // SAFETY: see above.
            (_, Some(set)) => Some(unsafe { set(h, true, n, pointers) }),
            _ => Some(0),
        })
    }
}

/// Calls that are one function of both standards, with their arguments and what is passed of them.
macro_rules! calls {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) = $field:ident($($passed:expr),*);)*) => {
        impl RawInstance {
            $($(#[$doc])*
            pub fn $name(&mut self $(, $argument: $type)*) -> Status {
                // SAFETY: the function belongs to the loaded library, the handle is alive, pointers to arrays and results are
                // valid during the call, and saved states come from `save` or `deserialize` of the same library.
                self.status(ids::$field, |f, h| f.$field.map(|f| unsafe { f(h $(, $passed)*) }))
            })*
        }
    };
}

calls! {
    /// FMI 3: `EnterConfigurationMode`
    enter_configuration() = enter_configuration();
    /// FMI 3: `ExitConfigurationMode`
    exit_configuration() = exit_configuration();
    /// `ExitInitializationMode`
    exit_initialization() = exit_initialization();
    /// `Terminate`
    terminate() = terminate();
    /// `Reset`
    reset() = reset();
    /// FMI 3: `EnterStepMode`
    enter_step_mode() = enter_step_mode();
    /// FMI 3: the shift of a clock (s).
    clock_shift(clock: u32, shift: &mut f64) = get_shift(&clock, 1, shift);
    /// `EnterEventMode`
    enter_event_mode() = enter_event();
    /// `EnterContinuousTimeMode`
    enter_continuous_time_mode() = enter_continuous();
    /// FMI 3 Scheduled Execution: `ActivateModelPartition` of a clock at time `t` (s).
    activate_partition(clock: u32, t: f64) = activate_partition(clock, t);
    /// Saves the FMU's state into `state`, which may hold one already.
    save(state: &mut RawState) = get_state(&mut state.0);
    /// Goes back to a saved state.
    restore(state: &RawState) = set_state(state.0);
    /// Frees a saved state; the FMU must set its pointer to NULL, see [`RawState::is_none`].
    free_state(state: &mut RawState) = free_state(&mut state.0);
    /// The number of bytes of a serialized state.
    state_size(state: &RawState, size: &mut usize) = state_size(state.0, size);
    /// Writes a saved state to `bytes`, which must have the size that [`Self::state_size`] gives.
    serialize(state: &RawState, bytes: &mut [u8]) = serialize(state.0, bytes.as_mut_ptr(), bytes.len());
    /// A state from bytes.
    deserialize(bytes: &[u8], state: &mut RawState) = deserialize(bytes.as_ptr(), bytes.len(), &mut state.0);
    /// `SetTime`, s
    set_time(t: f64) = set_time(t);
    /// `SetContinuousStates`
    set_states(x: &[f64]) = set_states(x.as_ptr(), x.len());
    /// `GetContinuousStates`
    get_states(x: &mut [f64]) = get_states(x.as_mut_ptr(), x.len());
    /// The derivatives of all states, per s.
    get_derivatives(x: &mut [f64]) = get_derivatives(x.as_mut_ptr(), x.len());
    /// `GetEventIndicators`
    get_indicators(z: &mut [f64]) = get_indicators(z.as_mut_ptr(), z.len());
    /// `GetNominalsOfContinuousStates`
    get_nominals(x: &mut [f64]) = get_nominals(x.as_mut_ptr(), x.len());
}

// SAFETY, for all unsafe blocks below: the functions belong to the loaded library, the handle is alive, pointers to
// results live as long as the call, and saved states come from `save` or `deserialize` of the same library.
impl RawInstance {
    /// `SetupExperiment` of FMI 2, then `EnterInitializationMode`: for callers that set no parameters in between.
    pub fn enter_initialization(&mut self, experiment: &Experiment) -> Status {
        let setup = self.setup_experiment(experiment);
        if setup > Status::Warning { setup } else { setup.max(self.enter_initialization_mode(experiment)) }
    }

    /// `fmi2SetupExperiment`; FMI 3 has no such call.
    pub fn setup_experiment(&mut self, experiment: &Experiment) -> Status {
        if self.version() == FmiVersion::V3 {
            return Status::Ok;
        }
        let (has_tolerance, tolerance) = optional(experiment.tolerance);
        let (has_stop, stop) = optional(experiment.stop);
        let start = experiment.start;
        self.status(ids::setup, |f, h| {
            // SAFETY: see above.
            f.setup.map(|f| unsafe { f(h, has_tolerance.into(), tolerance, start, has_stop.into(), stop) })
        })
    }

    /// `EnterInitializationMode`; in FMI 2 after [`Self::setup_experiment`].
    pub fn enter_initialization_mode(&mut self, experiment: &Experiment) -> Status {
        let (has_tolerance, tolerance) = optional(experiment.tolerance);
        let (has_stop, stop) = optional(experiment.stop);
        let version = self.version();
        let function = match version {
            FmiVersion::V2 => ids::enter_initialization2,
            FmiVersion::V3 => ids::enter_initialization3,
        };
        self.status(function, |f, h| match version {
            // SAFETY: see above.
            FmiVersion::V2 => f.enter_initialization2.map(|f| unsafe { f(h) }),
            FmiVersion::V3 => {
                let enter = f.enter_initialization3?;
                // SAFETY: see above.
                Some(unsafe { enter(h, has_tolerance, tolerance, experiment.start, has_stop, stop) })
            }
        })
    }

    /// FMI 3, event mode: activates clocks.
    pub fn tick(&mut self, clocks: &[u32]) -> Status {
        let active = vec![true; clocks.len()];
        let (v, n, active) = (clocks.as_ptr(), clocks.len(), active.as_ptr());
        // SAFETY: see above.
        self.status(ids::set_clock, |f, h| f.set_clock.map(|f| unsafe { f(h, v, n, active) }))
    }

    /// FMI 3: the interval of a clock (s); `None` as long as the FMU has not determined it.
    pub fn clock_interval(&mut self, clock: u32) -> (Status, Option<f64>) {
        /// `fmi3IntervalChanged`: the interval is new since the last call.
        const CHANGED: i32 = 2;
        let (mut interval, mut qualifier) = (0.0, CHANGED);
        let status = self.status(ids::get_interval, |f, h| {
            // SAFETY: see above.
            f.get_interval.map(|f| unsafe { f(h, &clock, 1, &mut interval, &mut qualifier) })
        });
        (status, (qualifier == CHANGED).then_some(interval))
    }

    /// `DoStep` from `t` to `t + h` (s); with `no_rollback` the FMU need not support a rollback to a time before `t`.
    #[inline]
    pub fn do_step(&mut self, t: f64, h: f64, no_rollback: bool) -> RawStep {
        self.page.at(t);
        match self.version() {
            FmiVersion::V2 => {
                let status = self.status(ids::do_step2, |f, instance| {
                    // SAFETY: see above.
                    f.do_step2.map(|step| unsafe { step(instance, t, h, no_rollback.into()) })
                });
                // In FMI 2 an FMU can request the end only by discarding the step.
                let terminated = status == Status::Discard && self.wants_to_end();
                let status = if terminated { Status::Ok } else { status };
                RawStep { status, terminated, event: false, early: false, reached: None }
            }
            FmiVersion::V3 => self.do_step_along(t, |raw| {
                let (mut event, mut terminated, mut early, mut reached) = (0, 0, 0, t + h);
                let status = raw.status(ids::do_step3, |f, instance| {
                    let step = f.do_step3?;
                    let (event, terminated) = (&mut event, &mut terminated);
                    // SAFETY: see above.
                    Some(unsafe {
                        step(instance, t, h, no_rollback, event, terminated, &mut early, &mut reached)
                    })
                });
                let (event, terminated, early) = (event != 0, terminated != 0, early != 0);
                RawStep { status, terminated, event, early, reached: Some(reached) }
            }),
        }
    }

    /// Whether the FMU discarded a step to request the end of the simulation.
    #[cold]
    fn wants_to_end(&mut self) -> bool {
        const TERMINATED: i32 = 3;
        let mut value = 0;
        let query = self.status(ids::get_boolean_status, |f, h| {
            // SAFETY: see above.
            f.get_boolean_status.map(|f| unsafe { f(h, TERMINATED, &mut value) })
        });
        query <= Status::Warning && value != 0
    }
}
