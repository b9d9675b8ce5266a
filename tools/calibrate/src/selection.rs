//! Stepwise selection of one further effect at a time: the best candidates are fitted jointly with all other parameters, compared, and
//! subjected to the acceptance tests.
//!
//! cost = -2 log p + ln n for each parameter, n the number of blocks (Schwarz, Annals of Statistics 6 (1978) 461-464)     (1)
//!
//! p is that of the fit runs and the validation runs; parameters are fitted to the fit runs alone.
//! The acceptance tests, in this order: (1) decreases by more than 100, or than 10 if an effect is larger than structure error, or than 48 if
//! it is listed and predicts the validation runs better by 10 and no output of them worse, both for white and for autocorrelated noise; sign
//! and size are physical and no parameter reaches a limit; all runs agree on the size; -2 log p of the validation runs given the fit runs
//! decreases. With the cost alone, effects would be found on every bench with drifting thermocouples.

mod companion;
mod fitted;
mod gate;
mod instead;
mod known;
mod preference;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::comparison::with_unit;
use crate::hypothesis::{Addition, Hypothesis};
use crate::levels::{DECISIVE, NEARLY, SAMPLES};
use crate::linearization::Linearization;
use crate::outcome::{Evidence, Follows};
use crate::parallel;
use crate::search::{IN_SOME_RUNS, Scored, choice, variants};
use crate::setup::BLOCKS;
pub use companion::{beside, companion};
use fitted::fitted;
use gate::{Judged, enough, gate, implausible, predicts_less};
pub use gate::{asked, asked_for, predicts_where_it_acts};
use instead::listed_instead;
pub use known::Known;
use preference::{
    best_prediction_first, is_element_of, is_part, law_elsewhere, listed_first, one_driver_first,
    order_by_likelihood,
};

/// Reduction of the cost required for a term: very strong evidence. Source: Kass, Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795, sec.
/// 3.2.
pub const LEAST: f64 = 10.0;
/// Costs that differ by less cannot be distinguished; a lower validation cost must differ by as much: strong evidence. Source: as for
/// [`LEAST`].
pub const NEAR: f64 = 6.0;
/// Weight of the evidence of a block in posterior probabilities. Source: Gruenwald, van Ommen, Bayesian Analysis 12 (2017) 1069-1103, a power of
/// the likelihood of a model that is not exact; here the independent readings for each block.
const TEMPER: f64 = SAMPLES / BLOCKS as f64;
/// Difference of the cost within which two explanations cannot be distinguished. Derivation: [`NEAR`] for a likelihood to the power
/// [`TEMPER`].
pub const ALIKE: f64 = NEAR / TEMPER;
/// Numbers of candidates with distinct names: effects of the list, power laws, shapes, laws with a lag, shapes over two
/// drivers, masses. Numerical: a limit of effort; the others explain less to first order.
const CANDIDATES: [usize; 6] = [6, 2, 2, 2, 2, 2];
/// Numbers of additional candidates, ranked by the other measure. Numerical: as for [`CANDIDATES`].
const FURTHER: [usize; 6] = [3, 1, 1, 1, 1, 1];
/// Fraction of the best evidence to first order below which a candidate is not fitted. Numerical: a limit of effort; of 178 candidates that
/// were accepted in 120 development sets of the blind suite, none was below.
const BEHIND: f64 = 0.3;

/// Fraction of the time that is left in which the fits of a round start. Definition: half, since a candidate that passes is fitted again to
/// each run.
const FITS: f64 = 0.5;

/// Fitted candidate.
pub struct Candidate<'a> {
    /// Description.
    pub name: String,
    /// Complete model with the candidate, linearised after the fit.
    pub point: Linearization<'a>,
    /// Reduction of (1) for autocorrelated noise, and for white noise.
    pub delta: (f64, f64),
    /// The part of the first beyond the fit runs; `None` without validation runs.
    pub delta_validation: Option<f64>,
    /// Ratio of validation error with it to validation error without it; `None` without validation data.
    pub validation: Option<f64>,
    /// Reason for rejection, in one sentence.
    pub refused: Option<String>,
}

impl Candidate<'_> {
    /// Applies the acceptance tests; one that cannot be simulated in the validation runs is rejected. Result: whether it passes.
    fn judge(&mut self, before: &Linearization) -> bool {
        let usual = asked(before, &self.point);
        let asked = enough(usual, self.addition(), self.delta_validation);
        let judged = self.judged_for(before, asked);
        if self.refused.is_none() && self.sure() <= usual {
            self.refused = predicts_less(before, &judged);
        }
        self.refused.is_none()
    }

    /// The same with this decrease of the cost asked for.
    fn judge_for(&mut self, before: &Linearization, asked: f64) -> bool {
        self.judged_for(before, asked).refused.is_none()
    }

    fn judged_for(&mut self, before: &Linearization, asked: f64) -> Judged {
        let judged =
            gate(before, self, asked).unwrap_or_else(|e| Judged::refused(format!("cannot be judged: {e}")));
        (self.validation, self.refused) = (judged.validation, judged.refused.clone());
        judged
    }

    /// Evidence under the less favourable of the two noise models.
    pub fn sure(&self) -> f64 {
        self.delta.0.min(self.delta.1)
    }

    /// Whether it depends on at most one driver, without a lag or a history.
    pub fn is_simple(&self) -> bool {
        matches!(self.addition().follows, Follows::Nothing | Follows::Driver(_))
    }

    /// The addition to the model.
    pub fn addition(&self) -> &Addition {
        let additions = &self.point.fitted.hypothesis.additions;
        &additions[additions.len() - 1]
    }
}

/// Why a candidate comes before one that explains more.
const PREFERENCE: &str =
    "it is more specific, predicts better, or explains as much together with the other effects";

/// Result of one round of the selection.
pub struct Round<'a> {
    /// All fitted candidates, best first.
    pub candidates: Vec<Candidate<'a>>,
    /// Index of the accepted candidate.
    pub taken: Option<usize>,
    /// Reason for accepting it although it fails an acceptance test.
    excuse: Option<&'static str>,
    /// Candidates that the data cannot distinguish from it.
    pub alike: Vec<usize>,
    /// A listed effect that also passes and may be a part of the accepted law: [`preference::is_element_of`].
    pub part: Option<usize>,
    /// Candidates that could not be fitted, with the reason.
    failed: Vec<(Scored, CalibrateError)>,
}

impl<'a> Round<'a> {
    /// The accepted candidate.
    pub fn winner(&self) -> Option<&Candidate<'a>> {
        self.taken.map(|taken| &self.candidates[taken])
    }

    /// The candidate that explains most but has a greater validation error, if it explains a lot: another missing effect may cause the
    /// validation error. A law that was accepted may stand in for both, if the candidate is an effect of the list, and is at its port or
    /// explains clearly more.
    pub fn promising(&self) -> Option<usize> {
        let first = self.candidates.iter().position(|c| at_limit(c.addition()).is_none())?;
        let best = &self.candidates[first];
        let predicts_worse = best.validation.is_some_and(|ratio| ratio >= 1.0) && best.refused.is_some();
        let is_behind = self.winner().is_none_or(|taken| {
            let (own, other) = (best.addition(), taken.addition());
            let is_ahead = own.port == other.port || taken.sure() < NEARLY * best.sure();
            own.is_listed() && !other.is_listed() && is_ahead
        });
        (predicts_worse && is_behind && best.sure() > DECISIVE).then_some(first)
    }

    /// The same round with a candidate accepted although it fails an acceptance test, with the reason.
    pub fn with_taken(mut self, k: usize, excuse: &'static str) -> Round<'a> {
        self.candidates[k].refused = None;
        self.taken = Some(k);
        self.excuse = Some(excuse);
        self
    }

    /// The same round without an accepted candidate, with the reason for rejecting it.
    pub fn without_taken(mut self, reason: &str) -> Round<'a> {
        if let Some(k) = self.taken.take() {
            self.candidates[k].refused = Some(reason.to_string());
        }
        self
    }

    /// Whether the accepted candidate, together with the one before it, passes the acceptance tests relative to the model without both.
    pub fn passes_beside(&self, point: &Linearization, first: &Candidate) -> bool {
        let rest = |both: &Candidate| asked(point, &both.point) - first.sure();
        self.winner().is_some_and(|c| gate(point, c, rest(c)).is_ok_and(|judged| judged.refused.is_none()))
    }

    /// The same round with another linearization for the accepted candidate.
    pub fn with_point(mut self, point: Linearization<'a>) -> Round<'a> {
        if let Some(taken) = self.taken {
            self.candidates[taken].point = point;
        }
        self
    }

    /// Posterior probability of a model with this reduction of the cost, among the candidates of the round and the model without any.
    fn probability(&self, delta: f64) -> f64 {
        let failed = self.failed.iter().map(|(scored, _)| scored.evidence);
        let all = self.candidates.iter().map(|c| c.delta.0).chain(failed).chain([0.0]);
        shares(&all.collect::<Vec<_>>())(delta)
    }

    /// Why a candidate without an excuse was accepted.
    fn reason_of(&self, taken: &Candidate) -> String {
        let is_most = self.candidates.iter().all(|c| c.refused.is_some() || c.sure() <= taken.sure());
        if is_most {
            "has the largest evidence and meets the acceptance criteria".to_string()
        } else {
            format!(
                "is preferred to candidates with more evidence: {PREFERENCE}; it meets the acceptance criteria"
            )
        }
    }

    /// Candidate table of the round for the report.
    pub fn candidate_table(&self, round: usize) -> Vec<Evidence> {
        let best = self.winner().map(|c| c.name.clone());
        let failed = self.failed.iter().map(|(scored, error)| Evidence {
            round,
            name: scored.name.clone(),
            port: scored.port,
            delta_bic: scored.raw,
            delta_bic_whitened: scored.evidence,
            delta_validation: None,
            probability: self.probability(scored.evidence),
            validation_ratio: None,
            accepted: false,
            reason: format!("could not be fitted, BIC to first order: {error}"),
        });
        let candidates = self.candidates.iter().enumerate().map(|(k, c)| {
            let reason = match (&c.refused, &best) {
                (_, Some(best)) if self.alike.contains(&k) => {
                    format!("explains as much as {best}: this data cannot tell them apart")
                }
                (Some(refused), _) => refused.clone(),
                (None, _) if self.taken == Some(k) => {
                    self.excuse.map_or_else(|| self.reason_of(c), str::to_string)
                }
                (None, Some(best)) if self.winner().is_some_and(|taken| taken.sure() < c.sure()) => {
                    format!("{best} is preferred: {PREFERENCE}")
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
                delta_validation: c.delta_validation,
                probability: self.probability(c.delta.0),
                validation_ratio: c.validation,
                accepted: self.taken == Some(k),
                reason,
            }
        });
        candidates.chain(failed).collect()
    }
}

/// Posterior probability of a model by its reduction of the cost, among models with these reductions that are equally probable before:
/// exp(-cost / 2) approximates the marginal likelihood, here to the power [`TEMPER`].
///
/// *Source*: Kass, Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795, sec. 4.1.3.
pub fn shares(deltas: &[f64]) -> impl Fn(f64) -> f64 + use<> {
    let most = deltas.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weight = move |delta: f64| (0.5 * TEMPER * (delta - most)).exp();
    let sum: f64 = deltas.iter().map(|delta| weight(*delta)).sum();
    move |delta| weight(delta) / sum
}

/// The candidates of a round, fitted.
fn candidates<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
) -> Round<'a> {
    let is_first = start.additions.is_empty();
    let chosen = choose(scored, is_first).into_iter().filter(|scored| !repeats(start, scored));
    let chosen: Vec<&Scored> = chosen.collect();
    // The best to first order come first. A fit that nothing judges is of no use.
    let until = point.setup.deadline().share(FITS);
    let of = |scored: &&Scored| match until.is_near() {
        true => Err(CalibrateError("the time budget is kept for judging the others".to_string())),
        false => fitted(point, start, scored, known),
    };
    let fitted = parallel::in_turn(&chosen, of);
    let (mut candidates, mut failed) = (Vec::new(), Vec::new());
    for (result, scored) in fitted.into_iter().zip(chosen) {
        match result {
            Ok(candidate) => candidates.push(candidate),
            Err(error) => failed.push((scored.clone(), error)),
        }
    }
    candidates.sort_by(|a, b| b.sure().total_cmp(&a.sure()));
    for candidate in &mut candidates {
        candidate.refused = at_limit(candidate.addition());
    }
    Round { candidates, taken: None, excuse: None, alike: Vec::new(), part: None, failed }
}

/// Releases the linearizations of all candidates but these.
fn release(candidates: &mut [Candidate], kept: &[Option<usize>]) {
    let rest = candidates.iter_mut().enumerate().filter(|(k, _)| !kept.contains(&Some(*k)));
    rest.for_each(|(_, candidate)| candidate.point.release());
}

/// Fits and compares the best candidates scored at `point`, the model without any of them; their fits start at `start`. A candidate
/// with which the model cannot be run is listed with the reason. If the best one is no physical explanation, those that explain far less to
/// first order take its place.
pub fn compete<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
) -> Round<'a> {
    let (mut round, is_out) = among(point, start, scored, known);
    if is_out {
        let rest: Vec<Scored> = scored.iter().filter(|s| !round.has_tried(s)).cloned().collect();
        let (second, _) = among(point, start, &rest, known);
        let first = std::mem::replace(&mut round, second);
        round.candidates.extend(first.candidates);
        round.failed.extend(first.failed);
    }
    listed_instead(point, start, scored, known, round)
}

/// The same among these alone; and whether the best one explains enough, but is no physical explanation.
fn among<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
) -> (Round<'a>, bool) {
    let Round { mut candidates, failed, .. } = candidates(point, start, scored, known);
    // Preferred are a listed effect to a law that explains little more, and a law of one driver to one of two or with an additional state.
    let mut order: Vec<usize> = (0..candidates.len()).filter(|k| candidates[*k].refused.is_none()).collect();
    best_prediction_first(&candidates, &mut order);
    one_driver_first(&candidates, &mut order);
    if let Some(best) = order.first().map(|k| &candidates[*k]) {
        // A second driver is a further addition: it has to explain as much as one, and not only what is left by nearly the same law.
        let is_enough = |c: &Candidate| {
            let (own, whole) = (c.addition(), best.addition());
            let less = best.sure() - c.sure();
            let nearly = c.sure() > NEARLY * best.sure();
            less < ALIKE
                || (nearly && own.is_listed() && own.port == whole.port)
                || (is_part(own, whole) && (nearly || less < asked(&c.point, &best.point)))
        };
        let stands = |c: &Candidate| {
            (c.addition().is_listed() || (!best.is_simple() && c.is_simple())) && is_enough(c)
        };
        let rank = |c: &Candidate| match (stands(c), c.addition().is_listed()) {
            (true, true) => 0,
            (true, false) => 1,
            (false, _) => 2,
        };
        order.sort_by_key(|k| rank(&candidates[*k]));
        order_by_likelihood(&candidates, &mut order);
        listed_first(&candidates, &mut order);
    }
    let taken = order.into_iter().find(|k| candidates[*k].judge(point));
    let taken = taken.map(|t| law_elsewhere(&mut candidates, t, |c| c.judge(point)).unwrap_or(t));
    let alike = taken.map_or_else(Vec::new, |t| self::alike(point, &candidates, t));
    let part = taken.and_then(|t| {
        let law = candidates[t].addition().clone();
        let is_part = |c: &Candidate| c.refused.is_none() && is_element_of(c.addition(), &law);
        candidates.iter_mut().position(|c| is_part(c) && c.judge(point))
    });
    let is_out = taken.is_none()
        && candidates.first().is_some_and(|best| {
            best.sure() > asked(point, &best.point) && implausible(point, best).is_some()
        });
    let first = candidates.iter().position(|c| at_limit(c.addition()).is_none());
    release(&mut candidates, &[taken, first, part]);
    (Round { candidates, taken, excuse: None, alike, part, failed }, is_out)
}

/// Listed effects that the data cannot distinguish from an accepted listed effect, also if they alone would not be accepted.
fn alike(point: &Linearization, candidates: &[Candidate], taken: usize) -> Vec<usize> {
    let own = &candidates[taken];
    let is_rival = |k: &usize| {
        let other = &candidates[*k];
        *k != taken
            && other.addition().is_listed()
            && other.sure() > own.sure() - ALIKE
            && implausible(point, other).is_none()
    };
    let all = if own.addition().is_listed() { candidates.len() } else { 0 };
    (0..all).filter(is_rival).collect()
}

/// Whether a law of the hypothesis is over the same driver at the same port: a second table only moves the values of the first, and neither is
/// then determined. Two lags of a driver have a time constant each.
fn repeats(hypothesis: &Hypothesis, scored: &Scored) -> bool {
    let same = |a: &Addition| !a.is_listed() && a.port == scored.port && a.follows == scored.follows;
    let is_present = matches!(scored.follows, Follows::Driver(_));
    !scored.listed && is_present && hypothesis.additions.iter().any(same)
}

/// The most promising candidates of each kind, with distinct effects, ports or drivers: ranked by evidence under both noise models, then
/// for a first addition by evidence for white noise, which assumes no sensor drift. If a large missing effect biases the parameters, one of the
/// rankings is misleading; beside an addition they are near their optimum. If all of them are at one port, the best one elsewhere follows.
fn choose(scored: &[Scored], is_first: bool) -> Vec<&Scored> {
    let mut chosen: Vec<&Scored> = Vec::new();
    let rankings = [(CANDIDATES, Scored::sure as fn(&Scored) -> f64), (FURTHER, |s: &Scored| s.raw)];
    for (quota, worth) in rankings.into_iter().take(if is_first { 2 } else { 1 }) {
        let mut order: Vec<&Scored> =
            scored.iter().filter(|s| s.addition.is_some() && worth(s) > LEAST).collect();
        order.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let best = scored.iter().map(worth).fold(0.0, f64::max);
        let mut taken = [0; CANDIDATES.len()];
        for candidate in order {
            let Some(addition) = &candidate.addition else { continue };
            let k = addition.kind();
            let is_chosen = chosen.iter().any(|c| std::ptr::eq(*c, candidate));
            let names = chosen.iter().filter(|c| variants(&c.name) == variants(&candidate.name)).count();
            // An effect may act in other runs than first estimated, so two variants are allowed.
            let twice = names > usize::from(k == 0 && variants(&candidate.name).ends_with(IN_SOME_RUNS));
            let is_far = worth(candidate) < BEHIND * best;
            if taken[k] >= quota[k] || is_far || (twice && !is_chosen) {
                continue;
            }
            taken[k] += usize::from(is_chosen || names == 0);
            if !is_chosen {
                chosen.push(candidate);
            }
        }
    }
    // All of the best to first order may be at a port that the fits or the validation runs refuse.
    if let Some(port) = chosen.first().map(|first| first.port)
        && chosen.iter().all(|own| own.port == port)
    {
        let elsewhere = |s: &&Scored| s.port != port && s.addition.is_some() && s.sure() > LEAST;
        let others = scored.iter().filter(elsewhere);
        chosen.extend(others.max_by(|a, b| a.sure().total_cmp(&b.sure())));
    }
    // Whether the second driver of a law is needed is seen only beside the laws of one of them.
    let pair = chosen.iter().find(|s| matches!(s.follows, Follows::Both(..)));
    let parts: Vec<&Scored> = pair.map_or_else(Vec::new, |pair| {
        let of = |driver| {
            let is_part = |s: &&Scored| {
                s.port == pair.port
                    && s.follows == Follows::Driver(driver)
                    && !s.listed
                    && s.addition.is_some()
            };
            scored.iter().filter(is_part).max_by(|a, b| a.sure().total_cmp(&b.sure()))
        };
        pair.follows.drivers().filter_map(of).collect()
    });
    let is_new = |part: &&Scored| !chosen.iter().any(|c| std::ptr::eq(*c, *part));
    let parts: Vec<&Scored> = parts.into_iter().filter(is_new).collect();
    chosen.extend(parts);
    chosen
}

/// Sentence on a parameter of an addition that is at a limit.
pub fn at_limit(addition: &Addition) -> Option<String> {
    let stuck = addition.numbers.iter().find(|number| number.is_at_limit())?;
    Some(format!("{} = {} is at its limit", stuck.symbol, with_unit(stuck.value, stuck.unit)))
}
