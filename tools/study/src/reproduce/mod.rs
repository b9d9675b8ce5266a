//! The two published systems, number by number: published, recomputed as published, corrected, measured.

pub mod paper;
pub mod report;
pub mod thesis;

use serde::Serialize;

/// Assessment of a published number in the audit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It follows from what is published.
    Holds,
    /// It follows, with the restriction in the note.
    HoldsWithNote,
    /// It does not follow from what is published.
    Inconsistent,
    /// The equation or the reference is damaged.
    Garbled,
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
    /// All verdicts.
    pub const ALL: [Verdict; 9] = [
        Verdict::Holds,
        Verdict::HoldsWithNote,
        Verdict::Inconsistent,
        Verdict::Garbled,
        Verdict::UnitError,
        Verdict::SignError,
        Verdict::PhysicsError,
        Verdict::NotAValidation,
        Verdict::Remark,
    ];

    /// As words in a table.
    pub fn text(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::HoldsWithNote => "holds, see note",
            Verdict::Inconsistent => "inconsistent",
            Verdict::Garbled => "garbled",
            Verdict::UnitError => "unit error",
            Verdict::SignError => "sign error",
            Verdict::PhysicsError => "physics error",
            Verdict::NotAValidation => "not a validation",
            Verdict::Remark => "remark",
        }
    }
}

/// Origin of a native model's value: prediction or fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Printed {
    /// A number in the row's unit.
    Number(f64),
    /// Words.
    Text(&'static str),
}

impl From<f64> for Printed {
    fn from(number: f64) -> Printed {
        Printed::Number(number)
    }
}

impl From<&'static str> for Printed {
    fn from(text: &'static str) -> Printed {
        Printed::Text(text)
    }
}

/// A published number or statement, recomputed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Number in the audit, with a suffix where it has several.
    pub id: &'static str,
    /// Where it is published.
    pub location: &'static str,
    /// What it is.
    pub quantity: String,
    /// The published value.
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
    pub unit: &'static str,
    /// Verdict.
    pub verdict: Verdict,
    /// Why.
    pub note: String,
}

impl Row {
    /// A row without a recomputed value; its verdict is `Holds`.
    pub fn new(
        id: &'static str,
        location: &'static str,
        quantity: impl Into<String>,
        printed: impl Into<Printed>,
        unit: &'static str,
    ) -> Row {
        Row {
            id,
            location,
            quantity: quantity.into(),
            printed: printed.into(),
            as_published: None,
            corrected: None,
            basis: None,
            untuned: None,
            leave_one_out: None,
            measured: None,
            unit,
            verdict: Verdict::Holds,
            note: String::new(),
        }
    }

    /// With the value that the published equations give.
    pub fn published(mut self, value: f64) -> Row {
        self.as_published = Some(value);
        self
    }

    /// With the corrected value.
    pub fn right(mut self, value: impl Into<Option<f64>>) -> Row {
        self.corrected = value.into();
        self
    }

    /// With the origin of the corrected value: fit or prediction.
    pub fn by(mut self, basis: Basis) -> Row {
        self.basis = self.corrected.map(|_| basis);
        self
    }

    /// With the predictions of the untuned model and of the model fitted to the other tests.
    pub fn predictions(mut self, untuned: Option<f64>, leave_one_out: Option<f64>) -> Row {
        (self.untuned, self.leave_one_out) = (untuned, leave_one_out);
        self
    }

    /// With the measured value.
    pub fn measured(mut self, value: f64) -> Row {
        self.measured = Some(value);
        self
    }

    /// With a verdict and its reason.
    pub fn but(mut self, verdict: Verdict, note: impl Into<String>) -> Row {
        self.verdict = verdict;
        self.note = note.into();
        self
    }

    /// With a remark; the verdict does not change.
    pub fn note(mut self, note: impl Into<String>) -> Row {
        self.note = note.into();
        self
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
