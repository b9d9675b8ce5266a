//! Smoothing of inputs: means of neighbouring readings, and the zero of an instrument.
//!
//! Runs of one rig have their instruments' zeros at slightly different places. A law with a steep slope at zero (sign of a current, of a
//! speed) amplifies such an offset at rest, where nothing acts: v = V_b tanh(i / I_small) of 5 mA at I_small = 50 mA is a tenth of V_b.
//! Readings at rest state the offset: there, the input is zero.

use crate::levels::{CALIBRATED, CERTAIN, NEGLIGIBLE, SURE};

/// Rows on either side over which an input is smoothed. Numerical: the mean of 13 readings has a quarter of their noise.
const REACH: usize = 6;
/// Rows on either side for the second average. Numerical: the mean of 97 readings has a tenth of their noise.
const FAR: usize = 48;
/// Readings of one mean. Definition: a reading and those on either side.
const WINDOW: usize = 2 * REACH + 1;

/// An input without its noise: each reading is replaced by the mean of neighbouring readings that agree with it to within noise of the
/// deviation `sigma`, so that steps are preserved. Where these means are constant they are averaged again over a longer window; otherwise
/// noise would dominate at standstill. At rest the input is zero, and what its instrument reads there is subtracted from all rows.
pub fn input(column: &[f64], sigma: f64) -> Vec<f64> {
    let once = smoothed(column, sigma);
    let mut own = means_of_alike(&once, FAR, CERTAIN * of_mean(sigma));
    if let Some((zero, at_rest)) = rest(column, &once, sigma) {
        own.iter_mut().zip(at_rest).for_each(|(own, rests)| *own = if rests { 0.0 } else { *own - zero });
    }
    own
}

/// Means of neighbouring values that agree to within noise of this deviation.
pub fn smoothed(column: &[f64], sigma: f64) -> Vec<f64> {
    means_of_alike(column, REACH, CERTAIN * sigma)
}

fn of_mean(sigma: f64) -> f64 {
    sigma / (WINDOW as f64).sqrt()
}

/// What an instrument reads at rest, and the rows at rest: stretches in which the means `once` are constant at a value that is zero to within
/// the usual error of an instrument's zero. `None` if there are too few for a mean whose noise is negligible.
fn rest(column: &[f64], once: &[f64], sigma: f64) -> Option<(f64, Vec<bool>)> {
    let (usual, scatter) = (SURE * CALIBRATED * sigma, CERTAIN * of_mean(sigma));
    let near = in_stretches(once, |mean| mean.abs() <= usual + scatter);
    let own = || column.iter().zip(&near).filter(|(_, near)| **near).map(|(x, _)| x);
    let count = own().count() as f64;
    let zero = own().sum::<f64>() / count;
    let is_known = sigma > 0.0 && count >= NEGLIGIBLE.powi(-2) && zero.abs() <= usual;
    is_known.then(|| (zero, in_stretches(once, |mean| (mean - zero).abs() <= scatter)))
}

/// The values of which at least [`WINDOW`] in succession fulfil a condition.
fn in_stretches(values: &[f64], is_met: impl Fn(f64) -> bool) -> Vec<bool> {
    let groups = values.chunk_by(|a, b| is_met(*a) == is_met(*b));
    let of = |group: &[f64]| vec![group.len() >= WINDOW && is_met(group[0]); group.len()];
    groups.flat_map(of).collect()
}

/// Means over each value and its neighbours up to `reach` rows away, as long as these and all values between differ by less than `size`.
/// The window is symmetric, so that a ramp is not shifted.
fn means_of_alike(column: &[f64], reach: usize, size: f64) -> Vec<f64> {
    let mean = |row: usize| {
        let alike = |k: usize| (column[k] - column[row]).abs() <= size;
        let before = (1..=reach.min(row)).take_while(|k| alike(row - k)).count();
        let after = (1..=reach.min(column.len() - 1 - row)).take_while(|k| alike(row + k)).count();
        let both = before.min(after);
        let (from, to) = if both > 0 { (both, both) } else { (before, after) };
        let near = &column[row - from..=row + to];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..column.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    const SIGMA: f64 = 0.01;

    /// The smoothed readings of a signal with noise and a zero, and the signal.
    fn read(zero: f64, signal: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = rng(5);
        let truth: Vec<f64> = (0..1000).map(signal).collect();
        let read: Vec<f64> = truth.iter().map(|x| x + zero + SIGMA * normal(&mut rng)).collect();
        (input(&read, SIGMA), truth)
    }

    fn error(own: &[f64], truth: &[f64]) -> f64 {
        own.iter().zip(truth).map(|(a, b)| a - b).sum::<f64>() / own.len() as f64
    }

    #[test]
    fn readings_at_rest_give_the_zero_of_the_instrument() {
        for zero in [-0.7, 0.0, 0.4] {
            let (own, truth) = read(zero * SIGMA, |row| if row % 400 < 150 { 0.0 } else { 2.0 });
            let rests = own.iter().zip(&truth).filter(|(own, truth)| **truth == 0.0 && **own == 0.0).count();
            assert!(rests > 430, "{zero}: {rests} of 450 rows are zero");
            let loaded = error(&own[200..390], &truth[200..390]) / SIGMA;
            assert!(loaded.abs() < 0.2, "{zero}: {loaded} of the noise is left under load");
        }
    }

    /// A small constant load, a load that passes zero, few rows at rest, and an input without noise.
    #[test]
    fn other_inputs_keep_what_they_read() {
        let (own, truth) = read(0.0, |_| 2.0 * SIGMA);
        assert!(error(&own, &truth).abs() < 0.1 * SIGMA && own.iter().all(|x| *x != 0.0));
        let (own, _) = read(0.0, |row| 40.0 * SIGMA * (row as f64 / 30.0).sin());
        assert!(own.iter().all(|x| *x != 0.0));
        let offset = 0.5 * SIGMA;
        let (own, truth) = read(offset, |row| if row < 60 { 0.0 } else { 2.0 });
        assert!((error(&own[100..], &truth[100..]) - offset).abs() < 0.1 * SIGMA);
        assert_eq!(input(&[0.25; 300], 0.0), [0.25; 300]);
    }
}
