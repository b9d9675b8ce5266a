//! Errors with their data; the text of each error is one sentence.
use crate::log::{LogMessage, Status};
use std::path::{Path, PathBuf};

/// A failure of this crate. `Display` gives one sentence naming what, where, and the limits.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was attempted: "open", "write", ...
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not an archive that can be unpacked safely, or not one of an FMU or a system.
    #[error("{} is not a usable {kind} archive: {reason}", path.display())]
    Archive {
        /// The archive.
        path: PathBuf,
        /// "FMU" or "SSP".
        kind: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that cannot be understood: a model description, an input table, a system of FMUs.
    #[error("{file}, line {line}: {message}")]
    Text {
        /// The file; of an archive with the path of the archive, when known.
        file: String,
        /// Line, from 1.
        line: u64,
        /// What is wrong there.
        message: String,
    },
    /// The binary cannot be loaded.
    #[error("cannot load {} of {}: {reason}", binary.display(), path.display())]
    Library {
        /// The archive.
        path: PathBuf,
        /// The binary, relative to the unpacked archive.
        binary: PathBuf,
        /// Message of the loader.
        reason: String,
    },
    /// An FMI function did not succeed.
    #[error("{function} of {instance} returned {status}{}{}", at(*time), because(messages))]
    Call {
        /// The name of the instance.
        instance: String,
        /// The C function.
        function: &'static str,
        /// Discard, Error, Fatal or Pending.
        status: Status,
        /// The communication point (s), for a step.
        time: Option<f64>,
        /// The last messages the FMU logged during the call.
        messages: Vec<LogMessage>,
    },
    /// The FMU reported Fatal earlier; it must not be called again.
    #[error("{function} of {instance} was not called because the FMU reported Fatal before")]
    Dead {
        /// The name of the instance.
        instance: String,
        /// The C function.
        function: &'static str,
    },
    /// The FMU, its version of the standard or the variable does not support the request.
    #[error("{name} {reason}")]
    Unsupported {
        /// The archive, the instance or the variable.
        name: String,
        /// A predicate: "is for Model Exchange only", with the words of the FMU if it refused.
        reason: String,
    },
    /// A call was made with lists that do not fit together, or a value its type cannot hold.
    #[error("{function} of {instance}: {reason}")]
    Misuse {
        /// The name of the instance.
        instance: String,
        /// The function.
        function: &'static str,
        /// What does not fit.
        reason: String,
    },
    /// No variable has this name.
    #[error("{model} has no variable {name}{}", suggestion(near))]
    UnknownVariable {
        /// The requested name.
        name: String,
        /// The model.
        model: String,
        /// Names that look alike, best first.
        near: Vec<String>,
    },
    /// The text is not a value of the variable's type.
    #[error("{name} = {text:?} is not {expected}")]
    BadValue {
        /// The variable.
        name: String,
        /// The text as given.
        text: String,
        /// The expected value: "a finite number", "one of off, slow, fast".
        expected: String,
    },
    /// The value lies outside the declared limits.
    #[error("{name} = {}{} is outside its limits {}{}{}", number(*value), spaced(unit), limits(*min, *max), spaced(unit), if *may_be_celsius { celsius(*value, unit, *min, *max) } else { String::new() })]
    OutOfRange {
        /// The variable.
        name: String,
        /// The value as given, in the variable's unit.
        value: f64,
        /// Declared minimum.
        min: Option<f64>,
        /// Declared maximum.
        max: Option<f64>,
        /// Declared unit.
        unit: Option<String>,
        /// Whether the value may be one in degC by mistake: not a difference of temperatures, nor a value with its unit.
        may_be_celsius: bool,
    },
    /// A simulation option makes no sense.
    #[error("{option} = {value} {reason}")]
    Option {
        /// "stop time", "step size", ...
        option: &'static str,
        /// The value as given.
        value: String,
        /// A predicate: "must be above the start time 0 s".
        reason: String,
    },
}

impl Error {
    /// The error of an action on a file.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| Self::Io { action, path: path.to_owned(), source }
    }

    /// The error of a name for which a predicate holds.
    pub(crate) fn unsupported(name: impl ToString, reason: impl Into<String>) -> Self {
        Self::Unsupported { name: name.to_string(), reason: reason.into() }
    }

    /// The error of an option with this value and a predicate.
    pub(crate) fn option(option: &'static str, value: impl ToString, reason: impl Into<String>) -> Self {
        Self::Option { option, value: value.to_string(), reason: reason.into() }
    }
}

fn at(time: Option<f64>) -> String {
    time.map(|t| format!(" at t = {} s", number(t))).unwrap_or_default()
}

/// A number for a message, with an exponent where the digits would be many zeros. All its digits are written.
pub fn number(x: f64) -> String {
    let plain = x.to_string();
    if plain.len() <= 20 { plain } else { format!("{x:e}") }
}

/// The FMU's messages, on one line.
pub(crate) fn because(messages: &[LogMessage]) -> String {
    let texts: Vec<String> =
        messages.iter().map(|m| m.text.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    if texts.is_empty() { String::new() } else { format!(": {}", texts.join("; ")) }
}

pub(crate) fn suggestion(near: &[String]) -> String {
    if near.is_empty() { String::new() } else { format!(", did you mean {}?", near.join(" or ")) }
}

fn spaced(unit: &Option<String>) -> String {
    unit.as_ref().filter(|u| *u != "1").map(|u| format!(" {u}")).unwrap_or_default()
}

fn limits(min: Option<f64>, max: Option<f64>) -> String {
    let text = |x: Option<f64>, none: &str| x.map_or(none.to_owned(), number);
    format!("{} ... {}", text(min, "-inf"), text(max, "inf"))
}

/// For a temperature that would be within its limits in degC.
fn celsius(value: f64, unit: &Option<String>, min: Option<f64>, max: Option<f64>) -> String {
    let kelvin = value + 273.15;
    let is_within = min.is_none_or(|min| kelvin >= min) && max.is_none_or(|max| kelvin <= max);
    if unit.as_deref() == Some("K") && is_within {
        format!("; {} degC is within them", number(value))
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_in_messages_have_no_rows_of_zeros() {
        for (value, text) in
            [(0.02, "0.02"), (1e300, "1e300"), (-1.5e-9, "-0.0000000015"), (1e-30, "1e-30"), (3.0, "3")]
        {
            assert_eq!(number(value), text);
        }
        assert_eq!(number(f64::MAX), "1.7976931348623157e308");
    }
}
