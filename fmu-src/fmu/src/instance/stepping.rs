//! Co-Simulation steps of FMI 3 with event mode, early return and intermediate update.
//!
//! *Event*: a discrete output changes, or a time event occurs. A change of the commutation sector or of the bridge's current direction
//! changes no output discontinuously, so the step handles it internally. If the importer does not use event mode, the step handles all
//! events internally. A discrete output is constant between two events.
//! *Early return*: the step ends at an event. The event time is located by bisection to [`NEAR`] of the step, just after the event.
//! *Intermediate update*: a step is divided into [`PARTS`] equal parts, each within the tolerance. It is a single part if the importer
//! named only inputs, because nothing is read during the step and it cannot end early. After each part the importer may read
//! intermediate variables, set continuous inputs, and end the step there or later. If a part fails, the step is rolled back. Inputs set
//! after a part have the new value at its end and are linear over it (recommendedIntermediateInputSmoothness is 0 by default: inputs
//! are continuous): the part is repeated with their derivatives, unless an event has ended it.
//!
//! Without these features the result is bit-identical to that of a plain step.

use super::{Instance, Interface, Mode};
use crate::refusal::{Outcome, Refused};
use physics::declare::{Causality, Variability};
use physics::effects::IMMINENT;
use physics::exchange::Update;
use physics::model::{Declaration, Entry, Model, Slot};
use std::ffi::c_void;

/// Number of parts of a step with intermediate updates.
const PARTS: u32 = 4;
/// Tolerance of the event time, relative to the step.
const NEAR: f64 = 1e-6;

/// `fmi3IntermediateUpdateCallback`: environment, time, whether inputs may be set, whether values may be read, whether the part is final,
/// whether the step may end here; outputs: early return requested, and its time. Booleans are bytes.
pub type IntermediateUpdate = unsafe extern "C" fn(*mut c_void, f64, u8, u8, u8, u8, *mut u8, *mut f64);

/// The intermediate update callback and its variables.
#[derive(Clone, Debug)]
pub struct IntermediateUpdates {
    /// Called after each part.
    pub callback: IntermediateUpdate,
    /// First argument of the callback.
    pub environment: *mut c_void,
    /// Intermediate variables.
    pub references: Vec<u32>,
}

/// Optional features of Co-Simulation that the importer uses.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Event mode.
    pub event_mode: bool,
    /// Early return.
    pub early_return: bool,
    /// Intermediate update.
    pub updates: Option<IntermediateUpdates>,
}

impl Part {
    /// Rejects intermediate variables other than continuous inputs and outputs.
    pub(super) fn check(&self, declaration: &Declaration) -> Outcome {
        for &reference in self.updates.iter().flat_map(|updates| &updates.references) {
            let entry = declaration.by_reference(reference);
            if !entry.is_some_and(Entry::is_intermediate) {
                let name = entry.map_or_else(|| format!("value reference {reference}"), |e| e.name.clone());
                return Err(Refused::error(format!(
                    "{name} is not a continuous input or output of {} and cannot be an intermediate variable.",
                    declaration.name
                )));
            }
        }
        Ok(())
    }

    /// Slots of the discrete outputs.
    pub(super) fn discrete(&self, declaration: &Declaration) -> Vec<Slot> {
        let shown = |entry: &&Entry| {
            entry.row.causality == Causality::Output && entry.row.variability == Variability::Discrete
        };
        declaration.entries.iter().filter(shown).map(|entry| entry.slot).collect()
    }

    /// Number of parts of a step.
    fn parts(&self, declaration: &Declaration) -> u32 {
        let reads = |reference: &u32| !declaration.by_reference(*reference).is_some_and(Entry::is_settable);
        let mut named = self.updates.iter().flat_map(|updates| &updates.references);
        if self.early_return || named.clone().count() == 0 || named.any(reads) { PARTS } else { 1 }
    }

    /// Whether it is an intermediate variable.
    pub(super) fn has_intermediate(&self, entry: &Entry) -> bool {
        self.updates.as_ref().is_some_and(|updates| updates.references.contains(&entry.value_reference))
    }
}

/// End of a step or of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ended {
    /// Ended at or just after an event that the importer has to handle.
    pub event: bool,
    /// Ended before the requested time.
    pub early: bool,
}

/// A step with intermediate updates.
#[derive(Clone, Copy, Debug)]
pub struct StepInParts {
    /// Start and end time, s.
    start: f64,
    end: f64,
    /// The requested communication step size, s.
    h: f64,
    /// Number of completed parts.
    taken: u32,
    /// Start and length of the present part, s.
    part: (f64, f64),
    done: bool,
    /// Result so far.
    pub ended: Ended,
}

/// Arguments of one intermediate update.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The callback.
    pub callback: IntermediateUpdate,
    /// First argument of the callback.
    pub environment: *mut c_void,
    /// Present time, s.
    pub time: f64,
    /// Whether inputs are among the intermediate variables.
    pub sets: bool,
    /// Whether the step may end here.
    pub may_return: bool,
}

impl Instance {
    /// Rejects event mode if the instance was created without it.
    pub fn require_events(&self) -> Outcome {
        if self.interface == Interface::ModelExchange || self.part.event_mode {
            return Ok(());
        }
        Err(Refused::error("the instance was created without event mode (eventModeUsed = false)."))
    }

    /// Event -> step mode.
    pub fn enter_step(&mut self) -> Outcome {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Event])?;
        self.go(Mode::Step);
        Ok(())
    }

    /// Updates the discrete outputs, which are constant between events.
    pub fn update(&mut self) -> Outcome<Update> {
        self.require(&[Mode::Event])?;
        let update = if self.interface == Interface::ModelExchange {
            self.model.update()
        } else {
            self.hold();
            let next = self.model.next_event();
            let passed = next <= self.model.time() + IMMINENT;
            Update { states_changed: false, next_event: if passed { f64::INFINITY } else { next } }
        };
        if self.log.is_on() {
            self.report_event(&update);
        }
        Ok(update)
    }

    /// Sets the pre values of the discrete outputs to their present values.
    pub(super) fn hold(&mut self) {
        for (discrete_pre, slot) in self.discrete_pre.iter_mut().zip(&self.discrete) {
            *discrete_pre = self.model.get(*slot);
        }
    }

    /// Value of a discrete output since the last event.
    pub(super) fn discrete_pre(&mut self, slot: Slot) -> f64 {
        match self.discrete.iter().position(|s| *s == slot) {
            Some(k) => self.discrete_pre[k],
            None => self.model.get(slot),
        }
    }

    /// Whether the present value of a discrete output differs from its value since the last event.
    fn is_due(&mut self) -> bool {
        self.discrete_pre
            .iter()
            .zip(&self.discrete)
            .any(|(discrete_pre, slot)| self.model.get(*slot) != *discrete_pre)
    }

    /// Whether steps have intermediate updates.
    pub fn has_intermediate_updates(&self) -> bool {
        self.part.updates.is_some()
    }

    /// A step of `h` seconds from the communication point `at`, s, or to an event inside it.
    #[inline]
    pub fn stride(&mut self, at: f64, h: f64) -> Outcome<Ended> {
        self.require_step(at, h)?;
        let before = self.model.rejected_steps();
        let ended = if self.part.event_mode {
            self.advance_to_event(at, h)?
        } else {
            self.advance(at, h)?;
            Ended::default()
        };
        if self.log.is_on() {
            self.report_step(at, h, before);
        }
        Ok(ended)
    }

    fn advance_to_event(&mut self, at: f64, h: f64) -> Outcome<Ended> {
        let timed = self.model.next_event();
        let ahead = timed > at + IMMINENT;
        let mut ended = Ended::default();
        let mut way = h;
        if ahead && self.part.early_return && timed < at + h - IMMINENT {
            // The step must end at the event, not a rounding error before it.
            way = timed - at;
            way += if at + way < timed { f64::EPSILON * timed.abs() } else { 0.0 };
            ended.early = true;
        }
        // A pending event that the importer has not handled does not end the step again.
        let due = self.is_due();
        let before = copy(self.step_start.take(), self.model.as_ref());
        if let Err(refused) = self.take_step(at, way) {
            self.step_start = Some(before);
            return Err(refused);
        }
        let new = !due && self.is_due();
        let found = if new && self.part.early_return { self.find(before.as_ref(), at, way) } else { Ok(way) };
        if found.is_err() {
            self.model.copy_from(before.as_ref());
        }
        self.step_start = Some(before);
        let found = found?;
        ended.early |= found < way;
        ended.event = due || new || (ahead && timed <= at + way + IMMINENT);
        Ok(ended)
    }

    /// Locates the change of a discrete output in the step of `way` seconds from `before`; the model is then just after the event.
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

    /// Starts a step with intermediate updates.
    pub fn begin(&mut self, at: f64, h: f64) -> Outcome<StepInParts> {
        self.require_step(at, h)?;
        let earlier = self.update_start.take();
        self.update_start = Some(copy(earlier, self.model.as_ref()));
        Ok(StepInParts {
            start: at,
            end: at + h,
            h,
            taken: 0,
            part: (at, 0.0),
            done: false,
            ended: Ended::default(),
        })
    }

    /// Computes the next part of a step; `None` at the end of the step.
    pub fn part(&mut self, parts: &mut StepInParts) -> Outcome<Option<View>> {
        if parts.done {
            return Ok(None);
        }
        parts.taken += 1;
        let at = if parts.taken == 1 { parts.start } else { self.model.time() };
        let whole = parts.start + parts.h;
        let count = self.part.parts(self.model.declaration());
        let share = f64::from(parts.taken) / f64::from(count);
        let next = if parts.taken >= count { whole } else { parts.start + parts.h * share };
        let to = next.min(parts.end);
        parts.part = (at, to - at);
        self.part_start = Some(copy(self.part_start.take(), self.model.as_ref()));
        let before = self.model.rejected_steps();
        let outcome = if self.part.event_mode {
            self.advance_to_event(at, to - at)
        } else {
            self.advance(at, to - at).map(|()| Ended::default())
        };
        let ended = match outcome {
            Ok(ended) => ended,
            Err(refused) => return Err(self.undone(refused)),
        };
        if self.log.is_on() {
            self.report_step(at, to - at, before);
        }
        parts.ended.event |= ended.event;
        if ended.event || ended.early {
            self.part_start = None;
        }
        parts.ended.early |= ended.early || (to >= parts.end && parts.end < whole);
        parts.done = ended.early || to >= parts.end;
        let Some(updates) = &self.part.updates else { return Ok(None) };
        let (callback, environment) = (updates.callback, updates.environment);
        let declaration = self.model.declaration();
        let input = |reference: &u32| declaration.by_reference(*reference).is_some_and(Entry::is_settable);
        let sets = updates.references.iter().any(input);
        self.mode = Mode::Intermediate;
        let may_return = self.part.early_return && !parts.done;
        Ok(Some(View { callback, environment, time: self.model.time(), sets, may_return }))
    }

    /// Continues after an intermediate update; `until` is the early return time that the importer requests, s.
    pub fn after_update(&mut self, parts: &mut StepInParts, until: Option<f64>) -> Outcome {
        self.require(&[Mode::Intermediate])?;
        self.mode = Mode::Step;
        self.repeat_with_lines(parts)?;
        let now = self.model.time();
        if let Some(until) = until.filter(|until| until.is_finite() && !parts.done && self.part.early_return)
        {
            parts.end = parts.end.min(until);
            if parts.end <= now + IMMINENT.min(NEAR * parts.h) {
                (parts.done, parts.ended.early) = (true, true);
            }
        }
        Ok(())
    }
}

impl Instance {
    /// Rolls back the step after an error that does not end the run.
    fn undone(&mut self, refused: Refused) -> Refused {
        if let (Some(before), None) = (&self.update_start, &self.ended) {
            self.model.copy_from(before.as_ref());
        }
        refused
    }

    /// Repeats the last part with linear inputs for the inputs that were set since.
    fn repeat_with_lines(&mut self, parts: &mut StepInParts) -> Outcome {
        let (Some(mut start), Some(updates)) = (self.part_start.take(), self.part.updates.take()) else {
            return Ok(());
        };
        let (at, h) = parts.part;
        let declaration = self.model.declaration();
        let inputs = || updates.references.iter().filter_map(|r| declaration.by_reference(*r));
        let inputs = || inputs().filter(|entry| entry.is_continuous_input());
        let has_moved = inputs().any(|entry| self.model.get(entry.slot) != start.get(entry.slot));
        let mut outcome = Ok(());
        if has_moved {
            let (mut event, before) = (false, self.model.rejected_steps());
            for entry in inputs() {
                // The new value is that at the end of the part.
                let (from, to) = (start.get(entry.slot), self.model.get(entry.slot));
                start.set_slope(entry.slot, (to - from) / h);
            }
            std::mem::swap(&mut self.model, &mut start);
            outcome = self.take_step(at, h);
            if outcome.is_ok() {
                for entry in inputs() {
                    self.model.set(entry.slot, start.get(entry.slot));
                }
                event = self.part.event_mode && self.is_due();
            }
            if self.log.is_on() {
                self.report_step(at, h, before);
            }
            parts.ended.event |= event;
        }
        self.part_start = Some(start);
        self.part.updates = Some(updates);
        outcome.map_err(|refused| self.undone(refused))
    }
}

/// A copy of a model, in the memory of an older copy if there is one.
pub(super) fn copy(old: Option<Box<dyn Model>>, model: &dyn Model) -> Box<dyn Model> {
    if let Some(mut old) = old
        && old.copy_from(model)
    {
        return old;
    }
    model.boxed_clone()
}
