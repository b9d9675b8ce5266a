//! FMI 2.0: the 44 functions. They only convert arguments; `instance.rs` decides which calls are allowed.
//!
//! Arguments are as in the standard, "Functional Mock-up Interface for Model Exchange and Co-Simulation",
//! version 2.0.4; each function's documentation names its section.

mod exchange;

pub use exchange::*;

use crate::boundary::{self, Instantiation, Out, array, enter, free_instance, instantiate, set_logging};
use crate::functions;
use crate::instance::{Instance, Interface, Part, Standard, Type};
use crate::logger::{Logger2, Sink, Status};
use crate::refusal::{Outcome, Refused};
use crate::resources::of_uri;
use crate::saved_handle::{deserialize, free, save, serialize, serialized_size};
use std::ffi::{c_char, c_int, c_void};

/// Handle of an instance.
pub type Component = *mut c_void;
/// Handle of a saved state.
pub type FmuState = *mut c_void;
/// `fmi2Boolean`: zero is false.
pub type Boolean = c_int;

/// Callback functions of the importer.
#[repr(C)]
pub struct CallbackFunctions {
    /// Logger.
    pub logger: Option<Logger2>,
    /// Unused: this library uses its own allocator.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Unused.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Unused: steps are synchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Argument of the logger.
    pub environment: *mut c_void,
}

/// `fmi2Type`: `fmi2ModelExchange`.
const MODEL_EXCHANGE: c_int = 0;
/// `fmi2Type`: `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;
/// `fmi2StatusKind`: time of the last successful step.
const PENDING_STATUS: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2StatusKind`: whether the model requests the end of the simulation.
const TERMINATED: c_int = 3;

fn nothing_pending(i: &Instance) -> Outcome {
    i.require_stepping()?;
    Err(Refused::discard("steps are synchronous; no step is pending."))
}

/// Platform of the header files; section 2.1.3.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of the standard; section 2.1.4.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Enables or disables messages; section 2.1.5.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: Component,
    on: Boolean,
    n: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: by the crate's documentation; also for every block below.
    unsafe { set_logging(c, "fmi2SetDebugLogging", on != 0, n, categories) }
}

/// Creates an instance; section 2.1.5.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    interface: c_int,
    guid: *const c_char,
    resources: *const c_char,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Component {
    unsafe {
        let sink = match functions.as_ref() {
            Some(CallbackFunctions { logger: Some(logger), environment, .. }) => {
                Sink::Fmi2(*logger, *environment)
            }
            _ => Sink::None,
        };
        let (known, unsupported) = match interface {
            MODEL_EXCHANGE => (Interface::ModelExchange, None),
            CO_SIMULATION => (Interface::CoSimulation, None),
            other => (
                Interface::CoSimulation,
                Some(format!(
                    "the interface type {other} is neither 0, Model Exchange, nor 1, Co-Simulation."
                )),
            ),
        };
        let logging_on = logging_on != 0;
        instantiate(Instantiation {
            function: "fmi2Instantiate",
            standard: Standard::Two,
            interface: known,
            part: Part::default(),
            name,
            token: guid,
            resources,
            locate: of_uri,
            sink,
            logging_on,
            unsupported,
        })
    }
}

/// Frees an instance; section 2.1.5.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Component) {
    unsafe { free_instance(c, "fmi2FreeInstance") }
}

functions! {
    enter;
    /// Sets tolerance, start and stop time; section 2.1.6.
    fn fmi2SetupExperiment(
        tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64
    ) => |i| {
        i.set_tolerance((tolerance_defined != 0).then_some(tolerance))?;
        i.set_window(start, (stop_defined != 0).then_some(stop))
    };
    /// Enters initialization mode; section 2.1.6.
    fn fmi2EnterInitializationMode() => Instance::enter_initialization;
    /// Exits initialization mode; section 2.1.6.
    fn fmi2ExitInitializationMode() => Instance::exit_initialization;
    /// Terminates the run; section 2.1.6.
    fn fmi2Terminate() => Instance::terminate;
    /// Resets to the state after instantiation; section 2.1.6.
    fn fmi2Reset() => Instance::reset;
}

/// Getter and setter of one type; `of` is the interface's type, `value` the C type.
macro_rules! values {
    ($($get:ident, $set:ident, $value:ty, $of:expr, $from:expr, $to:expr;)*) => {
        functions! {
            enter;
            $(/// Reads values; section 2.1.7.
            fn $get(vr: *const u32, n: usize, value: *mut $value) => |i| {
                let (vr, value) = (array(vr, n, "vr")?, Out::array(value, n, "value")?);
                i.get(vr, $of, n, |k, number| value.set(k, $from(number)))
            };
            /// Sets values, all or none; section 2.1.7.
            fn $set(vr: *const u32, n: usize, value: *const $value) => |i| {
                let (vr, value) = (array(vr, n, "vr")?, array(value, n, "value")?);
                i.set(vr, $of, n, |k| $to(value[k]))
            };)*
        }
    };
}

values! {
    fmi2GetReal, fmi2SetReal, f64, Type::Real, |x| x, |x| x;
    fmi2GetInteger, fmi2SetInteger, c_int, Type::Integer, |x| x as c_int, f64::from;
    fmi2GetBoolean, fmi2SetBoolean, Boolean, Type::Boolean, |x| c_int::from(x != 0.0), f64::from;
    fmi2GetString, fmi2SetString, *const c_char, Type::Absent("String"), |_| c"".as_ptr(), |_| f64::NAN;
}

functions! {
    enter;
    /// Saves the instance; section 2.1.8. An existing handle is reused.
    fn fmi2GetFMUstate(state: *mut FmuState) => |i| save(i, state);
    /// Restores the instance; section 2.1.8.
    fn fmi2SetFMUstate(state: FmuState) => |i| i.restore(state);
    /// Frees a saved state; section 2.1.8.
    fn fmi2FreeFMUstate(state: *mut FmuState) => |i| free(i, state);
    /// Size of a serialized state in bytes; section 2.1.8.
    fn fmi2SerializedFMUstateSize(state: FmuState, size: *mut usize) => |i| serialized_size(i, state, size);
    /// Serializes a saved state; section 2.1.8.
    fn fmi2SerializeFMUstate(state: FmuState, bytes: *mut u8, n: usize) => |i| serialize(i, state, bytes, n);
    /// Deserializes a saved state; section 2.1.8.
    fn fmi2DeSerializeFMUstate(bytes: *const u8, n: usize, state: *mut FmuState) =>
        |i| deserialize(i, bytes, n, state);
    /// Derivatives with respect to inputs, states and parameters; section 2.1.9.
    fn fmi2GetDirectionalDerivative(
        unknowns: *const u32, n_unknown: usize, knowns: *const u32, n_known: usize, seed: *const f64,
        sensitivity: *mut f64
    ) => |i| {
        let (unknowns, knowns) =
            (array(unknowns, n_unknown, "vUnknown_ref")?, array(knowns, n_known, "vKnown_ref")?);
        let (seed, out) =
            (array(seed, n_known, "dvKnown")?, Out::array(sensitivity, n_unknown, "dvUnknown")?);
        out.fill(&i.directional(unknowns, knowns, seed, n_unknown)?);
        Ok(())
    };
    /// Sets input derivatives for the next step; section 4.2.1.
    fn fmi2SetRealInputDerivatives(vr: *const u32, n: usize, order: *const c_int, value: *const f64) => |i| {
        i.set_slopes(array(vr, n, "vr")?, array(order, n, "order")?, array(value, n, "value")?)
    };
    /// First derivatives of outputs with respect to time; section 4.2.1.
    fn fmi2GetRealOutputDerivatives(vr: *const u32, n: usize, order: *const c_int, value: *mut f64) => |i| {
        let (vr, order, out) = (array(vr, n, "vr")?, array(order, n, "order")?, Out::array(value, n, "value")?);
        out.fill(&i.output_derivatives(vr, order, n)?);
        Ok(())
    };
    /// Computes a step; section 4.2.2.
    fn fmi2DoStep(at: f64, h: f64, _no_set_state_prior: Boolean) => |i| i.step(at, h);
    /// Cancels a pending step; section 4.2.2. Always an error: steps are synchronous.
    fn fmi2CancelStep() => |_| {
        Err(Refused::error("steps are synchronous, so none can be cancelled."))
    };
    /// Status of a pending step; section 4.2.3.
    fn fmi2GetStatus(_kind: c_int, _value: *mut Status) => |i| nothing_pending(i);
    /// Time of the last successful step; section 4.2.3.
    fn fmi2GetRealStatus(kind: c_int, value: *mut f64) => |i| {
        if kind != LAST_SUCCESSFUL_TIME {
            return nothing_pending(i);
        }
        i.require_stepping()?;
        Out::variable(value, "value")?.set(0, i.time());
        Ok(())
    };
    /// Integer status; section 4.2.3. None is defined.
    fn fmi2GetIntegerStatus(_kind: c_int, _value: *mut c_int) => |i| nothing_pending(i);
    /// Whether the model requests the end of the simulation (at a limit of validity); section 4.2.3.
    fn fmi2GetBooleanStatus(kind: c_int, value: *mut Boolean) => |i| {
        if kind != TERMINATED {
            return nothing_pending(i);
        }
        i.require_stepping()?;
        Out::variable(value, "value")?.set(0, Boolean::from(i.end().is_some()));
        Ok(())
    };
}

/// Text about a pending step, or the reason for the end of the run; section 4.2.3.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: Component, kind: c_int, value: *mut *const c_char) -> Status {
    unsafe {
        boundary::write(value, c"".as_ptr());
        enter(c, "fmi2GetStringStatus", |i| match i.end() {
            Some(reason) if kind == PENDING_STATUS => {
                boundary::write(value, reason.as_ptr());
                Ok(())
            }
            _ => nothing_pending(i),
        })
    }
}
