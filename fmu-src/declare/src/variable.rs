//! A declared variable, and the trait of a group of variables.

use crate::{Enumeration, Unit};

/// Causality as in FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before or during a simulation.
    Parameter,
    /// Set by the importer at every communication point.
    Input,
    /// Computed by the model.
    Output,
    /// Computed by the model, for Model Exchange importers: states, derivatives, event indicators.
    Local,
}

/// Variability as in FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialization.
    Fixed,
    /// Can change at any communication point.
    Tunable,
    /// Changes only at events.
    Discrete,
    /// Changes at any time.
    Continuous,
}

/// Scale of a parameter in a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic; the lower limit is positive.
    Log,
}

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 64-bit floating point.
    Real,
    /// Integer.
    Integer,
    /// Boolean.
    Boolean,
    /// Enumeration.
    Enumeration(&'static Enumeration),
}

/// A value of a variable. All values are transferred as `f64`, which represents each kind exactly.
pub trait Scalar: Copy {
    /// The kind of the type.
    const KIND: Kind;
    /// The value as a number: Booleans 0 or 1, enumerations their FMI value.
    fn to_f64(self) -> f64;
    /// Conversion from a number; `None` if the type has no such value.
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
        // The cast saturates and drops fractions and NaN; only an integer in range is unchanged.
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

/// The declaration of one variable: an element of [`Group::TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct Variable {
    /// Name in its group; the model adds the prefix of the group.
    pub name: &'static str,
    /// Value reference in its group; the model adds the base of the group. Never reused.
    pub value_reference: u32,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// Type.
    pub kind: Kind,
    /// Unit of the value.
    pub unit: Unit,
    /// Start value; `NaN` for a computed variable.
    pub start: f64,
    /// Lower limit.
    pub min: f64,
    /// Upper limit.
    pub max: f64,
    /// Nominal value, positive.
    pub nominal: f64,
    /// Scale in a fit.
    pub scale: Scale,
    /// True for a temperature difference: no offset in degrees Celsius.
    pub relative: bool,
    /// True for a variable that grows without limit during a simulation, far above its nominal value.
    pub unbounded: bool,
    /// True for an input that saturates: a finite value outside the limits acts as the limit.
    pub saturates: bool,
    /// Description with sign convention.
    pub doc: &'static str,
    /// Source of the start value; empty if the value is 0, a mode, or computed.
    pub source: &'static str,
    /// For the initial temperature of a node, whose name is that of the output: outputs at whose measured temperature it starts if its own
    /// is not measured, the nearest first.
    pub near: &'static [&'static str],
    /// For an output that is the temperature of a node: name of the node's initial temperature without `initial.`, if it is not that of the
    /// output; else empty.
    pub node: &'static str,
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
            saturates: false,
            unbounded: false,
            doc: "",
            source: "",
            near: &[],
            node: "",
        }
    }

    /// A tunable parameter. Its nominal value is its start value, or 1 if that is 0.
    pub const fn tunable(value_reference: u32, start: f64, unit: Unit, min: f64, max: f64) -> Variable {
        let row =
            Variable::new(value_reference, Causality::Parameter, Variability::Tunable, unit, start, min, max);
        row.nominal(if start == 0.0 { 1.0 } else { start.abs() })
    }

    /// A fixed parameter: it can only be set before the end of initialization.
    pub const fn fixed(value_reference: u32, start: f64, unit: Unit, min: f64, max: f64) -> Variable {
        let mut row = Variable::tunable(value_reference, start, unit, min, max);
        row.variability = Variability::Fixed;
        row
    }

    /// The initial temperature of a node; see [`near`](Variable::near).
    pub const fn initial_temperature(value_reference: u32, near: &'static [&'static str]) -> Variable {
        let mut row = Variable::fixed(value_reference, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0);
        row.near = near;
        row
    }

    /// A fixed enumeration; `start` is the FMI value of the item.
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

    /// A fixed integer.
    pub const fn count(value_reference: u32, start: i32, min: i32, max: i32) -> Variable {
        let mut row = Variable::tunable_count(value_reference, start, min, max);
        row.variability = Variability::Fixed;
        row
    }

    /// A tunable integer.
    pub const fn tunable_count(value_reference: u32, start: i32, min: i32, max: i32) -> Variable {
        Variable::tunable(value_reference, start as f64, Unit::One, min as f64, max as f64)
    }

    /// An input; linear between communication points if the importer sets input derivatives.
    pub const fn input(value_reference: u32, start: f64, unit: Unit, min: f64, max: f64) -> Variable {
        Variable::new(value_reference, Causality::Input, Variability::Continuous, unit, start, min, max)
    }

    /// A continuous output.
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

    /// A discrete output.
    pub const fn flag(value_reference: u32) -> Variable {
        let mut row = Variable::output(value_reference, Unit::One);
        row.variability = Variability::Discrete;
        row
    }

    /// A continuous local variable.
    pub const fn local(value_reference: u32, unit: Unit) -> Variable {
        let mut row = Variable::output(value_reference, unit);
        row.causality = Causality::Local;
        row
    }

    /// With a nominal value.
    pub const fn nominal(mut self, nominal: f64) -> Variable {
        self.nominal = nominal;
        self
    }

    /// An output that is the temperature of this node; see [`node`](Variable::node).
    pub const fn of_node(mut self, node: &'static str) -> Variable {
        self.node = node;
        self
    }

    /// With the source of its start value.
    pub const fn source(mut self, source: &'static str) -> Variable {
        self.source = source;
        self
    }

    /// With a logarithmic scale in a fit.
    pub const fn log(mut self) -> Variable {
        self.scale = Scale::Log;
        self
    }

    /// A temperature difference.
    pub const fn difference(mut self) -> Variable {
        self.relative = true;
        self
    }

    /// A variable that grows without limit.
    pub const fn unbounded(mut self) -> Variable {
        self.unbounded = true;
        self
    }

    /// An input that saturates at its limits.
    pub const fn saturates(mut self) -> Variable {
        self.saturates = true;
        self
    }

    /// The value that the model uses: a finite value of an input that saturates is limited to its range.
    #[inline]
    pub fn limited(&self, value: f64) -> f64 {
        if self.saturates && value.is_finite() { value.clamp(self.min, self.max) } else { value }
    }

    /// Used by [`variables!`](crate::variables!): adds name, description and type of the field.
    #[doc(hidden)]
    pub const fn named(mut self, name: &'static str, doc: &'static str, kind: Kind) -> Variable {
        self.name = name;
        self.doc = doc;
        self.kind = kind;
        self
    }
}

/// A struct of variables with its table. Implemented by [`variables!`](crate::variables!).
pub trait Group {
    /// One element per field, in the order of the fields.
    const TABLE: &'static [Variable];
    /// The value of element `index`.
    ///
    /// # Panics
    /// If the table has no such element.
    fn get(&self, index: usize) -> f64;
    /// Sets the value of element `index`; false, without a change, if its type has no such value.
    ///
    /// # Panics
    /// If the table has no such element.
    fn set(&mut self, index: usize, value: f64) -> bool;

    /// A group with the value 0 in every row.
    ///
    /// # Panics
    /// If the type of a row has no value 0.
    fn zero() -> Self
    where
        Self: Sized;

    /// All values, in the order of the table.
    fn values(&self) -> impl Iterator<Item = f64> {
        (0..Self::TABLE.len()).map(|row| self.get(row))
    }

    /// Sets all values from a sequence; `None` if it is too short or a type has no such value.
    fn take_values(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        (0..Self::TABLE.len()).try_for_each(|row| self.set(row, next()?).then_some(()))
    }

    /// The values after `t` seconds with these derivatives, per second.
    #[inline]
    fn after(&self, t: f64, slopes: &Self) -> Self
    where
        Self: Copy,
    {
        let mut moved = *self;
        for row in 0..Self::TABLE.len() {
            moved.set(row, self.get(row) + slopes.get(row) * t);
        }
        moved
    }
}

/// A struct of variables whose rows have names. Implemented by [`variables!`](crate::variables!).
pub trait Named: Group {
    /// The rows: an enumeration with the names of the fields.
    type Row: Copy;
    /// The row of element `index`; `None` if the table has no such element.
    fn row(index: usize) -> Option<Self::Row>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_input_that_saturates_is_limited() {
        let fan = Variable::input(1, 0.0, Unit::One, 0.0, 1.0);
        for (value, limited) in [(1.02, 1.0), (-3.0, 0.0), (0.4, 0.4), (f64::INFINITY, f64::INFINITY)] {
            assert_eq!(fan.saturates().limited(value), limited);
            assert_eq!(fan.limited(value), value);
        }
        assert!(fan.saturates().limited(f64::NAN).is_nan());
    }

    #[test]
    fn an_integer_accepts_integers_only() {
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
