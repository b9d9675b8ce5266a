//! Acceptance tests of a candidate: evidence, physical sign and size, the same size in every run, validation error.

use super::preference::is_sensor;
use super::{ALIKE, Candidate, LEAST, NEAR, at_limit};
use crate::CalibrateError;
use crate::acting::acting;
use crate::catalogue::LISTED;
use crate::comparison::{digits, with_unit};
use crate::deadline::Deadline;
use crate::experiment::Role;
use crate::fit::Fitted;
use crate::hypothesis::Addition;
use crate::instruments;
use crate::intake::mean_square;
use crate::levels::{CALIBRATED, CERTAIN, DECISIVE, PART, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::setup::{Setup, Shown};
use physics::terms::Port;

/// Fraction of a run that is held out if the effect acts in no validation run. Source: Hastie, Tibshirani, Friedman, The Elements of
/// Statistical Learning (2nd ed., 2009), sec. 7.2: typically a quarter for validation.
const HELD_OUT: f64 = 0.25;

/// Ratio of two mean square errors below which a candidate is larger than structure error can be. Derivation: it then accounts for more of an output's
/// error than it leaves.
const LARGE: f64 = 0.5;

/// Result of the acceptance tests.
#[derive(Debug, Default)]
pub struct Judged {
    /// Ratio of validation errors with and without the candidate; `None` without validation data, and if an earlier test rejects it.
    pub validation: Option<f64>,
    /// Reason for rejection.
    pub refused: Option<String>,
    /// The output that is predicted worst compared with the prediction without it, and the ratio of the errors; `None` as above.
    pub worst: Option<(usize, f64)>,
}

impl Judged {
    /// Rejected for this reason before any validation.
    pub fn refused(sentence: String) -> Judged {
        Judged { refused: Some(sentence), ..Judged::default() }
    }
}

/// Applies the acceptance tests; `asked` is the decrease of the cost that is asked for.
pub fn gate(before: &Linearization, candidate: &Candidate, asked: f64) -> Result<Judged, CalibrateError> {
    let (white, raw) = candidate.delta;
    if candidate.sure() <= asked {
        let sentence = format!(
            "lowers BIC by {} for white noise and by {} for autocorrelated noise; more than {asked} is required, because the structure \
             error of a model can explain less",
            digits(raw),
            digits(white)
        );
        return Ok(Judged::refused(sentence));
    }
    if let Some(sentence) = implausible(before, candidate) {
        return Ok(Judged::refused(sentence));
    }
    let validated = validation(before, candidate)?;
    let validation = validated.map(|v| v.ratio());
    // A null model with a great memory leaves little of the density; a mean square error that halves needs no other measure.
    let is_halved = validated.is_some_and(|v| v.with < LARGE * v.without);
    let of_density =
        validated.and_then(|v| v.density).filter(|gain| *gain < NEAR && !is_halved).map(|gain| {
            format!(
                "the validation runs are hardly predicted better: -2 ln p falls by {}; {NEAR} is required",
                digits(gain)
            )
        });
    // The density is one to first order about the fit: without a better fit or a smaller error it says nothing.
    let of_nothing = validated.and_then(|v| v.density).filter(|gain| white - gain < LEAST).and(validation);
    let of_nothing = of_nothing.filter(|ratio| *ratio >= 1.0 - STRUCTURE).map(|ratio| {
        format!("it improves neither the fit runs nor the error of the validation runs, which is {ratio:.3} times that without it")
    });
    // Held-out parts have no null model of their own.
    let of_parts = validated.filter(|v| v.density.is_none()).and_then(|v| {
        let ratio = v.ratio();
        let how = if ratio < 1.0 { "hardly predicted better" } else { "predicted worse" };
        (ratio >= 1.0 - STRUCTURE || v.fall < NEAR).then(|| {
            format!(
                "the data that were not fitted are {how}: {ratio:.3} times the error without it, chi square falls by {}; {NEAR} is required",
                digits(v.fall)
            )
        })
    });
    let [with, without] = [&candidate.point, before].map(|point| point.fitted.shown.as_slice());
    let seen = instruments::greatest(&instruments::decreases(before.setup, &before.runs, [with, without]));
    let seen = validated.map_or(seen, |v| v.seen.max(seen));
    // A physical effect has one form, and a lag is no error of an instrument's reading; a law or an offset fits what other nodes leave.
    let addition = candidate.addition();
    let is_free = !addition.is_listed() || is_sensor(addition.port) && addition.follows != Follows::History;
    let of_instruments = (is_free && seen < 1.0)
        .then(|| format!("accounts for {:.0} % of {}", 100.0 * seen, instruments::words()));
    // An effect that accounts for more of the whole error than it leaves is right also where parameters stood in for it in one output.
    let of_output = validated.and_then(|v| v.worse).filter(|_| !is_halved).map(|(output, ratio)| {
        let channel = before.setup.experiment.outputs[output].column;
        format!("{channel} that was not fitted is predicted worse: {ratio:.3} times the error without it")
    });
    let refused = of_instruments.or(of_density).or(of_nothing).or(of_parts).or(of_output);
    // A listed effect may need a second one beside it; a law is what its table makes it, also beyond the data.
    let refused = if refused.is_none() && !addition.is_listed() { ends(before, candidate)? } else { refused };
    Ok(Judged { validation, refused, worst: validated.and_then(|v| v.worst) })
}

/// Sentence on a run that the model ends at a limit of validity with a law and not without: the motor was run to its last row. Of the
/// runs that are not fitted the inputs are enough.
fn ends(before: &Linearization, candidate: &Candidate) -> Result<Option<String>, CalibrateError> {
    let judge = before.setup.strict().until(Deadline::default());
    let runs: Vec<usize> =
        (0..judge.experiment.runs.len()).filter(|run| !before.runs.contains(run)).collect();
    let ends = |point: &Linearization| -> Result<Vec<Option<String>>, CalibrateError> {
        let shown = judge.show_to_end(&point.fitted.hypothesis, &runs)?;
        Ok(shown.into_iter().map(|(_, why)| why).collect())
    };
    let (without, with) = (ends(before)?, ends(&candidate.point)?);
    let files = runs.iter().map(|run| &judge.experiment.runs[*run].file);
    let mut ended = files.zip(without.into_iter().zip(with)).filter_map(|(file, (without, with))| {
        let why = with.filter(|_| without.is_none())?;
        Some(format!("the model does not reach the last row of {file} with it. {why}"))
    });
    Ok(ended.next())
}

/// Reason why a candidate is no physical explanation of the fit runs, whatever it predicts.
pub fn implausible(before: &Linearization, candidate: &Candidate) -> Option<String> {
    let addition = candidate.addition();
    if addition.numbers[0].limits.0 == 0.0 && addition.numbers[0].value <= 0.0 {
        return Some(format!("{} would have to be negative", addition.numbers[0].symbol));
    }
    at_limit(addition)
        .or_else(|| of_one_file(candidate))
        .or_else(|| to_a_limit(before, candidate))
        .or_else(|| within_calibration(candidate))
        .or_else(|| unlike(candidate))
}

/// Decrease of the cost that is asked for an addition, from the model without it to the model with it.
pub fn asked(before: &Linearization, with: &Linearization) -> f64 {
    if outweighs(before, with) { LEAST } else { DECISIVE }
}

/// The same for one addition.
pub fn asked_for(before: &Linearization, with: &Linearization, addition: &Addition) -> f64 {
    enough(asked(before, with), addition, with.delta_validation(before))
}

/// Sentence on an output that is predicted worse with a candidate for which less was asked, because it predicts: that holds of every output.
pub fn predicts_less(point: &Linearization, judged: &Judged) -> Option<String> {
    let (output, ratio) = judged.worst.filter(|(_, ratio)| *ratio > 1.0 + STRUCTURE)?;
    let channel = point.setup.experiment.outputs[output].column;
    Some(format!(
        "explains less than {DECISIVE}, and {channel} is predicted worse: {ratio:.3} times the error without it"
    ))
}

/// What is asked for by itself, or less for a listed effect with this decrease of -2 ln p of the validation runs: it has one form, and if it
/// predicts better by very strong evidence, it is enough that the model with it can be distinguished from the one without.
pub fn enough(asked: f64, addition: &Addition, predicted: Option<f64>) -> f64 {
    let is_predicted = addition.is_listed() && predicted.is_some_and(|gain| gain >= LEAST);
    if asked > ALIKE && is_predicted { ALIKE } else { asked }
}

/// Whether an effect is larger than structure error can be: an output's mean square error in the fit runs halves, and what it falls by is
/// above the structure error of that output.
fn outweighs(before: &Linearization, with: &Linearization) -> bool {
    let setup = before.setup;
    let squares = |point: &Linearization| setup.squares(&before.runs, &point.fitted.shown);
    let pairs = squares(before).into_iter().zip(squares(with)).enumerate();
    pairs.into_iter().any(|(output, ((without, count), (with, _)))| {
        let (size, _) = mean_square(setup.experiment, &before.runs, output);
        with < LARGE * without && without - with > STRUCTURE * STRUCTURE * size * count as f64
    })
}

/// Sentence on a law of all runs that only one of the files asks for. What a listed effect does elsewhere is known from its form; a law is what its
/// readings make it, and they may be wrong.
fn of_one_file(candidate: &Candidate) -> Option<String> {
    let file = &candidate.point.setup.experiment.odd_file.as_ref()?.name;
    let addition = candidate.addition();
    (!addition.is_listed() && addition.is_in_every_run()).then(|| {
        format!("only {file} supports it: without this file the parameters describe the other runs, and the file may be wrong")
    })
}

/// Sentence on a declared parameter that reaches a limit with a candidate: the candidate then explains with a parameter that has no plausible
/// value.
fn to_a_limit(before: &Linearization, candidate: &Candidate) -> Option<String> {
    let [before, with] = [before, &candidate.point].map(|point| &point.fitted.hypothesis.declared);
    let mut all = candidate.point.setup.declared.iter().zip(before.iter().zip(with));
    let (own, (_, value)) = all.find(|(own, (before, with))| {
        let is_replaced = **with == 0.0 && is_size_at(&own.name, candidate.addition().port);
        own.is_inside(**before) && !own.is_inside(**with) && !is_replaced
    })?;
    Some(format!("{} reaches its limit {} with it", own.name, with_unit(*value, own.unit)))
}

/// Whether a parameter is the size of a listed effect at this port: an effect there may be the right form of it, and leave nothing.
fn is_size_at(parameter: &str, port: Port) -> bool {
    LISTED.iter().any(|l| l.port == port && parameter == l.parameter(l.symbols[0]))
}

/// Sentence on a listed sensor effect that is smaller than the calibration accuracy.
fn within_calibration(candidate: &Candidate) -> Option<String> {
    let (setup, addition) = (candidate.point.setup, candidate.addition());
    if !addition.is_listed() || !is_sensor(addition.port) {
        return None;
    }
    let most =
        candidate.point.reach().iter().enumerate().map(|(k, x)| x / setup.sigma(k)).fold(0.0, f64::max);
    (most < CALIBRATED).then(|| {
        format!("moves no output by more than {most:.1} deviations of its noise: a sensor errs by as much")
    })
}

/// Sentence on a run whose estimated size differs from that of the others, by linearised leave-one-out.
fn unlike(candidate: &Candidate) -> Option<String> {
    let (point, addition) = (&candidate.point, candidate.addition());
    let active: Vec<usize> = (0..point.runs.len()).filter(|r| addition.active[point.runs[*r]]).collect();
    if active.len() < 2 {
        return None;
    }
    let evidence = point.evidence.without_tables()?;
    for own in active {
        let Some(column) = point.amplitude_column(own) else { continue };
        let Some(gain) = evidence.gain(&column) else { continue };
        let (off, deviation) = (gain.size[0], gain.covariance[(0, 0)].sqrt());
        if off.abs() > PART + CERTAIN * deviation {
            let file = &point.setup.experiment.runs[point.runs[own]].file;
            return Some(format!(
                "is not the same in every run: {file} wants {:.0} % of the size that the others have",
                100.0 * (1.0 + off)
            ));
        }
    }
    None
}

/// Sums of squares over validation data, in units of the noise.
#[derive(Clone, Copy)]
struct Validated {
    with: f64,
    without: f64,
    /// Fall of the sum, each output divided by its variance inflation (Burnham, Anderson, Model Selection and Multimodel Inference, 2nd
    /// ed., 2002, sec. 2.5): as many independent readings count as the memory of the noise leaves.
    fall: f64,
    /// Decrease of -2 ln p of the validation runs; `None` for held-out parts of fit runs.
    density: Option<f64>,
    /// Part of the outputs that it accounts for ([`instruments`]).
    seen: f64,
    /// The output that is predicted worst with it, and the ratio of its error to that without it, if structure error can hardly cause it.
    worse: Option<(usize, f64)>,
    /// The same whatever causes it.
    worst: Option<(usize, f64)>,
}

impl Validated {
    /// Ratio of validation errors with and without the candidate.
    fn ratio(self) -> f64 {
        (self.with / self.without).sqrt()
    }

    /// From the outputs with and without a candidate.
    fn new(setup: &Setup, runs: &[usize], shown: [&[Shown]; 2], candidate: &Candidate) -> Validated {
        let [with, without] = shown.map(|shown| setup.chi_squares(runs, shown));
        let fall = |k: usize| (without[k] - with[k]) / candidate.point.evidence.inflation(k);
        let falls: Vec<f64> = (0..with.len()).map(fall).collect();
        let decreases = instruments::decreases(setup, runs, shown);
        let worse = worst(&with, &without, &falls, |k| decreases[k] < -1.0);
        let worst = ratios(&with, &without).max_by(|a, b| a.1.total_cmp(&b.1));
        let seen = instruments::greatest(&decreases);
        let [with, without, fall] = [with, without, falls].map(|parts| parts.iter().sum());
        Validated { with, without, fall, density: None, seen, worse, worst }
    }
}

/// Ratios of the errors of the outputs that have readings.
fn ratios(with: &[f64], without: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    let all = with.iter().zip(without).map(|(a, b)| (a / b).sqrt()).enumerate();
    all.filter(|(_, ratio)| ratio.is_finite())
}

/// The output whose error grows most from sums of squares `without` to `with`, and the ratio, if neither structure error nor, by
/// `is_beyond`, the error of good instruments can cause it.
fn worst(
    with: &[f64],
    without: &[f64],
    falls: &[f64],
    is_beyond: impl Fn(usize) -> bool,
) -> Option<(usize, f64)> {
    let worse =
        ratios(with, without).filter(|(k, ratio)| *ratio > 1.0 + PART && -falls[*k] > NEAR && is_beyond(*k));
    worse.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Ratio of validation errors with and without a candidate: on the validation runs; if it acts in none of them, on the end of the runs in
/// which it acts, fitted without that part.
fn validation(before: &Linearization, candidate: &Candidate) -> Result<Option<Validated>, CalibrateError> {
    let setup = before.setup;
    // A fitted candidate is judged although the time budget is used up: that takes no more than a few runs.
    let judge = setup.clone().until(Deadline::default());
    let runs = setup.runs(Role::Validate);
    let addition = candidate.addition();
    let partly = !addition.is_in_every_run();
    if !runs.is_empty() {
        let without = judge.show(&acting(&judge, &before.fitted.hypothesis, &runs)?, &runs)?;
        let with = acting(&judge, &candidate.point.fitted.hypothesis, &runs)?;
        let active = with.additions.last().is_some_and(|own| runs.iter().any(|run| own.active[*run]));
        let shown = judge.show(&with, &runs)?;
        if !partly || active {
            let density = candidate.point.delta_validation(before);
            return Ok(Some(Validated {
                density,
                ..Validated::new(setup, &runs, [&shown, &without], candidate)
            }));
        }
    }
    let mut part = setup.clone();
    let mut judged = setup.clone();
    let mut held = Vec::new();
    for run in before.runs.iter().filter(|run| addition.active[**run]) {
        let Some((from, to)) = setup.counted(*run) else { continue };
        let cut = to - HELD_OUT * (to - from);
        part = part.with_window(*run, (from, cut));
        judged = judged.with_window(*run, (cut, to));
        held.push(*run);
    }
    if held.is_empty() {
        return Ok(None);
    }
    let without = part.fit(before.fitted.hypothesis.clone(), &before.runs)?;
    let with = part.fit(candidate.point.fitted.hypothesis.clone(), &before.runs)?;
    let [with, without] = [&with, &without].map(|fitted: &Fitted| judged.show(&fitted.hypothesis, &held));
    Ok(Some(Validated::new(&judged, &held, [&with?, &without?], candidate)))
}

/// Whether the outputs that a candidate explains in the fit runs have a smaller validation error with it, regardless of other outputs.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn predicts_where_it_acts(before: &Linearization, candidate: &Candidate) -> Result<bool, CalibrateError> {
    let (setup, runs) = (before.setup, before.setup.runs(Role::Validate));
    let by_output = |runs: &[usize], shown: &[Shown]| setup.chi_squares(runs, shown);
    let fitted = [before, &candidate.point].map(|point| by_output(&before.runs, &point.fitted.shown));
    let explained: Vec<f64> = fitted[0].iter().zip(&fitted[1]).map(|(a, b)| (a - b).max(0.0)).collect();
    let without = by_output(&runs, &setup.show(&before.fitted.hypothesis, &runs)?);
    let with = by_output(&runs, &setup.show(&candidate.point.fitted.hypothesis, &runs)?);
    let whole: f64 = explained.iter().sum();
    let ratio = |k: usize| if without[k] > 0.0 { with[k] / without[k] } else { 1.0 };
    let predicted: f64 = explained.iter().enumerate().map(|(k, own)| own / whole * ratio(k)).sum();
    Ok(predicted < (1.0 - STRUCTURE).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::OddFile;
    use crate::hypothesis::Addition;
    use crate::testing;
    use physics::terms::Driver;

    #[test]
    fn friction_may_be_replaced_by_another_form_of_it() {
        assert!(is_size_at("effect.coulomb_friction.tau_c", Port::DragTorque));
        assert!(!is_size_at("effect.coulomb_friction.tau_c", Port::HousingHeat));
        assert!(!is_size_at("effect.coulomb_friction.w_small", Port::DragTorque));
        assert!(!is_size_at("conductance.G_still", Port::HousingAmbientConductance));
    }

    #[test]
    fn less_is_asked_for_an_effect_that_predicts() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let listed = testing::addition(&setup, "windage", 1e-8);
        let law = testing::law(Port::DragTorque, Follows::Driver(Driver::Speed));
        assert_eq!(enough(DECISIVE, &listed, Some(LEAST)), ALIKE);
        assert_eq!(enough(DECISIVE, &listed, Some(LEAST - 0.1)), DECISIVE);
        assert_eq!(enough(DECISIVE, &listed, None), DECISIVE);
        assert_eq!(enough(DECISIVE, &law, Some(90.0)), DECISIVE);
        assert_eq!(enough(LEAST, &listed, Some(90.0)), LEAST);
        let candidate = testing::candidate(&setup, listed, 60.0);
        let said = |ratio: f64| {
            predicts_less(&candidate.point, &Judged { worst: Some((2, ratio)), ..Judged::default() })
        };
        assert_eq!(said(1.0 + STRUCTURE), None);
        let worse = said(1.1).unwrap();
        assert!(worse.contains("winding_temperature_degC is predicted worse: 1.100 times"), "{worse}");
        let all = ratios(&[4.0, 0.0, 9.0], &[1.0, 0.0, 4.0]).collect::<Vec<_>>();
        assert_eq!(all, [(0, 2.0), (2, 1.5)]);
    }

    /// A listed effect and one of this run alone are not.
    #[test]
    fn a_law_that_one_file_asks_for_is_refused() {
        let mut experiment = testing::experiment(testing::PRIORS, true);
        for odd in [None, Some(OddFile { name: "run.csv".into(), note: String::new() })] {
            experiment.odd_file = odd.clone();
            let setup = Setup::new(&experiment, &[]).unwrap();
            let law = testing::law(Port::DragTorque, Follows::Driver(Driver::Speed));
            let here = Addition { active: vec![false], ..law.clone() };
            let listed = testing::addition(&setup, "windage", 1e-8);
            for (addition, is_refused) in [(law, odd.is_some()), (here, false), (listed, false)] {
                let candidate = testing::candidate(&setup, addition, 500.0);
                let said = of_one_file(&candidate);
                assert_eq!(said.is_some_and(|why| why.contains("only run.csv supports it")), is_refused);
            }
        }
    }

    /// In a run whose outputs nobody has looked at.
    #[test]
    fn an_addition_with_which_a_run_ends_is_refused() {
        let mut experiment = testing::experiment(testing::PRIORS, true);
        let mut second = experiment.runs[0].clone();
        (second.file, second.role) = ("second.csv".to_string(), Role::Test);
        experiment.runs.push(second);
        let setup = Setup::new(&experiment, &[]).unwrap();
        for (volts, is_refused) in [(0.1, false), (400.0, true)] {
            let with = testing::candidate(&setup, testing::addition(&setup, "contact_drop", volts), 500.0);
            let without = testing::candidate(&setup, testing::addition(&setup, "contact_drop", 0.0), 0.0);
            let said = ends(&without.point, &with).unwrap();
            assert_eq!(
                said.as_ref().is_some_and(|why| why.contains("last row of second.csv")),
                is_refused,
                "{said:?}"
            );
        }
    }

    /// An output counts as worse by its ratio, by the number of independent readings behind it, and by what instruments show; an output without
    /// readings does not.
    #[test]
    fn one_output_that_is_predicted_worse_is_named() {
        let without = [100.0, 100.0, 100.0, 0.0];
        let falls = |with: &[f64; 4]| -> Vec<f64> { (0..4).map(|k| without[k] - with[k]).collect() };
        let with = [10.0, 400.0, 225.0, 0.0];
        assert_eq!(worst(&with, &without, &falls(&with), |_| true), Some((1, 2.0)));
        assert_eq!(worst(&with, &without, &falls(&with), |k| k != 1), Some((2, 1.5)));
        // 25 % are within structure error.
        let with = [10.0, 1.25f64.powi(2) * 100.0, 90.0, 0.0];
        assert_eq!(worst(&with, &without, &falls(&with), |_| true), None);
        // So few independent readings are no evidence.
        let with = [10.0, 400.0, 90.0, 0.0];
        assert_eq!(
            worst(&with, &without, &falls(&with).iter().map(|fall| fall / 60.0).collect::<Vec<_>>(), |_| {
                true
            }),
            None
        );
    }
}
