//! Final estimate of a model with laws.
//!
//! Fit runs find a law, validation runs select it. The selected model is then estimated once more from both together: a law covers all that
//! these runs reach, beyond which it is constant. What it leaves of the validation runs is not due to its range. Test runs, which take no part
//! in either, show how well it predicts: if there are any, it is the final model.
//! *Source*: Hastie, Tibshirani, Friedman, The Elements of Statistical Learning (2009), sec. 7.2 and 7.10.1: the selected model is fitted to
//! all data but those of the test.

use super::refine::{reached, tabulated};
use super::{Judgement, Search};
use crate::CalibrateError;
use crate::acting::acting;
use crate::experiment::Role;
use crate::hypothesis::{Hypothesis, Shape};
use crate::linearization::Linearization;
use crate::numbers::ends;

/// A model that is estimated from fit and validation runs together.
pub(super) struct Joint<'a> {
    /// The model.
    pub point: Linearization<'a>,
    /// The same, estimated from the fit runs alone.
    of_fit_runs: Hypothesis,
}

impl<'a> Search<'a> {
    /// Estimates the accepted model from fit and validation runs together, if it has a law and then describes them better.
    pub(super) fn join(&mut self) -> Result<(), CalibrateError> {
        let (setup, validation) = (self.setup, self.setup.runs(Role::Validate));
        if !self.has_law() || validation.is_empty() {
            return Ok(());
        }
        let of_fit_runs = acting(setup, &self.point().fitted.hypothesis, &validation)?;
        let runs = [self.first.runs.clone(), validation].concat();
        let before = Linearization::judged(setup, setup.judged(of_fit_runs.clone(), &runs)?, &runs)?;
        let mut point = Linearization::judged(setup, setup.fit(widened(&before), &runs)?, &runs)?;
        for k in 0..of_fit_runs.additions.len() {
            if setup.deadline().is_near() {
                return Ok(());
            }
            if let Some(hypothesis) = tabulated(&point, k)? {
                let fitted = setup.fit(hypothesis, &runs)?;
                if fitted.chi_square < point.fitted.chi_square {
                    point = Linearization::judged(setup, fitted, &runs)?;
                }
            }
        }
        self.joint =
            (point.fitted.chi_square < before.fitted.chi_square).then_some(Joint { point, of_fit_runs });
        Ok(())
    }

    /// The final estimates if there are test runs.
    pub(super) fn conclude(&mut self, judgement: &mut Judgement<'a>) {
        let has_test = !self.setup.runs(Role::Test).is_empty();
        if let Some(Joint { point, of_fit_runs }) = self.joint.take().filter(|_| has_test) {
            judgement.hypothesis = point.fitted.hypothesis.clone();
            (judgement.point, judgement.of_fit_runs) = (Some(point), Some(of_fit_runs));
        }
    }
}

/// The model with the ranges of its powers as far as the runs of the linearization reach.
fn widened(point: &Linearization) -> Hypothesis {
    let mut hypothesis = point.fitted.hypothesis.clone();
    for (k, addition) in hypothesis.additions.iter_mut().enumerate() {
        if let Shape::Power { factor } | Shape::Linear { factor } = &mut addition.shape {
            let (least, most) = ends(reached(point, k, factor.driver).into_iter().flatten());
            factor.range = (factor.range.0.min(least), factor.range.1.max(most));
        }
    }
    hypothesis
}
