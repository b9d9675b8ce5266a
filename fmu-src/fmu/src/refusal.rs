//! Error of a rejected call: status and message.

use crate::logger::Status;

/// Why a call is refused.
#[derive(Debug)]
pub struct Refused {
    /// Status that the importer receives.
    pub status: Status,
    /// One sentence for its log.
    pub message: String,
}

impl Refused {
    /// A call that is not allowed.
    pub fn error(message: impl Into<String>) -> Refused {
        Refused { status: Status::Error, message: message.into() }
    }

    /// A value that is refused.
    pub fn discard(message: impl Into<String>) -> Refused {
        Refused { status: Status::Discard, message: message.into() }
    }
}

/// What an operation gives.
pub type Outcome<T = ()> = Result<T, Refused>;
