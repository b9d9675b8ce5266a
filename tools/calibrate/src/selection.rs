//! One further effect at a time: the best of what was scored are fitted with all the other numbers, compete, and have to
//! pass the gate.
//!
//! cost = -2 log p + ln n for each number, n the blocks (Schwarz, Annals of Statistics 6 (1978) 461-464)     (1)
//!
//! The gate asks, in this order: does (1) fall by more than 10 with the noise taken as white and with its own memory;
//! are sign and size physical; does every run want the same size; is what was not fitted predicted better. Without it
//! the cost alone finds effects in every bench whose thermocouples drift.

mod gate;

use crate::CalibrateError;
use crate::hypothesis::{Addition, Hypothesis};
use crate::linearization::Linearization;
use crate::outcome::{Evidence, Follows};
use crate::search::{Scored, choice};
use crate::setup::Setup;
use gate::gate;
pub use gate::{acting, predicts_where_it_acts};
use physics::terms::{Driver, Port};
use rayon::prelude::*;

/// Fall of the cost that a term needs: very strong evidence. *Source*: Kass, Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795, sec. 3.2.
pub const LEAST: f64 = 10.0;
/// What a candidate that predicts worse has to explain to be tried together with another.
const PROMISING: f64 = 100.0;
/// Costs as near as this cannot be told apart, and what predicts better does so by as much: strong evidence. *Source*: as above.
pub const NEAR: f64 = 6.0;
/// Contenders: effects of the list, powers, shapes, laws with a lag.
const CANDIDATES: [usize; 4] = [4, 2, 2, 2];
/// The same, by another measure.
const FURTHER: [usize; 4] = [3, 1, 1, 1];
/// What brings a store of its own is simulated ten times as slowly, and competes only where what is sure of it is this share of the
/// best.
const STORED: f64 = 0.2;
/// Laws as near as this, as a number and as a share, are chosen by what they predict.
const PREDICTING: (f64, f64) = (30.0, 0.02);
/// A table that predicts better than a power by less than this share is not clearly better.
const CLEARLY: f64 = 1.05;
/// Error on what was not fitted, over that of an effect of the list, below which a law predicts far better.
const AHEAD: f64 = 0.7;

/// A candidate that was fitted.
pub struct Candidate<'a> {
    /// What it is, in words.
    pub name: String,
    /// With everything around it, linearised anew.
    pub point: Linearization<'a>,
    /// Fall of (1) with the noise's own memory, and for white noise.
    pub delta: (f64, f64),
    /// Error on what was not fitted, over that without; `None` where there is nothing.
    pub validation: Option<f64>,
    /// Why it is not taken, in one sentence.
    pub refused: Option<String>,
}

impl Candidate<'_> {
    /// What speaks for it whichever way the noise is taken.
    pub fn sure(&self) -> f64 {
        self.delta.0.min(self.delta.1)
    }

    /// What was added.
    pub fn addition(&self) -> &Addition {
        let additions = &self.point.fitted.hypothesis.additions;
        &additions[additions.len() - 1]
    }
}

/// What a round has come to.
pub struct Round<'a> {
    /// All that were fitted, the best first.
    pub candidates: Vec<Candidate<'a>>,
    /// The one that is taken, by its place.
    pub taken: Option<usize>,
    /// Why it was taken though it does not pass the gate by itself.
    excuse: Option<&'static str>,
    /// Others that the data cannot tell from it.
    pub alike: Vec<usize>,
    /// Candidates that could not be fitted, and why.
    failed: Vec<(Scored, CalibrateError)>,
}

impl<'a> Round<'a> {
    /// What was taken.
    pub fn winner(&self) -> Option<&Candidate<'a>> {
        self.taken.map(|taken| &self.candidates[taken])
    }

    /// The one that explains most but predicts worse, where that is a lot: something else may spoil what it predicts.
    pub fn promising(&self) -> Option<usize> {
        let predicts_worse = |c: &Candidate| c.validation.is_some_and(|ratio| ratio >= 1.0);
        let first = self.candidates.iter().position(|c| at_limit(c.addition()).is_none())?;
        let best = &self.candidates[first];
        (self.taken.is_none() && predicts_worse(best) && best.sure() > PROMISING).then_some(first)
    }

    /// The same with one of its candidates taken though it does not pass the gate, and why.
    pub fn with_taken(mut self, k: usize, excuse: &'static str) -> Round<'a> {
        self.candidates[k].refused = None;
        self.taken = Some(k);
        self.excuse = Some(excuse);
        self
    }

    /// The same with nothing taken, and why not what was.
    pub fn without_taken(mut self, reason: &str) -> Round<'a> {
        if let Some(k) = self.taken.take() {
            self.candidates[k].refused = Some(reason.to_string());
        }
        self
    }

    /// Whether what was taken also passes the gate beside a point that lies further back.
    pub fn passes_beside(&self, point: &Linearization) -> bool {
        self.winner().is_some_and(|c| matches!(gate(point, c), Ok((_, None))))
    }

    /// The same with another point for what was taken.
    pub fn with_point(mut self, point: Linearization<'a>) -> Round<'a> {
        if let Some(taken) = self.taken {
            self.candidates[taken].point = point;
        }
        self
    }

    /// The round as a report tells it.
    pub fn candidate_table(&self, round: usize) -> Vec<Evidence> {
        let best = self.winner().map(|c| c.name.clone());
        let failed = self.failed.iter().map(|(scored, error)| Evidence {
            round,
            name: scored.name.clone(),
            port: scored.port,
            delta_bic: scored.raw,
            delta_bic_whitened: scored.evidence,
            validation_ratio: None,
            accepted: false,
            reason: format!("could not be fitted, BIC to first order: {error}"),
        });
        let candidates = self.candidates.iter().enumerate().map(|(k, c)| {
            let reason = match (&c.refused, &best) {
                (Some(refused), _) => refused.clone(),
                (None, _) if self.taken == Some(k) => {
                    self.excuse.unwrap_or("explains most of all, and passes the gate").to_string()
                }
                (None, Some(best)) if self.alike.contains(&k) => {
                    format!("explains as much as {best}: this data cannot tell them apart")
                }
                (None, Some(best)) => format!("explains less than {best}"),
                (None, None) => "is not the best".to_string(),
            };
            Evidence {
                round,
                name: c.name.clone(),
                port: c.addition().port,
                delta_bic: c.delta.1,
                delta_bic_whitened: c.delta.0,
                validation_ratio: c.validation,
                accepted: self.taken == Some(k),
                reason,
            }
        });
        candidates.chain(failed).collect()
    }
}

/// Lets the best of what was scored at a point compete; `point` is the model without any of them, and their fits begin at
/// `start`. A candidate with which the model cannot be run is listed with the reason.
pub fn compete<'a>(point: &Linearization<'a>, start: &Hypothesis, scored: &[Scored]) -> Round<'a> {
    let chosen = choose(scored);
    let fitted: Vec<Result<Candidate<'a>, CalibrateError>> =
        chosen.par_iter().map(|scored| fitted(point, start, scored)).collect();
    let (mut candidates, mut failed) = (Vec::new(), Vec::new());
    for (result, scored) in fitted.into_iter().zip(chosen) {
        match result {
            Ok(candidate) => candidates.push(candidate),
            Err(error) => failed.push((scored.clone(), error)),
        }
    }
    candidates.sort_by(|a, b| b.sure().total_cmp(&a.sure()));
    let mut taken = None;
    let mut alike = Vec::new();
    for candidate in &mut candidates {
        candidate.refused = at_limit(candidate.addition());
    }
    // An effect of the list stands for a shape that explains hardly more, and a law without a further state for one with it.
    let mut order: Vec<usize> = (0..candidates.len()).filter(|k| candidates[*k].refused.is_none()).collect();
    let first = order.first().map(|k| &candidates[*k]);
    let best = first.map_or(0.0, Candidate::sure);
    let is_late = |c: &Candidate| c.addition().late.is_some();
    let is_best_late = first.is_some_and(is_late);
    let near = if is_best_late { LEAST.max(best * PREDICTING.1) } else { LEAST };
    let stands = |c: &Candidate| {
        let is_simple = c.addition().is_listed() || (is_best_late && !is_late(c));
        is_simple && best - c.sure() < near
    };
    order.sort_by_key(|k| !stands(&candidates[*k]));
    order_by_likelihood(&candidates, &mut order);
    for k in order {
        // Who explains far less than one that was taken is not looked at.
        if taken.is_some_and(|t: usize| candidates[t].sure() - candidates[k].sure() > NEAR) {
            continue;
        }
        if taken.is_some() && !candidates[k].addition().is_listed() {
            continue;
        }
        // A candidate that cannot be run where it must prove itself has not proved itself.
        let (validation, refused) =
            gate(point, &candidates[k]).unwrap_or_else(|e| (None, Some(format!("cannot be judged: {e}"))));
        candidates[k].validation = validation;
        let passes = refused.is_none();
        candidates[k].refused = refused;
        match (passes, taken) {
            (true, None) => taken = Some(best_predicting(point, &mut candidates, k)),
            (true, Some(_)) if candidates[k].addition().is_listed() => alike.push(k),
            _ => {}
        }
    }
    if taken.is_some_and(|t| !candidates[t].addition().is_listed()) {
        alike.clear();
    }
    // From the others nothing is looked at any more.
    let first = candidates.iter().position(|c| at_limit(c.addition()).is_none());
    let rest = candidates.iter_mut().enumerate().filter(|(k, _)| ![taken, first].contains(&Some(*k)));
    rest.for_each(|(_, candidate)| candidate.point.release());
    Round { candidates, taken, excuse: None, alike, failed }
}

/// Of two laws of no list that explain the same, the likelier comes first: a sensor that errs by what the motor does is rarer than a
/// motor that does it, and what happens at a node follows the temperature of that node.
fn order_by_likelihood(candidates: &[Candidate], order: &mut Vec<usize>) {
    let unnamed = |k: &usize| !candidates[*k].addition().is_listed();
    for strange in [is_at_a_sensor as fn(&Addition) -> bool, follows_another_node] {
        let Some(first) = order.iter().position(unnamed) else { return };
        let best = &candidates[order[first]];
        if !strange(best.addition()) {
            continue;
        }
        let as_well = |k: &usize| {
            let other = &candidates[*k];
            unnamed(k)
                && !strange(other.addition())
                && (is_sensor(best.addition().port) || other.addition().port == best.addition().port)
                && best.sure() - other.sure() < NEAR
        };
        if let Some(other) = order.iter().position(as_well) {
            let other = order.remove(other);
            order.insert(first, other);
        }
    }
}

fn is_at_a_sensor(addition: &Addition) -> bool {
    is_sensor(addition.port)
}

fn follows_another_node(addition: &Addition) -> bool {
    let other = match addition.port {
        Port::HousingHeat | Port::HousingAmbientConductance | Port::HeatCapacity | Port::HousingSensor => {
            Driver::WindingTemperature
        }
        Port::WindingHeat | Port::WindingResistance | Port::WindingSensor => Driver::HousingTemperature,
        _ => return false,
    };
    addition.follows == Follows::Driver(other)
}

fn is_sensor(port: Port) -> bool {
    matches!(port, Port::AmbientSensor | Port::WindingSensor | Port::HousingSensor | Port::TorqueSensor)
}

/// Of the laws at the port and over the driver of the `k`-th candidate, the one that predicts best what was not fitted. A power goes
/// on where a table is held: a table has to be clearly better.
fn best_predicting(point: &Linearization, candidates: &mut [Candidate], k: usize) -> usize {
    let place = |c: &Candidate| (c.addition().port, c.addition().follows);
    if candidates[k].addition().is_listed() {
        return match law_ahead(point, candidates, k) {
            Some(law) => best_predicting(point, candidates, law),
            None => k,
        };
    }
    let worth =
        |c: &Candidate| c.validation.unwrap_or(1.0) * if c.addition().is_table() { CLEARLY } else { 1.0 };
    let mut best = k;
    for other in 0..candidates.len() {
        let apart = candidates[k].sure() - candidates[other].sure();
        let near = apart.abs() <= PREDICTING.0.max(PREDICTING.1 * candidates[k].sure().abs());
        let same = place(&candidates[other]) == place(&candidates[k]);
        let own = &candidates[other];
        if other == k || !same || !near || own.refused.is_some() || own.addition().is_listed() {
            continue;
        }
        let Ok((validation, None)) = gate(point, &candidates[other]) else { continue };
        candidates[other].validation = validation;
        if worth(&candidates[other]) < worth(&candidates[best]) {
            best = other;
        }
    }
    best
}

/// An effect of the list stands for a law that explains hardly more, but not for one at its port that also predicts far better.
fn law_ahead(point: &Linearization, candidates: &mut [Candidate], k: usize) -> Option<usize> {
    let own = &candidates[k];
    let (port, sure, foretold) = (own.addition().port, own.sure(), own.validation?);
    let explains_more = |c: &Candidate| {
        c.refused.is_none() && !c.addition().is_listed() && c.addition().port == port && c.sure() > sure
    };
    let law = candidates.iter().position(explains_more)?;
    let (validation, refused) = gate(point, &candidates[law]).ok()?;
    (candidates[law].validation, candidates[law].refused) = (validation, refused);
    let ahead = candidates[law].refused.is_none() && validation? < AHEAD * foretold;
    ahead.then_some(law)
}

/// The most promising of each kind, of different effects, ports or drivers: first by what is sure, then by what explains
/// most if no sensor drifts. Where a large effect has led the parameters astray, one of both misleads.
fn choose(scored: &[Scored]) -> Vec<&Scored> {
    let mut chosen: Vec<&Scored> = Vec::new();
    let surest = scored.iter().map(Scored::sure).fold(0.0, f64::max);
    for (quota, worth) in [(CANDIDATES, Scored::sure as fn(&Scored) -> f64), (FURTHER, |s: &Scored| s.raw)] {
        let mut order: Vec<&Scored> =
            scored.iter().filter(|s| s.addition.is_some() && worth(s) > 0.0).collect();
        order.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let best = scored.iter().map(worth).fold(0.0, f64::max);
        let mut taken = [0; 4];
        for candidate in order {
            let Some(addition) = &candidate.addition else { continue };
            let k = addition.kind();
            let names = chosen.iter().filter(|c| c.name == candidate.name).count();
            // An effect may act in other runs than was thought at first.
            let twice = names > usize::from(k == 0 && candidate.name.ends_with("some runs"));
            let far = (worth(candidate) < 0.3 * best && taken[k] >= 1)
                || (addition.is_store() && candidate.sure() < STORED * surest);
            if taken[k] < quota[k] && !far {
                taken[k] += 1;
                if !twice && !chosen.iter().any(|c| std::ptr::eq(*c, candidate)) {
                    chosen.push(candidate);
                }
            }
        }
    }
    chosen
}

/// The point's numbers with a further addition, where its fit begins.
fn initial_guess(setup: &Setup, start: &Hypothesis, addition: &Addition) -> Hypothesis {
    let mut hypothesis = start.clone();
    // A parameter that stands in for the effect is far off; from there the way back is long, or there is none.
    for (value, declared) in hypothesis.declared.iter_mut().zip(&setup.declared) {
        if declared.astray(*value) {
            *value = declared.prior;
        }
    }
    hypothesis.additions.push(addition.clone());
    hypothesis
}

fn fitted<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &Scored,
) -> Result<Candidate<'a>, CalibrateError> {
    let Some(addition) = &scored.addition else {
        return Err(CalibrateError(format!("{} cannot be added", scored.name)));
    };
    let setup = point.setup;
    let fitted = setup.fit(initial_guess(setup, start, addition), &point.runs)?;
    let larger = Linearization::judged(setup, fitted, &point.runs)?;
    let cost = point.per_number() * addition.price() + if addition.is_listed() { 0.0 } else { choice() };
    let of_runs =
        if addition.active.iter().all(|on| *on) { 0.0 } else { 2.0 * point.runs.len() as f64 * 2f64.ln() };
    let (before, after) = (point.evidence.cost(), larger.evidence.cost());
    let delta = (before.0 - after.0 - cost - of_runs, before.1 - after.1 - cost - of_runs);
    Ok(Candidate { name: scored.name.clone(), point: larger, delta, validation: None, refused: None })
}

/// A number of an addition that stands at a limit, in one sentence.
fn at_limit(addition: &Addition) -> Option<String> {
    let stuck = addition.numbers.iter().find(|number| {
        let (least, most) = number.limits;
        (number.value <= least && least != 0.0) || number.value >= most
    })?;
    Some(format!("{} = {:.4} stands at its limit", stuck.symbol, stuck.value))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A candidate that could not be fitted is listed with the reason.
    #[test]
    fn a_failed_candidate_is_listed() {
        let scored = Scored {
            addition: None,
            name: "drag_torque over speed".to_string(),
            port: Port::DragTorque,
            follows: Follows::Driver(Driver::Speed),
            listed: false,
            evidence: 80.0,
            raw: 90.0,
            shape: Vec::new(),
        };
        let failed = vec![(scored, CalibrateError("the step size is too small".to_string()))];
        let round = Round { candidates: Vec::new(), taken: None, excuse: None, alike: Vec::new(), failed };
        let candidate_table = round.candidate_table(2);
        assert_eq!(
            (candidate_table.len(), candidate_table[0].round, candidate_table[0].delta_bic),
            (1, 2, 90.0)
        );
        assert!(
            !candidate_table[0].accepted && candidate_table[0].reason.ends_with("the step size is too small")
        );
    }
}
