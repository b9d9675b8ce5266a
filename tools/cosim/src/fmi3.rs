//! FMI 3.0 Co-Simulation: the C types, and each call as a thin method that returns the C status.
use crate::Kind;
use crate::fmi2::c_string;
use crate::functions::functions;
use crate::instance::{Setup, convert_get, convert_set};
use crate::log::{Log, log_message, text_of};
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;

type Handle = *mut c_void;
type State = *mut c_void;
type LogCallback = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// `fmi3GetX` of a type that is `T` in C.
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> c_int;
/// `fmi3SetX` of a type that is `T` in C.
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> c_int;

functions! {
    /// The functions of FMI 3.0 that a Co-Simulation master calls. C's bool is read as a byte, so that a careless
    /// FMU cannot create an invalid Rust bool.
    Functions {
        required {
            instantiate = fmi3InstantiateCoSimulation: fn(*const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const u32, usize, *mut c_void, LogCallback, *const c_void) -> Handle;
            free_instance = fmi3FreeInstance: fn(Handle);
            enter_initialization = fmi3EnterInitializationMode: fn(Handle, bool, f64, f64, bool, f64) -> c_int;
            exit_initialization = fmi3ExitInitializationMode: fn(Handle) -> c_int;
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
            get_string = fmi3GetString: fn(Handle, *const u32, usize, *mut *const c_char, usize) -> c_int;
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
            set_string = fmi3SetString: fn(Handle, *const u32, usize, *const *const c_char, usize) -> c_int;
            do_step = fmi3DoStep: fn(Handle, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
        }
        optional {
            enter_configuration = fmi3EnterConfigurationMode: fn(Handle) -> c_int;
            exit_configuration = fmi3ExitConfigurationMode: fn(Handle) -> c_int;
            get_state = fmi3GetFMUState: fn(Handle, *mut State) -> c_int;
            set_state = fmi3SetFMUState: fn(Handle, State) -> c_int;
            free_state = fmi3FreeFMUState: fn(Handle, *mut State) -> c_int;
            state_size = fmi3SerializedFMUStateSize: fn(Handle, State, *mut usize) -> c_int;
            serialize_state = fmi3SerializeFMUState: fn(Handle, State, *mut u8, usize) -> c_int;
            deserialize_state = fmi3DeserializeFMUState: fn(Handle, *const u8, usize, *mut State) -> c_int;
        }
    }
}

/// An instance of an FMI 3.0 FMU.
///
/// Safety of all methods: `handle` came from `fmi3InstantiateCoSimulation` and is not freed, the function pointers
/// belong to the loaded library, slices are as long as the counts passed with them, and `Instance` sees to it that
/// nothing is called after Fatal.
pub(crate) struct Fmi3 {
    pub(crate) functions: Functions,
    handle: Handle,
}

impl Fmi3 {
    /// `Ok(None)` if the FMU refuses, `Err` with the name of a missing function.
    pub(crate) fn instantiate(
        library: &Library,
        setup: &Setup,
        log: &Log,
    ) -> Result<Option<Self>, &'static str> {
        let functions = Functions::load(library)?;
        let resources = setup.dir.join("resources");
        // The standard wants a trailing separator, and NULL if there is no such directory.
        let separator = std::path::MAIN_SEPARATOR;
        let resources = resources.is_dir().then(|| c_string(&format!("{}{separator}", resources.display())));
        // SAFETY: all strings are C strings that outlive the call; the environment outlives the instance.
        let handle = unsafe {
            (functions.instantiate)(
                setup.name.as_ptr(),
                setup.token.as_ptr(),
                resources.as_ref().map_or(ptr::null(), |r| r.as_ptr()),
                false,
                log.debug(),
                false,
                false,
                ptr::null(),
                0,
                log.environment(),
                log_message,
                ptr::null(),
            )
        };
        Ok((!handle.is_null()).then_some(Self { functions, handle }))
    }

    pub(crate) fn enter_configuration(&mut self) -> Option<c_int> {
        // SAFETY: see the type.
        self.functions.enter_configuration.map(|f| unsafe { f(self.handle) })
    }

    pub(crate) fn exit_configuration(&mut self) -> Option<c_int> {
        // SAFETY: see the type.
        self.functions.exit_configuration.map(|f| unsafe { f(self.handle) })
    }

    pub(crate) fn enter_initialization(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> c_int {
        // SAFETY: see the type.
        unsafe {
            (self.functions.enter_initialization)(
                self.handle,
                tolerance.is_some(),
                tolerance.unwrap_or(0.0),
                start,
                stop.is_some(),
                stop.unwrap_or(0.0),
            )
        }
    }

    pub(crate) fn exit_initialization(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.exit_initialization)(self.handle) }
    }

    pub(crate) fn terminate(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.terminate)(self.handle) }
    }

    pub(crate) fn reset(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.reset)(self.handle) }
    }

    pub(crate) fn get_f64(&mut self, vrs: &[u32], values: &mut [f64]) -> c_int {
        // SAFETY: see the type.
        unsafe {
            (self.functions.get_f64)(self.handle, vrs.as_ptr(), vrs.len(), values.as_mut_ptr(), values.len())
        }
    }

    pub(crate) fn set_f64(&mut self, vrs: &[u32], values: &[f64]) -> c_int {
        // SAFETY: see the type.
        unsafe {
            (self.functions.set_f64)(self.handle, vrs.as_ptr(), vrs.len(), values.as_ptr(), values.len())
        }
    }

    pub(crate) fn get_f32(&mut self, vrs: &[u32], values: &mut [f64]) -> c_int {
        self.get(self.functions.get_f32, vrs, values, f64::from)
    }

    pub(crate) fn set_f32(&mut self, vrs: &[u32], values: &[f64]) -> c_int {
        self.set(self.functions.set_f32, vrs, values, |x| x as f32)
    }

    /// Integers and enumerations of any width; a `UInt64` above the range of `i64` is cut to its end.
    pub(crate) fn get_int<U>(
        &mut self,
        kind: Kind,
        vrs: &[u32],
        values: &mut [U],
        to: impl Fn(i64) -> U,
    ) -> c_int {
        let f = &self.functions;
        match kind {
            Kind::Int8 => self.get(f.get_i8, vrs, values, |x| to(x.into())),
            Kind::UInt8 => self.get(f.get_u8, vrs, values, |x| to(x.into())),
            Kind::Int16 => self.get(f.get_i16, vrs, values, |x| to(x.into())),
            Kind::UInt16 => self.get(f.get_u16, vrs, values, |x| to(x.into())),
            Kind::Int32 => self.get(f.get_i32, vrs, values, |x| to(x.into())),
            Kind::UInt32 => self.get(f.get_u32, vrs, values, |x| to(x.into())),
            Kind::UInt64 => self.get(f.get_u64, vrs, values, |x| to(i64::try_from(x).unwrap_or(i64::MAX))),
            _ => self.get(f.get_i64, vrs, values, to),
        }
    }

    /// The caller has checked that the values fit the type.
    pub(crate) fn set_int<U: Copy>(
        &mut self,
        kind: Kind,
        vrs: &[u32],
        values: &[U],
        from: impl Fn(U) -> i64,
    ) -> c_int {
        let f = &self.functions;
        match kind {
            Kind::Int8 => self.set(f.set_i8, vrs, values, |x| from(x) as i8),
            Kind::UInt8 => self.set(f.set_u8, vrs, values, |x| from(x) as u8),
            Kind::Int16 => self.set(f.set_i16, vrs, values, |x| from(x) as i16),
            Kind::UInt16 => self.set(f.set_u16, vrs, values, |x| from(x) as u16),
            Kind::Int32 => self.set(f.set_i32, vrs, values, |x| from(x) as i32),
            Kind::UInt32 => self.set(f.set_u32, vrs, values, |x| from(x) as u32),
            Kind::UInt64 => self.set(f.set_u64, vrs, values, |x| from(x) as u64),
            _ => self.set(f.set_i64, vrs, values, from),
        }
    }

    pub(crate) fn get_bool<U>(&mut self, vrs: &[u32], values: &mut [U], to: impl Fn(bool) -> U) -> c_int {
        self.get(self.functions.get_bool, vrs, values, |x| to(x != 0))
    }

    pub(crate) fn set_bool<U: Copy>(&mut self, vrs: &[u32], values: &[U], from: impl Fn(U) -> bool) -> c_int {
        self.set(self.functions.set_bool, vrs, values, |x| u8::from(from(x)))
    }

    pub(crate) fn get_string(&mut self, vrs: &[u32]) -> (c_int, Vec<String>) {
        let mut texts = vec![ptr::null(); vrs.len()];
        let n = vrs.len();
        // SAFETY: see the type; the FMU keeps the strings until the next call.
        unsafe {
            let status = (self.functions.get_string)(self.handle, vrs.as_ptr(), n, texts.as_mut_ptr(), n);
            (status, if status > 1 { Vec::new() } else { texts.into_iter().map(|t| text_of(t)).collect() })
        }
    }

    pub(crate) fn set_string(&mut self, vrs: &[u32], values: &[&CStr]) -> c_int {
        let texts: Vec<_> = values.iter().map(|v| v.as_ptr()).collect();
        // SAFETY: see the type.
        unsafe {
            (self.functions.set_string)(self.handle, vrs.as_ptr(), vrs.len(), texts.as_ptr(), texts.len())
        }
    }

    /// The status, whether the FMU wants the simulation to end, and whether it returned before `t + h`.
    pub(crate) fn do_step(&mut self, t: f64, h: f64, no_rollback: bool) -> (c_int, bool, bool) {
        let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, t);
        // SAFETY: see the type.
        let status = unsafe {
            (self.functions.do_step)(
                self.handle,
                t,
                h,
                no_rollback,
                &mut event,
                &mut terminate,
                &mut early,
                &mut last,
            )
        };
        (status, terminate != 0, early != 0)
    }

    pub(crate) fn handle(&self) -> Handle {
        self.handle
    }

    /// Must be the last call.
    pub(crate) fn free(&mut self) {
        // SAFETY: called once, from `Instance::drop`.
        unsafe { (self.functions.free_instance)(self.handle) }
    }

    fn get<T: Copy + Default, U>(
        &self,
        f: Get<T>,
        vrs: &[u32],
        values: &mut [U],
        to: impl Fn(T) -> U,
    ) -> c_int {
        // SAFETY: see the type.
        let call =
            |v: &[u32], x: &mut [T]| unsafe { f(self.handle, v.as_ptr(), v.len(), x.as_mut_ptr(), x.len()) };
        convert_get(vrs, values, call, to)
    }

    fn set<T: Copy + Default, U: Copy>(
        &self,
        f: Set<T>,
        vrs: &[u32],
        values: &[U],
        from: impl Fn(U) -> T,
    ) -> c_int {
        // SAFETY: see the type.
        let call = |v: &[u32], x: &[T]| unsafe { f(self.handle, v.as_ptr(), v.len(), x.as_ptr(), x.len()) };
        convert_set(vrs, values, call, from)
    }
}
