//! The periodic cubic spline through equidistant points of one period: twice continuously differentiable everywhere.
//!
//! With second derivatives M_k at the points, M_(k-1) + 4 M_k + M_(k+1) = 6 (y_(k-1) - 2 y_k + y_(k+1)) / h^2.
//! *Source*: de Boor, A Practical Guide to Splines, rev. ed. 2001, chapter IV.

/// A function of period 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// From each point k / n to the next: the factors of 1, b, b^2, b^3, where b goes from 0 to 1.
    pieces: Vec<[f64; 4]>,
}

/// The integral of one function along another: y dx over a period and its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Along {
    /// For each piece the integral up to it, and the factors of b, b^2, ... within it.
    pieces: Vec<[f64; 7]>,
    /// Over the whole period.
    whole: f64,
}

/// The piece of `n` in which `phase`, 0 ... 1, lies, and how far it is through it, 0 ... 1.
#[inline]
fn piece(phase: f64, n: usize) -> (usize, f64) {
    let place = phase * n as f64;
    let k = (place as usize).min(n - 1);
    (k, place - k as f64)
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
        let piece = |k: usize| {
            let (_, after) = around(k);
            let (y0, y1, m0, m1) = (values[k], values[after], m[k], m[after]);
            [y0, y1 - y0 - 2.0 * m0 - m1, 3.0 * m0, m1 - m0]
        };
        Spline { pieces: (0..n).map(piece).collect() }
    }

    /// Value and slope at `phase`, 0 ... 1.
    #[inline]
    pub fn at(&self, phase: f64) -> (f64, f64) {
        let n = self.pieces.len();
        let (k, b) = piece(phase, n);
        let [c0, c1, c2, c3] = self.pieces[k];
        let value = c0 + b * (c1 + b * (c2 + b * c3));
        let slope = c1 + b * (2.0 * c2 + b * (3.0 * c3));
        (value, slope * n as f64)
    }

    /// The integral of this function along `way`, which has as many points.
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
        Along { pieces, whole }
    }
}

impl Along {
    /// From 0 to `phase`, 0 ... 1.
    #[inline]
    pub fn to(&self, phase: f64) -> f64 {
        let (k, b) = piece(phase, self.pieces.len());
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

    /// cos^2 over a period, 1/2 of it, and the parts on the way, which go on where pieces meet.
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
