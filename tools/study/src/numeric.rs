//! Small numerical tools: a root, a maximum, a straight line.

pub use physics::root::{root, try_root, try_root_between};

/// `n` numbers from `from` to `to`, both included; the first alone where `n` is 1.
pub fn linspace(from: f64, to: f64, n: usize) -> Vec<f64> {
    let steps = n.saturating_sub(1).max(1) as f64;
    (0..n).map(|k| from + (to - from) * k as f64 / steps).collect()
}

/// Where `f`, which has one maximum between `a` and `b`, is greatest, to `tolerance` in the argument (golden
/// section).
pub fn maximum(f: impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64) -> f64 {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (a, b);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    while (b - a).abs() > tolerance {
        if fc > fd {
            (b, d, fd) = (d, c, fc);
            c = b - golden * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + golden * (b - a);
            fd = f(d);
        }
    }
    0.5 * (a + b)
}

/// The straight line of least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub intercept: f64,
    /// Change per unit of x.
    pub slope: f64,
    /// Share of the variance that the line explains, r^2.
    pub r2: f64,
}

impl Line {
    /// The line through points (x, y); `None` for fewer than two different x.
    pub fn through(points: &[(f64, f64)]) -> Option<Line> {
        let n = points.len() as f64;
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let sum = |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| f(p.0 - x, p.1 - y)).sum::<f64>();
        let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
        if points.len() < 2 || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        Some(Line { intercept: y - slope * x, slope, r2: if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 } })
    }

    /// The value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maximum_of_a_parabola() {
        assert!((maximum(|x| -(x - 0.3) * (x - 0.3), -1.0, 2.0, 1e-8) - 0.3).abs() < 1e-7);
    }

    /// By hand: (0,1), (1,2), (2,4): slope 3/2, intercept 5/6, r2 = 1 - (1/6)/(14/3) = 27/28.
    #[test]
    fn line_by_hand() {
        let line = Line::through(&[(0.0, 1.0), (1.0, 2.0), (2.0, 4.0)]).unwrap();
        assert!((line.slope - 1.5).abs() < 1e-15 && (line.intercept - 5.0 / 6.0).abs() < 1e-15);
        assert!((line.r2 - 27.0 / 28.0).abs() < 1e-15 && (line.at(2.0) - 23.0 / 6.0).abs() < 1e-14);
        assert_eq!(Line::through(&[(1.0, 1.0), (1.0, 2.0)]), None);
    }

    #[test]
    fn linspace_has_both_ends() {
        assert_eq!(linspace(1.0, 2.0, 3), [1.0, 1.5, 2.0]);
        assert_eq!(linspace(1.0, 2.0, 1), [1.0]);
        assert!(linspace(1.0, 2.0, 0).is_empty());
    }
}
