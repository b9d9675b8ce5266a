//! An importer of every model in both standards and both interface types, with the messages of its instance.

mod calls;
pub mod running;

pub use calls::{Fmu, Saved, Succeeds};

use motor_fmu::fmi2::{CallbackFunctions, fmi2Instantiate};
use motor_fmu::fmi3::{
    fmi3EnterConfigurationMode, fmi3EnterStepMode, fmi3ExitConfigurationMode, fmi3InstantiateCoSimulation,
    fmi3InstantiateModelExchange, fmi3SetUInt64,
};
use motor_fmu::instance::{Instance, IntermediateUpdate};
use motor_fmu::logger::{Logger2, Status};
use physics::declare::{Causality, Kind};
use physics::model::{Declaration, Entry, ModelType};
use physics::token::Contents;
use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ops::Deref;
use std::ptr::{null, null_mut};
use std::rc::Rc;

/// Standard and interface type: whether FMI 3, whether Model Exchange.
pub type How = (bool, bool);
pub const CS2: How = (false, false);
pub const ME2: How = (false, true);
pub const CS3: How = (true, false);
pub const ME3: How = (true, true);
pub const KINDS: [How; 4] = [CS2, ME2, CS3, ME3];

pub const MODELS: &[ModelType] = physics::models::ALL;
/// The model whose names [`vr`] knows.
pub const MOTOR: &ModelType = &MODELS[0];

/// Value reference of a variable of the motor.
pub fn vr(name: &str) -> u32 {
    reference((MOTOR.declaration)(), name)
}

fn reference(declaration: &Declaration, name: &str) -> u32 {
    match name {
        "time" => physics::model::TIME,
        _ => declaration.by_name(name).unwrap_or_else(|| panic!("no variable {name}")).value_reference,
    }
}

/// A number of repetitions, a smaller one in Miri, which takes a thousand times as long. It shortens runs, not the list of calls.
pub const fn shortened(usual: usize, in_miri: usize) -> usize {
    if cfg!(miri) { in_miri } else { usual }
}

/// The token that selects a model.
pub fn token(kind: &ModelType) -> CString {
    token_with(kind, Contents::default())
}

/// The token of an archive of a model with these contents.
fn token_with(kind: &ModelType, contents: Contents) -> CString {
    CString::new((kind.declaration)().token.with(contents).to_string()).unwrap()
}

/// The variables of type Real and a causality.
pub fn reals(declaration: &'static Declaration, role: Causality) -> impl Iterator<Item = &'static Entry> {
    declaration.entries.iter().filter(move |e| e.row.causality == role && e.row.kind == Kind::Real)
}

/// A message: status, category, text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    pub status: c_int,
    pub category: String,
    pub text: String,
}

/// A look into a step, at a time: whether inputs may be set, whether the step may end. The requested end, if any.
pub type Look = Box<dyn FnMut(Fmu, f64, bool, bool) -> Option<f64>>;

/// What the environment pointer of an instance leads to.
struct Environment {
    fmu: Cell<Fmu>,
    messages: RefCell<Vec<Message>>,
    look: RefCell<Option<Look>>,
}

const NAME: &CStr = c"any";

/// FMI 2's logger; the library passes "%s" and one text. Only in Miri it has the variadic tail that stable Rust cannot define.
unsafe extern "C" fn logger2(
    environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    #[cfg(not(miri))] text: *const c_char,
    #[cfg(miri)] mut tail: ...
) {
    unsafe {
        assert_eq!((CStr::from_ptr(instance), CStr::from_ptr(format)), (NAME, c"%s"));
        #[cfg(miri)]
        let text = tail.next_arg();
        logger3(environment, status, category, text);
    }
}

unsafe extern "C" fn logger3(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    text: *const c_char,
) {
    let text_of = |p| unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned();
    let message = Message { status, category: text_of(category), text: text_of(text) };
    unsafe { &*environment.cast::<Environment>() }.messages.borrow_mut().push(message);
}

unsafe extern "C" fn look(
    environment: *mut c_void,
    time: f64,
    sets: u8,
    gets: u8,
    done: u8,
    may_return: u8,
    requested: *mut u8,
    until: *mut f64,
) {
    assert_eq!((gets, done), (1, 1));
    let environment = unsafe { &*environment.cast::<Environment>() };
    let mut look = environment.look.borrow_mut();
    if let Some(end) = look.as_mut().unwrap()(environment.fmu.get(), time, sets == 1, may_return == 1) {
        unsafe { (*requested, *until) = (1, end) };
    }
}

/// Options of an instantiation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    pub logging: bool,
    pub event_mode: bool,
    pub early_return: bool,
    pub resources: Option<&'a str>,
    /// Contents of the archive according to its token.
    pub contents: Contents,
}

/// With logging.
pub const LOGGED: Options = Options {
    logging: true,
    event_mode: false,
    early_return: false,
    resources: None,
    contents: Contents { starts: 0, terms: 0, load: 0 },
};

/// An instance with its importer.
pub struct Importer {
    fmu: Fmu,
    pub exchange: bool,
    pub declaration: &'static Declaration,
    /// No `Box`: a box that moves is the only pointer to its contents, and the library has another.
    environment: Rc<Environment>,
}

impl Importer {
    pub fn instantiated(kind: &ModelType, how: How, options: Options) -> Importer {
        Importer::tried(kind, how, options, None).unwrap_or_else(|messages| panic!("{messages:?}"))
    }

    /// An instance of the motor.
    pub fn motor(how: How) -> Importer {
        Importer::instantiated(MOTOR, how, LOGGED)
    }

    /// An instance that looks into steps at these variables; the messages where the library makes none.
    pub fn tried(
        kind: &ModelType,
        (three, exchange): How,
        options: Options,
        look_at: Option<(&[u32], Look)>,
    ) -> Result<Importer, Vec<Message>> {
        let (seen, looks) = look_at.unzip();
        let update = looks.as_ref().map(|_| look as IntermediateUpdate);
        let seen = seen.unwrap_or_default();
        let mut fmu = Fmu { handle: null_mut(), three };
        let messages = RefCell::default();
        let environment = Rc::new(Environment { fmu: Cell::new(fmu), messages, look: RefCell::new(looks) });
        let pointer: *mut c_void = Rc::as_ptr(&environment).cast_mut().cast();
        let resources = options.resources.map(|text| CString::new(text).unwrap());
        let resources = resources.as_ref().map_or(null(), |text| text.as_ptr());
        let token = token_with(kind, options.contents);
        let (name, logging) = (NAME.as_ptr(), u8::from(options.logging));
        let (token, log) = (token.as_ptr(), Some(logger3 as _));
        let (events, early) = (u8::from(options.event_mode), u8::from(options.early_return));
        fmu.handle = unsafe {
            match (three, exchange) {
                (false, _) => {
                    #[cfg(miri)]
                    let logger: Logger2 = logger2;
                    // The same function with the arguments that the library really passes.
                    #[cfg(not(miri))]
                    let logger = std::mem::transmute::<*const c_void, Logger2>(logger2 as *const c_void);
                    let callbacks = CallbackFunctions {
                        logger: Some(logger),
                        allocate_memory: None,
                        free_memory: None,
                        step_finished: None,
                        environment: pointer,
                    };
                    fmi2Instantiate(
                        name,
                        c_int::from(!exchange),
                        token,
                        resources,
                        &callbacks,
                        0,
                        logging.into(),
                    )
                }
                (true, true) => {
                    fmi3InstantiateModelExchange(name, token, resources, 0, logging, pointer, log)
                }
                (true, false) => {
                    let (at, n) = (seen.as_ptr(), seen.len());
                    fmi3InstantiateCoSimulation(
                        name, token, resources, 0, logging, events, early, at, n, pointer, log, update,
                    )
                }
            }
        };
        if fmu.handle.is_null() {
            return Err(environment.messages.take());
        }
        environment.fmu.set(fmu);
        Ok(Importer { fmu, exchange, declaration: (kind.declaration)(), environment })
    }

    /// The messages since the last call.
    pub fn heard(&self) -> Vec<Message> {
        self.environment.messages.take()
    }

    /// Those that are the reason of a status.
    pub fn said(&self) -> Vec<Message> {
        self.heard().into_iter().filter(|message| message.status != 0).collect()
    }

    pub fn reference(&self, name: &str) -> u32 {
        reference(self.declaration, name)
    }

    pub fn initialize(&self) {
        self.enter(None, 0.0).ok();
        self.exit_initialization().ok();
    }

    /// With these start values, through initialization: ready to step or at the first event.
    pub fn initialized(self, start: &[(&str, f64)]) -> Importer {
        for (name, value) in start {
            assert!(matches!(self.set(name, *value), Status::Ok | Status::Warning), "{name}");
        }
        self.initialize();
        self
    }

    /// Through initialization, and in Model Exchange through the first event.
    pub fn started(self, start: &[(&str, f64)]) -> Importer {
        let this = self.initialized(start);
        if this.exchange {
            this.update();
            this.continue_in_time().ok();
        }
        this
    }

    /// Whether a call has caused an internal failure.
    pub fn has_failed(&self) -> bool {
        let mut failed = false;
        let look = |i: &mut Instance| {
            failed = i.has_failed();
            Ok(())
        };
        unsafe { motor_fmu::boundary::enter(self.handle, "look", look) }.ok();
        failed
    }

    /// Sets the number of segments in configuration mode.
    pub fn segments(self, count: u64) -> Importer {
        unsafe {
            fmi3EnterConfigurationMode(self.handle).ok();
            fmi3SetUInt64(self.handle, &self.reference("air_segments"), 1, &count, 1).ok();
            fmi3ExitConfigurationMode(self.handle).ok();
        }
        self
    }

    /// One event iteration: whether values have changed, and the time of the next event where it is known.
    pub fn update(&self) -> (bool, Option<f64>) {
        let (status, [again, terminate, nominals, values, defined], next) = self.iterate();
        assert_eq!((status, again, terminate, nominals), (Status::Ok, 0, 0, 0));
        assert!(defined == 1 || (defined, next) == (0, 0.0), "{defined} {next}");
        (values == 1, (defined == 1).then_some(next))
    }

    /// Handles an event of Co-Simulation; the time of the next, where it is known.
    pub fn handle_event(&self) -> Option<f64> {
        // At the first event the instance is in event mode.
        self.enter_event();
        let (changed, next) = self.update();
        assert!(!changed);
        unsafe { fmi3EnterStepMode(self.handle) }.ok();
        next
    }

    /// Sets variables of one type in one call.
    pub fn set_all(&self, values: &[(&str, f64)]) -> Status {
        let references: Vec<u32> = values.iter().map(|(name, _)| self.reference(name)).collect();
        let (first, entry) = (values.first().map(|(name, _)| *name), |name| self.declaration.by_name(name));
        if first.and_then(entry).is_none_or(|entry| entry.row.kind == Kind::Real) {
            self.set_reals(&references, &values.iter().map(|(_, value)| *value).collect::<Vec<_>>())
        } else {
            self.set_whole(&references, &values.iter().map(|(_, value)| *value as i64).collect::<Vec<_>>())
        }
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        self.set_all(&[(name, value)])
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        assert_eq!(self.get_reals(&[self.reference(name)], &mut value), Status::Ok, "{name}");
        value[0]
    }

    pub fn get_whole(&self, name: &str) -> i64 {
        let mut value = [0];
        self.fmu.get_whole(&[self.reference(name)], &mut value).ok();
        value[0]
    }

    pub fn is_hot(&self) -> bool {
        self.flag(self.reference("over_temperature"))
    }

    /// A step of FMI 3.0: whether there is an event, whether it ended early, and where.
    pub fn ended(&self, at: f64, h: f64) -> (bool, bool, f64) {
        let (status, [event, terminate, early], last) = self.step3(at, h);
        assert_eq!((status, terminate), (Status::Ok, 0));
        (event == 1, early == 1, last)
    }

    /// Puts the time and the continuous states.
    pub fn put(&self, time: f64, x: &[f64]) {
        self.set_time(time).ok();
        self.set_states(x).ok();
    }

    pub fn states(&self) -> Vec<f64> {
        filled(self.number_of_states(), |x| self.get_states(x))
    }

    pub fn rates(&self) -> Vec<f64> {
        filled(self.number_of_states(), |x| self.get_rates(x))
    }

    pub fn indicators(&self) -> Vec<f64> {
        filled(self.declaration.indicators.len(), |z| self.get_indicators(z))
    }

    /// All outputs, bit for bit.
    pub fn outputs(&self) -> Vec<u64> {
        let references: Vec<u32> =
            reals(self.declaration, Causality::Output).map(|e| e.value_reference).collect();
        filled(references.len(), |all| self.get_reals(&references, all))
            .into_iter()
            .map(f64::to_bits)
            .collect()
    }
}

/// An array that a call must fill.
pub fn filled(n: usize, call: impl FnOnce(&mut [f64]) -> Status) -> Vec<f64> {
    let mut all = vec![f64::NAN; n];
    call(&mut all).ok();
    all
}

impl Deref for Importer {
    type Target = Fmu;

    fn deref(&self) -> &Fmu {
        &self.fmu
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        self.free();
    }
}
