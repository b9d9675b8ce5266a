//! What is looked for, round by round, and looked at again.

use super::{SAID, Search};
use crate::CalibrateError;
use crate::hypothesis::Addition;
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::search::{Scored, best_memory_term, latent_input_at, needs_memory, search};
use crate::selection::{Candidate, LEAST, NEAR, Round, compete, predicts_where_it_acts};
use physics::terms::MOST_TERMS;

/// Times that all that was found is looked at again, while it changes.
const PASSES: usize = 2;
/// Who explains less than this share of what the first does is far behind.
const AHEAD: f64 = 0.9;

impl<'a> Search<'a> {
    /// What was scored last.
    pub(super) fn left(&self) -> &[Scored] {
        self.scored.last().map_or(&[], Vec::as_slice)
    }

    /// Adds the best of what passes, round by round, until nothing does or there is no more room.
    pub(super) fn rounds(&mut self, progress: &dyn Fn(f64, &str)) {
        while self.rounds.len() < MOST_TERMS {
            if self.setup.deadline().is_near() || self.left().first().is_none_or(|s| s.sure() <= LEAST) {
                break;
            }
            let round = compete(self.point(), &self.point().fitted.hypothesis, self.left());
            let taken = match round.promising().filter(|_| self.rounds.is_empty()) {
                Some(k) => self.together(round, k),
                None => {
                    self.rounds.push(round);
                    self.rounds.last().is_some_and(|r| r.taken.is_some())
                }
            };
            if !taken {
                break;
            }
            let found = self.point().fitted.hypothesis.additions.last().map_or("", |a| &a.id).to_string();
            progress(0.3 + 0.1 * self.rounds.len() as f64, &format!("{found}; is there more?"));
            // What was tried together with another has been looked at.
            if self.scored.len() > self.rounds.len() {
                continue;
            }
            match self.look_on() {
                Ok(scored) => self.scored.push(scored),
                Err(e) => {
                    self.notes
                        .push(format!("beyond what was found nothing further could be looked for: {e}"));
                    break;
                }
            }
        }
    }

    /// What the model as it stands may lack.
    fn look_on(&self) -> Result<Vec<Scored>, CalibrateError> {
        Ok(search(&Linearization::new(self.setup, self.point().fitted.clone(), &self.first.runs)?))
    }

    /// A candidate that explains a lot and predicts worse, together with what else there is. It is taken where both predict better, and
    /// where nothing else shows in what was fitted but the outputs that it explains are predicted better: then the others meet something
    /// new. Whether it was taken.
    fn together(&mut self, round: Round<'a>, k: usize) -> bool {
        // One that cannot be looked at has not proved itself.
        let Ok(point) =
            Linearization::new(self.setup, round.candidates[k].point.fitted.clone(), &self.first.runs)
        else {
            self.rounds.push(round);
            return false;
        };
        let scored = search(&point);
        let alone = scored.first().is_none_or(|s| s.sure() <= LEAST);
        if alone && predicts_where_it_acts(self.point(), &round.candidates[k]).unwrap_or(false) {
            let excuse = "explains all there is; the outputs in which it shows are predicted better, the others meet something new";
            self.rounds.push(round.with_taken(k, excuse));
            self.scored.push(scored);
            return true;
        }
        let second = compete(&point, &point.fitted.hypothesis, &scored);
        if !second.passes_beside(self.point()) {
            self.rounds.push(round);
            return false;
        }
        self.rounds.push(
            round.with_taken(k, "explains most of all; together with what comes next it passes the gate"),
        );
        self.scored.push(scored);
        self.rounds.push(second);
        true
    }

    /// Where a force that knows its past explains more of the naive fit's residual than the present does, and what was taken does not come
    /// near it or leaves much of it: that stood in for it. Whether it is so.
    pub(super) fn remember(&mut self) -> bool {
        let rest = self.left().first().is_some_and(|s| s.follows == Follows::History && s.sure() > SAID);
        if !needs_memory(&self.scored[0]) || !(rest || self.history().is_some()) {
            return false;
        }
        let Some(known) = best_memory_term(&self.scored[0]) else { return false };
        self.remembered = Some(latent_input_at(&self.scored[0], known.port).unwrap_or(known).clone());
        // A law that predicts better stays, whatever remains unexplained beside it.
        if !self.has_law() {
            for (k, round) in self.rounds.drain(..).enumerate() {
                let round = round.without_taken("stood in for what knows its past, and leaves much of it");
                self.refused.extend(round.candidate_table(k + 1));
            }
        }
        true
    }

    /// Looks at each addition once more, from the others and the numbers that were found with it: there the slopes are those
    /// of the right neighbourhood, where the naive fit may have been far astray, and a first choice that had to stand for
    /// two effects gives way.
    pub(super) fn search_again(&mut self, progress: &dyn Fn(f64, &str)) -> Result<(), CalibrateError> {
        // A round that took nothing is the last.
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
        // What may well be a force that knows its past is not turned over and over.
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
            // Beside another effect, each may be another.
            if !changed || self.rounds.len() < 2 {
                break;
            }
        }
        Ok(())
    }

    /// Looks at the first addition once more, beside all others; it comes last, or what is better does, or none. Whether it is no
    /// longer what it was.
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
        let cost = |r: &Round| r.winner().map_or(f64::INFINITY, |c| c.point.evidence.cost().0);
        let whole = self.rounds.last().map_or(f64::INFINITY, cost);
        // What the others explain without it was a first choice that had to stand for them.
        if self.rounds.len() > 1 && without.evidence.cost().0 < whole + LEAST {
            self.rounds.remove(0);
            if let Some(last) = self.rounds.pop() {
                self.rounds.push(last.with_point(without));
            }
            return Ok(true);
        }
        let stripped = Linearization::new(self.setup, self.setup.judged(others.clone(), &runs)?, &runs)?;
        let round = compete(&without, &others, &search(&stripped));
        if let Some(winner) = round.winner().filter(|_| cost(&round) < whole + LEAST) {
            let same = (&winner.addition().id, winner.addition().port) == (&own.id, own.port);
            self.rounds.remove(0);
            self.rounds.push(round);
            return Ok(!same);
        }
        // It stays, last of all.
        let mut kept = others;
        kept.additions.push(own);
        let point = Linearization::judged(self.setup, self.setup.judged(kept, &runs)?, &runs)?;
        // Only now: where time ends before, the rounds stay those of the model.
        let old = self.rounds.remove(0);
        self.rounds.push(old.with_point(point));
        Ok(false)
    }

    /// Two effects of the list at one port and over one driver may stand in for one law between them: where a power explains as
    /// much, it is the simpler story.
    pub(super) fn one_law(&mut self) -> Result<(), CalibrateError> {
        let Some(point) = self.taken().map(|c| &c.point) else { return Ok(()) };
        let additions = &point.fitted.hypothesis.additions;
        let place = |a: &Addition| (a.port, a.follows);
        let twice = |a: &&Addition| {
            a.is_listed() && additions.iter().filter(|b| b.is_listed() && place(b) == place(a)).count() > 1
        };
        let Some(at) = additions.iter().find(twice).map(place) else { return Ok(()) };
        let cost = point.evidence.cost().0;
        let mut others = point.fitted.hypothesis.clone();
        others.additions.retain(|a| place(a) != at);
        let runs = self.first.runs.clone();
        let refit = self.setup.fit(others.clone(), &runs)?;
        let without = Linearization::new(self.setup, refit, &runs)?;
        let is_power = |s: &&Scored| {
            s.addition.as_ref().is_some_and(|a| place(a) == at && !a.is_listed() && !a.is_table())
        };
        let powers: Vec<Scored> = search(&without).iter().filter(is_power).cloned().collect();
        let round = compete(&without, &others, &powers);
        if round.winner().is_some_and(|c| c.point.evidence.cost().0 < cost + NEAR) {
            self.rounds.retain(|round| round.winner().is_some_and(|c| place(c.addition()) != at));
            self.rounds.push(round);
        }
        Ok(())
    }

    /// Whether what was taken first is far ahead of all that act elsewhere.
    fn clear(&self) -> bool {
        let Some((round, best)) = self.rounds.first().and_then(|r| Some((r, r.winner()?))) else {
            return false;
        };
        let elsewhere = round.candidates.iter().filter(|c| c.addition().port != best.addition().port);
        elsewhere.map(Candidate::sure).fold(0.0, f64::max) < AHEAD * best.sure()
    }

    /// Whether a parameter of the naive fit has gone so far that it stands in for something else.
    fn astray(&self) -> bool {
        let declared = self.setup.declared.iter().zip(&self.first.fitted.hypothesis.declared);
        declared.into_iter().any(|(d, value)| d.astray(*value))
    }
}
