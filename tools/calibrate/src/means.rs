//! Means over blocks of successive rows: a fast logger's file has more rows than the motor's response has detail, and each costs the time of
//! a simulation step.
//!
//! A block ends at a gap and at the ends of the evaluated window. Blocks are shortened until the mean square of each load, and with it a
//! loss, keeps all but [`STRUCTURE`] of its value: a load that alternates within a block heats the motor by its mean square, which means do
//! not have.

use crate::experiment::{Experiment, Run};
use crate::levels::STRUCTURE;
use crate::noise;
use std::ops::Range;

/// Rows of all runs together from which means take their place in a search. Definition: four runs of 1.5 h with a row every 2 s, for which
/// the search is made, are 10,800 rows; a tenth more has none.
const MOST_ROWS: f64 = 12_000.0;
/// Noise, in quantization steps, from which the error of a mean decreases with the number of its readings. Source: Widrow, Kollar,
/// Quantization Noise (2008), ch. 19: with Gaussian dither of half a step, the mean of the quantization error is below 0.5 % of a step.
const DITHER: f64 = 0.5;

impl Experiment {
    /// The experiment with means in all runs, if it has more rows than a search is made for; a note says so.
    pub fn of_means(&self) -> Option<Experiment> {
        let rows: usize = self.runs.iter().map(|run| run.table.time.len()).sum();
        if rows as f64 <= MOST_ROWS {
            return None;
        }
        let span: f64 = self.runs.iter().map(|run| run.table.span()).sum();
        // The usual interval of a run, without its gaps, in blocks of equal time: a run of a slower logger keeps its rows.
        let length = |run: &Run| (span / MOST_ROWS / usual_interval(run)).round().max(1.0) as usize;
        let (means, lengths) = self.with_means(length);
        let (least, most) = (*lengths.iter().min()?, *lengths.iter().max()?);
        if most == 1 {
            return None;
        }
        let mut means = means;
        for (n, channel) in self.inputs.iter().chain(&self.outputs).enumerate() {
            if let Some(stated) = means.noise.get_mut(channel.column) {
                *stated /= (least as f64).sqrt();
            }
            let quantised = noise::quantised(self, n, channel);
            let columns = self.runs.iter().map(|r| (r.table.time.as_slice(), r.table.columns[n].as_slice()));
            let is_dithered = noise::of_columns(columns, channel.is_temperature())
                .is_some_and(|sigma| sigma >= DITHER * 12f64.sqrt() * quantised);
            if quantised > 0.0 && !is_dithered {
                let stated = means.noise.entry(channel.column).or_default();
                *stated = stated.hypot(quantised);
            }
        }
        let now: usize = means.runs.iter().map(|run| run.table.time.len()).sum();
        let of = if least == most { format!("{most}") } else { format!("{least} to {most}") };
        means.notes.push(format!(
            "the runs have {rows} rows: parameters and effects were found with {now} means over {of} rows each (about {:.2} s); all errors \
             are those of the rows as measured",
            span / now as f64
        ));
        Some(means)
    }

    /// The experiment with means over at most `length` rows in each run, and the lengths after shortening.
    pub fn with_means(&self, length: impl Fn(&Run) -> usize) -> (Experiment, Vec<usize>) {
        let greatest = |k: usize| self.runs.iter().map(|r| square(&r.table.columns[k])).fold(0.0, f64::max);
        let loads = self.inputs.iter().enumerate().filter(|(_, channel)| !channel.is_temperature());
        let squares: Vec<(usize, f64)> = loads.map(|(k, _)| (k, greatest(k))).collect();
        let mut means = self.clone();
        let shorten = |run: &mut Run| {
            let pieces = pieces(run);
            let is_kept = |length: usize, k: usize, of_all: f64| {
                let column = &run.table.columns[k];
                square(column) - square(&of_blocks(column, &pieces, length)) <= STRUCTURE * of_all
            };
            let mut length = length(run);
            while length > 1 && !squares.iter().all(|(k, of_all)| is_kept(length, *k, *of_all)) {
                length = length.div_ceil(2);
            }
            let table = &mut run.table;
            table.columns = table.columns.iter().map(|c| of_blocks(c, &pieces, length)).collect();
            // The start time of a run is preserved.
            let first = table.time.first().copied();
            table.time = of_blocks(&table.time, &pieces, length);
            table.time.iter_mut().zip(first).for_each(|(own, first)| *own = first);
            length
        };
        let lengths = means.runs.iter_mut().map(shorten).collect();
        (means, lengths)
    }
}

/// Median interval between the rows of a run, s.
fn usual_interval(run: &Run) -> f64 {
    let mut all: Vec<f64> = run.table.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Rows of a run between its gaps and the ends of its window.
fn pieces(run: &Run) -> Vec<Range<usize>> {
    let time = &run.table.time;
    let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let mut ends: Vec<usize> = run.table.gaps().map(|row| row + 1).collect();
    ends.extend([time.partition_point(|t| *t < from), time.partition_point(|t| *t <= to), time.len()]);
    ends.sort_unstable();
    let mut first = 0;
    let piece = |end: usize| std::mem::replace(&mut first, end)..end;
    ends.into_iter().map(piece).filter(|rows| !rows.is_empty()).collect()
}

/// Means of a column over blocks of the pieces.
fn of_blocks(column: &[f64], pieces: &[Range<usize>], length: usize) -> Vec<f64> {
    let blocks = pieces.iter().flat_map(|rows| column[rows.clone()].chunks(length));
    blocks.map(|block| mean(block.iter().copied())).collect()
}

fn square(column: &[f64]) -> f64 {
    mean(column.iter().map(|x| x * x))
}

/// Mean of the values that are numbers.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) =
        values.filter(|x| x.is_finite()).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    sum / count
}

#[cfg(test)]
mod tests;
