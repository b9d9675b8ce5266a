//! What the child process reports to the parent: events, and findings of the stages.

use std::cell::RefCell;

use serde::{Deserialize, Serialize};

use super::facts::Variable;
use crate::validate::rules::Breach;

/// A message of the child process to the parent, one line each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Event {
    /// A stage begins: its number and its description.
    Begin(usize, String),
    /// Something was found.
    Seen(Observation),
    /// The stages from this one on need another process.
    Next(usize),
}

/// A finding before the parent adds severity and section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Code of the rule.
    pub code: String,
    /// `modelDescription.xml:12` or the library's name in the archive.
    pub place: String,
    /// The sentence.
    pub message: String,
}

/// A finding that ends its stage.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: String,
    pub(super) breach: Breach,
}

impl Fault {
    pub(super) fn new<T>(place: &str, breach: Breach) -> Result<T, Fault> {
        Err(Fault { place: place.to_owned(), breach })
    }

    /// Adds the variable that was set or read.
    pub(super) fn about(mut self, variable: &Variable, values: &[f64]) -> Fault {
        self.place.clone_from(&variable.place);
        self.breach.message += &match values {
            [] => format!(" (variable {variable})"),
            [first, ..] => format!(" (variable {variable}, value {first})"),
        };
        self
    }
}

/// The channel to the parent process.
pub(super) struct Channel<'a>(RefCell<&'a mut dyn FnMut(Event)>);

impl<'a> Channel<'a> {
    pub(super) fn new(send: &'a mut dyn FnMut(Event)) -> Self {
        Channel(RefCell::new(send))
    }

    pub(super) fn send(&self, event: Event) {
        (self.0.borrow_mut())(event);
    }
}

pub(super) struct Seen<'a> {
    pub(super) channel: &'a Channel<'a>,
    /// Findings that were reported already: several stages may detect the same fault.
    reported: Vec<(&'static str, String)>,
    pub(super) failed: bool,
}

impl<'a> Seen<'a> {
    pub(super) fn new(channel: &'a Channel<'a>) -> Self {
        Seen { channel, reported: Vec::new(), failed: false }
    }

    /// Reports a finding, unless it has been reported.
    pub(super) fn add(&mut self, place: &str, Breach { rule, message }: Breach) {
        let key = (rule.code, place.to_owned());
        if self.reported.contains(&key) {
            return;
        }
        self.reported.push(key);
        self.failed = true;
        let (code, place) = (rule.code.to_owned(), place.to_owned());
        self.channel.send(Event::Seen(Observation { code, place, message }));
    }
}
