//! Result of a search, before the final estimates.

use crate::hypothesis::Hypothesis;
use crate::levels::DECISIVE;
use crate::linearization::Linearization;
use crate::outcome::{Evidence, Follows, Found, Localised, Unexplained, Verdict};
use crate::search::Scored;
use physics::terms::Port;
use std::time::Duration;

/// The verdict on the effects that were added: what explains most decides it, for less is also left where the model has a structure error.
/// And the law that explains most, unless a listed effect stands beside it and it is a mass, which is a detail of the network.
pub(super) fn verdict_on(effects: &[Found]) -> (Verdict, Option<usize>) {
    let explains = |found: &Found| found.delta_bic_whitened;
    let is_mass = |found: &Found| matches!(found.follows, Follows::Mass(_));
    let listed = effects.iter().filter(|found| found.term.is_none());
    let named = listed.map(explains).max_by(f64::total_cmp);
    let laws =
        effects.iter().enumerate().filter(|(_, f)| f.term.is_some() && !(named.is_some() && is_mass(f)));
    let law = laws.max_by(|a, b| explains(a.1).total_cmp(&explains(b.1)));
    let is_law_first = law.is_some_and(|(_, law)| named.is_none_or(|named| named <= explains(law)));
    let verdict = match effects {
        [] => Verdict::Nothing,
        _ if is_law_first => Verdict::Unexplained,
        _ if effects.iter().any(|found| !found.alternatives.is_empty()) => Verdict::Class,
        _ => Verdict::Named,
    };
    (verdict, law.map(|(k, _)| k))
}

/// What is left, as it was scored; no law was added for it.
pub(super) fn unexplained(scored: &Scored) -> Unexplained {
    Unexplained { port: scored.port, follows: scored.follows, shape: scored.shape.clone(), added: false }
}

/// Result of a search.
pub struct Judgement<'a> {
    /// The verdict.
    pub verdict: Verdict,
    /// The model, linearised; `None` if it is the naive fit.
    pub point: Option<Linearization<'a>>,
    /// The model with the runs in which each addition is active, including held-out runs.
    pub hypothesis: Hypothesis,
    /// If the model was finally estimated from fit and validation runs together: that of the fit runs alone.
    pub of_fit_runs: Option<Hypothesis>,
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
    /// Whether the time budget ended the search.
    pub is_cut: bool,
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
            is_cut: false,
            point: None,
            of_fit_runs: None,
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

#[cfg(test)]
mod tests {
    use super::*;
    use physics::terms::{Driver, GenericTerm, Law, Product};

    fn found(term: Option<Follows>, delta_bic_whitened: f64) -> Found {
        let port = Port::WindingHeat;
        let law = || GenericTerm::new(port, Law::Product(Product { coefficient: 1.0, factors: [None; 3] }));
        Found {
            id: String::new(),
            port,
            follows: term.unwrap_or(Follows::Nothing),
            alternatives: Vec::new(),
            weights: Vec::new(),
            runs: Vec::new(),
            everywhere: true,
            parameters: Vec::new(),
            term: term.map(|_| law()),
            separating_experiment: None,
            delta_bic: 0.0,
            delta_bic_whitened,
            delta_validation: None,
            validation_ratio: None,
            magnitude: String::new(),
        }
    }

    /// What explains most decides the verdict, in any order; a law that explains less is reported.
    #[test]
    fn what_explains_most_decides_the_verdict() {
        let law = |sure| found(Some(Follows::Driver(Driver::Speed)), sure);
        let listed = |sure| found(None, sure);
        let class = |sure| Found { alternatives: vec!["windage".to_string()], ..listed(sure) };
        assert_eq!(verdict_on(&[]), (Verdict::Nothing, None));
        assert_eq!(verdict_on(&[listed(200.0)]), (Verdict::Named, None));
        assert_eq!(verdict_on(&[law(150.0), listed(500.0)]), (Verdict::Named, Some(0)));
        assert_eq!(verdict_on(&[listed(120.0), class(500.0), law(150.0)]), (Verdict::Class, Some(2)));
        assert_eq!(verdict_on(&[listed(500.0), law(501.0)]), (Verdict::Unexplained, Some(1)));
        assert_eq!(verdict_on(&[law(300.0), law(700.0), listed(400.0)]), (Verdict::Unexplained, Some(1)));
        assert_eq!(verdict_on(&[law(300.0)]), (Verdict::Unexplained, Some(0)));
    }

    /// Beside a listed effect a mass is a detail of the network; alone it is an effect without a name.
    #[test]
    fn a_mass_beside_a_listed_effect_is_no_second_one() {
        let mass = || found(Some(Follows::Mass(Driver::HousingTemperature)), 900.0);
        assert_eq!(verdict_on(&[mass(), found(None, 200.0)]), (Verdict::Named, None));
        assert_eq!(verdict_on(&[mass()]), (Verdict::Unexplained, Some(0)));
    }
}
