//! An instance: its life cycle, and what it refuses.

mod exchange;
mod mode;
mod slopes;

pub use mode::{Interface, Mode, Type};
pub use slopes::same_numbers;

use crate::boundary::{Outcome, Refused};
use crate::logger::{CATEGORIES, Log};
use crate::saved::Saved;
use mode::LIVING;
use physics::declare::Elements;
use physics::model::{Element, Entry, Model, ModelType, Refusal, TIME};
use physics::terms::GenericTerm;
use std::path::Path;

/// One motor, or whatever else the token asked for, in an importer's hands.
pub struct Instance {
    kind: &'static ModelType,
    model: Box<dyn Model>,
    /// A model to be moved about for derivatives, made when the first are asked for.
    scratch: Option<Box<dyn Model>>,
    /// The terms of the archive.
    terms: Vec<GenericTerm>,
    interface: Interface,
    /// How many elements its variables have whose number a parameter says: that of the archive.
    elements: u32,
    mode: Mode,
    /// Start and stop time, s; the stop is infinite where it was not announced.
    window: (f64, f64),
    /// Values were set since the model last started, during initialization.
    unsettled: bool,
    /// Where messages go.
    pub log: Log,
}

impl Instance {
    /// The instance of the model with this token, with the terms in its archive's resources.
    pub fn new(
        token: Option<&str>,
        resources: Option<&Path>,
        interface: Interface,
        log: Log,
    ) -> Outcome<Instance> {
        let Some(kind) = token.and_then(physics::models::by_token) else {
            let known: Vec<String> = physics::models::ALL
                .iter()
                .map(|m| (m.declaration)())
                .map(|d| format!("{} of {}", d.token, d.name))
                .collect();
            let token = token.unwrap_or("NULL");
            return Err(Refused::error(format!(
                "the token {token} is none of this library's: {}; its modelDescription.xml is of another build.",
                known.join(", ")
            )));
        };
        let terms = resources.map_or(Ok(Vec::new()), terms::of_resources);
        let terms = terms.map_err(|error| Refused::error(format!("{error}.")))?;
        let Some(mut model) = crate::new_model(kind, &terms) else {
            return Err(Refused::error(format!(
                "{} does not take the {} terms of {}.",
                (kind.declaration)().name,
                terms.len(),
                terms::FILE_NAME
            )));
        };
        if interface == Interface::ModelExchange {
            model.hand_over();
        }
        let elements = counted(model.as_mut());
        let (mode, window) = (Mode::Instantiated, (0.0, f64::INFINITY));
        let scratch = None;
        Ok(Instance { kind, model, scratch, terms, interface, elements, mode, window, unsettled: true, log })
    }

    /// Whether the archive has this variable: there may be fewer elements than the library knows.
    #[inline]
    fn shows(&self, entry: &Entry) -> bool {
        match entry.element {
            Some(Element { index, of: Elements::UpTo(..) }) => index <= self.elements,
            _ => true,
        }
    }

    fn require(&self, allowed: &[Mode]) -> Outcome {
        if allowed.contains(&self.mode) {
            return Ok(());
        }
        Err(Refused::error(format!("not allowed while the instance is {}.", self.mode.words())))
    }

    /// After a panic: nothing but reset and free is allowed.
    pub fn break_down(&mut self) {
        self.mode = Mode::Broken;
    }

    /// Turns the telling of events on or off; refuses a category that does not exist.
    pub fn set_logging(&mut self, on: bool, categories: &[Option<String>]) -> Outcome {
        for category in categories {
            let category = category.as_deref().unwrap_or("NULL");
            if !CATEGORIES.iter().any(|(name, _)| *name == category) {
                let known: Vec<&str> = CATEGORIES.iter().map(|(name, _)| *name).collect();
                return Err(Refused::error(format!(
                    "the log category {category} is none of {}.",
                    known.join(", ")
                )));
            }
        }
        self.log.on = on;
        Ok(())
    }

    /// Announces the window of time; `None` where no stop is known.
    pub fn set_window(&mut self, start: f64, stop: Option<f64>) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        if !start.is_finite() {
            return Err(Refused::error(format!("the start time {start} s is not finite.")));
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
        {
            return Err(Refused::error(format!(
                "the stop time {stop} s is not after the start time {start} s."
            )));
        }
        self.window = (start, stop.unwrap_or(f64::INFINITY));
        Ok(())
    }

    /// Instantiated -> initialization.
    pub fn enter_initialization(&mut self) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        self.mode = Mode::Initialization;
        self.unsettled = true;
        Ok(())
    }

    /// Initialization -> step.
    pub fn exit_initialization(&mut self) -> Outcome {
        self.require(&[Mode::Initialization])?;
        self.settle()?;
        self.mode = match self.interface {
            Interface::CoSimulation => Mode::Step,
            Interface::ModelExchange => {
                let counted = counted(self.model.as_mut());
                if counted > self.elements {
                    return Err(Refused::error(format!(
                        "this archive shows {} segments of the housing as states and {counted} are asked for; \
                         in Co-Simulation there may be more of them than are shown.",
                        self.elements
                    )));
                }
                Mode::Event
            }
        };
        Ok(())
    }

    /// Running -> terminated.
    pub fn terminate(&mut self) -> Outcome {
        self.require(&[Mode::Step, Mode::Event, Mode::Continuous])?;
        self.mode = Mode::Terminated;
        Ok(())
    }

    /// Any -> instantiated, as new: start values, time and integrator.
    pub fn reset(&mut self) -> Outcome {
        self.model = crate::new_model(self.kind, &self.terms)
            .ok_or_else(|| Refused::error("the model no longer takes the terms that it has taken."))?;
        if self.interface == Interface::ModelExchange {
            self.model.hand_over();
        }
        self.mode = Mode::Instantiated;
        self.window = (0.0, f64::INFINITY);
        self.unsettled = true;
        Ok(())
    }

    /// During initialization the model starts anew from what was set last.
    #[inline]
    fn settle(&mut self) -> Outcome {
        if self.mode == Mode::Initialization && self.unsettled {
            self.model.start(self.window.0).map_err(|fault| Refused::error(fault.0))?;
            self.unsettled = false;
        }
        Ok(())
    }

    #[inline]
    fn entry(&self, value_reference: u32, of: Type) -> Outcome<&'static Entry> {
        let declaration = self.model.declaration();
        let Some(entry) = declaration.by_reference(value_reference).filter(|e| self.shows(e)) else {
            return Err(Refused::error(format!(
                "{} has no variable with the value reference {value_reference}.",
                declaration.name
            )));
        };
        let is = Type::of(entry);
        if is != of {
            return Err(Refused::error(format!(
                "{} (value reference {value_reference}) is of type {} and not {}.",
                entry.name,
                is.words(),
                of.words()
            )));
        }
        Ok(entry)
    }

    /// Reads values; `put` gets each with its place in the list.
    #[inline]
    pub fn get(&mut self, references: &[u32], of: Type, mut put: impl FnMut(usize, f64)) -> Outcome {
        self.require(&[Mode::Initialization, Mode::Step, Mode::Terminated, Mode::Event, Mode::Continuous])?;
        self.settle()?;
        for (k, &value_reference) in references.iter().enumerate() {
            if value_reference == TIME && of == Type::Real {
                put(k, self.model.time());
                continue;
            }
            let slot = self.entry(value_reference, of)?.slot;
            put(k, self.model.get(slot));
        }
        Ok(())
    }

    /// Sets values, all or none.
    #[inline]
    pub fn set(&mut self, references: &[u32], of: Type, value: impl Fn(usize) -> f64) -> Outcome {
        self.require(&[Mode::Instantiated, Mode::Initialization, Mode::Step, Mode::Event, Mode::Continuous])?;
        let running = !matches!(self.mode, Mode::Instantiated | Mode::Initialization);
        let mut last = None;
        for (k, &value_reference) in references.iter().enumerate() {
            if value_reference == TIME && of == Type::Real {
                return Err(Refused::error("time is the independent variable and cannot be set."));
            }
            let entry = self.entry(value_reference, of)?;
            if self.mode == Mode::Continuous && !entry.is_continuous_input() {
                return Err(Refused::error(format!(
                    "{} can be set at an event alone and the instance is {}.",
                    entry.name,
                    self.mode.words()
                )));
            }
            if let Err(refusal) = entry.check(value(k), running) {
                let message = entry.explain(value(k), &refusal);
                return Err(match refusal {
                    Refusal::Computed | Refusal::Fixed => Refused::error(message),
                    _ => Refused::discard(message),
                });
            }
            last = Some(entry.slot);
        }
        // All are good. A single value, the common case, needs no second look-up.
        if let (&[_], Some(slot)) = (references, last) {
            self.model.set(slot, value(0));
        } else {
            for (k, &value_reference) in references.iter().enumerate() {
                let slot = self.entry(value_reference, of)?.slot;
                self.model.set(slot, value(k));
            }
        }
        self.unsettled = true;
        Ok(())
    }

    /// Sets the slopes of continuous inputs over the next step, all or none.
    pub fn set_slopes(&mut self, references: &[u32], orders: &[i32], slopes: &[f64]) -> Outcome {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Initialization, Mode::Step])?;
        for ((&value_reference, &order), &slope) in references.iter().zip(orders).zip(slopes) {
            let entry = self.entry(value_reference, Type::Real)?;
            if !entry.is_continuous_input() {
                return Err(Refused::error(format!(
                    "{} is no continuous input and takes no slope.",
                    entry.name
                )));
            }
            if order != 1 {
                return Err(Refused::error(format!(
                    "the derivative of order {order} of {} cannot be set; order 1 can.",
                    entry.name
                )));
            }
            if !slope.is_finite() {
                return Err(Refused::discard(format!(
                    "the slope {slope} {}/s of {} is not a finite number.",
                    entry.row.unit.name(),
                    entry.name
                )));
            }
        }
        for (&value_reference, &slope) in references.iter().zip(slopes) {
            let slot = self.entry(value_reference, Type::Real)?.slot;
            self.model.set_slope(slot, slope);
        }
        Ok(())
    }

    /// Steps from the communication point `at`, s, by `h` seconds.
    #[inline]
    pub fn step(&mut self, at: f64, h: f64) -> Outcome {
        self.require(&[Mode::Step])?;
        let now = self.model.time();
        if !(h > 0.0 && h.is_finite()) {
            return Err(Refused::error(format!(
                "the communication step size {h} s is not positive and finite."
            )));
        }
        // Importers count time in their own way; a thousandth of a step is rounding, more is a mistake.
        let rounding = (1e-3 * h).max(8.0 * f64::EPSILON * now.abs());
        if at.is_nan() || (at - now).abs() > rounding {
            return Err(Refused::error(format!(
                "the communication point {at} s is not where the instance stands, {now} s."
            )));
        }
        if at + h > self.window.1 + rounding {
            return Err(Refused::error(format!(
                "the step from {at} s by {h} s leads past the announced stop time {} s.",
                self.window.1
            )));
        }
        self.model.step(at, h).map_err(|fault| Refused::discard(fault.0))
    }

    /// The time reached, s.
    pub fn time(&self) -> f64 {
        self.model.time()
    }

    fn require_living(&self) -> Outcome {
        self.require(LIVING)
    }

    /// Refuses a call of the other interface.
    pub fn require_interface(&self, interface: Interface) -> Outcome {
        if self.interface == interface {
            return Ok(());
        }
        Err(Refused::error(format!(
            "this is a function of {} and the instance is one of {}.",
            interface.words(),
            self.interface.words()
        )))
    }

    /// Saves the instance, into `old` where there is one of the same model.
    pub fn save(&self, old: Option<&mut Saved>) -> Outcome<Option<Saved>> {
        self.require_living()?;
        let (mode, window) = (self.mode, self.window);
        if let Some(old) = old
            && old.interface == self.interface
            && old.model.copy_from(self.model.as_ref())
        {
            (old.mode, old.window) = (mode, window);
            return Ok(None);
        }
        let interface = self.interface;
        Ok(Some(Saved { model: self.model.boxed_clone(), interface, mode, window }))
    }

    /// Takes the instance back to what was saved.
    pub fn restore(&mut self, saved: &Saved) -> Outcome {
        self.require_living()?;
        if saved.interface != self.interface {
            return Err(Refused::error(format!(
                "the saved state is of an instance for {} and this is one for {}.",
                saved.interface.words(),
                self.interface.words()
            )));
        }
        if !self.model.copy_from(saved.model.as_ref()) {
            return Err(Refused::error(format!(
                "the saved state is of {} and not of {}.",
                saved.model.declaration().name,
                self.model.declaration().name
            )));
        }
        (self.mode, self.window, self.unsettled) = (saved.mode, saved.window, true);
        Ok(())
    }

    /// Refuses a call that belongs to events.
    pub fn require_event(&self) -> Outcome {
        self.require(&[Mode::Event])
    }

    /// The saved state of bytes.
    pub fn deserialize(&self, bytes: &[u8]) -> Outcome<Saved> {
        self.require_living()?;
        Saved::from_bytes(bytes, self.model.as_ref(), self.interface)
    }
}

/// The number that a parameter gives to the elements of a variable; 0 where no variable of the model has such.
fn counted(model: &mut dyn Model) -> u32 {
    let declaration = model.declaration();
    let dimension = declaration.entries.iter().find_map(|entry| match entry.element {
        Some(Element { of: Elements::UpTo(_, parameter), .. }) => declaration.by_name(parameter),
        _ => None,
    });
    // Whole numbers within their limits pass through tables exactly.
    dimension.map_or(0, |parameter| model.get(parameter.slot) as u32)
}
