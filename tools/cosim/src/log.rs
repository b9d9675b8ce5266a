//! The log of an FMU's messages, and the C callbacks of both standards.
use std::collections::VecDeque;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// Messages kept by a [`Log`]; older ones are dropped, so that the memory is bounded.
const CAPACITY: usize = 1000;

/// The result of an FMI call. The order is that of the standards: worse is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Success.
    Ok,
    /// Warning; the computation continues.
    Warning,
    /// The call was rejected; the state of the FMU is unchanged.
    Discard,
    /// The instance can no longer be used, apart from reset and free.
    Error,
    /// The binary can no longer be used at all.
    Fatal,
    /// FMI 2 only: the step runs on in another thread, which this client does not allow.
    Pending,
}

impl Status {
    /// The meaning of a C status; numbers outside the standard count as [`Status::Error`].
    pub(crate) fn from_c(status: c_int) -> Self {
        match status {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            4 => Self::Fatal,
            5 => Self::Pending,
            _ => Self::Error,
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// One message of an FMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogMessage {
    /// Status that the FMU gave to the message.
    pub status: Status,
    /// The log category, normally one of [`crate::ModelDescription::log_categories`].
    pub category: String,
    /// The text.
    pub text: String,
}

/// A sink for messages, shared by all its clones; give one to [`crate::Instance::instantiate`] and keep a clone.
/// The last 1000 messages are kept.
#[derive(Clone, Debug, Default)]
pub struct Log {
    sink: Arc<Sink>,
    debug: bool,
}

/// What the FMU's environment pointer refers to.
#[derive(Debug, Default)]
pub(crate) struct Sink {
    kept: Mutex<VecDeque<LogMessage>>,
    /// Messages ever logged, also those that made room; atomic, as each FMI call reads it.
    total: AtomicU64,
    /// A message came with an environment pointer that is not the importer's.
    foreign: AtomicBool,
}

/// The sinks whose address FMUs have got. What an FMU hands back is looked up here and never followed.
static SINKS: Mutex<Vec<(usize, Weak<Sink>)>> = Mutex::new(Vec::new());

impl Log {
    /// A sink for warnings and errors.
    pub fn new() -> Self {
        Self::default()
    }

    /// A sink that also requests the debug messages (`loggingOn`), which may be slow.
    pub fn with_debug() -> Self {
        Self { debug: true, ..Self::default() }
    }

    /// The messages that are kept, oldest first.
    pub fn messages(&self) -> Vec<LogMessage> {
        self.sink.lock().iter().cloned().collect()
    }

    /// Whether debug logging is on.
    pub(crate) fn debug(&self) -> bool {
        self.debug
    }

    pub(crate) fn mark(&self) -> u64 {
        self.sink.total.load(Ordering::Relaxed)
    }

    /// At most the last three messages logged after `mark`.
    pub(crate) fn since(&self, mark: u64) -> Vec<LogMessage> {
        let messages = self.sink.lock();
        let fresh = (self.mark().saturating_sub(mark)).min(3) as usize;
        let skip = messages.len().saturating_sub(fresh);
        messages.iter().skip(skip).cloned().collect()
    }

    /// Whether a message came with an environment pointer that is not the importer's; the standards require that one.
    pub fn has_foreign_environment(&self) -> bool {
        self.sink.foreign.load(Ordering::Relaxed)
    }

    /// The pointer that the FMU hands back with each message; known as long as a clone of `self` lives.
    pub(crate) fn environment(&self) -> *mut c_void {
        let address = Arc::as_ptr(&self.sink);
        let mut sinks = SINKS.lock().unwrap_or_else(PoisonError::into_inner);
        sinks.retain(|(known, sink)| sink.strong_count() > 0 && *known != address as usize);
        sinks.push((address as usize, Arc::downgrade(&self.sink)));
        address.cast_mut().cast()
    }
}

impl Sink {
    /// The sink that an FMU means; the latest one if it means none.
    fn of(environment: *mut c_void) -> Option<Arc<Self>> {
        let sinks = SINKS.lock().unwrap_or_else(PoisonError::into_inner);
        let meant = sinks.iter().find(|(known, _)| *known == environment as usize);
        if let Some(sink) = meant.and_then(|(_, sink)| sink.upgrade()) {
            return Some(sink);
        }
        let latest = sinks.iter().rev().find_map(|(_, sink)| sink.upgrade())?;
        latest.foreign.store(true, Ordering::Relaxed);
        Some(latest)
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<LogMessage>> {
        // A poisoned lock does not invalidate the list of messages.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, message: LogMessage) {
        let mut messages = self.lock();
        if messages.len() == CAPACITY {
            messages.pop_front();
        }
        messages.push_back(message);
        self.total.fetch_add(1, Ordering::Relaxed);
    }
}

/// The text behind a C string, empty for NULL.
///
/// # Safety
/// `text` is NULL or points to a NUL-terminated string that stays unchanged during the call.
pub(crate) unsafe fn text_of(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not NULL, and terminated by the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

/// `fmi3LogMessageCallback`
pub(crate) type LogCallback = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// The log callback of FMI 3.
pub(crate) unsafe extern "C" fn log_message(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: C strings or NULL, by the standards.
    let (category, text) = unsafe { (text_of(category), text_of(message)) };
    if let Some(sink) = Sink::of(environment) {
        sink.push(LogMessage { status: Status::from_c(status), category, text });
    }
}

/// What `logger.c` makes of a message of FMI 2.
#[unsafe(no_mangle)]
unsafe extern "C" fn cosim_deliver(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    text: *const c_char,
) {
    // SAFETY: as for FMI 3.
    unsafe { log_message(environment, status, category, text) }
}

// SAFETY: `logger.c` defines it; the address alone is used here.
unsafe extern "C" {
    /// `fmi2CallbackLogger`, with the arguments of printf.
    fn cosim_log_fmi2(
        environment: *mut c_void,
        instance: *const c_char,
        status: c_int,
        category: *const c_char,
        message: *const c_char,
        ...
    );
}

/// `fmi2CallbackLogger`
type Logger2 = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`
#[repr(C)]
pub(crate) struct Callbacks {
    logger: Logger2,
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
        Box::new(Self { logger: cosim_log_fmi2, allocate: calloc, free, step_finished: None, environment })
    }
}
