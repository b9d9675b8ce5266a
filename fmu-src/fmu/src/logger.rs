//! Messages to the importer.

use std::ffi::{CString, c_char, c_int, c_void};

/// Severity of a call's outcome, with the numbers of both standards.
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
    /// The instance cannot be used any more.
    Fatal = 4,
}

/// Log categories, the same in both model descriptions: name and description.
pub const CATEGORIES: &[(&str, &str)] = physics::model::LOG_CATEGORIES;

impl Status {
    fn category(self) -> &'static str {
        match self {
            Status::Ok => "logEvents",
            Status::Warning => "logStatusWarning",
            Status::Discard => "logStatusDiscard",
            Status::Error | Status::Fatal => "logStatusError",
        }
    }
}

/// FMI 2's logger: environment, instance, status, category, printf format and its arguments.
pub type Logger2 = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);
/// FMI 3's logger: environment, status, category, message.
pub type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// Where messages go.
#[derive(Clone, Copy)]
pub enum Sink {
    /// Nowhere: the importer gave no logger.
    None,
    /// To FMI 2's logger.
    Fmi2(Logger2, *mut c_void),
    /// To FMI 3's logger.
    Fmi3(Logger3, *mut c_void),
}

/// The messages of one instance.
pub struct Log {
    sink: Sink,
    instance: CString,
    /// Whether events are logged; rejected calls and failures are always logged.
    pub on: bool,
}

impl Log {
    /// Messages of the instance of this name.
    pub fn new(sink: Sink, instance: &str, on: bool) -> Log {
        Log { sink, instance: c_string(instance), on }
    }

    /// Logs a message; [`Status::Ok`] is an event.
    pub fn send(&self, status: Status, message: &str) {
        if status == Status::Ok && !self.on {
            return;
        }
        let (category, message) = (c_string(status.category()), c_string(message));
        // SAFETY: the importer gave the function and its environment for the life of the instance; all strings
        // live over the call, and the format takes the one argument it gets.
        unsafe {
            match self.sink {
                Sink::None => {}
                Sink::Fmi2(logger, environment) => logger(
                    environment,
                    self.instance.as_ptr(),
                    status as c_int,
                    category.as_ptr(),
                    c"%s".as_ptr(),
                    message.as_ptr(),
                ),
                Sink::Fmi3(logger, environment) => {
                    logger(environment, status as c_int, category.as_ptr(), message.as_ptr());
                }
            }
        }
    }
}

/// A C string of the text; a zero inside, which C could not carry, becomes a space.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}
