//! A sensor that follows a temperature late.
//!
//! tau dy/dt = T - y,   T on a line over the step                                           (1)
//! y(h) = y_0 + (T_0 - y_0) e + s (h - tau e),   e = 1 - exp(-h / tau),   s = (T_1 - T_0) / h   (2)
//!
//! *Assumes* nothing beyond eq. (1): eq. (2) is its exact solution, whatever the step.

/// What a sensor of time constant `tau` >= 0, s, that stood at `shown` shows after `h` > 0 seconds in which its
/// temperature went from `from` to `to`, K.
#[inline]
pub fn lagged(shown: f64, tau: f64, from: f64, to: f64, h: f64) -> f64 {
    if tau == 0.0 {
        return to;
    }
    let e = -(-h / tau).exp_m1();
    shown + (from - shown) * e + (to - from) / h * (h - tau * e)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One time constant after a jump: 1 - 1/e of it. Long after the start of a ramp: tau times its slope behind.
    #[test]
    fn a_jump_and_a_ramp() {
        let jump = lagged(300.0, 20.0, 350.0, 350.0, 20.0);
        assert!((jump - (300.0 + 50.0 * (1.0 - (-1.0f64).exp()))).abs() < 1e-12, "{jump}");
        let ramp = lagged(300.0, 2.0, 300.0, 400.0, 1000.0);
        assert!((ramp - (400.0 - 2.0 * 0.1)).abs() < 1e-12, "{ramp}");
    }

    /// Exact: two half steps are the whole one. tau = 0 shows the temperature, and so does nearly 0.
    #[test]
    fn steps_add_up_and_no_lag_is_the_limit() {
        let whole = lagged(310.0, 7.0, 320.0, 330.0, 4.0);
        let halves = lagged(lagged(310.0, 7.0, 320.0, 325.0, 2.0), 7.0, 325.0, 330.0, 2.0);
        assert!((whole - halves).abs() < 1e-12, "{whole} {halves}");
        assert_eq!(lagged(310.0, 0.0, 320.0, 330.0, 4.0), 330.0);
        assert!((lagged(310.0, 1e-9, 320.0, 330.0, 4.0) - 330.0).abs() < 1e-8);
    }
}
