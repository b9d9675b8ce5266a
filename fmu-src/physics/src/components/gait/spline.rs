//! Piecewise polynomials over one period.
//!
//! The periodic cubic spline through equidistant points is twice continuously differentiable everywhere. With second derivatives M_k
//! at the points, M_(k-1) + 4 M_k + M_(k+1) = 6 (y_(k-1) - 2 y_k + y_(k+1)) / h^2.
//! *Source*: de Boor, A Practical Guide to Splines, rev. ed. 2001, chapter IV.
//!
//! Table rows at any distances are connected by straight lines; the integral of such a function has segments of second degree.

use std::sync::Arc;

/// Positions of the knots.
#[derive(Clone, Debug, PartialEq)]
enum Knots {
    /// At 0, 1/n, 2/n, ...
    Equidistant,
    /// At these phases, ascending from 0, below 1.
    At(Arc<[f64]>),
}

/// A periodic function of period 1, or one with a constant increment per period.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    knots: Knots,
    /// Coefficients of 1, b, b^2, b^3 from each knot to the next, where b goes from 0 to 1.
    pieces: Vec<[f64; 4]>,
}

/// The integral of one function over another: y dx over a period and parts of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Along {
    knots: Knots,
    /// For each segment the integral up to its start, and the coefficients of b, b^2, ... within it.
    pieces: Vec<[f64; 7]>,
    /// Over a whole period.
    whole: f64,
}

impl Knots {
    /// The segment, of `n`, that contains `phase`, 0 ... 1; the relative position in it, 0 ... 1; the number of segments of this length
    /// per period.
    #[inline]
    fn piece(&self, phase: f64, n: usize) -> (usize, f64, f64) {
        match self {
            Knots::Equidistant => {
                let place = phase * n as f64;
                let k = (place as usize).min(n - 1);
                (k, place - k as f64, n as f64)
            }
            Knots::At(knots) => {
                let k = knots.partition_point(|knot| *knot <= phase).max(1) - 1;
                let per_period = 1.0 / width(knots, k);
                (k, (phase - knots[k]) * per_period, per_period)
            }
        }
    }
}

/// From knot `k` to the next.
#[inline]
fn width(knots: &[f64], k: usize) -> f64 {
    knots.get(k + 1).copied().unwrap_or(1.0) - knots[k]
}

/// Iterations until the equations are solved to rounding; each reduces the error to one quarter.
const SWEEPS: u32 = 40;

impl Spline {
    /// Spline through `values` at 0, 1/n, 2/n, ...; 1 is 0 again.
    pub fn through(values: &[f64]) -> Spline {
        let n = values.len();
        let around = |k: usize| ((k + n - 1) % n, (k + 1) % n);
        let mut m = vec![0.0; n];
        for _ in 0..SWEEPS {
            for k in 0..n {
                let (before, after) = around(k);
                let bend = values[before] - 2.0 * values[k] + values[after];
                m[k] = (bend - m[before] - m[after]) / 4.0;
            }
        }
        let piece = |k: usize| {
            let (_, after) = around(k);
            let (y0, y1, m0, m1) = (values[k], values[after], m[k], m[after]);
            [y0, y1 - y0 - 2.0 * m0 - m1, 3.0 * m0, m1 - m0]
        };
        Spline { knots: Knots::Equidistant, pieces: (0..n).map(piece).collect() }
    }

    /// Straight lines through `values` at `knots`, which ascend from 0; 1 is 0 again.
    pub fn linear(knots: &Arc<[f64]>, values: &[f64]) -> Spline {
        let n = values.len();
        let piece = |k: usize| [values[k], values[(k + 1) % n] - values[k], 0.0, 0.0];
        Spline { knots: Knots::At(Arc::clone(knots)), pieces: (0..n).map(piece).collect() }
    }

    /// The integral of straight lines through `rates` at `knots`, without its increment per period if `periodic`; 0 at 0.
    /// Also returns the increment.
    pub fn integral(knots: &Arc<[f64]>, rates: &[f64], periodic: bool) -> (Spline, f64) {
        let n = rates.len();
        let area = |k: usize| 0.5 * width(knots, k) * (rates[k] + rates[(k + 1) % n]);
        let gain: f64 = (0..n).map(area).sum();
        let trend = if periodic { gain } else { 0.0 };
        let mut so_far = 0.0;
        let piece = |k: usize| {
            let (w, v0, v1) = (width(knots, k), rates[k], rates[(k + 1) % n]);
            let begin = so_far - trend * knots[k];
            so_far += area(k);
            [begin, w * (v0 - trend), 0.5 * w * (v1 - v0), 0.0]
        };
        (Spline { knots: Knots::At(Arc::clone(knots)), pieces: (0..n).map(piece).collect() }, gain)
    }

    /// The mean over the period.
    pub fn mean(&self) -> f64 {
        let area = |(k, [c0, c1, c2, c3]): (usize, &[f64; 4])| {
            let width = match &self.knots {
                Knots::Equidistant => 1.0 / self.pieces.len() as f64,
                Knots::At(knots) => width(knots, k),
            };
            width * (c0 + c1 / 2.0 + c2 / 3.0 + c3 / 4.0)
        };
        self.pieces.iter().enumerate().map(area).sum()
    }

    /// Adds a constant.
    pub fn raise(&mut self, by: f64) {
        self.pieces.iter_mut().for_each(|piece| piece[0] += by);
    }

    /// Value and derivative at `phase`, 0 ... 1.
    #[inline]
    pub fn at(&self, phase: f64) -> (f64, f64) {
        let (k, b, per_period) = self.knots.piece(phase, self.pieces.len());
        let [c0, c1, c2, c3] = self.pieces[k];
        let value = c0 + b * (c1 + b * (c2 + b * c3));
        let slope = c1 + b * (2.0 * c2 + b * (3.0 * c3));
        (value, slope * per_period)
    }

    /// The integral of this function over `way`, which has the same knots.
    pub fn along(&self, way: &Spline) -> Along {
        let mut whole = 0.0;
        let piece = |(y, x): (&[f64; 4], &[f64; 4])| {
            let mut factors = [whole, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            for (i, y) in y.iter().enumerate() {
                for (j, x) in x.iter().enumerate().skip(1) {
                    factors[i + j] += y * x * j as f64 / (i + j) as f64;
                }
            }
            whole = factors.iter().sum();
            factors
        };
        let pieces = self.pieces.iter().zip(&way.pieces).map(piece).collect();
        Along { knots: self.knots.clone(), pieces, whole }
    }
}

impl Along {
    /// From 0 to `phase`, 0 ... 1.
    #[inline]
    pub fn to(&self, phase: f64) -> f64 {
        let (k, b, _) = self.knots.piece(phase, self.pieces.len());
        let [c0, c1, c2, c3, c4, c5, c6] = self.pieces[k];
        c0 + b * (c1 + b * (c2 + b * (c3 + b * (c4 + b * (c5 + b * c6)))))
    }

    /// Over a whole period.
    #[inline]
    pub fn whole(&self) -> f64 {
        self.whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine through 50 points: fourth-order error in the value, third-order in the derivative.
    #[test]
    fn follows_a_sine_with_its_slope() {
        let values: Vec<f64> = (0..50).map(|k| (TAU * f64::from(k) / 50.0).sin()).collect();
        let spline = Spline::through(&values);
        for k in 0..=700 {
            let phase = f64::from(k) / 700.0;
            let (value, slope) = spline.at(phase);
            assert!((value - (TAU * phase).sin()).abs() < 5e-6);
            assert!((slope / TAU - (TAU * phase).cos()).abs() < 5e-5);
        }
        for (k, value) in values.iter().enumerate() {
            assert!((spline.at(k as f64 / 50.0).0 - value).abs() < 1e-15);
        }
    }

    #[test]
    fn closes_with_value_slope_and_bend() {
        let spline = Spline::through(&[0.0, 1.0, 0.3, -2.0, 0.7]);
        let (left, right) = (spline.at(1.0 - 1e-12), spline.at(0.0));
        assert!((left.0 - right.0).abs() < 1e-9 && (left.1 - right.1).abs() < 1e-9);
        let bend = |p: f64, q: f64| (spline.at(q).1 - spline.at(p).1) / (q - p);
        assert!((bend(1.0 - 1e-5, 1.0) - bend(0.0, 1e-5)).abs() < 1e-2 * bend(0.0, 1e-5).abs());
    }

    /// Rows at unequal distances: straight lines, and their integral with and without its increment.
    #[test]
    fn a_table_is_straight_between_its_rows() {
        let knots: Arc<[f64]> = vec![0.0, 0.125, 0.5].into();
        let rates = [2.0, 6.0, -4.0];
        let line = Spline::linear(&knots, &rates);
        for (phase, value) in
            [(0.0, 2.0), (0.0625, 4.0), (0.125, 6.0), (0.3125, 1.0), (0.75, -1.0), (1.0, 2.0)]
        {
            assert!((line.at(phase).0 - value).abs() < 1e-14, "{phase}");
        }
        // Areas of the three trapezia: 0.5, 0.375, -0.5.
        let (whole, gain) = Spline::integral(&knots, &rates, false);
        let (periodic, same) = Spline::integral(&knots, &rates, true);
        assert!((gain - 0.375).abs() < 1e-15 && gain == same);
        for k in 0..=64 {
            let phase = f64::from(k) / 64.0;
            let ((a, slope), (b, rest)) = (whole.at(phase), periodic.at(phase));
            assert!((a - b - gain * phase).abs() < 1e-14 && (slope - rest - gain).abs() < 1e-13, "{phase}");
            assert!((slope - line.at(phase).0).abs() < 1e-13);
        }
        assert!((whole.at(0.5).0 - 0.875).abs() < 1e-15 && (whole.at(1.0).0 - gain).abs() < 1e-15);
        let n = 100_000;
        let middle = |k: i32| periodic.at((f64::from(k) + 0.5) / f64::from(n)).0 / f64::from(n);
        assert!(((0..n).map(middle).sum::<f64>() - periodic.mean()).abs() < 1e-9);
    }

    /// cos^2 over a period, 1/2 of it, and parts of it, continuous at the knots.
    #[test]
    fn integrates_one_function_along_another() {
        let of = |f: fn(f64) -> f64| {
            Spline::through(&(0..50).map(|k| f(TAU * f64::from(k) / 50.0)).collect::<Vec<f64>>())
        };
        let along = of(f64::cos).along(&of(f64::sin));
        assert!((along.whole() - 0.5 * TAU).abs() < 1e-5, "{}", along.whole());
        for k in 0..=700 {
            let phase = f64::from(k) / 700.0;
            let exact = 0.5 * TAU * phase + 0.25 * (2.0 * TAU * phase).sin();
            assert!((along.to(phase) - exact).abs() < 1e-5, "{phase}");
            assert!((along.to(phase + 1e-9) - along.to(phase)).abs() < 1e-7);
        }
    }
}
