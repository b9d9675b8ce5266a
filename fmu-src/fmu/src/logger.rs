//! Messages to the importer.
//!
//! An operation puts its messages into a queue. [`crate::boundary`] delivers them after the operation, when no Rust reference to the
//! instance exists. A message is put into the queue only if its category is enabled, so that the queue of an instance without logging
//! stays empty and costs no memory.
//!
//! With logging off nothing is sent, errors included: "`logMessage` must only be called for log categories that were enabled by calls to
//! `fmi3SetDebugLogging` or via `loggingOn`" (FMI 3.0.2 section 2.3.1; FMI 2.0.5 section 2.1.5 with "should"). The one exception is an
//! instantiation that fails: then the logger "is called with detailed information about the reason" (the same sections), because no
//! instance exists whose categories could be enabled.

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

/// Log categories, the same in both model descriptions: name and description. The last one stands for all.
pub const CATEGORIES: &[(&str, &str)] = physics::model::LOG_CATEGORIES;

/// The category of a message: its place in [`CATEGORIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Category {
    /// A call that returns Error.
    Error = 0,
    /// A call that returns Discard.
    Discard = 1,
    /// A call that returns Warning, or the end of a run.
    Warning = 2,
    /// A change of the life cycle, an event.
    Events = 3,
    /// Rejected steps of the integrator.
    Steps = 4,
}

/// All categories enabled.
const ALL: u8 = (1 << (CATEGORIES.len() - 1)) - 1;

impl Category {
    fn name(self) -> &'static str {
        CATEGORIES[self as usize].0
    }

    /// The category of a call with this status.
    fn of(status: Status) -> Category {
        match status {
            Status::Ok => Category::Events,
            Status::Warning => Category::Warning,
            Status::Discard => Category::Discard,
            Status::Error | Status::Fatal => Category::Error,
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
    /// Messages of the instance of this name.
    pub fn new(sink: Sink, instance: &str, on: bool) -> Log {
        Log { sink, instance: instance.to_string(), enabled: if on { ALL } else { 0 }, queue: Vec::new() }
    }

    /// Enables or disables categories, by their places in [`CATEGORIES`]; all of them if there are none.
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

    /// Puts a message of a category into the queue; the text is made if the category is enabled.
    #[inline]
    pub fn note(&mut self, category: Category, text: impl FnOnce() -> String) {
        if self.wants(category) {
            let status = if category == Category::Warning { Status::Warning } else { Status::Ok };
            self.queue.push(Message { status, category, text: text() });
        }
    }

    /// Puts the reason of a status into the queue.
    pub fn reason(&mut self, status: Status, text: &str) {
        let category = Category::of(status);
        if self.wants(category) {
            self.queue.push(Message { status, category, text: text.to_string() });
        }
    }

    /// Whether messages wait for their delivery.
    #[inline]
    pub fn is_waiting(&self) -> bool {
        !self.queue.is_empty()
    }

    /// The waiting messages of a call, as C needs them.
    pub fn take(&mut self, function: &str) -> Delivery {
        let messages = std::mem::take(&mut self.queue).into_iter();
        let messages = messages.map(|message| {
            let text = format!("{function}: {}", message.text);
            (message.status, c_string(message.category.name()), c_string(&escaped(&text)))
        });
        Delivery { sink: self.sink, instance: c_string(&self.instance), messages: messages.collect() }
    }
}

/// Messages that do not depend on an instance any more.
pub struct Delivery {
    sink: Sink,
    instance: CString,
    messages: Vec<(Status, CString, CString)>,
}

impl Delivery {
    /// The reason of an instantiation that fails.
    pub fn of_failure(sink: Sink, instance: &str, text: &str) -> Delivery {
        let message = (Status::Error, c_string(Category::Error.name()), c_string(&escaped(text)));
        Delivery { sink, instance: c_string(instance), messages: vec![message] }
    }

    /// Calls the importer's logger.
    ///
    /// # Safety
    /// The logger and its environment are still those of the importer, and no Rust reference to the instance exists.
    pub unsafe fn send(self) {
        for (status, category, text) in &self.messages {
            // SAFETY: all strings live over the call, and the format takes the one argument it gets.
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

/// A text in which `#` is no reference to a variable (FMI 2.0.5 section 2.1.5, FMI 3.0.2 section 2.3.1).
fn escaped(text: &str) -> String {
    text.replace('#', "##")
}

/// A C string of the text; a zero inside, which C could not carry, becomes a space.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn categories_have_their_places_and_the_last_one_stands_for_all() {
        for (category, name) in [
            (Category::Error, "logStatusError"),
            (Category::Discard, "logStatusDiscard"),
            (Category::Warning, "logStatusWarning"),
            (Category::Events, "logEvents"),
            (Category::Steps, "logRejectedSteps"),
        ] {
            assert_eq!(category.name(), name);
        }
        assert_eq!(CATEGORIES.last().map(|(name, _)| *name), Some("logAll"));
        assert_eq!(ALL.count_ones() as usize, CATEGORIES.len() - 1);
    }

    #[test]
    fn a_zero_and_a_hash_do_not_reach_the_importer() {
        assert_eq!(c_string("a\0b").as_c_str(), c"a b");
        assert_eq!(escaped("segment #3"), "segment ##3");
    }
}
