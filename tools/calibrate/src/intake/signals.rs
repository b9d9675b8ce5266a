//! Sensors that show by their own readings that they do not work: spikes, jumps that no temperature makes, the end of a range.
//!
//! Spike: a group of up to [`WIDEST`] readings whose distance from the line between the readings beside it is z deviations,
//!
//! z > sqrt(2 ln(n / alpha)),                                                                       (1)
//!
//! n the readings of the experiment and alpha the probability of one false alarm in all of it (bound on the greatest of n normal
//! variables). The deviation is the greater of the channel's noise and that of the readings near by. A pulse that another channel
//! makes in the same row is no spike, nor is a pulse of an input that another channel follows with a probability of chance below 1e-3.
//! *Sources*: Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393; Davies and Gather, J. Am. Stat. Assoc. 88 (1993) 782-792.
//!
//! Jump: a temperature has a heat capacity. A change from row to row that is far beyond the channel's usual ones is the sensor's
//! contact; on one side of it the readings are no temperature ([`super::response`] decides on which).

use crate::experiment::{Channel, Experiment, Table};
use crate::noise;

/// Probability of a false alarm in an experiment.
const ALPHA: f64 = 1e-3;
/// Deviations at which a channel follows the pulse of an input: two-sided probability of chance 1e-3.
const FOLLOWS: f64 = 3.29;
/// Most readings of a spike.
const WIDEST: usize = 5;
/// Readings near by.
const NEAR: usize = 10;
/// Fraction of a channel's readings that are spikes from which on none is trusted.
const MOSTLY: f64 = 0.1;
/// A jump is this many times the greatest change among all but [`RARE`] of the channel's changes, and at least so many kelvin.
const JUMP: (f64, f64) = (6.0, 3.0);
const RARE: f64 = 0.005;
/// A sensor of temperature never reads beyond, K: outside are the codes of an open or shorted one.
const POSSIBLE: (f64, f64) = (100.0, 1273.15);

/// Sets aside what shows by itself, with notes.
pub fn set_aside(experiment: &mut Experiment) {
    let channels: Vec<&'static Channel> =
        experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let readings: usize = experiment.runs.iter().map(|r| r.table.time.len() * channels.len()).sum();
    let least = (2.0 * (readings as f64 / ALPHA).ln()).sqrt();
    let mut notes: Vec<String> = Vec::new();
    for run in &mut experiment.runs {
        let table = &mut run.table;
        let mut say = |k: usize, what: String| {
            let note = format!("{}: {} {what}", run.file, channels[k].column);
            if !notes.contains(&note) {
                notes.push(note);
            }
        };
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
                say(
                    k,
                    format!(
                        "reads {reading:.1} degC in {count} rows, as an open or shorted sensor does; these are set aside"
                    ),
                );
            }
        }
        let spikes: Vec<Vec<usize>> =
            channels.iter().enumerate().map(|(k, c)| spikes(table, k, c, least)).collect();
        for k in 0..channels.len() {
            let alone =
                |row: &&usize| (0..channels.len()).all(|other| other == k || !spikes[other].contains(row));
            let mut own: Vec<usize> = spikes[k].iter().filter(alone).copied().collect();
            if k < experiment.inputs.len() {
                // What is commanded moves others; a spike of the reading does not.
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
            if own.is_empty() {
                continue;
            }
            if own.len() as f64 > MOSTLY * there as f64 && k >= experiment.inputs.len() {
                table.columns[k].fill(f64::NAN);
                say(k, format!("has {} spikes in {there} readings and is set aside", own.len()));
            } else {
                own.iter().for_each(|row| table.columns[k][*row] = f64::NAN);
                let from = table.time[own[0]];
                say(k, format!("has {} spikes, the first at {from} s; they are set aside", own.len()));
            }
        }
    }
    experiment.notes.extend(notes);
}

/// Whether a channel leaves the line between the readings beside these rows.
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
    // A mean of so many readings, and the line through two.
    let deviation = sigma * (1.0 / rows.len() as f64 + 0.5).sqrt();
    mean.is_finite() && deviation > 0.0 && mean.abs() > FOLLOWS * deviation
}

/// Rows of spikes.
fn spikes(table: &Table, k: usize, channel: &Channel, least: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..table.time.len()).filter(|row| table.columns[k][*row].is_finite()).collect();
    if rows.len() < 4 * NEAR {
        return Vec::new();
    }
    let column: Vec<f64> = rows.iter().map(|row| table.columns[k][*row]).collect();
    let time: Vec<f64> = rows.iter().map(|row| table.time[*row]).collect();
    let changes = super::sorted(column.windows(2).map(|w| (w[1] - w[0]).abs()));
    let sigma = noise::of_column(&time, &column).unwrap_or(0.0);
    // A command moves in steps and has no noise: its pulses are meant.
    let usual = changes[changes.len() / 2];
    if sigma.max(usual) == 0.0 && !channel.is_temperature() {
        return Vec::new();
    }
    let n = column.len();
    let mut found = Vec::new();
    let mut row = 1;
    while row + 1 < n {
        let width = (1..=WIDEST.min(n - 1 - row)).find(|width| {
            let (a, b) = (column[row - 1], column[row + width]);
            let group = &column[row..row + width];
            let line = |j: usize| {
                a + (b - a) * (time[row + j] - time[row - 1]) / (time[row + width] - time[row - 1])
            };
            let off = group.iter().enumerate().map(|(j, x)| x - line(j));
            let (low, high) = off.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            // All of the group on one side, far out, and both sides alike.
            let size = if low > 0.0 {
                low
            } else if high < 0.0 {
                -high
            } else {
                0.0
            };
            if size <= least * sigma || (b - a).abs() > 0.3 * size {
                return false;
            }
            let from = row.saturating_sub(NEAR);
            let near = column[from..row]
                .windows(2)
                .chain(column[row + width..(row + width + NEAR).min(n)].windows(2));
            let near = super::sorted(near.map(|w| (w[1] - w[0]).abs()));
            let local = near.last().copied().unwrap_or(0.0);
            size > least * sigma.max(usual) && size > 2.0 * local
        });
        match width {
            Some(width) => {
                found.extend(rows[row..row + width].iter());
                row += width + 1;
            }
            None => row += 1,
        }
    }
    found
}

/// Rows at which a temperature jumps.
pub fn jumps(column: &[f64]) -> Vec<usize> {
    let rows: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    if rows.len() < 4 * NEAR {
        return Vec::new();
    }
    let change = |j: usize| (column[rows[j]] - column[rows[j - 1]]).abs();
    let changes = super::sorted((1..rows.len()).map(change));
    let usual = changes[((1.0 - RARE) * (changes.len() - 1) as f64) as usize];
    let least = (JUMP.0 * usual).max(JUMP.1);
    (1..rows.len()).filter(|j| change(*j) > least).map(|j| rows[j]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::{normal, rng};

    /// A winding that warms and cools with noise of 0.1 K.
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
        Table { time, columns: vec![column], dated: false, notes: Vec::new() }
    }

    fn winding() -> &'static Channel {
        Channel::of("winding_temperature_degC").unwrap()
    }

    #[test]
    fn spikes_of_any_width_are_found_and_a_clean_sensor_has_none() {
        for seed in 0..20 {
            assert_eq!(spikes(&table(warming(seed)), 0, winding(), 6.0), Vec::<usize>::new(), "{seed}");
            assert_eq!(jumps(&warming(seed)), Vec::<usize>::new(), "{seed}");
        }
        for width in 1..=WIDEST {
            for size in [-300.0, 5.0, 900.0] {
                let mut column = warming(3);
                column[700..700 + width].iter_mut().for_each(|x| *x += size);
                let found = spikes(&table(column), 0, winding(), 6.0);
                assert_eq!(found, (700..700 + width).collect::<Vec<_>>(), "{width} {size}");
            }
        }
    }

    #[test]
    fn a_loose_contact_jumps() {
        for level in [228.0, 325.0, 398.0] {
            let mut column = warming(5);
            column[900..1100].fill(level);
            assert_eq!(jumps(&column), [900, 1100], "{level}");
        }
    }
}
