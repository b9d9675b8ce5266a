//! Units, signs, columns and clocks that contradict the model.
//!
//! For every output k, over the rows of the runs,
//!
//! q_k = |y - p| / max(|y|, |p|)                                                                    (1)
//!
//! (root mean squares without the tenth of the rows with the greatest deviations; p the preset's prediction). A temperature rise can be
//! doubled by an effect that the model lacks; it is therefore compared by its shape, its start and its order of magnitude:
//!
//! q_k^2 = 1 - r^2 + (|y_0 - p_0| / s)^2 + (|ln(s_y / s_p)| - ln 2.5)_+^2                            (2)
//!
//! r the correlation of y and p, s their standard deviations. The check is made only if the fit of the declared parameters, with the
//! structure error below, leaves a residual of more than [`FACTOR`] times the structure error in a run. A mistake in a column is a
//! hypothesis that changes the data: another unit, in either direction; a power of ten; a wrong sign; two columns exchanged; a temperature
//! rise over ambient recorded instead of a temperature, or one of the opposite sign; an ambient sensor heated by the motor; an input that
//! was not measured, with values implied by an output; current or voltage of the drive's supply instead of the motor's; a magnitude
//! recorded instead of a value with its sign; an input recorded behind a first-order lag; a load recorded behind AC coupling; an arbitrary
//! factor; a wrong unit of time, or in one file another interval. The score of a hypothesis is the sum of ln q_k. Hypotheses on outputs
//! from which no run starts need no simulation; the others are simulated only if some q is large. The best ones are confirmed: the declared
//! parameters are fitted to the data as they are and as changed by the hypothesis, with a structure error of [`STRUCTURE`] of each output's
//! size and [`SAMPLES`] independent readings per run as the noise. The data are contradictory only if the minimum of the former is
//! [`FACTOR`] times that of the latter (2 for a lag of an input, since no effect makes an output respond before its cause): no values
//! within the priors explain the data as well. Another interval between the rows of a file is compared together with the fit runs of the
//! other files, if these agree with the model: they then determine the parameters, and predict instead of the preset. It has to explain the
//! file as well as parameters of its own would (Schwarz's criterion). With any mistake in one file, all files have to agree better with one
//! motor.
//!
//! Before that, parameters without prior get one if their values in the preset contradict the data (`undeclared.rs`). Since a mistake may
//! stand beside them, the evidence counts for errors of the size above and for errors of unknown size: C the cost, n the number of
//! independent readings,
//!
//! evidence = min(C - C', n ln (C / C')) - ln n                                                       (3)
//!
//! *Source*: parameter bounds and residuals for fault isolation: Isermann, Fault-Diagnosis Systems (2006), ch. 9; likelihood ratio of
//! hypotheses: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

mod conversions;
mod cost;
mod filters;
pub mod illustration;
mod mistakes;
mod search;
mod sides;
mod supply;
#[cfg(test)]
mod tests;
mod time;
mod unmeasured;
pub mod wrapped;

use super::{Predicted, Unusable};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role, Run, Start};
use crate::hypothesis::Hypothesis;
use crate::levels::{CERTAIN, FACTOR, NEARLY, SAMPLES, STRUCTURE};
use crate::means::Division;
use crate::one_gain;
use crate::selection::LEAST;
use cost::{Cost, fitted};
pub use mistakes::Mistake;
use search::{Found, is_exact, search, wrong_value};
pub use supply::is_bus;
use time::wrong_time;

/// Sum of squared parameter deviations over their priors above which parameters count as strained. Derivation: two at [`CERTAIN`].
const STRAINED: f64 = 2.0 * CERTAIN * CERTAIN;
/// q of an output without any agreement. Numerical: any value far above 1.
const MOST_OFF: f64 = 10.0;
/// Rows of a run that are compared; each is the mean over a constant number of readings. Numerical: a run comprises some tens of time
/// constants.
pub(super) const ROWS: usize = 500;
/// Least size of a quantity, in SI units. Numerical: rounding.
const ROUNDING: f64 = 1e-9;
/// Least variation of a temperature in (2), K. Limit: smaller ones show no shape.
const LEAST_RISE: f64 = 0.5;

/// Predictions of the model and their deviation from the data.
#[derive(Clone)]
struct Judge<'a> {
    preset: &'a [(u32, f64)],
    /// The runs in which a mistake is looked for.
    runs: &'a [usize],
    /// Further runs, which agree with the model: they are fitted together with [`runs`](Judge::runs).
    beside: Vec<usize>,
    /// Fit of the further runs, which predicts instead of the preset.
    base: Option<Hypothesis>,
    /// Cost up to which a hypothesis is confirmed: that of another explanation.
    most: f64,
    deadline: Deadline,
}

impl<'a> Judge<'a> {
    /// Of these runs alone, by the preset.
    fn of(preset: &'a [(u32, f64)], runs: &'a [usize], deadline: &Deadline) -> Judge<'a> {
        let deadline = deadline.clone();
        Judge { preset, runs, beside: Vec::new(), base: None, most: f64::INFINITY, deadline }
    }

    fn predicted(&self, experiment: &Experiment) -> Predicted {
        let by_fit = self.base.as_ref().and_then(|base| {
            super::predicted_by(experiment, self.preset, self.runs, base, &self.deadline).ok()
        });
        by_fit.unwrap_or_else(|| super::predicted(experiment, self.preset, self.runs, &self.deadline))
    }

    /// (1) and the best ratio of reading to prediction for each output; `None` without readings.
    fn outputs(&self, experiment: &Experiment, predicted: &Predicted) -> Vec<Option<(f64, f64)>> {
        let inputs = experiment.inputs.len();
        let of = |output: usize| {
            let mut rows: Vec<(f64, f64)> = Vec::new();
            for (n, run) in self.runs.iter().enumerate() {
                let run = &experiment.runs[*run];
                let (column, model) = (&run.table.columns[inputs + output], predicted[n].get(output)?);
                let own = column.iter().copied().zip(model.iter().copied());
                rows.extend(own.filter(|(y, _)| y.is_finite()));
            }
            if rows.is_empty() {
                return None;
            }
            // A model that cannot be simulated explains no data.
            if rows.iter().any(|(_, p)| !p.is_finite()) {
                return Some((MOST_OFF, f64::NAN));
            }
            let both: f64 = rows.iter().map(|(y, p)| y * p).sum();
            let own: f64 = rows.iter().map(|(_, p)| p * p).sum();
            let q = if experiment.outputs[output].is_temperature() {
                let off = self.runs.iter().zip(predicted).filter_map(|(run, model)| {
                    let run = &experiment.runs[*run];
                    let (y, p) = (run.table.columns[inputs + output][0], model[output][0]);
                    (run.start == Start::Ambient && y.is_finite()).then_some((y - p).abs())
                });
                shape(&rows, super::median(off))
            } else {
                let size = |pick: &dyn Fn(&(f64, f64)) -> f64| {
                    let mut all: Vec<f64> = rows.iter().map(|row| pick(row).powi(2)).collect();
                    let last = (all.len() * 9).div_ceil(10) - 1;
                    all.select_nth_unstable_by(last, f64::total_cmp);
                    let kept = &all[..=last];
                    (kept.iter().sum::<f64>() / kept.len() as f64).sqrt()
                };
                let whole = size(&|(y, _)| *y).max(size(&|(_, p)| *p)).max(ROUNDING);
                size(&|(y, p)| y - p) / whole
            };
            Some((q.min(MOST_OFF), both / own))
        };
        (0..experiment.outputs.len()).map(of).collect()
    }
}

/// (2)
fn shape(rows: &[(f64, f64)], start: f64) -> f64 {
    let n = rows.len() as f64;
    let (y, p) = rows.iter().fold((0.0, 0.0), |(a, b), (y, p)| (a + y / n, b + p / n));
    let (mut yy, mut pp, mut yp) = (ROUNDING, ROUNDING, 0.0);
    for (a, b) in rows {
        yy += (a - y).powi(2);
        pp += (b - p).powi(2);
        yp += (a - y) * (b - p);
    }
    let size = (yy.max(pp) / n).sqrt().max(LEAST_RISE);
    let unlike = if yp > 0.0 { 1.0 - yp * yp / (yy * pp) } else { 1.0 };
    let scale = (0.5 * (yy / pp).ln().abs() - FACTOR.ln()).max(0.0);
    let start = if start.is_finite() { start / size } else { 0.0 };
    (unlike + scale * scale + start * start).sqrt()
}

fn score(outputs: &[Option<(f64, f64)>]) -> f64 {
    outputs
        .iter()
        .flatten()
        .map(|(q, _)| if q.is_finite() { q.max(STRUCTURE).ln() } else { MOST_OFF.ln() })
        .sum()
}

fn worst(outputs: &[Option<(f64, f64)>]) -> f64 {
    outputs.iter().flatten().map(|(q, _)| *q).fold(0.0, f64::max)
}

/// The experiment with at most `most` means in a run, or more if a load alternates: sufficient for detecting a mistake, and faster to
/// simulate.
pub(super) fn thinned(experiment: &Experiment, most: usize) -> Experiment {
    let mut thin = experiment.clone();
    // A frozen sensor contradicts every hypothesis on its column.
    for table in thin.runs.iter_mut().map(|r| &mut r.table) {
        for column in &mut table.columns[experiment.inputs.len()..] {
            let first = super::median(column.iter().copied());
            let still = column.iter().filter(|x| **x == first).count();
            if still as f64 > NEARLY * column.iter().filter(|x| x.is_finite()).count() as f64 {
                column.fill(f64::NAN);
            }
        }
    }
    let whole = |run: &Run| {
        let rows = run.table.time.len();
        Some(Division {
            length: rows.div_ceil(most),
            pieces: std::iter::once(0..rows).collect(),
            loss: STRUCTURE,
        })
    };
    thin.with_means(&[], whole).0
}

/// Fit that predicts an output.
pub struct Reference {
    /// The parameters.
    pub hypothesis: Hypothesis,
    /// Whether the fitted data agree with the model, so that a deviation of the output is not one of the fit.
    pub is_sure: bool,
}

/// Reason why the data contradict the model, over all runs or in one file; otherwise the fit that predicts each output. Parameters without
/// a prior whose values in the preset contradict the data get one.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn contradiction(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Result<Vec<Option<Reference>>, Unusable>, CalibrateError> {
    let all: Vec<usize> = super::all_runs(experiment);
    let mut thin = thinned(experiment, ROWS);
    let whole = Judge::of(preset, &all, deadline);
    if let Some(unusable) = wrong_time(&whole, &thin, None)? {
        return Ok(Err(unusable));
    }
    for (file, runs) in files(&thin).iter().filter(|(_, runs)| is_longer(&thin, runs)) {
        if let Some(unusable) = wrong_time(&whole, &thin, Some((file, runs)))? {
            return Ok(Err(unusable));
        }
    }
    let mut as_is = fitted(&whole, &thin)?;
    // What the experiment states is tried before values of the preset.
    let mut value = None;
    while !as_is.is_cut
        && !as_is.bad_runs().is_empty()
        && let Some((other, better)) = cost::released(&whole, &thin, &as_is)?
        && as_is.evidence(&better) > LEAST
    {
        if as_is.bad_runs().len() == all.len() {
            value = wrong_value(&whole, &thin, &as_is, is_exact)?;
        }
        if value.is_some() {
            break;
        }
        (as_is, thin) = (better, other);
    }
    let bad = as_is.bad_runs();
    let unusable =
        if bad.is_empty() || as_is.is_cut { None } else { mistaken(&whole, &thin, &as_is, value)? };
    if let Some(unusable) = unusable {
        return Ok(Err(unusable));
    }
    let references = references(&whole, &thin, as_is)?;
    experiment.priors = thin.priors;
    experiment.released = thin.released;
    Ok(Ok(references))
}

/// The value of `[set]` or `[prior]` that contradicts what is left of the data after all other checks.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn contradicting_value(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Unusable>, CalibrateError> {
    let (all, thin) = (super::all_runs(experiment), thinned(experiment, ROWS));
    let judge = Judge::of(preset, &all, deadline);
    let as_is = fitted(&judge, &thin)?;
    if as_is.is_cut || as_is.bad_runs().is_empty() {
        Ok(None)
    } else {
        wrong_value(&judge, &thin, &as_is, |_, _| true)
    }
}

/// The fit of the data without the readings of an output in some runs, and its cost, if these agree with the model.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn without(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    (output, runs): (usize, &[usize]),
    deadline: &Deadline,
) -> Result<Option<(Hypothesis, f64)>, CalibrateError> {
    let others = blanked(&thinned(experiment, ROWS), runs, experiment.place_of(output));
    let cost = fitted(&Judge::of(preset, &super::all_runs(experiment), deadline), &others)?;
    let agrees = !cost.is_cut && cost.bad_runs().is_empty();
    let whole = cost.whole();
    Ok(cost.best.filter(|_| agrees).map(|best| (best.hypothesis, whole)))
}

/// The fit of the data, whether they agree with the model or not; `None` if the deadline ends it.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn fit(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Hypothesis>, CalibrateError> {
    let all = super::all_runs(experiment);
    let cost = fitted(&Judge::of(preset, &all, deadline), &thinned(experiment, ROWS))?;
    Ok(cost.best.filter(|_| !cost.is_cut).map(|best| best.hypothesis))
}

/// The fit of the data as they are, if they agree with the model; otherwise each output is predicted by the fit of the others if these
/// agree. Strained parameters may compensate for a failed sensor and predict nothing.
fn references(
    judge: &Judge,
    experiment: &Experiment,
    as_is: Cost,
) -> Result<Vec<Option<Reference>>, CalibrateError> {
    let agrees = as_is.bad_runs().is_empty() && !as_is.is_cut;
    let is_strained = as_is.prior > STRAINED;
    let own = as_is.best.filter(|_| !is_strained).map(|best| best.hypothesis);
    let of = |output: usize| -> Result<Option<Reference>, CalibrateError> {
        if !agrees && !judge.deadline.is_near() {
            let others = fitted(judge, &blanked(experiment, judge.runs, experiment.place_of(output)))?;
            if !others.is_cut
                && others.bad_runs().is_empty()
                && let Some(best) = others.best
            {
                return Ok(Some(Reference { hypothesis: best.hypothesis, is_sure: true }));
            }
        }
        Ok(own.clone().map(|hypothesis| Reference { hypothesis, is_sure: agrees }))
    };
    (0..experiment.outputs.len()).map(of).collect()
}

/// The mistake in the columns of all runs, or a wrong `value` of the experiment, or the mistake in the columns of one file; `as_is` is the fit
/// of all runs.
fn mistaken(
    whole: &Judge,
    experiment: &Experiment,
    as_is: &Cost,
    value: Option<Unusable>,
) -> Result<Option<Unusable>, CalibrateError> {
    let (all, bad) = (whole.runs, as_is.bad_runs());
    let predicted = whole.predicted(experiment);
    // A mistake of one file spoils the fit of all: that of every run then leaves a contradiction, and a greater one.
    let mut everywhere: Option<(f64, Found)> = None;
    if 2 * bad.len() > all.len()
        && let Some(found) = search(whole, experiment, &predicted, "every run")?
    {
        let cost = fitted(whole, &found.data)?;
        if cost.is_cut || cost.bad_runs().is_empty() {
            return Ok(Some(found.why));
        }
        everywhere = Some((cost.whole(), found));
    }
    // One value of the experiment is the simpler cause of a contradiction in all files.
    if everywhere.is_none() && bad.len() == all.len() {
        let value = if value.is_some() { value } else { wrong_value(whole, experiment, as_is, is_exact)? };
        if value.is_some() {
            return Ok(value);
        }
    }
    // One of several loggers may be wrong: each file is checked separately.
    let files = files(experiment);
    for (file, runs) in files.iter().filter(|(_, runs)| files.len() > 1 && bad.contains(&runs[0])) {
        let alone = Judge { runs, ..whole.clone() };
        let own: Predicted = runs.iter().map(|r| predicted[*r].clone()).collect();
        if let Some(found) = search(&alone, experiment, &own, file)?
            && let as_meant = fitted(whole, &found.data)?
            && let cost = as_meant.whole()
            && is_of_one_motor(whole, as_is, as_meant, &found, runs)
            && !is_of_another_channel(whole, experiment, runs, &found)?
        {
            let Some((least, _)) = everywhere else { return Ok(Some(found.why)) };
            if cost + LEAST < least {
                everywhere = Some((cost, found));
            }
        } else if everywhere.is_none()
            && let Some(found) = beside(whole, experiment, (file, runs), &bad)?
        {
            return Ok(Some(found.why));
        }
    }
    Ok(everywhere.map(|(_, found)| found.why))
}

/// Whether one gain or offset of another channel makes a file agree with the motor of the others: a unit that is nearly that gain, of a channel
/// that follows from it, is not the mistake.
fn is_of_another_channel(
    whole: &Judge,
    experiment: &Experiment,
    runs: &[usize],
    found: &Found,
) -> Result<bool, CalibrateError> {
    let change = one_gain::beside_others(experiment, whole.preset, runs, &whole.deadline)?;
    let touched = found.why.mistake.as_ref().map_or(Vec::new(), |mistake| mistake.touches());
    Ok(change.is_some_and(|change| !touched.contains(&change.column)))
}

/// Whether the runs agree better with one motor if those of a file are as they are meant: a file by itself agrees with a motor of its own as
/// well. The runs of a file that is not fitted are predicted by the others. The costs are those of all runs.
fn is_of_one_motor(whole: &Judge, as_is: &Cost, as_meant: Cost, found: &Found, runs: &[usize]) -> bool {
    let is_fit = |run: &&usize| found.data.runs[**run].role == Role::Fit;
    let [own, all] = [runs, whole.runs].map(|runs| runs.iter().filter(is_fit).count());
    if as_meant.is_cut || own == all {
        return true;
    }
    if own == 0 {
        return as_meant.of(runs) < as_is.of(runs);
    }
    let as_meant = as_meant.stretched(as_is, found.stretch * own as f64 / all as f64);
    as_meant.whole() + as_meant.wider_than(as_is) < as_is.whole()
}

/// The files and their runs.
pub(super) fn files(experiment: &Experiment) -> Vec<(&str, Vec<usize>)> {
    let mut files: Vec<(&str, Vec<usize>)> = Vec::new();
    for (k, run) in experiment.runs.iter().enumerate() {
        match files.iter_mut().find(|(file, _)| *file == run.file) {
            Some((_, runs)) => runs.push(k),
            None => files.push((&run.file, vec![k])),
        }
    }
    files
}

/// Whether runs are longer by the square of [`FACTOR`] than the others usually are.
fn is_longer(experiment: &Experiment, runs: &[usize]) -> bool {
    let length = |k: usize| experiment.runs[k].table.span();
    let others = (0..experiment.runs.len()).filter(|k| !runs.contains(k)).map(length);
    runs.iter().any(|k| length(*k) > FACTOR * FACTOR * super::median(others.clone()))
}

/// The mistake in one file in comparison with the fit runs of the other files, if these agree with the model.
fn beside(
    whole: &Judge,
    experiment: &Experiment,
    (file, runs): (&str, &[usize]),
    bad: &[usize],
) -> Result<Option<Found>, CalibrateError> {
    let alone = Judge { runs, ..whole.clone() };
    let (beside, base) = agreeing(whole, experiment, runs, bad)?;
    if beside.is_empty() {
        return Ok(None);
    }
    // A run may have parameters of its own; the mistake is one number instead.
    let others = (experiment.priors.len() as f64 - 1.0).max(0.0);
    let readings = SAMPLES * (runs.len() * experiment.outputs.len()) as f64;
    let most = fitted(&alone, experiment)?.whole() + others * readings.ln();
    let judge = Judge { beside, base, most, ..alone };
    search(&judge, experiment, &judge.predicted(experiment), file)
}

/// The fit runs of other files with their fit, if they agree with the model: those that are not bad, or all if a mistake in one file spoils
/// the agreement of each.
fn agreeing(
    whole: &Judge,
    experiment: &Experiment,
    own: &[usize],
    bad: &[usize],
) -> Result<(Vec<usize>, Option<Hypothesis>), CalibrateError> {
    let is_other = |run: &usize| experiment.runs[*run].role == Role::Fit && !own.contains(run);
    let others: Vec<usize> = whole.runs.iter().copied().filter(is_other).collect();
    let good: Vec<usize> = others.iter().copied().filter(|run| !bad.contains(run)).collect();
    let runs = if good.is_empty() { others } else { good };
    if runs.is_empty() {
        return Ok((runs, None));
    }
    let cost = fitted(&Judge { runs: &runs, ..whole.clone() }, experiment)?;
    let agree = !cost.bad_runs().iter().any(|run| runs.contains(run));
    Ok(if agree { (runs, cost.best.map(|best| best.hypothesis)) } else { (Vec::new(), None) })
}

/// The experiment without the readings of a column in these runs.
fn blanked(experiment: &Experiment, runs: &[usize], column: usize) -> Experiment {
    let mut changed = experiment.clone();
    runs.iter().for_each(|run| changed.runs[*run].table.columns[column].fill(f64::NAN));
    changed
}
