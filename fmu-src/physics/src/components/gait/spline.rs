//! The periodic cubic spline through equidistant points of one period: twice continuously differentiable everywhere.
//!
//! With second derivatives M_k at the points, M_(k-1) + 4 M_k + M_(k+1) = 6 (y_(k-1) - 2 y_k + y_(k+1)) / h^2.
//! *Source*: de Boor, A Practical Guide to Splines, rev. ed. 2001, chapter IV.

/// A function of period 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Values, and second derivatives times h^2 / 6, at the points k / n.
    points: Vec<[f64; 2]>,
}

/// Sweeps until the equations hold to rounding: each takes away three quarters of the error.
const SWEEPS: u32 = 40;

impl Spline {
    /// Through `values` at 0, 1/n, 2/n, ...; 1 is 0 again.
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
        Spline { points: values.iter().zip(m).map(|(&y, m)| [y, m]).collect() }
    }

    /// Value and slope at `phase`, 0 ... 1.
    #[inline]
    pub fn at(&self, phase: f64) -> (f64, f64) {
        let n = self.points.len();
        let place = phase * n as f64;
        let k = (place as usize).min(n - 1);
        let (b, [y0, m0], [y1, m1]) = (place - k as f64, self.points[k], self.points[(k + 1) % n]);
        let a = 1.0 - b;
        let value = a * y0 + b * y1 + (a * a * a - a) * m0 + (b * b * b - b) * m1;
        let slope = y1 - y0 - (3.0 * a * a - 1.0) * m0 + (3.0 * b * b - 1.0) * m1;
        (value, slope * n as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine through 50 points: fourth-order in the value, third in the slope.
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
}
