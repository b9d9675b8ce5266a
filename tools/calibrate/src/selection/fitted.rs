//! The fit of a candidate.

use super::{ALIKE, Candidate, Known, choice};
use crate::CalibrateError;
use crate::fit::Fitted;
use crate::hypothesis::{Addition, Hypothesis, Shape};
use crate::linearization::Linearization;
use crate::search::Scored;
use crate::setup::Setup;

/// First distance, in rows, of the times that [`moved_in_time`] compares. Numerical: some minutes of a logger of 2 s; it moves on while the
/// agreement improves.
const REACH: usize = 64;

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
    if let Some(moved) = moved_in_time(point.setup, &candidate.point.fitted, &point.runs) {
        let other = fitted_as(point, start, scored, &moved, known)?;
        if other.sure() > candidate.sure() {
            (form, candidate) = (moved, other);
        }
    }
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

/// A step effect, the last addition of a fit, at the time of a row for which the simulated model agrees best: a search by bisection about the
/// time by linearization, which a step of a load nearby leads astray. `None` if that stays, and for other effects.
fn moved_in_time(setup: &Setup, fitted: &Fitted, runs: &[usize]) -> Option<Addition> {
    let addition = fitted.hypothesis.additions.last().filter(|own| own.is_listed())?;
    let place = addition.numbers.iter().position(|number| !number.sloped)?;
    let mut rows: Vec<f64> = runs.iter().flat_map(|run| setup.drives[*run].time.iter().copied()).collect();
    rows.sort_by(f64::total_cmp);
    let at = |row: usize| {
        let mut addition = addition.clone();
        addition.numbers[place].value = rows[row];
        addition
    };
    let cost = |row: usize| {
        let mut other = fitted.hypothesis.clone();
        *other.additions.last_mut()? = at(row);
        setup.judged(other, runs).ok().map(|judged| judged.cost)
    };
    let begin = rows.partition_point(|t| *t < addition.numbers[place].value).min(rows.len() - 1);
    let (mut best, mut least) = (begin, fitted.cost);
    let mut reach = REACH;
    while reach > 0 && !setup.deadline().is_near() {
        let sides = [best.checked_sub(reach), Some(best + reach).filter(|row| *row < rows.len())];
        let near = sides.into_iter().flatten().filter_map(|row| Some((row, cost(row)?)));
        match near.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, cost)| *cost < least) {
            Some(nearer) => (best, least) = nearer,
            None => reach /= 2,
        }
    }
    (best != begin).then(|| at(best))
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

    /// A loss of magnetisation at 700 s is found there from two minutes beside it.
    #[test]
    fn a_step_moves_to_its_row() {
        let mut experiment = testing::experiment(testing::PRIORS, true);
        testing::read_of(&mut experiment, |setup| {
            let mut change = setup.change(&setup.preset(), 0);
            let slot = |name: &str| setup.bench.declaration().by_name(name).unwrap().slot;
            change.values.push((slot("effect.demagnetisation.fraction"), 0.1));
            change.values.push((slot("effect.demagnetisation.time"), 700.0));
            change
        });
        let setup = Setup::new(&experiment, &[]).unwrap();
        let judged = |addition: Addition| {
            let hypothesis = Hypothesis { additions: vec![addition], ..setup.preset() };
            setup.judged(hypothesis, &[0]).unwrap()
        };
        for (begin, end) in [(580.0, Some(700.0)), (825.0, Some(700.0)), (700.0, None)] {
            let mut addition = testing::addition(&setup, "demagnetisation", 0.1);
            addition.numbers[1].value = begin;
            let moved = moved_in_time(&setup, &judged(addition), &[0]);
            assert_eq!(moved.map(|own| own.numbers[1].value), end);
        }
        let windage = judged(testing::addition(&setup, "windage", 1e-8));
        assert!(moved_in_time(&setup, &windage, &[0]).is_none());
    }

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
