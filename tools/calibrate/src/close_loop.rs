//! The identification loop: fit, search for missing effects, add them and test them on held-out runs.
//!
//! 1. The preset as it is, and the naive fit of the declared parameters (`fit.rs`).
//! 2. The fitted model is linearised (`linearization.rs`) and every candidate addition is scored (`search.rs`).
//! 3. The best candidates compete and must pass an acceptance test (`selection.rs`). The accepted one extends the model, and step 2
//!    is repeated, three times at most.
//! 4. If a latent input explains a residual that no present value of a driver explains, the effect depends on history.
//! 5. The test runs are evaluated.

mod joint;
mod judgement;
mod refine;
mod repeated;
mod stepwise;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::acting::acting;
use crate::estimates;
use crate::experiment::{Experiment, Role};
use crate::fit::Fitted;
use crate::instruments;
use crate::levels::{DECISIVE, NEARLY, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::{Evidence, Follows, Found, Localised, Outcome, Refusal, Unexplained, Verdict};
use crate::report::count_of;
use crate::search::{Scored, best_memory_term, latent_input_at, search};
use crate::selection::{Candidate, Known, Round, shares};
use crate::separate::separate;
use crate::setup::Setup;
use crate::undeclared::{better_than_effects, in_place_of_effects};
use joint::Joint;
use judgement::BOXES;
pub use judgement::Judgement;
use physics::terms::Port;
use repeated::{rest, unless_unusable};
use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Largest number of updates of the parameters estimated jointly with a latent input. Numerical: a limit of effort; each is a
/// Gauss-Newton step.
const MOVES: usize = 4;
/// These updates stop below this fraction of a standard deviation. Numerical: a tenth of the half width of a 95 % interval.
const SETTLED: f64 = 0.2;
/// Fraction of the time for the search from the plain fit if runs disagree; the disagreement counted as noise hides most effects.
/// Numerical: matters only for a search that the time limit ends.
const FIRST: f64 = 0.7;

/// Options of the identification loop.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Time budget of the search; unlimited if `None`.
    pub budget: Option<Duration>,
    /// What is done.
    pub extent: Extent,
}

/// What is done with the data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// Effects are looked for.
    #[default]
    Search,
    /// Only the declared parameters are fitted.
    Fit,
    /// The same, because the checks of the data were cut off: the verdict is that of a search that found nothing in its time.
    Unchecked,
}

/// Runs the identification loop on an experiment; `preset` are the start values of its preset, by value reference. `progress` is called
/// with the completed fraction and the name of the next step.
///
/// # Errors
/// A run without the inputs that the model needs; parameters that the runs do not determine; readings of an input that explain by a zero
/// offset what was found.
pub fn run(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    options: Options,
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, Refusal> {
    let begun = Instant::now();
    let outcome = repeated::searched(experiment, preset, options, progress)?;
    Ok(Outcome { seconds: begun.elapsed().as_secs_f64(), ..outcome })
}

/// The search, or two if the runs disagree.
fn closed(
    setup: &Setup,
    options: Options,
    begun: Instant,
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, Refusal> {
    let mut setup = setup.clone();
    let deadline = setup.deadline().clone();
    // A preset that cannot be simulated says nothing about the noise.
    let _ = setup.lower_noise(&setup.preset(), &setup.runs(Role::Fit));
    let plain = setup.refit(&setup.runs(Role::Fit));
    let other = match &plain {
        Ok(plain) if !deadline.is_near() => {
            deadline.in_time(setup.between_runs(plain, &setup.runs(Role::Fit)))?.flatten()
        }
        _ => None,
    };
    match other {
        None => attempt(setup, plain, options, progress),
        // Fit only, or the fit runs themselves refute the plain fit, which then is no starting point for a search.
        Some(other) if options.extent != Extent::Search || other.is_plain_refuted => {
            attempt(other.setup, Ok(other.fitted), options, progress)
        }
        // An effect that acts only in some runs also makes runs disagree.
        Some(other) => {
            // A model that cannot be simulated in all runs is discarded.
            let found = attempt(setup.until(rest(options, begun, FIRST)), plain, options, progress);
            let found = unless_unusable(found)?;
            let next =
                attempt(other.setup.until(rest(options, begun, 1.0)), Ok(other.fitted), options, progress)?;
            Ok(found
                .filter(|found| !found.effects.is_empty() && found.misfit() <= next.misfit())
                .unwrap_or(next))
        }
    }
}

/// The search, starting from a first fit.
fn attempt<'a>(
    mut setup: Setup<'a>,
    mut refit: Result<Fitted, CalibrateError>,
    options: Options,
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, Refusal> {
    let deadline = setup.deadline().clone();
    let measured = setup.noise.clone();
    setup.structure = Arc::default();
    let for_boxes = options.budget.map_or(BOXES.0, |budget| budget.mul_f64(BOXES.1));
    let fit = setup.runs(Role::Fit);
    // At the deadline, the search returns its result so far.
    let mut is_cut = deadline.is_near();
    if !is_cut {
        let heard = refit.and_then(|r| setup.include_input_noise(&r.hypothesis, &fit).map(|()| r));
        progress(0.15, "search for missing effects");
        refit = heard.and_then(|r| setup.fit(r.hypothesis, &fit));
        is_cut = deadline.is_near();
    }
    if is_cut {
        deadline.lift();
        refit = refit.or_else(|_| setup.judged(setup.preset(), &fit));
    }
    let (refit, setup) = (refit?, setup);
    let readings = refit.readings;
    let is_thin = readings < setup.declared.len();
    let mut looked = None;
    is_cut |= options.extent == Extent::Unchecked;
    if !(options.extent == Extent::Fit || is_thin || is_cut) {
        looked = deadline.in_time(Search::new(&setup, refit.clone(), &fit))?;
        is_cut = looked.is_none();
    }
    if let Some(search_of) = &looked
        && let Some(mut released) = deadline
            .in_time(better_than_effects(&search_of.first, &search_of.scored[0], &search_of.known))?
            .flatten()
    {
        released.setup.noise = measured;
        return attempt(released.setup, Ok(released.fitted), options, progress);
    }
    let Some(mut search_of) = looked else {
        deadline.lift();
        let point = Linearization::judged(&setup, refit.clone(), &fit)?;
        let verdict = if options.extent == Extent::Fit { Verdict::Fitted } else { Verdict::Nothing };
        let mut judgement = Judgement::of(verdict, &point);
        judgement.time_for_boxes = for_boxes;
        judgement.is_cut = is_cut;
        if options.extent != Extent::Fit && is_thin {
            judgement.notes.push(format!(
                "{} and {}: too few readings to look for missing effects",
                count_of(readings, "reading"),
                count_of(setup.declared.len(), "parameter")
            ));
        }
        return Ok(estimates::outcome(&setup, &point, judgement)?);
    };
    search_of.rounds(progress);
    // A clear result at the start makes the second search unnecessary.
    if !search_of.remember() {
        // If the second search fails, the first result is kept.
        if let Err(e) = search_of.search_again(progress) {
            search_of.notes.push(format!("what was found could not be looked at again: {e}"));
        }
        if let Err(e) = search_of.one_law() {
            search_of.notes.push(format!("whether one law stands behind two effects could not be seen: {e}"));
        }
    }
    if let Err(e) = search_of.refine() {
        search_of.notes.push(format!("the accepted function could not be refined: {e}"));
    }
    if let Err(e) = deadline.in_time(search_of.join()) {
        search_of
            .notes
            .push(format!("the law could not be estimated from fit and validation runs together: {e}"));
    }
    if let Some(unusable) = deadline.in_time(search_of.error_of_an_input())?.flatten() {
        return Err(Refusal::Unusable(unusable));
    }
    if search_of.leaves_a_rest()?
        && let Some(mut released) = deadline.in_time(in_place_of_effects(&search_of.first))?.flatten()
    {
        released.setup.noise = measured;
        return attempt(released.setup, Ok(released.fitted), options, progress);
    }
    let is_cut = deadline.is_near();
    search_of.is_cut = is_cut;
    deadline.lift();
    progress(0.85, "judging what was found");
    let mut verdict = search_of.verdict()?;
    verdict.time_for_boxes = for_boxes;
    verdict.is_cut = is_cut;
    Ok(estimates::outcome(&setup, &search_of.first, verdict)?)
}

/// State of a search.
struct Search<'a> {
    setup: &'a Setup<'a>,
    /// The naive fit.
    first: Linearization<'a>,
    /// Candidates scored at the naive fit, and after each round that accepted one.
    scored: Vec<Vec<Scored>>,
    /// The rounds; each starts from the model that the previous one accepted.
    rounds: Vec<Round<'a>>,
    /// Candidates refused in the last round.
    refused: Vec<Evidence>,
    /// Warnings.
    notes: Vec<String>,
    /// Whether the time budget is exhausted.
    is_cut: bool,
    /// The memory term, if the residual needs one in addition to the present values of all drivers.
    remembered: Option<Scored>,
    /// The fits of candidates so far.
    known: Known,
    /// The accepted model, estimated from fit and validation runs together.
    joint: Option<Joint<'a>>,
}

impl<'a> Search<'a> {
    fn new(setup: &'a Setup<'a>, refit: Fitted, fit: &[usize]) -> Result<Search<'a>, CalibrateError> {
        let first = Linearization::new(setup, refit, fit)?;
        let scored = search(&first);
        Ok(Search {
            setup,
            first,
            scored: vec![scored],
            remembered: None,
            known: Known::default(),
            joint: None,
            is_cut: false,
            rounds: Vec::new(),
            refused: Vec::new(),
            notes: Vec::new(),
        })
    }

    /// The candidate that the last round accepted.
    fn taken(&self) -> Option<&Candidate<'a>> {
        self.rounds.iter().rev().find_map(Round::winner)
    }

    fn point(&self) -> &Linearization<'a> {
        self.taken().map_or(&self.first, |c| &c.point)
    }

    /// Whether nothing was accepted, or laws that leave more of the fit runs than instruments err by.
    fn leaves_a_rest(&self) -> Result<bool, CalibrateError> {
        let mut accepted = self.rounds.iter().filter_map(Round::winner).map(Candidate::addition);
        let is_law_only = accepted.all(|own| !own.is_listed());
        let explains =
            |point: &Linearization| instruments::explain_rest(self.setup, &point.fitted, &[Role::Fit]);
        Ok(is_law_only && (self.taken().is_none() || !explains(self.point())?))
    }

    /// The history-dependent latent input, if the additions explain clearly less than it does.
    fn history(&self) -> Option<&Scored> {
        let scored = &self.scored[0];
        let free = scored.iter().find(|s| s.is_free())?;
        let (before, after) = (self.first.evidence.cost(), self.point().evidence.cost());
        let ahead =
            |evidence: f64, explained: f64| evidence - explained > DECISIVE.max(STRUCTURE * evidence.abs());
        (ahead(free.evidence, before.0 - after.0) && ahead(free.raw, before.1 - after.1))
            .then(|| switched(scored, free))
    }

    /// The verdict on what was accepted.
    fn verdict(&mut self) -> Result<Judgement<'a>, CalibrateError> {
        let rounds = self.rounds.iter().enumerate();
        let candidate_table: Vec<Evidence> = rounds
            .flat_map(|(k, round)| round.candidate_table(k + 1))
            .chain(self.refused.drain(..))
            .collect();
        let localised = self.localised();
        // What instruments may err by needs no other explanation.
        let is_explained =
            instruments::explain_rest(self.setup, &self.first.fitted, &[Role::Fit, Role::Validate])?;
        let notes = std::mem::take(&mut self.notes);
        let mut judgement =
            Judgement { localised, candidate_table, notes, ..Judgement::of(Verdict::Nothing, &self.first) };
        let remembered = self.remembered.take();
        let setup = self.setup;
        if remembered.is_none()
            && let Some(free) = self.history().cloned()
        {
            // What predicts the validation runs better is kept even if a residual remains.
            if self.holds_beyond_the_fit() {
                judgement.notes.push(format!(
                    "beside what was added, a time-dependent input at {} explains more of the fit runs than any law: part of the residual \
                     there remains unexplained",
                    free.port.name()
                ));
            } else if !is_explained {
                judgement.verdict = Verdict::Unexplained;
                judgement.unexplained = Some(judgement::unexplained(&free));
                judgement.beside = self.beside(free.port, &self.first);
                return Ok(judgement);
            }
        }
        let unfitted: Vec<usize> = [Role::Validate, Role::Test].iter().flat_map(|r| setup.runs(*r)).collect();
        let mut effects = Vec::new();
        for round in &self.rounds {
            let Some(taken) = round.taken else { continue };
            effects.push(self.found(round, taken)?);
        }
        let (verdict, unnamed) = judgement::verdict_on(&effects);
        judgement.verdict = verdict;
        if let Some(free) = remembered {
            judgement.verdict = Verdict::Unexplained;
            judgement.unexplained = Some(judgement::unexplained(&free));
        } else if let Some(k) = unnamed {
            // The nonparametric shape estimated from the data, reported with the accepted law.
            let found = &effects[k];
            let same = |s: &&Scored| s.port == found.port && s.follows == found.follows && s.shape.len() > 2;
            let shape = self.scored[0].iter().find(same).map(|s| s.shape.clone()).unwrap_or_default();
            judgement.unexplained =
                Some(Unexplained { port: found.port, follows: found.follows, shape, added: true });
        } else if effects.is_empty()
            && !is_explained
            && let Some(rest) = self.left().iter().filter(|s| !s.listed).find(|s| !judgement.refutes(s))
            && rest.sure() > DECISIVE
        {
            judgement.verdict = Verdict::Unexplained;
            judgement.unexplained = Some(judgement::unexplained(rest));
        }
        judgement.effects = effects;
        if let Some(unexplained) = &judgement.unexplained {
            judgement.beside = self.beside(unexplained.port, self.point());
        }
        if let Some(taken) = self.rounds.iter().rposition(|r| r.taken.is_some()) {
            let mut rounds = std::mem::take(&mut self.rounds);
            let round = rounds.swap_remove(taken);
            let point = round.candidates.into_iter().nth(round.taken.unwrap_or(0)).map(|c| c.point);
            if let Some(point) = point {
                judgement.hypothesis = point.fitted.hypothesis.clone();
                judgement.point = Some(point);
            }
        }
        self.conclude(&mut judgement);
        let partly: Vec<bool> = judgement.hypothesis.additions.iter().map(|a| !a.is_in_every_run()).collect();
        judgement.hypothesis = acting(setup, &judgement.hypothesis, &unfitted)?;
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

    /// Whether an accepted law is outside the list of effects.
    fn has_law(&self) -> bool {
        self.rounds.iter().filter_map(Round::winner).any(|c| !c.addition().is_listed())
    }

    /// Whether a law or a listed effect of all runs was accepted: it also predicts runs to which it was not fitted.
    fn holds_beyond_the_fit(&self) -> bool {
        let holds = |c: &Candidate| !c.addition().is_listed() || c.addition().is_in_every_run();
        self.rounds.iter().filter_map(Round::winner).any(holds)
    }

    /// A model with the best parameters given a latent input at a port; `None` if that model cannot be simulated.
    fn beside(&self, port: Port, from: &Linearization) -> Option<(Linearization<'a>, Port)> {
        let (setup, runs) = (self.setup, &self.first.runs);
        let place = Port::ALL.iter().find(|p| **p == port && !self.is_cut)?;
        let mut point = Linearization::beside(setup, from.fitted.clone(), runs, place).ok()?;
        for _ in 0..MOVES {
            let told = point.estimated(Some(port));
            let far = |(k, way): (usize, &f64)| way.abs() > SETTLED * told.covariance[(k, k)].sqrt();
            if !told.moves.iter().enumerate().any(far) {
                break;
            }
            let mut moved = point.fitted.hypothesis.clone();
            moved.take(&told.moved);
            let Ok(next) =
                setup.judged(moved, runs).and_then(|f| Linearization::beside(setup, f, runs, place))
            else {
                break;
            };
            point = next;
        }
        Some((point, port))
    }

    /// The addition that a round accepted, without the final parameter values.
    fn found(&self, round: &Round, taken: usize) -> Result<Found, CalibrateError> {
        let setup = self.setup;
        let candidate = &round.candidates[taken];
        let addition = candidate.addition();
        let mut alternatives: Vec<String> = Vec::new();
        let mut deltas = vec![candidate.delta.0];
        let mut separating = None;
        for other in round.alike.iter().map(|k| &round.candidates[*k]) {
            let id = &other.addition().id;
            if *id == addition.id || alternatives.contains(id) {
                continue;
            }
            alternatives.push(id.clone());
            deltas.push(other.delta.0);
            if separating.is_none() && !self.is_cut {
                let names = [addition.id.as_str(), id.as_str()];
                separating = separate(
                    setup,
                    &candidate.point.fitted.hypothesis,
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
            weights: deltas.iter().copied().map(shares(&deltas)).collect(),
            runs: files(setup, &addition.active),
            everywhere: addition.is_in_every_run(),
            parameters: Vec::new(),
            term: addition.term(),
            separating_experiment: separating,
            delta_bic: candidate.delta.1,
            delta_bic_whitened: candidate.delta.0,
            delta_validation: candidate.delta_validation,
            validation_ratio: candidate.validation,
            magnitude: estimates::magnitude(&candidate.point),
        })
    }

    /// Fraction of the naive fit's residual that a latent input explains, for each port.
    fn localised(&self) -> Vec<Localised> {
        let (_, raw) = self.first.evidence.cost();
        let excess = (raw - self.first.evidence.values() as f64).max(1.0);
        let of = |port: &Port| {
            let free = self.scored[0].iter().find(|s| s.port == *port && s.is_free())?;
            let with_driver = self.scored[0].iter().find(|s| s.port == *port && !s.listed && !s.is_free());
            let follows = with_driver.map_or(Follows::History, |s| s.follows);
            let gain = free.raw + 2.0 * self.first.per_number();
            Some(Localised { port: *port, share: (gain / excess).clamp(0.0, 1.0), follows })
        };
        let mut all: Vec<Localised> = Port::ALL.iter().filter_map(of).collect();
        all.sort_by(|a, b| b.share.total_cmp(&a.share));
        let mut known = HashSet::new();
        all.retain(|one| known.insert(one.port.quantity()));
        all
    }
}

/// Latent inputs at different heat-flow ports explain nearly the same residual. A memory term (latch, switch, intermittent effect) is
/// specific to its port, so its port is used if it explains nearly as much.
fn switched<'s>(scored: &'s [Scored], free: &'s Scored) -> &'s Scored {
    let known = best_memory_term(scored).filter(|known| known.sure() > NEARLY * free.sure());
    known.and_then(|known| latent_input_at(scored, known.port)).unwrap_or(free)
}

/// The files of active runs, without duplicates.
fn files(setup: &Setup, active: &[bool]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (run, _) in setup.experiment.runs.iter().zip(active).filter(|(_, on)| **on) {
        if !all.contains(&run.file) {
            all.push(run.file.clone());
        }
    }
    all
}
