//! Findings of the validator, and their list.

use std::collections::HashMap;

use cosim::FmiVersion;
pub(crate) use cosim::xml::short;
use serde::Serialize;

use super::rules::{Breach, Severity};

/// One thing the validator noticed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Its severity.
    pub severity: Severity,
    /// The rule's short name, a key into [`super::rules::ALL`].
    pub code: &'static str,
    /// Where: `modelDescription.xml:12` or the name of an archive entry.
    #[serde(rename = "where")]
    pub place: String,
    /// One sentence with variable, value, rule and the standard's section.
    pub message: String,
}

/// A file with one systematic fault in ten thousand variables is described well enough by this many lines.
const MOST_PER_RULE: usize = 200;

/// The findings of one run, and the standard whose sections their messages cite.
pub(crate) struct Findings {
    pub(crate) version: FmiVersion,
    list: Vec<Finding>,
    counts: HashMap<&'static str, usize>,
}

impl Findings {
    pub(crate) fn new() -> Self {
        Findings { version: FmiVersion::V3, list: Vec::new(), counts: HashMap::new() }
    }

    pub(crate) fn add(&mut self, place: impl Into<String>, Breach { rule, message }: Breach) {
        let count = self.counts.entry(rule.code).or_insert(0);
        *count += 1;
        if *count > MOST_PER_RULE {
            return;
        }
        let (standard, section) = match self.version {
            FmiVersion::V2 => ("FMI 2.0", rule.fmi2),
            FmiVersion::V3 => ("FMI 3.0", rule.fmi3),
        };
        let reference =
            if section.is_empty() { String::new() } else { format!(" ({standard}, section {section})") };
        self.list.push(Finding {
            severity: rule.severity,
            code: rule.code,
            place: place.into(),
            message: format!("{message}{reference}."),
        });
    }

    /// Whether any error has been found so far.
    pub(crate) fn any_error(&self) -> bool {
        self.list.iter().any(|f| f.severity == Severity::Error)
    }

    /// The list; the last line of a rule with many findings gives the number of those that are not listed.
    pub(crate) fn into_list(mut self) -> Vec<Finding> {
        let mut cut: Vec<_> = self.counts.into_iter().filter(|(_, n)| *n > MOST_PER_RULE).collect();
        cut.sort_unstable();
        for (code, count) in cut {
            let severity = self.list.iter().find(|f| f.code == code).map_or(Severity::Note, |f| f.severity);
            self.list.push(Finding {
                severity,
                code,
                place: String::new(),
                message: format!("{} more findings of this kind are not listed.", count - MOST_PER_RULE),
            });
        }
        self.list
    }
}
