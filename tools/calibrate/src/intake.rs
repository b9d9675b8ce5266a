//! Plausibility checks of the measured data, before any search for effects.
//!
//! Three checks, in this order: there are enough readings ([`enough`]); units, signs and columns agree with the model
//! ([`consistency`]); each sensor works ([`signals`] and [`converter`] from its own readings, [`response`] from its response to the
//! inputs). A sensor that fails is set aside with a note, in the whole run or in part of it. A run in which the load changed in a gap between
//! the rows becomes two ([`gaps`]). Data that contradict the model, or runs without remaining readings, are [`Unusable`], and no search is
//! made.
//!
//! The model is that of the preset, unfitted; the checks therefore allow for all parameter values within the priors.

mod averaged;
mod bursts;
mod clipped;
mod clock_jumps;
mod clocks;
mod consistency;
mod converter;
mod copies;
mod dead_input;
mod dead_torque;
mod departures;
mod drifts;
mod exchanged;
mod filtered;
mod first_rows;
mod gaps;
mod misplaced;
mod modes;
mod odd_file;
mod pulses;
mod repeats;
mod response;
mod saturated;
mod signals;
mod start;
mod steps;
mod unsynchronized;

use crate::CalibrateError;
use crate::comparison::converted;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment, Role, Run};
use crate::fit::is_wide;
use crate::hypothesis::Hypothesis;
use crate::levels::{SAMPLES, SMALL, STRUCTURE};
use crate::numbers::{ends, median, range, sorted};
pub use crate::outcome::{Refusal, Unusable};
use crate::overrides::Override;
use crate::parallel;
use crate::report::count_of;
use crate::setup::Setup;
use crate::simulate::{Bench, Drive};
pub(crate) use consistency::Mistake;
pub use consistency::illustration::{Illustrated, Illustration, illustration};
use physics::declare::Unit;
use physics::model::Declaration;

/// Fewest rows of a run that can be fitted. Derivation: five rows have three second differences, the fewest with a median.
const LEAST_ROWS: usize = 5;
/// If more than this fraction of an input's readings is outside the limits of its variable, its unit is wrong; otherwise only these
/// readings. Definition: the majority.
const WRONG_UNIT: f64 = 0.5;
/// Greatest difference of two working temperature sensors, K. Limit: two thermocouples of class 2 (2.5 K each, IEC 60584-1) with cold
/// junctions (2 K each) differ by up to 9 K.
const FAR: f64 = 10.0;

/// Predictions by run, then by output, then by row.
type Predicted = Vec<Vec<Vec<f64>>>;

/// Checks an experiment and sets aside invalid readings; `preset` are the start values of its preset, by value reference. Result: whether all
/// checks were made. Work that the deadline cuts off leads to no conclusion, and a note says so.
///
/// # Errors
/// [`Refusal`].
pub fn check(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<bool, Refusal> {
    let agrees = sensors(experiment, preset, deadline)?;
    let mut unusable = clocks::check(experiment, preset, deadline)?;
    if unusable.is_none() {
        unusable =
            unsynchronized::set_aside(experiment, preset, deadline).or_else(|| nothing_left(experiment));
    }
    if unusable.is_none() {
        unusable = odd_file::check(experiment, preset, deadline)?;
    }
    if unusable.is_none() && !agrees {
        unusable = consistency::contradicting_value(experiment, preset, deadline)?;
    }
    if let Some(unusable) = unusable {
        return Err(Refusal::Unusable(unusable));
    }
    let is_complete = !deadline.is_near();
    if !is_complete {
        let note = "the time budget ended the checks of the data before all were made; no effect is looked for in data that were not \
                    checked; --budget sets another one";
        experiment.notes.push(note.to_string());
    }
    Ok(is_complete)
}

/// All checks except that of the clocks, and of values: whether the data agree with the model.
fn sensors(experiment: &mut Experiment, preset: &[(u32, f64)], deadline: &Deadline) -> Result<bool, Refusal> {
    repeats::set_aside(experiment);
    averaged::reconstruct(experiment);
    clipped::outputs(experiment);
    enough(experiment)?;
    let unusable = outside_limits(experiment)
        .or_else(|| copies::repeated(experiment))
        .or_else(|| copies::of_another_file(experiment))
        .or_else(|| clipped::input(experiment))
        .or_else(|| consistency::wrapped::found(experiment, preset, deadline))
        .or_else(|| exchanged::set_aside(experiment, preset, deadline));
    if let Some(unusable) = unusable {
        return Err(Refusal::Unusable(unusable));
    }
    converter::set_aside(experiment);
    let spikes = signals::set_aside(experiment);
    dead_torque::set_aside(experiment, preset)?;
    first_rows::set_aside(experiment, preset)?;
    misplaced::set_aside(experiment, preset, deadline);
    bursts::set_aside(experiment, preset, deadline);
    modes::correct(experiment, preset, deadline)?;
    let stated = (experiment.priors.clone(), experiment.released.clone());
    // What the wrong readings asked for is not wanted without them.
    let again = |experiment: &mut Experiment| {
        (experiment.priors, experiment.released) = stated.clone();
        Fits::of(experiment, preset, deadline)
    };
    let mut fits = Fits::of(experiment, preset, deadline)?;
    if let Some(unusable) = clock_jumps::found(experiment, &fits.own()) {
        return Err(Refusal::Unusable(unusable));
    }
    if saturated::set_aside(experiment, &fits.predicted, &fits.own()) {
        fits = again(experiment)?;
    }
    if gaps::split(experiment, preset, fits.own(), deadline) {
        fits = again(experiment)?;
    }
    let mut known = Vec::new();
    while drifts::set_aside(experiment, preset, (&fits.fitted, &mut known), deadline)? {
        fits = again(experiment)?;
    }
    let own = fits.own();
    let Fits { predicted, fitted, is_sure } = fits;
    pulses::set_aside(experiment, &own, &spikes);
    // A sensor that is right looks wrong beside a dead input, and is the evidence against it.
    let asked = experiment.clone();
    let deviations = || deviations(&asked, preset, &predicted, deadline);
    response::set_aside(experiment, &predicted, (&fitted, &is_sure), deviations);
    let unusable = dead_input::found(&asked, preset, &predicted, deadline)
        .or_else(|| nothing_left(experiment))
        .or_else(|| start::of_single_sensor(experiment));
    if let Some(unusable) = unusable {
        return Err(Refusal::Unusable(unusable));
    }
    Ok(is_sure.iter().all(|sure| *sure))
}

/// What the model predicts.
struct Fits {
    /// By the preset.
    predicted: Predicted,
    /// All outputs by the fit that is the reference of each output.
    fitted: Vec<Predicted>,
    /// Whether the data of each reference agree with the model.
    is_sure: Vec<bool>,
}

impl Fits {
    /// Of data that no mistake in a column and no start at another temperature contradicts.
    fn of(experiment: &mut Experiment, preset: &[(u32, f64)], deadline: &Deadline) -> Result<Fits, Refusal> {
        let references =
            consistency::contradiction(experiment, preset, deadline)?.map_err(Refusal::Unusable)?;
        if let Some(unusable) = start::elsewhere(experiment) {
            return Err(Refusal::Unusable(unusable));
        }
        let predicted = predicted(experiment, preset, &all_runs(experiment), deadline);
        let of = |reference: &Option<consistency::Reference>| match reference {
            Some(one) => predicted_by(experiment, preset, &all_runs(experiment), &one.hypothesis, deadline),
            None => Ok(predicted.clone()),
        };
        let fitted = references.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        let is_sure = references.iter().map(|r| r.as_ref().is_some_and(|r| r.is_sure)).collect();
        Ok(Fits { predicted, fitted, is_sure })
    }

    /// Each output by its own fit.
    fn own(&self) -> Predicted {
        let runs = 0..self.predicted.len();
        runs.map(|run| self.fitted.iter().enumerate().map(|(k, all)| all[run][k].clone()).collect()).collect()
    }
}

fn all_runs(experiment: &Experiment) -> Vec<usize> {
    (0..experiment.runs.len()).collect()
}

/// Rejects runs that are too short to be fitted.
fn enough(experiment: &Experiment) -> Result<(), CalibrateError> {
    for run in experiment.runs.iter().filter(|r| r.role == Role::Fit) {
        let rows = counted(run).count();
        if rows < LEAST_ROWS {
            return Err(CalibrateError(format!(
                "{}: {rows} rows count, and the fit needs at least {LEAST_ROWS} rows of each run",
                run.file
            )));
        }
    }
    if experiment.priors.is_empty() {
        return Err(CalibrateError(format!(
            "the experiment {} has no [prior]: without a parameter that may differ from the preset, every difference between two \
             specimens would be taken for a missing effect; name the parameters that may differ, each with its relative standard \
             deviation",
            experiment.name
        )));
    }
    Ok(())
}

/// Rows of a run inside its window.
fn counted(run: &Run) -> impl Iterator<Item = usize> + '_ {
    let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    run.table.time.iter().enumerate().filter(move |(_, t)| (from..=to).contains(*t)).map(|(k, _)| k)
}

/// Inputs outside the limits of their variable: single readings are set aside; if most are outside, the unit is wrong.
fn outside_limits(experiment: &mut Experiment) -> Option<Unusable> {
    let declaration = declaration(experiment)?;
    for (k, channel) in experiment.inputs.iter().enumerate() {
        let Some(entry) = channel.input.and_then(|name| declaration.by_name(name)) else { continue };
        let (least, most) = (entry.row.min, entry.row.max);
        for run in &mut experiment.runs {
            let column = &mut run.table.columns[k];
            // Noise about a limit, such as that of a fan at rest, is tolerated. A limit above zero is that of a physical quantity.
            let slack = SMALL * (most - least);
            let below = if least > 0.0 { slack.min(SMALL * least) } else { slack };
            let beyond = |x: &f64| *x < least - below || *x > most + slack;
            let there = column.iter().filter(|x| x.is_finite()).count();
            let count = column.iter().filter(|x| beyond(x)).count();
            if count == 0 {
                continue;
            }
            let reading = column.iter().find(|x| beyond(x)).map_or(0.0, |x| x - channel.offset);
            let (least, most) = (least - channel.offset, most - channel.offset);
            if count as f64 > WRONG_UNIT * there as f64 || channel.unit == Unit::One {
                return Some(Unusable::new(
                    channel.column,
                    format!(
                        "{} reads {} in {}; its limits are {} and {}",
                        channel.column,
                        converted(reading),
                        run.file,
                        converted(least),
                        converted(most)
                    ),
                    format!(
                        "check the unit of the column; [columns] converts other units, such as {}",
                        other_units(channel)
                    ),
                ));
            }
            column.iter_mut().filter(|x| beyond(x)).for_each(|x| *x = f64::NAN);
            experiment.notes.push(format!(
                "{}: {} of {} outside {} ... {} set aside",
                run.file,
                count_of(count, "reading"),
                channel.column,
                converted(least),
                converted(most)
            ));
        }
    }
    None
}

fn other_units(channel: &Channel) -> String {
    let all = crate::experiment::units::names(channel.unit).iter().copied();
    all.filter(|name| !channel.column.ends_with(name)).collect::<Vec<_>>().join(", ")
}

fn declaration(experiment: &Experiment) -> Option<&'static Declaration> {
    physics::models::by_name(&experiment.model).map(|m| (m.declaration)())
}

/// Prediction of the preset for each output at every row of these runs; blank for a run that cannot be simulated.
fn predicted(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    runs: &[usize],
    deadline: &Deadline,
) -> Predicted {
    let Ok(mut bench) = Bench::new(experiment, preset) else { return vec![Vec::new(); runs.len()] };
    bench.ease = crate::setup::EASE;
    bench.deadline = deadline.clone();
    let of = |run: &usize| {
        let run = &experiment.runs[*run];
        let shown = Drive::new(experiment, run).and_then(|drive| bench.run(&drive, &Override::default()));
        shown.unwrap_or_else(|_| vec![vec![f64::NAN; run.table.time.len()]; experiment.outputs.len()])
    };
    parallel::map(runs, of)
}

/// Prediction of a fit for some runs.
fn predicted_by(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    runs: &[usize],
    fitted: &Hypothesis,
    deadline: &Deadline,
) -> Result<Predicted, CalibrateError> {
    let setup = Setup::new(experiment, preset)?.until(deadline.clone());
    let of = |run: &usize| {
        let run = *run;
        let shown = setup.bench.run(&setup.drives[run], &setup.change(fitted, run));
        let rows = experiment.runs[run].table.time.len();
        shown.unwrap_or_else(|_| vec![vec![f64::NAN; rows]; experiment.outputs.len()])
    };
    Ok(parallel::map(runs, of))
}

/// Standard deviations of the preset's prediction due to the priors of the declared parameters; 0 if it cannot be simulated.
fn deviations(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    predicted: &[Vec<Vec<f64>>],
    deadline: &Deadline,
) -> Predicted {
    let mut all: Predicted =
        predicted.iter().map(|run| run.iter().map(|c| vec![0.0; c.len()]).collect()).collect();
    let Ok(setup) = Setup::new(experiment, preset) else { return all };
    for (k, declared) in setup.declared.iter().enumerate() {
        let mut moved = setup.preset();
        moved.declared[k] = (declared.prior + declared.deviation).clamp(declared.limits.0, declared.limits.1);
        let Ok(shown) = predicted_by(experiment, preset, &all_runs(experiment), &moved, deadline) else {
            continue;
        };
        let rows =
            all.iter_mut().zip(&shown).zip(predicted).flat_map(|((a, b), c)| a.iter_mut().zip(b).zip(c));
        for ((sum, moved), own) in rows {
            for ((sum, moved), own) in
                sum.iter_mut().zip(moved).zip(own).filter(|((_, a), b)| (**a - **b).is_finite())
            {
                *sum += (moved - own).powi(2);
            }
        }
    }
    all.iter_mut().flatten().flatten().for_each(|x| *x = x.sqrt());
    all
}

/// The ambient temperature at each row of a run, K; blank without such a column.
fn ambient(experiment: &Experiment, run: &Run) -> Vec<f64> {
    let place = experiment.inputs.iter().position(|c| c.is_ambient());
    let Some(place) = place else { return vec![f64::NAN; run.table.time.len()] };
    let mut last = run.table.columns[place].iter().copied().find(|x| x.is_finite()).unwrap_or(f64::NAN);
    let held = |x: &f64| {
        if x.is_finite() {
            last = *x;
        }
        last
    };
    run.table.columns[place].iter().map(held).collect()
}

/// Reason why the fit runs have no readings left.
fn nothing_left(experiment: &Experiment) -> Option<Unusable> {
    let inputs = experiment.inputs.len();
    let has = |k: usize| {
        let runs = experiment.runs.iter().filter(|r| r.role == Role::Fit);
        runs.flat_map(|r| counted(r).map(|row| r.table.columns[inputs + k][row])).any(f64::is_finite)
    };
    let left: Vec<usize> = (0..experiment.outputs.len()).filter(|k| has(*k)).collect();
    left.is_empty().then(|| {
        let channel = experiment.outputs[0].column;
        Unusable::new(
            channel,
            format!("no output has a usable reading in the runs that are fitted; first of all {channel}"),
            "repair the sensors that the notes name, or fit other runs",
        )
    })
}

/// Setup of an experiment with structure errors as noise, scaled to the readings of these runs.
fn structured<'a>(
    experiment: &'a Experiment,
    preset: &[(u32, f64)],
    runs: &[usize],
) -> Result<Setup<'a>, CalibrateError> {
    let mut setup = Setup::new(experiment, preset)?;
    setup.declared.iter_mut().for_each(|d| d.is_free = is_wide(d));
    let inputs = experiment.inputs.len();
    for k in 0..experiment.outputs.len() {
        setup.noise[inputs + k] = setup.noise[inputs + k].hypot(structure(experiment, runs, k));
    }
    Ok(setup)
}

/// Structure error of an output over runs, as the standard deviation of independent readings.
fn structure(experiment: &Experiment, runs: &[usize], output: usize) -> f64 {
    let (square, count) = mean_square(experiment, runs, output);
    let count = count as f64;
    let samples = (SAMPLES * runs.len() as f64).min(count.max(1.0));
    STRUCTURE * (square * count / samples).sqrt()
}

/// Deviation of an output's readings in a run from its prediction, by row.
fn deviation(experiment: &Experiment, predicted: &[Vec<f64>], output: usize, run: usize) -> Vec<f64> {
    let column = experiment.readings(run, output);
    let Some(model) = predicted.get(output) else { return vec![f64::NAN; column.len()] };
    column.iter().zip(model).map(|(y, p)| y - p).collect()
}

/// Mean square of an output over runs (temperatures: rise over ambient), and the number of its readings.
pub fn mean_square(experiment: &Experiment, runs: &[usize], output: usize) -> (f64, usize) {
    let is_temperature = experiment.outputs[output].is_temperature();
    let (mut sum, mut count) = (0.0, 0);
    for run in runs {
        let zero = ambient(experiment, &experiment.runs[*run]);
        for (y, zero) in experiment.readings(*run, output).iter().zip(zero).filter(|(y, _)| y.is_finite()) {
            sum += (y - if is_temperature { zero } else { 0.0 }).powi(2);
            count += 1;
        }
    }
    (sum / count.max(1) as f64, count)
}

#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
pub(crate) use odd_file::tests::three;
