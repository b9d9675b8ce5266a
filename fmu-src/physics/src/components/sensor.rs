//! A temperature sensor with first-order lag.
//!
//! tau dy/dt = T - y,   T a parabola over the step                                       (1)
//! y(h) = y_0 + (T_0 - y_0) e + s (h - tau e) + 4 b g(h / tau)                           (2)
//! e = 1 - exp(-h / tau),   s = (T_1 - T_0) / h,   b = T_m - (T_0 + T_1) / 2
//! g(u) = [u (1 + exp(-u)) - 2 (1 - exp(-u))] / u^2                                      (3)
//!
//! mean y = (T_0 + 4 T_m + T_1) / 6 - tau (y(h) - y_0) / h                               (4)
//!
//! T_0, T_m and T_1 are the temperatures at the start, in the middle and at the end of the step. Eq. (4) is the integral of eq. (1).
//! *Assumes* only eq. (1): eq. (2) is its exact solution for any step size.

/// Reading of a sensor of time constant `tau` >= 0, s, with initial reading `shown`, after `h` > 0 seconds with these temperatures at the
/// start, in the middle and at the end, K.
#[inline]
pub fn lagged(shown: f64, tau: f64, [from, middle, to]: [f64; 3], h: f64) -> f64 {
    if tau == 0.0 {
        return to;
    }
    let e = -(-h / tau).exp_m1();
    let bend = middle - 0.5 * (from + to);
    shown + (from - shown) * e + (to - from) / h * (h - tau * e) + 4.0 * bend * bent(h / tau, e)
}

/// Mean reading over these `h` seconds by eq. (4); `shown` and `shows` are those at the ends.
#[inline]
pub fn mean_lagged([shown, shows]: [f64; 2], tau: f64, [from, middle, to]: [f64; 3], h: f64) -> f64 {
    (from + 4.0 * middle + to) / 6.0 - tau * (shows - shown) / h
}

/// Eq. (3), with `e` = 1 - exp(-u); its series where the terms cancel.
#[inline]
fn bent(u: f64, e: f64) -> f64 {
    if u < 0.01 {
        u * (1.0 / 6.0 - u * (1.0 / 12.0 - u * (1.0 / 40.0 - u / 180.0)))
    } else {
        (u * (2.0 - e) - 2.0 * e) / (u * u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One time constant after a step: 1 - 1/e of it. Long after the start of a ramp the lag is tau times its rate.
    #[test]
    fn a_jump_and_a_ramp() {
        let jump = lagged(300.0, 20.0, [350.0; 3], 20.0);
        assert!((jump - (300.0 + 50.0 * (1.0 - (-1.0f64).exp()))).abs() < 1e-12, "{jump}");
        let ramp = lagged(300.0, 2.0, [300.0, 350.0, 400.0], 1000.0);
        assert!((ramp - (400.0 - 2.0 * 0.1)).abs() < 1e-12, "{ramp}");
    }

    /// Exact for a parabola: two half steps equal one whole step, for short and long time constants. tau = 0 indicates the temperature, tau
    /// near 0 almost.
    #[test]
    fn steps_add_up_and_no_lag_is_the_limit() {
        let path = |t: f64| 320.0 + 3.0 * t - 0.7 * t * t;
        for tau in [0.3, 7.0, 199.0, 201.0, 5e3] {
            let over = |shown: f64, from: f64, h: f64| {
                lagged(shown, tau, [from, from + 0.5 * h, from + h].map(path), h)
            };
            let (whole, halves) = (over(310.0, 0.0, 4.0), over(over(310.0, 0.0, 2.0), 2.0, 2.0));
            assert!((whole - halves).abs() < 1e-9, "{tau} s: {whole} {halves}");
            let mean = mean_lagged([310.0, whole], tau, [0.0, 2.0, 4.0].map(path), 4.0);
            let middles = (0..1000).map(|k| over(310.0, 0.0, (f64::from(k) + 0.5) * 4e-3));
            assert!((mean - middles.sum::<f64>() / 1e3).abs() < 1e-5, "{tau} s: {mean}");
        }
        assert_eq!(lagged(310.0, 0.0, [320.0, 325.0, 330.0], 4.0), 330.0);
        assert!((lagged(310.0, 1e-9, [320.0, 329.0, 330.0], 4.0) - 330.0).abs() < 1e-7);
    }
}
