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

/// What is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// The zip archive.
    Archive,
    /// The XML files and their schemas.
    Xml,
    /// What the model description means.
    Semantics,
    /// Other files and libraries.
    Files,
    /// The running FMU.
    Behaviour,
    /// Answers to calls that importers must not make.
    Misuse,
}

/// Why a rule holds. Only breaches of the first three are errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// The text of the standard, in the section that is named.
    Standard,
    /// The FMU's own declarations: it contradicts what it says itself.
    Declaration,
    /// Reading the archive or running the FMU is dangerous.
    Safety,
    /// Experience of this project; the standard does not require it.
    Practice,
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
    /// Section of FMI 2.0.5.
    pub fmi2: &'static str,
    /// Section of FMI 3.0.2.
    pub fmi3: &'static str,
}

/// A breach of a rule, in a sentence without its full stop.
#[derive(Debug)]
pub(crate) struct Breach {
    pub(crate) rule: &'static Rule,
    pub(crate) message: String,
}

/// Rules that follow from a declaration of the FMU; a section, if any, defines this declaration.
const BY_DECLARATION: [&str; 5] =
    ["reference-differs", "unit-contradiction", "unit-exponents", "derivative-unit", "step-size"];
const FOR_SAFETY: [&str; 8] = [
    "archive-bomb",
    "entry-duplicate",
    "entry-outside",
    "entry-header",
    "entry-damaged",
    "xml-doctype",
    "xml-depth",
    "time-limit",
];

impl Rule {
    /// Why the rule holds.
    pub fn basis(&self) -> Basis {
        match self.code {
            code if BY_DECLARATION.contains(&code) => Basis::Declaration,
            code if FOR_SAFETY.contains(&code) => Basis::Safety,
            _ if self.fmi2.is_empty() && self.fmi3.is_empty() => Basis::Practice,
            _ => Basis::Standard,
        }
    }

    /// What it checks: the table is in the order of the phases.
    pub fn phase(&self) -> Phase {
        let place = |code: &str| ALL.iter().position(|r| r.code == code);
        let at = place(self.code);
        let begins = |rule: &Rule| at >= place(rule.code);
        if begins(&TOKEN_UNCHECKED) {
            Phase::Misuse
        } else if begins(&NOT_RUN) {
            Phase::Behaviour
        } else if begins(&NO_IMPLEMENTATION) {
            Phase::Files
        } else if begins(&INTERFACE_MISSING) {
            Phase::Semantics
        } else if begins(&XML_NOT_UTF8) {
            Phase::Xml
        } else {
            Phase::Archive
        }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_a_basis_beyond_practice() {
        for rule in ALL.iter() {
            assert!(rule.severity != Severity::Error || rule.basis() != Basis::Practice, "{}", rule.code);
        }
        for code in BY_DECLARATION.iter().chain(&FOR_SAFETY) {
            assert!(ALL.iter().any(|r| r.code == *code), "{code}");
        }
    }

    /// The numbers of the headings of chapters 2 to 4 in the texts of the standards.
    const HEADINGS: [&str; 2] = [
        "2 2.1 2.1.1-9 2.2 2.2.1-9 2.3 2.3.1-2 3 3.1 3.2 3.2.1-4 3.3 3.3.1-2 4 4.1 4.1.1-2 4.2 4.2.1-5 4.3 4.3.1-2",
        "2 2.1 2.2 2.2.1-12 2.2.7.1-4 2.2.8.1-4 2.2.12.1-2 2.3 2.3.1-8 2.4 2.4.1-10 2.4.7.1-5 2.4.7.5.1 2.4.9.1-2 2.4.9.1.1-4 \
         2.4.9.2.1-7 2.4.10.1-7 2.5 2.5.1-4 2.5.1.1-6 2.5.1.1.1 2.5.1.4.1-3 2.5.4.1-2 2.6 3 3.1 3.1.1 3.2 3.2.1 3.3 3.4 \
         3.4.1 4 4.1 4.1.1-3 4.2 4.2.1-2 4.3 4.3.1-5 4.4 4.4.1 4.4.1.1",
    ];

    #[test]
    fn sections_exist_in_the_standards() {
        let exists = |headings: &str, section: &str| {
            headings.split_whitespace().any(|heading| match heading.split_once('-') {
                None => heading == section,
                Some((first, last)) => {
                    let (above, from) = first.rsplit_once('.').unwrap();
                    let numbers = from.parse::<u32>().unwrap()..=last.parse().unwrap();
                    section
                        .rsplit_once('.')
                        .is_some_and(|(a, n)| a == above && n.parse().is_ok_and(|n| numbers.contains(&n)))
                }
            })
        };
        assert!(!exists(HEADINGS[0], "2.1.10") && !exists(HEADINGS[1], "2.4.7.6"));
        for rule in ALL.iter() {
            for (headings, section) in HEADINGS.iter().zip([rule.fmi2, rule.fmi3]) {
                assert!(section.is_empty() || exists(headings, section), "{}: {section}", rule.code);
            }
        }
    }

    #[test]
    fn phases_follow_each_other() {
        let phases: Vec<Phase> = ALL.iter().map(|r| r.phase()).collect();
        let changes = phases.windows(2).filter(|two| two[0] != two[1]).count();
        assert_eq!((phases[0], changes, phases[phases.len() - 1]), (Phase::Archive, 5, Phase::Misuse));
        assert_eq!((CRASH.phase(), ENTRY_LINK.phase()), (Phase::Behaviour, Phase::Archive));
    }
}
