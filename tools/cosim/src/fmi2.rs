//! FMI 2.0 Co-Simulation: the C types, and each call as a thin method that returns the C status.
use crate::functions::functions;
use crate::instance::{Setup, convert_get, convert_set};
use crate::log::{Log, log_fmi2, text_of};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr;

type Component = *mut c_void;
type State = *mut c_void;

functions! {
    /// The functions of FMI 2.0 that a Co-Simulation master calls.
    Functions {
        required {
            instantiate = fmi2Instantiate: fn(*const c_char, c_int, *const c_char, *const c_char, *const Callbacks, c_int, c_int) -> Component;
            free_instance = fmi2FreeInstance: fn(Component);
            setup_experiment = fmi2SetupExperiment: fn(Component, c_int, f64, f64, c_int, f64) -> c_int;
            enter_initialization = fmi2EnterInitializationMode: fn(Component) -> c_int;
            exit_initialization = fmi2ExitInitializationMode: fn(Component) -> c_int;
            terminate = fmi2Terminate: fn(Component) -> c_int;
            reset = fmi2Reset: fn(Component) -> c_int;
            get_real = fmi2GetReal: fn(Component, *const c_uint, usize, *mut f64) -> c_int;
            get_integer = fmi2GetInteger: fn(Component, *const c_uint, usize, *mut c_int) -> c_int;
            get_boolean = fmi2GetBoolean: fn(Component, *const c_uint, usize, *mut c_int) -> c_int;
            get_string = fmi2GetString: fn(Component, *const c_uint, usize, *mut *const c_char) -> c_int;
            set_real = fmi2SetReal: fn(Component, *const c_uint, usize, *const f64) -> c_int;
            set_integer = fmi2SetInteger: fn(Component, *const c_uint, usize, *const c_int) -> c_int;
            set_boolean = fmi2SetBoolean: fn(Component, *const c_uint, usize, *const c_int) -> c_int;
            set_string = fmi2SetString: fn(Component, *const c_uint, usize, *const *const c_char) -> c_int;
            do_step = fmi2DoStep: fn(Component, f64, f64, c_int) -> c_int;
        }
        optional {
            set_input_derivatives = fmi2SetRealInputDerivatives: fn(Component, *const c_uint, usize, *const c_int, *const f64) -> c_int;
            get_boolean_status = fmi2GetBooleanStatus: fn(Component, c_int, *mut c_int) -> c_int;
            get_state = fmi2GetFMUstate: fn(Component, *mut State) -> c_int;
            set_state = fmi2SetFMUstate: fn(Component, State) -> c_int;
            free_state = fmi2FreeFMUstate: fn(Component, *mut State) -> c_int;
            state_size = fmi2SerializedFMUstateSize: fn(Component, State, *mut usize) -> c_int;
            serialize_state = fmi2SerializeFMUstate: fn(Component, State, *mut u8, usize) -> c_int;
            deserialize_state = fmi2DeSerializeFMUstate: fn(Component, *const u8, usize, *mut State) -> c_int;
        }
    }
}

/// `fmi2CallbackFunctions`. The logger is variadic in C, see [`log_fmi2`].
#[repr(C)]
pub(crate) struct Callbacks {
    logger:
        unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, *const c_char),
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

// SAFETY: the C library that the standard library links has both, with these signatures.
unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(pointer: *mut c_void);
}

impl Callbacks {
    /// The FMU keeps a pointer to them, hence the box.
    pub(crate) fn new(log: &Log) -> Box<Self> {
        let environment = log.environment();
        Box::new(Self { logger: log_fmi2, allocate: calloc, free, step_finished: None, environment })
    }
}

/// An instance of an FMI 2.0 FMU.
///
/// Safety of all methods: `component` came from `fmi2Instantiate` and is not freed, the function pointers belong to
/// the loaded library, slices are as long as the counts passed with them, and `Instance` sees to it that nothing
/// is called after Fatal.
pub(crate) struct Fmi2 {
    pub(crate) functions: Functions,
    component: Component,
    /// The FMU keeps a pointer to it, hence the box.
    callbacks: Option<Box<Callbacks>>,
}

impl Fmi2 {
    /// `Ok(None)` if the FMU refuses, `Err` with the name of a missing function.
    pub(crate) fn instantiate(
        library: &Library,
        setup: &Setup,
        log: &Log,
    ) -> Result<Option<Self>, &'static str> {
        let functions = Functions::load(library)?;
        let callbacks = Callbacks::new(log);
        let resources = c_string(&file_uri(&setup.dir.join("resources")));
        const CO_SIMULATION: c_int = 1;
        // SAFETY: all strings are C strings that outlive the call; `callbacks` is boxed and kept.
        let component = unsafe {
            (functions.instantiate)(
                setup.name.as_ptr(),
                CO_SIMULATION,
                setup.token.as_ptr(),
                resources.as_ptr(),
                &*callbacks,
                0,
                c_int::from(log.debug()),
            )
        };
        Ok((!component.is_null()).then_some(Self { functions, component, callbacks: Some(callbacks) }))
    }

    /// Sets up the experiment and enters initialization mode.
    pub(crate) fn enter_initialization(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> c_int {
        let f = &self.functions;
        // SAFETY: see the type.
        unsafe {
            let status = (f.setup_experiment)(
                self.component,
                tolerance.is_some().into(),
                tolerance.unwrap_or(0.0),
                start,
                stop.is_some().into(),
                stop.unwrap_or(0.0),
            );
            if status > 1 { status } else { status.max((f.enter_initialization)(self.component)) }
        }
    }

    pub(crate) fn exit_initialization(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.exit_initialization)(self.component) }
    }

    pub(crate) fn terminate(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.terminate)(self.component) }
    }

    pub(crate) fn reset(&mut self) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.reset)(self.component) }
    }

    pub(crate) fn get_f64(&mut self, vrs: &[u32], values: &mut [f64]) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.get_real)(self.component, vrs.as_ptr(), vrs.len(), values.as_mut_ptr()) }
    }

    pub(crate) fn set_f64(&mut self, vrs: &[u32], values: &[f64]) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.set_real)(self.component, vrs.as_ptr(), vrs.len(), values.as_ptr()) }
    }

    pub(crate) fn get_int<U>(&mut self, vrs: &[u32], values: &mut [U], to: impl Fn(c_int) -> U) -> c_int {
        // SAFETY: see the type.
        let call = |v: &[u32], x: &mut [c_int]| unsafe {
            (self.functions.get_integer)(self.component, v.as_ptr(), v.len(), x.as_mut_ptr())
        };
        convert_get(vrs, values, call, to)
    }

    pub(crate) fn set_int<U: Copy>(&mut self, vrs: &[u32], values: &[U], from: impl Fn(U) -> c_int) -> c_int {
        // SAFETY: see the type.
        let call = |v: &[u32], x: &[c_int]| unsafe {
            (self.functions.set_integer)(self.component, v.as_ptr(), v.len(), x.as_ptr())
        };
        convert_set(vrs, values, call, from)
    }

    pub(crate) fn get_bool<U>(&mut self, vrs: &[u32], values: &mut [U], to: impl Fn(bool) -> U) -> c_int {
        // SAFETY: see the type.
        let call = |v: &[u32], x: &mut [c_int]| unsafe {
            (self.functions.get_boolean)(self.component, v.as_ptr(), v.len(), x.as_mut_ptr())
        };
        convert_get(vrs, values, call, |x: c_int| to(x != 0))
    }

    pub(crate) fn set_bool<U: Copy>(&mut self, vrs: &[u32], values: &[U], from: impl Fn(U) -> bool) -> c_int {
        // SAFETY: see the type.
        let call = |v: &[u32], x: &[c_int]| unsafe {
            (self.functions.set_boolean)(self.component, v.as_ptr(), v.len(), x.as_ptr())
        };
        convert_set(vrs, values, call, |x| c_int::from(from(x)))
    }

    pub(crate) fn get_string(&mut self, vrs: &[u32]) -> (c_int, Vec<String>) {
        let mut texts = vec![ptr::null(); vrs.len()];
        // SAFETY: see the type; the FMU keeps the strings until the next call.
        unsafe {
            let status =
                (self.functions.get_string)(self.component, vrs.as_ptr(), vrs.len(), texts.as_mut_ptr());
            (status, if status > 1 { Vec::new() } else { texts.into_iter().map(|t| text_of(t)).collect() })
        }
    }

    pub(crate) fn set_string(&mut self, vrs: &[u32], values: &[&CStr]) -> c_int {
        let texts: Vec<_> = values.iter().map(|v| v.as_ptr()).collect();
        // SAFETY: see the type.
        unsafe { (self.functions.set_string)(self.component, vrs.as_ptr(), vrs.len(), texts.as_ptr()) }
    }

    /// First derivatives of inputs; the caller has checked that the function exists.
    pub(crate) fn set_input_derivatives(&mut self, vrs: &[u32], slopes: &[f64]) -> Option<c_int> {
        let function = self.functions.set_input_derivatives?;
        const FIRST: [c_int; 64] = [1; 64];
        let mut worst = 0;
        for (v, s) in vrs.chunks(FIRST.len()).zip(slopes.chunks(FIRST.len())) {
            // SAFETY: see the type.
            worst = worst
                .max(unsafe { function(self.component, v.as_ptr(), v.len(), FIRST.as_ptr(), s.as_ptr()) });
        }
        Some(worst)
    }

    pub(crate) fn do_step(&mut self, t: f64, h: f64, no_rollback: bool) -> c_int {
        // SAFETY: see the type.
        unsafe { (self.functions.do_step)(self.component, t, h, no_rollback.into()) }
    }

    /// Whether the FMU discarded a step because it wants the simulation to end.
    pub(crate) fn wants_to_end(&mut self) -> bool {
        const TERMINATED: c_int = 3;
        let Some(function) = self.functions.get_boolean_status else { return false };
        let mut terminated = 0;
        // SAFETY: see the type.
        let status = unsafe { function(self.component, TERMINATED, &mut terminated) };
        status == 0 && terminated != 0
    }

    pub(crate) fn component(&self) -> Component {
        self.component
    }

    /// For an FMU that may still use them after the instance is gone.
    pub(crate) fn leak_callbacks(&mut self) {
        std::mem::forget(self.callbacks.take());
    }

    /// Must be the last call.
    pub(crate) fn free(&mut self) {
        // SAFETY: called once, from `Instance::drop`.
        unsafe { (self.functions.free_instance)(self.component) }
    }
}

/// A C string; text from XML and arguments has no NUL, and if it had, it would end there.
pub(crate) fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}

/// `path` as a `file:///` URI, with everything but unreserved characters percent-encoded.
pub(crate) fn file_uri(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let mut uri = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~:".contains(&byte) {
            uri.push(byte.into());
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    #[test]
    fn uris_are_encoded() {
        assert_eq!(super::file_uri("/tmp/a b/ü".as_ref()), "file:///tmp/a%20b/%C3%BC");
    }
}
