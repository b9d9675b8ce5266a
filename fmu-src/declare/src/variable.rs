//! A row of a table, and what a group of rows can do.

use crate::{Enumeration, Unit};

/// The role of a variable, in FMI's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before or during a run.
    Parameter,
    /// Set by the importer at every communication point.
    Input,
    /// Computed by the model.
    Output,
    /// Computed by the model, and of use to those who integrate it: states, their derivatives, event indicators.
    Local,
}

/// When a variable may change, in FMI's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Never after initialization.
    Fixed,
    /// At any communication point.
    Tunable,
    /// At events only.
    Discrete,
    /// At any time.
    Continuous,
}

/// How a fit should step through the range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By differences.
    Linear,
    /// By ratios; the lower limit is positive.
    Log,
}

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 64-bit floating point.
    Real,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
    /// One of named choices.
    Enumeration(&'static Enumeration),
}

/// A value that a table can hold. All values pass through tables as `f64`, which represents each kind exactly.
pub trait Scalar: Copy {
    /// The kind of the type.
    const KIND: Kind;
    /// The value as a number: Booleans 0 or 1, enumerations their FMI value.
    fn to_f64(self) -> f64;
    /// The value of a number, or `None` where the type has no such value.
    fn from_f64(value: f64) -> Option<Self>;
}

impl Scalar for f64 {
    const KIND: Kind = Kind::Real;
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Option<f64> {
        Some(value)
    }
}

impl Scalar for i32 {
    const KIND: Kind = Kind::Integer;
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn from_f64(value: f64) -> Option<i32> {
        // The cast saturates and drops fractions and NaN; what comes back unchanged was a whole number that fits.
        (f64::from(value as i32) == value).then_some(value as i32)
    }
}

impl Scalar for bool {
    const KIND: Kind = Kind::Boolean;
    fn to_f64(self) -> f64 {
        f64::from(u8::from(self))
    }
    fn from_f64(value: f64) -> Option<bool> {
        match value {
            0.0 => Some(false),
            1.0 => Some(true),
            _ => None,
        }
    }
}

/// The declaration of one variable: a row of [`Group::TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct Variable {
    /// Name within its group; the model puts the group's prefix before it.
    pub name: &'static str,
    /// Value reference within its group; the model adds the group's base. Never re-used.
    pub value_reference: u32,
    /// Role.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Type.
    pub kind: Kind,
    /// Unit of the value.
    pub unit: Unit,
    /// Value at the start; `NaN` where the model computes it.
    pub start: f64,
    /// Least value allowed.
    pub min: f64,
    /// Greatest value allowed.
    pub max: f64,
    /// Typical size, positive.
    pub nominal: f64,
    /// How a fit steps through the range.
    pub scale: Scale,
    /// True for a difference of temperatures: no offset when shown in degrees Celsius.
    pub relative: bool,
    /// Description: what it is and how its sign counts.
    pub doc: &'static str,
    /// Where the start value comes from; empty where it is 0, a mode, or computed.
    pub source: &'static str,
}

impl Variable {
    const fn new(
        value_reference: u32,
        causality: Causality,
        variability: Variability,
        unit: Unit,
        start: f64,
        min: f64,
        max: f64,
    ) -> Variable {
        Variable {
            name: "",
            value_reference,
            causality,
            variability,
            kind: Kind::Real,
            unit,
            start,
            min,
            max,
            nominal: 1.0,
            scale: Scale::Linear,
            relative: false,
            doc: "",
            source: "",
        }
    }

    /// A parameter that may be changed between steps. Its nominal value is its start, or 1 where that is 0.
    pub const fn tunable(value_reference: u32, start: f64, unit: Unit, min: f64, max: f64) -> Variable {
        let row =
            Variable::new(value_reference, Causality::Parameter, Variability::Tunable, unit, start, min, max);
        row.nominal(if start == 0.0 { 1.0 } else { start.abs() })
    }

    /// A choice that holds for the whole run; `start` is the FMI value of the item.
    pub const fn choice(value_reference: u32, start: i32) -> Variable {
        Variable::new(
            value_reference,
            Causality::Parameter,
            Variability::Fixed,
            Unit::One,
            start as f64,
            f64::NEG_INFINITY,
            f64::INFINITY,
        )
    }

    /// A whole number that holds for the whole run.
    pub const fn count(value_reference: u32, start: i32, min: i32, max: i32) -> Variable {
        let mut row = Variable::tunable_count(value_reference, start, min, max);
        row.variability = Variability::Fixed;
        row
    }

    /// A whole number that may be changed between steps.
    pub const fn tunable_count(value_reference: u32, start: i32, min: i32, max: i32) -> Variable {
        Variable::tunable(value_reference, start as f64, Unit::One, min as f64, max as f64)
    }

    /// An input, continuous between communication points where the importer gives slopes.
    pub const fn input(value_reference: u32, start: f64, unit: Unit, min: f64, max: f64) -> Variable {
        Variable::new(value_reference, Causality::Input, Variability::Continuous, unit, start, min, max)
    }

    /// An output that changes continuously.
    pub const fn output(value_reference: u32, unit: Unit) -> Variable {
        Variable::new(
            value_reference,
            Causality::Output,
            Variability::Continuous,
            unit,
            f64::NAN,
            f64::NEG_INFINITY,
            f64::INFINITY,
        )
    }

    /// An output that changes at events only.
    pub const fn flag(value_reference: u32) -> Variable {
        let mut row = Variable::output(value_reference, Unit::One);
        row.variability = Variability::Discrete;
        row
    }

    /// A variable that shows the inside of the model and changes continuously.
    pub const fn local(value_reference: u32, unit: Unit) -> Variable {
        let mut row = Variable::output(value_reference, unit);
        row.causality = Causality::Local;
        row
    }

    /// With a typical size.
    pub const fn nominal(mut self, nominal: f64) -> Variable {
        self.nominal = nominal;
        self
    }

    /// With the source of its start value.
    pub const fn source(mut self, source: &'static str) -> Variable {
        self.source = source;
        self
    }

    /// With a fit that steps by ratios.
    pub const fn log(mut self) -> Variable {
        self.scale = Scale::Log;
        self
    }

    /// A difference of temperatures.
    pub const fn difference(mut self) -> Variable {
        self.relative = true;
        self
    }

    /// Used by [`variables!`](crate::variables): adds what the field itself says.
    #[doc(hidden)]
    pub const fn named(mut self, name: &'static str, doc: &'static str, kind: Kind) -> Variable {
        self.name = name;
        self.doc = doc;
        self.kind = kind;
        self
    }
}

/// A struct of variables with its table. Implemented by [`variables!`](crate::variables).
pub trait Group {
    /// One row a field, in the order of the fields.
    const TABLE: &'static [Variable];
    /// The value of row `index`.
    ///
    /// # Panics
    /// Where the table has no such row.
    fn get(&self, index: usize) -> f64;
    /// Sets the value of row `index`; false, and nothing changed, where its type has no such value.
    ///
    /// # Panics
    /// Where the table has no such row.
    fn set(&mut self, index: usize, value: f64) -> bool;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_takes_whole_numbers_only() {
        assert_eq!(i32::from_f64(7.0), Some(7));
        assert_eq!(i32::from_f64(-3.0), Some(-3));
        for no in [0.5, f64::NAN, f64::INFINITY, 3e9] {
            assert_eq!(i32::from_f64(no), None, "{no}");
        }
        let (fixed, tunable) = (Variable::count(1, 4, 1, 8), Variable::tunable_count(1, 4, 1, 8));
        assert_eq!((fixed.variability, tunable.variability), (Variability::Fixed, Variability::Tunable));
        assert_eq!((fixed.start, fixed.min, fixed.max), (4.0, 1.0, 8.0));
    }
}
