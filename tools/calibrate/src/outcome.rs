//! Result of a close-loop run as data: everything that a report contains.

use crate::CalibrateError;
use crate::experiment::Role;
use crate::intake::Mistake;
use crate::levels::NEARLY;
use physics::terms::{GenericTerm, Port};

/// Error over noise up to which a model explains the data. Definition: of that statement.
const EXPLAINED: f64 = 2.0;

/// Reason why the data cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Unusable {
    /// The faulty column.
    pub channel: String,
    /// Description of the fault, in one sentence with the file.
    pub reason: String,
    /// Suggested correction.
    pub suggestion: String,
    /// The mistake in the columns that would explain it, for the figure of the corrected readings.
    pub(crate) mistake: Option<Box<Mistake>>,
}

impl Unusable {
    /// A fault that is no [`Mistake`].
    pub fn new(channel: &str, reason: impl Into<String>, suggestion: impl Into<String>) -> Unusable {
        let (reason, suggestion) = (reason.into(), suggestion.into());
        Unusable { channel: channel.to_string(), reason, suggestion, mistake: None }
    }
}

/// Reason why an experiment is rejected.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The data contradict the model, or too many sensors are set aside.
    Unusable(Unusable),
    /// The input is incomplete.
    Input(CalibrateError),
}

impl From<CalibrateError> for Refusal {
    fn from(error: CalibrateError) -> Refusal {
        Refusal::Input(error)
    }
}

/// Conclusion about the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// One to three listed effects explain the data; no other effect explains it as well.
    Named,
    /// Two or three effects that this data cannot distinguish.
    Class,
    /// A dependence on a driver at a port that matches no listed effect.
    Unexplained,
    /// The model with refitted parameters explains the data to within noise.
    Nothing,
    /// Only parameters were fitted; no search for effects was made.
    Fitted,
}

impl Verdict {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Named => "named",
            Verdict::Class => "class",
            Verdict::Unexplained => "unexplained",
            Verdict::Nothing => "nothing",
            Verdict::Fitted => "fitted",
        }
    }
}

/// Estimated value with its interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Full name of the parameter; for a number of a term its symbol (`exponent`, `coefficient`).
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: (f64, f64),
    /// Value before the fit: the preset's; 0 for an effect.
    pub prior: f64,
    /// Its unit.
    pub unit: &'static str,
}

pub use physics::effects::Follows;

/// Effect of the list, or unlisted term, that was added to the model.
#[derive(Clone, Debug)]
pub struct Found {
    /// Id of the effect; `generic_term` for a term of no list.
    pub id: String,
    /// Port at which it acts.
    pub port: Port,
    /// Driver on which it depends.
    pub follows: Follows,
    /// Ids of effects that explain the data equally well.
    pub alternatives: Vec<String>,
    /// Posterior weights of it and its alternatives, in this order; their sum is 1.
    pub weights: Vec<f64>,
    /// Files of the runs in which it acts.
    pub runs: Vec<String>,
    /// Whether it acts in every run.
    pub everywhere: bool,
    /// Its parameters; those of an effect by symbol (`k`), not by full name.
    pub parameters: Vec<Estimate>,
    /// The law as data, for an unlisted term.
    pub term: Option<GenericTerm>,
    /// Further run that would distinguish it from its alternatives, with the predictions of each.
    pub separating_experiment: Option<String>,
    /// Reduction of BIC by it over fit and validation runs, for white noise.
    pub delta_bic: f64,
    /// Reduction of BIC by it over fit and validation runs, allowing for autocorrelated noise.
    pub delta_bic_whitened: f64,
    /// The part of `delta_bic_whitened` beyond the fit runs: by how much -2 ln p of the validation runs falls. `None` without validation
    /// runs.
    pub delta_validation: Option<f64>,
    /// Ratio of validation error with it to validation error without it; `None` without validation runs.
    pub validation_ratio: Option<f64>,
    /// Greatest power (or quantity of the port) that it contributes in the runs, with unit, and the range of its driver.
    pub magnitude: String,
}

/// Structured residual at a port that no effect explains.
#[derive(Clone, Debug)]
pub struct Unexplained {
    /// Port.
    pub port: Port,
    /// Driver on which it depends.
    pub follows: Follows,
    /// Its shape over the driver: driver, value, standard deviation, in SI units.
    pub shape: Vec<(f64, f64, f64)>,
    /// Whether it was added to the model, because it reduces the validation error.
    pub added: bool,
}

/// Root mean square error of one output in one role, in the channel's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelError {
    /// The role.
    pub role: Role,
    /// The column.
    pub column: &'static str,
    /// Error of the unmodified preset.
    pub before: f64,
    /// Error of the parameter fit without added effects.
    pub refit: f64,
    /// Error of the repaired model.
    pub after: f64,
    /// Error due to noise alone: that of a perfect model.
    pub floor: f64,
    /// Error of good instruments.
    pub instruments: f64,
    /// Error of the black box of this channel; `None` if the time budget did not allow one.
    pub blackbox: Option<f64>,
    /// 95 % prediction interval of the repaired model.
    pub prediction: Prediction,
}

impl ChannelError {
    /// Ratio of the final error to the noise, if it is above [`EXPLAINED`] and the error is above that of good instruments.
    pub fn unexplained(&self) -> Option<f64> {
        let ratio = self.after / self.floor;
        (self.floor > 0.0 && self.after > self.instruments && ratio > EXPLAINED).then_some(ratio)
    }
}

/// 95 % prediction intervals of one output over the readings of one role.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Root mean square of the half widths, in the channel's unit.
    pub half_width: f64,
    /// Fraction of the readings inside the interval.
    pub inside: f64,
}

/// Black-box model of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct BlackBox {
    /// The column.
    pub column: &'static str,
    /// Description of its structure.
    pub kind: String,
    /// Its errors (RMSE) in SI units, by role; roles without readings are left out.
    pub errors: Vec<(Role, f64)>,
}

/// Candidate that was tested, with the result of the test.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Round of the stepwise selection: 1 for the first effect.
    pub round: usize,
    /// Id of the effect, or port, driver and shape.
    pub name: String,
    /// Port at which it acts.
    pub port: Port,
    /// Reduction of BIC by it over fit and validation runs, for white noise.
    pub delta_bic: f64,
    /// Reduction of BIC by it over fit and validation runs, allowing for autocorrelated noise.
    pub delta_bic_whitened: f64,
    /// The part of `delta_bic_whitened` beyond the fit runs: by how much -2 ln p of the validation runs falls. `None` without validation
    /// runs.
    pub delta_validation: Option<f64>,
    /// Posterior probability of it among the candidates of its round and the model without any, 0 to 1.
    pub probability: f64,
    /// Ratio of validation error with it to validation error without it.
    pub validation_ratio: Option<f64>,
    /// Whether it was accepted.
    pub accepted: bool,
    /// Reason, in one sentence.
    pub reason: String,
}

impl Found {
    /// It and its alternatives, with their posterior weights.
    pub fn class(&self) -> impl Iterator<Item = (&str, f64)> {
        let ids = std::iter::once(&self.id).chain(&self.alternatives).map(String::as_str);
        ids.zip(self.weights.iter().copied())
    }
}

/// Fraction of the residual that a latent input at a port explains.
#[derive(Clone, Debug)]
pub struct Localised {
    /// The port.
    pub port: Port,
    /// Fraction of the residual's mean square in excess of noise, 0 to 1.
    pub share: f64,
    /// Driver with which the latent input correlates best.
    pub follows: Follows,
}

/// Test for white residuals of one output.
#[derive(Clone, Debug)]
pub struct Whiteness {
    /// The column.
    pub column: &'static str,
    /// Mean square of block means divided by its value for white noise; fit without added effects. 1 if the residual is white.
    pub blocks_refit: f64,
    /// The same ratio for the repaired model.
    pub blocks_after: f64,
    /// Autocorrelation at lag one row: fit without added effects, repaired model.
    pub autocorrelation: (f64, f64),
}

/// Detection limit: smallest size of an effect that this data would have revealed.
#[derive(Clone, Debug)]
pub struct Limit {
    /// Id of the effect.
    pub id: String,
    /// Symbol of its size.
    pub symbol: &'static str,
    /// The size.
    pub size: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// One run with readings and predictions of the models, thinned for plots. Temperatures in degC.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Place of its run in the experiment. A run that ends at a gap and the one that begins after it have one file, role and window.
    pub run: usize,
    /// Its file.
    pub file: String,
    /// Its role.
    pub role: Role,
    /// Evaluated time window: from and to, s.
    pub window: Option<(f64, f64)>,
    /// Times, s.
    pub time: Vec<f64>,
    /// One curve for each output.
    pub outputs: Vec<Curve>,
}

/// One output of one run. NaN where there is no reading.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The column.
    pub column: &'static str,
    /// Readings.
    pub measured: Vec<f64>,
    /// Prediction of the unmodified preset.
    pub before: Vec<f64>,
    /// Prediction of the fit without added effects.
    pub refit: Vec<f64>,
    /// Prediction of the repaired model.
    pub after: Vec<f64>,
    /// Half width of the repaired model's 95 % prediction interval.
    pub half_width: Vec<f64>,
}

/// Settings of the model for one run.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The run's file.
    pub file: String,
    /// Its role.
    pub role: Role,
    /// All values that differ from the model's start values: full name and number. Includes measured initial temperatures.
    pub values: Vec<(String, f64)>,
    /// Added terms.
    pub terms: Vec<GenericTerm>,
}

/// Result of a close-loop run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The experiment's name.
    pub name: String,
    /// The model's name.
    pub model: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// Effects found, strongest first.
    pub effects: Vec<Found>,
    /// Structured residual that no effect explains.
    pub unexplained: Option<Unexplained>,
    /// Declared parameters of the repaired model.
    pub parameters: Vec<Estimate>,
    /// Those of them that have no prior in the experiment.
    pub released: Vec<String>,
    /// Declared parameters of the fit without added effects.
    pub refit: Vec<Estimate>,
    /// Unknowns of single runs, with the file.
    pub of_runs: Vec<(String, Estimate)>,
    /// Pairs of declared parameters with highly correlated estimates, with their correlation.
    pub correlated: Vec<(String, String, f64)>,
    /// Errors by role and output.
    pub errors: Vec<ChannelError>,
    /// Fraction of the residual explained at each port.
    pub localised: Vec<Localised>,
    /// Tested candidates, in order.
    pub candidate_table: Vec<Evidence>,
    /// Tests for white residuals.
    pub whiteness: Vec<Whiteness>,
    /// Detection limits.
    pub limits: Vec<Limit>,
    /// Runs for plots.
    pub curves: Vec<Curves>,
    /// The repaired model, run by run, in the experiment's order.
    pub settings: Vec<Setting>,
    /// The repaired model for export: settings of the test runs, otherwise those of the last run.
    pub export: Setting,
    /// Warnings and remarks.
    pub notes: Vec<String>,
    /// Runs in which the repaired model reaches a limit of validity, with the reason.
    pub endings: Vec<String>,
    /// Whether the time budget ended the search.
    pub is_cut: bool,
    /// The file that was left out, because it disagrees with the others and no effect describes it.
    pub left_out: Option<String>,
    /// Black-box models for comparison.
    pub boxes: Vec<BlackBox>,
    /// Wall time, s.
    pub seconds: f64,
}

impl Outcome {
    /// The ports at which a latent input explains nearly as much of the residual as at this one, or more.
    pub fn ports_like(&self, port: Port) -> impl Iterator<Item = Port> {
        let own = self.localised.iter().find(|one| one.port == port).map_or(f64::INFINITY, |one| one.share);
        let is_near = move |one: &&Localised| one.port != port && one.share >= NEARLY * own;
        self.localised.iter().filter(is_near).map(|one| one.port)
    }

    /// Misfit in the fit and validation runs: sum of the log error variances of the outputs (normal density at the best variance).
    pub fn misfit(&self) -> f64 {
        let mut squares: Vec<(&str, f64)> = Vec::new();
        for error in self.errors.iter().filter(|e| e.role != Role::Test && e.after.is_finite()) {
            let square = error.after.powi(2).max(error.floor.powi(2));
            match squares.iter_mut().find(|(column, _)| *column == error.column) {
                Some((_, sum)) => *sum += square,
                None => squares.push((error.column, square)),
            }
        }
        squares.iter().map(|(_, sum)| sum.ln()).sum()
    }

    /// The greatest error of the final model relative to the noise in the runs of a role, with that ratio, if it is above [`EXPLAINED`] and
    /// above the error of good instruments.
    pub fn unexplained_error(&self, role: Role) -> Option<(&ChannelError, f64)> {
        let of = self.errors.iter().filter(|e| e.role == role);
        let ratios = of.filter_map(|e| Some((e, e.unexplained()?)));
        ratios.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The role whose runs show what the model is worth: those that were not fitted, if there are any.
    pub fn unfitted(&self) -> Role {
        let has = |role: &Role| self.errors.iter().any(|e| e.role == *role && e.floor > 0.0);
        [Role::Test, Role::Validate].into_iter().find(has).unwrap_or(Role::Fit)
    }

    /// The error that the final model leaves, with its ratio to the noise; `None` if the model explains the data. Where an effect was found,
    /// first the fit runs count, then all others; otherwise those that show what the model is worth.
    pub fn remaining_error(&self) -> Option<(&ChannelError, f64)> {
        if matches!(self.verdict, Verdict::Nothing | Verdict::Fitted) {
            return self.unexplained_error(self.unfitted());
        }
        let others = || {
            let all =
                [Role::Validate, Role::Test].into_iter().filter_map(|role| self.unexplained_error(role));
            all.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        self.unexplained_error(Role::Fit).or_else(others)
    }

    /// Parameters without prior whose 95 % intervals contain the values of the preset, if effects were found.
    pub fn stood_in(&self) -> Vec<String> {
        let keeps = |p: &&Estimate| p.ci95.0 <= p.prior && p.prior <= p.ci95.1;
        let own = self.parameters.iter().filter(|p| self.released.contains(&p.name)).filter(keeps);
        own.filter(|_| !self.effects.is_empty()).map(|p| p.name.clone()).collect()
    }
}
