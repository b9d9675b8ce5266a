//! Steps that an importer of FMI 3 takes part in: it handles events, lets steps return early, and looks in on the way.
//!
//! *Events* are what changes a discrete output, and what comes at a time that is known. A sector of commutation or a bridge that
//! turns round changes nothing that an importer could see at once: the step takes these by itself, as it takes all of them
//! where the importer has no event mode. A discrete output stands from one event to the next.
//! *Early return*: at an event the step ends, found by halving to [`NEAR`] of the step, with the output on its new side.
//! *Looks*: a step is taken in [`PARTS`] equal parts, each accurate by itself, and after each the importer may read what it
//! named, set continuous inputs, and end the step there or later. A step that fails in any part has not been taken.
//!
//! An importer that takes no part gets the plain step, bit for bit.

use super::{Instance, Interface, Mode};
use crate::refusal::{Outcome, Refused};
use physics::declare::{Causality, Variability};
use physics::effects::IMMINENT;
use physics::exchange::Update;
use physics::model::{Declaration, Entry, Model, Slot};
use std::ffi::c_void;

/// Parts of a step that is looked into.
const PARTS: u32 = 4;
/// How near an event is found, as a share of the step.
const NEAR: f64 = 1e-6;

/// `fmi3IntermediateUpdateCallback`: environment, time, whether inputs may be set, whether values may be read, whether the part is final,
/// whether the step may end here; whether it is to end, and when. Booleans are bytes, as everywhere here.
pub type IntermediateUpdate = unsafe extern "C" fn(*mut c_void, f64, u8, u8, u8, u8, *mut u8, *mut f64);

/// How an importer looks into steps.
#[derive(Clone, Debug)]
pub struct Look {
    /// Called after each part.
    pub callback: IntermediateUpdate,
    /// Handed back to it.
    pub environment: *mut c_void,
    /// What it reads and sets.
    pub references: Vec<u32>,
}

/// What an importer takes part in.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// It handles events.
    pub event_mode: bool,
    /// A step may end before its end.
    pub early_return: bool,
    /// It looks into steps.
    pub look: Option<Look>,
}

impl Part {
    /// Refuses a look at what cannot be seen.
    pub(super) fn check(&self, declaration: &Declaration) -> Outcome {
        for &reference in self.look.iter().flat_map(|look| &look.references) {
            let entry = declaration.by_reference(reference);
            if !entry.is_some_and(Entry::is_intermediate) {
                let name = entry.map_or_else(|| format!("value reference {reference}"), |e| e.name.clone());
                return Err(Refused::error(format!(
                    "{name} is no continuous input or output of {} and cannot be an intermediate variable.",
                    declaration.name
                )));
            }
        }
        Ok(())
    }

    /// Where the outputs are that change at events alone.
    pub(super) fn discrete(&self, declaration: &Declaration) -> Vec<Slot> {
        let shown = |entry: &&Entry| {
            entry.row.causality == Causality::Output && entry.row.variability == Variability::Discrete
        };
        declaration.entries.iter().filter(shown).map(|entry| entry.slot).collect()
    }

    /// Whether a variable is among those that are looked at.
    pub(super) fn sees(&self, entry: &Entry) -> bool {
        self.look.as_ref().is_some_and(|look| look.references.contains(&entry.value_reference))
    }
}

/// How a step, or a part of one, ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ended {
    /// At an event, or past one, that the importer has to handle.
    pub event: bool,
    /// Before its end.
    pub early: bool,
}

/// A step that is looked into.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Where it began and where it is to end, s.
    begun: f64,
    end: f64,
    /// The length that was asked for, s.
    h: f64,
    /// Parts taken.
    taken: u32,
    done: bool,
    /// How it has ended so far.
    pub ended: Ended,
}

/// What the importer is shown between two parts.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Its function.
    pub callback: IntermediateUpdate,
    /// Handed back to it.
    pub environment: *mut c_void,
    /// The time reached, s.
    pub time: f64,
    /// Whether inputs are among what it named.
    pub sets: bool,
    /// Whether the step may end here.
    pub may_return: bool,
}

impl Instance {
    /// Refuses event mode where it was not asked for.
    pub fn require_events(&self) -> Outcome {
        if self.interface == Interface::ModelExchange || self.part.event_mode {
            return Ok(());
        }
        Err(Refused::error("event mode was not asked for when the instance was made (eventModeUsed)."))
    }

    /// Event -> step mode.
    pub fn enter_step(&mut self) -> Outcome {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Event])?;
        self.mode = Mode::Step;
        Ok(())
    }

    /// Lets what is held between events follow.
    pub fn update(&mut self) -> Outcome<Update> {
        self.require(&[Mode::Event])?;
        if self.interface == Interface::ModelExchange {
            return Ok(self.model.update());
        }
        self.hold();
        let next = self.model.next_event();
        let passed = next <= self.model.time() + IMMINENT;
        Ok(Update { states_changed: false, next_event: if passed { f64::INFINITY } else { next } })
    }

    /// Discrete outputs show what they are now.
    pub(super) fn hold(&mut self) {
        for (held, slot) in self.held.iter_mut().zip(&self.discrete) {
            *held = self.model.get(*slot);
        }
    }

    /// What a discrete output shows since the last event.
    pub(super) fn held(&mut self, slot: Slot) -> f64 {
        match self.discrete.iter().position(|s| *s == slot) {
            Some(k) => self.held[k],
            None => self.model.get(slot),
        }
    }

    /// Whether a discrete output is no longer what it shows.
    fn is_due(&mut self) -> bool {
        self.held.iter().zip(&self.discrete).any(|(held, slot)| self.model.get(*slot) != *held)
    }

    /// Whether the importer looks into steps.
    pub fn is_looked_into(&self) -> bool {
        self.part.look.is_some()
    }

    /// A step from the communication point `at`, s, by `h` seconds, or to an event within it.
    #[inline]
    pub fn stride(&mut self, at: f64, h: f64) -> Outcome<Ended> {
        self.require_step(at, h)?;
        if self.part.event_mode {
            return self.advance_to_event(at, h);
        }
        self.advance(at, h)?;
        Ok(Ended::default())
    }

    fn advance_to_event(&mut self, at: f64, h: f64) -> Outcome<Ended> {
        let timed = self.model.next_event();
        let ahead = timed > at + IMMINENT;
        let mut ended = Ended::default();
        let mut way = h;
        if ahead && self.part.early_return && timed < at + h - IMMINENT {
            // To the event and not a rounding before it.
            way = timed - at;
            way += if at + way < timed { f64::EPSILON * timed.abs() } else { 0.0 };
            ended.early = true;
        }
        // What the importer has not yet handled is no reason to stop again.
        let due = self.is_due();
        let before = copy(self.begun.take(), self.model.as_ref());
        if let Err(fault) = self.model.step(at, way) {
            self.begun = Some(before);
            return Err(self.halted(fault));
        }
        let new = !due && self.is_due();
        let found = if new && self.part.early_return { self.find(before.as_ref(), at, way) } else { Ok(way) };
        if found.is_err() {
            self.model.copy_from(before.as_ref());
        }
        self.begun = Some(before);
        let found = found?;
        ended.early |= found < way;
        ended.event = due || new || (ahead && timed <= at + way + IMMINENT);
        Ok(ended)
    }

    /// Where in the step by `way` from `before` a discrete output changes; the model stands there afterwards.
    fn find(&mut self, before: &dyn Model, at: f64, way: f64) -> Outcome<f64> {
        let (mut low, mut high) = (0.0, way);
        let near = (NEAR * way).max(4.0 * f64::EPSILON * at.abs());
        let mut go = |to: f64| -> Outcome<bool> {
            self.model.copy_from(before);
            self.advance(at, to)?;
            Ok(self.is_due())
        };
        while high - low > near {
            let middle = 0.5 * (low + high);
            if go(middle)? {
                high = middle;
            } else {
                low = middle;
            }
        }
        go(high)?;
        Ok(high)
    }

    /// Begins a step that is looked into.
    pub fn begin(&mut self, at: f64, h: f64) -> Outcome<Course> {
        self.require_step(at, h)?;
        let looked = self.looked_from.take();
        self.looked_from = Some(copy(looked, self.model.as_ref()));
        Ok(Course { begun: at, end: at + h, h, taken: 0, done: false, ended: Ended::default() })
    }

    /// The next part of a step; `None` when it has ended.
    pub fn part(&mut self, course: &mut Course) -> Outcome<Option<View>> {
        if course.done {
            return Ok(None);
        }
        course.taken += 1;
        let at = if course.taken == 1 { course.begun } else { self.model.time() };
        let whole = course.begun + course.h;
        let share = f64::from(course.taken) / f64::from(PARTS);
        let next = if course.taken >= PARTS { whole } else { course.begun + course.h * share };
        let to = next.min(course.end);
        let outcome = if self.part.event_mode {
            self.advance_to_event(at, to - at)
        } else {
            self.advance(at, to - at).map(|()| Ended::default())
        };
        let ended = match outcome {
            Ok(ended) => ended,
            Err(refused) => {
                if let (Some(before), None) = (&self.looked_from, &self.ended) {
                    self.model.copy_from(before.as_ref());
                }
                return Err(refused);
            }
        };
        course.ended.event |= ended.event;
        course.ended.early |= ended.early || (to >= course.end && course.end < whole);
        course.done = ended.early || to >= course.end;
        let Some(look) = &self.part.look else { return Ok(None) };
        let (callback, environment) = (look.callback, look.environment);
        let declaration = self.model.declaration();
        let input = |reference: &u32| declaration.by_reference(*reference).is_some_and(Entry::is_settable);
        let sets = look.references.iter().any(input);
        self.mode = Mode::Intermediate;
        let may_return = self.part.early_return && !course.done;
        Ok(Some(View { callback, environment, time: self.model.time(), sets, may_return }))
    }

    /// After a look: `until` where the importer wants the step to end, s.
    pub fn looked(&mut self, course: &mut Course, until: Option<f64>) -> Outcome {
        self.require(&[Mode::Intermediate])?;
        self.mode = Mode::Step;
        let now = self.model.time();
        if let Some(until) = until.filter(|until| until.is_finite() && !course.done && self.part.early_return)
        {
            course.end = course.end.min(until);
            if course.end <= now + IMMINENT.min(NEAR * course.h) {
                (course.done, course.ended.early) = (true, true);
            }
        }
        Ok(())
    }
}

/// A copy of a model, in the place of an older one where there is any.
fn copy(old: Option<Box<dyn Model>>, model: &dyn Model) -> Box<dyn Model> {
    if let Some(mut old) = old
        && old.copy_from(model)
    {
        return old;
    }
    model.boxed_clone()
}
