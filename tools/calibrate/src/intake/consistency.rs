//! Units, signs, columns and clocks that contradict the model.
//!
//! For every output k, over the rows of the runs,
//!
//! q_k = |y - p| / max(|y|, |p|)                                                                    (1)
//!
//! (root mean squares without the tenth of the rows that is furthest off; p the preset's prediction). A temperature, to which an effect
//! that the model lacks can add as much again, is compared by its shape, its start and the order of its size:
//!
//! q_k^2 = 1 - r^2 + (|y_0 - p_0| / s)^2 + (|ln(s_y / s_p)| - ln 2.5)_+^2                            (2)
//!
//! r the correlation of y and p, s their standard deviations. The question is asked only if the declared parameters, fitted with the
//! structure error below, leave more than [`GOOD`] times of it in a run. A
//! mistake in a column is a hypothesis that changes the data: another unit, in either direction; a power of ten; a wrong sign; two columns
//! exchanged; a rise over ambient in place of a temperature; an ambient sensor that the motor heats; an input that was not
//! measured, whose values an output implies; any factor; a wrong unit of the time. The score of a hypothesis is
//! the sum of ln q_k. Hypotheses over outputs cost nothing; those over inputs are simulated only if some q is large. The best ones
//! are confirmed: the declared parameters are fitted with the data as they are and as the hypothesis would have them, with a
//! structure error of [`STRUCTURE`] of each output's size and [`SAMPLES`] independent readings in each run as the noise. Only where
//! the minimum of the former is [`WORSE`] times that of the latter are the data contradictory: no values that the priors allow do as well.
//!
//! *Source*: parameter bounds and residuals for fault isolation: Isermann, Fault-Diagnosis Systems (2006), ch. 9; likelihood ratio of
//! hypotheses: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

mod mistakes;
mod unmeasured;

use super::{Unusable, sorted, structured};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role, Start};
use crate::hypothesis::Hypothesis;
use mistakes::{Mistake, mistakes};
use physics::declare::Unit;
use std::time::Duration;

/// Error of a model without the effect that is looked for, as a fraction of an output's size: the refit of a bench that lacks one is 1 to 5 % off.
pub(super) const STRUCTURE: f64 = 0.02;
/// Independent readings of a run: it has some tens of time constants.
pub(super) const SAMPLES: f64 = 50.0;
/// Ratio and difference of (minus twice the logarithm of) the likelihoods of data and hypothesis: the latter is that of 1e-21 odds.
pub(super) const WORSE: (f64, f64) = (2.5, 100.0);
/// Residual of a run over the structure error, as a mean over outputs, from which on mistakes are looked for.
const GOOD: f64 = 3.0;
/// Sum of squares of the declared parameters over their priors from which on they are: two of them four deviations off.
const STRAINED: f64 = 32.0;
/// Difference of two costs of an output that count as different.
const CHANGED: f64 = 20.0;
/// q of an output from which on hypotheses over inputs are simulated.
const SUSPECT: f64 = 0.25;
/// q below which an output agrees, and no better.
const AGREES: f64 = 0.02;
/// Fall of the score that a hypothesis needs to be confirmed: q of one output by a third.
const FALL: f64 = 0.35;
/// Most mistakes at once, and hypotheses that are confirmed for each.
const MOST: usize = 3;
const SHORT: usize = 6;
/// Factors nearer to 1 than this can be physics.
const PHYSICAL: f64 = 2.5;
/// q of what does not agree at all.
const MOST_OFF: f64 = 10.0;
/// Rows of a run that are compared: means over as many rows each.
const ROWS: usize = 500;
/// Time for the search, and for the fit of a hypothesis: one that is not at its minimum in time is not confirmed.
const SEARCH: Duration = Duration::from_secs(6);
const FIT: Duration = Duration::from_secs(3);
/// Time for the fit of the data as they are. If it is not at its minimum by then, as on a busy machine, nothing is concluded:
/// its cost would refuse good data.
const AS_IS: Duration = Duration::from_secs(30);

/// What the model predicts and how far data are from it.
struct Judge<'a> {
    preset: &'a [(u32, f64)],
    runs: &'a [usize],
    deadline: Deadline,
}

/// Predictions run by run, output by output.
type Predicted = Vec<Vec<Vec<f64>>>;

impl Judge<'_> {
    fn predicted(&self, experiment: &Experiment) -> Predicted {
        super::predicted(experiment, self.preset, self.runs)
    }

    /// (1), and the ratio of reading to prediction that is best, output by output; `None` where nothing was measured.
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
            // A model that cannot be run explains nothing.
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
                let whole = size(&|(y, _)| *y).max(size(&|(_, p)| *p)).max(1e-9);
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
    let (mut yy, mut pp, mut yp) = (1e-9, 1e-9, 0.0);
    for (a, b) in rows {
        yy += (a - y).powi(2);
        pp += (b - p).powi(2);
        yp += (a - y) * (b - p);
    }
    let size = (yy.max(pp) / n).sqrt().max(0.5);
    let unlike = if yp > 0.0 { 1.0 - yp * yp / (yy * pp) } else { 1.0 };
    let scale = (0.5 * (yy / pp).ln().abs() - PHYSICAL.ln()).max(0.0);
    let start = if start.is_finite() { start / size } else { 0.0 };
    (unlike + scale * scale + start * start).sqrt()
}

fn score(outputs: &[Option<(f64, f64)>]) -> f64 {
    outputs
        .iter()
        .flatten()
        .map(|(q, _)| if q.is_finite() { q.max(AGREES).ln() } else { MOST_OFF.ln() })
        .sum()
}

/// The score that the outputs which a mistake touches have when they agree.
fn agreement(mistake: &Mistake, outputs: &[Option<(f64, f64)>], inputs: usize) -> f64 {
    let touched =
        mistake.touches().into_iter().filter_map(|k| outputs.get(k.checked_sub(inputs)?).copied().flatten());
    touched.count() as f64 * AGREES.ln()
}

fn worst(outputs: &[Option<(f64, f64)>]) -> f64 {
    outputs.iter().flatten().map(|(q, _)| *q).fold(0.0, f64::max)
}

/// The experiment with means over neighbouring rows, which is enough to see a mistake and costs less to simulate.
pub(super) fn thinned(experiment: &Experiment, most: usize) -> Experiment {
    let mut thin = experiment.clone();
    // A sensor that stands still contradicts whatever it is taken for.
    for table in thin.runs.iter_mut().map(|r| &mut r.table) {
        for column in &mut table.columns[experiment.inputs.len()..] {
            let first = super::median(column.iter().copied());
            let still = column.iter().filter(|x| **x == first).count();
            if still as f64 > 0.9 * column.iter().filter(|x| x.is_finite()).count() as f64 {
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
        // A run starts where it started.
        let first = table.time[0];
        table.time = mean(&table.time);
        table.time[0] = first;
    }
    thin
}

/// Why the data contradict the model, over all runs or in one file; else the fit of the data as they are.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn contradiction(
    experiment: &Experiment,
    preset: &[(u32, f64)],
) -> Result<Result<Option<Hypothesis>, Unusable>, CalibrateError> {
    let all: Vec<usize> = super::all_runs(experiment);
    let experiment = &thinned(experiment, ROWS);
    let mut whole = Judge { preset, runs: &all, deadline: Deadline::default() };
    let Cost { runs: costs, prior, is_cut, hypothesis, .. } = fitted(&whole, experiment, AS_IS)?;
    // Not before: a fit that took long would leave no time for the hypotheses over inputs.
    whole.deadline = Deadline::after(SEARCH);
    // Parameters that are strained may stand in for a sensor that does not work.
    let hypothesis = hypothesis.filter(|_| prior <= STRAINED);
    let limit = GOOD * GOOD * SAMPLES * experiment.outputs.len() as f64;
    let bad: Vec<usize> = all.iter().copied().filter(|r| costs[*r] > limit || prior > STRAINED).collect();
    if bad.is_empty() || is_cut {
        return Ok(Ok(hypothesis));
    }
    let predicted = whole.predicted(experiment);
    if 2 * bad.len() > all.len()
        && let Some(unusable) = search(&whole, experiment, &predicted, "every run")?
    {
        return Ok(Err(unusable));
    }
    // One logger of several: a file at a time.
    let mut files: Vec<(&str, Vec<usize>)> = Vec::new();
    for (k, run) in experiment.runs.iter().enumerate() {
        match files.iter_mut().find(|(file, _)| *file == run.file) {
            Some((_, runs)) => runs.push(k),
            None => files.push((&run.file, vec![k])),
        }
    }
    let deadline = Deadline::after(SEARCH);
    for (file, runs) in files.iter().filter(|(_, runs)| files.len() > 1 && bad.contains(&runs[0])) {
        let judge = Judge { preset, runs, deadline: deadline.clone() };
        let own: Predicted = runs.iter().map(|r| predicted[*r].clone()).collect();
        if let Some(unusable) = search(&judge, experiment, &own, file)? {
            return Ok(Err(unusable));
        }
    }
    Ok(Ok(hypothesis))
}

/// The mistakes that together bring the data nearest to the model, if no values that the priors allow explain the data as they are nearly
/// as well.
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
        // First the outputs, which need no simulation; then the inputs; at last any factor.
        for mistake in candidates.iter().filter(|m| !taken(m) && !m.is_simulated(inputs)) {
            // At best it brings the outputs that it touches to full agreement.
            let own =
                mistake.touches().into_iter().filter_map(|k| outputs.get(k.checked_sub(inputs)?).copied());
            if score(&own.collect::<Vec<_>>()) >= FALL + agreement(mistake, &outputs, inputs) {
                try_one(&mut best, mistake.clone());
            }
        }
        for mistake in candidates.iter().filter(|m| !taken(m) && m.is_simulated(inputs)) {
            if worst_now < SUSPECT || judge.deadline.is_over() {
                break;
            }
            try_one(&mut best, mistake.clone());
        }
        let is_explained = |best: &[Changed]| best.first().is_some_and(|(value, ..)| *value < now - FALL);
        // Any factor stands for what no usual mistake explains: not before all of those are tried.
        if !is_explained(&best) && !judge.deadline.is_over() {
            for (k, output) in outputs.iter().enumerate() {
                if let Some((_, ratio)) = output.filter(|(q, r)| *q > SUSPECT && r.is_finite() && *r != 0.0)
                    && !(1.0 / PHYSICAL..=PHYSICAL).contains(&ratio)
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
        if worst_now > 2.0 * SUSPECT && !is_explained(&best) {
            let of = any_factor(judge, &at).into_iter();
            best.extend(of.filter(|one| agrees_more(&outputs, &judge.outputs(&one.2, &one.3))));
            shortlist(&mut best);
        }
        best.retain(|(value, ..)| *value < now - FALL);
        // Exchanged thermometers, and all of them in another unit, have nearly the same shapes.
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
            None => fitted(judge, &at, AS_IS)?,
        };
        if as_is.is_cut {
            break;
        }
        let mut confirmed: Option<(Cost, Changed)> = None;
        for one in best {
            let as_meant = fitted(judge, &one.2, FIT)?;
            // An output that implies an input is no evidence: both sides are judged without it.
            let without = match one.1 {
                Mistake::Unmeasured { by, .. } => Some(fitted(judge, &blanked(&at, judge.runs, by), FIT)?),
                _ => None,
            };
            if without.as_ref().unwrap_or(&as_is).is_worse_than(&as_meant)
                && confirmed.as_ref().is_none_or(|(least, _)| as_meant.whole() < 0.9 * least.whole())
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

/// Keeps the best few, the best one first; of equals the first that was tried.
fn shortlist(best: &mut Vec<Changed>) {
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Of those that change the same columns, the best.
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

/// Whether an output agrees better, and none is far off that agreed.
fn agrees_more(before: &[Option<(f64, f64)>], after: &[Option<(f64, f64)>]) -> bool {
    let pairs = || before.iter().flatten().zip(after.iter().flatten()).map(|((a, _), (b, _))| (*a, *b));
    pairs().any(|(a, b)| b < SUSPECT && b < 0.5 * a)
        && !pairs().any(|(a, b)| a < SUSPECT && b > (1.5 * a).max(0.15))
}

/// A mistake taken back: the score, the mistake, the data and what is predicted for them.
type Changed = (f64, Mistake, Experiment, Predicted);

/// Each input with the factor that brings it nearest to the model.
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
        let mut step = 0.25;
        let mut powers: Vec<f64> =
            (-12..=12).map(|k| f64::from(k) * step).filter(|p| p.abs() > PHYSICAL.log10()).collect();
        while step > 0.005 {
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
            powers.retain(|p| p.abs() > PHYSICAL.log10());
        }
        found.extend(best.map(|(_, one)| one));
    }
    found
}

/// The minimum over the declared parameters, output by output, and of their priors.
struct Cost {
    outputs: Vec<f64>,
    prior: f64,
    /// Of each run of the experiment, fitted or not.
    runs: Vec<f64>,
    /// Whether the time ended before the fit was at its minimum.
    is_cut: bool,
    /// Where it is; `None` where the model cannot be run.
    hypothesis: Option<Hypothesis>,
}

impl Cost {
    fn whole(&self) -> f64 {
        self.outputs.iter().sum::<f64>() + self.prior
    }

    /// Whether it is worse in the outputs in which the two differ. The others may lack an effect that has nothing to do with it.
    fn is_worse_than(&self, other: &Cost) -> bool {
        let pairs =
            self.outputs.iter().zip(&other.outputs).filter(|(own, other)| (*own - *other).abs() > CHANGED);
        let (own, meant) = pairs.fold((self.prior, other.prior), |(a, b), (own, other)| (a + own, b + other));
        own > WORSE.0 * meant && self.whole() > other.whole() + WORSE.1
    }
}

/// The cost of the best values of the declared parameters, with structure errors for the noise.
fn fitted(judge: &Judge, experiment: &Experiment, time: Duration) -> Result<Cost, CalibrateError> {
    let fit: Vec<usize> =
        judge.runs.iter().copied().filter(|r| experiment.runs[*r].role == Role::Fit).collect();
    let runs = if fit.is_empty() { judge.runs.to_vec() } else { fit };
    let setup = structured(experiment, judge.preset, &runs)?.until(Deadline::after(time));
    let all = super::all_runs(experiment);
    let cost = setup.refit(&runs).and_then(|fitted| {
        let shown = setup.show(&fitted.hypothesis, &all)?;
        let of = |r: &usize| setup.chi_square(&[*r], &shown[*r..=*r]).0;
        Ok(Cost {
            outputs: setup.chi_squares(&runs, &fitted.shown),
            prior: fitted.cost - fitted.chi_square,
            runs: all.iter().map(of).collect(),
            is_cut: setup.deadline().is_near(),
            hypothesis: Some(fitted.hypothesis),
        })
    });
    // A model that cannot be run explains nothing.
    Ok(cost.unwrap_or_else(|_| Cost {
        outputs: vec![f64::MAX; setup.outputs()],
        prior: 0.0,
        runs: vec![f64::INFINITY; all.len()],
        is_cut: setup.deadline().is_near(),
        hypothesis: None,
    }))
}
