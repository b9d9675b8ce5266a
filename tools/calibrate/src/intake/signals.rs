//! Sensor failures detectable from the readings alone: spikes, jumps that are impossible for a temperature, end of the range.
//!
//! Spike: a group of up to [`WIDEST`] readings that deviate from the line between the neighbouring readings by z standard deviations,
//!
//! z > sqrt(2 ln(n / alpha)),                                                                       (1)
//!
//! n the number of readings of the experiment and alpha the probability of one false alarm in the experiment (bound on the greatest of n
//! normal variables). The standard deviation is the greater of the channel's noise and that of the neighbouring readings. A pulse in the
//! same row as one of another channel is not a spike, nor is a pulse of an input that another channel follows, at a significance level of
//! 1e-3.
//! *Sources*: Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393; Davies and Gather, J. Am. Stat. Assoc. 88 (1993) 782-792.
//!
//! Jump: a temperature belongs to a heat capacity and is continuous. A change between rows far greater than the channel's usual changes is
//! a contact failure of the sensor; on one side of it the readings are no temperature ([`super::response`] determines which).

use crate::experiment::{Channel, Experiment, Table};
use crate::levels::{SMALL, STRUCTURE};
use crate::noise;
use crate::report::count_of;

/// Probability of a false alarm in an experiment, alpha of (1). Definition: the level of the test; the bound (1) grows with the root of
/// its logarithm only.
const ALPHA: f64 = 1e-3;
/// Standard deviations at which a channel follows the pulse of an input. Derivation: two-sided quantile of the normal distribution for
/// the level [`ALPHA`].
const FOLLOWS: f64 = 3.29;
/// Most readings of a spike. Derivation: half of [`NEAR`]; a wider group is the majority of its neighbourhood, which then is no
/// reference.
pub(super) const WIDEST: usize = 5;
/// Greatest difference of the readings on both sides of a spike, as a fraction of the spike. Derivation: a spike returns to its level,
/// a step changes the level by its whole size; this is the middle.
pub(super) const ALIKE: f64 = 0.5;
/// Number of neighbouring readings. Numerical: their changes determine a scale to 20 %, and spikes exceed it many times.
pub(super) const NEAR: usize = 10;
/// Quantile of the neighbouring changes, if other pulses may be among them. Derivation: of 18 changes, another pulse accounts for two and a
/// step of an input for one.
pub(super) const NEAR_BY: f64 = 0.8;
/// A jump exceeds the channel's usual changes by this factor. Derivation: (1) for 7e4 readings.
pub(super) const JUMP: f64 = 6.0;
/// The same for a jump that the rows around it confirm. Derivation: (1) for 7e4 changes, whose quantile 1 - [`RARE`] is 2.8 standard
/// deviations.
const SMALL_JUMP: f64 = 2.0;
/// Error of a thermometer that works, K; a jump is larger. Limit: thermocouple of class 2, IEC 60584-1.
pub(super) const SENSOR_ERROR: f64 = 2.5;
/// Fraction of a channel's changes that are not usual. Tuned: a run has fewer jumps.
const RARE: f64 = 0.005;
/// Fewest equal readings of a drop-out. Derivation: two readings of a fine sensor may be equal by chance, three are not.
pub(super) const REPEATED: usize = 3;
/// Least change of an input, in SI units. Numerical: rounding.
const ROUNDING: f64 = 1e-9;
/// Standard deviation of a reading from the line between its neighbours, relative to that of a reading. Derivation: the variances of the
/// reading and of two halves, 1 + 1/4 + 1/4 = 1.5.
pub(super) const FROM_LINE: f64 = 1.224_745;
/// Range of temperature sensors, K. Limit: readings outside are codes of an open or shorted sensor.
pub(super) const POSSIBLE: (f64, f64) = (100.0, 1273.15);

/// Bound (1) for an experiment.
pub(super) fn bound(experiment: &Experiment) -> f64 {
    let channels = experiment.inputs.len() + experiment.outputs.len();
    let readings: usize = experiment.runs.iter().map(|r| r.table.time.len() * channels).sum();
    (2.0 * (readings as f64 / ALPHA).ln()).sqrt()
}

/// Sets aside the failures found, with notes; returns the number of spikes of every channel.
pub fn set_aside(experiment: &mut Experiment) -> Vec<usize> {
    let channels: Vec<&'static Channel> =
        experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let least = bound(experiment);
    let quantised: Vec<f64> =
        channels.iter().enumerate().map(|(k, c)| noise::quantised(experiment, k, c)).collect();
    let mut notes: Vec<String> = Vec::new();
    let mut counts = vec![0; channels.len()];
    for run in &mut experiment.runs {
        let table = &mut run.table;
        let file = run.file.clone();
        let mut write = |note: String| {
            if !notes.contains(&note) {
                notes.push(note);
            }
        };
        let about = |k: usize, what: String| format!("{file}: {} {what}", channels[k].column);
        for (k, channel) in channels.iter().enumerate().filter(|(_, c)| c.is_temperature()) {
            let column = &mut table.columns[k];
            let beyond = |x: &&mut f64| **x < POSSIBLE.0 || **x > POSSIBLE.1;
            let (first, mut count) = (column.iter().copied().find(|x| *x < POSSIBLE.0 || *x > POSSIBLE.1), 0);
            column.iter_mut().filter(beyond).for_each(|x| {
                *x = f64::NAN;
                count += 1;
            });
            if let Some(first) = first {
                let reading = first - channel.offset;
                write(about(
                    k,
                    format!(
                        "reads {reading:.1} degC in {}, as an open or shorted sensor does; {} set aside",
                        count_of(count, "row"),
                        these(count)
                    ),
                ));
            }
        }
        for (k, channel) in channels.iter().enumerate().filter(|(_, c)| c.is_temperature()) {
            let Some(code) = code(&table.columns[k]) else { continue };
            let column = &mut table.columns[k];
            let count = column.iter().filter(|x| **x == code).count();
            column.iter_mut().filter(|x| **x == code).for_each(|x| *x = f64::NAN);
            let reading = code - channel.offset;
            let rows = count_of(count, "row");
            write(about(k, format!("drops out to {reading:.2} degC in {rows}; {} set aside", these(count))));
        }
        let spikes: Vec<Vec<usize>> =
            channels.iter().enumerate().map(|(k, c)| spikes(table, k, c, (least, quantised[k]))).collect();
        // The ambient temperature cannot have pulses caused by the motor: in such a row the logger failed.
        let failed: Vec<usize> = (0..experiment.inputs.len())
            .filter(|k| channels[*k].is_temperature())
            .flat_map(|k| {
                let readings = Readings::of(&table.time, &table.columns[k]).with_least(quantised[k]);
                let ends = readings.ends(least, 1.0);
                spikes[k].iter().copied().chain(ends)
            })
            .collect();
        if !failed.is_empty() {
            for column in &mut table.columns {
                failed.iter().for_each(|row| column[*row] = f64::NAN);
            }
            let from = table.time[failed[0]];
            let (rows, are) = match failed.len() {
                1 => (format!("the row at {from} s"), "is"),
                count => (format!("{count} rows, the first at {from} s"), "are"),
            };
            write(format!(
                "{}: {rows}, in which the ambient temperature (ambient_temperature_degC) has a spike, {are} set aside in all channels",
                run.file
            ));
        }
        let inputs = &table.columns[..experiment.inputs.len()];
        let sizes: Vec<f64> = inputs.iter().map(|c| Readings::of(&table.time, c).size()).collect();
        for k in 0..channels.len() {
            let alone = |row: &&usize| {
                !failed.contains(row)
                    && (0..channels.len()).all(|other| other == k || !spikes[other].contains(row))
            };
            let mut own: Vec<usize> = spikes[k].iter().filter(alone).copied().collect();
            let inputs = experiment.inputs.len();
            // Where an input changes, an output may have a pulse; `super::pulses` compares it with the model.
            if k >= inputs {
                own.retain(|row| !(0..inputs).any(|j| changes(table, j, *row, least * sizes[j])));
            }
            if k < inputs {
                // A real pulse of an input changes other channels; a spike in its reading does not.
                own = own
                    .chunk_by(|a, b| b - a == 1)
                    .filter(|group| {
                        (0..channels.len()).all(|other| other == k || !follows(table, other, group))
                    })
                    .flatten()
                    .copied()
                    .collect();
            }
            let there = table.columns[k].iter().filter(|x| x.is_finite()).count();
            counts[k] += own.len();
            if own.is_empty() {
                continue;
            }
            if own.len() as f64 > SMALL * there as f64 && k >= experiment.inputs.len() {
                table.columns[k].fill(f64::NAN);
                let count = count_of(own.len(), "spike");
                write(about(k, format!("has {count} in {there} readings and is set aside")));
            } else {
                own.iter().for_each(|row| table.columns[k][*row] = f64::NAN);
                let from = table.time[own[0]];
                write(about(
                    k,
                    match own.len() {
                        1 => format!("has a spike at {from} s, which is set aside"),
                        count => format!("has {count} spikes, the first at {from} s; they are set aside"),
                    },
                ));
            }
        }
    }
    experiment.notes.extend(notes);
    counts
}

/// Rows as the subject of a sentence.
fn these(count: usize) -> &'static str {
    if count == 1 { "it is" } else { "these are" }
}

/// Code of an amplifier without sensor: the only value of the column that is repeated exactly, and far from all others.
fn code(column: &[f64]) -> Option<f64> {
    let all = super::sorted(column.iter().copied());
    let runs: Vec<&[f64]> = all.chunk_by(|a, b| a == b).collect();
    let of = |code: &[f64], rest: &[&[f64]], gap: f64| {
        let (least, most) = (rest.first()?[0], rest.last()?[0]);
        let readings: usize = rest.iter().map(|r| r.len()).sum();
        let is_fine = 2 * rest.len() > readings && readings >= NEAR;
        (code.len() >= REPEATED && is_fine && gap > SENSOR_ERROR.max(0.5 * (most - least))).then_some(code[0])
    };
    let (first, above) = runs.split_first()?;
    let (last, below) = runs.split_last()?;
    let low = of(first, above, above.first()?[0] - first[0]);
    low.or_else(|| of(last, below, last[0] - below.last().map_or(f64::INFINITY, |r| r[0])))
}

/// Whether a channel changes by more than `least` within a spike's width of a row.
fn changes(table: &Table, channel: usize, row: usize, least: f64) -> bool {
    let column = &table.columns[channel];
    let near = &column[row.saturating_sub(WIDEST)..(row + WIDEST + 1).min(column.len())];
    super::range(near.iter().copied()) > least.max(ROUNDING)
}

/// Whether a channel deviates from the line between the readings next to these rows.
fn follows(table: &Table, channel: usize, rows: &[usize]) -> bool {
    let column = &table.columns[channel];
    let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return false };
    let (Some(before), Some(after)) = (first.checked_sub(1), Some(last + 1).filter(|n| *n < column.len()))
    else {
        return false;
    };
    let slope = (column[after] - column[before]) / (table.time[after] - table.time[before]);
    let line = |row: usize| column[before] + slope * (table.time[row] - table.time[before]);
    let mean = rows.iter().map(|row| column[*row] - line(*row)).sum::<f64>() / rows.len() as f64;
    let there: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    let (time, values): (Vec<f64>, Vec<f64>) =
        there.iter().map(|row| (table.time[*row], column[*row])).unzip();
    let Some(sigma) = noise::of_column(&time, &values) else { return false };
    // Variance of the mean of these readings plus that of the line through two.
    let deviation = sigma * (1.0 / rows.len() as f64 + 0.5).sqrt();
    mean.is_finite() && deviation > 0.0 && mean.abs() > FOLLOWS * deviation
}

/// Rows of a table at which a channel has spikes.
fn spikes(table: &Table, k: usize, channel: &Channel, (least, quantised): (f64, f64)) -> Vec<usize> {
    // An ambient temperature has no pulses of its own, so that those next to each other are all spikes.
    let quantile = if channel.is_ambient() { NEAR_BY } else { 1.0 };
    let readings = Readings::of(&table.time, &table.columns[k]).with_least(quantised);
    readings.spikes(channel.is_temperature(), least, (quantile, ALIKE))
}

/// Readings of a column.
pub(super) struct Readings {
    rows: Vec<usize>,
    time: Vec<f64>,
    column: Vec<f64>,
    sigma: f64,
    /// Median change from row to row.
    usual: f64,
}

impl Readings {
    pub(super) fn of(time: &[f64], column: &[f64]) -> Readings {
        let rows: Vec<usize> = (0..time.len()).filter(|row| column[*row].is_finite()).collect();
        let column: Vec<f64> = rows.iter().map(|row| column[*row]).collect();
        let time: Vec<f64> = rows.iter().map(|row| time[*row]).collect();
        let sigma = noise::of_column(&time, &column).unwrap_or(0.0);
        let usual = super::median(column.windows(2).map(|w| (w[1] - w[0]).abs()));
        Readings { rows, time, column, sigma, usual }
    }

    /// The same with this least noise: that of the quantization, which changes of one step between long plateaus do not show.
    pub(super) fn with_least(self, least: f64) -> Readings {
        Readings { sigma: self.sigma.max(least), ..self }
    }

    /// The greater of the noise and of the usual change.
    pub(super) fn size(&self) -> f64 {
        self.sigma.max(self.usual)
    }

    /// Rows of spikes greater than `least` standard deviations and twice the neighbouring changes, of which the greatest `1 - quantile`
    /// are ignored; the readings on both sides differ by at most the fraction `alike` of the spike.
    pub(super) fn spikes(
        &self,
        is_temperature: bool,
        least: f64,
        (quantile, alike): (f64, f64),
    ) -> Vec<usize> {
        let (column, time, n) = (&self.column, &self.time, self.column.len());
        // A command has steps and no noise: its pulses are intended.
        if n < 4 * NEAR || (self.size() == 0.0 && !is_temperature) {
            return Vec::new();
        }
        let is_spike = |row: usize, width: usize| {
            let (a, b) = (column[row - 1], column[row + width]);
            let slope = (b - a) / (time[row + width] - time[row - 1]);
            let off = |j: usize| (column[j] - a - slope * (time[j] - time[row - 1])).abs();
            // All readings of the group deviate, and both sides are at the same level.
            let size = (row..row + width).map(off).fold(f64::INFINITY, f64::min);
            if size <= least * FROM_LINE * self.size() || (b - a).abs() > alike * size {
                return false;
            }
            let from = row.saturating_sub(NEAR);
            let near = column[from..row]
                .windows(2)
                .chain(column[row + width..(row + width + NEAR).min(n)].windows(2));
            let near = super::sorted(near.map(|w| (w[1] - w[0]).abs()));
            let local = near.get((quantile * near.len().saturating_sub(1) as f64) as usize);
            size > 2.0 * local.copied().unwrap_or(0.0)
        };
        let mut found = Vec::new();
        let mut row = 1;
        while row + 1 < n {
            match (1..=WIDEST.min(n - 1 - row)).find(|width| is_spike(row, *width)) {
                Some(width) => {
                    found.extend(&self.rows[row..row + width]);
                    row += width + 1;
                }
                None => row += 1,
            }
        }
        found
    }

    /// The first and the last row, if they deviate as far from the neighbouring readings.
    pub(super) fn ends(&self, least: f64, quantile: f64) -> Vec<usize> {
        let n = self.column.len();
        if n < 4 * NEAR {
            return Vec::new();
        }
        let of = |row: usize, beside: &[f64]| {
            let near = super::sorted(beside.windows(2).map(|w| (w[1] - w[0]).abs()));
            let local = near[(quantile * (near.len() - 1) as f64) as usize];
            let size = (self.column[row] - super::median(beside.iter().copied())).abs();
            (size > least * self.size() && size > 2.0 * local * (NEAR as f64).sqrt())
                .then_some(self.rows[row])
        };
        let ends = [of(0, &self.column[1..=NEAR]), of(n - 1, &self.column[n - 1 - NEAR..n - 1])];
        ends.into_iter().flatten().collect()
    }

    /// Deviation of a row from the median of the neighbouring readings, in standard deviations.
    pub(super) fn distance(&self, row: usize) -> f64 {
        let Ok(place) = self.rows.binary_search(&row) else { return 0.0 };
        let beside = place.saturating_sub(NEAR)..(place + NEAR + 1).min(self.column.len());
        (self.column[place] - super::median(self.column[beside].iter().copied())).abs() / self.size()
    }
}

/// Rows at which a temperature has a jump that is greater than the error of a thermometer.
pub fn jumps(column: &[f64]) -> Vec<usize> {
    jumps_above(column, JUMP, SENSOR_ERROR)
}

/// Rows at which the deviation of a temperature from its prediction may have a jump that matters: greater than that, or than the structure
/// error of a model of these readings. Whether it is one is seen in the rows around it.
pub fn small_jumps(deviation: &[f64], readings: &[f64]) -> Vec<usize> {
    let least = SENSOR_ERROR.min(STRUCTURE * super::range(readings.iter().copied()));
    jumps_above(deviation, SMALL_JUMP, least)
}

fn jumps_above(column: &[f64], factor: f64, least: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    if rows.len() < 4 * NEAR {
        return Vec::new();
    }
    let change = |j: usize| (column[rows[j]] - column[rows[j - 1]]).abs();
    let changes = super::sorted((1..rows.len()).map(change));
    let usual = changes[((1.0 - RARE) * (changes.len() - 1) as f64) as usize];
    let least = (factor * usual).max(least);
    (1..rows.len()).filter(|j| change(*j) > least).map(|j| rows[j]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    /// A winding that heats up and cools down, with noise of 0.1 K.
    fn warming(seed: u64) -> Vec<f64> {
        let mut rng = rng(seed);
        let mut at = 295.0;
        (0..2000)
            .map(|k| {
                at += 2.0 * (if k / 200 % 2 == 0 { 60.0 } else { 0.0 } - (at - 295.0)) / 40.0;
                at + 0.1 * normal(&mut rng)
            })
            .collect()
    }

    fn table(column: Vec<f64>) -> Table {
        let time = (0..column.len()).map(|k| 2.0 * k as f64).collect();
        Table { time, columns: vec![column], ..Table::default() }
    }

    fn winding() -> &'static Channel {
        Channel::of("winding_temperature_degC").unwrap()
    }

    #[test]
    fn spikes_of_any_width_are_found_and_a_clean_sensor_has_none() {
        for seed in 0..20 {
            assert_eq!(
                spikes(&table(warming(seed)), 0, winding(), (6.0, 0.0)),
                Vec::<usize>::new(),
                "{seed}"
            );
            assert_eq!(jumps(&warming(seed)), Vec::<usize>::new(), "{seed}");
            let (warming, model) = (warming(seed), warming(seed + 100));
            let off: Vec<f64> = warming.iter().zip(&model).map(|(y, p)| y - p).collect();
            assert_eq!(small_jumps(&off, &warming), Vec::<usize>::new(), "{seed}");
        }
        for width in 1..=WIDEST {
            for size in [-300.0, 5.0, 900.0] {
                let mut column = warming(3);
                column[700..700 + width].iter_mut().for_each(|x| *x += size);
                let found = spikes(&table(column), 0, winding(), (6.0, 0.0));
                assert_eq!(found, (700..700 + width).collect::<Vec<_>>(), "{width} {size}");
            }
        }
    }

    /// Spikes of the ambient temperature that are beside each other, of which each hides the next among its neighbours.
    #[test]
    fn spikes_beside_each_other_are_found_where_the_motor_makes_none() {
        let mut rng = rng(7);
        let mut column: Vec<f64> =
            (0..600).map(|k| 294.0 + 1e-3 * f64::from(k) + 0.02 * normal(&mut rng)).collect();
        let rows = [200, 203, 206, 410, 411, 415];
        rows.iter().for_each(|row| column[*row] = 353.0);
        let ambient = Channel::of("ambient_temperature_degC").unwrap();
        assert_eq!(spikes(&table(column), 0, ambient, (6.0, 0.0)), rows);
    }

    #[test]
    fn a_loose_contact_jumps() {
        for level in [228.0, 325.0, 398.0] {
            let mut column = warming(5);
            column[900..1100].fill(level);
            assert_eq!(jumps(&column), [900, 1100], "{level}");
            assert_eq!(small_jumps(&column, &column), [900, 1100], "{level}");
        }
    }
}
