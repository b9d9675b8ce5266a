//! The search, and when it is repeated: with values of the preset that effects make right again, and without a file that disagrees with all
//! others (`intake/odd_file.rs`) and that no effect describes. Of a fan that did not run, or another range of an amplifier, a fit of all runs
//! describes none of them.

use super::{Options, closed};
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::outcome::{Outcome, Refusal};
use crate::setup::Setup;
use std::time::Instant;

/// Part of the time budget for the search with all runs. Numerical: matters only for a search that the time limit ends; without the file the
/// parameters alone describe the runs, so that the second search is short.
const FIRST: f64 = 0.7;

/// The search, without the odd file if it is described better so.
pub(super) fn searched(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    options: Options,
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, Refusal> {
    let odd = experiment.odd_file.as_ref();
    let left = odd.map(|odd| (odd, experiment.without(&odd.name)));
    let is_fitted = |other: &Experiment| other.runs.iter().any(|run| run.role == Role::Fit);
    let Some((odd, other)) = left.filter(|(_, other)| is_fitted(other)) else {
        return whole(experiment, preset, options, progress);
    };
    let begun = Instant::now();
    let first = Options { budget: options.budget.map(|budget| budget.mul_f64(FIRST)), ..options };
    let outcome = whole(experiment, preset, first, progress)?;
    let time = rest(options, begun, 1.0);
    if follows(&outcome) || time.is_near() {
        return Ok(outcome);
    }
    progress(0.5, "no effect describes the file that disagrees with the others; looking without it");
    let budget = options.budget.map(|budget| budget.saturating_sub(begun.elapsed()));
    let again = unless_unusable(whole(&other, preset, Options { budget, ..options }, progress))?;
    let Some(mut again) = again.filter(follows) else { return Ok(outcome) };
    again.notes.retain(|note| *note != odd.note);
    again.notes.push(format!("{}; no effect describes the file, so it is left out", odd.note));
    again.left_out = Some(odd.name.clone());
    Ok(again)
}

/// Whether the fit and validation runs are described to within the noise.
fn follows(outcome: &Outcome) -> bool {
    [Role::Fit, Role::Validate].iter().all(|role| outcome.unexplained_error(*role).is_none())
}

/// The search with all runs.
fn whole(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    options: Options,
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, Refusal> {
    let begun = Instant::now();
    progress(0.0, "fitting the declared parameters");
    let deadline = options.budget.map_or_else(Deadline::default, Deadline::after);
    let means = experiment.of_means();
    let setup = Setup::of_means(experiment, means.as_ref(), preset)?.until(deadline.clone());
    let outcome = closed(&setup, options, begun, progress)?;
    // With the effects that were found, the values of the preset may be right: the parameters stood in for the effects.
    let setup = setup.without(&outcome.stood_in());
    let time = rest(options, begun, 1.0);
    let outcome = if setup.kept.is_empty() || time.is_near() {
        outcome
    } else {
        progress(0.5, "values of the preset are right beside what was found; looking again");
        let again = unless_unusable(closed(&setup.until(time), options, begun, progress))?;
        again.filter(|again| !again.is_cut).unwrap_or(outcome)
    };
    progress(1.0, outcome.verdict.name());
    Ok(outcome)
}

/// Deadline after a part of what is left of the time budget.
pub(super) fn rest(options: Options, begun: Instant, part: f64) -> Deadline {
    let rest = options.budget.map(|budget| budget.saturating_sub(begun.elapsed()).mul_f64(part));
    rest.map_or_else(Deadline::default, Deadline::after)
}

/// The outcome of a second search, or none if it fails; unusable data are an answer.
pub(super) fn unless_unusable(searched: Result<Outcome, Refusal>) -> Result<Option<Outcome>, Refusal> {
    match searched {
        Err(Refusal::Input(_)) => Ok(None),
        searched => searched.map(Some),
    }
}
