//! Thermometers that depart from their node in a run: a thermocouple that comes off, or a seat that fails.
//!
//! d(t) = e(t + s) - e(t),   e = y - p                                                              (1)
//!
//! y the readings, p the prediction of a fit that agrees with the data, s the time in which a thermometer in air follows. What a model
//! lacks in the motor changes e together with p, or as slowly as a heat capacity, and in both thermometers; a thermometer that comes off
//! changes e within s, in one channel, whatever p does. A departure is a change (1) that is greater than the error of a thermometer, than
//! twice the change of p and than what is usual in the runs of this channel ([`super::signals`]), while every input keeps its level, also in the
//! time s before it: a law of the sensor over speed or fan, or over a lag of them, changes e too. A sensor comes off once; a law acts in every run. Of the sections between departures, those
//! that deviate [`FACTOR`] times as far as the best one are wrong.
//!
//! *Source*: detection of abrupt changes in a residual: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

use super::signals::{JUMP, SENSOR_ERROR};
use super::{median, range, sorted};
use crate::experiment::{Experiment, Run};
use crate::levels::{CERTAIN, FACTOR, PART};
use crate::noise;

/// s of (1), s. Limit: a sheathed thermocouple of 3 mm in still air has a time constant of 20 s, and follows to 95 % in three of them.
const SETTLED: f64 = 60.0;
/// Quantile of (1) that is usual. Derivation: a departure at one time affects two of the sections of length s, which are less than a
/// quarter of a run.
const USUAL: f64 = 0.75;
/// Readings of a median on either side. Derivation: the fewest that tolerate an outlier.
const SIDE: usize = 3;
/// Fewest readings of a section that is a reference. Derivation: a standard deviation is then known to 13 %, 1 / sqrt(2 n).
const LEAST_ROWS: usize = 30;
/// The failure in words.
pub(super) const WHY: &str =
    "departs from its node within a minute while nothing changes, as a thermometer that comes off does";

/// First row of each row's later side in (1); `None` at the end of the run and across gaps.
fn later(time: &[f64]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut j = 0;
    (0..time.len()).filter_map(move |k| {
        while j < time.len() && time[j] < time[k] + SETTLED {
            j += 1;
        }
        (j < time.len() && time[j] < time[k] + 2.0 * SETTLED).then_some((k, j))
    })
}

/// (1) between two rows of a quantity, from medians on either side.
fn change(of: &[f64], (k, j): (usize, usize)) -> f64 {
    let before = median(of[(k + 1).saturating_sub(SIDE)..=k].iter().copied());
    median(of[j..(j + SIDE).min(of.len())].iter().copied()) - before
}

/// What is usual of (1), for the deviations of an output by run and row.
fn usual(experiment: &Experiment, off: &[Vec<f64>]) -> f64 {
    let all = off.iter().zip(&experiment.runs).flat_map(|(off, run)| {
        let rows: Vec<usize> = (0..off.len()).filter(|k| off[*k].is_finite()).collect();
        let time: Vec<f64> = rows.iter().map(|k| run.table.time[*k]).collect();
        let own: Vec<f64> = rows.iter().map(|k| off[*k]).collect();
        later(&time).map(|pair| change(&own, pair).abs()).collect::<Vec<_>>()
    });
    let all = sorted(all);
    all.get((USUAL * all.len() as f64) as usize).copied().unwrap_or(0.0)
}

/// For each run the rows of an output on the wrong side of a departure, for its deviations by run and row; none if more than one run has
/// departures.
pub(super) fn of(experiment: &Experiment, output: usize, off: &[Vec<f64>]) -> Vec<Vec<usize>> {
    let usual = usual(experiment, off);
    let inputs: Vec<usize> =
        (0..experiment.inputs.len()).filter(|k| !experiment.inputs[*k].is_temperature()).collect();
    let spans: Vec<f64> = inputs
        .iter()
        .map(|k| range(experiment.runs.iter().flat_map(|r| r.table.columns[*k].iter().copied())))
        .collect();
    // The rows, and whether the run has departures at all, also where inputs change.
    let of_run = |(off, run): (&Vec<f64>, &Run)| -> (Vec<usize>, bool) {
        let there: Vec<usize> = (0..off.len()).filter(|k| off[*k].is_finite()).collect();
        let table = &run.table;
        let pick = |of: &[f64]| -> Vec<f64> { there.iter().map(|k| of[*k]).collect() };
        let (time, read) = (pick(&table.time), pick(&table.columns[experiment.place_of(output)]));
        let model: Vec<f64> = read.iter().zip(pick(off)).map(|(y, e)| y - e).collect();
        let sigma = noise::of_column(&time, &read).unwrap_or(0.0);
        let is_steady = |k: usize, j: usize| {
            inputs.iter().zip(&spans).all(|(input, span)| {
                let own = &table.columns[*input][there[k]..=there[j]];
                range(own.iter().copied()) <= PART * span
            })
        };
        let of = |steady: &dyn Fn(usize, usize) -> bool| {
            rows(&time, &read, &model, (usual, 2.0 * CERTAIN * sigma), steady)
        };
        let bad = of(&is_steady);
        let own = there.iter().zip(bad).filter(|(_, bad)| *bad).map(|(k, _)| *k).collect();
        (own, of(&|_, _| true).contains(&true))
    };
    let all: Vec<(Vec<usize>, bool)> = off.iter().zip(&experiment.runs).map(of_run).collect();
    let is_one = all.iter().filter(|(_, departs)| *departs).count() == 1;
    all.into_iter().map(|(rows, _)| if is_one { rows } else { Vec::new() }).collect()
}

/// Whether each reading of a run is on the wrong side of a departure; `least` is the least change that is no noise.
fn rows(
    time: &[f64],
    read: &[f64],
    model: &[f64],
    (usual, least): (f64, f64),
    is_steady: &dyn Fn(usize, usize) -> bool,
) -> Vec<bool> {
    let off: Vec<f64> = read.iter().zip(model).map(|(y, p)| y - p).collect();
    let least = least.max(SENSOR_ERROR).max(JUMP * usual);
    let mut bad = vec![false; time.len()];
    let sized = |pair: (usize, usize)| (pair, change(&off, pair).abs());
    let departs =
        |(pair, size): &((usize, usize), f64)| *size > least && *size > 2.0 * change(model, *pair).abs();
    let found: Vec<((usize, usize), f64)> = later(time).map(sized).filter(departs).collect();
    for own in found.chunk_by(|a, b| b.0.0 <= a.0.1) {
        // What an input causes, at once or behind a lag, changes most right after it.
        let first_of_greatest = own.iter().rev().max_by(|a, b| a.1.total_cmp(&b.1));
        let since = |k: usize| time.partition_point(|t| *t < time[k] - SETTLED);
        if first_of_greatest.is_some_and(|((k, j), _)| is_steady(since(*k), *j)) {
            own.iter().for_each(|((k, j), _)| bad[*k..=*j].fill(true));
        }
    }
    let parts: Vec<(usize, usize)> = {
        let ends: Vec<usize> = (0..time.len()).filter(|k| !bad[*k] && (*k == 0 || bad[k - 1])).collect();
        let end = |from: usize| (from..time.len()).find(|k| bad[*k]).unwrap_or(time.len());
        ends.into_iter().map(|from| (from, end(from))).collect()
    };
    // The root mean square: a motor that cools down hides the failure for most of the section.
    let size =
        |(a, b): (usize, usize)| (off[a..b].iter().map(|e| e * e).sum::<f64>() / (b - a) as f64).sqrt();
    let good = parts.iter().filter(|(a, b)| b - a >= LEAST_ROWS).map(|part| size(*part));
    let best = good.fold(f64::INFINITY, f64::min);
    let wrong: Vec<(usize, usize)> =
        parts.into_iter().filter(|part| size(*part) > SENSOR_ERROR.max(FACTOR * best)).collect();
    if wrong.is_empty() {
        return vec![false; time.len()];
    }
    wrong.into_iter().for_each(|(a, b)| bad[a..b].fill(true));
    bad
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 2 s apart; the prediction heats up for 400 s and cools down.
    fn model() -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..400).map(|k| 2.0 * f64::from(k)).collect();
        let of = |t: &f64| {
            if *t < 400.0 { 8.0 * (1.0 - (-t / 90.0).exp()) } else { 7.9 * (-(t - 400.0) / 90.0).exp() }
        };
        let model = time.iter().map(of).collect();
        (time, model)
    }

    #[test]
    fn only_a_departure_without_a_cause_is_one() {
        let (time, model) = model();
        let of = |change: &dyn Fn(f64, f64) -> f64| -> Vec<usize> {
            let read: Vec<f64> = time.iter().zip(&model).map(|(t, p)| change(*t, *p)).collect();
            let bad = rows(&time, &read, &model, (0.02, 0.1), &|_, _| true);
            (0..400).filter(|k| bad[*k]).collect()
        };
        assert!(of(&|_, p| p + 1.5).is_empty());
        // A missing effect that doubles the rise, and an offset that grows over minutes.
        assert!(of(&|_, p| 2.0 * p).is_empty());
        assert!(of(&|t, p| p + 0.03 * (t - 200.0).clamp(0.0, 200.0)).is_empty());
        let off = of(&|t, p| if t < 300.0 { p } else { p * (-(t - 300.0) / 15.0).exp() });
        assert!(off.len() > 240 && off[0] > 110 && off[off.len() - 1] == 399, "{off:?}");
        let back = of(&|t, p| if (120.0..260.0).contains(&t) { p - 5.0 } else { p });
        assert!(back.len() > 60 && back[0] > 20 && back[back.len() - 1] < 165, "{back:?}");
    }
    /// A law of the sensor over a lag of an input that steps at 300 s; a thermometer that comes off 200 s later.
    #[test]
    fn what_an_input_causes_behind_a_lag_is_no_departure() {
        let (time, model) = model();
        let is_steady = |k: usize, j: usize| !(time[k] <= 300.0 && 300.0 <= time[j]);
        let bad = |change: &dyn Fn(f64) -> f64| {
            let read: Vec<f64> = time.iter().zip(&model).map(|(t, p)| p + change(*t)).collect();
            rows(&time, &read, &model, (0.02, 0.1), &is_steady).iter().filter(|bad| **bad).count()
        };
        for (size, tau) in [(5.0, 80.0), (-8.0, 30.0), (6.0, 10.0), (20.0, 200.0)] {
            assert_eq!(bad(&|t| size * (1.0 - (-(t - 300.0).max(0.0) / tau).exp())), 0, "{size} {tau}");
        }
        assert!(bad(&|t| if t < 500.0 { 0.0 } else { -6.0 }) > 120);
    }
}
