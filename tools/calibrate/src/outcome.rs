//! What closing the loop has come to: everything that a report says, as data.

use crate::experiment::Role;
use physics::terms::{GenericTerm, Port};

/// What the data says of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// An effect, or up to three, that no other explains as well.
    Named,
    /// Two or three effects that this data cannot tell apart.
    Class,
    /// Something at a port that follows a driver and is in no list.
    Unexplained,
    /// The model with other parameters explains all that there is.
    Nothing,
    /// Parameters alone were fitted, and nothing was looked for.
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

/// A number with what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Full name of the parameter; of a term's own number, its symbol (`exponent`, `coefficient`).
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: (f64, f64),
    /// The value before: the preset's; 0 for an effect.
    pub prior: f64,
    /// Its unit.
    pub unit: &'static str,
}

pub use physics::effects::Follows;

/// An effect, or a term of no list, that the model was given.
#[derive(Clone, Debug)]
pub struct Found {
    /// Id of the effect; `generic_term` for a term of no list.
    pub id: String,
    /// Where it acts.
    pub port: Port,
    /// What it follows.
    pub follows: Follows,
    /// Ids of effects that explain the data as well.
    pub alternatives: Vec<String>,
    /// Files of the runs in which it acts.
    pub runs: Vec<String>,
    /// Whether it acts in every run.
    pub everywhere: bool,
    /// Its numbers; an effect's own by symbol (`k`), not by full name.
    pub parameters: Vec<Estimate>,
    /// The law as data, where it is in no list.
    pub term: Option<GenericTerm>,
    /// The further run that would tell it from its alternatives, with what each would show.
    pub separating_experiment: Option<String>,
    /// By how much BIC falls with it, noise taken as white.
    pub delta_bic: f64,
    /// The same with the noise's own memory.
    pub delta_bic_whitened: f64,
    /// Error on the validation runs with it over that without; `None` without such runs.
    pub validation_ratio: Option<f64>,
    /// Greatest power or equivalent that it moves in the runs, with its unit, and the range of its driver.
    pub magnitude: String,
}

/// Something at a port that no effect explains.
#[derive(Clone, Debug)]
pub struct Unexplained {
    /// Where.
    pub port: Port,
    /// What it follows.
    pub follows: Follows,
    /// Its shape over the driver: driver, value, standard deviation, in SI units.
    pub shape: Vec<(f64, f64, f64)>,
    /// Whether the model was given it, because that improves what was not fitted.
    pub added: bool,
}

/// Root mean square error of one output in one role, in the channel's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelError {
    /// The role.
    pub role: Role,
    /// The column.
    pub column: &'static str,
    /// Of the untouched preset.
    pub before: f64,
    /// Of the naive fit of parameters.
    pub refit: f64,
    /// Of the repaired model.
    pub after: f64,
    /// Of the noise: what a perfect model would leave.
    pub floor: f64,
    /// Of the black box of this channel, where there was time for one.
    pub blackbox: Option<f64>,
    /// 95 % prediction interval of the repaired model.
    pub prediction: Prediction,
}

/// 95 % prediction intervals of one output over the readings of one role.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Root mean square of half their widths, in the channel's unit.
    pub half_width: f64,
    /// Fraction of the readings inside.
    pub inside: f64,
}

/// The black box of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct BlackBox {
    /// The column.
    pub column: &'static str,
    /// What it is, in words.
    pub kind: String,
    /// Its errors (RMSE) in SI units, by role; none of a role without readings.
    pub errors: Vec<(Role, f64)>,
}

/// A candidate that was looked at, and what became of it.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Round: 1 for the first effect that is looked for.
    pub round: usize,
    /// Id of the effect, or port, driver and shape.
    pub name: String,
    /// Where it acts.
    pub port: Port,
    /// By how much BIC falls, noise taken as white.
    pub delta_bic: f64,
    /// The same with the noise's own memory.
    pub delta_bic_whitened: f64,
    /// Error on the validation runs with it over that without.
    pub validation_ratio: Option<f64>,
    /// Whether it was taken.
    pub accepted: bool,
    /// Why, in one sentence.
    pub reason: String,
}

/// How much of the residual a free force at a port would explain.
#[derive(Clone, Debug)]
pub struct Localised {
    /// The port.
    pub port: Port,
    /// The share of the residual's excess over noise, 0 to 1.
    pub share: f64,
    /// The driver that the force follows best.
    pub follows: Follows,
}

/// Whether what a model leaves is noise, for one output.
#[derive(Clone, Debug)]
pub struct Whiteness {
    /// The column.
    pub column: &'static str,
    /// Mean square of block means over what noise alone gives: 1 where the residual is white.
    pub blocks_refit: f64,
    /// The same of the repaired model.
    pub blocks_after: f64,
    /// Correlation of neighbouring rows, refit and repaired.
    pub autocorrelation: (f64, f64),
}

/// The smallest size of an effect that this data would have shown.
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

/// One run with what was measured and what the models say, thinned for plots. Temperatures in degC.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Its file.
    pub file: String,
    /// Its role.
    pub role: Role,
    /// The rows that count: from and to, s.
    pub window: Option<(f64, f64)>,
    /// Times, s.
    pub time: Vec<f64>,
    /// One for each output.
    pub outputs: Vec<Curve>,
}

/// One output of one run. NaN where nothing was measured.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The column.
    pub column: &'static str,
    /// As measured.
    pub measured: Vec<f64>,
    /// By the untouched preset.
    pub before: Vec<f64>,
    /// By the naive fit.
    pub refit: Vec<f64>,
    /// By the repaired model.
    pub after: Vec<f64>,
    /// Half the width of its 95 % prediction interval.
    pub half_width: Vec<f64>,
}

/// The model as it must be set for one run.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The run's file.
    pub file: String,
    /// Its role.
    pub role: Role,
    /// Every value that differs from the model's own start values: full name and number. Initial temperatures that were measured are
    /// among them.
    pub values: Vec<(String, f64)>,
    /// Terms.
    pub terms: Vec<GenericTerm>,
}

/// What closing the loop has come to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The experiment's name.
    pub name: String,
    /// The model's name.
    pub model: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// What was found, strongest first.
    pub effects: Vec<Found>,
    /// What has no name.
    pub unexplained: Option<Unexplained>,
    /// Declared parameters of the repaired model.
    pub parameters: Vec<Estimate>,
    /// Declared parameters of the naive fit.
    pub refit: Vec<Estimate>,
    /// The unknowns of single runs, with the file.
    pub of_runs: Vec<(String, Estimate)>,
    /// Pairs of declared parameters that the data hardly separates, with their correlation.
    pub correlated: Vec<(String, String, f64)>,
    /// Errors by role and output.
    pub errors: Vec<ChannelError>,
    /// Where the residual sits.
    pub localised: Vec<Localised>,
    /// What was tried, in order.
    pub candidate_table: Vec<Evidence>,
    /// Whether what is left is noise.
    pub whiteness: Vec<Whiteness>,
    /// What would have been seen.
    pub limits: Vec<Limit>,
    /// Runs for plots.
    pub curves: Vec<Curves>,
    /// The repaired model, run by run, in the experiment's order.
    pub settings: Vec<Setting>,
    /// The repaired model as it goes into the archives: as in the test runs, else as in the last run.
    pub export: Setting,
    /// What is odd but no error.
    pub notes: Vec<String>,
    /// Runs in which the repaired model reaches a limit of validity, and why.
    pub endings: Vec<String>,
    /// Whether the time budget ended the search.
    pub is_cut: bool,
    /// The black boxes beside it.
    pub boxes: Vec<BlackBox>,
    /// Wall time, s.
    pub seconds: f64,
}
