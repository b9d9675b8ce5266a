//! The child process: all stages for all interface types; each event is reported immediately.

use std::path::Path;

use cosim::Archive;
use cosim::raw::RawBinary;

use super::facts::Facts;
use super::report::{Channel, Event, Seen};
use super::stages::{self, Stage};
use super::subject::Subject;
use crate::validate::rules;

/// Loads and runs the FMU in this process, beginning with stage number `from`.
pub fn probe(file: &Path, from: usize, send: &mut dyn FnMut(Event)) {
    let channel = Channel::new(send);
    run(file, from, &mut Seen::new(&channel));
}

fn run(file: &Path, from: usize, seen: &mut Seen) {
    let archive = match Archive::open(file) {
        Ok(archive) => archive,
        Err(error) => return seen.add("archive", rules::cannot_run(sentence(&error))),
    };
    let Some(facts) = Facts::read(&archive) else {
        return seen.add(
            "archive",
            rules::NOT_RUN.says("The FMU was not run: its model description cannot be read"),
        );
    };
    if facts.interfaces.is_empty() {
        return seen.add("archive", rules::NOT_RUN.says("The FMU was not run: it has no interface"));
    }
    let mut number = 0;
    for interface in &facts.interfaces {
        let first = number;
        number += stages::ALL.len();
        if number <= from {
            continue;
        }
        let place = &interface.place();
        if interface.needs_execution_tool {
            seen.add(place, rules::needs_another_program(interface.kind));
            continue;
        }
        seen.channel.send(Event::Begin(first, "loading the library".to_owned()));
        let binary = match RawBinary::load(&archive, &interface.model_identifier) {
            Ok(binary) => binary,
            Err(error @ cosim::Error::Library { .. }) => {
                seen.add(place, rules::LOAD.says(sentence(&error)));
                continue;
            }
            Err(error) => {
                seen.add(place, rules::cannot_run(sentence(&error)));
                continue;
            }
        };
        let place = format!("{} ({})", interface.model_identifier, interface.kind);
        let subject = Subject {
            archive: &archive,
            facts: &facts,
            interface,
            binary,
            place,
            base: Default::default(),
            pool: Default::default(),
        };
        for (i, stage) in stages::ALL.iter().enumerate().filter(|(i, _)| first + i >= from) {
            let before = std::mem::take(&mut seen.failed);
            let ended = run_stage(stage, first + i, &subject, seen);
            let failed = std::mem::replace(&mut seen.failed, before);
            // The other stages need a complete life cycle.
            if stage.is_basis && failed && !ended {
                break;
            }
        }
        // Another interface type is another instance.
        if interface.only_once_per_process && number < stages::ALL.len() * facts.interfaces.len() {
            seen.channel.send(Event::Next(number));
            return;
        }
    }
}

/// Whether the stage came to its end.
fn run_stage(stage: &Stage, number: usize, subject: &Subject, seen: &mut Seen) -> bool {
    if !(stage.applies)(subject) {
        return true;
    }
    let words = format!("{}: {}", subject.interface.kind, stage.what);
    seen.channel.send(Event::Begin(number, words));
    match (stage.run)(subject, seen) {
        Ok(()) => true,
        Err(fault) => {
            seen.add(&fault.place, fault.breach);
            false
        }
    }
}

fn sentence(error: &cosim::Error) -> String {
    error.to_string().trim_end_matches('.').to_owned()
}
