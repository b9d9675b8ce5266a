//! Search for the mistakes in the columns that explain a contradiction between data and model.

use super::cost::{Cost, crossed, fitted, with_free};
use super::mistakes::{Mistake, mistakes};
use super::sides::of_transmissions;
use super::{Judge, Predicted, blanked, score, supply, unmeasured, worst};
use crate::CalibrateError;
use crate::catalogue::shapes_an_effect;
use crate::comparison::digits;
use crate::experiment::Experiment;
use crate::intake::signals::POSSIBLE;
use crate::intake::{Unusable, declaration};
use crate::levels::{CERTAIN, FACTOR, PART, SAMPLES, SMALL, STRUCTURE};
use crate::selection::LEAST;
use crate::undeclared;
use physics::declare::Unit;

/// Decrease of the score required for confirming a hypothesis. Derivation: the square of q of one output halves, so that the mistake
/// accounts for more than it leaves.
pub(super) const FALL: f64 = 0.5 * std::f64::consts::LN_2;
/// Greatest number of simultaneous mistakes. Numerical: a limit of effort.
const MOST: usize = 3;
/// Greatest number of hypotheses confirmed for each, and of those about the same columns: the specimen deviates from the preset, so that
/// only the fit distinguishes similar factors. Numerical: a limit of effort; the best are tried first.
const SHORT: (usize, usize) = (16, 6);
/// First and last difference of the common logarithm of a factor. Numerical: the factor is known to 1 %.
const POWERS: (f64, f64) = (0.25, 0.005);

/// Common logarithm of the greatest factor of an input. Limit: units differ by thousands.
const MOST_POWER: f64 = 3.0;
/// Common logarithm of the greatest factor of the interval between the rows. Limit: usual settings of a logger differ by tens.
const INTERVALS: f64 = 1.25;

/// Greatest ratio of a value in another unit, and standard deviation of such a value relative to the present one. Limit: units differ by
/// thousands.
const ANY_ORDER: f64 = 2e3;

/// q of (1) and the best ratio of reading to prediction, by output; `None` without readings.
pub(super) type Agreement = Vec<Option<(f64, f64)>>;

/// Corrected mistake with the changed data and their prediction.
pub(super) struct Changed {
    /// Change of the score.
    pub score: f64,
    pub mistake: Mistake,
    pub data: Experiment,
    pub shown: Predicted,
}

/// The reason why the data cannot be used, and the data as they are meant.
pub(super) struct Found {
    pub why: Unusable,
    pub data: Experiment,
    /// Sum of ln |dx/dy| over the outputs, y the readings as recorded and x as they are meant.
    pub stretch: f64,
}

/// The combination of mistakes that gives the best agreement with the model, if no parameter values within the priors explain the
/// unchanged data nearly as well.
pub(super) fn search(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    files: &str,
) -> Result<Option<Found>, CalibrateError> {
    let mut at = experiment.clone();
    let mut predicted = predicted.clone();
    // Each mistake with the others that explain the data as well.
    let mut found: Vec<Vec<Mistake>> = Vec::new();
    let mut cost = fitted(judge, &at)?;
    while found.len() < MOST && !cost.is_cut {
        let mut best = likely(judge, &at, &predicted)?;
        let known: Vec<usize> = found.iter().flat_map(|one| one[0].touches()).collect();
        best.retain(|one| !one.mistake.touches().iter().any(|k| known.contains(k)));
        let Some((as_meant, one, others)) = confirmed(judge, &at, &cost, best)? else { break };
        found.push(std::iter::once(one.mistake).chain(others).collect());
        (at, predicted, cost) = (one.data, one.shown, as_meant);
    }
    if found.is_empty() {
        return Ok(None);
    }
    let (mut reasons, mut suggestions, mut channel) = (Vec::new(), Vec::new(), None);
    for own in &found {
        let (column, mut reason, suggestion) = own[0].words(experiment, files);
        let others: Vec<&str> = own[1..].iter().filter_map(Mistake::change).collect();
        if !others.is_empty() {
            reason = format!("{reason} (equally {})", others.join(", "));
        }
        reasons.push(reason);
        suggestions.push(suggestion);
        channel.get_or_insert(column);
    }
    for (name, value, own) in other_values(judge, experiment, &cost)? {
        reasons.push(format!("{name} = {value:.4} instead of {own:.4} would explain the data as well"));
        suggestions.push(format!("check the value of {name} in [set] and [prior]"));
    }
    let channel = channel.unwrap_or_default();
    let why = Unusable {
        mistake: Some(Box::new(found[0][0].clone())),
        ..Unusable::new(&channel, reasons.join("; "), suggestions.join("; "))
    };
    let stretch = found.iter().map(|own| own[0].stretch(experiment.inputs.len())).sum();
    Ok(Some(Found { why, data: at, stretch }))
}

/// Parameters of `[set]` and `[prior]` whose other value explains the unchanged data as well as the corrected mistakes: name, that value and
/// the present one. A greater difference than [`FACTOR`] is none between a motor and its preset.
fn other_values(
    judge: &Judge,
    experiment: &Experiment,
    as_meant: &Cost,
) -> Result<Vec<(String, f64, f64)>, CalibrateError> {
    let mut found = Vec::new();
    for (name, cost, value, own) in freed(judge, experiment, undeclared::DEVIATION, |_, _| true)? {
        if is_of_its_order(value, own) && !cost.is_worse_than(as_meant, FACTOR, None) {
            found.push((name, value, own));
        }
    }
    Ok(found)
}

/// The value of `[set]` or `[prior]`, of those that are `asked` for, of another order than the specimen's, if the data agree with the model with that of the specimen. A value
/// that has no prior is meant to be exact: one that differs by more than structure error causes contradicts the data as well.
pub(super) fn wrong_value(
    judge: &Judge,
    experiment: &Experiment,
    as_is: &Cost,
    asked: fn(&Experiment, &str) -> bool,
) -> Result<Option<Unusable>, CalibrateError> {
    let (values, others): (Vec<Freed>, Vec<Freed>) = freed(judge, experiment, ANY_ORDER, asked)?
        .into_iter()
        .filter(|(_, cost, ..)| !cost.is_cut && cost.follows_all() && as_is.is_worse_than(cost, FACTOR, None))
        .partition(|(name, _, value, own)| {
            // A wide prior permits values of another order.
            let prior = experiment.priors.iter().find(|p| p.name == *name);
            let deviation = prior.map_or(0.0, |p| p.deviation.of(*own, *own));
            let share = value / own;
            let is_near = match prior {
                Some(_) => is_of_its_order(*value, *own),
                None => (1.0 - PART..=1.0 / (1.0 - PART)).contains(&share),
            };
            let is_far = (value - own).abs() > CERTAIN * deviation;
            share * ANY_ORDER > 1.0 && share < ANY_ORDER && !is_near && is_far
        });
    let best = values.into_iter().min_by(|a, b| a.1.whole().total_cmp(&b.1.whole()));
    Ok(best.map(|(name, cost, value, own)| {
        let as_well = others.iter().filter(|(_, other, ..)| other.whole() < cost.whole() + LEAST);
        let as_well: Vec<String> =
            as_well.map(|(name, _, value, _)| format!("{name} = {}", digits(*value))).collect();
        let or =
            if as_well.is_empty() { String::new() } else { format!(", and for {}", as_well.join(" or ")) };
        Unusable::new(
            &name,
            format!(
                "{name} = {} contradicts the data, which agree with the model for {}{or}",
                digits(own),
                digits(value)
            ),
            format!("check the value and the unit of {name} in [set], [prior] and the preset"),
        )
    }))
}

/// Whether a parameter has no prior: its value is meant to be exact.
pub(super) fn is_exact(experiment: &Experiment, name: &str) -> bool {
    !experiment.priors.iter().any(|prior| prior.name == name)
}

/// A parameter, the cost if it is free, its value then and the present one.
type Freed = (String, Cost, f64, f64);

fn is_of_its_order(value: f64, own: f64) -> bool {
    (1.0 / FACTOR..=FACTOR).contains(&(value / own))
}

/// The parameters of `[set]` and `[prior]` without the shapes of effects, each with the cost if it has this standard deviation relative to its
/// value, the value then, and the present one.
fn freed(
    judge: &Judge,
    experiment: &Experiment,
    deviation: f64,
    asked: fn(&Experiment, &str) -> bool,
) -> Result<Vec<Freed>, CalibrateError> {
    let set = experiment.set.iter().map(|(name, _)| name);
    // A value in [set] may have a prior as well.
    let of_prior = experiment.priors.iter().map(|p| &p.name);
    let of_prior = of_prior.filter(|name| !experiment.set.iter().any(|(other, _)| other == *name));
    let mut all = Vec::new();
    let all_of = set.chain(of_prior).filter(|name| !shapes_an_effect(name) && asked(experiment, name));
    for name in all_of {
        if judge.deadline.is_near() {
            break;
        }
        if let Some((cost, value, own)) = with_free(judge, experiment, name, deviation)? {
            all.push((name.clone(), cost, value, own));
        }
    }
    Ok(all)
}

/// The hypotheses that agree better with the model than the data as they are, or hardly differ from them.
fn likely(judge: &Judge, at: &Experiment, predicted: &Predicted) -> Result<Vec<Changed>, CalibrateError> {
    let inputs = at.inputs.len();
    // The runs of different files may differ by more than parameters, so that only one mistake is looked for in comparison with others.
    if !judge.beside.is_empty() {
        return Ok(interval(judge, at, predicted).into_iter().collect());
    }
    // An output is compared with the preset, or with what the other outputs imply: a current that is the small difference of two voltages
    // is predicted by no preset.
    let implied = crossed(judge, at, predicted)?;
    let agreement = |data: &Experiment, shown: &Predicted, is_simulated: bool| {
        let own = judge.outputs(data, shown);
        if is_simulated { own } else { nearer(own, judge.outputs(data, &implied)) }
    };
    let before = [agreement(at, predicted, false), agreement(at, predicted, true)];
    let changed = |mistake: &Mistake| -> Option<Changed> {
        if !mistake.is_permitted(at, judge.runs) {
            return None;
        }
        let mut data = at.clone();
        mistake.apply(&mut data, judge.runs);
        if !is_possible(&data, mistake) {
            return None;
        }
        let is_simulated = mistake.is_simulated(at);
        let shown = if is_simulated { judge.predicted(&data) } else { predicted.clone() };
        let after = score(&agreement(&data, &shown, is_simulated));
        let score = after - score(&before[usize::from(is_simulated)]);
        Some(Changed { score, mistake: mistake.clone(), data, shown })
    };
    let mut best: Vec<Changed> = Vec::new();
    let is_better = |one: &Changed| {
        let is_simulated = one.mistake.is_simulated(at);
        let after = agreement(&one.data, &one.shown, is_simulated);
        one.score < -FALL
            && (one.mistake.is_partial() || agrees_more(&before[usize::from(is_simulated)], &after))
    };
    let candidates = all(judge, at);
    // Outputs first, because they need no simulation; then inputs; an arbitrary factor if no usual mistake explains the data.
    for mistake in candidates.iter().filter(|m| !m.is_simulated(at)) {
        // Upper bound of the gain: full agreement of the affected outputs.
        let own =
            mistake.touches().into_iter().filter_map(|k| before[0].get(k.checked_sub(inputs)?).copied()?);
        let own: Agreement = own.map(Some).collect();
        if score(&own) >= FALL + own.len() as f64 * STRUCTURE.ln() {
            best.extend(changed(mistake).filter(is_better));
        }
    }
    let worst_now = worst(&before[1]);
    for mistake in candidates.iter().filter(|m| m.is_simulated(at) && (worst_now >= PART || m.is_partial())) {
        best.extend(changed(mistake).filter(is_better));
    }
    for (k, output) in before[0].iter().enumerate() {
        if let Some((_, ratio)) = output.filter(|(q, r)| *q > PART && r.is_finite() && *r != 0.0)
            && !(1.0 / FACTOR..=FACTOR).contains(&ratio)
            && !at.outputs[k].is_temperature()
        {
            let words = format!("readings divided by {ratio:.3}");
            let columns = vec![inputs + k];
            if best.iter().any(|one| one.mistake.touches() == columns) {
                continue;
            }
            let mistake = Mistake::Affine { columns, factor: 1.0 / ratio, offset: 0.0, words };
            best.extend(changed(&mistake).filter(is_better));
        }
    }
    if best.is_empty() && worst_now > 2.0 * PART {
        best.extend(any_factor(judge, at, &changed).into_iter().filter(is_better));
    }
    shortlist(&mut best);
    // Exchanged thermometers, or a common wrong unit, hardly change the shapes.
    let is_new = |m: &&Mistake| !best.iter().any(|one| one.mistake == **m);
    let alike = candidates.iter().filter(|m| m.is_alike(at)).filter(is_new).filter_map(changed);
    let alike: Vec<Changed> = alike.filter(|one| one.score < FALL).collect();
    best.extend(alike);
    best.extend(supply::of(judge, at, predicted, &implied));
    best.extend(unmeasured::of(judge, at, predicted, &before[1]));
    Ok(best)
}

/// The interval between the rows with the best agreement. In all files another interval is another motor.
fn interval(judge: &Judge, at: &Experiment, predicted: &Predicted) -> Option<Changed> {
    let before = score(&judge.outputs(at, predicted));
    let with = |factor: f64| {
        let (mistake, mut data) = (Mistake::Time(factor, None), at.clone());
        mistake.apply(&mut data, judge.runs);
        let shown = judge.predicted(&data);
        let score = score(&judge.outputs(&data, &shown)) - before;
        Some(Changed { score, mistake, data, shown })
    };
    best_factor(judge, INTERVALS, 1.0 + PART, &with).filter(|one| one.score < -FALL)
}

/// The hypothesis with the least cost that no parameter values within the priors replace, and others about the same columns that explain
/// the data as well; of these, the first in the list of mistakes is the simplest.
fn confirmed(
    judge: &Judge,
    at: &Experiment,
    as_is: &Cost,
    best: Vec<Changed>,
) -> Result<Option<(Cost, Changed, Vec<Mistake>)>, CalibrateError> {
    let inputs = at.inputs.len();
    let mut all: Vec<(f64, Cost, Changed)> = Vec::new();
    for one in best {
        let as_meant = fitted(judge, &one.data)?.stretched(as_is, one.mistake.stretch(inputs));
        // An output that implies an input is not evidence: both costs are computed without it.
        let without = match one.mistake.implied_by() {
            Some(by) => Some(fitted(judge, &blanked(at, judge.runs, by))?.stretched(as_is, 0.0)),
            None => None,
        };
        // At the deadline the best of those that were confirmed is the answer; they come in the order of their scores.
        if as_meant.is_cut {
            break;
        }
        let (unchanged, factor) = (without.as_ref().unwrap_or(as_is), one.mistake.factor());
        let is_better = unchanged.is_worse_than(&as_meant, factor, None)
            && (!one.mistake.is_of_temperatures(at) || unchanged.is_worse_in_shape(&as_meant, factor));
        // What changes the level alone is a hypothesis about one number, which a missing effect confirms in part: it has to leave nothing.
        let is_whole = !one.mistake.is_level(at) || as_meant.agrees(as_is);
        if is_better && is_whole && as_meant.whole() <= judge.most {
            // As if the output that is no evidence agreed to within the structure error.
            let of_output = if without.is_some() { SAMPLES * judge.runs.len() as f64 } else { 0.0 };
            all.push((as_meant.whole() + as_meant.wider_than(as_is) + of_output, as_meant, one));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let names = self::all(judge, at);
    while !all.is_empty() {
        let most = all[0].0 + LEAST;
        // Structure error decides between a plain unit and others that leave as little; the first in the list is the simplest.
        let (columns, least) = (all[0].2.mistake.touches(), &all[0].1);
        let is_alike = |(cost, own, one): &(f64, Cost, Changed)| {
            let is_plain = one.mistake.is_plain() && one.mistake.touches() == columns;
            *cost <= most || is_plain && !own.is_worse_than(least, FACTOR, None)
        };
        let alike = (0..all.len()).filter(|k| is_alike(&all[*k]));
        let simplest = alike.min_by_key(|k| place(&all[*k].2.mistake, &names)).unwrap_or(0);
        let (_, as_meant, one) = all.remove(simplest);
        let rest: Vec<(f64, Cost, Changed)> = all.extract_if(.., |(cost, ..)| *cost <= most).collect();
        let mut is_sensor = false;
        // A failed sensor of one output contradicts the same rows; it leaves the other outputs in agreement.
        if one.mistake.is_simulated(at) {
            for k in (0..at.outputs.len()).filter(|k| !one.mistake.touches().contains(&(inputs + k))) {
                let alone = fitted(judge, &blanked(at, judge.runs, inputs + k))?.stretched(as_is, 0.0);
                is_sensor |= !alone.is_cut && as_meant.is_worse_than(&alone, FACTOR, Some(k));
            }
        }
        if !is_sensor {
            let same = one.mistake.touches();
            let mut others: Vec<Mistake> = rest.into_iter().map(|(.., other)| other.mistake).collect();
            others.retain(|m| m.touches() == same && !m.is_near(&one.mistake));
            return Ok(Some((as_meant, one, others)));
        }
    }
    Ok(None)
}

/// All mistakes, the simplest first.
fn all(judge: &Judge, at: &Experiment) -> Vec<Mistake> {
    [of_transmissions(at, judge.preset), mistakes(at)].concat()
}

/// Place of a mistake in the list of all.
fn place(mistake: &Mistake, all: &[Mistake]) -> usize {
    all.iter().position(|other| other == mistake).unwrap_or(all.len())
}

/// The better agreement of two predictions, output by output.
fn nearer(one: Agreement, other: Agreement) -> Agreement {
    let pairs = one.into_iter().zip(other);
    let of = |(a, b)| match (a, b) {
        (Some(a), Some(b)) => Some(nearest(a, b)),
        (a, b) => a.or(b),
    };
    pairs.map(of).collect()
}

fn nearest(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    if other.0 < one.0 { other } else { one }
}

/// Keeps the best few, best first; among equals the first that was tried.
fn shortlist(best: &mut Vec<Changed>) {
    best.sort_by(|a, b| a.score.total_cmp(&b.score));
    let mut seen: Vec<Vec<usize>> = Vec::new();
    best.retain(|one| {
        seen.push(one.mistake.touches());
        seen.iter().filter(|own| *own == &seen[seen.len() - 1]).count() <= SHORT.1
    });
    best.truncate(SHORT.0);
}

/// Whether the inputs that a mistake changes are within the limits of their variables, and temperatures within those of sensors.
fn is_possible(changed: &Experiment, mistake: &Mistake) -> bool {
    let declaration = declaration(changed);
    mistake.touches().into_iter().filter(|k| *k < changed.inputs.len()).all(|k| {
        let channel = changed.inputs[k];
        let entry = channel.input.and_then(|name| declaration?.by_name(name));
        let all =
            || changed.runs.iter().flat_map(|r| r.table.columns[k].iter().copied()).filter(|x| x.is_finite());
        // Single readings may be spikes.
        let within = |limits: std::ops::RangeInclusive<f64>| {
            let beyond = all().filter(|x| !limits.contains(x)).count();
            beyond as f64 <= SMALL * all().count() as f64
        };
        entry.is_none_or(|e| within(e.row.min..=e.row.max))
            && (!channel.is_temperature() || within(POSSIBLE.0..=POSSIBLE.1))
    })
}

/// Whether one output agrees and its q is halved, or those of all outputs are, in their geometric mean (the preset is not the specimen: a
/// current that is the small difference of two voltages is then far off without any mistake), and no output that agreed is now far off.
fn agrees_more(before: &Agreement, after: &Agreement) -> bool {
    let all = pairs(before, after).count() as f64;
    let one_agrees = pairs(before, after).any(|(a, b)| b < PART && b < 0.5 * a);
    let all_nearer = score(after) - score(before) < -all * std::f64::consts::LN_2;
    (one_agrees || all_nearer) && !spoils(before, after)
}

/// Whether an output that agreed is now far off.
pub(super) fn spoils(before: &Agreement, after: &Agreement) -> bool {
    pairs(before, after).any(|(a, b)| a < PART && b > PART)
}

/// (1) of each output that has readings in both.
fn pairs<'a>(before: &'a Agreement, after: &'a Agreement) -> impl Iterator<Item = (f64, f64)> + 'a {
    before.iter().flatten().zip(after.iter().flatten()).map(|((a, _), (b, _))| (*a, *b))
}

/// Each input with the factor that gives the best agreement with the model.
fn any_factor(
    judge: &Judge,
    experiment: &Experiment,
    changed: &dyn Fn(&Mistake) -> Option<Changed>,
) -> Vec<Changed> {
    let is_load = |unit: Unit| !matches!(unit, Unit::Kelvin | Unit::Pascal | Unit::One);
    let loads = experiment.inputs.iter().enumerate().filter(|(_, channel)| is_load(channel.unit));
    let of = |k: usize| {
        let with = |factor: f64| {
            let words = format!("readings times {factor:.3}");
            changed(&Mistake::Affine { columns: vec![k], factor, offset: 0.0, words })
        };
        best_factor(judge, MOST_POWER, FACTOR, &with)
    };
    loads.filter_map(|(k, _)| of(k)).collect()
}

/// The factor from 10^-`most` to 10^`most` that gives the best agreement; those between 1 / `least` and `least` are none.
fn best_factor(
    judge: &Judge,
    most: f64,
    least: f64,
    with: &dyn Fn(f64) -> Option<Changed>,
) -> Option<Changed> {
    let mut best: Option<(f64, Changed)> = None;
    let mut step = POWERS.0;
    let steps = (most / step) as i32;
    let mut powers: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * step).collect();
    while step > POWERS.1 && !judge.deadline.is_near() {
        for power in std::mem::take(&mut powers).into_iter().filter(|p| p.abs() > least.log10()) {
            let is_better = |one: &Changed| best.as_ref().is_none_or(|(_, least)| one.score < least.score);
            if let Some(one) = with(10f64.powf(power)).filter(is_better) {
                best = Some((power, one));
            }
        }
        step *= 0.5;
        let (at, _) = best.as_ref()?;
        powers = vec![at - step, at + step];
    }
    best.map(|(_, one)| one)
}
