//! One instance of an FMU, the same for FMI 2.0 and 3.0.
use crate::fmi2::{Fmi2, c_string};
use crate::fmi3::Fmi3;
use crate::{Archive, Error, FmiVersion, Log, Status};
use libloading::Library;
use std::ffi::{CString, c_int, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

mod access;
mod convert;
mod state;
pub(crate) use convert::{convert_get, convert_set};
pub use state::State;

/// What both standards need to instantiate.
pub(crate) struct Setup<'a> {
    pub(crate) name: CString,
    pub(crate) token: CString,
    /// The unpacked archive.
    pub(crate) dir: &'a Path,
}

/// How a communication step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// At `t + h`.
    Done,
    /// The FMU asks for the end of the simulation.
    Terminated,
}

enum Backend {
    Two(Fmi2),
    Three(Fmi3),
}

/// A Co-Simulation instance of an FMU.
///
/// Warnings go to the [`Log`]; Discard, Error and Fatal become [`Error::Call`] with the FMU's own words. After
/// Fatal the binary is never called again, not even to free the instance. Lists of value references go with lists
/// of values of the same length; for FMI 3 arrays the values of all elements follow each other.
/// Get, set and step do not allocate for scalars, apart from strings.
pub struct Instance {
    name: String,
    log: Log,
    backend: Backend,
    /// Fatal was reported, or a step never ended.
    dead: bool,
    /// Tells this instance's states from others'.
    id: u64,
    /// States of the FMU by slot; NULL where freed.
    states: Vec<*mut c_void>,
    /// Slots of `states` that no [`State`] refers to.
    free_slots: Vec<usize>,
    /// A state was saved once, so the FMU may have to go back in time.
    saved: bool,
    library: ManuallyDrop<Library>,
    _files: Arc<tempfile::TempDir>,
}

// SAFETY: the standards let any thread call an instance as long as calls do not overlap, which `&mut self` ensures;
// the log may be written from any thread.
unsafe impl Send for Instance {}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance").field("name", &self.name).field("dead", &self.dead).finish_non_exhaustive()
    }
}

impl Instance {
    /// Loads the binary and instantiates it for Co-Simulation; messages of the FMU go to `log`.
    ///
    /// # Errors
    /// No Co-Simulation interface, no binary for this platform, a binary that cannot be loaded or lacks functions,
    /// an FMU that refuses.
    pub fn instantiate(archive: &Archive, name: &str, log: Log) -> Result<Self, Error> {
        let description = archive.description();
        let path = archive.path().to_owned();
        let Some(interface) = &description.co_simulation else {
            let what = if description.model_exchange.is_some() {
                "is for Model Exchange only"
            } else {
                "has no interface"
            };
            return Err(Error::Unsupported {
                name: path.display().to_string(),
                reason: format!("cannot be stepped: it {what}"),
            });
        };
        let binary = archive.binary_of(interface)?;
        let library = load(&binary).map_err(|e| Error::Library {
            path: path.clone(),
            binary: binary.strip_prefix(archive.dir()).unwrap_or(&binary).to_owned(),
            reason: loader_says(&e),
        })?;
        let setup = Setup { name: c_string(name), token: c_string(&description.token), dir: archive.dir() };
        let mark = log.mark();
        let backend = match description.fmi_version {
            FmiVersion::V2 => Fmi2::instantiate(&library, &setup, &log).map(|i| i.map(Backend::Two)),
            FmiVersion::V3 => Fmi3::instantiate(&library, &setup, &log).map(|i| i.map(Backend::Three)),
        };
        let backend = backend.map_err(|symbol| Error::Symbol { path: path.clone(), symbol })?;
        let Some(backend) = backend else {
            return Err(Error::Instantiate { path, name: name.to_owned(), messages: log.since(mark) });
        };
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Ok(Self {
            name: name.to_owned(),
            log,
            backend,
            dead: false,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            states: Vec::new(),
            free_slots: Vec::new(),
            saved: false,
            library: ManuallyDrop::new(library),
            _files: archive.keep(),
        })
    }

    /// The name given at instantiation.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The sink of the FMU's messages.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// FMI 3: enters configuration mode, in which structural parameters can be set.
    ///
    /// # Errors
    /// [`Error::Call`]; [`Error::Unsupported`] for FMI 2.
    pub fn enter_configuration_mode(&mut self) -> Result<(), Error> {
        self.call_optional(["configuration mode", "fmi3EnterConfigurationMode"], |b| match b {
            Backend::Two(_) => None,
            Backend::Three(i) => i.enter_configuration(),
        })
    }

    /// FMI 3: leaves configuration mode.
    ///
    /// # Errors
    /// As [`Self::enter_configuration_mode`].
    pub fn exit_configuration_mode(&mut self) -> Result<(), Error> {
        self.call_optional(["configuration mode", "fmi3ExitConfigurationMode"], |b| match b {
            Backend::Two(_) => None,
            Backend::Three(i) => i.exit_configuration(),
        })
    }

    /// Tells the FMU its start time, stop time (s) and relative tolerance, and enters initialization mode.
    ///
    /// # Errors
    /// [`Error::Call`], as for all calls below.
    pub fn enter_initialization(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Result<(), Error> {
        self.call(["fmi2EnterInitializationMode", "fmi3EnterInitializationMode"], |b| match b {
            Backend::Two(i) => i.enter_initialization(start, stop, tolerance),
            Backend::Three(i) => i.enter_initialization(start, stop, tolerance),
        })
    }

    /// Leaves initialization mode: the FMU is ready to step.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        self.call(["fmi2ExitInitializationMode", "fmi3ExitInitializationMode"], |b| match b {
            Backend::Two(i) => i.exit_initialization(),
            Backend::Three(i) => i.exit_initialization(),
        })
    }

    /// FMI 2: the slopes (per s) of real inputs over the next step.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length, [`Error::Unsupported`] for FMI 3.
    pub fn set_input_derivatives(&mut self, vrs: &[u32], slopes: &[f64]) -> Result<(), Error> {
        let functions = ["fmi2SetRealInputDerivatives", "derivatives of inputs"];
        if !self.fits(functions, vrs.len(), slopes.len())? {
            return Ok(());
        }
        self.call_optional(functions, |b| match b {
            Backend::Two(i) => i.set_input_derivatives(vrs, slopes),
            Backend::Three(_) => None,
        })
    }

    /// One communication step from `t` to `t + h` (s).
    ///
    /// # Errors
    /// [`Error::Call`] with the time.
    pub fn do_step(&mut self, t: f64, h: f64) -> Result<Step, Error> {
        let no_rollback = !self.saved;
        let (mut terminated, mut early) = (false, false);
        let functions = ["fmi2DoStep", "fmi3DoStep"];
        self.call_at(functions, Some(t), |b| match b {
            Backend::Two(i) => {
                let status = i.do_step(t, h, no_rollback);
                // FMI 2 has no other way to ask for the end than to discard the step.
                terminated = Status::from_c(status) == Status::Discard && i.wants_to_end();
                if terminated { 0 } else { status }
            }
            Backend::Three(i) => {
                let (status, end, short) = i.do_step(t, h, no_rollback);
                (terminated, early) = (end, short);
                status
            }
        })?;
        if terminated {
            return Ok(Step::Terminated);
        }
        if early {
            return Err(
                self.misuse(functions, format!("it returned early from t = {t} s, which was not allowed"))
            );
        }
        Ok(Step::Done)
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.call(["fmi2Terminate", "fmi3Terminate"], |b| match b {
            Backend::Two(i) => i.terminate(),
            Backend::Three(i) => i.terminate(),
        })
    }

    /// Back to the state after instantiation.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn reset(&mut self) -> Result<(), Error> {
        self.call(["fmi2Reset", "fmi3Reset"], |b| match b {
            Backend::Two(i) => i.reset(),
            Backend::Three(i) => i.reset(),
        })
    }

    #[inline]
    fn call(
        &mut self,
        functions: [&'static str; 2],
        f: impl FnOnce(&mut Backend) -> c_int,
    ) -> Result<(), Error> {
        self.call_at(functions, None, f)
    }

    /// The one place where the FMU's status is judged; all calls but free go through here.
    #[inline]
    fn call_at(
        &mut self,
        functions: [&'static str; 2],
        time: Option<f64>,
        f: impl FnOnce(&mut Backend) -> c_int,
    ) -> Result<(), Error> {
        if self.dead {
            return Err(Error::Dead { instance: self.name.clone(), function: self.pick(functions) });
        }
        let mark = self.log.mark();
        let status = Status::from_c(f(&mut self.backend));
        if status <= Status::Warning {
            return Ok(());
        }
        Err(self.failed(functions, time, status, mark))
    }

    #[cold]
    fn failed(
        &mut self,
        functions: [&'static str; 2],
        time: Option<f64>,
        status: Status,
        mark: u64,
    ) -> Error {
        // A pending step still uses the instance in another thread: as untouchable as after Fatal.
        self.dead = status >= Status::Fatal;
        Error::Call {
            instance: self.name.clone(),
            function: self.pick(functions),
            status,
            time,
            messages: self.log.since(mark),
        }
    }

    /// As `call`, for a function that the FMU may lack: then `f` gives `None`.
    fn call_optional(
        &mut self,
        functions: [&'static str; 2],
        f: impl FnOnce(&mut Backend) -> Option<c_int>,
    ) -> Result<(), Error> {
        let mut lacking = false;
        self.call(functions, |b| {
            f(b).unwrap_or_else(|| {
                lacking = true;
                0
            })
        })?;
        if lacking {
            return Err(Error::Unsupported {
                name: self.name.clone(),
                reason: format!("does not provide {}", self.pick(functions)),
            });
        }
        Ok(())
    }

    fn pick(&self, functions: [&'static str; 2]) -> &'static str {
        match self.backend {
            Backend::Two(_) => functions[0],
            Backend::Three(_) => functions[1],
        }
    }

    fn misuse(&self, functions: [&'static str; 2], reason: String) -> Error {
        Error::Misuse { instance: self.name.clone(), function: self.pick(functions), reason }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if self.dead {
            // The library stays loaded, and what it may still call or write to stays valid: its threads may run on.
            std::mem::forget(self.log.clone());
            if let Backend::Two(i) = &mut self.backend {
                i.leak_callbacks();
            }
            return;
        }
        self.free_all_states();
        match &mut self.backend {
            Backend::Two(i) => i.free(),
            Backend::Three(i) => i.free(),
        }
        // SAFETY: dropped once, here; nothing of the library is used afterwards, as the backend's pointers are data.
        unsafe { ManuallyDrop::drop(&mut self.library) };
    }
}

/// The loader's own words, which the error keeps one level down.
pub(crate) fn loader_says(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}

/// Opens the binary with all symbols resolved at once, so that a missing one is an error here and no crash later.
pub(crate) fn load(binary: &Path) -> Result<Library, libloading::Error> {
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
