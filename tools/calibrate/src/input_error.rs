//! The error of an input's instrument, as an explanation of what effects were found for.
//!
//! y = y(u + sum_k c_k b_k(u, t)),   c constant in all runs or in one                               (1)
//!
//! A current probe that reads 0.35 A at no current, a shunt whose value is wrong by 15 %, an amplifier near its end or an encoder that loses
//! counts moves torque, voltage and temperatures together; effects of a motor describe each of them by itself: an offset of the torque sensor,
//! a torque or a voltage over the current. The functions b of the reading u and of the time t are in [`form`]. If (1) explains more than all
//! that was found, the reading is wrong and nothing can be said of the motor.
//!
//! Another value of one declared parameter in the same runs is simpler: of a motor whose magnets are weaker since the last run, no instrument is
//! wrong.
//! *Source*: parity equations of additive and multiplicative sensor faults, Isermann, Fault-Diagnosis Systems (2006), ch. 10; c is fitted
//! with the declared parameters.

mod form;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::evidence::Gain;
use crate::experiment::Role;
use crate::hypothesis::Hypothesis;
use crate::instruments;
use crate::intake::mean_square;
use crate::levels::{DECISIVE, FACTOR, NEARLY, PART, SMALL, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Unusable;
use crate::search::search;
use crate::selection::LEAST;
use crate::setup::Setup;
use crate::simulate::Drive;
use form::Form;

/// Gauss-Newton steps for c. Numerical: two for a zero, in which the model is nearly linear; a gain of 1.5 is known to 1 % after four.
const STEPS: usize = 8;

/// Part of the asked evidence that is enough to first order for a fit: a large error, and another missing effect, hide the rest. Numerical:
/// a limit of effort.
const AHEAD: f64 = 0.2;

/// An instrument of an input that is wrong in these runs.
#[derive(Clone)]
struct Wrong {
    input: usize,
    runs: Vec<usize>,
    form: Form,
    /// c of (1).
    sizes: Vec<f64>,
    /// Price of the numbers and of the choice.
    price: f64,
    /// Decrease of the cost less the price.
    sure: f64,
    /// Fraction of the [`excess`] that is left.
    left: f64,
    /// The greatest [`rest`] of an output.
    rest: f64,
}

/// Decreases of the cost by what was found.
#[derive(Clone, Copy, Default)]
pub struct Explained {
    /// By an effect, or by all that was found.
    pub all: f64,
    /// By effects of the list.
    pub listed: f64,
    /// Number of laws, which follow nearly anything: two of them have one cause rather than two.
    pub laws: usize,
}

/// The instrument of an input that explains the residual of a fit, in all or one of its runs or in the validation runs, if it explains more
/// than what was found, and more than structure error can.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn explains(
    point: &Linearization,
    places: &[Vec<usize>],
    found: Explained,
) -> Result<Option<Unusable>, CalibrateError> {
    // An instrument that leaves nothing is the simpler cause if it explains as much as several laws.
    let as_laws = if found.laws > 1 { found.listed.max(NEARLY * found.all) } else { found.all };
    let [all_found, listed, as_laws] = [found.all, found.listed, as_laws].map(|least| least.max(DECISIVE));
    let mut all: Vec<Wrong> = Vec::new();
    for wrong in likely(point, places, listed * AHEAD) {
        let own = wrong.runs.clone();
        let wrong = fitted(point, wrong)?;
        // Of another motor, or one that has changed meanwhile: one number, too.
        if own.len() < point.runs.len() && of_a_parameter(point, &own) >= wrong.sure - LEAST {
            continue;
        }
        let is_exact = wrong.left < SMALL;
        let least = if is_exact { as_laws } else { all_found };
        // With the right correction, the channels agree but for structure error. Where no law is looked for, an effect of no list may leave the
        // rest.
        let agrees =
            wrong.left < 1.0 && (is_exact || point.setup.takes_laws() && wrong.rest < FACTOR * STRUCTURE);
        // A function of many numbers may stand in for something else, of which it leaves a part.
        let is_whole = wrong.form.count() == 1 || wrong.left < PART || wrong.sure > FACTOR * least;
        // A small correction that leaves nearly nothing of a residual far above the noise is no structure error either.
        let is_seen = is_exact && excess(point) > 1.0 || wrong.is_seen(point.setup);
        if wrong.sure > least && agrees && is_whole && is_seen && wrong.is_plausible(point.setup) {
            all.push(wrong);
        }
    }
    // The forms come in the order of their numbers. A course of each run follows anything, so that it has to explain several times as much.
    let (courses, forms): (Vec<Wrong>, Vec<Wrong>) =
        all.into_iter().partition(|wrong| wrong.form.is_course());
    let most = forms.iter().map(|wrong| wrong.sure).fold(0.0, f64::max);
    let simplest = forms.into_iter().find(|wrong| wrong.sure >= NEARLY * most);
    let course = courses.into_iter().find(|course| course.sure > FACTOR * most);
    Ok(course.or(simplest).map(|wrong| wrong.sentence(point.setup)))
}

/// All these runs, and each of them.
pub fn places(runs: &[usize]) -> Vec<Vec<usize>> {
    let single = runs.iter().map(|run| vec![*run]).filter(|_| runs.len() > 1);
    std::iter::once(runs.to_vec()).chain(single).filter(|place| !place.is_empty()).collect()
}

impl Wrong {
    fn sentence(&self, setup: &Setup) -> Unusable {
        let experiment = setup.experiment;
        let is_everywhere = self.runs.len() == experiment.runs.len();
        let files: Vec<&str> = self.runs.iter().map(|run| experiment.runs[*run].file.as_str()).collect();
        let (place, also) = if is_everywhere {
            ("every run".to_string(), "")
        } else {
            (files.join(", "), "; what disagrees with the other runs may also be of another motor")
        };
        let channel = experiment.inputs[self.input];
        let (change, suggestion) = self.form.words(channel, &self.sizes);
        let reason = format!("{} in {place} agrees with the other channels if {change}", channel.column);
        Unusable::new(channel.column, reason, format!("{suggestion}{also}"))
    }

    /// The correction at a row of a run.
    fn correction(&self, drives: &[Drive], run: usize, row: usize) -> f64 {
        let (reading, time) =
            (drives[run].inputs()[self.input][row], drives[run].time[row] - drives[run].time[0]);
        self.sizes.iter().enumerate().map(|(k, c)| c * self.form.weight(k, run, reading, time)).sum()
    }

    /// Whether the correction is larger than what structure error, or the error of a good thermometer, stands for.
    fn is_seen(&self, setup: &Setup) -> bool {
        let (mut own, mut all, mut rows) = (0.0, 0.0, 0.0);
        for run in &self.runs {
            for (row, reading) in setup.drives[*run].inputs()[self.input].iter().enumerate() {
                own += self.correction(&setup.drives, *run, row).powi(2);
                all += reading * reading;
                rows += 1.0;
            }
        }
        let experiment = setup.experiment;
        if experiment.inputs[self.input].is_temperature() {
            let errors = experiment.thermometers().into_iter();
            let errors = errors.map(|output| instruments::error(experiment, &self.runs, output));
            return (own / rows).sqrt() > errors.filter(|x| x.is_finite()).fold(0.0, f64::max);
        }
        (own / all).sqrt() > STRUCTURE
    }

    /// Whether the readings can be wrong by so much: those of a quantity that hardly varies, a pressure of the air or a supply, are seen to be wrong
    /// if they err by a large part of it.
    fn is_plausible(&self, setup: &Setup) -> bool {
        let readings = || {
            let of = |run: &usize| setup.drives[*run].inputs()[self.input].iter().map(|x| x.abs());
            self.runs.iter().flat_map(of)
        };
        let (least, most) = (readings().fold(f64::INFINITY, f64::min), readings().fold(0.0, f64::max));
        let mut greatest: f64 = 0.0;
        for run in &self.runs {
            for row in 0..setup.drives[*run].time.len() {
                greatest = greatest.max(self.correction(&setup.drives, *run, row).abs());
            }
        }
        most - least > PART * most || greatest < PART * most
    }

    /// The setup with the corrected input.
    fn corrected<'a>(&self, setup: &Setup<'a>) -> Setup<'a> {
        setup.with_input(self.input, &self.runs, |drives, run, row, reading| {
            reading + self.correction(drives, run, row)
        })
    }

    /// What a further change of c explains to first order at a point, which may be that of a corrected input; `of` has the readings.
    fn gain(&self, point: &Linearization, of: &Setup, runs: &[usize]) -> Option<Gain> {
        let columns = point.input_columns(self.input, runs, self.form.count(), |k, run, row| {
            let drive = &of.driven[run];
            self.form.weight(k, run, drive.inputs()[self.input][row], drive.time[row] - drive.time[0])
        })?;
        match self.form.kernel() {
            Some(kernel) => point.evidence.shape(&columns, &kernel),
            None => point.evidence.gain(&columns),
        }
    }
}

/// What another value of one declared parameter in these runs explains to first order, less the price.
fn of_a_parameter(point: &Linearization, runs: &[usize]) -> f64 {
    let common = point.setup.declared.iter().enumerate().filter(|(_, own)| own.runs.is_none());
    let choice = 2.0 * ((common.clone().count() * point.runs.len()) as f64).ln();
    let of = |(k, _)| {
        let gain = point.evidence.gain(&point.parameter_column(k, runs)?)?;
        Some(gain.raw.min(gain.whitened) - point.per_number() - choice)
    };
    common.filter_map(of).fold(0.0, f64::max)
}

/// Each kind of form where it explains most to first order, if that is more than `least`: a first fit far from the truth shows a part only.
fn likely(point: &Linearization, places: &[Vec<usize>], least: f64) -> Vec<Wrong> {
    let setup = point.setup;
    let mut all: Vec<(usize, Form, &Vec<usize>)> = Vec::new();
    for (input, channel) in setup.experiment.inputs.iter().enumerate() {
        for place in places {
            let mut forms = form::forms(channel, &setup.drives, input, place);
            // A function follows anything: what a law in the motor explains must be known.
            forms.retain(|form| form.count() == 1 || setup.takes_laws());
            all.extend(forms.into_iter().map(|form| (input, form, place)));
        }
    }
    let choice = 2.0 * (all.len() as f64).ln();
    let of = |(input, form, runs): (usize, Form, &Vec<usize>)| {
        let price = form.price() * point.per_number() + choice;
        let sizes = vec![0.0; form.count()];
        let mut wrong =
            Wrong { input, runs: runs.clone(), form, sizes, price, sure: 0.0, left: 1.0, rest: 1.0 };
        let gain = wrong.gain(point, setup, runs)?;
        wrong.sizes = gain.size.iter().copied().collect();
        wrong.sure = gain.raw.min(gain.whitened) - price;
        Some(wrong)
    };
    let mut best: Vec<Wrong> = Vec::new();
    for wrong in all.into_iter().filter_map(of).filter(|wrong| wrong.sure > least) {
        match best.iter_mut().find(|other| other.form.kind() == wrong.form.kind()) {
            Some(other) if other.sure < wrong.sure => *other = wrong,
            Some(_) => {}
            None => best.push(wrong),
        }
    }
    best.sort_by_key(|wrong| wrong.form.kind());
    best
}

/// The correction fitted with the declared parameters, or with the effect of the list that explains most beside it as well, if both explain
/// clearly more than the effect alone.
fn fitted(point: &Linearization, mut wrong: Wrong) -> Result<Wrong, CalibrateError> {
    let places = wrong.runs.clone();
    if places == point.runs {
        // What is wrong in all fit runs is so in the others.
        let others = [Role::Validate, Role::Test].iter().flat_map(|role| point.setup.runs(*role));
        wrong.runs.extend(others);
    }
    let (alone, hypothesis) = settled(point, wrong, &point.fitted.hypothesis, &places)?;
    let setup = alone.corrected(point.setup);
    let own = Linearization::new(&setup, setup.judged(hypothesis.clone(), &point.runs)?, &point.runs)?;
    let scored = search(&own);
    let listed = scored.iter().filter(|s| s.listed && s.sure() > LEAST);
    let best = listed.max_by(|a, b| a.sure().total_cmp(&b.sure()));
    let Some(addition) = best.and_then(|s| s.addition.as_ref()) else { return Ok(alone) };
    let mut start = hypothesis;
    start.additions.push(addition.clone());
    let price = alone.price + point.per_number() * point.setup.price(addition);
    let effect = point.setup.fit_addition(start.clone(), &point.runs)?;
    let effect = sure(&Linearization::judged(point.setup, effect, &point.runs)?, point);
    let (both, _) = settled(point, Wrong { price, ..alone.clone() }, &start, &places)?;
    // A course follows anything, and would follow what the effect leaves.
    let is_needed = both.sure > effect + DECISIVE && both.sure > alone.sure && !both.form.is_course();
    // What the effect explains alone needs no instrument that is wrong.
    let is_vain = alone.sure <= effect;
    Ok(if is_needed { both } else { Wrong { sure: if is_vain { 0.0 } else { alone.sure }, ..alone } })
}

/// The correction with the numbers that explain most, by Gauss-Newton steps from those that it has and the parameters of `start`; and the
/// parameters then.
fn settled(
    point: &Linearization,
    mut wrong: Wrong,
    start: &Hypothesis,
    places: &[usize],
) -> Result<(Wrong, Hypothesis), CalibrateError> {
    wrong.sure = f64::NEG_INFINITY;
    let mut best = (wrong.clone(), start.clone());
    let mut hypothesis = start.clone();
    for _ in 0..STEPS {
        let setup = wrong.corrected(point.setup);
        let own = Linearization::judged(&setup, setup.fit(hypothesis, &point.runs)?, &point.runs)?;
        let before = wrong.sure;
        (wrong.sure, wrong.left) = (sure(&own, point) - wrong.price, excess(&own) / excess(point));
        wrong.rest = rest(&own);
        if wrong.sure > best.0.sure {
            best = (wrong.clone(), own.fitted.hypothesis.clone());
        }
        if (wrong.sure - before).abs() <= LEAST {
            break;
        }
        let Some(further) = wrong.gain(&own, point.setup, places) else { break };
        wrong.sizes.iter_mut().zip(&further.size).for_each(|(c, more)| *c += more);
        hypothesis = own.fitted.hypothesis.clone();
    }
    Ok(best)
}

/// Decrease of the cost under the less favourable of the two noise models.
fn sure(own: &Linearization, before: &Linearization) -> f64 {
    let (white, raw) = own.explains(before);
    white.min(raw)
}

/// Mean square of the residual in units of the noise, less the noise.
fn excess(point: &Linearization) -> f64 {
    point.fitted.chi_square / point.fitted.readings as f64 - 1.0
}

/// The greatest root mean square error of an output beyond its noise, relative to the size of the output.
fn rest(point: &Linearization) -> f64 {
    let (setup, runs) = (point.setup, &point.runs);
    let squares = instruments::beyond_noise(setup, runs, &point.fitted.shown).enumerate();
    let relative = squares.map(|(k, square)| square / mean_square(setup.experiment, runs, k).0);
    instruments::greatest(&relative.collect::<Vec<_>>())
}
