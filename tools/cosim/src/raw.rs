//! Every call of the two standards without checks, for testing FMUs.
//!
//! [`Instance`](crate::Instance) keeps its caller from mistakes; here a wrong token, a call out of order or a NaN reaches
//! the FMU, each call gives the bare [`Status`], and all interface types can be instantiated. The one promise kept for
//! the caller: after Fatal nothing is called any more.
use crate::log::{Callbacks, log_message};
use crate::page::{self, Function, Page, announce};
use crate::{Archive, Error, FmiVersion, Log, Status};
use accessor::{Handle, Text};
use libloading::Library;
use std::ffi::{CString, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

mod accessor;
mod calls;
mod continuous;
mod functions;
mod intermediate;
mod values;

pub use crate::description::InterfaceType;
pub use calls::{Experiment, RawState, RawStep};
pub use continuous::DiscreteUpdate;
use functions::ids;
pub(crate) use functions::{Functions, function_name, names, value_names};
pub(crate) use values::Number;

/// A loaded library of an FMU. It stays loaded for as long as an instance of it lives.
#[derive(Clone)]
pub struct RawBinary {
    loaded: Arc<Loaded>,
    archive: PathBuf,
    resources: PathBuf,
    files: Arc<tempfile::TempDir>,
}

struct Loaded {
    functions: Functions,
    version: FmiVersion,
    _library: Library,
}

/// How an instance is to be made.
#[derive(Clone, Copy, Debug)]
pub struct RawSetup<'a> {
    /// The interface type.
    pub interface: InterfaceType,
    /// The GUID or instantiation token to present.
    pub token: &'a str,
    /// The name of the instance.
    pub name: &'a str,
    /// FMI 3 Co-Simulation: event mode is used.
    pub event_mode: bool,
    /// FMI 3 Co-Simulation: inputs that will have derivatives, set in intermediate update mode.
    pub intermediate: &'a [u32],
}

/// An instance. Freed when dropped, unless the FMU reported Fatal.
pub struct RawInstance {
    loaded: Arc<Loaded>,
    handle: Handle,
    log: Log,
    dead: bool,
    /// Derivatives of inputs over the next step of FMI 3.
    lines: intermediate::Lines,
    /// Initialized, and neither terminated nor reset.
    runs: bool,
    page: &'static Page,
    /// Its number on the page, and its lane there.
    number: u16,
    lane: usize,
    /// The FMU keeps a pointer to it, hence the box.
    callbacks: Option<Box<Callbacks>>,
    _files: Arc<tempfile::TempDir>,
}

// SAFETY: the standards let any thread call an instance as long as calls do not overlap, which `&mut self` ensures.
unsafe impl Send for RawInstance {}

impl RawBinary {
    /// Loads the library with this file name (without extension) for this platform.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is none, [`Error::Library`] if it cannot be loaded.
    pub fn load(archive: &Archive, model_identifier: &str) -> Result<Self, Error> {
        let interface =
            crate::Interface { model_identifier: model_identifier.to_owned(), ..Default::default() };
        let binary = archive.binary_of(&interface)?;
        let version = archive.description().fmi_version;
        let library = during(version, 0, Function::LOAD, || load(&binary)).map_err(|e| Error::Library {
            path: archive.path().to_owned(),
            binary: binary.strip_prefix(archive.dir()).unwrap_or(&binary).to_owned(),
            // The loader's own words, which the error keeps one level down.
            reason: std::error::Error::source(&e).map_or_else(|| e.to_string(), ToString::to_string),
        })?;
        let functions = Functions::load(&library, version);
        Ok(Self {
            loaded: Arc::new(Loaded { functions, version, _library: library }),
            archive: archive.path().to_owned(),
            resources: archive.dir().join("resources"),
            files: archive.keep(),
        })
    }

    /// The first function that every FMU of this interface type must have and this binary lacks.
    pub(crate) fn missing(&self, kind: InterfaceType) -> Option<&'static str> {
        let Loaded { functions: f, version, .. } = &*self.loaded;
        if kind == InterfaceType::CoSimulation {
            return f.missing(*version);
        }
        let two = *version == FmiVersion::V2;
        let needed = [
            (f.exit_initialization.is_some(), names::exit_initialization),
            (f.enter_event.is_some(), names::enter_event),
            (two || f.update_discrete_states.is_some(), names::update_discrete_states),
            (!two || f.new_discrete_states.is_some(), names::new_discrete_states),
            (f.enter_continuous.is_some(), names::enter_continuous),
            (f.set_time.is_some(), names::set_time),
            (f.get_derivatives.is_some(), names::get_derivatives),
        ];
        needed.iter().find(|(is_there, _)| !is_there).map(|(_, names)| names[usize::from(!two)])
    }

    /// Result of `fmiXGetVersion`; `None` without that function.
    pub fn version(&self) -> Option<String> {
        // SAFETY: it takes nothing and gives a static C string or NULL.
        let call = |f: unsafe extern "C" fn() -> Text| unsafe { crate::log::text_of(f()) };
        during(self.loaded.version, 0, ids::version, || self.loaded.functions.version.map(call))
    }

    /// Result of `fmi2GetTypesPlatform`; `None` without that function, as in FMI 3.
    pub fn types_platform(&self) -> Option<String> {
        // SAFETY: as for `version`.
        let call = |f: unsafe extern "C" fn() -> Text| unsafe { crate::log::text_of(f()) };
        during(self.loaded.version, 0, ids::types_platform, || self.loaded.functions.types_platform.map(call))
    }

    /// Makes an instance; `None` if the FMU refuses or lacks the function.
    pub fn instantiate(&self, setup: &RawSetup, log: &Log) -> Option<RawInstance> {
        let mut callbacks = None;
        let (version, number) = (self.loaded.version, page::next_instance());
        announce(number, setup.name, &self.archive);
        let function = match (version, setup.interface) {
            (FmiVersion::V2, _) => ids::instantiate,
            (_, InterfaceType::CoSimulation) => ids::co_simulation,
            (_, InterfaceType::ModelExchange) => ids::model_exchange,
            (_, InterfaceType::ScheduledExecution) => ids::scheduled,
        };
        let handle = during(version, number, function, || match version {
            FmiVersion::V2 => self.instantiate2(setup, log, callbacks.insert(Callbacks::new(log))),
            FmiVersion::V3 => self.instantiate3(setup, log),
        })?;
        (!handle.is_null()).then(|| RawInstance {
            loaded: Arc::clone(&self.loaded),
            handle,
            log: log.clone(),
            dead: false,
            lines: intermediate::Lines::default(),
            runs: false,
            page: page::current(),
            number,
            lane: 0,
            callbacks,
            _files: Arc::clone(&self.files),
        })
    }

    fn instantiate2(&self, setup: &RawSetup, log: &Log, callbacks: &Callbacks) -> Option<Handle> {
        let kind: c_int = match setup.interface {
            InterfaceType::ModelExchange => 0,
            InterfaceType::CoSimulation => 1,
            InterfaceType::ScheduledExecution => return None,
        };
        let (name, token) = (c_string(setup.name), c_string(setup.token));
        let uri = c_string(&file_uri(&self.resources));
        let f = self.loaded.functions.instantiate?;
        // SAFETY: C strings that outlive the call; the callbacks are boxed and kept.
        Some(unsafe {
            f(name.as_ptr(), kind, token.as_ptr(), uri.as_ptr(), callbacks, 0, log.debug().into())
        })
    }

    fn instantiate3(&self, setup: &RawSetup, log: &Log) -> Option<Handle> {
        let f = &self.loaded.functions;
        let (name, token) = (c_string(setup.name), c_string(setup.token));
        let (n, t): (Text, Text) = (name.as_ptr(), token.as_ptr());
        // The standard requires a trailing separator, and NULL if there is no such directory.
        let separator = std::path::MAIN_SEPARATOR;
        let path =
            self.resources.is_dir().then(|| c_string(&format!("{}{separator}", self.resources.display())));
        let path = path.as_ref().map_or(ptr::null(), |p| p.as_ptr());
        let (debug, environment, none) = (log.debug(), log.environment(), ptr::null());
        // SAFETY: C strings that outlive the call; NULL is allowed for callbacks that are not offered.
        Some(unsafe {
            match setup.interface {
                InterfaceType::CoSimulation => {
                    let (event_mode, named) = (setup.event_mode, setup.intermediate);
                    let (inputs, update) = match named {
                        [] => (ptr::null(), none),
                        _ => (named.as_ptr(), intermediate::CALLBACK),
                    };
                    let new = f.co_simulation?;
                    new(
                        n,
                        t,
                        path,
                        false,
                        debug,
                        event_mode,
                        false,
                        inputs,
                        named.len(),
                        environment,
                        log_message,
                        update,
                    )
                }
                InterfaceType::ModelExchange => {
                    (f.model_exchange?)(n, t, path, false, debug, environment, log_message)
                }
                InterfaceType::ScheduledExecution => {
                    let (new, no) = (f.scheduled?, ignore as *const c_void);
                    new(n, t, path, false, debug, environment, log_message, no, no, no)
                }
            }
        })
    }

    /// Calls the free function with NULL, which the standards define to do nothing.
    pub fn free_null(&self) {
        if let Some(free) = self.loaded.functions.free_instance {
            // SAFETY: NULL is allowed.
            during(self.loaded.version, 0, ids::free_instance, || unsafe { free(ptr::null_mut()) });
        }
    }
}

/// Stands for the clock and preemption callbacks, whose arguments it does not read.
extern "C" fn ignore() {}

impl RawInstance {
    /// The standard it follows.
    #[inline]
    pub fn version(&self) -> FmiVersion {
        self.loaded.version
    }

    /// From now on it may be called at the same time as other instances.
    pub(crate) fn take_lane(&mut self) {
        self.lane = Page::lane(self.number);
    }

    /// The sink of the FMU's messages.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Whether calls are blocked after Fatal.
    #[inline]
    pub(crate) fn is_dead(&self) -> bool {
        self.dead
    }

    /// The functions of the binary, to see which are there.
    #[inline]
    pub(crate) fn functions(&self) -> &Functions {
        &self.loaded.functions
    }

    /// All calls use this function: `None` means that the binary lacks the function, which counts as Error.
    #[inline]
    fn status(
        &mut self,
        function: Function,
        call: impl FnOnce(&Functions, Handle) -> Option<c_int>,
    ) -> Status {
        if self.dead {
            return Status::Fatal;
        }
        self.page.enter(self.lane, self.loaded.version, self.number, function);
        let status = call(&self.loaded.functions, self.handle).map_or(Status::Error, Status::from_c);
        self.page.leave(self.lane);
        // A pending step still uses the instance in another thread: as untouchable as after Fatal.
        self.dead = status >= Status::Fatal;
        if function == ids::exit_initialization {
            self.runs = status <= Status::Warning;
        } else if function == ids::terminate || function == ids::reset || status >= Status::Error {
            self.runs = false;
        }
        status
    }
}

impl Drop for RawInstance {
    fn drop(&mut self) {
        // Some FMUs free in Terminate what they have allocated.
        if self.runs {
            self.terminate();
        }
        if self.dead {
            // The library stays loaded, and what it may still call or write to stays valid: its threads may run on.
            std::mem::forget(self.log.clone());
            std::mem::forget(self.callbacks.take());
            std::mem::forget(Arc::clone(&self.loaded));
        } else if let Some(free) = self.loaded.functions.free_instance {
            let handle = self.handle;
            // SAFETY: the handle came from this binary and is not used afterwards.
            during(self.loaded.version, self.number, ids::free_instance, || unsafe { free(handle) });
        }
    }
}

/// A call that is not one of an instance's own.
fn during<T>(version: FmiVersion, number: u16, function: Function, call: impl FnOnce() -> T) -> T {
    let page = page::current();
    page.enter(0, version, number, function);
    let result = call();
    page.leave(0);
    result
}

/// Opens the binary with all symbols resolved at once, so that a missing one is an error here and no crash later.
fn load(binary: &Path) -> Result<Library, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{Library as Unix, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: initialisers of the binary run; whoever opens an FMU trusts it to run code.
        unsafe { Unix::open(Some(binary), RTLD_NOW | RTLD_LOCAL) }.map(Library::from)
    }
    #[cfg(not(unix))]
    // SAFETY: as above.
    unsafe {
        Library::new(binary)
    }
}

/// A C string; text from XML and arguments has no NUL, and if it had, it would end there.
pub(crate) fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}

/// `path` as a `file:///` URI, with everything but unreserved characters percent-encoded.
fn file_uri(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let start = if text.starts_with('/') { "file://" } else { "file:///" };
    format!("{start}{}", encoded(&text, b"/-._~:"))
}

/// A text with everything but letters, digits and `plain` percent-encoded.
pub(crate) fn encoded(text: &str, plain: &[u8]) -> String {
    let encode = |byte: u8| match byte.is_ascii_alphanumeric() || plain.contains(&byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    };
    text.bytes().map(encode).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn uris_are_encoded() {
        assert_eq!(super::file_uri("/tmp/a b/ü".as_ref()), "file:///tmp/a%20b/%C3%BC");
    }
}
