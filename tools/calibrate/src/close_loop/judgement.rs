//! Result of a search, before the final estimates.

use crate::hypothesis::Hypothesis;
use crate::levels::DECISIVE;
use crate::linearization::Linearization;
use crate::outcome::{Evidence, Found, Localised, Unexplained, Verdict};
use crate::search::Scored;
use physics::terms::Port;
use std::time::Duration;

/// Result of a search.
pub struct Judgement<'a> {
    /// The verdict.
    pub verdict: Verdict,
    /// The model, linearised; `None` if it is the naive fit.
    pub point: Option<Linearization<'a>>,
    /// The model with the runs in which each addition is active, including held-out runs.
    pub hypothesis: Hypothesis,
    /// Added effects, without the final parameter values.
    pub effects: Vec<Found>,
    /// Residual without an identified law.
    pub unexplained: Option<Unexplained>,
    /// With an unexplained residual: the model whose parameters are estimated jointly with a latent input at its port.
    pub beside: Option<(Linearization<'a>, Port)>,
    /// Ports to which the residual was attributed.
    pub localised: Vec<Localised>,
    /// The candidate table.
    pub candidate_table: Vec<Evidence>,
    /// Warnings.
    pub notes: Vec<String>,
    /// Time for the black boxes.
    pub time_for_boxes: Duration,
}

/// Time for the black boxes: an absolute value without a budget, otherwise a fraction of the budget. Numerical: a limit of effort; a
/// channel without time has no black box.
pub(super) const BOXES: (Duration, f64) = (Duration::from_secs(60), 0.15);

impl Judgement<'_> {
    /// Whether the score of a candidate to first order is contradicted by its fit or by the validation runs.
    pub(super) fn refutes(&self, scored: &Scored) -> bool {
        let is_refuted =
            |e: &Evidence| e.delta_bic.min(e.delta_bic_whitened) <= DECISIVE || e.validation_ratio.is_some();
        self.candidate_table.iter().any(|e| e.name == scored.name && !e.accepted && is_refuted(e))
    }

    /// A verdict on a model without additions.
    pub(super) fn of(verdict: Verdict, point: &Linearization) -> Self {
        Judgement {
            verdict,
            time_for_boxes: BOXES.0,
            point: None,
            hypothesis: point.fitted.hypothesis.clone(),
            effects: Vec::new(),
            unexplained: None,
            beside: None,
            localised: Vec::new(),
            candidate_table: Vec::new(),
            notes: Vec::new(),
        }
    }
}
