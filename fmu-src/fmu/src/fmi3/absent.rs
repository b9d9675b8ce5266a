//! Functions that importers resolve when they load the library and that these FMUs do not support.

use super::{Boolean, InstanceHandle};
use crate::boundary::{Instantiation, instantiate};
use crate::functions;
use crate::instance::{Interface, Part, Standard};
use crate::logger::Logger3;
use crate::refusal::Refused;
use crate::resources::of_path;
use std::ffi::{c_char, c_int, c_void};

/// Functions that return an error with a message.
macro_rules! absent {
    ($why:literal; $($(#[doc = $doc:literal])* $name:ident($($argument:ident: $type:ty),*);)*) => {
        functions! {
            enter;
            $($(#[doc = $doc])* fn $name($($argument: $type),*) => |_| Err(Refused::error($why));)*
        }
    };
}

/// Constructors that return an error with a message.
unsafe fn refuse_to_make(
    function: &'static str,
    interface: &str,
    name: *const c_char,
    environment: *mut c_void,
    log_message: Option<Logger3>,
) -> InstanceHandle {
    let unsupported = Some(format!("this FMU has no {interface}; it has Model Exchange and Co-Simulation."));
    let sink = super::sink(log_message, environment);
    // SAFETY: by the crate's documentation.
    unsafe {
        instantiate(Instantiation {
            function,
            standard: Standard::Three,
            interface: Interface::CoSimulation,
            part: Part::default(),
            name,
            token: std::ptr::null(),
            resources: std::ptr::null(),
            locate: of_path,
            sink,
            logging_on: false,
            unsupported,
        })
    }
}

/// Creates an instance for Scheduled Execution.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: *mut c_void,
    log_message: Option<Logger3>,
    _clock_update: Option<unsafe extern "C" fn()>,
    _lock: Option<unsafe extern "C" fn()>,
    _unlock: Option<unsafe extern "C" fn()>,
) -> InstanceHandle {
    unsafe {
        refuse_to_make(
            "fmi3InstantiateScheduledExecution",
            "Scheduled Execution",
            name,
            environment,
            log_message,
        )
    }
}

absent! {
    "dependencies of array elements are not provided (providesPerElementDependencies is false).";
    /// Get number of variable dependencies.
    fmi3GetNumberOfVariableDependencies(_vr: u32, _n: *mut usize);
    /// Get variable dependencies.
    fmi3GetVariableDependencies(
        _dependent: u32, _elements: *mut usize, _independents: *mut u32, _independent_elements: *mut usize,
        _kinds: *mut c_int, _n: usize
    );
}

absent! {
    "this FMU has no clocks.";
    /// Get interval decimal.
    fmi3GetIntervalDecimal(_vr: *const u32, _n: usize, _intervals: *mut f64, _qualifiers: *mut c_int);
    /// Get interval fraction.
    fmi3GetIntervalFraction(
        _vr: *const u32, _n: usize, _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut c_int
    );
    /// Get shift decimal.
    fmi3GetShiftDecimal(_vr: *const u32, _n: usize, _shifts: *mut f64);
    /// Get shift fraction.
    fmi3GetShiftFraction(_vr: *const u32, _n: usize, _counters: *mut u64, _resolutions: *mut u64);
    /// Set interval decimal.
    fmi3SetIntervalDecimal(_vr: *const u32, _n: usize, _intervals: *const f64);
    /// Set interval fraction.
    fmi3SetIntervalFraction(_vr: *const u32, _n: usize, _counters: *const u64, _resolutions: *const u64);
    /// Set shift decimal.
    fmi3SetShiftDecimal(_vr: *const u32, _n: usize, _shifts: *const f64);
    /// Set shift fraction.
    fmi3SetShiftFraction(_vr: *const u32, _n: usize, _counters: *const u64, _resolutions: *const u64);
    /// Activate model partition.
    fmi3ActivateModelPartition(_clock: u32, _time: f64);
}
