//! An importer in a few lines: calls the C functions as C would.

pub mod exchanged;
pub mod three;

use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// Messages that the logger of [`Motor2`] received, in the order of the calls.
pub static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// FMI 2's logger without its variadic tail: the library passes "%s" and one text.
unsafe extern "C" fn logger(
    _environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    _format: *const c_char,
    message: *const c_char,
) {
    let text = |p| unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned();
    SAID.lock().unwrap().push(format!("{} {status} {} {}", text(instance), text(category), text(message)));
}

/// The messages since the last call that belong to an instance.
pub fn said(instance: &str) -> Vec<String> {
    let mut all = SAID.lock().unwrap();
    let (mine, rest) = all.drain(..).partition(|line| line.starts_with(&format!("{instance} ")));
    *all = rest;
    mine
}

pub fn token() -> CString {
    let declaration = (physics::models::ALL[0].declaration)();
    CString::new(declaration.token.clone()).unwrap()
}

/// Value reference of a variable.
pub fn vr(name: &str) -> u32 {
    if name == "time" {
        return physics::model::TIME;
    }
    let declaration = (physics::models::ALL[0].declaration)();
    declaration.by_name(name).unwrap_or_else(|| panic!("no variable {name}")).value_reference
}

/// An FMI 2 instance.
pub struct Motor2(pub Component);

impl Motor2 {
    pub fn instantiated(name: &str) -> Motor2 {
        Motor2::located(name, None).unwrap()
    }

    /// An instance whose archive has its resources at this URI; `None` where the library makes none.
    pub fn located(name: &str, resources: Option<&str>) -> Option<Motor2> {
        // SAFETY: the same function with the arguments that the library really passes.
        let logger = unsafe {
            std::mem::transmute::<*const c_void, motor_fmu::logger::Logger2>(logger as *const c_void)
        };
        let functions = CallbackFunctions {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: null_mut(),
        };
        let name = CString::new(name).unwrap();
        let resources = resources.map(|uri| CString::new(uri).unwrap());
        let resources = resources.as_ref().map_or(null(), |uri| uri.as_ptr());
        let c = unsafe { fmi2Instantiate(name.as_ptr(), 1, token().as_ptr(), resources, &functions, 0, 0) };
        (!c.is_null()).then_some(Motor2(c))
    }

    pub fn initialized(name: &str) -> Motor2 {
        let motor = Motor2::instantiated(name);
        motor.initialize();
        motor
    }

    pub fn initialize(&self) {
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.0, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(self.0), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(self.0), Status::Ok);
        }
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        unsafe { fmi2SetReal(self.0, &vr(name), 1, &value) }
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi2GetReal(self.0, &vr(name), 1, &mut value) }, Status::Ok, "{name}");
        value
    }

    pub fn step(&self, at: f64, h: f64) -> Status {
        unsafe { fmi2DoStep(self.0, at, h, 1) }
    }

    /// All outputs, bit for bit.
    pub fn outputs(&self) -> Vec<u64> {
        let declaration = (physics::models::ALL[0].declaration)();
        declaration
            .entries
            .iter()
            .filter(|e| {
                e.row.causality == physics::declare::Causality::Output
                    && e.row.kind == physics::declare::Kind::Real
            })
            .map(|e| self.get(&e.name).to_bits())
            .collect()
    }
}

impl Drop for Motor2 {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.0) }
    }
}
