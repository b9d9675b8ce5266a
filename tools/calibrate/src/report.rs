//! `report.json`: result of a close-loop run for scripts.
//!
//! The keys `name`, `verdict`, `seconds`, `effects`, `unexplained`, `parameters`, `error` and `fmu` are the contract;
//! the other keys follow the rest of [`Outcome`]. A number that is not finite is null.

mod words;

use crate::experiment::Role;
use crate::intake::Unusable;
use crate::outcome::{self, ChannelError as Error, Estimate, Found, Outcome};
use physics::terms::{Driver, Port};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use terms::TermText;
pub use words::{column_words, count_of, role_name, role_words, words};

/// The roles in the order of the report.
pub const ROLES: [Role; 3] = [Role::Fit, Role::Validate, Role::Test];

/// Unit of a driver; 1 if dimensionless.
pub fn driver_unit(driver: Driver) -> &'static str {
    driver.unit().name()
}

/// Comparison of the exported FMUs with the native model.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Replay {
    /// Greatest difference of an error (RMSE), as a fraction of its channel's range.
    pub greatest_difference: f64,
    /// Greatest difference of a single value, as a fraction of its channel's range.
    pub greatest_difference_of_a_value: f64,
    /// Limit of `greatest_difference`.
    pub limit: f64,
    /// Whether the replayed runs meet the limit.
    pub agrees: bool,
    /// The runs that were replayed.
    pub replayed: Vec<String>,
    /// The role whose runs were replayed.
    pub role: &'static str,
    /// Start values of each run that differ from those of the archives (initial temperatures, `[run.set]`), in SI units.
    pub start_values: BTreeMap<String, BTreeMap<String, f64>>,
    /// Every output in both standards.
    pub channels: Vec<ReplayedChannel>,
}

/// One output of the replay in one standard.
#[derive(Clone, Debug, Serialize)]
pub struct ReplayedChannel {
    /// Folder of the archive, which is the standard's name: `fmi2` or `fmi3`.
    pub standard: &'static str,
    /// The column.
    pub column: &'static str,
    /// Error of the FMU, in the channel's unit.
    pub rmse: f64,
    /// Error of the native model.
    pub after: f64,
    /// Difference of the greatest and the least reading.
    pub range: f64,
    /// Difference of the errors as a fraction of the range.
    pub difference: f64,
    /// Greatest difference of a value as a fraction of the range, if the native values are known.
    pub difference_of_a_value: f64,
}

/// Origin of a report.
#[derive(Clone, Debug, Serialize)]
pub struct Provenance {
    /// Name and version of the program.
    pub program: String,
    /// SHA-256 of the experiment's file followed by the files of its runs.
    pub data_sha256: String,
    /// Date and time in UTC.
    pub date: String,
}

/// Contents of the file.
#[derive(Debug, Serialize)]
pub struct Report<'a> {
    name: &'a str,
    model: &'static str,
    verdict: &'static str,
    #[serde(flatten)]
    provenance: Option<&'a Provenance>,
    seconds: f64,
    seconds_search: f64,
    budget: Budget,
    explains_data: Option<bool>,
    remaining_error: Option<RemainingError>,
    effects: Vec<Effect<'a>>,
    unexplained: Option<Unexplained>,
    unusable: Option<UnusableText<'a>>,
    parameters: InOrder<'a, Parameter>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    run_parameters: BTreeMap<&'a str, BTreeMap<&'a str, Parameter>>,
    error: BTreeMap<&'static str, InOrder<'a, Errors>>,
    prediction: BTreeMap<&'static str, InOrder<'a, Prediction>>,
    blackbox: InOrder<'a, &'a str>,
    fmu: &'a [String],
    replay: Option<&'a Replay>,
    notes: &'a [String],
    refit: InOrder<'a, Parameter>,
    correlated: Vec<Pair<'a>>,
    localised: Vec<Localised>,
    candidate_table: Vec<CandidateRow<'a>>,
    whiteness: InOrder<'a, Whiteness>,
    detection_limits: Vec<Limit<'a>>,
}

/// The time budget.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Budget {
    /// Limit of the wall time, s.
    pub seconds: f64,
    /// Whether it ended the search.
    pub exhausted: bool,
}

/// Largest error of the final model relative to the noise.
#[derive(Debug, Serialize)]
struct RemainingError {
    role: &'static str,
    channel: &'static str,
    error_over_noise: f64,
}

/// Reason why the data are unusable.
#[derive(Debug, Serialize)]
struct UnusableText<'a> {
    channel: &'a str,
    reason: &'a str,
    suggestion: &'a str,
}

/// List of named items that is written as an object, in this order.
#[derive(Debug)]
struct InOrder<'a, T>(Vec<(&'a str, T)>);

impl<T: Serialize> Serialize for InOrder<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

#[derive(Debug, Serialize)]
struct Effect<'a> {
    id: &'a str,
    port: &'static str,
    driver: Option<String>,
    alternatives: &'a [String],
    weights: InOrder<'a, f64>,
    runs: &'a [String],
    everywhere: bool,
    parameters: InOrder<'a, Parameter>,
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<TermText>,
    magnitude: &'a str,
    separating_experiment: Option<&'a str>,
    evidence: Support,
}

#[derive(Debug, Serialize)]
struct Support {
    delta_bic: f64,
    delta_bic_whitened: f64,
    delta_validation: Option<f64>,
    validation_rmse_ratio: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Parameter {
    value: f64,
    ci95: (f64, f64),
    prior: f64,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
struct Unexplained {
    port: &'static str,
    driver: Option<String>,
    added: bool,
    unit: &'static str,
    driver_unit: Option<&'static str>,
    shape: Vec<Linearization>,
}

#[derive(Debug, Serialize)]
struct Linearization {
    driver: f64,
    value: f64,
    deviation: f64,
}

#[derive(Debug, Serialize)]
struct Errors {
    before: f64,
    refit: f64,
    after: f64,
    floor: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    blackbox: Option<f64>,
}

/// 95 % prediction intervals of the repaired model: root mean square of the half widths, and the fraction of readings inside.
#[derive(Debug, Serialize)]
struct Prediction {
    half_width: f64,
    inside: f64,
}

#[derive(Debug, Serialize)]
struct Pair<'a> {
    parameters: (&'a str, &'a str),
    correlation: f64,
}

#[derive(Debug, Serialize)]
struct Localised {
    port: &'static str,
    share: f64,
    driver: Option<String>,
}

#[derive(Debug, Serialize)]
struct CandidateRow<'a> {
    round: usize,
    name: &'a str,
    port: &'static str,
    delta_bic: f64,
    delta_bic_whitened: f64,
    delta_validation: Option<f64>,
    probability: f64,
    validation_rmse_ratio: Option<f64>,
    accepted: bool,
    reason: &'a str,
}

#[derive(Debug, Serialize)]
struct Whiteness {
    blocks_refit: f64,
    blocks_after: f64,
    autocorrelation_refit: f64,
    autocorrelation_after: f64,
}

#[derive(Debug, Serialize)]
struct Limit<'a> {
    id: &'a str,
    symbol: &'static str,
    size: f64,
    unit: &'static str,
}

impl<'a> Report<'a> {
    /// Report of an outcome; `fmu` are the exported archives, relative to the report, `notes` are the outcome's with those added since,
    /// `seconds` is the total wall time.
    pub fn new(
        outcome: &'a Outcome,
        fmu: &'a [String],
        replay: Option<&'a Replay>,
        notes: &'a [String],
        (seconds, budget): (f64, f64),
    ) -> Report<'a> {
        let errors = |role: Role| {
            let of_role = outcome.errors.iter().filter(|e| e.role == role);
            let numbers = of_role.map(|e| {
                let Error { before, refit, after, floor, blackbox, .. } = *e;
                (e.column, Errors { before, refit, after, floor, blackbox })
            });
            (role_name(role), InOrder(numbers.collect()))
        };
        let predictions = |role: Role| {
            let of_role = outcome.errors.iter().filter(|e| e.role == role);
            let numbers = of_role.map(|e| {
                let outcome::Prediction { half_width, inside } = e.prediction;
                (e.column, Prediction { half_width, inside })
            });
            (role_name(role), InOrder(numbers.collect()))
        };
        let mut run_parameters: BTreeMap<&str, BTreeMap<&str, Parameter>> = BTreeMap::new();
        for (file, e) in &outcome.of_runs {
            run_parameters.entry(file).or_default().insert(&e.name, parameter(e));
        }
        Report {
            name: &outcome.name,
            model: outcome.model,
            verdict: outcome.verdict.name(),
            provenance: None,
            seconds,
            seconds_search: outcome.seconds,
            budget: Budget { seconds: budget, exhausted: outcome.is_cut },
            explains_data: (!outcome.errors.is_empty()).then(|| outcome.remaining_error().is_none()),
            remaining_error: outcome.remaining_error().map(|(e, ratio)| RemainingError {
                role: role_name(e.role),
                channel: e.column,
                error_over_noise: ratio,
            }),
            effects: outcome.effects.iter().map(effect).collect(),
            unexplained: outcome.unexplained.as_ref().map(unexplained),
            unusable: None,
            parameters: parameters(&outcome.parameters),
            run_parameters,
            error: ROLES.map(errors).into_iter().collect(),
            prediction: ROLES.map(predictions).into_iter().collect(),
            blackbox: InOrder(outcome.boxes.iter().map(|b| (b.column, b.kind.as_str())).collect()),
            fmu,
            replay,
            notes,
            refit: parameters(&outcome.refit),
            correlated: outcome
                .correlated
                .iter()
                .map(|(a, b, r)| Pair { parameters: (a, b), correlation: *r })
                .collect(),
            localised: outcome
                .localised
                .iter()
                .map(|l| Localised { port: l.port.quantity(), share: l.share, driver: l.follows.name() })
                .collect(),
            candidate_table: outcome.candidate_table.iter().map(candidate_row).collect(),
            whiteness: InOrder(outcome.whiteness.iter().map(whiteness).collect()),
            detection_limits: outcome
                .limits
                .iter()
                .map(|l| Limit { id: &l.id, symbol: l.symbol, size: l.size, unit: l.unit })
                .collect(),
        }
    }
}

impl<'a> Report<'a> {
    /// Adds the origin.
    #[must_use]
    pub fn made_of(self, provenance: &'a Provenance) -> Report<'a> {
        Report { provenance: Some(provenance), ..self }
    }

    /// Report on an experiment with unusable data.
    pub fn unusable(
        (name, model): (&'a str, &'static str),
        why: &'a Unusable,
        notes: &'a [String],
        (seconds, budget): (f64, f64),
    ) -> Report<'a> {
        Report {
            name,
            model,
            verdict: "unusable",
            provenance: None,
            seconds,
            seconds_search: 0.0,
            budget: Budget { seconds: budget, exhausted: false },
            explains_data: None,
            remaining_error: None,
            effects: Vec::new(),
            unexplained: None,
            unusable: Some(UnusableText {
                channel: &why.channel,
                reason: &why.reason,
                suggestion: &why.suggestion,
            }),
            parameters: InOrder(Vec::new()),
            run_parameters: BTreeMap::new(),
            error: ROLES.map(|role| (role_name(role), InOrder(Vec::new()))).into_iter().collect(),
            prediction: ROLES.map(|role| (role_name(role), InOrder(Vec::new()))).into_iter().collect(),
            blackbox: InOrder(Vec::new()),
            fmu: &[],
            replay: None,
            notes,
            refit: InOrder(Vec::new()),
            correlated: Vec::new(),
            localised: Vec::new(),
            candidate_table: Vec::new(),
            whiteness: InOrder(Vec::new()),
            detection_limits: Vec::new(),
        }
    }
}

fn effect(found: &Found) -> Effect<'_> {
    Effect {
        id: &found.id,
        port: found.port.quantity(),
        driver: found.follows.name(),
        alternatives: &found.alternatives,
        weights: InOrder(found.class().collect()),
        runs: &found.runs,
        everywhere: found.everywhere,
        parameters: parameters(&found.parameters),
        law: found.term.as_ref().map(|term| TermText::of("", term)),
        magnitude: &found.magnitude,
        separating_experiment: found.separating_experiment.as_deref(),
        evidence: Support {
            delta_bic: found.delta_bic,
            delta_bic_whitened: found.delta_bic_whitened,
            delta_validation: found.delta_validation,
            validation_rmse_ratio: found.validation_ratio,
        },
    }
}

fn parameters(estimates: &[Estimate]) -> InOrder<'_, Parameter> {
    InOrder(estimates.iter().map(|e| (e.name.as_str(), parameter(e))).collect())
}

fn parameter(e: &Estimate) -> Parameter {
    Parameter { value: e.value, ci95: e.ci95, prior: e.prior, unit: e.unit }
}

/// Unit of a value at a port.
pub fn unit(port: Port) -> &'static str {
    port.unit().name()
}

fn unexplained(found: &outcome::Unexplained) -> Unexplained {
    let point = |(driver, value, deviation): &(f64, f64, f64)| Linearization {
        driver: *driver,
        value: *value,
        deviation: *deviation,
    };
    Unexplained {
        port: found.port.quantity(),
        driver: found.follows.name(),
        added: found.added,
        unit: unit(found.port),
        driver_unit: found.follows.drivers().next().map(driver_unit),
        shape: found.shape.iter().map(point).collect(),
    }
}

fn candidate_row(evidence: &outcome::Evidence) -> CandidateRow<'_> {
    CandidateRow {
        round: evidence.round,
        name: &evidence.name,
        port: evidence.port.quantity(),
        delta_bic: evidence.delta_bic,
        delta_bic_whitened: evidence.delta_bic_whitened,
        delta_validation: evidence.delta_validation,
        probability: evidence.probability,
        validation_rmse_ratio: evidence.validation_ratio,
        accepted: evidence.accepted,
        reason: &evidence.reason,
    }
}

fn whiteness(found: &outcome::Whiteness) -> (&str, Whiteness) {
    let numbers = Whiteness {
        blocks_refit: found.blocks_refit,
        blocks_after: found.blocks_after,
        autocorrelation_refit: found.autocorrelation.0,
        autocorrelation_after: found.autocorrelation.1,
    };
    (found.column, numbers)
}
