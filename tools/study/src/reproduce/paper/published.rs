//! The paper's equations as published, and corrected.
//!
//! R = R_0 [1 + alpha (T_f - T_i)] -> R = alpha R_0 T                                       eqs. (8) to (10)
//! V = alpha T R_0 I + L I^2/(2 q) + T_m theta/q                                            eq. (14)
//! P = alpha I^2 R_0 T + I L dI/dt + T_m theta                                              eq. (15)
//! W = alpha T R_0 I q + L I^2/2 + T_m theta                                                eq. (16)
//!
//! Temperatures in (10) and (14) to (24) are in degrees Celsius.
//! *Source*: the paper, sections 2.3 to 3.2.

/// Temperature coefficient, 1/K (section 2.3).
pub const ALPHA: f64 = 0.004;
/// The resistance that is "measured at 20 degC", ohm (section 2.3).
pub const R_0: f64 = 115.0;
/// Room temperature, degC (section 2.3).
pub const T_ROOM: f64 = 20.0;
/// Resistance by the LCR meter, ohm (section 2.5).
pub const R_A: f64 = 9.20;
/// Inductance by the LCR meter, H (section 2.5).
pub const L_A: f64 = 1.803e-3;
/// Supply, V (section 2.5).
pub const SUPPLY: f64 = 12.0;
/// Time at each duty, s (section 2.5).
pub const DURATION: f64 = 900.0;
/// Duties of the five runs, percent.
pub const DUTIES: [f64; 5] = [20.0, 40.0, 60.0, 80.0, 100.0];
/// Current at full duty, A: what V_el over R gives.
pub const CURRENT: f64 = 0.18;

/// An operating point of the equations.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Current, A.
    pub i: f64,
    /// Temperature, degC.
    pub t: f64,
    /// Torque, N.m.
    pub torque: f64,
    /// Angle turned, rad.
    pub theta: f64,
    /// Charge passed, C.
    pub q: f64,
}

/// Eq. (10), ohm: the constant of integration is lost, so that a winding at 0 degC would have no resistance.
pub fn resistance(t: f64) -> f64 {
    ALPHA * R_0 * t
}

/// Eq. (8) with R_0 the resistance at 20 degC, ohm.
pub fn right_resistance(t: f64) -> f64 {
    R_A * (1.0 + ALPHA * (t - T_ROOM))
}

/// The three terms of eq. (14), V: electrical, magnetic, mechanical.
pub fn voltage(p: &Point) -> [f64; 3] {
    [resistance(p.t) * p.i, L_A * p.i * p.i / (2.0 * p.q), p.torque * p.theta / p.q]
}

/// The three terms of eq. (15) in steady state; the unit of the last is J instead of W.
pub fn power(p: &Point) -> [f64; 3] {
    [resistance(p.t) * p.i * p.i, 0.0, p.torque * p.theta]
}

/// The three terms of eq. (16), J.
pub fn work(p: &Point) -> [f64; 3] {
    [resistance(p.t) * p.i * p.q, 0.5 * L_A * p.i * p.i, p.torque * p.theta]
}

/// Eq. (21) as published: the voltage's change from `a` to `b`; the temperature's term lacks the current.
pub fn voltage_change(a: &Point, b: &Point) -> f64 {
    L_A / (2.0 * a.q) * (b.i * b.i - a.i * a.i)
        + ALPHA * R_0 * a.t * (b.i - a.i)
        + ALPHA * R_0 * a.t * (b.t - a.t)
        + a.theta / a.q * (b.torque - a.torque)
}

/// Eq. (21) as the derivatives of (14) give it.
pub fn right_voltage_change(a: &Point, b: &Point) -> f64 {
    voltage_change(a, b) + ALPHA * R_0 * (a.i - a.t) * (b.t - a.t)
}

/// dI/dV of eq. (22) as published, A/V.
pub fn current_per_volt(p: &Point) -> f64 {
    p.q / (p.i * L_A + resistance(p.t))
}

/// dI/dV of eq. (14), A/V: the charge belongs to both terms.
pub fn right_current_per_volt(p: &Point) -> f64 {
    p.q / (p.i * L_A + p.q * resistance(p.t))
}

/// Temperature's term of eq. (23) per change of voltage, K/V; I in place of J.
pub fn temperature_per_volt(p: &Point) -> f64 {
    1.0 / (ALPHA * R_0 * p.i)
}

/// Torque's term of eq. (24) per change of voltage, N.m/V.
pub fn torque_per_volt(p: &Point) -> f64 {
    p.q / p.theta
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point() -> Point {
        Point { i: 0.18, t: 20.0, torque: 0.18, theta: 27.1, q: 0.6 }
    }

    /// The paper's own 9.2 ohm, 48.67 uV with 0.6 C, 29.21 uJ.
    #[test]
    fn published_terms_come_out() {
        assert!((resistance(20.0) - 9.2).abs() < 1e-12);
        assert!((voltage(&point())[0] - 1.656).abs() < 1e-12);
        assert!((voltage(&point())[1] - 48.67e-6).abs() < 2e-8);
        assert!((work(&point())[1] - 29.21e-6).abs() < 1e-8);
        assert!((power(&point())[0] - 0.29808).abs() < 1e-12);
    }

    /// By differences of eq. (14) itself: each corrected derivative is one of the equation, no published one is.
    #[test]
    fn derivatives_of_the_state_function() {
        let total = |p: &Point| voltage(p).iter().sum::<f64>();
        let a = point();
        let d = 1e-6;
        let warmer = Point { t: a.t + d, ..a };
        let by_difference = (total(&warmer) - total(&a)) / d;
        assert!((right_voltage_change(&a, &warmer) / d / by_difference - 1.0).abs() < 1e-6);
        assert!((voltage_change(&a, &warmer) / d / by_difference - 111.0).abs() < 1.0, "audit, P17");
        let more = Point { i: a.i + d, ..a };
        let per_ampere = (total(&more) - total(&a)) / d;
        assert!((right_current_per_volt(&a) * per_ampere - 1.0).abs() < 1e-5);
        assert!((current_per_volt(&a) / right_current_per_volt(&a) - 0.60).abs() < 0.01, "audit, P18");
        assert!((temperature_per_volt(&a) * by_difference - 1.0).abs() < 1e-6);
        assert!((torque_per_volt(&a) * a.theta / a.q - 1.0).abs() < 1e-12);
    }
}
