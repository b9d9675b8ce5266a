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
//! hypothesis that changes the data: another unit, in either direction; a power of ten; a wrong sign; two columns exchanged; a
//! temperature rise over ambient recorded instead of a temperature; an ambient sensor heated by the motor; an input that was not
//! measured, with values implied by an output; an arbitrary factor; a wrong unit of time. The score of a hypothesis is
//! the sum of ln q_k. Hypotheses on outputs need no simulation; those on inputs are simulated only if some q is large. The best ones
//! are confirmed: the declared parameters are fitted to the data as they are and as changed by the hypothesis, with a
//! structure error of [`STRUCTURE`] of each output's size and [`SAMPLES`] independent readings per run as the noise. The data are
//! contradictory only if the minimum of the former is [`FACTOR`] times that of the latter: no values within the priors explain the data as
//! well.
//!
//! Before that, parameters without prior get one if their values in the preset contradict the data (`undeclared.rs`). Since a mistake may
//! stand beside them, the evidence counts for errors of the size above and for errors of unknown size: C the cost, n the number of
//! independent readings,
//!
//! evidence = min(C - C', n ln (C / C')) - ln n                                                       (3)
//!
//! *Source*: parameter bounds and residuals for fault isolation: Isermann, Fault-Diagnosis Systems (2006), ch. 9; likelihood ratio of
//! hypotheses: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

mod cost;
mod mistakes;
mod unmeasured;

use super::{Unusable, sorted};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Start};
use crate::hypothesis::Hypothesis;
use crate::levels::{CERTAIN, FACTOR, NEARLY, PART, STRUCTURE};
use crate::selection::LEAST;
use cost::{Cost, fitted};
use mistakes::{Mistake, mistakes};
use physics::declare::Unit;

/// Sum of squared parameter deviations over their priors above which parameters count as strained. Derivation: two at [`CERTAIN`].
const STRAINED: f64 = 2.0 * CERTAIN * CERTAIN;
/// Decrease of the score required for confirming a hypothesis. Derivation: the square of q of one output halves, so that the mistake
/// accounts for more than it leaves.
const FALL: f64 = 0.5 * std::f64::consts::LN_2;
/// Greatest number of simultaneous mistakes. Numerical: a limit of effort.
const MOST: usize = 3;
/// Greatest number of hypotheses confirmed for each. Numerical: a limit of effort; the best are tried first.
const SHORT: usize = 6;
/// q of an output without any agreement. Numerical: any value far above 1.
const MOST_OFF: f64 = 10.0;
/// Rows of a run that are compared; each is the mean over a constant number of readings. Numerical: a run comprises some tens of time
/// constants.
const ROWS: usize = 500;
/// Least size of a quantity, in SI units. Numerical: rounding.
const ROUNDING: f64 = 1e-9;
/// Least variation of a temperature in (2), K. Limit: smaller ones show no shape.
const LEAST_RISE: f64 = 0.5;
/// First and last difference of the common logarithm of a factor. Numerical: the factor is known to 1 %.
const POWERS: (f64, f64) = (0.25, 0.005);

/// Predictions of the model and their deviation from the data.
struct Judge<'a> {
    preset: &'a [(u32, f64)],
    runs: &'a [usize],
    deadline: Deadline,
}

/// Predictions by run, then by output.
type Predicted = Vec<Vec<Vec<f64>>>;

impl Judge<'_> {
    fn predicted(&self, experiment: &Experiment) -> Predicted {
        super::predicted(experiment, self.preset, self.runs, &self.deadline)
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
                    let all = sorted(rows.iter().map(|row| pick(row).powi(2)));
                    let kept = &all[..(all.len() * 9).div_ceil(10)];
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

/// Score, at full agreement, of the outputs that a mistake affects.
fn agreement(mistake: &Mistake, outputs: &[Option<(f64, f64)>], inputs: usize) -> f64 {
    let touched =
        mistake.touches().into_iter().filter_map(|k| outputs.get(k.checked_sub(inputs)?).copied().flatten());
    touched.count() as f64 * STRUCTURE.ln()
}

fn worst(outputs: &[Option<(f64, f64)>]) -> f64 {
    outputs.iter().flatten().map(|(q, _)| *q).fold(0.0, f64::max)
}

/// The experiment with means over neighbouring rows: sufficient for detecting a mistake, and faster to simulate.
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
    for table in thin.runs.iter_mut().map(|r| &mut r.table) {
        let length = table.time.len().div_ceil(most);
        let mean = |column: &[f64]| -> Vec<f64> {
            let of = |rows: &[f64]| {
                let there: Vec<f64> = rows.iter().copied().filter(|x| x.is_finite()).collect();
                there.iter().sum::<f64>() / there.len() as f64
            };
            column.chunks(length).map(of).collect()
        };
        table.columns = table.columns.iter().map(|c| mean(c)).collect();
        // The start time of a run is preserved.
        let first = table.time[0];
        table.time = mean(&table.time);
        table.time[0] = first;
    }
    thin
}

/// Reason why the data contradict the model, over all runs or in one file; otherwise the fit of the data as they are. Parameters without
/// a prior whose values in the preset contradict the data get one.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn contradiction(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Result<Option<Hypothesis>, Unusable>, CalibrateError> {
    let all: Vec<usize> = super::all_runs(experiment);
    let mut thin = thinned(experiment, ROWS);
    let whole = Judge { preset, runs: &all, deadline: deadline.clone() };
    let mut as_is = fitted(&whole, &thin)?;
    while !as_is.is_cut
        && !as_is.bad_runs().is_empty()
        && let Some((other, better)) = cost::released(&whole, &thin, &as_is)?
        && as_is.evidence(&better) > LEAST
    {
        (as_is, thin) = (better, other);
    }
    let bad = as_is.bad_runs();
    let unusable = if bad.is_empty() || as_is.is_cut { None } else { mistaken(&whole, &thin, &bad)? };
    experiment.priors = thin.priors;
    experiment.released = thin.released;
    // Strained parameters may compensate for a failed sensor.
    let best = as_is.best.filter(|_| as_is.prior <= STRAINED);
    Ok(unusable.map_or(Ok(best.map(|best| best.hypothesis)), Err))
}

/// The mistake in the columns of all runs, or in those of one file.
fn mistaken(
    whole: &Judge,
    experiment: &Experiment,
    bad: &[usize],
) -> Result<Option<Unusable>, CalibrateError> {
    let (all, preset) = (whole.runs, whole.preset);
    let predicted = whole.predicted(experiment);
    if 2 * bad.len() > all.len()
        && let Some(unusable) = search(whole, experiment, &predicted, "every run")?
    {
        return Ok(Some(unusable));
    }
    // One of several loggers may be wrong: each file is checked separately.
    let mut files: Vec<(&str, Vec<usize>)> = Vec::new();
    for (k, run) in experiment.runs.iter().enumerate() {
        match files.iter_mut().find(|(file, _)| *file == run.file) {
            Some((_, runs)) => runs.push(k),
            None => files.push((&run.file, vec![k])),
        }
    }
    for (file, runs) in files.iter().filter(|(_, runs)| files.len() > 1 && bad.contains(&runs[0])) {
        let judge = Judge { preset, runs, deadline: whole.deadline.clone() };
        let own: Predicted = runs.iter().map(|r| predicted[*r].clone()).collect();
        if let Some(unusable) = search(&judge, experiment, &own, file)? {
            return Ok(Some(unusable));
        }
    }
    Ok(None)
}

/// The combination of mistakes that gives the best agreement with the model, if no parameter values within the priors explain the
/// unchanged data nearly as well.
fn search(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    files: &str,
) -> Result<Option<Unusable>, CalibrateError> {
    let inputs = experiment.inputs.len();
    let mut at = experiment.clone();
    let mut predicted = predicted.clone();
    let mut found: Vec<Mistake> = Vec::new();
    let mut cost: Option<Cost> = None;
    while found.len() < MOST {
        let outputs = judge.outputs(&at, &predicted);
        let (now, worst_now) = (score(&outputs), worst(&outputs));
        let candidates = mistakes(&at);
        let taken = |m: &Mistake| m.touches().iter().any(|k| found.iter().any(|f| f.touches().contains(k)));
        let mut best: Vec<Changed> = Vec::new();
        let try_one = |best: &mut Vec<Changed>, mistake: Mistake| {
            let mut changed = at.clone();
            mistake.apply(&mut changed, judge.runs);
            if !is_possible(&changed, &mistake) {
                return;
            }
            let shown =
                if mistake.is_simulated(inputs) { judge.predicted(&changed) } else { predicted.clone() };
            let after = judge.outputs(&changed, &shown);
            if agrees_more(&outputs, &after) {
                best.push((score(&after), mistake, changed, shown));
                shortlist(best);
            }
        };
        // Outputs first, because they need no simulation; then inputs; arbitrary factors last.
        for mistake in candidates.iter().filter(|m| !taken(m) && !m.is_simulated(inputs)) {
            // Upper bound of the gain: full agreement of the affected outputs.
            let own =
                mistake.touches().into_iter().filter_map(|k| outputs.get(k.checked_sub(inputs)?).copied());
            if score(&own.collect::<Vec<_>>()) >= FALL + agreement(mistake, &outputs, inputs) {
                try_one(&mut best, mistake.clone());
            }
        }
        for mistake in candidates.iter().filter(|m| !taken(m) && m.is_simulated(inputs)) {
            if worst_now < PART || judge.deadline.is_over() {
                break;
            }
            try_one(&mut best, mistake.clone());
        }
        let is_explained = |best: &[Changed]| best.first().is_some_and(|(value, ..)| *value < now - FALL);
        // An arbitrary factor is tried only if no usual mistake explains the data.
        if !is_explained(&best) && !judge.deadline.is_over() {
            for (k, output) in outputs.iter().enumerate() {
                if let Some((_, ratio)) = output.filter(|(q, r)| *q > PART && r.is_finite() && *r != 0.0)
                    && !(1.0 / FACTOR..=FACTOR).contains(&ratio)
                    && !at.outputs[k].is_temperature()
                {
                    let words = format!("readings divided by {ratio:.3}");
                    let columns = vec![inputs + k];
                    let mistake = Mistake::Affine { columns, factor: 1.0 / ratio, offset: 0.0, words };
                    if !taken(&mistake) {
                        try_one(&mut best, mistake);
                    }
                }
            }
        }
        if worst_now > 2.0 * PART && !is_explained(&best) {
            let of = any_factor(judge, &at).into_iter();
            best.extend(of.filter(|one| agrees_more(&outputs, &judge.outputs(&one.2, &one.3))));
            shortlist(&mut best);
        }
        best.retain(|(value, ..)| *value < now - FALL);
        // Exchanged thermometers, or a common wrong unit, hardly change the shapes.
        for mistake in candidates.iter().filter(|m| !taken(m) && m.is_alike(&at)) {
            let mut changed = at.clone();
            mistake.apply(&mut changed, judge.runs);
            if is_possible(&changed, mistake) {
                let shown =
                    if mistake.is_simulated(inputs) { judge.predicted(&changed) } else { predicted.clone() };
                best.push((score(&judge.outputs(&changed, &shown)), mistake.clone(), changed, shown));
            }
        }
        let implied = unmeasured::of(judge, &at, &predicted, &outputs);
        best.extend(implied.into_iter().filter(|one| !taken(&one.1)));
        if best.is_empty() {
            break;
        }
        let as_is = match cost.take() {
            Some(cost) => cost,
            None => fitted(judge, &at)?,
        };
        if as_is.is_cut {
            break;
        }
        let mut confirmed: Option<(Cost, Changed)> = None;
        for one in best {
            let as_meant = fitted(judge, &one.2)?;
            // An output that implies an input is not evidence: both costs are computed without it.
            let without = match one.1 {
                Mistake::Unmeasured { by, .. } => Some(fitted(judge, &blanked(&at, judge.runs, by))?),
                _ => None,
            };
            if without.as_ref().unwrap_or(&as_is).is_worse_than(&as_meant)
                && confirmed.as_ref().is_none_or(|(least, _)| as_meant.whole() < NEARLY * least.whole())
            {
                confirmed = Some((as_meant, one));
            }
        }
        let Some((as_meant, (_, mistake, changed, shown))) = confirmed else { break };
        found.push(mistake);
        (at, predicted, cost) = (changed, shown, Some(as_meant));
    }
    let Some(first) = found.first() else { return Ok(None) };
    let (channel, mut reason, mut suggestion) = first.words(experiment, files);
    for mistake in &found[1..] {
        let (_, further, what) = mistake.words(experiment, files);
        reason = format!("{reason}; {further}");
        suggestion = format!("{suggestion}; {what}");
    }
    Ok(Some(Unusable { channel, reason, suggestion }))
}

/// The experiment without the readings of a column in these runs.
fn blanked(experiment: &Experiment, runs: &[usize], column: usize) -> Experiment {
    let mut changed = experiment.clone();
    runs.iter().for_each(|run| changed.runs[*run].table.columns[column].fill(f64::NAN));
    changed
}

/// Keeps the best few, best first; among equals the first that was tried.
fn shortlist(best: &mut Vec<Changed>) {
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Of those that change the same columns, only the best is kept.
    let mut seen: Vec<Vec<usize>> = Vec::new();
    best.retain(|one| {
        let own = one.1.touches();
        let is_new = !seen.contains(&own);
        seen.push(own);
        is_new
    });
    best.truncate(SHORT);
}

/// Whether the inputs that a mistake changes are within the limits of their variables.
fn is_possible(changed: &Experiment, mistake: &Mistake) -> bool {
    let declaration = super::declaration(changed);
    mistake.touches().into_iter().filter(|k| *k < changed.inputs.len()).all(|k| {
        let entry = changed.inputs[k].input.and_then(|name| declaration?.by_name(name));
        let middle = super::median(changed.runs.iter().flat_map(|r| r.table.columns[k].iter().copied()));
        entry.is_none_or(|e| (e.row.min..=e.row.max).contains(&middle))
    })
}

/// Whether one output agrees better and no output that agreed is now far off.
fn agrees_more(before: &[Option<(f64, f64)>], after: &[Option<(f64, f64)>]) -> bool {
    let pairs = || before.iter().flatten().zip(after.iter().flatten()).map(|((a, _), (b, _))| (*a, *b));
    pairs().any(|(a, b)| b < PART && b < 0.5 * a) && !pairs().any(|(a, b)| a < PART && b > PART)
}

/// Corrected mistake: score, mistake, changed data and their prediction.
type Changed = (f64, Mistake, Experiment, Predicted);

/// Each input with the factor that gives the best agreement with the model.
fn any_factor(judge: &Judge, experiment: &Experiment) -> Vec<Changed> {
    let mut found = Vec::new();
    for (k, channel) in experiment.inputs.iter().enumerate() {
        if matches!(channel.unit, Unit::Kelvin | Unit::Pascal | Unit::One) {
            continue;
        }
        let tried = |power: f64| {
            let factor = 10f64.powf(power);
            let words = format!("readings times {factor:.3}");
            let mistake = Mistake::Affine { columns: vec![k], factor, offset: 0.0, words };
            let mut changed = experiment.clone();
            mistake.apply(&mut changed, judge.runs);
            let shown = judge.predicted(&changed);
            (score(&judge.outputs(&changed, &shown)), mistake, changed, shown)
        };
        let mut best: Option<(f64, Changed)> = None;
        let mut step = POWERS.0;
        let mut powers: Vec<f64> =
            (-12..=12).map(|k| f64::from(k) * step).filter(|p| p.abs() > FACTOR.log10()).collect();
        while step > POWERS.1 {
            for power in std::mem::take(&mut powers) {
                if judge.deadline.is_over() {
                    break;
                }
                let one = tried(power);
                if best.as_ref().is_none_or(|(_, least)| one.0 < least.0) {
                    best = Some((power, one));
                }
            }
            step *= 0.5;
            let Some((at, _)) = &best else { break };
            powers = vec![at - step, at + step];
            powers.retain(|p| p.abs() > FACTOR.log10());
        }
        found.extend(best.map(|(_, one)| one));
    }
    found
}
