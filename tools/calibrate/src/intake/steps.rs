//! Steps of a thermometer that has moved: from one reading to the next its deviation from the prediction changes, and stays changed.
//!
//! e(k) - e(k - 1) = d,   median e[k, k + n) - median e[k - n, k) > d / 2,   e = y - p                        (1)
//! e(later, u = before) - e(before) and e(after) - e(earlier, u = after): their mean is above d / 2               (2)
//! at other steps of u, in any run, of at least half the size: e changes by d / 2 in the sense of (1)                     (3)
//!
//! y the readings, p the prediction, u an input that changes at the step, n a few readings. A prediction that follows a change of the load
//! too fast or too slowly changes e over several rows, or returns: (1). A law of the sensor over an input (speed, fan), smooth or with a
//! threshold, changes e wherever that input changes, and back where it returns; a sensor that has moved stays moved, and does so once: not
//! (2), with the nearest rows at the same input, or (3) at a fraction [`PART`] of the other steps. Without rows for (2) a step counts if it is
//! greater than the error of a thermometer that works. What happens in a gap between the rows is no step: the load may have changed.
//!
//! *Source*: detection of abrupt changes in a residual: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

use super::signals::{NEAR, SENSOR_ERROR, WIDEST};
use super::{median, range};
use crate::experiment::Experiment;
use crate::levels::{FACTOR, PART, SMALL};

/// Unpredicted fraction of a jump above which it is attributed to the sensor. Limit: if the preset's heat capacity is within a factor
/// of two of the motor's, the model predicts at least half of a step.
pub(super) const UNPREDICTED: f64 = 0.5;

/// The loads of an experiment, and the deviations of a thermometer from its fit in all runs.
pub(super) struct Record<'a> {
    experiment: &'a Experiment,
    /// Columns of the inputs that are no temperatures, with their range over all runs.
    loads: Vec<(usize, f64)>,
    /// By run and row.
    off: &'a [Vec<f64>],
}

impl<'a> Record<'a> {
    pub(super) fn new(experiment: &'a Experiment, off: &'a [Vec<f64>]) -> Record<'a> {
        let of = |k: usize| range(experiment.runs.iter().flat_map(|r| r.table.columns[k].iter().copied()));
        let loads = (0..experiment.inputs.len()).filter(|k| !experiment.inputs[*k].is_temperature());
        Record { experiment, loads: loads.map(|k| (k, of(k))).collect(), off }
    }

    fn load(&self, run: usize, input: usize) -> &[f64] {
        &self.experiment.runs[run].table.columns[input]
    }

    /// The loads that change up to a row: column, range and change.
    fn changed(&self, run: usize, rows: std::ops::RangeInclusive<usize>) -> Vec<(usize, f64, f64)> {
        let of = |(input, all): &(usize, f64)| {
            let own = &self.load(run, *input)[rows.clone()];
            (range(own.iter().copied()) > SMALL * all).then(|| (*input, *all, own[own.len() - 1] - own[0]))
        };
        self.loads.iter().filter_map(of).collect()
    }

    /// (3): whether a step of the deviation by `size` in a row, at which the load changes by `change`, is one of several.
    fn is_law(&self, (run, row): (usize, usize), (input, change): (usize, f64), size: f64) -> bool {
        let (mut steps, mut like) = (0.0, 0.0);
        for (other, off) in self.off.iter().enumerate() {
            let load = self.load(other, input);
            let by = |k: usize| load[k] - load[k - 1];
            for k in 1..load.len().min(off.len()) {
                let is_own = other == run && k.abs_diff(row) <= WIDEST;
                if is_own || by(k).abs() < UNPREDICTED * change.abs() {
                    continue;
                }
                let sense = size.signum() * change.signum() * by(k).signum();
                let most = (k..(k + 2).min(off.len())).map(|k| sense * (off[k] - off[k - 1]));
                steps += 1.0;
                if most.fold(f64::NEG_INFINITY, f64::max) > UNPREDICTED * size.abs() {
                    like += 1.0;
                }
            }
        }
        steps > 0.0 && like >= (PART * steps).max(1.0)
    }
}

/// Deviations of a thermometer in a run, and what may explain a step of them.
pub(super) struct Steps<'a> {
    pub(super) run: usize,
    pub(super) off: &'a [f64],
    pub(super) time: &'a [f64],
    /// Rows of `off` and `time` in the table.
    pub(super) rows: &'a [usize],
    pub(super) record: &'a Record<'a>,
}

impl Steps<'_> {
    /// Whether a change of the deviation by this much at a reading is a step of the sensor.
    pub(super) fn is_one(&self, k: usize, size: f64) -> bool {
        self.is_sudden(k, size) && (size.abs() > SENSOR_ERROR || self.is_kept(k, size))
    }

    /// Whether neither a gap nor an input explains it.
    pub(super) fn is_sudden(&self, k: usize, size: f64) -> bool {
        // The first rows have the error of a measured start, and few readings before them.
        if k < NEAR || self.is_after_gap(k) {
            return false;
        }
        let row = self.rows[k];
        let changed = self.record.changed(self.run, self.rows[k.saturating_sub(WIDEST)]..=row);
        let law = |(input, _, change): &(usize, f64, f64)| {
            self.record.is_law((self.run, row), (*input, *change), size)
        };
        let kept: Vec<bool> = changed.iter().filter_map(|one| self.is_kept_at_equal(*one, k, size)).collect();
        let is_known = changed.is_empty() || !kept.is_empty() || size.abs() > SENSOR_ERROR;
        is_known && !kept.contains(&false) && !changed.iter().any(law)
    }

    fn is_after_gap(&self, k: usize) -> bool {
        let interval = |j: usize| self.time[j] - self.time[j - 1];
        let near = k.saturating_sub(NEAR).max(1)..(k + NEAR).min(self.time.len());
        interval(k) > FACTOR * median(near.map(interval))
    }

    fn before(k: usize) -> std::ops::Range<usize> {
        k.saturating_sub(NEAR)..k
    }

    fn after(&self, k: usize) -> std::ops::Range<usize> {
        k..(k + NEAR).min(self.off.len())
    }

    fn level(&self, at: impl Iterator<Item = usize>) -> f64 {
        median(at.map(|k| self.off[k]))
    }

    /// (1)
    fn is_kept(&self, k: usize, size: f64) -> bool {
        let change = self.level(self.after(k)) - self.level(Self::before(k));
        (change - size).abs() < UNPREDICTED * size.abs()
    }

    /// (2) for a load; `None` if it cannot be decided.
    fn is_kept_at_equal(&self, (input, all, _): (usize, f64, f64), k: usize, size: f64) -> Option<bool> {
        let load = self.record.load(self.run, input);
        let alike = |a: usize, b: usize| (load[self.rows[a]] - load[self.rows[b]]).abs() < SMALL * all;
        let enough = |rows: Vec<usize>| (rows.len() >= NEAR).then_some(rows);
        let later = (k..self.off.len()).filter(|j| alike(*j, k.saturating_sub(WIDEST))).take(NEAR).collect();
        let earlier = (0..k).rev().filter(|j| alike(*j, k)).take(NEAR).collect();
        let back = enough(later).map(|rows| self.level(rows.into_iter()) - self.level(Self::before(k)));
        let once = enough(earlier).map(|rows| self.level(self.after(k)) - self.level(rows.into_iter()));
        let (count, sum) = [back, once].iter().flatten().fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
        (count > 0.0).then(|| sum / count * size.signum() > UNPREDICTED * size.abs())
    }
}
