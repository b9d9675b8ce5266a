//! Findings of the validator, and their list.

use std::collections::HashMap;

pub(crate) use cosim::xml::short;
use cosim::{FmiVersion, number};
use serde::Serialize;

use super::rules::{Basis, Breach, Phase, Severity};

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
    /// What was checked.
    pub phase: Phase,
    /// Why the rule holds.
    pub basis: Basis,
    /// One sentence with variable, value, rule and the standard's section.
    pub message: String,
}

/// A message in which numbers with rows of zeros have an exponent.
fn readable(message: &str) -> String {
    let is_digit = |c: char| c.is_ascii_digit() || "+-.".contains(c);
    let mut out = String::new();
    let mut rest = message;
    while let Some(start) = rest.find(is_digit) {
        let length = rest[start..].find(|c| !is_digit(c)).unwrap_or(rest.len() - start);
        let text = &rest[start..start + length];
        out += &rest[..start];
        match text.parse::<f64>() {
            // Digits of integers and of binary data stay as they are.
            Ok(x) if length > 20 && (text.contains('.') || text.ends_with("0000")) => out += &number(x),
            _ => out += text,
        }
        rest = &rest[start + length..];
    }
    out + rest
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
            phase: rule.phase(),
            basis: rule.basis(),
            message: format!("{}{reference}.", readable(&message)),
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
            let Some(first) = self.list.iter().find(|f| f.code == code).cloned() else { continue };
            let message = format!("{} more findings of this kind are not listed.", count - MOST_PER_RULE);
            self.list.push(Finding { place: String::new(), message, ..first });
        }
        self.list
    }
}
