//! Means over blocks of successive rows: a fast logger's file has more rows than the motor's response has detail, and each costs the time of
//! a simulation step.
//!
//! Blocks are shortened until the mean square of each load, and with it a loss, keeps nearly all of its value: a load that alternates within a
//! block heats the motor by its mean square, which means do not have. A block in which a load changes its sign has no readings of outputs:
//! friction and the drop of contacts bend there, so that their means are not those at the mean load.

use crate::experiment::{Experiment, Run};
use crate::levels::{CERTAIN, NEGLIGIBLE, SMALL, STRUCTURE};
use crate::noise;
use crate::numbers::{interval, range};
use std::collections::BTreeMap;
use std::ops::Range;

/// Rows of all runs together from which means take their place in a search. Definition: four runs of 1.5 h with a row every 2 s, for which
/// the search is made, are 10,800 rows; a tenth more has none.
const MOST_ROWS: f64 = 12_000.0;
/// Number of means. Definition: half of that, so that a block has two rows or more.
const MEANS: f64 = MOST_ROWS / 2.0;
/// Noise, in quantization steps, from which the error of a mean decreases with the number of its readings. Source: Widrow, Kollar,
/// Quantization Noise (2008), ch. 19: with Gaussian dither of half a step, the mean of the quantization error is below 0.5 % of a step.
const DITHER: f64 = 0.5;

/// How the rows of a run are divided.
pub struct Division {
    /// Greatest number of rows in a block.
    pub length: usize,
    /// Parts of the run that blocks do not cross.
    pub pieces: Vec<Range<usize>>,
    /// What the mean square of a load may lose, relative to its greatest in a run.
    pub loss: f64,
}

impl Experiment {
    /// The experiment with means in all runs, if it has more rows than a search is made for; a note says so.
    pub fn of_means(&self) -> Option<Experiment> {
        let rows: usize = self.runs.iter().map(|run| run.table.time.len()).sum();
        if rows as f64 <= MOST_ROWS {
            return None;
        }
        // Blocks of equal time: a run of a slower logger keeps its rows.
        let all = self.runs.iter().map(|run| run.table.span()).sum::<f64>();
        let span = |k: usize| range(self.runs.iter().flat_map(|run| run.table.columns[k].iter().copied()));
        let steps: Vec<(usize, f64)> = self.loads().map(|k| (k, SMALL * span(k))).collect();
        let noise = |k: usize| noise::of_runs(self, k, self.inputs[k]).unwrap_or(0.0);
        let reversing: Vec<(usize, f64)> = self.loads().map(|k| (k, CERTAIN * noise(k))).collect();
        let (mut means, lengths) = self.with_means(&reversing, |run| {
            let length = (all / MEANS / interval([&run.table.time[..]])).round().max(1.0) as usize;
            let loss = NEGLIGIBLE * STRUCTURE;
            pieces(run, &steps).map(|pieces| Division { length, pieces, loss })
        });
        let (least, most) = (*lengths.iter().min()?, *lengths.iter().max()?);
        if most == 1 {
            return None;
        }
        for (n, channel) in self.inputs.iter().chain(&self.outputs).enumerate() {
            if let Some(stated) = means.noise.get_mut(channel.column) {
                *stated /= (least as f64).sqrt();
            }
            let quantised = noise::quantised(self, n, channel);
            let is_dithered = || {
                noise::of_runs(self, n, channel)
                    .is_some_and(|sigma| sigma >= DITHER * 12f64.sqrt() * quantised)
            };
            if quantised > 0.0 && !is_dithered() {
                let stated = means.noise.entry(channel.column).or_default();
                *stated = stated.hypot(quantised);
            }
        }
        // Windows of a file are runs of their own.
        let files: BTreeMap<&str, usize> =
            self.runs.iter().map(|run| (run.file.as_str(), run.table.logged)).collect();
        let logged: usize = files.values().sum();
        let now: usize = means.runs.iter().map(|run| run.table.time.len()).sum();
        let of = if least == most { format!("{most}") } else { format!("{least} to {most}") };
        means.notes.push(format!(
            "the runs have {logged} rows: parameters and effects were found with {now} means over {of} rows each (about {:.2} s), or fewer \
             rows at steps of the load; all errors are those of the rows as measured",
            all / now as f64
        ));
        Some(means)
    }

    /// The experiment with means over blocks of rows, and the length of the blocks of each run after shortening; `None` keeps the rows of a
    /// run. Outputs have a blank in blocks of less than half the length, whose noise is not that of the others, and in those in which one of
    /// the `reversing` loads changes its sign, each with the least value that is not zero.
    pub fn with_means(
        &self,
        reversing: &[(usize, f64)],
        division: impl Fn(&Run) -> Option<Division>,
    ) -> (Experiment, Vec<usize>) {
        let greatest = |k: usize| self.runs.iter().map(|r| square(&r.table.columns[k])).fold(0.0, f64::max);
        let squares: Vec<(usize, f64)> = self.loads().map(|k| (k, greatest(k))).collect();
        let mut means = self.clone();
        let average = |run: &mut Run| {
            let Some(Division { mut length, pieces, loss }) = division(run) else { return 1 };
            let blocks = |length: usize| -> Vec<Range<usize>> {
                let of = |rows: &Range<usize>| {
                    let end = rows.end;
                    rows.clone().step_by(length).map(move |from| from..end.min(from + length))
                };
                pieces.iter().flat_map(of).collect()
            };
            let is_kept = |length: usize, k: usize, of_all: f64| {
                let column = &run.table.columns[k];
                square(column) - square_of_means(column, &blocks(length)) <= loss * of_all
            };
            while length > 1 && !squares.iter().all(|(k, of_all)| is_kept(length, *k, *of_all)) {
                length = length.div_ceil(2);
            }
            if length == 1 {
                return length;
            }
            let (blocks, table) = (blocks(length), &mut run.table);
            let turned: Vec<usize> = (0..blocks.len())
                .filter(|n| {
                    reversing.iter().any(|(k, least)| turns(&table.columns[*k][blocks[*n].clone()], *least))
                })
                .collect();
            table.columns = table.columns.iter().map(|column| of_blocks(column, &blocks)).collect();
            // The start of a run is preserved.
            let first = table.time.first().copied();
            table.time = of_blocks(&table.time, &blocks);
            table.time.iter_mut().zip(first).for_each(|(own, first)| *own = first);
            for column in &mut table.columns[self.inputs.len()..] {
                let short =
                    column.iter_mut().zip(&blocks).skip(1).filter(|(_, rows)| 2 * rows.len() < length);
                short.for_each(|(reading, _)| *reading = f64::NAN);
                // Where loads alternate, hardly a block is left.
                if (turned.len() as f64) < SMALL * blocks.len() as f64 {
                    turned.iter().for_each(|n| column[*n] = f64::NAN);
                }
            }
            length
        };
        let lengths = means.runs.iter_mut().map(average).collect();
        (means, lengths)
    }

    /// Indices of the inputs that are loads.
    fn loads(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.inputs.len()).filter(|k| !self.inputs[*k].is_temperature())
    }
}

/// The rows of a run between its gaps, the ends of its window, and the steps of these loads, each with its least step. The two rows of a step
/// are pieces of their own, so that it stays one: the mean square of a ramp is smaller. `None` if steps are no exception.
fn pieces(run: &Run, steps: &[(usize, f64)]) -> Option<Vec<Range<usize>>> {
    let table = &run.table;
    let moves = |row: usize| {
        steps.iter().any(|(k, least)| (table.columns[*k][row + 1] - table.columns[*k][row]).abs() > *least)
    };
    let stepped: Vec<usize> = (0..table.time.len().saturating_sub(1)).filter(|row| moves(*row)).collect();
    if stepped.len() as f64 > SMALL * table.time.len() as f64 {
        return None;
    }
    let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let [from, to] = [table.time.partition_point(|t| *t < from), table.time.partition_point(|t| *t <= to)];
    let mut ends: Vec<usize> = table.gaps().map(|row| row + 1).chain([from, to, table.time.len()]).collect();
    ends.extend(stepped.iter().flat_map(|row| [*row, row + 1, row + 2]));
    ends.sort_unstable();
    let mut first = 0;
    let piece = |end: usize| std::mem::replace(&mut first, end)..end;
    Some(ends.into_iter().map(piece).filter(|rows| !rows.is_empty()).collect())
}

/// Whether values are on both sides of zero, each by more than `least`.
fn turns(values: &[f64], least: f64) -> bool {
    let known = values.iter().filter(|x| x.is_finite());
    let (low, high) = known.fold((0.0f64, 0.0f64), |(a, b), x| (a.min(*x), b.max(*x)));
    high.min(-low) > least
}

/// Means of a column over blocks.
fn of_blocks(column: &[f64], blocks: &[Range<usize>]) -> Vec<f64> {
    blocks.iter().map(|rows| mean(column[rows.clone()].iter().copied())).collect()
}

/// Mean square of the means of a column over blocks, each with the weight of its rows.
fn square_of_means(column: &[f64], blocks: &[Range<usize>]) -> f64 {
    let known = of_blocks(column, blocks).into_iter().zip(blocks).filter(|(mean, _)| mean.is_finite());
    let of = |(mean, rows): (f64, &Range<usize>)| (rows.len() as f64 * mean * mean, rows.len() as f64);
    let (sum, rows) = known.map(of).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    sum / rows
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
