//! Messages about mode changes, events and rejected steps (`logEvents`, `logRejectedSteps`).
//!
//! They are created only if logging is on. Values are read from a copy of the model, so that logging does not change results.

use super::{Instance, Mode};
use crate::logger::Category;
use physics::declare::{Causality, Kind, Variability};
use physics::effects::IMMINENT;
use physics::exchange::Update;
use physics::model::{Declaration, Entry};

/// Values at the last observation.
#[derive(Clone, Debug)]
pub(super) struct Report {
    /// Discrete outputs with their values; NaN before the first observation.
    outputs: Vec<(&'static Entry, f64)>,
    /// The next time event, s.
    next_event: f64,
}

impl Report {
    pub(super) fn new(declaration: &'static Declaration) -> Report {
        let shown = |entry: &&Entry| {
            entry.row.causality == Causality::Output && entry.row.variability == Variability::Discrete
        };
        let outputs = declaration.entries.iter().filter(shown).map(|entry| (entry, f64::NAN)).collect();
        Report { outputs, next_event: f64::INFINITY }
    }
}

/// A value of a discrete output as text.
fn shown(entry: &Entry, value: f64) -> String {
    if entry.row.kind == Kind::Boolean { (value != 0.0).to_string() } else { value.to_string() }
}

impl Instance {
    /// Changes the mode.
    pub(super) fn go(&mut self, mode: Mode) {
        self.mode = mode;
        self.log_transition(mode.words());
    }

    /// Logs a mode change.
    pub fn log_transition(&mut self, what: &str) {
        let time = if self.mode == Mode::Initialization { self.window.0 } else { self.model.time() };
        self.log.note(Category::Events, || format!("{what}, time {time} s."));
    }

    /// Changes of discrete outputs since the last observation; stores the present values.
    pub(super) fn observe(&mut self) -> Vec<String> {
        let mut changes = Vec::new();
        if !self.log.wants(Category::Events) {
            return changes;
        }
        let mut model = self.model.boxed_clone();
        for (entry, before) in &mut self.report.outputs {
            let now = model.get(entry.slot);
            if now != *before && !before.is_nan() {
                changes.push(format!("{} becomes {}", entry.name, shown(entry, now)));
            }
            *before = now;
        }
        self.report.next_event = self.model.next_event();
        changes
    }

    /// Logs events and rejected steps of a step of `h` seconds from `at`, s; `before` is the number of rejected steps at its start.
    #[cold]
    pub(super) fn report_step(&mut self, at: f64, h: f64, before: u64) {
        let rejected = self.model.rejected_steps().saturating_sub(before);
        if rejected > 0 {
            self.log.note(Category::Steps, || {
                format!(
                    "the integrator rejected {rejected} steps in the communication step from {at} s by {h} s."
                )
            });
        }
        let (planned, now) = (self.report.next_event, self.model.time());
        let mut events = self.observe();
        if planned > at + IMMINENT && planned <= now + IMMINENT {
            events.insert(0, format!("time event at {planned} s"));
        }
        for event in events {
            self.log.note(Category::Events, || format!("{event}, time {now} s."));
        }
    }

    /// Logs an event iteration.
    #[cold]
    pub(super) fn report_event(&mut self, update: &Update) {
        let (now, next) = (self.model.time(), update.next_event);
        let changes = self.observe();
        self.log.note(Category::Events, || {
            let changes =
                if changes.is_empty() { String::new() } else { format!(": {}", changes.join(", ")) };
            let states = if update.states_changed { "; states changed" } else { "" };
            let next =
                if next.is_finite() { format!("; next time event at {next} s") } else { String::new() };
            format!("event, time {now} s{changes}{states}{next}.")
        });
    }
}
