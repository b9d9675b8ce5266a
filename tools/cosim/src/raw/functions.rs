//! The C functions of both standards: every name and signature once, loaded from a binary in one go.
//!
//! All are optional here: which ones an FMU must have depends on its interface types.
use super::accessor::{Accessor, Handle, Text};
use crate::log::{Callbacks, LogCallback};
use crate::page::Function;
use crate::{FmiVersion, Kind};
use libloading::Library;
use std::ffi::{c_int, c_void};

#[repr(C)]
#[derive(Default)]
pub(crate) struct EventInfo {
    pub(super) again: c_int,
    pub(super) terminate: c_int,
    pub(super) nominals_changed: c_int,
    pub(super) values_changed: c_int,
    pub(super) next_defined: c_int,
    pub(super) next: f64,
}

/// Declares the table: `field: C type = symbol in FMI 2.0, symbol in FMI 3.0`, with `_` for no such function. What both
/// standards have with one C type is one field. Each line of `values` declares a get and a set function, with the part
/// of their names that names the type. The symbols of a field are also in `names`, for messages.
macro_rules! functions {
    (
        required { $($must:ident: fn($($must_argument:ty),* $(,)?) $(-> $must_result:ty)? = $must_two:tt, $must_three:tt;)* }
        optional { $($may:ident: fn($($may_argument:ty),* $(,)?) $(-> $may_result:ty)? = $may_two:tt, $may_three:tt;)* }
        values { $($value:ident: $c:ty = $two_of:tt, $three_of:tt;)* }
    ) => {
        /// The functions of one binary.
        pub(crate) struct Functions {
            $(pub(crate) $must: Option<unsafe extern "C" fn($($must_argument),*) $(-> $must_result)?>,)*
            $(pub(crate) $may: Option<unsafe extern "C" fn($($may_argument),*) $(-> $may_result)?>,)*
            $(pub(super) $value: Accessor<$c>,)*
        }

        impl Functions {
            /// Resolves all symbols of a standard.
            pub(super) fn load(library: &Library, version: FmiVersion) -> Self {
                // SAFETY, for all unsafe blocks below: the standards fix the type behind each name, and the library stays
                // loaded for as long as this table lives.
                Self {
                    // SAFETY: see above.
                    $($must: unsafe { find(library, version, stringify!($must_two), stringify!($must_three)) },)*
                    // SAFETY: see above.
                    $($may: unsafe { find(library, version, stringify!($may_two), stringify!($may_three)) },)*
                    $($value: match version {
                        // SAFETY: see above.
                        FmiVersion::V2 => unsafe {
                            Accessor::Fmi2 {
                                get: symbol(library, concat!("fmi2Get", $two_of)),
                                set: symbol(library, concat!("fmi2Set", $two_of)),
                            }
                        },
                        // SAFETY: see above.
                        FmiVersion::V3 => unsafe {
                            Accessor::Fmi3 {
                                get: symbol(library, concat!("fmi3Get", $three_of)),
                                set: symbol(library, concat!("fmi3Set", $three_of)),
                            }
                        },
                    },)*
                }
            }

            /// The first function that every Co-Simulation FMU must have and this binary lacks.
            pub(super) fn missing(&self, version: FmiVersion) -> Option<&'static str> {
                let pick = |[two, three]: [&'static str; 2]| if version == FmiVersion::V2 { two } else { three };
                $(if self.$must.is_none() && pick(names::$must) != "_" {
                    return Some(pick(names::$must));
                })*
                $(if !pick([$two_of, $three_of]).is_empty() {
                    let (has_get, has_set) = self.$value.has();
                    if !has_get {
                        return Some(pick([concat!("fmi2Get", $two_of), concat!("fmi3Get", $three_of)]));
                    }
                    if !has_set {
                        return Some(pick([concat!("fmi2Set", $two_of), concat!("fmi3Set", $three_of)]));
                    }
                })*
                None
            }
        }

        /// The symbols of each field in FMI 2.0 and 3.0.
        #[allow(non_upper_case_globals, dead_code)]
        pub(crate) mod names {
            $(pub(crate) const $must: [&str; 2] = [stringify!($must_two), stringify!($must_three)];)*
            $(pub(crate) const $may: [&str; 2] = [stringify!($may_two), stringify!($may_three)];)*
        }

        /// The places of the fields; values have theirs behind them, two for each kind.
        #[allow(non_camel_case_types, dead_code)]
        enum Place { $($must,)* $($may,)* Values }

        /// The numbers of the functions for the page that parent and child share.
        #[allow(non_upper_case_globals, dead_code)]
        pub(crate) mod ids {
            use super::{Function, Place};
            $(pub(crate) const $must: Function = Function(Function::FIRST + Place::$must as u16);)*
            $(pub(crate) const $may: Function = Function(Function::FIRST + Place::$may as u16);)*
        }

        const NAMES: &[[&str; 2]] = &[$(names::$must,)* $(names::$may,)*];
    };
}

/// The number of the get or set function of a kind.
pub(crate) const fn value_id(is_set: bool, kind: Kind) -> Function {
    Function(Function::FIRST + Place::Values as u16 + 2 * kind as u16 + is_set as u16)
}

/// The name of the function at a place, counted from [`Function::FIRST`].
pub(crate) fn function_name(place: u16, version: FmiVersion) -> &'static str {
    let of_value = || {
        let place = place.checked_sub(Place::Values as u16)?;
        let kind = Kind::ALL.get(usize::from(place / 2))?;
        Some(value_names(place % 2 == 1, *kind))
    };
    let names = NAMES.get(usize::from(place)).copied().or_else(of_value);
    names.map_or("a function", |names| names[usize::from(version == FmiVersion::V3)])
}

/// The names of the get or set function of a kind in both standards.
pub(crate) const fn value_names(is_set: bool, kind: Kind) -> [&'static str; 2] {
    macro_rules! both {
        ($two:literal, $three:literal) => {
            if is_set {
                [concat!("fmi2Set", $two), concat!("fmi3Set", $three)]
            } else {
                [concat!("fmi2Get", $two), concat!("fmi3Get", $three)]
            }
        };
    }
    match kind {
        Kind::Float64 => both!("Real", "Float64"),
        Kind::Float32 => both!("Real", "Float32"),
        Kind::Int8 => both!("Integer", "Int8"),
        Kind::UInt8 => both!("Integer", "UInt8"),
        Kind::Int16 => both!("Integer", "Int16"),
        Kind::UInt16 => both!("Integer", "UInt16"),
        Kind::Int32 => both!("Integer", "Int32"),
        Kind::UInt32 => both!("Integer", "UInt32"),
        Kind::Int64 | Kind::Enumeration => both!("Integer", "Int64"),
        Kind::UInt64 => both!("Integer", "UInt64"),
        Kind::Boolean => both!("Boolean", "Boolean"),
        Kind::String => both!("String", "String"),
        Kind::Binary => both!("Binary", "Binary"),
        Kind::Clock => both!("Clock", "Clock"),
    }
}

/// A symbol of the binary.
///
/// # Safety
/// `F` is the type of the function called `name`, and is not called after the library has been unloaded.
unsafe fn symbol<F: Copy>(library: &Library, name: &str) -> Option<F> {
    // SAFETY: the caller's promise.
    unsafe { library.get(name) }.ok().map(|symbol| *symbol)
}

/// The symbol that the version of the standard has; `_` stands for none.
///
/// # Safety
/// As [`symbol`].
unsafe fn find<F: Copy>(library: &Library, version: FmiVersion, two: &str, three: &str) -> Option<F> {
    let name = if version == FmiVersion::V2 { two } else { three };
    // SAFETY: the caller's promise.
    if name == "_" { None } else { unsafe { symbol(library, name) } }
}

// C's bool is read as a byte, so that a careless FMU cannot create an invalid Rust bool.
functions! {
    required {
        instantiate: fn(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Handle = fmi2Instantiate, _;
        co_simulation: fn(Text, Text, Text, bool, bool, bool, bool, *const u32, usize, *mut c_void, LogCallback, *const c_void) -> Handle = _, fmi3InstantiateCoSimulation;
        free_instance: fn(Handle) = fmi2FreeInstance, fmi3FreeInstance;
        setup: fn(Handle, c_int, f64, f64, c_int, f64) -> c_int = fmi2SetupExperiment, _;
        enter_initialization2: fn(Handle) -> c_int = fmi2EnterInitializationMode, _;
        enter_initialization3: fn(Handle, bool, f64, f64, bool, f64) -> c_int = _, fmi3EnterInitializationMode;
        exit_initialization: fn(Handle) -> c_int = fmi2ExitInitializationMode, fmi3ExitInitializationMode;
        terminate: fn(Handle) -> c_int = fmi2Terminate, fmi3Terminate;
        reset: fn(Handle) -> c_int = fmi2Reset, fmi3Reset;
        do_step2: fn(Handle, f64, f64, c_int) -> c_int = fmi2DoStep, _;
        do_step3: fn(Handle, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int = _, fmi3DoStep;
    }
    optional {
        version: fn() -> Text = fmi2GetVersion, fmi3GetVersion;
        types_platform: fn() -> Text = fmi2GetTypesPlatform, _;
        set_logging2: fn(Handle, c_int, usize, *const Text) -> c_int = fmi2SetDebugLogging, _;
        set_logging3: fn(Handle, bool, usize, *const Text) -> c_int = _, fmi3SetDebugLogging;
        model_exchange: fn(Text, Text, Text, bool, bool, *mut c_void, LogCallback) -> Handle = _, fmi3InstantiateModelExchange;
        scheduled: fn(Text, Text, Text, bool, bool, *mut c_void, LogCallback, *const c_void, *const c_void, *const c_void) -> Handle = _, fmi3InstantiateScheduledExecution;
        enter_configuration: fn(Handle) -> c_int = _, fmi3EnterConfigurationMode;
        exit_configuration: fn(Handle) -> c_int = _, fmi3ExitConfigurationMode;
        get_state: fn(Handle, *mut *mut c_void) -> c_int = fmi2GetFMUstate, fmi3GetFMUState;
        set_state: fn(Handle, *mut c_void) -> c_int = fmi2SetFMUstate, fmi3SetFMUState;
        free_state: fn(Handle, *mut *mut c_void) -> c_int = fmi2FreeFMUstate, fmi3FreeFMUState;
        state_size: fn(Handle, *mut c_void, *mut usize) -> c_int = fmi2SerializedFMUstateSize, fmi3SerializedFMUStateSize;
        serialize: fn(Handle, *mut c_void, *mut u8, usize) -> c_int = fmi2SerializeFMUstate, fmi3SerializeFMUState;
        deserialize: fn(Handle, *const u8, usize, *mut *mut c_void) -> c_int = fmi2DeSerializeFMUstate, fmi3DeserializeFMUState;
        directional2: fn(Handle, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> c_int = fmi2GetDirectionalDerivative, _;
        directional3: fn(Handle, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int = _, fmi3GetDirectionalDerivative;
        adjoint: fn(Handle, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int = _, fmi3GetAdjointDerivative;
        enter_event: fn(Handle) -> c_int = fmi2EnterEventMode, fmi3EnterEventMode;
        new_discrete_states: fn(Handle, *mut EventInfo) -> c_int = fmi2NewDiscreteStates, _;
        update_discrete_states: fn(Handle, *mut u8, *mut u8, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int = _, fmi3UpdateDiscreteStates;
        enter_continuous: fn(Handle) -> c_int = fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode;
        completed_step2: fn(Handle, c_int, *mut c_int, *mut c_int) -> c_int = fmi2CompletedIntegratorStep, _;
        completed_step3: fn(Handle, bool, *mut u8, *mut u8) -> c_int = _, fmi3CompletedIntegratorStep;
        set_time: fn(Handle, f64) -> c_int = fmi2SetTime, fmi3SetTime;
        set_states: fn(Handle, *const f64, usize) -> c_int = fmi2SetContinuousStates, fmi3SetContinuousStates;
        get_states: fn(Handle, *mut f64, usize) -> c_int = fmi2GetContinuousStates, fmi3GetContinuousStates;
        get_derivatives: fn(Handle, *mut f64, usize) -> c_int = fmi2GetDerivatives, fmi3GetContinuousStateDerivatives;
        get_indicators: fn(Handle, *mut f64, usize) -> c_int = fmi2GetEventIndicators, fmi3GetEventIndicators;
        get_nominals: fn(Handle, *mut f64, usize) -> c_int = fmi2GetNominalsOfContinuousStates, fmi3GetNominalsOfContinuousStates;
        number_of_states: fn(Handle, *mut usize) -> c_int = _, fmi3GetNumberOfContinuousStates;
        number_of_indicators: fn(Handle, *mut usize) -> c_int = _, fmi3GetNumberOfEventIndicators;
        set_input_derivatives: fn(Handle, *const u32, usize, *const c_int, *const f64) -> c_int = fmi2SetRealInputDerivatives, _;
        output_derivatives2: fn(Handle, *const u32, usize, *const c_int, *mut f64) -> c_int = fmi2GetRealOutputDerivatives, _;
        output_derivatives3: fn(Handle, *const u32, usize, *const i32, *mut f64, usize) -> c_int = _, fmi3GetOutputDerivatives;
        enter_step_mode: fn(Handle) -> c_int = _, fmi3EnterStepMode;
        get_binary: fn(Handle, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int = _, fmi3GetBinary;
        set_binary: fn(Handle, *const u32, usize, *const usize, *const *const u8, usize) -> c_int = _, fmi3SetBinary;
        set_clock: fn(Handle, *const u32, usize, *const bool) -> c_int = _, fmi3SetClock;
        get_interval: fn(Handle, *const u32, usize, *mut f64, *mut c_int) -> c_int = _, fmi3GetIntervalDecimal;
        get_shift: fn(Handle, *const u32, usize, *mut f64) -> c_int = _, fmi3GetShiftDecimal;
        get_boolean_status: fn(Handle, c_int, *mut c_int) -> c_int = fmi2GetBooleanStatus, _;
        activate_partition: fn(Handle, u32, f64) -> c_int = _, fmi3ActivateModelPartition;
    }
    values {
        float64: f64 = "Real", "Float64";
        float32: f32 = "", "Float32";
        int8: i8 = "", "Int8";
        uint8: u8 = "", "UInt8";
        int16: i16 = "", "Int16";
        uint16: u16 = "", "UInt16";
        int32: i32 = "Integer", "Int32";
        uint32: u32 = "", "UInt32";
        int64: i64 = "", "Int64";
        uint64: u64 = "", "UInt64";
        boolean2: c_int = "Boolean", "";
        boolean3: u8 = "", "Boolean";
        string: Text = "String", "String";
    }
}
