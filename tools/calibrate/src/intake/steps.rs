//! Steps of a thermometer that has moved: from one reading to the next its deviation from the prediction changes, and stays changed.
//!
//! e(k) - e(k - 1) = d,   median e[k, k + n) - median e[k - n, k) > d / 2,   e = y - p                        (1)
//! e(later, u = before) - e(before) and e(after) - e(earlier, u = after): their mean is above d / 2               (2)
//!
//! y the readings, p the prediction, u the inputs that change at the step, n a few readings. A prediction that follows a change of the load
//! too fast or too slowly changes e over several rows, or returns: (1). A law of the sensor over an input (speed, fan) changes e wherever
//! that input changes, and back where it returns; a sensor that has moved stays moved: (2), with the nearest rows at the same inputs.
//! Without such rows a step counts if it is greater than the error of a thermometer that works.
//!
//! *Source*: detection of abrupt changes in a residual: Basseville and Nikiforov, Detection of Abrupt Changes (1993), ch. 2.

use super::signals::{NEAR, SENSOR_ERROR, WIDEST};
use super::{median, range};
use crate::levels::{FACTOR, SMALL};

/// Unpredicted fraction of a jump above which it is attributed to the sensor. Limit: if the preset's heat capacity is within a factor
/// of two of the motor's, the model predicts at least half of a step.
pub(super) const UNPREDICTED: f64 = 0.5;

/// An input in a run.
pub(super) struct Load<'a> {
    pub(super) values: &'a [f64],
    /// Greatest minus least value in all runs.
    pub(super) range: f64,
}

/// Deviations of a thermometer in a run, and what may explain a step of them.
pub(super) struct Steps<'a> {
    pub(super) off: &'a [f64],
    pub(super) time: &'a [f64],
    /// Rows of `off` and `time` in the table.
    pub(super) rows: &'a [usize],
    pub(super) loads: &'a [Load<'a>],
}

impl Steps<'_> {
    /// Whether a change of the deviation by this much at a reading is a step of the sensor.
    pub(super) fn is_one(&self, k: usize, size: f64) -> bool {
        let is_large = size.abs() > SENSOR_ERROR;
        (is_large || self.is_kept(k, size)) && self.is_kept_at_equal_inputs(k, size).unwrap_or(is_large)
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

    /// (1), without a gap between the two rows.
    fn is_kept(&self, k: usize, size: f64) -> bool {
        let interval = |j: usize| self.time[j] - self.time[j - 1];
        let usual = median((1..self.time.len()).map(interval));
        let change = self.level(self.after(k)) - self.level(Self::before(k));
        interval(k) < FACTOR * usual && (change - size).abs() < UNPREDICTED * size.abs()
    }

    /// (2); `None` if it cannot be decided.
    fn is_kept_at_equal_inputs(&self, k: usize, size: f64) -> Option<bool> {
        let around = self.rows[k.saturating_sub(WIDEST)]..=self.rows[k];
        let changed: Vec<&Load> = self
            .loads
            .iter()
            .filter(|load| range(load.values[around.clone()].iter().copied()) > SMALL * load.range)
            .collect();
        if changed.is_empty() {
            return Some(true);
        }
        let alike = |a: usize, b: usize| {
            let differs = |load: &&Load| {
                (load.values[self.rows[a]] - load.values[self.rows[b]]).abs() > SMALL * load.range
            };
            !changed.iter().any(differs)
        };
        let enough = |rows: Vec<usize>| (rows.len() >= NEAR).then_some(rows);
        let later = (k..self.off.len()).filter(|j| alike(*j, k.saturating_sub(WIDEST))).take(NEAR).collect();
        let earlier = (0..k).rev().filter(|j| alike(*j, k)).take(NEAR).collect();
        let back = enough(later).map(|rows| self.level(rows.into_iter()) - self.level(Self::before(k)));
        let once = enough(earlier).map(|rows| self.level(self.after(k)) - self.level(rows.into_iter()));
        let (count, sum) = [back, once].iter().flatten().fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
        (count > 0.0).then(|| sum / count * size.signum() > UNPREDICTED * size.abs())
    }
}
