//! Messages to the importer.
//!
//! An operation queues its messages. [`crate::boundary`] delivers them after the operation, when no Rust reference to the instance
//! exists. A message is queued only if its category is enabled, so that the queue of an instance without logging is empty and
//! allocates no memory.
//!
//! With logging off nothing is sent, not even errors: "`logMessage` must only be called for log categories that were enabled by calls to
//! `fmi3SetDebugLogging` or via `loggingOn`" (FMI 3.0.2 section 2.3.1; FMI 2.0.5 section 2.1.5 with "should"). The only exception is a
//! failed instantiation: then the logger "is called with detailed information about the reason" (the same sections), because no
//! instance exists whose categories could be enabled.

use std::ffi::{CString, c_char, c_int, c_void};

/// Status of a call, with the numbers of both standards.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// Success, with a message.
    Warning = 1,
    /// The value or the step is rejected. The instance is unchanged.
    Discard = 2,
    /// The call is not allowed, or the model has failed. The instance is unchanged.
    Error = 3,
    /// The instance can no longer be used.
    Fatal = 4,
}

/// Log categories, the same in both model descriptions: name and description. The last one is logAll.
pub const CATEGORIES: &[(&str, &str)] = physics::model::LOG_CATEGORIES;

/// Category of a message: its index in [`CATEGORIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Category {
    /// A call that returns Error.
    Error = 0,
    /// A call that returns Discard.
    Discard = 1,
    /// A call that returns Warning, or the end of a run.
    Warning = 2,
    /// A mode change or an event.
    Events = 3,
    /// Rejected steps of the integrator.
    Steps = 4,
}

/// All categories enabled.
pub const ALL: u8 = (1 << (CATEGORIES.len() - 1)) - 1;

impl Category {
    /// Its name in the model description.
    pub fn name(self) -> &'static str {
        CATEGORIES[self as usize].0
    }

    /// Category of a call with this status.
    fn of(status: Status) -> Category {
        match status {
            Status::Ok => Category::Events,
            Status::Warning => Category::Warning,
            Status::Discard => Category::Discard,
            Status::Error | Status::Fatal => Category::Error,
        }
    }
}

/// FMI 2 logger: environment, instance, status, category, printf format and its arguments.
pub type Logger2 = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);
/// FMI 3 logger: environment, status, category, message.
pub type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// Destination of messages.
#[derive(Clone, Copy)]
pub enum Sink {
    /// None: the importer gave no logger.
    None,
    /// FMI 2 logger.
    Fmi2(Logger2, *mut c_void),
    /// FMI 3 logger.
    Fmi3(Logger3, *mut c_void),
}

/// A message.
struct Message {
    status: Status,
    category: Category,
    text: String,
}

/// The messages of one instance.
pub struct Log {
    sink: Sink,
    instance: String,
    /// One bit for each category.
    enabled: u8,
    queue: Vec<Message>,
}

impl Log {
    /// Messages of the instance with this name.
    pub fn new(sink: Sink, instance: &str, on: bool) -> Log {
        Log { sink, instance: instance.to_string(), enabled: if on { ALL } else { 0 }, queue: Vec::new() }
    }

    /// Enables or disables categories by their index in [`CATEGORIES`]; all of them if the list is empty.
    pub fn enable(&mut self, on: bool, categories: &[usize]) {
        let bit = |place: &usize| if *place == CATEGORIES.len() - 1 { ALL } else { 1 << place };
        let chosen =
            if categories.is_empty() { ALL } else { categories.iter().map(bit).fold(0, |a, b| a | b) };
        self.enabled = if on { self.enabled | chosen } else { self.enabled & !chosen };
    }

    /// Whether any category is enabled.
    #[inline]
    pub fn is_on(&self) -> bool {
        self.enabled != 0
    }

    /// Whether messages of a category are sent.
    #[inline]
    pub fn wants(&self, category: Category) -> bool {
        self.enabled & (1 << category as u8) != 0 && !matches!(self.sink, Sink::None)
    }

    /// Queues a message of a category; the text is created only if the category is enabled.
    #[inline]
    pub fn note(&mut self, category: Category, text: impl FnOnce() -> String) {
        if self.wants(category) {
            let status = if category == Category::Warning { Status::Warning } else { Status::Ok };
            self.queue.push(Message { status, category, text: text() });
        }
    }

    /// Queues the reason for a status.
    pub fn reason(&mut self, status: Status, text: &str) {
        let category = Category::of(status);
        if self.wants(category) {
            self.queue.push(Message { status, category, text: text.to_string() });
        }
    }

    /// Whether messages are queued.
    #[inline]
    pub fn is_waiting(&self) -> bool {
        !self.queue.is_empty()
    }

    /// Removes the queued messages of a call and converts them for C.
    pub fn take(&mut self, function: &str) -> Delivery {
        let messages = std::mem::take(&mut self.queue).into_iter();
        let messages = messages.map(|message| {
            let text = format!("{function}: {}", message.text);
            (message.status, c_string(message.category.name()), c_string(&escaped(&text)))
        });
        Delivery { sink: self.sink, instance: c_string(&self.instance), messages: messages.collect() }
    }
}

/// Messages that no longer depend on an instance.
pub struct Delivery {
    sink: Sink,
    instance: CString,
    messages: Vec<(Status, CString, CString)>,
}

impl Delivery {
    /// The reason for a failed instantiation.
    pub fn of_failure(sink: Sink, instance: &str, text: &str) -> Delivery {
        let message = (Status::Error, c_string(Category::Error.name()), c_string(&escaped(text)));
        Delivery { sink, instance: c_string(instance), messages: vec![message] }
    }

    /// Calls the importer's logger.
    ///
    /// # Safety
    /// The logger and its environment are still valid, and no Rust reference to the instance exists.
    pub unsafe fn send(self) {
        for (status, category, text) in &self.messages {
            // SAFETY: all strings are valid during the call, and the format has one argument.
            unsafe {
                match self.sink {
                    Sink::None => {}
                    Sink::Fmi2(logger, environment) => logger(
                        environment,
                        self.instance.as_ptr(),
                        *status as c_int,
                        category.as_ptr(),
                        c"%s".as_ptr(),
                        text.as_ptr(),
                    ),
                    Sink::Fmi3(logger, environment) => {
                        logger(environment, *status as c_int, category.as_ptr(), text.as_ptr());
                    }
                }
            }
        }
    }
}

/// The text with `#` escaped, so that it is no variable reference (FMI 2.0.5 section 2.1.5, FMI 3.0.2 section 2.3.1).
pub fn escaped(text: &str) -> String {
    text.replace('#', "##")
}

/// The text as a C string; a zero inside is replaced by a space.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}
