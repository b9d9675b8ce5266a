//! The two published systems, number by number: published, recomputed as published, corrected, measured.

pub mod paper;
pub mod report;
pub mod thesis;

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the audit says of a published number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It follows from what is published.
    #[default]
    Holds,
    /// It follows, with the restriction in the note.
    HoldsWithNote,
    /// It does not follow from what is published.
    Inconsistent,
    /// A text, equation or reference is misprinted, missing or in the wrong place.
    EditorialError,
    /// The unit is wrong.
    UnitError,
    /// The sign is wrong.
    SignError,
    /// The physics is wrong.
    PhysicsError,
    /// The agreement is built in.
    NotAValidation,
    /// Neither right nor wrong: what follows from it.
    Remark,
}

impl Verdict {
    /// All verdicts in their order, as words in a table.
    pub const ALL: [(Verdict, &str); 9] = [
        (Verdict::Holds, "holds"),
        (Verdict::HoldsWithNote, "holds, see note"),
        (Verdict::Inconsistent, "inconsistent"),
        (Verdict::EditorialError, "editorial error"),
        (Verdict::UnitError, "unit error"),
        (Verdict::SignError, "sign error"),
        (Verdict::PhysicsError, "physics error"),
        (Verdict::NotAValidation, "not a validation"),
        (Verdict::Remark, "remark"),
    ];

    /// As words in a table.
    pub fn text(self) -> &'static str {
        Verdict::ALL[self as usize].1
    }
}

/// How a native model came to a value that stands beside a published one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Parameters of the model were fitted to the published value: the agreement is that of a fit.
    Fitted,
    /// The published value was not used in the fit.
    Predicted,
}

impl Basis {
    /// As a word in a table.
    pub fn text(self) -> &'static str {
        match self {
            Basis::Fitted => "fitted",
            Basis::Predicted => "predicted",
        }
    }
}

/// What is published: a number, or text and formulas.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Printed {
    /// A number in the row's unit.
    Number(f64),
    /// Words.
    Text(String),
}

impl Default for Printed {
    /// Nothing, until the program enters a constant of its own.
    fn default() -> Printed {
        Printed::Text(String::new())
    }
}

/// A published number or statement, recomputed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Number in the audit, with a suffix where it has several.
    #[serde(skip_deserializing)]
    pub id: String,
    /// Where it is published.
    #[serde(default)]
    pub location: String,
    /// What it is.
    pub quantity: String,
    /// The published value.
    #[serde(default)]
    pub printed: Printed,
    /// Recomputed by the published equations and inputs.
    pub as_published: Option<f64>,
    /// Recomputed with correct equations and the inputs that were used.
    pub corrected: Option<f64>,
    /// Whether the model of `corrected` was fitted to the published value; `None` without a fitted model.
    pub basis: Option<Basis>,
    /// Computed by the native model with declared values, untuned.
    pub untuned: Option<f64>,
    /// Computed by the native model fitted to the other tests, without this one.
    pub leave_one_out: Option<f64>,
    /// Measured by the authors.
    pub measured: Option<f64>,
    /// Unit of all values.
    pub unit: String,
    /// Verdict.
    #[serde(default)]
    pub verdict: Verdict,
    /// Why.
    #[serde(default)]
    pub note: String,
}

impl Row {
    /// Enters a published value that is a constant of the program.
    fn printed(&mut self, value: f64) -> &mut Row {
        self.printed = Printed::Number(value);
        self
    }

    /// Enters the value that the published equations give.
    fn published(&mut self, value: f64) -> &mut Row {
        self.as_published = Some(value);
        self
    }

    fn right(&mut self, value: impl Into<Option<f64>>) -> &mut Row {
        self.corrected = value.into();
        self
    }

    /// Enters the origin of the corrected value: fit or prediction.
    fn by(&mut self, basis: Basis) -> &mut Row {
        self.basis = self.corrected.map(|_| basis);
        self
    }

    /// Enters the predictions of the untuned model and of the model fitted to the other tests.
    fn predictions(&mut self, untuned: Option<f64>, leave_one_out: Option<f64>) -> &mut Row {
        (self.untuned, self.leave_one_out) = (untuned, leave_one_out);
        self
    }

    fn measured(&mut self, value: f64) -> &mut Row {
        self.measured = Some(value);
        self
    }

    /// Enters the numbers of the note, one for each `{}`.
    fn fill<const N: usize>(&mut self, numbers: [String; N]) -> &mut Row {
        debug_assert_eq!(self.note.matches("{}").count(), N, "{}", self.id);
        self.note = numbers.iter().fold(self.note.clone(), |note, number| note.replacen("{}", number, 1));
        self
    }
}

/// The rows of a table by id, which is their order.
struct Rows(BTreeMap<String, Row>);

impl Rows {
    /// The rows of a text of this crate in TOML.
    fn read(text: &str) -> Rows {
        let mut rows: BTreeMap<String, Row> = toml::from_str(text).expect("the tests read every table");
        rows.iter_mut().for_each(|(id, row)| row.id.clone_from(id));
        Rows(rows)
    }

    /// The row of an id that the text has.
    fn of(&mut self, id: &str) -> &mut Row {
        self.0.get_mut(id).unwrap_or_else(|| panic!("there is no row {id}"))
    }

    fn add(&mut self, row: Row) -> &mut Row {
        self.0.entry(row.id.clone()).or_insert(row)
    }

    /// All rows, in the order of the audit.
    fn all(self) -> Vec<Row> {
        self.0.into_values().collect()
    }
}

/// Four significant digits.
pub fn significant(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = (3.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
#[track_caller]
fn near(value: f64, expected: f64, by: f64) {
    assert!((value - expected).abs() <= by, "{value} instead of {expected}");
}
