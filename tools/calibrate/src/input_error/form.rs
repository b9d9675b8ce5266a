//! The forms that the error of an instrument takes: functions b of the reading and of the time.
//!
//! | form | b |
//! |---|---|
//! | zero | 1 |
//! | gain | u |
//! | curve | hat functions of the reading u: the end of a range, a dead band, counts that are lost, a wrong table |
//! | warming | hat functions of the time since the start of the run |
//! | gain that drifts | u times the same |
//! | course | hat functions of the time in each run: an ambient temperature that was typed in, or read once in an hour |
//!
//! The values of hat functions have the covariance of a law ([`crate::search`]).

use crate::comparison::{converted, digits};
use crate::experiment::Channel;
use crate::hypothesis::hat;
use crate::search::{alike, spread};
use crate::simulate::Drive;
use nalgebra::DMatrix;
use physics::declare::Unit;

/// Knots over the readings. Numerical: as for a law over one driver.
const KNOTS: usize = 13;
/// Knots over the time. Numerical: an instrument warms up once.
const TIMES: usize = 5;
/// Numbers of a function with hat functions for each of its knots, as in the penalty of a table. Derivation: values of neighbouring knots
/// are correlated.
const POINT: f64 = 0.5;

/// A form with its knots.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// The zero is off.
    Zero,
    /// The gain is off.
    Gain,
    /// The reading errs by a function of itself.
    Curve(Vec<f64>),
    /// The zero drifts.
    ZeroDrift(Vec<f64>),
    /// The gain drifts.
    GainDrift(Vec<f64>),
    /// Nobody measured the course of the quantity in these runs.
    Course {
        /// Times since the start of a run, s.
        knots: Vec<f64>,
        /// The runs.
        runs: Vec<usize>,
    },
}

/// What may be wrong with an instrument whose readings in these runs are `input` of the drives: a command has no sensor, and a gain of the
/// power is the loss of a drive. The sensor of a temperature has effects of the list; a temperature that changes less often than the knots
/// of a course was not recorded.
pub fn forms(channel: &Channel, drives: &[Drive], input: usize, runs: &[usize]) -> Vec<Form> {
    let columns = || runs.iter().map(|run| &drives[*run].inputs()[input]);
    let times = runs.iter().flat_map(|run| drives[*run].time.iter().map(|t| t - drives[*run].time[0]));
    let times = spread(times.collect(), TIMES, None);
    if channel.is_temperature() {
        let changes = |column: &Vec<f64>| column.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let is_recorded = columns().any(|column| changes(column) >= TIMES);
        let course = times.filter(|_| !is_recorded).map(|knots| Form::Course { knots, runs: runs.to_vec() });
        return course.into_iter().collect();
    }
    if channel.unit == Unit::One {
        return Vec::new();
    }
    let readings = columns().flatten().copied();
    let mut all = vec![Form::Zero];
    all.extend(times.clone().map(Form::ZeroDrift));
    if channel.unit != Unit::Watt {
        all.push(Form::Gain);
        all.extend(spread(readings.collect(), KNOTS, None).map(Form::Curve));
        all.extend(times.map(Form::GainDrift));
    }
    all
}

impl Form {
    fn knots(&self) -> &[f64] {
        match self {
            Form::Zero | Form::Gain => &[],
            Form::Curve(knots)
            | Form::ZeroDrift(knots)
            | Form::GainDrift(knots)
            | Form::Course { knots, .. } => knots,
        }
    }

    /// Place of its kind, those with one number first.
    pub fn kind(&self) -> usize {
        match self {
            Form::Zero => 0,
            Form::Gain => 1,
            Form::Curve(_) => 2,
            Form::ZeroDrift(_) => 3,
            Form::GainDrift(_) => 4,
            Form::Course { .. } => 5,
        }
    }

    /// Whether it is a course in each run.
    pub fn is_course(&self) -> bool {
        matches!(self, Form::Course { .. })
    }

    /// Number of functions b.
    pub fn count(&self) -> usize {
        let runs = if let Form::Course { runs, .. } = self { runs.len() } else { 1 };
        runs * self.knots().len().max(1)
    }

    /// The `k`-th function b in a run at a reading and a time since its start.
    pub fn weight(&self, k: usize, run: usize, reading: f64, time: f64) -> f64 {
        match self {
            Form::Zero => 1.0,
            Form::Gain => reading,
            Form::Curve(knots) => hat(knots, k, reading),
            Form::ZeroDrift(knots) => hat(knots, k, time),
            Form::GainDrift(knots) => reading * hat(knots, k, time),
            Form::Course { knots, runs } if runs[k / knots.len()] == run => hat(knots, k % knots.len(), time),
            Form::Course { .. } => 0.0,
        }
    }

    /// Covariance of the sizes; `None` for a single one.
    pub fn kernel(&self) -> Option<DMatrix<f64>> {
        let runs = self.count() / self.knots().len().max(1);
        let each = DMatrix::identity(runs, runs);
        (!self.knots().is_empty()).then(|| each.kronecker(&alike(self.knots())))
    }

    /// Numbers in the complexity penalty.
    pub fn price(&self) -> f64 {
        if self.knots().is_empty() { 1.0 } else { 1.0 + POINT * self.count() as f64 }
    }

    /// What has to be done to the readings of a channel, and what to check.
    pub fn words(&self, channel: &Channel, sizes: &[f64]) -> (String, String) {
        let (column, unit) = (channel.column, channel.unit.name());
        let at = |of: &dyn Fn(f64) -> String, place: &dyn Fn(f64) -> String| {
            let ends = [0, self.knots().len() / 2, self.knots().len() - 1];
            let all: Vec<String> =
                ends.iter().map(|k| format!("{} {}", of(sizes[*k]), place(self.knots()[*k]))).collect();
            all.join(", ")
        };
        let amount = |c: f64| format!("{} {unit}", digits(c));
        let reading = |u: f64| format!("at {} {unit}", digits(u));
        let after = |t: f64| format!("after {t:.0} s");
        match self {
            Form::Zero => (
                format!("{} {unit} is subtracted: the zero of its sensor is off", converted(-sizes[0])),
                format!("check the zero of {column}, and subtract what it reads at rest"),
            ),
            Form::Gain => (
                format!(
                    "it is multiplied by {}: the gain of its instrument is off, or the column is of another quantity",
                    digits(1.0 + sizes[0])
                ),
                format!(
                    "compare {column} with a second instrument (value of the shunt, scaling of the amplifier, amplitude or root mean \
                     square, poles of the motor); [columns] states the unit of a column"
                ),
            ),
            Form::Curve(_) => (
                format!(
                    "a function of the reading is added ({}): its instrument is not linear, as near the end of its range, with a dead band, \
                     with lost counts or with a wrong table",
                    at(&amount, &reading)
                ),
                format!("compare {column} with a second instrument over its whole range"),
            ),
            Form::ZeroDrift(_) => (
                format!(
                    "a function of the time is added ({}): the zero of its sensor drifts",
                    at(&amount, &after)
                ),
                format!("let the instrument of {column} warm up, and check its zero before and after a run"),
            ),
            Form::GainDrift(_) => (
                format!(
                    "it is multiplied by a function of the time ({}): the gain of its instrument drifts",
                    at(&|c| digits(1.0 + c), &after)
                ),
                format!(
                    "let the instrument of {column} warm up, and compare it with a second one before and after a run"
                ),
            ),
            Form::Course { .. } => {
                let most = sizes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
                (
                    format!(
                        "it varies in the course of a run, by up to {} K; it was written down and not recorded",
                        digits(most.abs())
                    ),
                    format!("record {column} during the run"),
                )
            }
        }
    }
}
