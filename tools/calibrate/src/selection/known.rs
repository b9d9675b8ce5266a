//! Fits that were made before: a round that looks again compares candidates beside additions with which they were fitted already.

use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::fit::Fitted;
use crate::hypothesis::{Addition, Hypothesis, Shape};
use std::sync::Mutex;

/// The fits of one search, whose runs, noise and declared parameters do not change.
#[derive(Default)]
pub struct Known(Mutex<Vec<Fitted>>);

impl Known {
    /// The known fit of a model with the additions of `start`, or a new one, which is kept unless the deadline ended it.
    ///
    /// # Errors
    /// That of the new fit.
    pub fn or_fitted(
        &self,
        start: &Hypothesis,
        fit: impl FnOnce() -> Result<Fitted, CalibrateError>,
        deadline: &Deadline,
    ) -> Result<Fitted, CalibrateError> {
        if let Some(fitted) = self.find(start) {
            return Ok(fitted);
        }
        let fitted = fit()?;
        if !deadline.is_near() {
            self.keep(&fitted);
        }
        Ok(fitted)
    }

    /// The fit of a model with the same additions, in the order of `start`.
    fn find(&self, start: &Hypothesis) -> Option<Fitted> {
        let known = self.0.lock().ok()?;
        known.iter().find_map(|fitted| {
            let additions = in_order(&fitted.hypothesis.additions, &start.additions)?;
            let hypothesis = Hypothesis { additions, ..fitted.hypothesis.clone() };
            Some(Fitted { hypothesis, ..fitted.clone() })
        })
    }

    /// Keeps a fit.
    fn keep(&self, fitted: &Fitted) {
        if let Ok(mut known) = self.0.lock() {
            known.push(fitted.clone());
        }
    }
}

/// The same additions in the order of others, if they are the same.
fn in_order(known: &[Addition], others: &[Addition]) -> Option<Vec<Addition>> {
    let same = |other: &Addition| known.iter().find(|own| is_same(own, other)).cloned();
    if known.len() == others.len() { others.iter().map(same).collect() } else { None }
}

/// Whether two additions are the same but for the numbers that a fit estimates, and for the prior of a table: its points and amplitude differ
/// a little with the parameters for which it was scored.
fn is_same(one: &Addition, other: &Addition) -> bool {
    let is_form = match (&one.shape, &other.shape) {
        (Shape::Listed { slots: a, with: b, .. }, Shape::Listed { slots: c, with: d, .. }) => {
            (a, b) == (c, d)
        }
        (Shape::Power { factor: a }, Shape::Power { factor: b })
        | (Shape::Linear { factor: a }, Shape::Linear { factor: b }) => {
            (a.driver, a.exponent) == (b.driver, b.exponent)
        }
        (Shape::Table { .. }, Shape::Table { .. }) => true,
        _ => false,
    };
    is_form
        && (&one.id, one.port, one.follows) == (&other.id, other.port, other.follows)
        && one.active == other.active
        && held(one) == held(other)
}

/// The numbers of an addition, without the values of those that a fit estimates.
fn held(addition: &Addition) -> Vec<Option<f64>> {
    addition.numbers.iter().map(|number| (!number.sloped).then_some(number.value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Setup;
    use crate::testing;

    /// A fit is found again with its numbers, in any order of the additions, but not for another law or for other runs.
    #[test]
    fn a_fit_is_found_by_its_additions() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let [windage, drop] =
            [("windage", 1e-8), ("contact_drop", 0.3)].map(|(id, size)| testing::addition(&setup, id, size));
        let law = testing::law(windage.port, windage.follows);
        let with = |additions: &[&Addition]| Hypothesis {
            additions: additions.iter().map(|one| (*one).clone()).collect(),
            ..setup.preset()
        };
        let fitted =
            |hypothesis| Fitted { hypothesis, shown: Vec::new(), chi_square: 0.0, cost: 0.0, readings: 0 };
        let known = Known::default();
        assert!(known.find(&with(&[&windage])).is_none());
        known.keep(&fitted(with(&[&windage, &drop])));
        let start = testing::addition(&setup, "windage", 3e-8);
        let found = known.find(&with(&[&drop, &start])).unwrap().hypothesis;
        let ids: Vec<(&str, f64)> =
            found.additions.iter().map(|a| (a.id.as_str(), a.numbers[0].value)).collect();
        assert_eq!(ids, [("contact_drop", 0.3), ("windage", 1e-8)]);
        assert!(known.find(&with(&[&windage])).is_none());
        assert!(known.find(&with(&[&law, &drop])).is_none());
        let elsewhere = Addition { active: vec![false], ..windage.clone() };
        assert!(known.find(&with(&[&elsewhere, &drop])).is_none());
        known.keep(&fitted(with(&[&law])));
        let mut steeper = law.clone();
        assert!(known.find(&with(&[&steeper])).is_some());
        if let Shape::Power { factor } = &mut steeper.shape {
            factor.exponent += 0.25;
        }
        assert!(known.find(&with(&[&steeper])).is_none());
    }
}
