//! Fits from several starts: a cost with more than one minimum.

use super::{FAR, Fitted, OPTIONS, is_wide};
use crate::CalibrateError;
use crate::hypothesis::{Addition, Hypothesis};
use crate::setup::Setup;
use least_squares::Options;
use std::time::{Duration, Instant};

/// Options for the final fit from the best start. Numerical: otherwise the result along a direction of nearly constant cost would
/// depend on the start.
const LAST: Options = Options { damping: 1e-6, linearisations: 12, decrease: 1e-5, ..OPTIONS };
/// Number of simulated starts, in addition to the preset. Numerical: starts of a fit.
const TRIED: usize = 48;
/// Number of fitted starts, in addition to the preset. Numerical: starts of a fit.
const STARTS: usize = 2;
/// Range of the simulated starts as a factor on ln(1 + relative deviation), three standard deviations, and its upper limit. Numerical:
/// starts of a fit.
const SPREAD: (f64, f64) = (3.0, 5.0);
/// Time limit for the simulated starts. Numerical: a limit of effort.
const TRYING: Duration = Duration::from_millis(1500);

impl Setup<'_> {
    /// The fit of a model with a new addition. Where a declared parameter ends at a limit, the cost has often a second minimum:
    /// two lags in series are the same in either order, and a lag of the winding is its heat capacity or its thermometer. The fit is
    /// then repeated with the declared parameters within a standard deviation of their priors at first, and the better one is returned.
    /// An effect with a shape gets more iterations, because its shape may be far from the start.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn fit_addition(&self, start: Hypothesis, runs: &[usize]) -> Result<Fitted, CalibrateError> {
        let has_shape = |a: &Addition| a.is_listed() && a.numbers.iter().filter(|n| n.sloped).count() > 1;
        let options = if start.additions.last().is_some_and(has_shape) { &FAR } else { &OPTIONS };
        let near = |mut start: Hypothesis| {
            for (value, declared) in start.declared.iter_mut().zip(&self.declared) {
                *value = declared.prior;
            }
            let mut scales = self.scaled(&start, false);
            for (scale, declared) in scales.iter_mut().zip(&self.declared) {
                let within = [declared.prior - declared.deviation, declared.prior + declared.deviation];
                let [least, most] = within.map(|limit| limit.clamp(scale.limits.0, scale.limits.1));
                scale.limits = (least, most);
            }
            let held = self.fit_scaled(start, runs, scales, &FAR)?;
            self.fit_with(held.hypothesis, runs, false, options)
        };
        let own = self.fit_with(start.clone(), runs, false, options)?;
        let mut ends = self.declared.iter().zip(&own.hypothesis.declared);
        if ends.all(|(declared, value)| declared.is_inside(*value)) {
            return Ok(own);
        }
        Ok(match near(start) {
            Ok(other) if other.cost < own.cost => other,
            _ => own,
        })
    }

    /// The first fit of the declared parameters: from the preset, and with wide priors also from further starts.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated from any start.
    pub fn refit(&self, runs: &[usize]) -> Result<Fitted, CalibrateError> {
        let plain = self.fit(self.preset(), runs);
        if !self.declared.iter().any(is_wide) {
            return plain;
        }
        let mut best = plain;
        for start in std::iter::once(self.preset()).chain(self.starts(runs)) {
            if best.is_ok() && self.deadline().is_near() {
                break;
            }
            let near = self.settled(start, runs);
            let better = match (&near, &best) {
                (Ok(near), Ok(best)) => near.cost < best.cost,
                (near, _) => near.is_ok(),
            };
            if better {
                best = near;
            }
        }
        let best = best?;
        if self.deadline().is_near() {
            return Ok(best);
        }
        self.fit_with(best.hypothesis.clone(), runs, false, &LAST).or(Ok(best))
    }

    /// The best starts of a low-discrepancy sample of the wide priors (Halton's sequence, Numer. Math. 2 (1960) 84-90).
    fn starts(&self, runs: &[usize]) -> Vec<Hypothesis> {
        /// Bases of the sequence, one for each parameter. Definition: the first prime numbers.
        const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
        let (begun, mut found) = (Instant::now(), Vec::new());
        for n in 1..=TRIED {
            if begun.elapsed() > TRYING || self.deadline().is_near() {
                break;
            }
            let mut start = self.preset();
            let wide = self.declared.iter().enumerate().filter(|(_, d)| is_wide(d));
            for ((k, d), prime) in wide.zip(PRIMES) {
                let spread = (SPREAD.0 * (1.0 + d.deviation / d.prior).ln()).min(SPREAD.1);
                let power = spread * (2.0 * halton(n, prime) - 1.0);
                start.declared[k] = (d.prior * power.exp()).clamp(d.limits.0, d.limits.1);
            }
            if let Ok(fitted) = self.judged(start, runs)
                && fitted.cost.is_finite()
            {
                found.push(fitted);
            }
        }
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        found.into_iter().take(STARTS).map(|f| f.hypothesis).collect()
    }
}

/// The n-th element of Halton's sequence for a prime.
fn halton(mut n: usize, prime: usize) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while n > 0 {
        share /= prime as f64;
        value += share * (n % prime) as f64;
        n /= prime;
    }
    value
}
