//! Text to values: `--set name=value`, cells of input tables.
use crate::error::suggestion;
use crate::quantity::{in_unit, number_with_unit};
use crate::{Causality, Error, Kind, ModelDescription, Variability, Variable};

/// A value that a variable can be set to.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// For `Float64` and `Float32`; in the variable's unit.
    Real(f64),
    /// For all integers and enumerations.
    Integer(i128),
    /// For `Boolean`.
    Boolean(bool),
    /// For `String`.
    String(String),
    /// For `Binary`; as text in hexadecimal digits.
    Binary(Vec<u8>),
}

impl ModelDescription {
    /// The parameter or input called `name` and `text` as a value of its type, within its limits.
    ///
    /// Enumerations take the name of an item or its number, Booleans true, false, 1 or 0.
    ///
    /// # Errors
    /// An unknown name (with similar ones), a variable that is not for the user to set, text that is no finite
    /// value of the type, a value outside min and max.
    pub fn parse_value(&self, name: &str, text: &str) -> Result<(&Variable, Value), Error> {
        let variable = self.settable(name)?;
        Ok((variable, self.value_of(variable, text)?))
    }

    /// The parameter or input called `name`.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`], [`Error::Unsupported`].
    pub fn settable(&self, name: &str) -> Result<&Variable, Error> {
        let variable = self.variable(name).ok_or_else(|| Error::UnknownVariable {
            name: name.to_owned(),
            model: self.model_name.clone(),
            near: self.near(name),
        })?;
        use Causality::{Input, Parameter, StructuralParameter};
        let role_fits = matches!(variable.causality, Parameter | StructuralParameter | Input);
        if role_fits && variable.variability != Variability::Constant {
            return Ok(variable);
        }
        let what = match variable.variability {
            Variability::Constant => format!("a constant {}", variable.causality),
            _ if variable.causality == Causality::Output => "an output".to_owned(),
            _ if variable.causality == Causality::Independent => "the independent variable".to_owned(),
            _ => format!("a {}", variable.causality),
        };
        let reason = format!("cannot be set: it is {what}, and only parameters and inputs can be");
        Err(Error::unsupported(name, reason))
    }

    /// The numeric variable called `name`, of any causality.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`], [`Error::Unsupported`] for one that is no number.
    pub(crate) fn recordable(&self, name: &str) -> Result<&Variable, Error> {
        let unknown = || Error::UnknownVariable {
            name: name.to_owned(),
            model: self.model_name.clone(),
            near: nearest(name, self.variables.iter().map(|v| v.name.as_str())),
        };
        let variable = self.variable(name).ok_or_else(unknown)?;
        if variable.kind.is_numeric() {
            return Ok(variable);
        }
        Err(Error::unsupported(name, "cannot be recorded: it is not a number"))
    }

    /// `text` as a value of `variable`, within its limits. A real number may have a unit, such as `300 rpm`: one of the FMU or any of the
    /// quantity; without one it is in the unit of the variable.
    ///
    /// # Errors
    /// [`Error::BadValue`], [`Error::OutOfRange`], [`Error::Unsupported`] for a unit of another quantity and for arrays, binaries and clocks.
    pub fn value_of(&self, variable: &Variable, text: &str) -> Result<Value, Error> {
        let Some((number, unit)) = number_with_unit(variable, text) else {
            let value = self.typed_value(variable, text)?;
            check_limits(variable, &value)?;
            return Ok(value);
        };
        let number = in_unit(self, variable, number, unit)?;
        if !number.is_finite() {
            return Err(Error::BadValue {
                name: variable.name.clone(),
                text: text.to_owned(),
                expected: finite(variable),
            });
        }
        let value = self.typed_value(variable, &number.to_string())?;
        check_limits(variable, &value).map_err(|error| match error {
            // The unit was stated: it is no other one by mistake.
            Error::OutOfRange { name, value, min, max, unit, .. } => {
                Error::OutOfRange { name, value, min, max, unit, may_be_celsius: false }
            }
            other => other,
        })?;
        Ok(value)
    }

    /// As [`Self::value_of`], without the limits of the variable.
    pub(crate) fn typed_value(&self, variable: &Variable, text: &str) -> Result<Value, Error> {
        let text = text.trim();
        let bad = |expected: String| Error::BadValue {
            name: variable.name.clone(),
            text: text.to_owned(),
            expected,
        };
        if !variable.dimensions.is_empty() || variable.kind == Kind::Clock {
            let what = if variable.dimensions.is_empty() { "clocks" } else { "arrays" };
            let reason = format!("cannot be set from text: {what} have no text form here");
            return Err(Error::unsupported(&variable.name, reason));
        }
        match variable.kind {
            Kind::Boolean => match text {
                "true" | "1" => Ok(Value::Boolean(true)),
                "false" | "0" => Ok(Value::Boolean(false)),
                _ => Err(bad("true or false".to_owned())),
            },
            Kind::String => Ok(Value::String(text.to_owned())),
            Kind::Binary => parse_hex(text)
                .map(Value::Binary)
                .ok_or_else(|| bad("an even number of hexadecimal digits".to_owned())),
            kind if kind.is_float() => {
                let value: f64 = text.parse().map_err(|_| bad(finite(variable)))?;
                // A Float32 must be finite after rounding, too.
                let fits = if kind == Kind::Float32 { (value as f32).is_finite() } else { value.is_finite() };
                if !fits {
                    return Err(bad(finite(variable)));
                }
                Ok(Value::Real(value))
            }
            Kind::Enumeration => {
                self.item(variable, text).map(|i| Value::Integer(i.into())).ok_or_else(|| {
                    let items = self.enumeration(variable).map_or(&[][..], |e| &e.items);
                    let names: Vec<_> = items.iter().map(|i| format!("{} ({})", i.name, i.value)).collect();
                    let near = nearest(text, items.iter().map(|i| i.name.as_str()));
                    bad(if names.is_empty() {
                        "an item of its enumeration".to_owned()
                    } else {
                        format!("one of {}{}", names.join(", "), suggestion(&near))
                    })
                })
            }
            kind => {
                let (low, high) = integer_limits(kind);
                let value: i128 = text.parse().map_err(|_| bad("a whole number".to_owned()))?;
                if value < low || value > high {
                    return Err(bad(format!("a whole number from {low} to {high}")));
                }
                Ok(Value::Integer(value))
            }
        }
    }

    /// The number of an item given by name or number. A type without items takes any number.
    fn item(&self, variable: &Variable, text: &str) -> Option<i64> {
        let items = self.enumeration(variable).map_or(&[][..], |e| &e.items);
        if let Some(item) = items.iter().find(|i| i.name == text) {
            return Some(item.value);
        }
        let number: i64 = text.parse().ok()?;
        (items.is_empty() || items.iter().any(|i| i.value == number)).then_some(number)
    }

    /// At most three settable names similar to `name`, best first.
    fn near(&self, name: &str) -> Vec<String> {
        nearest(name, self.variables.iter().filter(|v| self.settable_role(v)).map(|v| v.name.as_str()))
    }

    fn settable_role(&self, v: &Variable) -> bool {
        matches!(v.causality, Causality::Parameter | Causality::StructuralParameter | Causality::Input)
    }
}

/// At most three of the `candidates` similar to `name`, best first.
pub(crate) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Vec<String> {
    let wanted = name.to_lowercase();
    let letters = wanted.chars().count();
    let mut scored: Vec<(usize, bool, usize, &str)> = Vec::new();
    for original in candidates {
        let candidate = original.to_lowercase();
        let contains = wanted.len() >= 3 && candidate.contains(&wanted);
        let score = if contains { 1 } else { strsim::osa_distance(&wanted, &candidate) };
        // A third of the letters may differ, but never all of them.
        if contains || score <= (1 + letters / 4).min(letters.saturating_sub(1)) {
            // First those in which a part of the name begins with it, the shortest before longer ones.
            let begins =
                candidate.starts_with(&wanted) || candidate.split('.').any(|part| part.starts_with(&wanted));
            scored.push((score, !begins, candidate.len(), original));
        }
    }
    scored.sort();
    scored.into_iter().take(3).map(|(.., name)| name.to_owned()).collect()
}

fn finite(variable: &Variable) -> String {
    variable
        .unit
        .as_ref()
        .filter(|u| *u != "1")
        .map_or("a finite number".to_owned(), |u| format!("a finite number (in {u})"))
}

/// Whether a number is within the limits of its variable.
pub(crate) fn check_limits(variable: &Variable, value: &Value) -> Result<(), Error> {
    let value = match value {
        Value::Real(x) => *x,
        Value::Integer(x) if variable.kind != Kind::Enumeration => *x as f64,
        _ => return Ok(()),
    };
    let above = variable.min.is_none_or(|min| value >= min);
    let below = variable.max.is_none_or(|max| value <= max);
    if above && below {
        return Ok(());
    }
    Err(Error::OutOfRange {
        name: variable.name.clone(),
        value,
        min: variable.min,
        max: variable.max,
        unit: variable.unit.clone(),
        may_be_celsius: !variable.relative,
    })
}

/// The bytes of an xs:hexBinary.
pub(crate) fn parse_hex(text: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let pair = |pair: &[u8]| Some((16 * digit(pair[0])? + digit(*pair.get(1)?)?) as u8);
    text.as_bytes().chunks(2).map(pair).collect()
}

/// The range of an integer type.
pub(crate) fn integer_limits(kind: Kind) -> (i128, i128) {
    match kind {
        Kind::Int8 => (i8::MIN.into(), i8::MAX.into()),
        Kind::UInt8 => (0, u8::MAX.into()),
        Kind::Int16 => (i16::MIN.into(), i16::MAX.into()),
        Kind::UInt16 => (0, u16::MAX.into()),
        Kind::Int32 => (i32::MIN.into(), i32::MAX.into()),
        Kind::UInt32 => (0, u32::MAX.into()),
        Kind::UInt64 => (0, u64::MAX.into()),
        _ => (i64::MIN.into(), i64::MAX.into()),
    }
}
