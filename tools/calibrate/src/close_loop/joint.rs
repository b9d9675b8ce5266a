//! Final estimate of a model with laws.
//!
//! Fit runs find a law, validation runs select it. Test runs, which take no part in either, show how well the result predicts: if there are
//! any, the selected model is estimated once more from fit and validation runs together, and so is the plain fit that it is compared with.
//! A law then covers all that these runs reach, beyond which it is constant.
//! *Source*: Hastie, Tibshirani, Friedman, The Elements of Statistical Learning (2009), sec. 7.2 and 7.10.1: the selected model is fitted to
//! all data but those of the test.

use super::Search;
use super::refine::{reached, tabulated};
use crate::CalibrateError;
use crate::acting::acting;
use crate::experiment::Role;
use crate::hypothesis::{Hypothesis, Shape};
use crate::linearization::Linearization;
use crate::numbers::ends;

/// Models that are estimated from fit and validation runs together.
pub(super) struct Joint<'a> {
    /// The plain fit.
    pub first: Linearization<'a>,
    /// The selected model.
    pub point: Linearization<'a>,
    /// The selected model, estimated from the fit runs alone.
    pub of_fit_runs: Hypothesis,
}

impl<'a> Search<'a> {
    /// The final estimates; `None` without a law, without validation or test runs, and if they do not describe these runs better.
    pub(super) fn joint(&self) -> Result<Option<Joint<'a>>, CalibrateError> {
        let setup = self.setup;
        let [validation, test] = [Role::Validate, Role::Test].map(|role| setup.runs(role));
        if !self.has_law() || validation.is_empty() || test.is_empty() || setup.deadline().is_near() {
            return Ok(None);
        }
        let runs = [self.first.runs.clone(), validation].concat();
        let of_fit_runs = acting(setup, &self.point().fitted.hypothesis, &runs)?;
        let before = Linearization::judged(setup, setup.judged(of_fit_runs.clone(), &runs)?, &runs)?;
        let start = setup.judged(widened(&before), &runs)?;
        let mut point = Linearization::judged(setup, setup.fit(start.hypothesis, &runs)?, &runs)?;
        for k in 0..of_fit_runs.additions.len() {
            if setup.deadline().is_near() {
                return Ok(None);
            }
            if let Some(hypothesis) = tabulated(&point, k)? {
                let fitted = setup.fit(hypothesis, &runs)?;
                if fitted.chi_square < point.fitted.chi_square {
                    point = Linearization::judged(setup, fitted, &runs)?;
                }
            }
        }
        if point.fitted.chi_square >= before.fitted.chi_square {
            return Ok(None);
        }
        let plain = setup.fit(self.first.fitted.hypothesis.clone(), &runs)?;
        Ok(Some(Joint { first: Linearization::judged(setup, plain, &runs)?, point, of_fit_runs }))
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
