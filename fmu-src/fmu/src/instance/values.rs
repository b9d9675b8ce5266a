//! Values by reference: permitted access in each mode, and number of values of a variable.
//!
//! In FMI 2 each element of an array is a separate scalar variable. In FMI 3 the elements are one variable with the reference of the first.

use super::{Instance, Interface, Mode, Standard, Type};
use crate::refusal::{Outcome, Refused};
use physics::declare::{Causality, Elements, Kind, Variability};
use physics::model::{Element, Entry, Refusal, Slot, TIME};

impl Instance {
    /// Whether an array element exists at the present size.
    #[inline]
    pub(super) fn holds(&self, entry: &Entry) -> bool {
        match entry.element {
            Some(Element { index, of: Elements::UpTo(..), .. }) => index <= self.elements,
            _ => true,
        }
    }

    /// Whether an entry has its own value reference.
    #[inline]
    fn shows(&self, entry: &Entry) -> bool {
        match entry.element {
            Some(Element { index, .. }) if self.standard == Standard::Three => index == 1,
            _ => self.holds(entry),
        }
    }

    /// Number of values of a variable.
    #[inline]
    pub(super) fn width(&self, entry: &Entry) -> usize {
        match entry.element {
            Some(Element { of, .. }) if self.standard == Standard::Three => match of {
                Elements::One => 1,
                Elements::Fixed(count) => count as usize,
                Elements::UpTo(..) => self.elements as usize,
            },
            _ => 1,
        }
    }

    /// Entries of a variable: one for a scalar, one per element for an array.
    pub(super) fn elements_of(&self, entry: &'static Entry) -> impl Iterator<Item = &'static Entry> + use<> {
        let declaration = self.model.declaration();
        let (first, width) = (entry.value_reference, self.width(entry) as u32);
        // Elements have consecutive references.
        (first..first + width).filter_map(move |reference| declaration.by_reference(reference))
    }

    #[inline]
    pub(super) fn entry(&self, value_reference: u32, of: Type) -> Outcome<&'static Entry> {
        let declaration = self.model.declaration();
        let Some(entry) = declaration.by_reference(value_reference).filter(|e| self.shows(e)) else {
            return Err(Refused::error(match declaration.unserved_reference(value_reference) {
                Some(sentence) => format!("{sentence}."),
                None => format!(
                    "{} has no variable with the value reference {value_reference}.",
                    declaration.name
                ),
            }));
        };
        let is = self.type_of(entry);
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

    /// Type of a variable in a call; FMI 3 requires unsigned array sizes.
    #[inline]
    fn type_of(&self, entry: &Entry) -> Type {
        match Type::of(entry) {
            Type::Integer if self.is_structural(entry) => Type::Size,
            of => of,
        }
    }

    #[inline]
    fn is_structural(&self, entry: &Entry) -> bool {
        entry.row.kind == Kind::Integer
            && self.standard == Standard::Three
            && self.model.declaration().is_dimension(entry)
    }

    /// Reads `n` values; `put` receives each with its index.
    #[inline]
    pub fn get(
        &mut self,
        references: &[u32],
        of: Type,
        n: usize,
        mut put: impl FnMut(usize, f64),
    ) -> Outcome {
        // In step and continuous-time mode all variables may be read, so the mode is checked once.
        let running = matches!(self.mode, Mode::Step | Mode::Continuous);
        if !running {
            self.require_readable()?;
            self.settle()?;
        }
        // With event mode discrete outputs are constant between events.
        let plain = running && of == Type::Real && n == references.len() && !self.part.event_mode;
        if plain && let Some(places) = self.read.places(references) {
            for (k, place) in places.iter().enumerate() {
                put(k, self.model.get(place.slot));
            }
            return Ok(());
        }
        self.get_each(references, of, n, put)?;
        if plain {
            self.read.store(self.model.declaration(), references);
        }
        Ok(())
    }

    /// The same with all checks.
    #[inline(never)]
    fn get_each(
        &mut self,
        references: &[u32],
        of: Type,
        n: usize,
        mut put: impl FnMut(usize, f64),
    ) -> Outcome {
        let running = matches!(self.mode, Mode::Step | Mode::Continuous);
        let mut place = 0;
        for &value_reference in references {
            if value_reference == TIME && of == Type::Real {
                if place < n {
                    put(place, self.model.time());
                }
                place += 1;
                continue;
            }
            let entry = self.entry(value_reference, of)?;
            if !running {
                self.require_to_read(entry)?;
            }
            if entry.element.is_none() {
                if place < n {
                    put(place, self.value(entry, entry.slot));
                }
                place += 1;
                continue;
            }
            let width = self.width(entry);
            for k in 0..width.min(n - place.min(n)) {
                let slot = Slot { row: entry.slot.row + k as u16, ..entry.slot };
                put(place + k, self.model.get(slot));
            }
            place += width;
        }
        if place != n {
            return Err(wrong_number(references.len(), place, n));
        }
        Ok(())
    }

    #[inline]
    fn value(&mut self, entry: &Entry, slot: Slot) -> f64 {
        if self.part.event_mode
            && entry.row.variability == Variability::Discrete
            && self.mode != Mode::Initialization
        {
            return self.discrete_pre(slot);
        }
        self.model.get(slot)
    }

    #[inline]
    fn require_readable(&self) -> Outcome {
        // In the error state values may be read for debugging.
        if self.mode == Mode::Instantiated && self.standard == Standard::Two {
            return self.require(&[]);
        }
        Ok(())
    }

    /// Before initialization only start values can be read, in intermediate update mode only intermediate variables.
    #[inline]
    pub(super) fn require_to_read(&self, entry: &Entry) -> Outcome {
        let allowed = match self.mode {
            Mode::Instantiated | Mode::Configuration => entry.is_settable(),
            Mode::Intermediate => self.part.has_intermediate(entry),
            _ => true,
        };
        if allowed {
            return Ok(());
        }
        Err(Refused::error(format!(
            "{} cannot be read while the instance is {}.",
            entry.name,
            self.mode.words()
        )))
    }

    /// Sets `n` values, all or none.
    #[inline]
    pub fn set(&mut self, references: &[u32], of: Type, n: usize, value: impl Fn(usize) -> f64) -> Outcome {
        if matches!(self.mode, Mode::Terminated | Mode::Error) {
            return self.require(&[]);
        }
        let plain = self.mode == Mode::Step && of == Type::Real && n == references.len();
        if plain
            && let Some(places) = self.written.places(references)
            && places.iter().enumerate().all(|(k, place)| place.takes(value(k)))
        {
            for (k, place) in places.iter().enumerate() {
                self.model.set(place.slot, value(k));
            }
            self.unsettled = true;
            return Ok(());
        }
        self.set_each(references, of, n, value)?;
        if plain {
            self.written.store(self.model.declaration(), references);
        }
        Ok(())
    }

    /// The same with all checks. Not inlined, so that a step that sets its inputs again needs few registers and little stack.
    #[inline(never)]
    fn set_each(&mut self, references: &[u32], of: Type, n: usize, value: impl Fn(usize) -> f64) -> Outcome {
        // In step mode the check per variable is needed only for structural parameters, and with event mode for all parameters (FMI 3.0.2
        // section 2.4.7.4).
        let special = self.mode != Mode::Step || of == Type::Size || self.part.event_mode;
        let running = !matches!(self.mode, Mode::Instantiated | Mode::Configuration | Mode::Initialization);
        let mut last = None;
        for (k, &value_reference) in references.iter().enumerate() {
            if value_reference == TIME && of == Type::Real {
                return Err(Refused::error("time is the independent variable and cannot be set."));
            }
            let entry = self.entry(value_reference, of)?;
            if special {
                self.require_to_set(entry)?;
            }
            // All settable variables are scalars. A variable that cannot be set is reported first, also if the number of values is wrong.
            if n != references.len() && entry.is_settable() {
                break;
            }
            let value = if k < n { entry.row.limited(value(k)) } else { f64::NAN };
            if let Err(refusal) = entry.check(value, running) {
                let message = entry.explain(value, &refusal);
                return Err(match refusal {
                    Refusal::Computed | Refusal::Fixed => Refused::error(message),
                    _ => Refused::discard(message),
                });
            }
            last = Some(entry);
        }
        if n != references.len() {
            return Err(wrong_number(references.len(), references.len(), n));
        }
        // All values are valid. A single value, the usual case, needs no second look-up.
        if let (&[_], Some(entry)) = (references, last) {
            self.write(entry, value(0));
        } else {
            for (k, &value_reference) in references.iter().enumerate() {
                self.write(self.entry(value_reference, of)?, value(k));
            }
        }
        self.unsettled = true;
        Ok(())
    }

    #[inline]
    fn write(&mut self, entry: &Entry, value: f64) {
        let used = entry.row.limited(value);
        self.model.set(entry.slot, used);
        if used != value {
            self.report_saturation(entry, value);
        }
    }

    /// Rejects a variable that cannot be set in the present mode.
    #[inline]
    fn require_to_set(&self, entry: &Entry) -> Outcome {
        if !entry.is_settable() {
            return Ok(());
        }
        let when = match self.mode {
            Mode::Continuous if !entry.is_continuous_input() => "at an event alone",
            Mode::Intermediate if !(entry.is_continuous_input() && self.part.has_intermediate(entry)) => {
                "between steps alone"
            }
            Mode::Step if self.part.event_mode && entry.row.causality == Causality::Parameter => {
                "in event mode alone, because the importer uses it,"
            }
            Mode::Configuration if !self.is_structural(entry) => "outside configuration mode alone",
            mode if mode != Mode::Configuration && self.is_structural(entry) => "in configuration mode alone",
            _ => return Ok(()),
        };
        Err(Refused::error(format!(
            "{} can be set {when} and the instance is {}.",
            entry.name,
            self.mode.words()
        )))
    }

    /// Sets the derivatives of continuous inputs for the next step, all or none.
    pub fn set_slopes(&mut self, references: &[u32], orders: &[i32], slopes: &[f64]) -> Outcome {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Instantiated, Mode::Initialization, Mode::Step])?;
        let mut saturates = false;
        if let Some(places) = self.sloped.places(references)
            && orders.iter().all(|&order| order == 1)
            && slopes.iter().all(|slope| slope.is_finite())
        {
            for (place, &slope) in places.iter().zip(slopes) {
                self.model.set_slope(place.slot, slope);
                saturates |= place.saturates && slope != 0.0;
            }
            if saturates {
                self.expect_limits();
            }
            return Ok(());
        }
        for ((&value_reference, &order), &slope) in references.iter().zip(orders).zip(slopes) {
            let entry = self.entry(value_reference, Type::Real)?;
            if !entry.is_continuous_input() {
                return Err(Refused::error(format!(
                    "{} is not a continuous input and has no input derivative.",
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
                    "the input derivative {slope} {}/s of {} is not a finite number.",
                    entry.row.unit.name(),
                    entry.name
                )));
            }
        }
        for (&value_reference, &slope) in references.iter().zip(slopes) {
            let entry = self.entry(value_reference, Type::Real)?;
            self.model.set_slope(entry.slot, slope);
            saturates |= entry.row.saturates && slope != 0.0;
        }
        if saturates {
            self.expect_limits();
        }
        self.sloped.store(self.model.declaration(), references);
        Ok(())
    }
}

fn wrong_number(variables: usize, wanted: usize, there: usize) -> Refused {
    Refused::error(format!("{variables} variables have {wanted} values, but {there} are given."))
}
