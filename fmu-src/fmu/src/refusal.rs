//! Error of a rejected call: status and message.

use crate::logger::Status;

/// Reason for a rejected call.
#[derive(Debug)]
pub struct Refused {
    /// Status that the importer receives.
    pub status: Status,
    /// One sentence for the log.
    pub message: String,
}

impl Refused {
    /// A call that is not allowed.
    pub fn error(message: impl Into<String>) -> Refused {
        Refused { status: Status::Error, message: message.into() }
    }

    /// A rejected value.
    pub fn discard(message: impl Into<String>) -> Refused {
        Refused { status: Status::Discard, message: message.into() }
    }
}

/// Result of an operation.
pub type Outcome<T = ()> = Result<T, Refused>;
