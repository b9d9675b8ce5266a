//! What a sweep varies: numbers, items of enumerations, presets.

use super::MAX_POINTS;
use super::shown::Shown;
use crate::StudyError;
use crate::numeric::linspace;
use serde::Serialize;
use units::Conversion;

/// The name under which the motor is varied.
pub const PRESET: &str = "preset";

/// A value of a varied variable.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Choice {
    /// A number in SI units.
    Number(f64),
    /// An item, a preset, or a number with its unit.
    Word(String),
}

impl Choice {
    /// As text for a setting.
    pub fn text(&self) -> String {
        match self {
            Choice::Number(number) => number.to_string(),
            Choice::Word(word) => word.clone(),
        }
    }

    /// The number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Choice::Number(number) => Some(*number),
            Choice::Word(_) => None,
        }
    }

    /// For tables and labels, without unit; a word has its own.
    pub fn shown(&self, unit: &Shown) -> String {
        self.number().map_or_else(|| self.text(), |si| present::number(unit.of(si)))
    }

    /// The same with the unit.
    pub fn with_unit(&self, unit: &Shown) -> String {
        let behind = self.number().map_or(String::new(), |_| unit.unit(" "));
        format!("{}{behind}", self.shown(unit))
    }

    /// The same in the usual notation of units, for figures.
    pub fn in_words(&self, unit: &Shown) -> String {
        let behind = self.number().map_or(String::new(), |_| present::words::unit(&unit.unit(" ")));
        format!("{}{behind}", self.shown(unit))
    }
}

/// A variable and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// Name of an input or a parameter, or [`PRESET`].
    pub name: String,
    /// Its values; [`Vary::resolved`] gives those with a unit in SI units.
    pub values: Vec<Choice>,
    /// The unit in which the values are shown: that of all of them, if they were given in one; else the SI unit.
    pub shown: Option<Shown>,
}

/// The forms of the option.
const FORMS: &str = "name=from:to:n or name=value,value,...";

impl Vary {
    /// From `name=from:to:n`, both ends included, or `name=value,value,...`; numbers may have units. A unit behind `to` alone is that of
    /// both ends.
    ///
    /// # Errors
    /// One sentence naming what is wrong.
    pub fn parse(text: &str) -> Result<Vary, StudyError> {
        let wrong = |why: &str| StudyError::new(format!("--vary {text}: {why}; expected {FORMS}"));
        let (name, values) = text.split_once('=').ok_or_else(|| wrong("there is no ="))?;
        if name.trim().is_empty() {
            return Err(wrong("there is no name"));
        }
        let name = name.trim().to_owned();
        if values.contains(':') {
            if name == PRESET {
                return Err(wrong("names of motors have no range"));
            }
            return Ok(Vary { name, values: range(values).map_err(|why| wrong(&why))?, shown: None });
        }
        let items: Vec<&str> = values.split(',').map(str::trim).collect();
        if items.iter().any(|item| item.is_empty()) {
            return Err(wrong("a value is missing"));
        }
        let choice = |item: &&str| match item.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Choice::Number(number)),
            Ok(number) => Err(wrong(&format!("{number} is not a finite number"))),
            Err(_) => Ok(Choice::Word((*item).to_owned())),
        };
        Ok(Vary { name, values: items.iter().map(choice).collect::<Result<_, _>>()?, shown: None })
    }

    /// Values with a unit as numbers in SI units, so that they are drawn on an axis and have ends; items and motors as they are.
    /// `conversion` is that of a variable and a unit ([`super::Case::conversion`]).
    ///
    /// # Errors
    /// There is no such variable, or its unit is of another quantity.
    pub fn resolved(
        &self,
        conversion: impl Fn(&str, &str) -> Result<Conversion, StudyError>,
    ) -> Result<Vary, StudyError> {
        let given = |value: &Choice| match value {
            Choice::Word(word) if self.name != PRESET => {
                units::split(word).map(|(x, unit)| (x, unit.to_owned()))
            }
            _ => None,
        };
        let all: Vec<Option<(f64, String)>> = self.values.iter().map(given).collect();
        let in_si = |(value, given): (&Choice, &Option<(f64, String)>)| match given {
            Some((number, unit)) => Ok(Choice::Number(conversion(&self.name, unit)?.of(*number))),
            None => Ok(value.clone()),
        };
        let in_unit = || {
            let (_, unit) = all.first()?.as_ref()?;
            all.iter().all(|given| given.as_ref().is_some_and(|(_, own)| own == unit)).then_some(unit)
        };
        let resolve = || -> Result<Vary, StudyError> {
            let given =
                |unit: &String| Ok::<_, StudyError>(Shown::given(unit, conversion(&self.name, unit)?));
            let values = self.values.iter().zip(&all).map(in_si).collect::<Result<_, StudyError>>()?;
            Ok(Vary { name: self.name.clone(), values, shown: in_unit().map(given).transpose()? })
        };
        resolve().map_err(|why| StudyError::new(format!("--vary {}: {why}", self.name)))
    }

    /// The ends of a range of numbers; all values of a list with words.
    pub(super) fn ends(&self) -> Vary {
        let mut ends = self.clone();
        if let (Some(_), [first, .., last]) = (self.numbers(), &self.values[..]) {
            ends.values = vec![first.clone(), last.clone()];
        }
        ends
    }

    /// The numbers, where all values are.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(Choice::number).collect()
    }
}

/// Values of `from:to:n`; those with a unit are words, such as a list has.
fn range(text: &str) -> Result<Vec<Choice>, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [from, to, n] = parts[..] else { return Err("there are not three numbers behind =".to_owned()) };
    let points: usize = n.parse().map_err(|_| {
        let unit = match units::split(n) {
            Some((_, unit)) if !unit.is_empty() => format!(" (a unit stands behind {to})"),
            _ => String::new(),
        };
        format!("{n} is not a whole number of points{unit}")
    })?;
    if !(1..=MAX_POINTS).contains(&points) {
        return Err(format!("{points} points are not within 1 ... {MAX_POINTS}"));
    }
    let [first, last] = [from, to].map(|end| {
        units::split(end)
            .filter(|(number, _)| number.is_finite())
            .ok_or_else(|| format!("{end} is not a finite number"))
    });
    let ((first, before), (last, unit)) = (first?, last?);
    let first = match before {
        "" => first,
        before if before == unit => first,
        _ if unit.is_empty() => {
            return Err(format!("{from} has a unit and {to} has none: the unit of both stands behind {to}"));
        }
        before => in_unit(first, before, unit)?,
    };
    let values = linspace(first, last, points).into_iter();
    if unit.is_empty() {
        return Ok(values.map(Choice::Number).collect());
    }
    Ok(values.map(|value| Choice::Word(format!("{value} {unit}"))).collect())
}

/// The number of one end of a range in the unit of the other.
fn in_unit(number: f64, from: &str, to: &str) -> Result<f64, String> {
    let [value, difference] = [false, true].map(|relative| units::conversion(from, to, relative));
    match (value, difference) {
        (Err(refusal), _) | (_, Err(refusal)) => Err(refusal.to_string()),
        // Whether the variable is a temperature or a difference of temperatures is not known yet.
        (Ok(value), Ok(difference)) if value.of(number) != difference.of(number) => {
            Err(format!("the ends are in {from} and {to}: both must be in one unit"))
        }
        (Ok(value), Ok(_)) => Ok(value.of(number)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steady::Setup;
    use crate::sweep::{Case, ConstantInputs, Goal, sweep};
    use std::f64::consts::PI;

    fn resolved(text: &str) -> Result<Vary, String> {
        let case = ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, &[]) };
        Vary::parse(text)
            .and_then(|vary| vary.resolved(|name, unit| case.conversion(name, unit)))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn values_with_a_unit_are_numbers() {
        let speed = 3000.0 * PI / 30.0;
        for (text, expected) in [
            ("imposed_speed=0:3000 rpm:4", [0.0, speed / 3.0, 2.0 * speed / 3.0, speed]),
            ("imposed_speed=0rpm : 3000 rpm : 4", [0.0, speed / 3.0, 2.0 * speed / 3.0, speed]),
            ("current_command=0 mA:3 A:4", [0.0, 1.0, 2.0, 3.0]),
            ("current_command=0:3:4", [0.0, 1.0, 2.0, 3.0]),
            ("ambient_temperature=20:50 degC:4", [293.15, 303.15, 313.15, 323.15]),
            ("ambient_temperature=293,15:323,15 K:4", [293.15, 303.15, 313.15, 323.15]),
            ("current_command=0 mA,1,2000 mA, 3 A", [0.0, 1.0, 2.0, 3.0]),
            ("ambient_temperature=20 degC,303.15,313.15 K,122degF", [293.15, 303.15, 313.15, 323.15]),
            // Equal steps in the unit that is given.
            ("motor.k_t=100:400 rpm/V:4", [1.0, 2.0, 3.0, 4.0].map(|k| 30.0 / (100.0 * k * PI))),
        ] {
            let found = resolved(text).unwrap().numbers().unwrap();
            let is_close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * b.abs();
            assert!(found.iter().zip(&expected).all(is_close), "{text}: {found:?}, expected {expected:?}");
        }
        for (text, words) in [
            ("current_command=0 A:5:6", "0 A has a unit and 5 has none: the unit of both stands behind 5"),
            ("current_command=0:5:6 A", "6 A is not a whole number of points (a unit stands behind 5)"),
            ("current_command=0:5 V:6", "current_command has the unit \"A\", not \"V\""),
            ("current_command=0 V:5 A:6", "\"V\" is not a unit of the same quantity as \"A\""),
            ("ambient_temperature=20 degC:300 K:3", "the ends are in degC and K: both must be in one unit"),
            ("cooling_mode=0:3 A:3", "\"A\""),
            ("preset=0:3 A:3", "names of motors have no range"),
            ("curent_command=0:5 A:6", "did you mean current_command?"),
            ("current_command=1 A,2 V", "current_command has the unit \"A\", not \"V\""),
        ] {
            let error = resolved(text).unwrap_err();
            assert!(error.starts_with("--vary ") && error.contains(words), "{text}: {error}");
        }
    }

    /// Names stay names, also one that begins with a number.
    #[test]
    fn items_and_motors_are_no_numbers() {
        for (text, words) in [
            ("cooling_mode=bare,annulus_push", ["bare", "annulus_push"]),
            ("preset=3kW.toml,maxon-305015", ["3kW.toml", "maxon-305015"]),
        ] {
            let expected = words.map(|word| Choice::Word(word.to_owned()));
            assert_eq!(resolved(text).unwrap().values, expected, "{text}");
        }
    }

    /// Also where a caller does not resolve the range, a point has the value with its unit.
    #[test]
    fn points_of_a_range_with_a_unit_are_those_of_its_numbers() {
        let case = ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, &[]) };
        let found = |vary: &Vary| {
            let found =
                sweep(&case, std::slice::from_ref(vary), &Goal::of("winding_temperature"), |_| {}).unwrap();
            found.points.iter().map(|p| p.objective.unwrap()).collect::<Vec<_>>()
        };
        let range = Vary::parse("ambient_temperature=20:30 degC:2").unwrap();
        let expected = found(&Vary::parse("ambient_temperature=293.15:303.15:2").unwrap());
        assert_eq!(
            (found(&range), found(&range.resolved(|name, unit| case.conversion(name, unit)).unwrap())),
            (expected.clone(), expected)
        );
    }
}
