//! What the child does: all stages for all interface types, each event told as it happens.

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::time::{Duration, Instant};

use cosim::Archive;
use cosim::raw::RawBinary;
use serde::{Deserialize, Serialize};

use super::facts::{Facts, Variable};
use super::session::{Subject, name_of};
use super::stages::{self, Stage};
use crate::validate::finding::short;
use crate::validate::rules::{self, Rule};

/// What the child tells the parent, one line each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Event {
    /// A stage begins: its place in the order, and what it does in words.
    Begin(usize, String),
    /// Calls still return; said now and then, so that a slow FMU is not taken for a hung one.
    Alive,
    /// Something was found.
    Seen(Observation),
    /// All stages are through.
    End,
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
    pub(super) rule: &'static Rule,
    pub(super) place: String,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn new(rule: &'static Rule, place: &str, message: impl Into<String>) -> Fault {
        Fault { rule, place: place.to_owned(), message: message.into() }
    }

    /// Adds the variable that was set or read.
    pub(super) fn about(mut self, variable: &Variable, values: &[f64]) -> Fault {
        self.place.clone_from(&variable.place);
        self.message += &match values {
            [] => format!(" (variable \"{}\")", short(&variable.name)),
            [first, ..] => format!(" (variable \"{}\", value {first})", short(&variable.name)),
        };
        self
    }
}

/// How often a sign of life is enough.
const PULSE: Duration = Duration::from_secs(1);

/// The way to the parent.
pub(super) struct Line<'a> {
    tell: RefCell<&'a mut dyn FnMut(Event)>,
    last: Cell<Instant>,
}

impl Line<'_> {
    fn tell(&self, event: Event) {
        self.last.set(Instant::now());
        (self.tell.borrow_mut())(event);
    }
}

/// Something that wants to know that calls return.
pub(super) trait Pulse {
    /// A call has returned.
    fn alive(&self);
}

impl Pulse for Line<'_> {
    fn alive(&self) {
        if self.last.get().elapsed() > PULSE {
            self.tell(Event::Alive);
        }
    }
}

/// Where stages put what they find.
pub(super) struct Seen<'a> {
    line: &'a Line<'a>,
    /// What has been said already: the same fault may show in several stages.
    said: Vec<(&'static str, String)>,
    failed: bool,
}

impl Seen<'_> {
    /// Tells a finding, unless it has been told.
    pub(super) fn add(&mut self, rule: &'static Rule, place: &str, message: impl Into<String>) {
        let key = (rule.code, place.to_owned());
        if self.said.contains(&key) {
            return;
        }
        self.said.push(key);
        self.failed = true;
        let (code, place) = (rule.code.to_owned(), place.to_owned());
        self.line.tell(Event::Seen(Observation { code, place, message: message.into() }));
    }
}

/// Loads and runs the FMU in this process, beginning with stage number `from`.
pub fn probe(file: &Path, from: usize, tell: &mut dyn FnMut(Event)) {
    let line = Line { tell: RefCell::new(tell), last: Cell::new(Instant::now()) };
    run(file, from, &mut Seen { line: &line, said: Vec::new(), failed: false });
    line.tell(Event::End);
}

fn run(file: &Path, from: usize, seen: &mut Seen) {
    let archive = match Archive::open(file) {
        Ok(archive) => archive,
        Err(error) => return seen.add(&rules::NOT_RUN, "archive", sentence(&error)),
    };
    let Some(facts) = Facts::read(archive.dir()) else { return };
    let mut number = 0;
    for interface in &facts.interfaces {
        let first = number;
        number += stages::ALL.len();
        if number <= from {
            continue;
        }
        let place = &interface.place;
        if interface.needs_tool {
            let message = format!(
                "The FMU was not run for {}: it needs another program to be installed",
                name_of(interface.kind)
            );
            seen.add(&rules::NOT_RUN, place, message);
            continue;
        }
        seen.line.tell(Event::Begin(first, "loading the library".to_owned()));
        let binary = match RawBinary::load(&archive, &interface.identifier) {
            Ok(binary) => binary,
            Err(error @ cosim::Error::Library { .. }) => {
                seen.add(&rules::LOAD, place, sentence(&error));
                continue;
            }
            Err(error) => {
                seen.add(&rules::NOT_RUN, place, format!("The FMU was not run: {}", sentence(&error)));
                continue;
            }
        };
        let place = format!("{} ({})", interface.identifier, name_of(interface.kind));
        let subject = Subject {
            archive: &archive,
            facts: &facts,
            interface,
            binary,
            place,
            base: Default::default(),
            line: seen.line,
        };
        for (i, stage) in stages::ALL.iter().enumerate().filter(|(i, _)| first + i >= from) {
            let before = std::mem::take(&mut seen.failed);
            let ended = run_stage(stage, first + i, &subject, seen);
            let failed = std::mem::replace(&mut seen.failed, before);
            // Without a life cycle there is nothing to look at.
            if stage.is_basis && failed && !ended {
                break;
            }
        }
    }
}

/// Whether the stage came to its end.
fn run_stage(stage: &Stage, number: usize, subject: &Subject, seen: &mut Seen) -> bool {
    if !(stage.applies)(subject) {
        return true;
    }
    let words = format!("{}: {}", name_of(subject.interface.kind), stage.what);
    seen.line.tell(Event::Begin(number, words));
    match (stage.run)(subject, seen) {
        Ok(()) => true,
        Err(fault) => {
            seen.add(fault.rule, &fault.place, fault.message);
            false
        }
    }
}

fn sentence(error: &cosim::Error) -> String {
    error.to_string().trim_end_matches('.').to_owned()
}
