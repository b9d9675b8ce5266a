//! Every call of the two standards as it stands, for a caller that tests an FMU rather than uses it.
//!
//! [`Instance`](crate::Instance) keeps its caller from mistakes; here a wrong token, a call out of order or a NaN reaches
//! the FMU, each call gives the bare [`Status`], and all interface types can be instantiated. The one promise kept for
//! the caller: after Fatal nothing is called any more.
use crate::fmi2::Callbacks;
use crate::fmi2::{c_string, file_uri};
use crate::log::text_of;
use crate::{Archive, Error, FmiVersion, Log, Status};
use functions::{Api, Common, Functions2, Functions3, Handle, LOG_MESSAGE};
use libloading::Library;
use std::ffi::c_int;
use std::path::PathBuf;
use std::ptr;
use std::sync::Arc;

mod calls;
mod continuous;
mod functions;
mod values;

pub use calls::{RawState, RawStep};
pub use continuous::DiscreteUpdate;

/// An interface type of the standards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the standard's words
pub enum InterfaceType {
    CoSimulation,
    ModelExchange,
    ScheduledExecution,
}

/// A loaded library of an FMU. It stays loaded for as long as an instance of it lives.
#[derive(Clone)]
pub struct RawBinary {
    shared: Arc<Shared>,
}

struct Shared {
    api: Api,
    version: FmiVersion,
    resources: PathBuf,
    _files: Arc<tempfile::TempDir>,
    /// Last, so that it is unloaded last.
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
}

/// An instance. Freed when dropped, unless the FMU reported Fatal.
pub struct RawInstance {
    shared: Arc<Shared>,
    common: Common,
    handle: Handle,
    log: Log,
    dead: bool,
    /// The FMU keeps a pointer to it, hence the box.
    _callbacks: Option<Box<Callbacks>>,
}

// SAFETY: the standards let any thread call an instance as long as calls do not overlap, which `&mut self` ensures.
unsafe impl Send for RawInstance {}

impl RawBinary {
    /// Loads the library with this file name (without extension) for this platform.
    ///
    /// # Errors
    /// [`Error::Platform`] if there is none, [`Error::Library`] if it cannot be loaded.
    pub fn load(archive: &Archive, model_identifier: &str) -> Result<Self, Error> {
        let interface =
            crate::Interface { model_identifier: model_identifier.to_owned(), ..Default::default() };
        let binary = archive.binary_of(&interface)?;
        let library = crate::instance::load(&binary).map_err(|e| Error::Library {
            path: archive.path().to_owned(),
            binary: binary.strip_prefix(archive.dir()).unwrap_or(&binary).to_owned(),
            reason: crate::instance::loader_says(&e),
        })?;
        let missing = |symbol| Error::Symbol { path: archive.path().to_owned(), symbol };
        let version = archive.description().fmi_version;
        let api = match version {
            FmiVersion::V2 => Api::Two(Box::new(Functions2::load(&library).map_err(missing)?)),
            FmiVersion::V3 => Api::Three(Box::new(Functions3::load(&library).map_err(missing)?)),
        };
        let resources = archive.dir().join("resources");
        let shared = Shared { api, version, resources, _files: archive.keep(), _library: library };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// What `fmiXGetVersion` says; `None` without that function.
    pub fn version(&self) -> Option<String> {
        let version = match &self.shared.api {
            Api::Two(f) => f.version,
            Api::Three(f) => f.version,
        };
        // SAFETY: it takes nothing and gives a static C string or NULL.
        version.map(|f| unsafe { text_of(f()) })
    }

    /// What `fmi2GetTypesPlatform` says; `None` without that function, as in FMI 3.
    pub fn types_platform(&self) -> Option<String> {
        match &self.shared.api {
            // SAFETY: as for `version`.
            Api::Two(f) => f.types_platform.map(|f| unsafe { text_of(f()) }),
            Api::Three(_) => None,
        }
    }

    /// Makes an instance; `None` if the FMU refuses or lacks the function.
    pub fn instantiate(&self, setup: &RawSetup, log: &Log) -> Option<RawInstance> {
        let (name, token) = (c_string(setup.name), c_string(setup.token));
        let resources = &self.shared.resources;
        let (n, t) = (name.as_ptr(), token.as_ptr());
        let mut callbacks = None;
        let handle = match &self.shared.api {
            Api::Two(f) => {
                let kind: c_int = match setup.interface {
                    InterfaceType::ModelExchange => 0,
                    InterfaceType::CoSimulation => 1,
                    InterfaceType::ScheduledExecution => return None,
                };
                let uri = c_string(&file_uri(resources));
                let kept = callbacks.insert(Callbacks::new(log));
                let instantiate = f.instantiate?;
                // SAFETY: C strings that outlive the call; the callbacks are boxed and kept.
                unsafe { instantiate(n, kind, t, uri.as_ptr(), &**kept, 0, log.debug().into()) }
            }
            Api::Three(f) => {
                let separator = std::path::MAIN_SEPARATOR;
                let path =
                    resources.is_dir().then(|| c_string(&format!("{}{separator}", resources.display())));
                let (path, debug) = (path.as_ref().map_or(ptr::null(), |p| p.as_ptr()), log.debug());
                let (environment, none) = (log.environment(), ptr::null());
                // SAFETY: C strings that outlive the call; NULL is allowed for callbacks that are not offered.
                unsafe {
                    match setup.interface {
                        InterfaceType::CoSimulation => (f.co_simulation?)(
                            n,
                            t,
                            path,
                            false,
                            debug,
                            setup.event_mode,
                            false,
                            ptr::null(),
                            0,
                            environment,
                            LOG_MESSAGE,
                            none,
                        ),
                        InterfaceType::ModelExchange => {
                            (f.model_exchange?)(n, t, path, false, debug, environment, LOG_MESSAGE)
                        }
                        InterfaceType::ScheduledExecution => {
                            let nothing = ignore as *const std::ffi::c_void;
                            (f.scheduled?)(
                                n,
                                t,
                                path,
                                false,
                                debug,
                                environment,
                                LOG_MESSAGE,
                                nothing,
                                nothing,
                                nothing,
                            )
                        }
                    }
                }
            }
        };
        (!handle.is_null()).then(|| RawInstance {
            shared: Arc::clone(&self.shared),
            common: self.shared.api.common(),
            handle,
            log: log.clone(),
            dead: false,
            _callbacks: callbacks,
        })
    }

    /// Calls the free function with NULL, which the standards define to do nothing.
    pub fn free_null(&self) {
        if let Some(free) = self.shared.api.common().free_instance {
            // SAFETY: NULL is allowed.
            unsafe { free(ptr::null_mut()) }
        }
    }
}

/// Stands for the clock and preemption callbacks, whose arguments it does not read.
extern "C" fn ignore() {}

impl RawInstance {
    /// The standard it follows.
    pub fn version(&self) -> FmiVersion {
        self.shared.version
    }

    /// The sink of the FMU's messages.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// All calls go through here: `None` stands for a function that the binary lacks, which counts as Error.
    fn status(&mut self, call: impl FnOnce(&Api, &Common, Handle) -> Option<c_int>) -> Status {
        if self.dead {
            return Status::Fatal;
        }
        let status = call(&self.shared.api, &self.common, self.handle).map_or(Status::Error, Status::from_c);
        self.dead = status >= Status::Fatal;
        status
    }
}

impl Drop for RawInstance {
    fn drop(&mut self) {
        if self.dead {
            // What the FMU may still write to stays valid.
            std::mem::forget(self.log.clone());
            std::mem::forget(self._callbacks.take());
            std::mem::forget(Arc::clone(&self.shared));
        } else if let Some(free) = self.common.free_instance {
            // SAFETY: the handle came from this binary and is not used afterwards.
            unsafe { free(self.handle) }
        }
    }
}
