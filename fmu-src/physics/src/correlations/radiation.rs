//! Thermal radiation of a grey body in a large enclosure.
//!
//! q = eps sigma (T_s^4 - T_a^4)                                                            (1)
//! h_r = q / (T_s - T_a) = eps sigma (T_s + T_a)(T_s^2 + T_a^2)                             (2)
//!
//! *Assumes* a grey, diffuse, convex body in a much larger enclosure of uniform temperature.
//! *Neglects* reflection by an annulus around the body (there the wall is a node).
//! *Sign*: q > 0 leaves the body.
//! *Range*: any temperature >= 0 K; below 0 K is set to 0 K, above 1e4 K to 1e4 K; eps is limited to 0 ... 1.
//! *Source*: Incropera, Fundamentals of Heat and Mass Transfer, 7th ed., eqs. 1.7 to 1.9; sigma of the SI
//! (2019).

/// Stefan-Boltzmann constant, W/(m2.K4).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

#[inline]
fn limited(t: f64) -> f64 {
    t.clamp(0.0, 1e4)
}

/// Radiation heat transfer coefficient, eq. (2), W/(m2.K), from the temperatures of the surface, `t_s`, and of
/// ambient, `t_a`, in K. Finite also where the two are equal.
#[inline]
pub fn coefficient(eps: f64, t_s: f64, t_a: f64) -> f64 {
    let (t_s, t_a) = (limited(t_s), limited(t_a));
    eps.clamp(0.0, 1.0) * STEFAN_BOLTZMANN * (t_s + t_a) * (t_s * t_s + t_a * t_a)
}

/// Heat flux from the surface at `t_s` to ambient at `t_a`, eq. (1), W/m2.
#[inline]
pub fn flux(eps: f64, t_s: f64, t_a: f64) -> f64 {
    coefficient(eps, t_s, t_a) * (limited(t_s) - limited(t_a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;

    /// Incropera, 7th ed., example 1.2: a steam pipe of 70 mm, eps 0.8, at 200 degC in a room at 25 degC
    /// loses 421 W/m by radiation. The test fails with the third power in (1).
    #[test]
    fn steam_pipe_of_the_book() {
        close(flux(0.8, 473.0, 298.0) * std::f64::consts::PI * 0.07, 421.0, 2e-3);
    }

    #[test]
    fn linearised_is_exact_and_has_the_limit_4_sigma_t3() {
        let (eps, t) = (0.3, 350.0f64);
        close(coefficient(eps, t, t), 4.0 * eps * STEFAN_BOLTZMANN * t.powi(3), 1e-14);
        let (hot, cold) = (400.0f64, 300.0f64);
        close(flux(eps, hot, cold), eps * STEFAN_BOLTZMANN * (hot.powi(4) - cold.powi(4)), 1e-13);
        assert_eq!(flux(eps, t, t), 0.0);
        assert_eq!(flux(eps, hot, cold), -flux(eps, cold, hot));
    }

    #[test]
    fn finite_for_any_finite_temperature() {
        for t in [-1e300, -1.0, 0.0, 300.0, 1e300] {
            assert!(flux(2.0, t, 300.0).is_finite() && coefficient(-1.0, t, t) == 0.0);
        }
    }
}
