//! Instruments that average: one whose input or output is behind a filter, and how long it is.
//!
//! With an imposed speed, y(t) = q(u(t)) for voltage, current and torque (`unsynchronized.rs`), and
//!
//! an output behind a filter F:    y = F q(u)                                                       (1)
//! an input behind a first-order lag:    y = q(u + tau du/dt)                                      (2)
//!
//! F is a lag of first or second order, an exponential smoothing of the rows, a mean over the last seconds, or a delay, which is here to be
//! compared with: `clocks.rs` states it better. q is fitted anew for each. The filter of an input acts on all outputs that follow from it; it
//! is a mistake in the data if (2) explains them better than (1) with a filter for each. An input without its filter would have several times the noise, and heats by its
//! square, so that it is not corrected. The readings of an output count where F q differs from q by less than half of the noise.
//!
//! *Source*: comparison of models by their likelihood: Ljung, System Identification (2nd ed., 1999), ch. 16.4.

use super::clocks::LEAST;
use super::unsynchronized::{LONGEST, MAJORITY, Readings, mean_square, sum, weights};
use super::{Mistake, Unusable, all_runs, predicted};
use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::levels::{CALIBRATED, CERTAIN, FACTOR};
use crate::noise;
use crate::numbers::{between, median};
use physics::declare::Unit;

/// Ratio of neighbouring times that are tried. Numerical: a filter of another time constant leaves a fifth of the error.
const RATIO: f64 = 1.2;

/// Ratio of two times that are alike. Numerical: the error of a mean with another time is less than a hundredth of a step.
const NEAREST: f64 = 1.01;

/// How an instrument averages.
#[derive(Clone, Copy)]
enum Filter {
    /// Lags of first order, one behind the other.
    Lag(usize),
    /// Exponential smoothing row by row, as a logger's program does it.
    Smoothing,
    /// Mean over the last seconds.
    Mean,
    /// The same reading later.
    Delay,
}

/// The filters that are tried. Definition: those of instruments and loggers.
const FILTERS: [Filter; 5] = [Filter::Lag(1), Filter::Lag(2), Filter::Smoothing, Filter::Mean, Filter::Delay];

impl Filter {
    /// `None` for a delay, which is no filter.
    fn words(self, tau: f64) -> Option<String> {
        match self {
            Filter::Lag(1) | Filter::Smoothing => Some(format!("a first-order lag of about {tau:.1} s")),
            Filter::Lag(_) => Some(format!("two first-order lags of about {tau:.1} s each")),
            Filter::Mean => Some(format!("a mean over about the last {tau:.1} s")),
            Filter::Delay => None,
        }
    }

    /// The time in which the error falls by a factor, s; at most, for a mean.
    fn after(self, tau: f64, factor: f64) -> f64 {
        match self {
            Filter::Lag(order) => order as f64 * tau * factor.ln(),
            Filter::Smoothing => tau * factor.ln(),
            Filter::Mean | Filter::Delay => tau.min(tau * factor.ln()),
        }
    }

    /// A column behind the filter with this time in s; it is at rest before the first row, and linear between rows.
    fn of(self, time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
        match self {
            Filter::Lag(order) => (0..order).fold(column.to_vec(), |x, _| lagged(time, &x, tau)),
            Filter::Smoothing => {
                let mut y = column.to_vec();
                for k in 1..y.len() {
                    y[k] += ((time[k - 1] - time[k]) / tau).exp() * (y[k - 1] - y[k]);
                }
                y
            }
            Filter::Mean => {
                let area = integral(time, column);
                let since = |t: f64| between(time, &area, t) + column[0] * (t - time[0]).min(0.0);
                (0..time.len()).map(|k| (area[k] - since(time[k] - tau)) / tau).collect()
            }
            Filter::Delay => time.iter().map(|t| between(time, column, t - tau)).collect(),
        }
    }
}

fn lagged(time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
    let mut y = column.to_vec();
    for k in 1..column.len() {
        let step = time[k] - time[k - 1];
        let kept = (-step / tau).exp();
        // The response to a line from one row to the next.
        let slope = (column[k] - column[k - 1]) / step;
        y[k] = column[k] - tau * slope + kept * (y[k - 1] - column[k - 1] + tau * slope);
    }
    y
}

fn integral(time: &[f64], column: &[f64]) -> Vec<f64> {
    let mut area = vec![0.0; column.len()];
    for k in 1..column.len() {
        area[k] = area[k - 1] + 0.5 * (column[k] + column[k - 1]) * (time[k] - time[k - 1]);
    }
    area
}

/// Times that are tried, s, from the interval between rows on.
fn times(step: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(step), |tau| Some(tau * RATIO)).take_while(|tau| *tau <= LONGEST)
}

/// An output in a run that does not follow the inputs at the same row.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub output: usize,
    pub run: usize,
    /// Mean square that q leaves in the rows away from changes.
    pub least: f64,
}

/// The readings at a place, and the mean square that q leaves in all of them.
pub(super) type AsIs = (Readings, f64);

/// Those of a place; `None` if they are too few.
pub(super) fn as_is(experiment: &Experiment, model: &[Vec<f64>], place: &Place) -> Option<AsIs> {
    let own = Readings::new(experiment, model, place.run, place.output)?;
    let left = own.left()?;
    Some((own, left))
}

/// Gain in -2 ln p if a mean square of the residual of these readings takes the place of another one.
fn gain(own: &Readings, as_is: f64, changed: f64) -> f64 {
    own.rows.len() as f64 * (as_is / changed).ln()
}

/// The input whose filter explains these outputs: better than a filter of each does, and most of what the rows away from changes do not have.
pub(super) fn input(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    places: &[Place],
    deadline: &Deadline,
) -> Option<Unusable> {
    let runs = all_runs(experiment);
    let read = |experiment: &Experiment| -> Option<Vec<AsIs>> {
        let model = predicted(experiment, preset, &runs, deadline);
        places.iter().map(|place| as_is(experiment, &model[place.run], place)).collect()
    };
    let all = read(experiment)?;
    let step = all.iter().map(|(own, _)| own.step()).fold(0.0, f64::max);
    let is_load =
        |k: &usize| !experiment.inputs[*k].is_temperature() && experiment.inputs[*k].unit != Unit::One;
    let loads = (0..experiment.inputs.len()).filter(is_load);
    let mut best: Option<(f64, Mistake)> = None;
    for mistake in loads.flat_map(|k| times(step).map(move |tau| Mistake::Slow(k, tau))) {
        if deadline.is_near() {
            return None;
        }
        let mut data = experiment.clone();
        mistake.apply(&mut data, &runs);
        let Some(changed) = read(&data) else { continue };
        let gain = all.iter().zip(&changed).map(|((own, as_is), (_, left))| gain(own, *as_is, *left)).sum();
        if best.as_ref().is_none_or(|(most, _)| gain > *most) {
            best = Some((gain, mistake));
        }
    }
    let (own, mistake) = best?;
    let of_outputs: f64 = all.iter().filter_map(|one| filtered(&[one]).map(|(gain, ..)| gain)).sum();
    let mut data = experiment.clone();
    mistake.apply(&mut data, &runs);
    // What the rows away from changes do not have, as mean squares before and after.
    let excess =
        |((_, as_is), (_, left)): (&AsIs, AsIs), place: &Place| (left - place.least) / (as_is - place.least);
    let changed = read(&data)?;
    let rest = median(all.iter().zip(changed).zip(places).map(|(pair, place)| excess(pair, place)));
    if own < of_outputs + LEAST || rest > 1.0 - MAJORITY {
        return None;
    }
    let (channel, reason, suggestion) = mistake.words(experiment, "every run");
    Some(Unusable { mistake: Some(Box::new(mistake)), ..Unusable::new(&channel, reason, suggestion) })
}

/// The filter that explains an output in some runs best: its gain, kind and time.
fn filtered(all: &[&AsIs]) -> Option<(f64, Filter, f64)> {
    let of = |(filter, tau): (Filter, f64)| {
        let of_run = |(own, as_is): &&AsIs| {
            Some(gain(own, *as_is, own.behind(|column| filter.of(&own.time, column, tau))?))
        };
        Some((all.iter().map(of_run).sum::<Option<f64>>()?, filter, tau))
    };
    let best =
        |all: &mut dyn Iterator<Item = (Filter, f64)>| all.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0));
    let step = all.iter().map(|(own, _)| own.step()).fold(0.0, f64::max);
    let mut found =
        best(&mut FILTERS.into_iter().flat_map(|filter| times(step).map(move |tau| (filter, tau))))?;
    let mut ratio = RATIO;
    while ratio > NEAREST {
        ratio = ratio.sqrt();
        let (_, filter, tau) = found;
        found = best(&mut [tau / ratio, tau, tau * ratio].into_iter().map(|tau| (filter, tau)))?;
    }
    Some(found)
}

/// The filter of an output, in words, and by run the rows whose readings it changes by more than half of the noise, if it explains all rows
/// nearly as well as those away from changes are explained without it. A filter belongs to the instrument and not to a run.
pub(super) fn output(runs: &[AsIs], least: &[f64]) -> Option<(String, Vec<Vec<usize>>)> {
    let (gain, filter, tau) = filtered(&runs.iter().collect::<Vec<_>>())?;
    let words = filter.words(tau)?;
    let of = |(own, _): &AsIs| {
        let columns: Vec<Vec<f64>> =
            own.levels.iter().map(|column| filter.of(&own.time, column, tau)).collect();
        let all: Vec<usize> = (0..own.rows.len()).collect();
        let weights = weights(&columns, &own.y, &all)?;
        let [behind, at_once] = [&columns, &own.levels].map(|levels| sum(levels, &weights, all.len()));
        let left = mean_square(&own.y, &behind, &all);
        let off: Vec<f64> = behind.iter().zip(&at_once).map(|(a, b)| (a - b).abs()).collect();
        let least = CALIBRATED * noise::of_column(&own.time, &own.y)?;
        // Changes that are no noise of the inputs, and the time in which the filter takes them to the least.
        let seen = least + CERTAIN * noise::of_column(&own.time, &off)?;
        let after = filter.after(tau, seen / least);
        let mut until = f64::NEG_INFINITY;
        let is_off = |row: &usize| {
            if off[*row] > seen {
                until = own.time[*row] + after;
            }
            own.time[*row] <= until
        };
        Some((left, all.into_iter().filter(is_off).map(|row| own.rows[row]).collect::<Vec<_>>()))
    };
    let all: Vec<(f64, Vec<usize>)> = runs.iter().map(of).collect::<Option<_>>()?;
    // Of all runs together, as the filter.
    let ratio = median(all.iter().zip(least).map(|((left, _), least)| left / least));
    (gain > LEAST && ratio <= FACTOR).then(|| (words, all.into_iter().map(|(_, rows)| rows).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{CURRENT, SPEED, TORQUE, VOLTAGE, column, experiment};
    use super::super::unsynchronized::set_aside;
    use super::*;

    fn behind(data: &mut Experiment, k: usize, filter: Filter, tau: f64) {
        let time = data.runs[0].table.time.clone();
        let own = filter.of(&time, column(data, k), tau);
        *column(data, k) = own;
    }

    /// A line, a step and a ramp behind each filter, against the integrals of their responses.
    #[test]
    fn filters_have_the_responses_of_their_equations() {
        let time: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        let ramp: Vec<f64> = time.iter().map(|t| (t - 10.0).max(0.0)).collect();
        let at = |filter: Filter, tau: f64, t: usize| filter.of(&time, &ramp, tau)[t];
        let since = 10.0f64;
        let e = (-since / 3.0).exp();
        assert!((at(Filter::Lag(1), 3.0, 200) - (since - 3.0 * (1.0 - e))).abs() < 1e-9);
        let second = since - 6.0 + e * (6.0 + since);
        assert!((at(Filter::Lag(2), 3.0, 200) - second).abs() < 2e-3);
        assert!((at(Filter::Mean, 4.0, 200) - 8.0).abs() < 1e-9);
        assert!((at(Filter::Delay, 4.05, 200) - 5.95).abs() < 1e-9);
    }

    /// The kind of the filter and its time constant are found, and the readings that are left are right.
    #[test]
    fn the_filter_of_an_output_is_found() {
        let cases = [
            (VOLTAGE, Filter::Lag(1), 7.0, "a first-order lag of about"),
            (TORQUE, Filter::Lag(1), 13.0, "a first-order lag of about"),
            (TORQUE, Filter::Lag(2), 5.0, "two first-order lags of about"),
            (VOLTAGE, Filter::Mean, 31.0, "a mean over about the last"),
        ];
        for (n, (k, filter, tau, words)) in cases.into_iter().enumerate() {
            let mut data = experiment(91 + n as u64);
            let right = column(&mut data, k).clone();
            behind(&mut data, k, filter, tau);
            assert_eq!(set_aside(&mut data, &[], &Deadline::default()), None);
            let note = data.notes.iter().find(|note| note.contains("is behind")).cloned().unwrap_or_default();
            let said: f64 = note
                .split(words)
                .nth(1)
                .and_then(|rest| rest.trim_start().split(' ').next()?.parse().ok())
                .unwrap_or_default();
            assert!((said / tau).ln().abs() < RATIO.ln(), "{n}: {tau} {:?}", data.notes);
            let span = crate::intake::response::spread(&right);
            let left =
                || column(&mut data.clone(), k).clone().into_iter().zip(right.clone()).collect::<Vec<_>>();
            let wrong = left().iter().filter(|(x, y)| (x - y).abs() > 0.05 * span).count();
            let kept = left().iter().filter(|(x, _)| x.is_finite()).count();
            assert!(kept > 300 && wrong * 50 < kept, "{n}: {wrong} of {kept}");
        }
    }

    /// All outputs that follow from it show the filter of an input; with a filter of each output there is none at the input.
    #[test]
    fn the_filter_of_an_input_is_a_mistake() {
        for (n, (k, tau)) in [(CURRENT, 4.0), (CURRENT, 9.0), (SPEED, 6.5)].into_iter().enumerate() {
            let mut data = experiment(101 + n as u64);
            behind(&mut data, k, Filter::Lag(1), tau);
            let found = set_aside(&mut data, &[], &Deadline::default());
            let found = found.unwrap();
            let Some(Mistake::Slow(column, said)) = found.mistake.as_deref() else { panic!("{found:?}") };
            // The step of a load within a row is not seen.
            let far = (said - tau).abs();
            assert!(*column == k && far <= 1.5 + (RATIO - 1.0) * tau, "{n}: {found:?}");
        }
        let mut data = experiment(104);
        [VOLTAGE, TORQUE].into_iter().for_each(|k| behind(&mut data, k, Filter::Lag(1), 8.0));
        assert_eq!(set_aside(&mut data, &[], &Deadline::default()), None, "{:?}", data.notes);
    }
}
