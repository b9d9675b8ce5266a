//! Noise of the block means of each output: an autoregressive process of first order.
//!
//! e_k = rho e_(k-1) + s sqrt(1 - rho^2) w_k,   w_k ~ N(0, 1),   s >= 1,   0 <= rho < 1                  (1)
//! w_1 = e_1 / s,   w_k = (e_k - rho e_(k-1)) / (s sqrt(1 - rho^2))                                      (2)
//! s^2 = sum l_k^2 / (n (1 - gamma / N)),   rho = sum l_k l_(k-1) / sum l_k^2                            (3)
//!
//! The unit is the noise of a block mean if the noise of the readings is white: s = 1 and rho = 0. Thermometers in flowing air, filters of
//! an amplifier and a motor that varies by itself have noise with a memory of several rows: block means then vary more, and neighbours
//! vary alike. l is the residual of all N block means after the estimate of the null model's coefficients, of which the data determine
//! gamma; n belong to this output.
//! *Sources*: (2) Prais, Winsten, Cowles Commission Discussion Paper 383 (1954); (3) MacKay, Neural Computation 4 (1992) 415-447, sec. 4.

use crate::levels::NEGLIGIBLE;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Greatest correlation of neighbours. Limit: a process with a longer memory than ten block means is a drift.
const LONGEST: f64 = 0.9;

/// Block means of one output in one run, in order of time.
#[derive(Clone, Debug)]
pub struct Series {
    /// The output.
    pub output: usize,
    /// Their place among all values.
    pub values: Range<usize>,
}

/// Standard deviation s and correlation rho of each output.
#[derive(Clone, Debug)]
pub struct Memory(Vec<(f64, f64)>);

impl Memory {
    /// Eq. (3) for a residual; `used` is the fraction gamma / N.
    pub fn of(series: &[Series], left: &DVector<f64>, used: f64) -> Memory {
        let outputs = series.iter().map(|s| s.output + 1).max().unwrap_or(0);
        let one = |output: usize| {
            let (mut square, mut product, mut count) = (0.0, 0.0, 0usize);
            for own in series.iter().filter(|s| s.output == output) {
                let left = &left.as_slice()[own.values.clone()];
                square += left.iter().map(|x| x * x).sum::<f64>();
                product += left.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
                count += left.len();
            }
            if square == 0.0 {
                return (1.0, 0.0);
            }
            let variance = square / (count as f64 * (1.0 - used));
            (variance.sqrt().max(1.0), (product / square).clamp(0.0, LONGEST))
        };
        Memory((0..outputs).map(one).collect())
    }

    /// Whether this is white noise of the stated size.
    pub fn is_negligible(&self) -> bool {
        self.0.iter().all(|(s, rho)| s - 1.0 < NEGLIGIBLE && *rho < NEGLIGIBLE)
    }

    /// Eq. (2) for each column.
    pub fn whitened(&self, series: &[Series], columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut all = columns.clone();
        for mut column in all.column_iter_mut() {
            for own in series {
                let (s, rho) = self.0[own.output];
                let scale = 1.0 / (s * (1.0 - rho * rho).sqrt());
                // From the end, so that each value still finds the one before it.
                for k in own.values.clone().skip(1).rev() {
                    column[k] = (column[k] - rho * column[k - 1]) * scale;
                }
                if let Some(first) = own.values.clone().next() {
                    column[first] /= s;
                }
            }
        }
        all
    }

    /// Log determinant of the covariance of all values.
    pub fn log_determinant(&self, series: &[Series]) -> f64 {
        let one = |own: &Series| {
            let ((s, rho), count) = (self.0[own.output], own.values.len() as f64);
            2.0 * count * s.ln() + (count - 1.0).max(0.0) * (1.0 - rho * rho).ln()
        };
        series.iter().map(one).sum()
    }

    /// Variance of the mean over many values of an output, relative to white noise of the stated size; 1 for an output without a reading.
    pub fn inflation(&self, output: usize) -> f64 {
        self.0.get(output).map_or(1.0, |(s, rho)| s * s * (1.0 + rho) / (1.0 - rho))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    fn series(counts: &[(usize, usize)]) -> Vec<Series> {
        let mut from = 0;
        let one = |(output, count): &(usize, usize)| {
            let values = from..from + count;
            from += count;
            Series { output: *output, values }
        };
        counts.iter().map(one).collect()
    }

    /// A process of each output is recovered with its size and correlation, and its whitened values are white.
    #[test]
    fn a_process_is_estimated_and_whitened() {
        let series = series(&[(0, 2000), (1, 2000), (0, 2000), (1, 2000)]);
        let true_noise = [(2.0, 0.6), (1.0, 0.0)];
        let mut rng = rng(8);
        let mut values = Vec::new();
        for own in &series {
            let (s, rho) = true_noise[own.output];
            let mut x = s * normal(&mut rng);
            for _ in own.values.clone() {
                values.push(x);
                x = rho * x + s * f64::sqrt(1.0 - rho * rho) * normal(&mut rng);
            }
        }
        let values = DVector::from_vec(values);
        let found = Memory::of(&series, &values, 0.0);
        for ((s, rho), (true_s, true_rho)) in found.0.iter().zip(true_noise) {
            assert!((s / true_s - 1.0).abs() < 0.06 && (rho - true_rho).abs() < 0.05, "{found:?}");
        }
        assert!(!found.is_negligible() && (found.inflation(0) / 16.0 - 1.0).abs() < 0.2);
        let white = found.whitened(&series, &DMatrix::from_columns(&[values]));
        let again = Memory::of(&series, &white.column(0).into_owned(), 0.0);
        // An output whose sensor was set aside in all runs has no series.
        assert_eq!(found.inflation(2), 1.0);
        assert!(again.is_negligible() && (white.norm_squared() / 8000.0 - 1.0).abs() < 0.05, "{again:?}");
    }

    /// Eq. (2) and the determinant against the covariance matrix s^2 rho^|j - k| of two runs.
    #[test]
    fn whitening_is_that_of_the_covariance() {
        let series = series(&[(0, 3), (0, 2)]);
        let memory = Memory(vec![(1.5, 0.4)]);
        let of_run = |k: usize| usize::from(k > 2);
        let covariance = DMatrix::from_fn(5, 5, |j, k| {
            let same = if of_run(j) == of_run(k) { 1.0 } else { 0.0 };
            same * 2.25 * 0.4f64.powi(j.abs_diff(k) as i32)
        });
        let x = DMatrix::from_vec(5, 1, vec![1.0, -2.0, 0.5, 3.0, 1.0]);
        let expected = (x.transpose() * covariance.clone().try_inverse().unwrap() * &x)[(0, 0)];
        assert!((memory.whitened(&series, &x).norm_squared() / expected - 1.0).abs() < 1e-12);
        assert!((memory.log_determinant(&series) - covariance.determinant().ln()).abs() < 1e-12);
    }
}
