//! What a sweep varies: numbers, items of enumerations, presets.

use super::MAX_POINTS;
use crate::StudyError;
use crate::numeric::linspace;
use serde::Serialize;

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

    /// For tables and labels.
    pub fn shown(&self) -> String {
        match self {
            Choice::Number(number) => present::number(*number),
            Choice::Word(word) => word.clone(),
        }
    }
}

/// A variable and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// Name of an input or a parameter, or [`PRESET`].
    pub name: String,
    /// Its values.
    pub values: Vec<Choice>,
}

impl Vary {
    /// From `name=from:to:n`, both ends included, or `name=value,value,...`.
    ///
    /// # Errors
    /// One sentence naming what is wrong.
    pub fn parse(text: &str) -> Result<Vary, StudyError> {
        let wrong = |why: &str| {
            StudyError::new(format!("--vary {text}: {why}; expected name=from:to:n or name=value,value,..."))
        };
        let (name, range) = text.split_once('=').ok_or_else(|| wrong("there is no ="))?;
        if name.trim().is_empty() {
            return Err(wrong("there is no name"));
        }
        let name = name.trim().to_owned();
        if !range.contains(':') {
            let items: Vec<&str> = range.split(',').map(str::trim).collect();
            if items.iter().any(|item| item.is_empty()) {
                return Err(wrong("a value is missing"));
            }
            let choice = |item: &&str| match item.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Choice::Number(number)),
                Ok(number) => Err(wrong(&format!("{number} is not a finite number"))),
                Err(_) => Ok(Choice::Word((*item).to_owned())),
            };
            return Ok(Vary { name, values: items.iter().map(choice).collect::<Result<_, _>>()? });
        }
        let parts: Vec<&str> = range.split(':').collect();
        let [from, to, n] = parts[..] else { return Err(wrong("there are not three numbers behind =")) };
        let number = |text: &str| {
            let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(&format!("{text} is not a finite number")))
        };
        let (from, to) = (number(from)?, number(to)?);
        let n: usize =
            n.trim().parse().map_err(|_| wrong(&format!("{n} is not a whole number of points")))?;
        if !(1..=MAX_POINTS).contains(&n) {
            return Err(wrong(&format!("{n} points are not within 1 ... {MAX_POINTS}")));
        }
        Ok(Vary { name, values: linspace(from, to, n).into_iter().map(Choice::Number).collect() })
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
