//! FMI 3.0: the 75 functions. They only convert arguments; `instance.rs` decides which calls are allowed.
//!
//! Arguments are as in the standard, "Functional Mock-up Interface Specification", version 3.0.2.
//! `fmi3/values.rs` has the getters and setters, `fmi3/stepping.rs` Co-Simulation, `fmi3/exchange.rs` Model Exchange and events,
//! `fmi3/slopes.rs` derivatives, `fmi3/absent.rs` functions that these models do not support: clocks, intervals, dependencies of
//! array elements.

mod absent;
mod exchange;
mod slopes;
mod stepping;
mod values;

pub use absent::*;
pub use exchange::*;
pub use slopes::*;
pub use stepping::*;
pub use values::*;

use crate::boundary::{free_instance, set_logging};
use crate::functions;
use crate::instance::Instance;
use crate::logger::{Logger3, Sink, Status};
use crate::saved_handle;
use std::ffi::{c_char, c_void};

/// Handle of an instance.
pub type InstanceHandle = *mut c_void;
/// Handle of a saved state.
pub type FmuState = *mut c_void;
/// `fmi3Boolean`, C's bool, read as a byte: C may pass a value that is invalid for a Rust bool.
pub type Boolean = u8;

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Enables or disables messages.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: InstanceHandle,
    on: Boolean,
    n: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: by the crate's documentation; also for every block below.
    unsafe { set_logging(instance, "fmi3SetDebugLogging", on != 0, n, categories) }
}

/// The sink of an optional logger.
fn sink(log_message: Option<Logger3>, environment: *mut c_void) -> Sink {
    log_message.map_or(Sink::None, |logger| Sink::Fmi3(logger, environment))
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: InstanceHandle) {
    unsafe { free_instance(instance, "fmi3FreeInstance") }
}

functions! {
    enter;
    /// Sets tolerance, start and stop time, and enters initialization mode.
    fn fmi3EnterInitializationMode(
        tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64
    ) => |i| {
        i.set_tolerance((tolerance_defined != 0).then_some(tolerance))?;
        i.set_window(start, (stop_defined != 0).then_some(stop))?;
        i.enter_initialization()
    };
    /// Enters configuration mode, in which array sizes are set.
    fn fmi3EnterConfigurationMode() => Instance::enter_configuration;
    /// Exits configuration mode.
    fn fmi3ExitConfigurationMode() => Instance::exit_configuration;
    /// Exits initialization mode.
    fn fmi3ExitInitializationMode() => Instance::exit_initialization;
    /// Terminates the run.
    fn fmi3Terminate() => Instance::terminate;
    /// Resets to the state after instantiation.
    fn fmi3Reset() => Instance::reset;
    /// Saves the instance. An existing handle is reused.
    fn fmi3GetFMUState(state: *mut FmuState) => |i| saved_handle::save(i, state);
    /// Restores the instance.
    fn fmi3SetFMUState(state: FmuState) => |i| i.restore(state);
    /// Frees a saved state.
    fn fmi3FreeFMUState(state: *mut FmuState) => |i| saved_handle::free(i, state);
    /// Size of a serialized state in bytes.
    fn fmi3SerializedFMUStateSize(state: FmuState, size: *mut usize) =>
        |i| saved_handle::serialized_size(i, state, size);
    /// Serializes a saved state.
    fn fmi3SerializeFMUState(state: FmuState, bytes: *mut u8, n: usize) =>
        |i| saved_handle::serialize(i, state, bytes, n);
    /// Deserializes a saved state.
    fn fmi3DeserializeFMUState(bytes: *const u8, n: usize, state: *mut FmuState) =>
        |i| saved_handle::deserialize(i, bytes, n, state);
}
