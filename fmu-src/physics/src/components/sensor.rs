//! A temperature sensor with first-order lag.
//!
//! tau dy/dt = T - y,   T linear over the step                                           (1)
//! y(h) = y_0 + (T_0 - y_0) e + s (h - tau e),   e = 1 - exp(-h / tau),   s = (T_1 - T_0) / h   (2)
//!
//! *Assumes* only eq. (1): eq. (2) is its exact solution for any step size.

/// Reading of a sensor of time constant `tau` >= 0, s, with initial reading `shown`, after `h` > 0 seconds in which the
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

    /// One time constant after a step: 1 - 1/e of it. Long after the start of a ramp the lag is tau times its rate.
    #[test]
    fn a_jump_and_a_ramp() {
        let jump = lagged(300.0, 20.0, 350.0, 350.0, 20.0);
        assert!((jump - (300.0 + 50.0 * (1.0 - (-1.0f64).exp()))).abs() < 1e-12, "{jump}");
        let ramp = lagged(300.0, 2.0, 300.0, 400.0, 1000.0);
        assert!((ramp - (400.0 - 2.0 * 0.1)).abs() < 1e-12, "{ramp}");
    }

    /// Exact: two half steps equal one whole step. tau = 0 indicates the temperature, tau near 0 almost.
    #[test]
    fn steps_add_up_and_no_lag_is_the_limit() {
        let whole = lagged(310.0, 7.0, 320.0, 330.0, 4.0);
        let halves = lagged(lagged(310.0, 7.0, 320.0, 325.0, 2.0), 7.0, 325.0, 330.0, 2.0);
        assert!((whole - halves).abs() < 1e-12, "{whole} {halves}");
        assert_eq!(lagged(310.0, 0.0, 320.0, 330.0, 4.0), 330.0);
        assert!((lagged(310.0, 1e-9, 320.0, 330.0, 4.0) - 330.0).abs() < 1e-8);
    }
}
