//! The life cycle, steps, and saved states.
use super::RawInstance;
use super::functions::Api;
use crate::Status;
use std::ffi::c_void;
use std::ptr;

/// A saved state. It must be given back with [`RawInstance::free_state`].
#[derive(Debug)]
pub struct RawState(*mut c_void);

/// How a communication step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawStep {
    /// The status of the call.
    pub status: Status,
    /// The FMU asks for the end of the simulation.
    pub terminated: bool,
    /// FMI 3: the FMU asks for event mode.
    pub event: bool,
    /// FMI 3: the FMU stopped before the end of the step.
    pub early: bool,
    /// FMI 3: the last successful time (s).
    pub reached: Option<f64>,
}

// SAFETY, for all unsafe blocks below: the functions belong to the loaded library, the handle is alive, pointers to
// results live as long as the call, and saved states come from `get_state` or `deserialize` of the same library.
impl RawInstance {
    /// FMI 2 `SetupExperiment`, then (both) `EnterInitializationMode`; times in s.
    pub fn enter_initialization(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Status {
        let (has_tolerance, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        let (has_stop, stop) = (stop.is_some(), stop.unwrap_or(0.0));
        self.status(|api, _, h| match api {
            Api::Two(f) => {
                let (setup, enter) = (f.setup?, f.enter_initialization?);
                // SAFETY: see above.
                let status =
                    unsafe { setup(h, has_tolerance.into(), tolerance, start, has_stop.into(), stop) };
                // SAFETY: see above.
                Some(if status > 1 { status } else { status.max(unsafe { enter(h) }) })
            }
            Api::Three(f) => {
                let enter = f.enter_initialization?;
                // SAFETY: see above.
                Some(unsafe { enter(h, has_tolerance, tolerance, start, has_stop, stop) })
            }
        })
    }

    /// `ExitInitializationMode`
    pub fn exit_initialization(&mut self) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.exit_initialization.map(|f| unsafe { f(h) }))
    }

    /// `Terminate`
    pub fn terminate(&mut self) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.terminate.map(|f| unsafe { f(h) }))
    }

    /// `Reset`
    pub fn reset(&mut self) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.reset.map(|f| unsafe { f(h) }))
    }

    /// FMI 3: `EnterStepMode`
    pub fn enter_step_mode(&mut self) -> Status {
        self.status(|api, _, h| match api {
            Api::Two(_) => None,
            // SAFETY: see above.
            Api::Three(f) => f.enter_step_mode.map(|f| unsafe { f(h) }),
        })
    }

    /// `DoStep` from `t` to `t + h` (s), which may have to be repeated.
    pub fn do_step(&mut self, t: f64, h: f64) -> RawStep {
        let (mut event, mut terminated, mut early, mut reached) = (0, 0, 0, t + h);
        let mut ended = false;
        let status = self.status(|api, _, handle| match api {
            Api::Two(f) => {
                let step = f.do_step?;
                // SAFETY: see above.
                let status = unsafe { step(handle, t, h, 0) };
                if Status::from_c(status) == Status::Discard
                    && let Some(query) = f.get_boolean_status
                {
                    const TERMINATED: i32 = 3;
                    let mut value = 0;
                    // SAFETY: see above.
                    ended = unsafe { query(handle, TERMINATED, &mut value) } <= 1 && value != 0;
                }
                Some(status)
            }
            Api::Three(f) => {
                let step = f.do_step?;
                // SAFETY: see above.
                Some(unsafe {
                    step(handle, t, h, false, &mut event, &mut terminated, &mut early, &mut reached)
                })
            }
        });
        let three = self.version() == crate::FmiVersion::V3;
        RawStep {
            status: if ended { Status::Ok } else { status },
            terminated: ended || terminated != 0,
            event: event != 0,
            early: early != 0,
            reached: three.then_some(reached),
        }
    }

    /// FMI 3 Scheduled Execution: `ActivateModelPartition` of a clock at time `t` (s).
    pub fn activate_partition(&mut self, clock: u32, t: f64) -> Status {
        self.status(|api, _, h| match api {
            Api::Two(_) => None,
            // SAFETY: see above.
            Api::Three(f) => f.activate_partition.map(|f| unsafe { f(h, clock, t) }),
        })
    }

    /// Saves the FMU's state; into `old` if that is given.
    pub fn get_state(&mut self, old: Option<RawState>) -> Result<RawState, Status> {
        let mut pointer = old.map_or(ptr::null_mut(), |s| s.0);
        // SAFETY: see above.
        let status = self.status(|_, c, h| c.get_state.map(|f| unsafe { f(h, &mut pointer) }));
        if status <= Status::Warning { Ok(RawState(pointer)) } else { Err(status) }
    }

    /// Goes back to a saved state.
    pub fn set_state(&mut self, state: &RawState) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.set_state.map(|f| unsafe { f(h, state.0) }))
    }

    /// Frees a saved state; the second value tells whether the FMU set its pointer to NULL, as it must.
    pub fn free_state(&mut self, mut state: RawState) -> (Status, bool) {
        // SAFETY: see above.
        let status = self.status(|_, c, h| c.free_state.map(|f| unsafe { f(h, &mut state.0) }));
        (status, state.0.is_null())
    }

    /// A saved state as bytes.
    pub fn serialize(&mut self, state: &RawState) -> Result<Vec<u8>, Status> {
        let mut size = 0;
        // SAFETY: see above.
        let status = self.status(|_, c, h| c.state_size.map(|f| unsafe { f(h, state.0, &mut size) }));
        if status > Status::Warning {
            return Err(status);
        }
        let mut bytes = vec![0; size];
        // SAFETY: see above; the buffer has the size that the FMU asked for.
        let status =
            self.status(|_, c, h| c.serialize.map(|f| unsafe { f(h, state.0, bytes.as_mut_ptr(), size) }));
        if status > Status::Warning { Err(status) } else { Ok(bytes) }
    }

    /// A state from bytes.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<RawState, Status> {
        let mut pointer = ptr::null_mut();
        let status = self.status(|_, c, h| {
            // SAFETY: see above.
            c.deserialize.map(|f| unsafe { f(h, bytes.as_ptr(), bytes.len(), &mut pointer) })
        });
        if status <= Status::Warning { Ok(RawState(pointer)) } else { Err(status) }
    }
}
