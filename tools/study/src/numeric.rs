//! Small numerical tools: a root, a maximum, a straight line.

/// `n` numbers from `from` to `to`, both included; the first alone where `n` is 1.
pub fn linspace(from: f64, to: f64, n: usize) -> Vec<f64> {
    let steps = n.saturating_sub(1).max(1) as f64;
    (0..n).map(|k| from + (to - from) * k as f64 / steps).collect()
}

/// The root of `f` between `a` and `b`, where it changes its sign, to `tolerance` in the argument; `None`
/// where it does not change its sign. A value of infinity has a sign too.
///
/// *Source*: the Illinois form of regula falsi (Dowell and Jarratt, BIT 11 (1971) 168-174), with bisection
/// where a value is infinite or the bracket does not shrink by half in three steps.
pub fn root(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, tolerance: f64) -> Option<f64> {
    try_root::<std::convert::Infallible>(|x| Ok(f(x)), a, b, tolerance).unwrap_or(None)
}

/// As [`root`], of a function that may fail.
pub fn try_root<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    a: f64,
    b: f64,
    tolerance: f64,
) -> Result<Option<f64>, E> {
    let (fa, fb) = (f(a)?, f(b)?);
    try_root_between(f, (a, fa), (b, fb), tolerance)
}

/// As [`try_root`], between two points with their values.
pub fn try_root_between<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
    tolerance: f64,
) -> Result<Option<f64>, E> {
    if fa == 0.0 {
        return Ok(Some(a));
    }
    if fb == 0.0 {
        return Ok(Some(b));
    }
    if fa.is_nan() || fb.is_nan() || fa.signum() == fb.signum() {
        return Ok(None);
    }
    let mut width = (b - a).abs();
    for k in 0..200 {
        if (b - a).abs() <= tolerance {
            break;
        }
        let slow = k % 3 == 2 && {
            let slow = (b - a).abs() > 0.5 * width;
            width = (b - a).abs();
            slow
        };
        let x = if slow || !fa.is_finite() || !fb.is_finite() {
            0.5 * (a + b)
        } else {
            (a * fb - b * fa) / (fb - fa)
        };
        let fx = f(x)?;
        if fx == 0.0 {
            return Ok(Some(x));
        }
        if fx.signum() == fb.signum() {
            // The far end is kept: halving its value pulls the next point over the root.
            (b, fb) = (x, fx);
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
            (b, fb) = (x, fx);
        }
    }
    Ok(Some(if fa.is_finite() && fb.is_finite() { b } else { 0.5 * (a + b) }))
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
    fn roots_of_known_functions() {
        let near = |found: Option<f64>, expected: f64| {
            assert!(found.is_some_and(|x| (x - expected).abs() < 1e-9), "{found:?} instead of {expected}");
        };
        near(root(|x| x * x - 2.0, 0.0, 2.0, 1e-12), 2f64.sqrt());
        near(root(|x| (x - 1.0).powi(9), 0.0, 3.0, 1e-12), 1.0);
        near(root(|x| if x > 0.3 { f64::INFINITY } else { x - 0.2 }, 0.0, 1.0, 1e-12), 0.2);
        assert_eq!(root(|x| x * x + 1.0, -1.0, 1.0, 1e-12), None);
        assert_eq!(root(|_| f64::NAN, -1.0, 1.0, 1e-12), None);
    }

    /// A function without a value beyond a limit before its root: the limit is found, by bisection.
    #[test]
    fn the_edge_of_a_runaway_is_a_root() {
        let edge = root(|x| if x > 0.75 { f64::INFINITY } else { -1.0 }, 0.0, 1.0, 1e-9);
        assert!(edge.is_some_and(|x| (x - 0.75).abs() < 1e-8), "{edge:?}");
    }

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
