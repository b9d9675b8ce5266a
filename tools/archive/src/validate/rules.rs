//! Every rule of the validator, in one table: code, severity, title, and the sections of the two standards.
//!
//! An empty section means that the standard has no such rule and the check is one of common sense.

mod behaviour;
mod fmu;

pub use behaviour::*;
pub use fmu::*;
use serde::Serialize;
use std::sync::LazyLock;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A breach of the standard or of the FMU's own declarations.
    Error,
    /// Doubtful practice: allowed, but a known source of trouble.
    Warning,
    /// Information.
    Note,
}

/// A rule.
#[derive(Debug)]
pub struct Rule {
    /// Short and unique code of a finding.
    pub code: &'static str,
    /// Severity of a breach.
    pub severity: Severity,
    /// The condition in a few words.
    pub title: &'static str,
    /// Section of FMI 2.0 (numbering of 2.0.4).
    pub fmi2: &'static str,
    /// Section of FMI 3.0.
    pub fmi3: &'static str,
}

/// A breach of a rule, in a sentence without its full stop.
#[derive(Debug)]
pub(crate) struct Breach {
    pub(crate) rule: &'static Rule,
    pub(crate) message: String,
}

impl Rule {
    pub(crate) fn says(&'static self, message: impl Into<String>) -> Breach {
        Breach { rule: self, message: message.into() }
    }
}

/// Declares rules: name, code, severity, title, sections in both standards, and the sentences of a breach, each a function of
/// the parts that it names.
macro_rules! rules {
    ($($name:ident $code:literal $severity:ident $title:literal $fmi2:literal $fmi3:literal
        $($sentence:ident($($part:ident),*) $text:literal)*;)*) => {
        use super::{Breach, Rule, Severity};
        use std::fmt::Display;

        $(
            #[doc = $title]
            pub static $name: Rule = Rule {
                code: $code, severity: Severity::$severity, title: $title, fmi2: $fmi2, fmi3: $fmi3,
            };
            $(
                #[doc = $title]
                pub(crate) fn $sentence($($part: impl Display),*) -> Breach {
                    $name.says(format!($text))
                }
            )*
        )*
        /// The rules in the order in which they are checked.
        pub(super) static ALL: &[&Rule] = &[$(&$name),*];
    };
}
use rules;

/// All rules, in the order in which they are checked.
pub static ALL: LazyLock<Vec<&Rule>> = LazyLock::new(|| [fmu::ALL, behaviour::ALL].concat());

/// Whether an FMU that breaks this rule can still be read: all but the rules on archive, XML and schemas.
pub(super) fn leaves_readable(code: &str) -> bool {
    let place = |code: &str| ALL.iter().position(|r| r.code == code);
    place(code) >= place(INTERFACE_MISSING.code)
}
