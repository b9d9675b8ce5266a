//! Final estimates: results of the identification loop in the form of a report.

use crate::CalibrateError;
use crate::beyond;
use crate::blackbox::black_boxes;
use crate::close_loop::Judgement;
use crate::comparison::{self, apart, with_unit};
use crate::deadline::Deadline;
use crate::experiment::{Channel, Role};
use crate::hypothesis::{Addition, Hypothesis};
use crate::instruments;
use crate::levels::{AT_NOISE, DECISIVE, PART, STRUCTURE, SURE};
use crate::linearization::Linearization;
use crate::one_gain;
use crate::outcome::{ChannelError, Curve, Curves, Estimate, Limit, Outcome, Prediction, Setting, Whiteness};
use crate::parallel;
use crate::prediction;
use crate::report::{ROLES, column_words};
use crate::selection::at_limit;
use crate::setup::{Declared, Setup, Shown};
use crate::strain;
use nalgebra::DMatrix;
use physics::terms::Port;

/// One-sided 95 % quantile of the standard normal distribution. Definition: 95 % of the distribution are below.
const BELOW: f64 = 1.645;
/// Two parameters with at least this correlation are reported as hardly distinguishable. Source: O'Brien, Quality & Quantity 41 (2007)
/// 673-690; the variance inflation 1 / (1 - r^2) is 5.3, rules of thumb are 4 to 10.
const CORRELATED: f64 = 0.9;

/// The outcome of a search; `first` is the naive fit, linearised.
///
/// # Errors
/// The model's error if it cannot be simulated.
pub fn outcome(setup: &Setup, first: &Linearization, judged: Judgement) -> Result<Outcome, CalibrateError> {
    // What was found with means over rows is evaluated at the rows as measured.
    let means = setup;
    let setup = &means.at_all_rows(&judged.hypothesis)?;
    let experiment = setup.experiment;
    let point = judged.point.as_ref().unwrap_or(first);
    let mut hypothesis = judged.hypothesis;
    let mut notes = means.experiment.notes.clone();
    notes.extend(judged.notes);
    let mut corrected = hypothesis.clone();
    let (mut naive, _) = estimates(means, first, None, None);
    naive.truncate(setup.declared.len());
    let (mut estimates_of, covariance) = estimates(means, point, None, Some(&mut corrected));
    let exact = setup.exact();
    // Without an added effect, the model remains the fit to the indicated values: estimated jointly with a disturbance that the model does not
    // get, the parameters predict worse. A correction that increases the error, or with a law at its limit, is rejected.
    let is_possible = corrected.additions.iter().all(|a| at_limit(a).is_none());
    if !hypothesis.additions.is_empty() && is_possible && is_no_worse(&exact, &corrected, &hypothesis)? {
        hypothesis = corrected;
    }
    if let Some((beside, port)) = &judged.beside {
        let (others, _) = estimates(means, beside, Some(*port), None);
        // Range of the parameters if the law at this port differs from the assumed one.
        for (estimate, other) in estimates_of.iter_mut().zip(others) {
            let ((a, b), (c, d)) = (estimate.ci95, other.ci95);
            *estimate = Estimate { value: estimate.value, ci95: (a.min(c), b.max(d)), ..other };
        }
    }
    // Values are those of the exported model. Where it is not the joint estimate with sensor drift, an interval is that of either.
    let scales = setup.scales(&hypothesis);
    for ((estimate, value), (_, limits, _)) in estimates_of.iter_mut().zip(hypothesis.numbers()).zip(scales) {
        (estimate.value, estimate.ci95) = (value, of_either(value, estimate.ci95, limits));
    }
    notes.extend(strain::notes(experiment, &setup.declared, &hypothesis.declared));
    for (d, value) in setup.declared.iter().zip(&hypothesis.declared).filter(|(d, _)| d.is_released) {
        let [own, other] = apart([d.prior, *value], d.unit);
        notes.push(format!(
            "{name} has no prior, but its value {} in the preset contradicts the data, and no effect explains them better than another \
             value: {} was estimated; add {name} to [prior], or to [set] if its value is known",
            own,
            other,
            name = d.name
        ));
    }
    let mut effects = judged.effects;
    let declared = setup.declared.len();
    let mut rest = estimates_of[declared..].iter();
    for (found, addition) in effects.iter_mut().zip(&hypothesis.additions) {
        for number in &addition.numbers {
            let mut estimate = if number.sloped { rest.next().cloned() } else { None }.unwrap_or_else(|| {
                let half = SURE * number.scale;
                let ci95 = (number.value - half, number.value + half);
                Estimate { name: String::new(), value: number.value, ci95, prior: 0.0, unit: number.unit }
            });
            estimate.name = number.symbol.clone();
            found.parameters.push(estimate);
        }
        found.term = addition.term();
    }
    // In reports listed effects come first.
    effects.sort_by_key(|found| found.term.is_some());
    // Parameters of single runs follow those common to all runs.
    let common = setup.declared.iter().filter(|d| d.runs.is_none()).count();
    naive.truncate(common);
    let file = |d: &Declared| Some(experiment.runs[*d.runs.as_ref()?.first()?].file.clone());
    let name = |d: &Declared, file: &str| d.name.trim_end_matches(&format!(" [{file}]")).to_string();
    let of_runs: Vec<(String, Estimate)> = setup.declared[common..]
        .iter()
        .zip(&estimates_of[common..])
        .filter_map(|(d, e)| {
            file(d).map(|file| (file.clone(), Estimate { name: name(d, &file), ..e.clone() }))
        })
        .collect();
    let all: Vec<usize> = (0..experiment.runs.len()).collect();
    let before = exact.show(&setup.preset(), &all)?;
    let fitted = exact.show(&first.fitted.hypothesis, &all)?;
    let (after, ends): (Vec<Shown>, Vec<_>) = exact.show_to_end(&hypothesis, &all)?.into_iter().unzip();
    let ended = |(run, why): (&usize, Option<String>)| {
        why.map(|why| {
            format!("{}: the calibrated model does not reach the last row. {why}", experiment.runs[*run].file)
        })
    };
    let endings: Vec<String> = all.iter().zip(ends).filter_map(ended).collect();
    notes.extend(endings.iter().cloned());
    let mut boxes = black_boxes(means, &Deadline::after(judged.time_for_boxes));
    if means.all_rows.is_some() {
        boxes.iter_mut().for_each(|own| own.at_all_rows(means, setup));
    }
    let mut errors = Vec::new();
    let mut half_widths = vec![Shown::new(); all.len()];
    // The structure error of the fit runs, then that of the validation runs as predicted from the fit runs.
    let mut structure = None;
    for role in ROLES {
        let runs = setup.runs(role);
        let pick = |shown: &[Shown]| runs.iter().map(|r| shown[*r].clone()).collect::<Vec<Shown>>();
        let rmse = |shown: &[Shown]| setup.rmse(&runs, &pick(shown));
        if runs.is_empty() {
            continue;
        }
        let (b, r, a) = (rmse(&before), rmse(&fitted), rmse(&after));
        let slopes = setup.input_sensitivities(&hypothesis, &runs)?;
        if role != Role::Fit {
            notes.extend(beyond::notes(setup, &hypothesis, role, &runs, &slopes));
        }
        let (direct, whole) = setup.input_noise(&slopes);
        let variances = parallel::indices(runs.len(), |place| {
            prediction::variance(setup, &hypothesis, &slopes, place, &covariance)
        });
        let own: Vec<&Shown> = runs.iter().map(|r| &after[*r]).collect();
        let of_fit_runs = judged.of_fit_runs.as_ref().filter(|_| role == Role::Validate);
        let of_fit_runs = of_fit_runs.map(|h| exact.show(h, &runs)).transpose()?;
        let predicted = of_fit_runs.as_ref().map_or_else(|| own.clone(), |all| all.iter().collect());
        let of_role = prediction::structure(setup, &runs, &predicted, &variances);
        notes.extend(of_fit_runs.map(|predicted| jointly(setup, &setup.rmse(&runs, &predicted))));
        let used = structure.get_or_insert_with(|| of_role.clone());
        for (run, variance) in runs.iter().zip(&variances) {
            half_widths[*run] = prediction::half_widths(setup, &after[*run], variance, used);
        }
        structure = Some(of_role);
        let widths: Vec<&Shown> = runs.iter().map(|r| &half_widths[*r]).collect();
        let predictions = prediction::coverage(setup, &runs, &own, &widths);
        for (k, channel) in experiment.outputs.iter().enumerate().filter(|(k, _)| b[*k].is_finite()) {
            // The output noise already includes the input noise propagated within a row.
            let floor = (setup.sensor_noise(k).powi(2) + (whole[k] - direct[k]).max(0.0)).sqrt();
            let column = channel.column;
            let of_box =
                |b: &crate::outcome::BlackBox| b.errors.iter().find(|(r, _)| *r == role).map(|(_, e)| *e);
            let blackbox = boxes.iter().find(|b| b.column == column).and_then(of_box);
            errors.push(ChannelError {
                role,
                column,
                before: b[k],
                refit: r[k],
                after: a[k],
                floor,
                instruments: instruments::error(experiment, &runs, k),
                blackbox,
                prediction: Prediction { half_width: predictions[k].0, inside: predictions[k].1 },
            });
        }
    }
    notes.extend(disagreement(setup, &errors));
    if let Some(odd) = &experiment.odd_file
        && describes_all_runs(&hypothesis, &errors)
    {
        notes.retain(|note| *note != odd.note);
    }
    match wrong_tests(setup, &hypothesis, &errors) {
        wrong if wrong.is_empty() => {
            notes.extend(comparison::notes(&errors, &boxes, judged.verdict, judged.is_cut))
        }
        wrong => notes.extend(wrong),
    }
    let added =
        hypothesis.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped).map(move |n| (a, n)));
    let names: Vec<String> = setup
        .declared
        .iter()
        .map(|d| d.name.clone())
        .chain(added.map(|(a, n)| format!("{}.{}", a.id, n.symbol)))
        .collect();
    let mut correlated = Vec::new();
    for a in 0..covariance.nrows() {
        for b in 0..a {
            let size = (covariance[(a, a)] * covariance[(b, b)]).sqrt();
            let correlation = if size > 0.0 { covariance[(a, b)] / size } else { 0.0 };
            if correlation.abs() > CORRELATED {
                correlated.push((names[b].clone(), names[a].clone(), correlation));
            }
        }
    }
    let settings = all.iter().map(|run| setting(setup, &hypothesis, *run)).collect::<Result<Vec<_>, _>>()?;
    // The exported model starts at ambient temperature, regardless of the run's initial state.
    let roles = [Role::Test, Role::Validate, Role::Fit];
    let exported = roles.iter().find_map(|role| setup.runs(*role).first().copied()).unwrap_or(0);
    let values = setup.bench.values(&setup.drives[exported], &setup.common_change(&hypothesis, exported));
    let export = Setting { values, ..settings[exported].clone() };
    Ok(Outcome {
        name: experiment.name.clone(),
        model: setup.bench.declaration().name,
        verdict: judged.verdict,
        effects,
        unexplained: judged.unexplained,
        parameters: estimates_of[..common].to_vec(),
        released: setup.declared.iter().filter(|d| d.is_released).map(|d| d.name.clone()).collect(),
        of_runs,
        refit: naive,
        correlated,
        errors,
        localised: judged.localised,
        candidate_table: judged.candidate_table,
        whiteness: whiteness(means, first, point),
        limits: limits(point),
        curves: all
            .iter()
            .map(|run| curves(setup, *run, [&before[*run], &fitted[*run], &after[*run]], &half_widths[*run]))
            .collect(),
        settings,
        export,
        notes,
        endings,
        boxes,
        is_cut: judged.is_cut,
        left_out: None,
        seconds: 0.0,
    })
}

/// Whether the final model describes all fit and validation runs with effects that act in each of them: then no file disagrees with the others.
fn describes_all_runs(found: &Hypothesis, errors: &[ChannelError]) -> bool {
    errors.iter().all(|e| e.role == Role::Test || e.unexplained().is_none())
        && found.additions.iter().all(Addition::is_in_every_run)
}

/// One sentence for each test file in which one channel is wrong: the model describes the fit and validation runs, and that file with another
/// gain.
fn wrong_tests(setup: &Setup, found: &Hypothesis, errors: &[ChannelError]) -> Vec<String> {
    let is_left = |role: Role| errors.iter().any(|e| e.role == role && e.unexplained().is_some());
    if !is_left(Role::Test) || is_left(Role::Fit) || is_left(Role::Validate) {
        return Vec::new();
    }
    let of = |runs: &Vec<usize>| {
        let (file, change) = (&setup.experiment.runs[runs[0]].file, one_gain::of(setup, found, runs)?);
        Some(format!(
            "{file} (test) disagrees with the fit and validation runs, which the model describes: it agrees if {}",
            change.words
        ))
    };
    setup.files_of(&setup.runs(Role::Test)).iter().filter_map(of).collect()
}

/// One sentence about the disagreement between runs, if it is counted as noise.
fn disagreement(setup: &Setup, errors: &[ChannelError]) -> Option<String> {
    let of_fit = errors.iter().filter(|e| e.role == Role::Fit && !setup.between.is_empty());
    let parts: Vec<String> = of_fit.map(|e| of_channel(e.column, e.refit)).collect();
    (!parts.is_empty()).then(|| {
        let (what, effect) = match setup.runs(Role::Fit).len() {
            1 => ("the fit run deviates from the model", "describes this run"),
            _ => ("the fit runs disagree", "predicts runs that it leaves out"),
        };
        format!(
            "{what} by more than the noise of the sensors: {} (RMSE of the fit). A fit with the sensor noise alone {effect} worse than the \
             preset; so the difference counts as noise that persists over a run, in the fit, in the intervals and in the search for effects",
            parts.join(", ")
        )
    })
}

/// A value of a channel, in words.
fn of_channel(column: &str, value: f64) -> String {
    let (name, unit) = column_words(column);
    format!("{name} {}", with_unit(value, unit))
}

/// One sentence about final estimates from fit and validation runs together, with the error of the validation runs before.
fn jointly(setup: &Setup, errors: &[f64]) -> String {
    let known = setup.experiment.outputs.iter().zip(errors).filter(|(_, error)| error.is_finite());
    let parts: Vec<String> = known.map(|(channel, error)| of_channel(channel.column, *error)).collect();
    format!(
        "the repaired model (after) was finally estimated from the fit and validation runs together, since there are test runs, and the refit \
         from the fit runs alone; estimated from the fit runs alone, the repaired model predicts the validation runs with an error (RMSE) of {}",
        parts.join(", ")
    )
}

/// Whether one hypothesis may replace another according to simulated errors: the error of the fit and validation runs together hardly
/// increases; or that of the validation runs, to which neither was fitted, while every output still follows the fit runs.
fn is_no_worse(exact: &Setup, one: &Hypothesis, other: &Hypothesis) -> Result<bool, CalibrateError> {
    let [fit, validation] = [Role::Fit, Role::Validate].map(|role| exact.runs(role));
    let of = |hypothesis: &Hypothesis, runs: &[usize]| -> Result<Vec<f64>, CalibrateError> {
        Ok(exact.chi_squares(runs, &exact.show(hypothesis, runs)?))
    };
    let sum = |parts: &[f64]| parts.iter().sum::<f64>();
    let (fitted, before) = (of(one, &fit)?, of(other, &fit)?);
    let validated = (sum(&of(one, &validation)?), sum(&of(other, &validation)?));
    let follows = fitted.iter().zip(&before).all(|(own, before)| *own <= (1.0 + PART).powi(2) * before);
    if !validation.is_empty() && follows && validated.0 <= (1.0 + STRUCTURE) * validated.1 {
        return Ok(true);
    }
    Ok(sum(&fitted) + validated.0 <= (1.0 + STRUCTURE) * (sum(&before) + validated.1))
}

/// Every parameter found by linearization, with its interval, and the covariance, estimated jointly with sensor drift and, if given,
/// with a latent input at a port. A `corrected` hypothesis receives the parameters that are optimal with this drift.
fn estimates(
    setup: &Setup,
    point: &Linearization,
    beside: Option<Port>,
    corrected: Option<&mut Hypothesis>,
) -> (Vec<Estimate>, DMatrix<f64>) {
    let hypothesis = &point.fitted.hypothesis;
    let scales = setup.scales(hypothesis);
    let p = scales.len();
    let told = point.estimated(beside);
    // Final first-order correction, with sensor drift and without input noise in the sensitivities. It is skipped if the residual is
    // large, since an unmodelled effect would bias it.
    let steps = beside.is_some() || (corrected.is_some() && told.misfit < AT_NOISE);
    let numbers = if steps { told.moved } else { hypothesis.numbers() };
    if let Some(corrected) = corrected {
        corrected.take(&numbers);
    }
    // A residual above the noise widens the intervals.
    let widen = told.misfit.max(1.0).sqrt();
    let covariance = told.covariance;
    let units = setup.declared.iter().map(|d| (d.name.clone(), d.prior, d.unit));
    let added = hypothesis.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
    let names: Vec<(String, f64, &'static str)> =
        units.chain(added.map(|n| (n.symbol.clone(), 0.0, n.unit))).collect();
    let deviation = |k: usize| covariance[(k, k)].max(0.0).sqrt();
    let all = names.into_iter().enumerate().map(|(k, (name, prior, unit))| {
        let (scale, limits, _) = scales[k];
        let half = SURE * deviation(k) * scale * widen;
        let ci95 = interval(numbers[k], told.moves[k] * scale, half, limits);
        Estimate { name, value: numbers[k], ci95, prior, unit }
    });
    let all = all.collect();
    let unit = |k: usize| scales[k].0 * widen;
    let covariance = DMatrix::from_fn(p, p, |a, b| unit(a) * covariance[(a, b)] * unit(b));
    (all, covariance)
}

/// The 95 % interval of a parameter with distance `way` to its unconstrained optimum and normal half width `half`, clipped to the limits.
/// At a limit, the profile likelihood is used; to second order it is a parabola about the unconstrained optimum.
/// *Source*: Venzon, Moolgavkar, Applied Statistics 37 (1988) 87-94.
fn interval(number: f64, way: f64, half: f64, (least, most): (f64, f64)) -> (f64, f64) {
    let inwards = (way * way + half * half).sqrt() - way.abs();
    let (below, above) = match (number <= least && way <= 0.0, number >= most && way >= 0.0) {
        (true, _) => (0.0, inwards),
        (_, true) => (inwards, 0.0),
        _ => (half, half),
    };
    ((number - below).max(least), (number + above).min(most))
}

/// The largest change of each output due to the last addition, in words.
pub fn magnitude(point: &Linearization) -> String {
    let parts = point.setup.experiment.outputs.iter().zip(point.reach()).filter(|(_, reach)| *reach > 0.0);
    let change = |(channel, reach): (&&Channel, f64)| {
        let (name, unit) = column_words(channel.column);
        format!("{name} by at most {}", with_unit(reach, unit))
    };
    let parts: Vec<String> = parts.map(change).collect();
    format!("changes {}", parts.join(", "))
}

fn limits(point: &Linearization) -> Vec<Limit> {
    let least = DECISIVE + point.per_number();
    let everywhere = vec![true; point.runs.len()];
    let found = point.listed().filter_map(|(k, forms)| {
        let (listed, addition) = &forms[0];
        if point.base(addition) != 0.0 {
            return None;
        }
        let gain = point.evidence.gain(&point.listed_column(k, &everywhere)?)?;
        // An effect of this size is missed with a probability of 5 %: its score is then below the threshold.
        let size = (least.sqrt() + BELOW) * gain.covariance[(0, 0)].sqrt();
        let number = &addition.numbers[0];
        Some(Limit { id: listed.id.to_string(), symbol: listed.symbols[0], size, unit: number.unit })
    });
    let mut all: Vec<Limit> = Vec::new();
    for limit in found {
        // For an effect with several forms, the most sensitive one determines the limit.
        match all.iter_mut().find(|l| l.id == limit.id) {
            Some(known) => known.size = known.size.min(limit.size),
            None => all.push(limit),
        }
    }
    all
}

/// Of the fit runs.
fn whiteness(setup: &Setup, first: &Linearization, point: &Linearization) -> Vec<Whiteness> {
    fn of_fit_runs<'p>(point: &'p Linearization) -> impl Iterator<Item = (&'p usize, &'p Shown)> {
        let fit = point.setup.runs(Role::Fit);
        point.runs.iter().zip(&point.fitted.shown).filter(move |(run, _)| fit.contains(run))
    }
    let blocks = |point: &Linearization| -> Vec<f64> {
        let mut sums = vec![(0.0, 0usize); setup.outputs()];
        for (run, shown) in of_fit_runs(point) {
            let mut values = Vec::new();
            setup.residual(*run, shown, &mut values);
            for (block, value) in setup.blocks[*run].iter().zip(&values) {
                sums[block.output].0 += value * value;
                sums[block.output].1 += 1;
            }
        }
        sums.iter().map(|(sum, count)| if *count > 0 { sum / *count as f64 } else { f64::NAN }).collect()
    };
    let neighbours = |point: &Linearization| -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); setup.outputs()];
        for (run, shown) in of_fit_runs(point) {
            let mut last = vec![f64::NAN; setup.outputs()];
            setup.each(*run, shown, |_, output, off| {
                if last[output].is_finite() {
                    sums[output].0 += off * last[output];
                }
                sums[output].1 += off * off;
                last[output] = off;
            });
        }
        sums.iter().map(|(product, square)| product / square).collect()
    };
    let (a, b) = (blocks(first), blocks(point));
    let (c, d) = (neighbours(first), neighbours(point));
    let all = setup.experiment.outputs.iter().enumerate().filter(|(k, _)| a[*k].is_finite());
    all.map(|(k, channel)| Whiteness {
        column: channel.column,
        blocks_refit: a[k],
        blocks_after: b[k],
        autocorrelation: (c[k], d[k]),
    })
    .collect()
}

fn setting(setup: &Setup, hypothesis: &Hypothesis, run: usize) -> Result<Setting, CalibrateError> {
    let change = setup.change(hypothesis, run);
    let of = &setup.experiment.runs[run];
    let drive = &setup.drives[run];
    let initial = setup.bench.initial(drive, &change)?;
    let mut values = setup.bench.values(drive, &change);
    values.retain(|(name, _)| !initial.iter().any(|(known, _)| known == name));
    values.extend(initial);
    Ok(Setting { file: of.file.clone(), role: of.role, values, terms: change.terms })
}

fn curves(setup: &Setup, run: usize, [before, refit, after]: [&Shown; 3], half: &Shown) -> Curves {
    let (of, m) = (&setup.experiment.runs[run], setup.outputs());
    let rows = of.table.drawn();
    let inputs = setup.experiment.inputs.len();
    let outputs = setup.experiment.outputs.iter().enumerate().map(|(output, channel)| {
        let shown =
            |values: &Shown| rows.iter().map(|row| values[row * m + output] - channel.offset).collect();
        Curve {
            column: channel.column,
            measured: rows
                .iter()
                .map(|row| of.table.columns[inputs + output][*row] - channel.offset)
                .collect(),
            before: shown(before),
            refit: shown(refit),
            after: shown(after),
            half_width: rows.iter().map(|row| half[row * m + output]).collect(),
        }
    });
    Curves {
        run,
        file: of.file.clone(),
        role: of.role,
        window: of.window,
        time: rows.iter().map(|row| of.table.time[*row]).collect(),
        outputs: outputs.collect(),
    }
}

/// The interval of an estimate, extended to that of another value with the same half width, within the limits.
fn of_either(value: f64, (least, most): (f64, f64), limits: (f64, f64)) -> (f64, f64) {
    let half = 0.5 * (most - least);
    (least.min((value - half).max(limits.0)), most.max((value + half).min(limits.1)))
}

#[cfg(test)]
mod tests;
