//! The C functions of both standards, all of them optional: which ones an FMU must have hangs on its interface types.
use crate::fmi2::Callbacks;
use crate::functions::functions;
use crate::log::log_message;
use std::ffi::{c_char, c_int, c_uint, c_void};

pub(super) type Handle = *mut c_void;
type Text = *const c_char;
/// `fmi3GetX` of a type that is `T` in C.
pub(super) type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> c_int;
/// `fmi3SetX` of a type that is `T` in C.
pub(super) type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> c_int;
type Plain = unsafe extern "C" fn(Handle) -> c_int;
type GetReals = unsafe extern "C" fn(Handle, *mut f64, usize) -> c_int;
type LogCallback = unsafe extern "C" fn(*mut c_void, c_int, Text, Text);

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Default)]
pub(super) struct EventInfo {
    pub(super) again: c_int,
    pub(super) terminate: c_int,
    pub(super) nominals_changed: c_int,
    pub(super) values_changed: c_int,
    pub(super) next_defined: c_int,
    pub(super) next: f64,
}

functions! {
    /// The functions of FMI 2.0.
    Functions2 {
        required {}
        optional {
            version = fmi2GetVersion: fn() -> Text;
            types_platform = fmi2GetTypesPlatform: fn() -> Text;
            instantiate = fmi2Instantiate: fn(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Handle;
            free_instance = fmi2FreeInstance: fn(Handle);
            setup = fmi2SetupExperiment: fn(Handle, c_int, f64, f64, c_int, f64) -> c_int;
            enter_initialization = fmi2EnterInitializationMode: fn(Handle) -> c_int;
            exit_initialization = fmi2ExitInitializationMode: fn(Handle) -> c_int;
            terminate = fmi2Terminate: fn(Handle) -> c_int;
            reset = fmi2Reset: fn(Handle) -> c_int;
            get_real = fmi2GetReal: fn(Handle, *const c_uint, usize, *mut f64) -> c_int;
            get_integer = fmi2GetInteger: fn(Handle, *const c_uint, usize, *mut c_int) -> c_int;
            get_boolean = fmi2GetBoolean: fn(Handle, *const c_uint, usize, *mut c_int) -> c_int;
            get_string = fmi2GetString: fn(Handle, *const c_uint, usize, *mut Text) -> c_int;
            set_real = fmi2SetReal: fn(Handle, *const c_uint, usize, *const f64) -> c_int;
            set_integer = fmi2SetInteger: fn(Handle, *const c_uint, usize, *const c_int) -> c_int;
            set_boolean = fmi2SetBoolean: fn(Handle, *const c_uint, usize, *const c_int) -> c_int;
            set_string = fmi2SetString: fn(Handle, *const c_uint, usize, *const Text) -> c_int;
            get_state = fmi2GetFMUstate: fn(Handle, *mut *mut c_void) -> c_int;
            set_state = fmi2SetFMUstate: fn(Handle, *mut c_void) -> c_int;
            free_state = fmi2FreeFMUstate: fn(Handle, *mut *mut c_void) -> c_int;
            state_size = fmi2SerializedFMUstateSize: fn(Handle, *mut c_void, *mut usize) -> c_int;
            serialize = fmi2SerializeFMUstate: fn(Handle, *mut c_void, *mut u8, usize) -> c_int;
            deserialize = fmi2DeSerializeFMUstate: fn(Handle, *const u8, usize, *mut *mut c_void) -> c_int;
            directional = fmi2GetDirectionalDerivative: fn(Handle, *const c_uint, usize, *const c_uint, usize, *const f64, *mut f64) -> c_int;
            enter_event = fmi2EnterEventMode: fn(Handle) -> c_int;
            new_discrete_states = fmi2NewDiscreteStates: fn(Handle, *mut EventInfo) -> c_int;
            enter_continuous = fmi2EnterContinuousTimeMode: fn(Handle) -> c_int;
            completed_step = fmi2CompletedIntegratorStep: fn(Handle, c_int, *mut c_int, *mut c_int) -> c_int;
            set_time = fmi2SetTime: fn(Handle, f64) -> c_int;
            set_states = fmi2SetContinuousStates: fn(Handle, *const f64, usize) -> c_int;
            get_derivatives = fmi2GetDerivatives: fn(Handle, *mut f64, usize) -> c_int;
            get_indicators = fmi2GetEventIndicators: fn(Handle, *mut f64, usize) -> c_int;
            get_states = fmi2GetContinuousStates: fn(Handle, *mut f64, usize) -> c_int;
            get_nominals = fmi2GetNominalsOfContinuousStates: fn(Handle, *mut f64, usize) -> c_int;
            set_input_derivatives = fmi2SetRealInputDerivatives: fn(Handle, *const c_uint, usize, *const c_int, *const f64) -> c_int;
            get_output_derivatives = fmi2GetRealOutputDerivatives: fn(Handle, *const c_uint, usize, *const c_int, *mut f64) -> c_int;
            do_step = fmi2DoStep: fn(Handle, f64, f64, c_int) -> c_int;
            get_boolean_status = fmi2GetBooleanStatus: fn(Handle, c_int, *mut c_int) -> c_int;
        }
    }
}

functions! {
    /// The functions of FMI 3.0. C's bool is a byte here, so that a careless FMU cannot create an invalid Rust bool.
    Functions3 {
        required {}
        optional {
            version = fmi3GetVersion: fn() -> Text;
            co_simulation = fmi3InstantiateCoSimulation: fn(Text, Text, Text, bool, bool, bool, bool, *const u32, usize, *mut c_void, LogCallback, *const c_void) -> Handle;
            model_exchange = fmi3InstantiateModelExchange: fn(Text, Text, Text, bool, bool, *mut c_void, LogCallback) -> Handle;
            scheduled = fmi3InstantiateScheduledExecution: fn(Text, Text, Text, bool, bool, *mut c_void, LogCallback, *const c_void, *const c_void, *const c_void) -> Handle;
            free_instance = fmi3FreeInstance: fn(Handle);
            enter_initialization = fmi3EnterInitializationMode: fn(Handle, bool, f64, f64, bool, f64) -> c_int;
            exit_initialization = fmi3ExitInitializationMode: fn(Handle) -> c_int;
            enter_event = fmi3EnterEventMode: fn(Handle) -> c_int;
            terminate = fmi3Terminate: fn(Handle) -> c_int;
            reset = fmi3Reset: fn(Handle) -> c_int;
            get_f64 = fmi3GetFloat64: fn(Handle, *const u32, usize, *mut f64, usize) -> c_int;
            get_f32 = fmi3GetFloat32: fn(Handle, *const u32, usize, *mut f32, usize) -> c_int;
            get_i8 = fmi3GetInt8: fn(Handle, *const u32, usize, *mut i8, usize) -> c_int;
            get_u8 = fmi3GetUInt8: fn(Handle, *const u32, usize, *mut u8, usize) -> c_int;
            get_i16 = fmi3GetInt16: fn(Handle, *const u32, usize, *mut i16, usize) -> c_int;
            get_u16 = fmi3GetUInt16: fn(Handle, *const u32, usize, *mut u16, usize) -> c_int;
            get_i32 = fmi3GetInt32: fn(Handle, *const u32, usize, *mut i32, usize) -> c_int;
            get_u32 = fmi3GetUInt32: fn(Handle, *const u32, usize, *mut u32, usize) -> c_int;
            get_i64 = fmi3GetInt64: fn(Handle, *const u32, usize, *mut i64, usize) -> c_int;
            get_u64 = fmi3GetUInt64: fn(Handle, *const u32, usize, *mut u64, usize) -> c_int;
            get_bool = fmi3GetBoolean: fn(Handle, *const u32, usize, *mut u8, usize) -> c_int;
            get_string = fmi3GetString: fn(Handle, *const u32, usize, *mut Text, usize) -> c_int;
            set_f64 = fmi3SetFloat64: fn(Handle, *const u32, usize, *const f64, usize) -> c_int;
            set_f32 = fmi3SetFloat32: fn(Handle, *const u32, usize, *const f32, usize) -> c_int;
            set_i8 = fmi3SetInt8: fn(Handle, *const u32, usize, *const i8, usize) -> c_int;
            set_u8 = fmi3SetUInt8: fn(Handle, *const u32, usize, *const u8, usize) -> c_int;
            set_i16 = fmi3SetInt16: fn(Handle, *const u32, usize, *const i16, usize) -> c_int;
            set_u16 = fmi3SetUInt16: fn(Handle, *const u32, usize, *const u16, usize) -> c_int;
            set_i32 = fmi3SetInt32: fn(Handle, *const u32, usize, *const i32, usize) -> c_int;
            set_u32 = fmi3SetUInt32: fn(Handle, *const u32, usize, *const u32, usize) -> c_int;
            set_i64 = fmi3SetInt64: fn(Handle, *const u32, usize, *const i64, usize) -> c_int;
            set_u64 = fmi3SetUInt64: fn(Handle, *const u32, usize, *const u64, usize) -> c_int;
            set_bool = fmi3SetBoolean: fn(Handle, *const u32, usize, *const u8, usize) -> c_int;
            set_string = fmi3SetString: fn(Handle, *const u32, usize, *const Text, usize) -> c_int;
            get_state = fmi3GetFMUState: fn(Handle, *mut *mut c_void) -> c_int;
            set_state = fmi3SetFMUState: fn(Handle, *mut c_void) -> c_int;
            free_state = fmi3FreeFMUState: fn(Handle, *mut *mut c_void) -> c_int;
            state_size = fmi3SerializedFMUStateSize: fn(Handle, *mut c_void, *mut usize) -> c_int;
            serialize = fmi3SerializeFMUState: fn(Handle, *mut c_void, *mut u8, usize) -> c_int;
            deserialize = fmi3DeserializeFMUState: fn(Handle, *const u8, usize, *mut *mut c_void) -> c_int;
            directional = fmi3GetDirectionalDerivative: fn(Handle, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            adjoint = fmi3GetAdjointDerivative: fn(Handle, *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize) -> c_int;
            update_discrete = fmi3UpdateDiscreteStates: fn(Handle, *mut u8, *mut u8, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
            enter_continuous = fmi3EnterContinuousTimeMode: fn(Handle) -> c_int;
            completed_step = fmi3CompletedIntegratorStep: fn(Handle, bool, *mut u8, *mut u8) -> c_int;
            set_time = fmi3SetTime: fn(Handle, f64) -> c_int;
            set_states = fmi3SetContinuousStates: fn(Handle, *const f64, usize) -> c_int;
            get_derivatives = fmi3GetContinuousStateDerivatives: fn(Handle, *mut f64, usize) -> c_int;
            get_indicators = fmi3GetEventIndicators: fn(Handle, *mut f64, usize) -> c_int;
            get_states = fmi3GetContinuousStates: fn(Handle, *mut f64, usize) -> c_int;
            get_nominals = fmi3GetNominalsOfContinuousStates: fn(Handle, *mut f64, usize) -> c_int;
            number_of_states = fmi3GetNumberOfContinuousStates: fn(Handle, *mut usize) -> c_int;
            number_of_indicators = fmi3GetNumberOfEventIndicators: fn(Handle, *mut usize) -> c_int;
            enter_step_mode = fmi3EnterStepMode: fn(Handle) -> c_int;
            get_output_derivatives = fmi3GetOutputDerivatives: fn(Handle, *const u32, usize, *const i32, *mut f64, usize) -> c_int;
            do_step = fmi3DoStep: fn(Handle, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
            activate_partition = fmi3ActivateModelPartition: fn(Handle, u32, f64) -> c_int;
        }
    }
}

/// The functions that have the same C type in both standards.
pub(super) struct Common {
    pub(super) free_instance: Option<unsafe extern "C" fn(Handle)>,
    pub(super) exit_initialization: Option<Plain>,
    pub(super) terminate: Option<Plain>,
    pub(super) reset: Option<Plain>,
    pub(super) enter_event: Option<Plain>,
    pub(super) enter_continuous: Option<Plain>,
    pub(super) set_time: Option<unsafe extern "C" fn(Handle, f64) -> c_int>,
    pub(super) set_states: Option<unsafe extern "C" fn(Handle, *const f64, usize) -> c_int>,
    pub(super) get_states: Option<GetReals>,
    pub(super) get_derivatives: Option<GetReals>,
    pub(super) get_indicators: Option<GetReals>,
    pub(super) get_nominals: Option<GetReals>,
    pub(super) get_state: Option<unsafe extern "C" fn(Handle, *mut *mut c_void) -> c_int>,
    pub(super) set_state: Option<unsafe extern "C" fn(Handle, *mut c_void) -> c_int>,
    pub(super) free_state: Option<unsafe extern "C" fn(Handle, *mut *mut c_void) -> c_int>,
    pub(super) state_size: Option<unsafe extern "C" fn(Handle, *mut c_void, *mut usize) -> c_int>,
    pub(super) serialize: Option<unsafe extern "C" fn(Handle, *mut c_void, *mut u8, usize) -> c_int>,
    pub(super) deserialize: Option<unsafe extern "C" fn(Handle, *const u8, usize, *mut *mut c_void) -> c_int>,
}

macro_rules! common {
    ($table:expr; $($field:ident)*) => { Common { $($field: $table.$field),* } };
}

macro_rules! common_of {
    ($table:expr) => {
        common!($table; free_instance exit_initialization terminate reset enter_event enter_continuous set_time set_states
            get_states get_derivatives get_indicators get_nominals get_state set_state free_state state_size serialize deserialize)
    };
}

/// The functions of one binary.
pub(super) enum Api {
    Two(Box<Functions2>),
    Three(Box<Functions3>),
}

impl Api {
    pub(super) fn common(&self) -> Common {
        match self {
            Self::Two(f) => common_of!(f),
            Self::Three(f) => common_of!(f),
        }
    }
}

/// The log callback of FMI 3.
pub(super) const LOG_MESSAGE: LogCallback = log_message;
