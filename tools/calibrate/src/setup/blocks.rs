//! Neighbouring readings averaged as blocks.

use super::{Setup, Shown, within};
use crate::experiment::{Experiment, Run};

/// Blocks of a run, for each output: residuals are averaged over this number of sections of a run. Numerical: a run comprises some tens
/// of time constants; twice as many change the penalty ln n by 0.7.
pub const BLOCKS: usize = 400;

/// Neighbouring rows of one output, averaged as a block.
#[derive(Clone, Debug)]
pub struct Block {
    /// The output.
    pub output: usize,
    /// The rows with readings inside the window.
    pub rows: Vec<u32>,
    /// Time at its centre, s.
    pub time: f64,
}

impl Setup<'_> {
    /// Means of values at rows (rows times outputs) over the blocks of a run, in units of their noise.
    pub fn means(&self, run: usize, values: &[f64], out: &mut Vec<f64>) {
        let m = self.outputs();
        out.extend(self.blocks[run].iter().map(|block| {
            let (mut sum, mut precision) = (0.0, 0.0);
            for row in block.rows.iter().map(|row| *row as usize) {
                let weight = self.weight(run, row, block.output).powi(2);
                (sum, precision) = (sum + weight * values[row * m + block.output], precision + weight);
            }
            sum / (self.sigma(block.output) * precision.sqrt())
        }));
    }

    /// Block means of the residual, in units of their noise.
    pub fn residual(&self, run: usize, shown: &Shown, out: &mut Vec<f64>) {
        let mut off = vec![0.0; shown.len()];
        let m = self.outputs();
        self.each(run, shown, |row, output, value| off[row * m + output] = value);
        self.means(run, &off, out);
    }
}

/// The blocks of a run with the readings inside a window.
pub(super) fn blocks(experiment: &Experiment, run: &Run, window: (f64, f64)) -> Vec<Block> {
    let inputs = experiment.inputs.len();
    let time = &run.table.time;
    let mut all = Vec::new();
    for output in 0..experiment.outputs.len() {
        let column = &run.table.columns[inputs + output];
        let there: Vec<u32> = (0..time.len())
            .filter(|k| within(window, time[*k]) && column[*k].is_finite())
            .map(|k| k as u32)
            .collect();
        let length = there.len().div_ceil(BLOCKS).max(1);
        all.extend(there.chunks(length).map(|rows| {
            let middle = 0.5 * (time[rows[0] as usize] + time[rows[rows.len() - 1] as usize]);
            Block { output, rows: rows.to_vec(), time: middle }
        }));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::sync::Arc;

    /// 1000 rows make 334 blocks of three rows, the last of one row; rows outside the window and blanks belong to no block.
    #[test]
    fn blocks_hold_what_was_measured_and_counts() {
        let mut experiment = testing::experiment("", true);
        let run = &mut experiment.runs[0];
        run.table.time = (0..1000).map(f64::from).collect();
        for column in &mut run.table.columns {
            *column = vec![300.0; 1000];
        }
        // 20 blanks in the voltage; no torque readings.
        run.table.columns[4][100..120].fill(f64::NAN);
        run.table.columns[5].fill(f64::NAN);
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        let blocks_of = |window, output| -> Vec<Block> {
            blocks(&experiment, &experiment.runs[0], window)
                .into_iter()
                .filter(|b| b.output == output)
                .collect()
        };
        let rows = |blocks: &[Block]| blocks.iter().map(|b| b.rows.len()).sum::<usize>();
        let whole = blocks_of(all, 2);
        assert_eq!((whole.len(), rows(&whole), whole[333].rows.len()), (334, 1000, 1));
        assert_eq!((whole[1].rows.as_slice(), whole[1].time), (&[3, 4, 5][..], 4.0));
        let gap = blocks_of(all, 0);
        assert_eq!((gap.len(), rows(&gap)), (980usize.div_ceil(3), 980));
        assert!(gap.iter().flat_map(|b| &b.rows).all(|r| !(100..120).contains(r)));
        assert!(blocks_of(all, 1).is_empty());
        let part = blocks_of((100.0, 299.0), 3);
        assert_eq!((part.len(), part[0].rows[0], part[199].rows[0]), (200, 100, 299));
    }

    /// For white noise, block means in units of their noise have variance 1 for any block length.
    #[test]
    fn means_of_white_noise_have_variance_one() {
        let experiment = testing::experiment("", true);
        let mut setup = Setup::new(&experiment, &[]).unwrap();
        let rows = 300;
        for length in [1, 4] {
            let of = |output: usize| {
                let all: Vec<u32> = (0..rows).collect();
                let chunks: Vec<Vec<u32>> = all.chunks(length).map(<[u32]>::to_vec).collect();
                chunks.into_iter().map(move |rows| Block { output, rows, time: 0.0 })
            };
            setup.blocks[0] = Arc::new((0..4).flat_map(of).collect());
            let mut rng = testing::rng(5);
            let (mut sum, mut count) = (0.0, 0);
            for _ in 0..20 {
                let values: Vec<f64> =
                    (0..rows as usize * 4).map(|k| setup.sigma(k % 4) * testing::normal(&mut rng)).collect();
                let mut means = Vec::new();
                setup.means(0, &values, &mut means);
                sum += means.iter().map(|x| x * x).sum::<f64>();
                count += means.len();
            }
            let variance = sum / count as f64;
            assert!((variance - 1.0).abs() < 0.05, "{length}: {variance}");
        }
    }
}
