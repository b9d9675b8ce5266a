//! The fit of a candidate.

use super::{ALIKE, Candidate, Known, choice};
use crate::CalibrateError;
use crate::hypothesis::{Addition, Hypothesis, Shape};
use crate::linearization::Linearization;
use crate::search::Scored;
use crate::setup::Setup;

/// Parameters of the fitted model with a further addition: start values of its fit.
fn initial_guess(setup: &Setup, start: &Hypothesis, addition: &Addition) -> Hypothesis {
    let mut hypothesis = start.clone();
    // A parameter that compensates for the effect is far off; a fit started from there converges slowly or not at all.
    for (value, declared) in hypothesis.declared.iter_mut().zip(&setup.declared) {
        if declared.astray(*value) {
            *value = declared.prior;
        }
    }
    hypothesis.additions.push(addition.clone());
    hypothesis
}

/// A candidate, fitted. A shape parameter of a listed effect that would end at a limit is held at the preset's value, if the data do not
/// distinguish that from its estimate.
pub fn fitted<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &Scored,
    known: &Known,
) -> Result<Candidate<'a>, CalibrateError> {
    let Some(mut form) = scored.addition.clone() else {
        return Err(CalibrateError(format!("{} cannot be added", scored.name)));
    };
    let mut candidate = fitted_as(point, start, scored, &form, known)?;
    while let Some(held) = held(point.setup, &form, candidate.addition()) {
        let Ok(other) = fitted_as(point, start, scored, &held, known) else { break };
        if other.sure() < candidate.sure() - ALIKE {
            break;
        }
        (form, candidate) = (held, other);
    }
    Ok(candidate)
}

/// A candidate in one form, fitted.
fn fitted_as<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &Scored,
    addition: &Addition,
    known: &Known,
) -> Result<Candidate<'a>, CalibrateError> {
    let setup = point.setup;
    let guess = initial_guess(setup, start, addition);
    let fitted =
        known.or_fitted(&guess, || setup.fit_addition(guess.clone(), &point.runs), setup.deadline())?;
    let larger = Linearization::judged(setup, fitted, &point.runs)?;
    let cost = point.per_number() * setup.price(addition)
        + if addition.is_listed() { 0.0 } else { choice(addition.port, addition.follows) };
    let of_runs = if addition.is_in_every_run() { 0.0 } else { 2.0 * point.runs.len() as f64 * 2f64.ln() };
    let (white, raw) = larger.explains(point);
    let delta = (white - cost - of_runs, raw - cost - of_runs);
    Ok(Candidate {
        name: scored.name.clone(),
        delta_validation: larger.delta_validation(point),
        point: larger,
        delta,
        validation: None,
        refused: None,
    })
}

/// A form of a listed effect, with the shape parameter that ended at a limit in the `fitted` one held at the preset's value, which has a source;
/// `None` if none did. A limit is that of plausible values and no estimate.
fn held(setup: &Setup, form: &Addition, fitted: &Addition) -> Option<Addition> {
    let mut form = form.clone();
    let Shape::Listed { slots, with, .. } = &mut form.shape else { return None };
    let stuck = fitted.numbers.iter().skip(1).find(|number| number.sloped && number.is_at_limit())?;
    let place = form.numbers.iter().position(|number| number.symbol == stuck.symbol)?;
    form.numbers.remove(place);
    let slot = slots.remove(place);
    with.push((slot, setup.bench.start_of(slot)));
    Some(form)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn a_shape_at_a_limit_is_held() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let form = testing::addition(&setup, "lubricant_friction", 1e-3);
        let symbols = |own: &Addition| own.numbers.iter().map(|n| n.symbol.clone()).collect::<Vec<_>>();
        assert_eq!(symbols(&form), ["tau_l", "n", "beta"]);
        assert!(held(&setup, &form, &form).is_none());
        let mut fitted = form.clone();
        // Without a dependence on the speed; a size is no shape.
        (fitted.numbers[1].value, fitted.numbers[0].value) = (0.0, fitted.numbers[0].limits.1);
        assert!(held(&setup, &form, &fitted).is_none());
        fitted.numbers[2].value = fitted.numbers[2].limits.0;
        let own = held(&setup, &form, &fitted).unwrap();
        assert_eq!(symbols(&own), ["tau_l", "n"]);
        let Shape::Listed { slots, with, .. } = &own.shape else { panic!("{:?}", own.shape) };
        let slot = |name: &str| setup.bench.declaration().by_name(name).unwrap().slot;
        assert_eq!(slots[1..], [slot("effect.lubricant_friction.n")]);
        assert_eq!(with[..], [(slot("effect.lubricant_friction.beta"), 0.025)]);
        fitted.numbers[1].value = 1.0;
        assert_eq!(symbols(&held(&setup, &own, &fitted).unwrap()), ["tau_l"]);
    }
}
