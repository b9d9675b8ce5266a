//! Stepwise selection: forward rounds, and re-estimation of earlier additions.

use super::Search;
use crate::CalibrateError;
use crate::acting::acting;
use crate::experiment::Role;
use crate::hypothesis::Addition;
use crate::input_error::{self, Explained};
use crate::instruments;
use crate::levels::{LEAD, NEARLY};
use crate::linearization::Linearization;
use crate::outcome::{Follows, Unusable};
use crate::search::{Scored, best_memory_term, latent_input_at, needs_memory, search};
use crate::selection::{
    ALIKE, Candidate, LEAST, NEAR, Round, asked_for, beside, companion, compete, predicts_where_it_acts,
};
use physics::terms::MOST_TERMS;

/// Largest number of passes over all additions. Numerical: a pass without a change is the last.
const PASSES: usize = 2;

/// Fraction of the best score below which a candidate is not fitted again. Derivation: to replace an addition it would have to explain twice as
/// much as to first order, where all other parameters are at their optimum.
const HALF: f64 = 0.5;

impl<'a> Search<'a> {
    /// Candidates scored last.
    pub(super) fn left(&self) -> &[Scored] {
        self.scored.last().map_or(&[], Vec::as_slice)
    }

    /// Adds the best accepted candidate, round by round, until none is accepted or the limit of additions is reached.
    pub(super) fn rounds(&mut self, progress: &dyn Fn(f64, &str)) {
        while self.rounds.len() < MOST_TERMS {
            if self.setup.deadline().is_near() || self.left().first().is_none_or(|s| s.sure() <= LEAST) {
                break;
            }
            let round = compete(self.point(), &self.point().fitted.hypothesis, self.left(), &self.known);
            let taken = match round.promising().filter(|_| self.rounds.is_empty()) {
                Some(k) => self.together(round, k),
                None => self.two_instead(round),
            };
            if !taken {
                break;
            }
            let found = self.point().fitted.hypothesis.additions.last().map_or("", |a| &a.id).to_string();
            progress(0.3 + 0.1 * self.rounds.len() as f64, &format!("{found}; is there more?"));
            // A round tried jointly with another one is already scored.
            if self.scored.len() > self.rounds.len() {
                continue;
            }
            match self.look_on() {
                Ok(mut scored) => {
                    let accepted: Vec<&Candidate> = self.rounds.iter().filter_map(Round::winner).collect();
                    scored.retain(|s| !is_another_form(s, &accepted));
                    self.scored.push(scored);
                }
                Err(e) => {
                    self.notes
                        .push(format!("beyond what was found nothing further could be looked for: {e}"));
                    break;
                }
            }
        }
    }

    /// The instrument of an input whose error explains more than all additions do, and than any candidate by itself; in the validation
    /// runs, more than all additions do there and in the fit runs, or what these leave there alone.
    pub(super) fn error_of_an_input(&self) -> Result<Option<Unusable>, CalibrateError> {
        let best = |counts: &dyn Fn(&Scored) -> bool| {
            let all = self.scored[0].iter().filter(|s| s.addition.is_some() && counts(s));
            all.map(Scored::sure).fold(0.0, f64::max)
        };
        let (effects, laws): (Vec<&Candidate>, Vec<&Candidate>) =
            self.rounds.iter().filter_map(Round::winner).partition(|c| c.addition().is_listed());
        let found = Explained {
            all: self.explained().max(best(&|_| true)),
            listed: effects.into_iter().map(Candidate::sure).fold(best(&|s| s.listed), f64::max),
            laws: laws.len(),
        };
        let of_fit = input_error::places(&self.first.runs);
        let in_fit = input_error::explains(&self.first, &of_fit, found)?;
        let of_validation = input_error::places(&self.setup.runs(Role::Validate));
        if in_fit.is_some() || of_validation.is_empty() {
            return Ok(in_fit);
        }
        let all: Vec<usize> = self.first.runs.iter().chain(&of_validation[0]).copied().collect();
        let over = |point: &Linearization| -> Result<Linearization<'a>, CalibrateError> {
            let hypothesis = acting(self.setup, &point.fitted.hypothesis, &of_validation[0])?;
            Linearization::judged(self.setup, self.setup.judged(hypothesis, &all)?, &all)
        };
        // Of the fit and validation runs; a law as far as they reach.
        let (white, raw) = self.point().explains(&self.first);
        let whole = over(&self.first)?;
        let jointly = self.joint.as_ref().map(|joint| joint.point.explains(&whole));
        let all = jointly.map_or(white.min(raw), |(joint, plain)| joint.min(plain).max(white.min(raw)));
        let found = Explained { all, listed: all, laws: 0 };
        let instead = input_error::explains(&whole, &of_validation, found)?;
        let is_whole = || instruments::explain_rest(self.setup, &self.point().fitted, &[Role::Fit]);
        if instead.is_some() || self.taken().is_none() || !is_whole()? {
            return Ok(instead);
        }
        match &self.joint {
            Some(joint) => input_error::explains(&joint.point, &of_validation, Explained::default()),
            None => input_error::explains(&over(self.point())?, &of_validation, Explained::default()),
        }
    }

    /// Decrease of the cost by all additions together, less the price of their numbers.
    fn explained(&self) -> f64 {
        let (white, raw) = self.point().explains(&self.first);
        let prices = self.point().fitted.hypothesis.additions.iter().map(|own| self.setup.price(own));
        white.min(raw) - self.first.per_number() * prices.sum::<f64>()
    }

    /// Appends a round; returns whether it has an accepted candidate.
    fn push(&mut self, round: Round<'a>) -> bool {
        let is_taken = round.taken.is_some();
        self.rounds.push(round);
        is_taken
    }

    /// Scores the candidate additions to the current model.
    fn look_on(&self) -> Result<Vec<Scored>, CalibrateError> {
        Ok(search(&Linearization::new(self.setup, self.point().fitted.clone(), &self.first.runs)?))
    }

    /// Tests a candidate with high evidence and a worse validation error jointly with a second addition. It is accepted if both
    /// together reduce the validation error. It is also accepted if no residual remains in the fit runs and the outputs that it acts on
    /// are predicted better: the other outputs then contain an unmodelled effect. Otherwise the round stays as it is. Returns whether it
    /// has an accepted candidate.
    fn together(&mut self, round: Round<'a>, k: usize) -> bool {
        // A candidate that cannot be linearised is refused.
        let Ok(point) =
            Linearization::new(self.setup, round.candidates[k].point.fitted.clone(), &self.first.runs)
        else {
            return self.push(round);
        };
        let scored = search(&point);
        let alone = scored.first().is_none_or(|s| s.sure() <= LEAST);
        if alone && predicts_where_it_acts(self.point(), &round.candidates[k]).unwrap_or(false) {
            let excuse = "explains all there is; the outputs in which it shows are predicted better, the others meet something new";
            self.rounds.push(round.with_taken(k, excuse));
            self.scored.push(scored);
            return true;
        }
        let first = &round.candidates[k].point;
        let second = companion(first, &first.fitted.hypothesis, &scored, &self.known);
        if !second.passes_beside(self.point(), &round.candidates[k]) {
            return self.push(round);
        }
        self.rounds.push(round.with_taken(
            k,
            "has the largest evidence; together with the next addition it meets the acceptance criteria",
        ));
        self.scored.push(scored);
        self.rounds.push(second);
        true
    }

    /// A law may stand in for two effects. If a physical element that may be its part, together with what is then found, explains as much, both
    /// are accepted instead: they say more, and continue beyond the data. Returns whether the round has an accepted candidate.
    fn two_instead(&mut self, round: Round<'a>) -> bool {
        let law = round.winner().map(Candidate::sure).filter(|_| self.rounds.len() + 1 < MOST_TERMS);
        let Some((k, law)) = round.part.zip(law) else { return self.push(round) };
        let part = &round.candidates[k];
        let scored = Linearization::new(self.setup, part.point.fitted.clone(), &self.first.runs);
        // Otherwise the law stands.
        let Ok(scored) = scored.map(|point| search(&point)) else { return self.push(round) };
        let least = law - ALIKE - part.sure();
        let second = beside(&part.point, &part.point.fitted.hypothesis, &scored, &self.known, least);
        if second.taken.is_none() {
            return self.push(round);
        }
        self.rounds.push(round.with_taken(k, "together with what comes next it explains as much as a law"));
        self.scored.push(scored);
        self.rounds.push(second);
        true
    }

    /// Selects a memory term if it explains more of the naive fit's residual than laws of present values do, and the accepted additions
    /// explain clearly less or leave a large residual: they were substitutes for it. Returns whether it was selected.
    pub(super) fn remember(&mut self) -> bool {
        let rest = self.left().first().is_some_and(|s| s.follows == Follows::History && s.sure() > LEAD);
        if !needs_memory(&self.scored[0]) || !(rest || self.history().is_some()) {
            return false;
        }
        let Some(known) = best_memory_term(&self.scored[0]) else { return false };
        self.remembered = Some(latent_input_at(&self.scored[0], known.port).unwrap_or(known).clone());
        // A law with a better validation error is kept even if a residual remains.
        if !self.has_law() {
            for (k, round) in self.rounds.drain(..).enumerate() {
                let round = round.without_taken("stood in for what knows its past, and leaves much of it");
                self.refused.extend(round.candidate_table(k + 1));
            }
        }
        true
    }

    /// Selects each addition again, given the other additions and the current parameters. The linearization there is accurate, while the
    /// naive fit may have been far off. A first choice that was a substitute for two effects is replaced.
    pub(super) fn search_again(&mut self, progress: &dyn Fn(f64, &str)) -> Result<(), CalibrateError> {
        // Rounds without an accepted candidate are removed.
        let taken = self.rounds.iter().filter(|r| r.taken.is_some()).count();
        for (k, round) in self.rounds.drain(taken..).enumerate() {
            self.refused.extend(round.candidate_table(taken + k + 1));
        }
        let count = self.rounds.len();
        let listed = self.taken().is_some_and(|c| c.addition().is_listed());
        if self.setup.deadline().is_near()
            || count == 0
            || (count == 1 && listed && (!self.astray() || self.clear()))
        {
            return Ok(());
        }
        // A probable memory term gets one pass only.
        let passes = if self.history().is_some() { 1 } else { PASSES };
        for pass in 0..passes {
            let mut changed = false;
            for k in 0..self.rounds.len() {
                if self.setup.deadline().is_near() {
                    return Ok(());
                }
                let share = (pass * count + k) as f64 / (passes * count) as f64;
                progress(0.6 + 0.2 * share, "looking again");
                changed |= self.look_at_the_first_again()?;
            }
            // A change of one addition can change the best choice of the others.
            if !changed || self.rounds.len() < 2 {
                break;
            }
        }
        Ok(())
    }

    /// Selects the first addition again, given all others. It moves to the end, or is replaced by a better candidate, or is removed.
    /// Returns whether it changed.
    fn look_at_the_first_again(&mut self) -> Result<bool, CalibrateError> {
        let runs = self.first.runs.clone();
        let mut others = self.point().fitted.hypothesis.clone();
        let own = others.additions.remove(0);
        let refit = if others.additions.is_empty() {
            self.first.fitted.clone()
        } else {
            self.setup.fit(others.clone(), &runs)?
        };
        let without = Linearization::judged(self.setup, refit, &runs)?;
        // If the others explain the residual without it, the first choice was a substitute for them: it would not be added to them.
        let (white, raw) = self.point().explains(&without);
        let fall = white.min(raw);
        if self.rounds.len() > 1 && fall < asked_for(&without, self.point(), &own) {
            self.rounds.remove(0);
            if let Some(last) = self.rounds.pop() {
                self.rounds.push(last.with_point(without));
            }
            return Ok(true);
        }
        let stripped = Linearization::new(self.setup, self.setup.judged(others.clone(), &runs)?, &runs)?;
        // Here the scores to first order are accurate: what explains far less is not fitted again.
        let mut scored = search(&stripped);
        let least = HALF * scored.iter().map(Scored::sure).fold(0.0, f64::max);
        // The addition itself is fitted in any case, so that what replaces it is compared with it.
        let is_own = |s: &Scored| {
            s.addition
                .as_ref()
                .is_some_and(|a| (&a.id, a.port, a.follows) == (&own.id, own.port, own.follows))
        };
        scored.retain(|s| s.sure() > least || is_own(s));
        let round = compete(&without, &others, &scored, &self.known);
        let is_as_good = |c: &&Candidate| self.point().explains(&c.point).0 < LEAST;
        if let Some(winner) = round.winner().filter(is_as_good) {
            let same = (&winner.addition().id, winner.addition().port) == (&own.id, own.port);
            self.rounds.remove(0);
            self.two_instead(round);
            return Ok(!same);
        }
        // The addition is kept, in last position.
        let mut kept = others;
        kept.additions.push(own);
        let point = Linearization::judged(self.setup, self.setup.judged(kept, &runs)?, &runs)?;
        // Removed only here: if the deadline passes earlier, the rounds still match the model.
        let old = self.rounds.remove(0);
        self.rounds.push(old.with_point(point));
        Ok(false)
    }

    /// Two listed effects at one port with the same driver may be substitutes for a single law: a power law that explains as much has
    /// fewer parameters and is preferred.
    pub(super) fn one_law(&mut self) -> Result<(), CalibrateError> {
        let Some(point) = self.taken().map(|c| &c.point) else { return Ok(()) };
        let additions = &point.fitted.hypothesis.additions;
        let place = |a: &Addition| (a.port, a.follows);
        let twice = |a: &&Addition| {
            a.is_listed() && additions.iter().filter(|b| b.is_listed() && place(b) == place(a)).count() > 1
        };
        let Some(at) = additions.iter().find(twice).map(place) else { return Ok(()) };
        let mut others = point.fitted.hypothesis.clone();
        others.additions.retain(|a| place(a) != at);
        let runs = self.first.runs.clone();
        let refit = self.setup.fit(others.clone(), &runs)?;
        let scored = search(&Linearization::new(self.setup, refit.clone(), &runs)?);
        let without = Linearization::judged(self.setup, refit, &runs)?;
        let is_power = |s: &&Scored| {
            s.addition.as_ref().is_some_and(|a| place(a) == at && !a.is_listed() && !a.is_table())
        };
        let powers: Vec<Scored> = scored.iter().filter(is_power).cloned().collect();
        let round = compete(&without, &others, &powers, &self.known);
        if round.winner().is_some_and(|c| point.explains(&c.point).0 < NEAR) {
            self.rounds.retain(|round| round.winner().is_some_and(|c| place(c.addition()) != at));
            self.rounds.push(round);
        }
        Ok(())
    }

    /// Whether the first candidate clearly leads all candidates at other ports.
    fn clear(&self) -> bool {
        let Some((round, best)) = self.rounds.first().and_then(|r| Some((r, r.winner()?))) else {
            return false;
        };
        let elsewhere = round.candidates.iter().filter(|c| c.addition().port != best.addition().port);
        elsewhere.map(Candidate::sure).fold(0.0, f64::max) < NEARLY * best.sure()
    }

    /// Whether a parameter of the naive fit deviates so far from its prior that it compensates for another effect.
    fn astray(&self) -> bool {
        let declared = self.setup.declared.iter().zip(&self.first.fitted.hypothesis.declared);
        declared.into_iter().any(|(d, value)| d.astray(*value))
    }
}

/// Whether a candidate is a law over the driver of an accepted listed effect, at its port, that adds little to what the effect explains:
/// then it is another form of the effect, as the structure error leaves one, and no second effect.
fn is_another_form(scored: &Scored, accepted: &[&Candidate]) -> bool {
    let same = |a: &Addition| a.is_listed() && (a.port, a.follows) == (scored.port, scored.follows);
    let adds_little = |c: &Candidate| scored.sure() < (1.0 - NEARLY) * c.sure();
    !scored.listed && accepted.iter().any(|c| same(c.addition()) && adds_little(c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Setup;
    use crate::testing;
    use physics::terms::{Driver, Port};

    #[test]
    fn a_law_that_adds_little_to_a_listed_effect_is_another_form_of_it() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let windage = testing::candidate(&setup, testing::addition(&setup, "windage", 1e-8), 3000.0);
        let law = testing::law(windage.addition().port, windage.addition().follows);
        let of = |addition: &Addition, evidence: f64, listed: bool| Scored {
            addition: Some(addition.clone()),
            name: String::new(),
            port: addition.port,
            follows: addition.follows,
            listed,
            evidence,
            raw: 2.0 * evidence,
            shape: Vec::new(),
        };
        assert!(is_another_form(&of(&law, 150.0, false), &[&windage]));
        // It explains more than structure error leaves; another driver, another port; a listed effect; beside a law.
        assert!(!is_another_form(&of(&law, 350.0, false), &[&windage]));
        let over_current = testing::law(law.port, Follows::Driver(Driver::Current));
        let elsewhere = testing::law(Port::HousingHeat, law.follows);
        assert!(!is_another_form(&of(&over_current, 150.0, false), &[&windage]));
        assert!(!is_another_form(&of(&elsewhere, 150.0, false), &[&windage]));
        assert!(!is_another_form(&of(&law, 150.0, true), &[&windage]));
        let first = testing::candidate(&setup, law.clone(), 3000.0);
        assert!(!is_another_form(&of(&law, 150.0, false), &[&first]));
    }
}
