//! The whole loop: fit, find what is missing, add it, and judge it on what was not fitted.
//!
//! 1. The preset as it is, and the naive fit of the declared parameters (`fit.rs`).
//! 2. The fitted model is linearised (`point.rs`) and everything it may lack is scored (`search.rs`).
//! 3. The best compete and pass a gate (`rounds.rs`); what is taken is the new model, and 2. begins anew, three times at most.
//! 4. What no present value of a driver explains but a force that is free in time does, follows its history.
//! 5. The test runs are opened.

use crate::CalibrateError;
use crate::experiment::{Experiment, Role};
use crate::fit::Fitted;
use crate::hypothesis::{Addition, Hypothesis};
use crate::outcome::{Evidence, Follows, Found, Localised, Outcome, Unexplained, Verdict};
use crate::point::Point;
use crate::rounds::{Contender, LEAST, Round, acting, compete};
use crate::search::{Scored, search};
use crate::separate::separate;
use crate::setup::Setup;
use crate::telling;
use physics::terms::{MOST_TERMS, Port};

/// Beyond its nearest rival, a force that is free in time needs this much to be called one that knows its past: a share
/// of what there is to explain (slopes mislead by some hundredths), and a number.
const HISTORY: (f64, f64) = (0.03, 30.0);
/// Times that numbers move beside a force, and share of their deviations by which they do no more.
const MOVES: usize = 4;
const SETTLED: f64 = 0.2;
/// Cost by which two effects of the list have to be better than one law in place of both.
const ONE_LAW: f64 = 6.0;
/// Share of what a force that is free in time explains from which on a switch explains it.
const SWITCHED: f64 = 0.9;
/// Who explains less than this share of what the first does is far behind.
const AHEAD: f64 = 0.9;
/// What is left unexplained is said from this evidence on.
const SAID: f64 = 40.0;

/// Closes the loop over an experiment; `preset` are the start values of its preset, by value reference. `progress` hears
/// the share that is done, and what is done next.
///
/// # Errors
/// A run that the model cannot be driven with; parameters that the runs do not show.
pub fn run(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, CalibrateError> {
    let begun = std::time::Instant::now();
    progress(0.0, "fitting the declared parameters");
    let mut setup = Setup::new(experiment, preset)?;
    let fit = setup.runs(Role::Fit);
    let refit = setup.fit(setup.preset(), &fit)?;
    setup.hear_inputs(&refit, &fit)?;
    let setup = setup;
    progress(0.15, "looking for what is missing");
    let refit = setup.fit(refit.hypothesis, &fit)?;
    let mut search_of = Search::new(&setup, refit.clone(), &fit)?;
    search_of.rounds(progress)?;
    // What cannot be looked at again stays as it was found.
    if let Err(e) = search_of.look_again(progress) {
        search_of.notes.push(format!("what was found could not be looked at again: {e}"));
    }
    if let Err(e) = search_of.one_law() {
        search_of.notes.push(format!("whether one law stands behind two effects could not be seen: {e}"));
    }
    progress(0.85, "judging what was found");
    let verdict = search_of.verdict()?;
    let mut outcome = telling::outcome(&setup, &search_of.first, &refit.hypothesis, verdict)?;
    outcome.seconds = begun.elapsed().as_secs_f64();
    progress(1.0, outcome.verdict.name());
    Ok(outcome)
}

/// What was found on the way.
struct Search<'a> {
    setup: &'a Setup<'a>,
    /// The naive fit.
    first: Point<'a>,
    /// What was scored there.
    scored: Vec<Scored>,
    /// The rounds, each from the model that the one before has taken.
    rounds: Vec<Round<'a>>,
    /// What the last round refused.
    refused: Vec<Evidence>,
    /// What is odd.
    notes: Vec<String>,
    /// What was scored last.
    left: Vec<Scored>,
}

/// What a search has come to.
pub struct Judgement<'a> {
    /// The verdict.
    pub verdict: Verdict,
    /// The model, linearised; `None` where it is the naive fit.
    pub point: Option<Point<'a>>,
    /// The model with the runs in which everything acts, the runs that were not fitted included.
    pub hypothesis: Hypothesis,
    /// What was added, but for its numbers.
    pub effects: Vec<Found>,
    /// What has no name.
    pub unexplained: Option<Unexplained>,
    /// Where something has no name: the model from which parameters are told beside a force at its port that is free in time.
    pub beside: Option<(Point<'a>, Port)>,
    /// Where the residual sat.
    pub localised: Vec<Localised>,
    /// What was tried.
    pub ladder: Vec<Evidence>,
    /// What is odd.
    pub notes: Vec<String>,
}

impl<'a> Search<'a> {
    fn new(setup: &'a Setup<'a>, refit: Fitted, fit: &[usize]) -> Result<Search<'a>, CalibrateError> {
        let first = Point::new(setup, refit, fit)?;
        let scored = search(&first);
        Ok(Search {
            setup,
            first,
            left: scored.clone(),
            scored,
            rounds: Vec::new(),
            refused: Vec::new(),
            notes: Vec::new(),
        })
    }

    /// The contender that the last round has taken.
    fn taken(&self) -> Option<&Contender<'a>> {
        self.rounds.iter().rev().find_map(Round::winner)
    }

    fn point(&self) -> &Point<'a> {
        self.taken().map_or(&self.first, |c| &c.point)
    }

    fn rounds(&mut self, progress: &dyn Fn(f64, &str)) -> Result<(), CalibrateError> {
        for round in 0..MOST_TERMS {
            if self.left.first().is_none_or(|s| s.sure() <= LEAST) {
                break;
            }
            let round_of = compete(self.point(), &self.point().fitted.hypothesis, &self.left);
            let ended = round_of.taken.is_none();
            self.rounds.push(round_of);
            if ended {
                break;
            }
            let found = self.point().fitted.hypothesis.additions.last().map_or("", |a| &a.id).to_string();
            progress(0.3 + 0.1 * (round + 1) as f64, &format!("{found}; is there more?"));
            let taken = self.point().fitted.clone();
            match Point::new(self.setup, taken, &self.first.runs) {
                Ok(point) => self.left = search(&point),
                Err(e) => {
                    self.notes
                        .push(format!("beyond what was found nothing further could be looked for: {e}"));
                    break;
                }
            }
        }
        Ok(())
    }

    /// Looks at each addition once more, from the others and the numbers that were found with it: there the slopes are those
    /// of the right neighbourhood, where the naive fit may have been far astray, and a first choice that had to stand for
    /// two effects gives way.
    fn look_again(&mut self, progress: &dyn Fn(f64, &str)) -> Result<(), CalibrateError> {
        // A round that took nothing is the last.
        let taken = self.rounds.iter().filter(|r| r.taken.is_some()).count();
        for (k, round) in self.rounds.drain(taken..).enumerate() {
            self.refused.extend(round.ladder(taken + k + 1));
        }
        let count = self.rounds.len();
        let listed = self.taken().is_some_and(|c| c.addition().is_listed());
        if count == 0 || (count == 1 && listed && (!self.astray() || self.clear())) {
            return Ok(());
        }
        let runs = self.first.runs.clone();
        for k in 0..count {
            progress(0.6 + 0.2 * k as f64 / count as f64, "looking again");
            let mut others = self.point().fitted.hypothesis.clone();
            let own = others.additions.remove(0);
            let refit = if others.additions.is_empty() {
                self.first.fitted.clone()
            } else {
                self.setup.fit(others.clone(), &runs)?
            };
            let without = Point::judged(self.setup, refit, &runs)?;
            let cost = |r: &Round| r.winner().map_or(f64::INFINITY, |c| c.point.evidence.cost().0);
            let whole = self.rounds.last().map_or(f64::INFINITY, cost);
            // What the others explain without it was a first choice that had to stand for them.
            if self.rounds.len() > 1 && without.evidence.cost().0 < whole + LEAST {
                self.rounds.remove(0);
                if let Some(last) = self.rounds.pop() {
                    self.rounds.push(last.with_point(without));
                }
                continue;
            }
            let stripped = Point::new(self.setup, self.setup.judged(others.clone(), &runs)?, &runs)?;
            let round = compete(&without, &others, &search(&stripped));
            let old = self.rounds.remove(0);
            if round.taken.is_some() && cost(&round) < whole + LEAST {
                self.rounds.push(round);
            } else {
                // It stays, last of all.
                let mut kept = others;
                kept.additions.push(own);
                let point = Point::judged(self.setup, self.setup.judged(kept, &runs)?, &runs)?;
                self.rounds.push(old.with_point(point));
            }
        }
        Ok(())
    }

    /// Two effects of the list at one port and over one driver may stand in for one law between them: where a power explains as
    /// much, it is the simpler story.
    fn one_law(&mut self) -> Result<(), CalibrateError> {
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
        let without = Point::new(self.setup, refit, &runs)?;
        let is_power = |s: &&Scored| {
            s.addition.as_ref().is_some_and(|a| place(a) == at && !a.is_listed() && !a.is_table())
        };
        let powers: Vec<Scored> = search(&without).iter().filter(is_power).cloned().collect();
        let round = compete(&without, &others, &powers);
        if round.winner().is_some_and(|c| c.point.evidence.cost().0 < cost + ONE_LAW) {
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
        let elsewhere = round.contenders.iter().filter(|c| c.addition().port != best.addition().port);
        elsewhere.map(Contender::sure).fold(0.0, f64::max) < AHEAD * best.sure()
    }

    /// Whether a parameter of the naive fit has gone so far that it stands in for something else.
    fn astray(&self) -> bool {
        let declared = self.setup.declared.iter().zip(&self.first.fitted.hypothesis.declared);
        declared.into_iter().any(|(d, value)| d.astray(*value))
    }

    /// The force that knows its past, where nothing that was added comes near what it would explain.
    fn history(&self) -> Option<&Scored> {
        let free = self.scored.iter().find(|s| s.follows == Follows::History && !s.listed)?;
        let (before, after) = (self.first.evidence.cost(), self.point().evidence.cost());
        let explained = before.0 - after.0;
        let (share, least) = HISTORY;
        let ahead = |evidence: f64, explained: f64| evidence - explained > least.max(share * evidence.abs());
        (ahead(free.evidence, explained) && ahead(free.raw, before.1 - after.1)).then(|| self.switched(free))
    }

    /// Forces that are free in time explain the same at many ports of heat. One that latches, switches or comes and goes says at which
    /// it does: the force there, where that explains nearly as much.
    fn switched<'s>(&'s self, free: &'s Scored) -> &'s Scored {
        let past = || self.scored.iter().filter(|s| s.follows == Follows::History && !s.listed);
        let known = past().find(|s| !s.is_free() && s.sure() > SWITCHED * free.sure());
        known.and_then(|known| past().find(|s| s.is_free() && s.port == known.port)).unwrap_or(free)
    }

    fn verdict(&mut self) -> Result<Judgement<'a>, CalibrateError> {
        let rounds = self.rounds.iter().enumerate();
        let ladder: Vec<Evidence> =
            rounds.flat_map(|(k, round)| round.ladder(k + 1)).chain(self.refused.drain(..)).collect();
        let localised = self.localised();
        let mut judgement = Judgement {
            verdict: Verdict::Nothing,
            point: None,
            hypothesis: self.first.fitted.hypothesis.clone(),
            effects: Vec::new(),
            unexplained: None,
            beside: None,
            localised,
            ladder,
            notes: std::mem::take(&mut self.notes),
        };
        if let Some(free) = self.history().cloned() {
            judgement.verdict = Verdict::Unexplained;
            judgement.unexplained = Some(told(&free, false));
            judgement.beside = self.beside(free.port, &self.first);
            return Ok(judgement);
        }
        let setup = self.setup;
        let unfitted: Vec<usize> = [Role::Validate, Role::Test].iter().flat_map(|r| setup.runs(*r)).collect();
        let mut effects = Vec::new();
        for round in &self.rounds {
            let Some(taken) = round.taken else { continue };
            effects.push(self.found(round, taken)?);
        }
        let unnamed = effects.iter().position(|f| f.term.is_some());
        let class = effects.iter().any(|f| !f.alternatives.is_empty());
        judgement.verdict = match (effects.is_empty(), unnamed, class) {
            (true, ..) => Verdict::Nothing,
            (_, Some(_), _) => Verdict::Unexplained,
            (_, None, true) => Verdict::Class,
            (_, None, false) => Verdict::Named,
        };
        if let Some(k) = unnamed {
            // The shape that the data draws by itself, beside the law that was taken.
            let found = &effects[k];
            let same = |s: &&Scored| s.port == found.port && s.follows == found.follows && s.shape.len() > 2;
            let shape = self.scored.iter().find(same).map(|s| s.shape.clone()).unwrap_or_default();
            judgement.unexplained =
                Some(Unexplained { port: found.port, follows: found.follows, shape, added: true });
        } else if effects.is_empty()
            && let Some(rest) = self.left.iter().find(|s| !s.listed).filter(|s| s.sure() > SAID)
        {
            judgement.verdict = Verdict::Unexplained;
            judgement.unexplained = Some(told(rest, false));
        }
        judgement.effects = effects;
        if let Some(unexplained) = &judgement.unexplained {
            judgement.beside = self.beside(unexplained.port, self.point());
        }
        if let Some(taken) = self.rounds.iter().rposition(|r| r.taken.is_some()) {
            let mut rounds = std::mem::take(&mut self.rounds);
            let round = rounds.swap_remove(taken);
            let point = round.contenders.into_iter().nth(round.taken.unwrap_or(0)).map(|c| c.point);
            if let Some(point) = point {
                judgement.hypothesis = point.fitted.hypothesis.clone();
                judgement.point = Some(point);
            }
        }
        let partly: Vec<bool> =
            judgement.hypothesis.additions.iter().map(|a| a.active.iter().any(|on| !on)).collect();
        acting(setup, &mut judgement.hypothesis, &unfitted)?;
        for (a, addition) in judgement.hypothesis.additions.iter().enumerate().filter(|(a, _)| partly[*a]) {
            judgement.effects[a].runs = files(setup, &addition.active);
            let runs = setup.experiment.runs.iter().enumerate();
            let decided: Vec<&str> = runs
                .filter(|(k, _)| setup.fitted_with(*k).is_none())
                .map(|(_, run)| run.file.as_str())
                .collect();
            if !decided.is_empty() {
                judgement.notes.push(format!(
                    "{} acts in some runs only; whether it acts in {} was decided by which predicts that run better, its size kept",
                    addition.id,
                    decided.join(", ")
                ));
            }
        }
        Ok(judgement)
    }

    /// A model moved to where its numbers are best beside a force at a port that is free in time; `None` where that cannot be run.
    fn beside(&self, port: Port, from: &Point) -> Option<(Point<'a>, Port)> {
        let (setup, runs) = (self.setup, &self.first.runs);
        let place = Port::ALL.iter().find(|p| **p == port)?;
        let mut point = Point::beside(setup, from.fitted.clone(), runs, place).ok()?;
        for _ in 0..MOVES {
            let told = point.told(Some(port));
            let far = |(k, way): (usize, &f64)| way.abs() > SETTLED * told.covariance[(k, k)].sqrt();
            if !told.moves.iter().enumerate().any(far) {
                break;
            }
            let mut moved = point.fitted.hypothesis.clone();
            moved.take(&told.moved);
            let Ok(next) = setup.judged(moved, runs).and_then(|f| Point::beside(setup, f, runs, place))
            else {
                break;
            };
            point = next;
        }
        Some((point, port))
    }

    /// What a round has taken, but for its numbers.
    fn found(&self, round: &Round, taken: usize) -> Result<Found, CalibrateError> {
        let setup = self.setup;
        let contender = &round.contenders[taken];
        let addition = contender.addition();
        let mut alternatives: Vec<String> = Vec::new();
        let mut separating = None;
        for other in round.alike.iter().map(|k| &round.contenders[*k]) {
            let id = &other.addition().id;
            if *id == addition.id || alternatives.contains(id) {
                continue;
            }
            alternatives.push(id.clone());
            if separating.is_none() {
                let names = [addition.id.as_str(), id.as_str()];
                separating = separate(
                    setup,
                    &contender.point.fitted.hypothesis,
                    &other.point.fitted.hypothesis,
                    names,
                );
            }
        }
        Ok(Found {
            id: addition.id.clone(),
            port: addition.port,
            follows: addition.follows,
            alternatives,
            runs: files(setup, &addition.active),
            everywhere: addition.active.iter().all(|on| *on),
            parameters: Vec::new(),
            term: addition.term(),
            separating_experiment: separating,
            delta_bic: contender.delta.1,
            delta_bic_whitened: contender.delta.0,
            validation_ratio: contender.validation,
            magnitude: telling::magnitude(&contender.point),
        })
    }

    /// How much of the naive fit's residual a force that is free in time would explain, port by port.
    fn localised(&self) -> Vec<Localised> {
        let (_, raw) = self.first.evidence.cost();
        let excess = (raw - self.first.evidence.values() as f64).max(1.0);
        let of = |port: &Port| {
            let free = self.scored.iter().find(|s| s.port == *port && s.is_free())?;
            let with_driver = self.scored.iter().find(|s| s.port == *port && !s.listed && !s.is_free());
            let follows = with_driver.map_or(Follows::History, |s| s.follows);
            let gain = free.raw + 2.0 * self.first.per_number();
            Some(Localised { port: *port, share: (gain / excess).clamp(0.0, 1.0), follows })
        };
        let mut all: Vec<Localised> = Port::ALL.iter().filter_map(of).collect();
        all.sort_by(|a, b| b.share.total_cmp(&a.share));
        all
    }
}

/// The files of active runs, each once.
fn files(setup: &Setup, active: &[bool]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (run, _) in setup.experiment.runs.iter().zip(active).filter(|(_, on)| **on) {
        if !all.contains(&run.file) {
            all.push(run.file.clone());
        }
    }
    all
}

fn told(scored: &Scored, added: bool) -> Unexplained {
    Unexplained { port: scored.port, follows: scored.follows, shape: scored.shape.clone(), added }
}
