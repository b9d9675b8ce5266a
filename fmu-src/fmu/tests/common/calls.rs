//! The functions of both standards under one name.

use motor_fmu::fmi2::*;
use motor_fmu::fmi3::*;
use motor_fmu::instance::Instance;
use motor_fmu::logger::Status;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::null_mut;

/// The handle of an instance and its standard.
#[derive(Clone, Copy)]
pub struct Fmu {
    pub handle: *mut c_void,
    pub three: bool,
}

/// `name(arguments) = function of FMI 2.0, function of FMI 3.0`, each with its arguments after the handle.
macro_rules! calls {
    ($($name:ident($($argument:ident: $type:ty),*) = $two:ident($($of_two:expr),*), $three:ident($($of_three:expr),*);)*) => {
        impl Fmu {$(
            pub fn $name(self $(, $argument: $type)*) -> Status {
                unsafe {
                    if self.three { $three(self.handle $(, $of_three)*) } else { $two(self.handle $(, $of_two)*) }
                }
            }
        )*}
    };
}

calls! {
    exit_initialization() = fmi2ExitInitializationMode(), fmi3ExitInitializationMode();
    terminate() = fmi2Terminate(), fmi3Terminate();
    reset() = fmi2Reset(), fmi3Reset();
    enter_event() = fmi2EnterEventMode(), fmi3EnterEventMode();
    continue_in_time() = fmi2EnterContinuousTimeMode(), fmi3EnterContinuousTimeMode();
    set_time(time: f64) = fmi2SetTime(time), fmi3SetTime(time);
    set_states(x: &[f64]) =
        fmi2SetContinuousStates(x.as_ptr(), x.len()), fmi3SetContinuousStates(x.as_ptr(), x.len());
    get_states(x: &mut [f64]) =
        fmi2GetContinuousStates(x.as_mut_ptr(), x.len()), fmi3GetContinuousStates(x.as_mut_ptr(), x.len());
    get_rates(x: &mut [f64]) =
        fmi2GetDerivatives(x.as_mut_ptr(), x.len()), fmi3GetContinuousStateDerivatives(x.as_mut_ptr(), x.len());
    get_indicators(z: &mut [f64]) =
        fmi2GetEventIndicators(z.as_mut_ptr(), z.len()), fmi3GetEventIndicators(z.as_mut_ptr(), z.len());
    get_reals(vr: &[u32], values: &mut [f64]) =
        fmi2GetReal(vr.as_ptr(), same(vr, values), values.as_mut_ptr()),
        fmi3GetFloat64(vr.as_ptr(), vr.len(), values.as_mut_ptr(), values.len());
    set_reals(vr: &[u32], values: &[f64]) =
        fmi2SetReal(vr.as_ptr(), same(vr, values), values.as_ptr()),
        fmi3SetFloat64(vr.as_ptr(), vr.len(), values.as_ptr(), values.len());
    directional(unknowns: &[u32], knowns: &[u32], seed: &[f64], out: &mut [f64]) =
        fmi2GetDirectionalDerivative(
            unknowns.as_ptr(), same(unknowns, out), knowns.as_ptr(), same(knowns, seed), seed.as_ptr(), out.as_mut_ptr()
        ),
        fmi3GetDirectionalDerivative(
            unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len(), seed.as_ptr(), seed.len(), out.as_mut_ptr(),
            out.len()
        );
    get_slopes(vr: &[u32], orders: &[i32], values: &mut [f64]) =
        fmi2GetRealOutputDerivatives(vr.as_ptr(), same(vr, values), orders.as_ptr(), values.as_mut_ptr()),
        fmi3GetOutputDerivatives(vr.as_ptr(), same(vr, orders), orders.as_ptr(), values.as_mut_ptr(), values.len());
    get_state(state: &mut *mut c_void) = fmi2GetFMUstate(state), fmi3GetFMUState(state);
    set_state(state: *mut c_void) = fmi2SetFMUstate(state), fmi3SetFMUState(state);
    free_state(state: &mut *mut c_void) = fmi2FreeFMUstate(state), fmi3FreeFMUState(state);
    state_size(state: *mut c_void, size: &mut usize) =
        fmi2SerializedFMUstateSize(state, size), fmi3SerializedFMUStateSize(state, size);
    serialize(state: *mut c_void, bytes: &mut [u8]) =
        fmi2SerializeFMUstate(state, bytes.as_mut_ptr(), bytes.len()),
        fmi3SerializeFMUState(state, bytes.as_mut_ptr(), bytes.len());
    deserialize(bytes: &[u8], state: &mut *mut c_void) =
        fmi2DeSerializeFMUstate(bytes.as_ptr(), bytes.len(), state),
        fmi3DeserializeFMUState(bytes.as_ptr(), bytes.len(), state);
}

/// The length of two arrays that FMI 2.0 takes to be equally long.
fn same<A, B>(one: &[A], other: &[B]) -> usize {
    assert_eq!(one.len(), other.len());
    one.len()
}

/// The reported flags of an event iteration: again, terminate, nominal values changed, values changed, next event defined.
pub type Flags = [i32; 5];

impl Fmu {
    pub fn free(self) {
        unsafe { if self.three { fmi3FreeInstance(self.handle) } else { fmi2FreeInstance(self.handle) } }
    }

    /// Enters initialization mode; the tolerance is defined where there is one.
    pub fn enter(self, tolerance: Option<f64>, start: f64) -> Status {
        let (h, defined, tolerance) = (self.handle, tolerance.is_some(), tolerance.unwrap_or(0.0));
        unsafe {
            if self.three {
                return fmi3EnterInitializationMode(h, u8::from(defined), tolerance, start, 0, 0.0);
            }
            match fmi2SetupExperiment(h, c_int::from(defined), tolerance, start, 0, 0.0) {
                Status::Ok => fmi2EnterInitializationMode(h),
                refused => refused,
            }
        }
    }

    pub fn set_whole(self, vr: &[u32], values: &[i64]) -> Status {
        let (h, n) = (self.handle, same(vr, values));
        if self.three {
            return unsafe { fmi3SetInt64(h, vr.as_ptr(), n, values.as_ptr(), n) };
        }
        let values: Vec<c_int> = values.iter().map(|v| c_int::try_from(*v).unwrap_or(c_int::MAX)).collect();
        unsafe { fmi2SetInteger(h, vr.as_ptr(), n, values.as_ptr()) }
    }

    pub fn get_whole(self, vr: &[u32], values: &mut [i64]) -> Status {
        let (h, n) = (self.handle, same(vr, values));
        if self.three {
            return unsafe { fmi3GetInt64(h, vr.as_ptr(), n, values.as_mut_ptr(), n) };
        }
        let mut read = vec![0; n];
        let status = unsafe { fmi2GetInteger(h, vr.as_ptr(), n, read.as_mut_ptr()) };
        values.iter_mut().zip(read).for_each(|(value, read)| *value = read.into());
        status
    }

    /// Whether a Boolean variable is true.
    pub fn flag(self, vr: u32) -> bool {
        let (mut byte, mut word) = (9, 9);
        let status = unsafe {
            if self.three {
                fmi3GetBoolean(self.handle, &vr, 1, &mut byte, 1)
            } else {
                fmi2GetBoolean(self.handle, &vr, 1, &mut word)
            }
        };
        assert_eq!(status, Status::Ok);
        if self.three { byte == 1 } else { word == 1 }
    }

    /// One event iteration, and the time of the next event.
    pub fn iterate(self) -> (Status, Flags, f64) {
        if self.three {
            let (mut flags, mut next) = ([9u8; 5], f64::NAN);
            let [a, b, c, d, e] = flags.each_mut();
            let status = unsafe { fmi3UpdateDiscreteStates(self.handle, a, b, c, d, e, &mut next) };
            return (status, flags.map(i32::from), next);
        }
        let mut info = EventInfo {
            new_discrete_states_needed: 9,
            terminate_simulation: 9,
            nominals_changed: 9,
            values_changed: 9,
            next_event_time_defined: 9,
            next_event_time: f64::NAN,
        };
        let status = unsafe { fmi2NewDiscreteStates(self.handle, &mut info) };
        let (again, terminate) = (info.new_discrete_states_needed, info.terminate_simulation);
        let (nominals, values, defined) =
            (info.nominals_changed, info.values_changed, info.next_event_time_defined);
        (status, [again, terminate, nominals, values, defined], info.next_event_time)
    }

    /// Completes an integrator step: whether an event or the end is due.
    pub fn complete(self) -> (Status, bool, bool) {
        let (mut bytes, mut words) = ((9, 9), (9, 9));
        unsafe {
            if self.three {
                let status = fmi3CompletedIntegratorStep(self.handle, 1, &mut bytes.0, &mut bytes.1);
                return (status, bytes.0 != 0, bytes.1 != 0);
            }
            let status = fmi2CompletedIntegratorStep(self.handle, 1, &mut words.0, &mut words.1);
            (status, words.0 != 0, words.1 != 0)
        }
    }

    pub fn step(self, at: f64, h: f64) -> Status {
        if self.three { self.step3(at, h).0 } else { unsafe { fmi2DoStep(self.handle, at, h, 1) } }
    }

    /// A step of FMI 3.0: whether there is an event, whether to terminate, whether it ended early, and where.
    pub fn step3(self, at: f64, h: f64) -> (Status, [u8; 3], f64) {
        let (mut flags, mut last) = ([9; 3], f64::NAN);
        let [event, terminate, early] = flags.each_mut();
        let status = unsafe { fmi3DoStep(self.handle, at, h, 1, event, terminate, early, &mut last) };
        (status, flags, last)
    }

    /// Lets inputs run along slopes, in FMI 2.0.
    pub fn set_slopes(self, vr: &[u32], orders: &[i32], slopes: &[f64]) -> Status {
        let n = same(vr, slopes);
        unsafe { fmi2SetRealInputDerivatives(self.handle, vr.as_ptr(), n, orders.as_ptr(), slopes.as_ptr()) }
    }

    /// The number of continuous states that the instance has.
    pub fn number_of_states(self) -> usize {
        let mut number = 0;
        let count = |i: &mut Instance| {
            number = i.number_of_states();
            Ok(())
        };
        unsafe { motor_fmu::boundary::enter(self.handle, "count", count) }.ok();
        number
    }

    pub fn set_logging(self, on: bool, categories: &[&CStr]) -> Status {
        let pointers: Vec<*const c_char> = categories.iter().map(|name| name.as_ptr()).collect();
        let (n, pointers) = (pointers.len(), pointers.as_ptr());
        unsafe {
            if self.three {
                fmi3SetDebugLogging(self.handle, u8::from(on), n, pointers)
            } else {
                fmi2SetDebugLogging(self.handle, c_int::from(on), n, pointers)
            }
        }
    }

    /// The state of the instance.
    pub fn save(self) -> Saved {
        self.try_save().unwrap()
    }

    pub fn try_save(self) -> Result<Saved, Status> {
        self.made(|state| self.get_state(state))
    }

    /// A state from its bytes.
    pub fn read(self, bytes: &[u8]) -> Result<Saved, Status> {
        self.made(|state| self.deserialize(bytes, state))
    }

    fn made(self, call: impl FnOnce(&mut *mut c_void) -> Status) -> Result<Saved, Status> {
        let mut state = null_mut();
        let status = call(&mut state);
        assert_eq!(state.is_null(), status != Status::Ok);
        if state.is_null() { Err(status) } else { Ok(Saved { of: self, state }) }
    }

    pub fn restore(self, saved: &Saved) -> Status {
        self.set_state(saved.state)
    }

    /// Continues from the state of another instance, through its bytes.
    pub fn take_over(self, other: Fmu) {
        self.restore(&self.read(&other.save().bytes()).unwrap()).ok();
    }
}

/// A saved state, freed at its end.
pub struct Saved {
    of: Fmu,
    pub state: *mut c_void,
}

impl Saved {
    pub fn bytes(&self) -> Vec<u8> {
        let mut size = 0;
        self.of.state_size(self.state, &mut size).ok();
        let mut bytes = vec![0; size];
        self.of.serialize(self.state, &mut bytes).ok();
        bytes
    }
}

impl Drop for Saved {
    fn drop(&mut self) {
        self.of.free_state(&mut self.state).ok();
        assert!(self.state.is_null());
    }
}

/// What must succeed.
pub trait Succeeds {
    fn ok(self);
}

impl Succeeds for Status {
    #[track_caller]
    fn ok(self) {
        assert_eq!(self, Status::Ok);
    }
}
