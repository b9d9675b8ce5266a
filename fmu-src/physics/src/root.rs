//! The root of a function of one variable.

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
}
