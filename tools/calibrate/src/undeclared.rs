//! Parameters without a prior whose values in the preset contradict the data.
//!
//! A parameter without a prior keeps its value. If that value is wrong, the fit compensates with the declared parameters, and an effect
//! would be found that does not exist. Therefore every parameter that stands neither in `[prior]` nor in `[set]` may have another value.
//! To first order that changes the outputs by
//!
//! dy = dy/ds s,   p -> p e^s,  or p -> s p_n if p = 0, on the side of 0 that the limits leave,       (1)
//!
//! p_n the nominal value of the declaration, an ordinary one.
//!
//! The parameters that explain most of the residual are fitted one by one with the declared parameters, as if they had a prior with a
//! standard deviation of their own value. The best one is kept in three cases:
//! - before the search, if the data contradict the model by more than a missing effect does (`intake/consistency.rs`);
//! - in the search, if it explains the fit runs at least as well as every effect, and the error of the validation runs falls;
//! - after a search that finds nothing, if it explains all that the fit leaves.
//!
//! A parameter that is 0 may stand for something that nobody stated: a coefficient of magnets or of a grease over temperature, the heat
//! capacity of a gear. The outputs follow it by (1). A parameter with which they jump is a switch and no candidate; neither is a start value, nor
//! a reference temperature. The sizes of the listed effects are candidates of the search. Before the search no listed effect is compared, so
//! that parameters that are 0 wait for it.
//! *Source*: evidence and its penalty as for effects (`evidence.rs`, `selection.rs`).

use crate::CalibrateError;
use crate::catalogue::{is_of_an_effect, shapes_an_effect};
use crate::experiment::Role;
use crate::fit::Fitted;
use crate::instruments::explain_rest;
use crate::levels::{NEARLY, PART};
use crate::linearization::Linearization;
use crate::parallel;
use crate::search::Scored;
use crate::selection::{Known, LEAST, compete};
use crate::setup::{Declared, Setup};
use physics::declare::{Causality, Kind, Unit, Variable};
use physics::model::Entry;

/// Change of s for the difference in (1). Numerical: the error of the sensitivity is 1 %.
const STEP: f64 = 0.01;
/// Largest magnitude of s by (1) for the start of a fit. Definition: one deviation of its prior; beyond it a first-order value, which may be
/// thousands of times too small, only leads a fit astray.
const FARTHEST: f64 = DEVIATION;
/// Number of parameters that are fitted from each start. Numerical: a limit of effort; the others explain less to first order.
const FITTED: usize = 2;
/// Standard deviation of their prior, relative to their value. Definition: a size of this order is all that is known.
pub const DEVIATION: f64 = 1.0;
/// Group of the start values.
const START_VALUES: &str = "initial.";

/// Whether the preset has a value other than 0 for it.
pub fn is_stated(parameter: &Declared) -> bool {
    parameter.prior != 0.0
}

/// An experiment with a further fitted parameter.
pub struct Released<'a> {
    /// The parameter.
    pub name: String,
    /// The experiment with it.
    pub setup: Setup<'a>,
    /// The fit.
    pub fitted: Fitted,
    /// Evidence for it: decrease of the cost less the penalty for a parameter.
    fall: f64,
}

impl Released<'_> {
    fn is_stated(&self) -> bool {
        self.setup.declared.iter().filter(|d| d.name == self.name).all(is_stated)
    }

    fn is_inside(&self) -> bool {
        let own = self
            .setup
            .declared
            .iter()
            .zip(&self.fitted.hypothesis.declared)
            .find(|(d, _)| d.name == self.name);
        own.is_some_and(|(d, value)| d.is_inside(*value))
    }
}

/// The parameter without prior whose other value explains the residual of `point`, the fit, best; to be fitted, it must explain more than
/// `least` to first order. A wrong value can lead the fit far astray, so that (1) fails there; each parameter is therefore also fitted from
/// the preset, by (1) at the preset. `may_be` selects parameters.
pub fn best<'a>(
    point: &Linearization<'a>,
    least: f64,
    may_be: fn(&Declared) -> bool,
) -> Option<Released<'a>> {
    let near = likely(point, least, may_be);
    if near.is_empty() {
        return None;
    }
    let setup = point.setup;
    let preset = setup.judged(setup.preset(), &point.runs);
    let preset = preset.and_then(|fitted| Linearization::judged(setup, fitted, &point.runs)).ok();
    let far = preset.as_ref().map_or_else(Vec::new, |preset| likely(preset, LEAST, may_be));
    let starts = near.into_iter().map(|own| (point, own));
    let starts = starts.chain(far.into_iter().filter_map(|own| Some((preset.as_ref()?, own))));
    // One after the other, each against the best so far: where parameters nearly replace each other, a fit takes many steps to a cost that is
    // no smaller. Within a fit the runs are parallel.
    let mut rival = point.fitted.cost;
    let all = starts.filter_map(|(start, (_, own, value))| {
        let released = fitted(point, rival, &start.fitted, own, value).ok().filter(Released::is_inside)?;
        rival = rival.min(released.fitted.cost);
        Some(released)
    });
    all.max_by(|a, b| a.fall.total_cmp(&b.fall))
}

/// The parameters without prior that explain most of the residual of a model, with the evidence and the value by (1).
fn likely(point: &Linearization, least: f64, may_be: fn(&Declared) -> bool) -> Vec<(f64, Declared, f64)> {
    let mut own = candidates(point.setup);
    own.retain(may_be);
    let mut all = parallel::flat_map(&own, |own| {
        let (sure, value) = explained(point, own)?;
        (sure > least).then(|| (sure, own.clone(), value))
    });
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(FITTED);
    all
}

/// This parameter, if it explains the residual of `point`, the fit, at least as well as any effect, and validation runs better than the
/// fit; `scored` are the candidate effects, `known` the fits with them.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn better_than_effects<'a>(
    point: &Linearization<'a>,
    scored: &[Scored],
    known: &Known,
) -> Result<Option<Released<'a>>, CalibrateError> {
    let setup = point.setup;
    let first = scored.first().map_or(LEAST, |best| LEAST.max(NEARLY * best.sure()));
    let Some(own) = best(point, first, |_| true) else { return Ok(None) };
    let rivals: Vec<Scored> =
        scored.iter().filter(|s| s.listed && s.sure() > NEARLY * own.fall).cloned().collect();
    let round = compete(point, &point.fitted.hypothesis, &rivals, known);
    // What the model has, but for its size, is no other value: an effect that explains as much has a name.
    let ahead = if own.is_stated() { -LEAST } else { LEAST };
    let rival = round.winner().map_or(LEAST, |winner| LEAST.max(winner.sure() + ahead));
    if own.fall <= rival {
        return Ok(None);
    }
    let runs = setup.runs(Role::Validate);
    let error = |setup: &Setup, fitted: &Fitted| -> Result<f64, CalibrateError> {
        Ok(setup.chi_square(&runs, &setup.show(&fitted.hypothesis, &runs)?).0)
    };
    let is_better = runs.is_empty() || error(&own.setup, &own.fitted)? < error(setup, &point.fitted)?;
    Ok(is_better.then_some(own))
}

/// The parameter with which the fit and validation runs of `point`, a fit that no effect and no law explains, are explained to within the error
/// of instruments; `None` if there is none, or if they are without it.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn in_place_of_effects<'a>(point: &Linearization<'a>) -> Result<Option<Released<'a>>, CalibrateError> {
    let roles = [Role::Fit, Role::Validate];
    if explain_rest(point.setup, &point.fitted, &roles)? {
        return Ok(None);
    }
    let Some(own) = best(point, LEAST, |_| true) else { return Ok(None) };
    Ok(explain_rest(&own.setup, &own.fitted, &roles)?.then_some(own))
}

/// Every parameter of the model that has a value in the preset and that the experiment does not mention.
fn candidates(setup: &Setup) -> Vec<Declared> {
    // Reference temperatures are definitions of other values, and no unknowns; limits of temperatures change no output.
    let is_temperature = |row: &Variable| row.unit == Unit::Kelvin && !row.relative;
    let is_open = |entry: &&Entry| {
        entry.row.causality == Causality::Parameter
            && matches!(entry.row.kind, Kind::Real)
            && (setup.bench.start_of(entry.slot) != 0.0 || !is_of_an_effect(&entry.name))
            && !entry.name.starts_with(START_VALUES)
            && !is_temperature(entry.row)
            && !shapes_an_effect(&entry.name)
            && !setup.declared.iter().any(|d| d.slot == entry.slot)
            && !setup.kept.contains(&entry.name)
            && !setup.experiment.sets(&entry.name)
    };
    let entries = setup.bench.declaration().entries.iter().filter(is_open);
    let own = |entry: &Entry| {
        let prior = setup.bench.start_of(entry.slot);
        let size = if prior == 0.0 { entry.row.nominal } else { prior.abs() };
        Declared { is_released: true, ..Declared::new(entry, prior, DEVIATION * size) }
    };
    entries.map(own).collect()
}

impl<'a> Setup<'a> {
    /// The setup in which these parameters without prior keep the values of the preset.
    pub fn without(mut self, names: &[String]) -> Setup<'a> {
        self.declared.retain(|d| !(d.is_released && names.contains(&d.name)));
        self.kept.extend_from_slice(names);
        self
    }
}

/// The setup with a further declared parameter, after those common to all runs.
fn with<'a>(setup: &Setup<'a>, own: Declared) -> (Setup<'a>, usize) {
    let mut other = setup.clone();
    let place = other.declared.iter().filter(|d| d.runs.is_none()).count();
    other.declared.insert(place, own);
    (other, place)
}

/// Value of a parameter by (1).
fn at(own: &Declared, s: f64) -> f64 {
    let value = match own.prior {
        0.0 if own.limits.1 > 0.0 => s * own.deviation,
        0.0 => -s * own.deviation,
        prior => prior * s.exp(),
    };
    value.clamp(own.limits.0, own.limits.1)
}

/// Evidence for another value of a parameter, and that value, by (1); `None` if it has no influence.
fn explained(point: &Linearization, own: &Declared) -> Option<(f64, f64)> {
    let (setup, place) = with(point.setup, own.clone());
    let moved = |s: f64| {
        let mut moved = point.fitted.hypothesis.clone();
        moved.declared.insert(place, at(own, s));
        moved
    };
    // Most parameters belong to modes that are not selected.
    if !point.slopes.are_moved_by(&setup, &moved(STEP)) {
        return None;
    }
    let column = |s: f64| point.difference_column(&setup.show(&moved(s), &point.runs).ok()?);
    let change = column(STEP)?;
    // Twice the step has twice the response, unless the response is that of a switch.
    if change.amax() == 0.0
        || (own.prior == 0.0 && (column(2.0 * STEP)? - 2.0 * &change).norm() > PART * change.norm())
    {
        return None;
    }
    let gain = point.evidence.gain(&(change / STEP))?;
    let value = at(own, gain.size[0].clamp(-FARTHEST, FARTHEST));
    (value != own.prior).then(|| (gain.whitened.min(gain.raw) - point.per_number(), value))
}

/// The fit with a further parameter that starts at `value`, the others as in `start`, against the cost of a rival.
fn fitted<'a>(
    point: &Linearization<'a>,
    rival: f64,
    start: &Fitted,
    own: Declared,
    value: f64,
) -> Result<Released<'a>, CalibrateError> {
    let name = own.name.clone();
    let (setup, place) = with(point.setup, own);
    let mut start = start.hypothesis.clone();
    start.declared.insert(place, value);
    let fitted = setup.settled_against(rival, start, &point.runs)?;
    let (white, raw) = Linearization::judged(&setup, fitted.clone(), &point.runs)?.explains(point);
    let fall = white.min(raw) - point.per_number();
    Ok(Released { name, setup, fitted, fall })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// Evidence and value by (1) of a parameter of the preset's motor, read with another value of magnets without temperature coefficient.
    #[test]
    fn a_coefficient_that_nobody_stated_is_found_on_its_side_of_zero() {
        let mut experiment = testing::experiment(testing::PRIORS, true);
        let set = |setup: &Setup, value: f64| {
            let entry = setup.bench.declaration().by_name("motor.alpha_mag").unwrap();
            (entry.slot, value)
        };
        testing::read_of(&mut experiment, |setup| {
            let mut change = setup.change(&setup.preset(), 0);
            change.values.push(set(setup, -0.002));
            change
        });
        let reference = {
            let setup = Setup::new(&experiment, &[]).unwrap();
            setup.bench.declaration().by_name("motor.alpha_mag").unwrap().row.value_reference
        };
        let setup = Setup::new(&experiment, &[(reference, 0.0)]).unwrap();
        let point = Linearization::judged(&setup, setup.refit(&[0]).unwrap(), &[0]).unwrap();
        assert!(
            candidates(&setup).iter().all(|own| own.name != "motor.T_ref" && own.name != "effect.windage.k")
        );
        let found = best(&point, LEAST, |_| true).unwrap();
        assert_eq!(found.name, "motor.alpha_mag");
        let value = found.setup.declared.iter().zip(&found.fitted.hypothesis.declared);
        let value = value.filter(|(d, _)| d.name == found.name).map(|(_, value)| *value).next().unwrap();
        assert!((value + 0.002).abs() < 2e-4, "{value}");
    }
}
