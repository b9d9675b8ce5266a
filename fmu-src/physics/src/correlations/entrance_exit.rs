//! Abrupt contraction into a gap and expansion out of it, after Kays and London.
//!
//! K_c = 1/C_c^2 - 2/C_c + 2 K_d - 1                                                        (1)
//! K_e = 1 - 2 K_d sigma + sigma^2                                                          (2)
//! sigma = c + 2/pi (1 - c^2) arctan c,   C_c = c/sigma                                     (3)
//! K_d = 6/5 laminar;  1 + 0.04 (Re/1e4)^(-0.2) turbulent;  linear in Re between 2300 and 4000 (4)
//! p_1 - p_2 = rho u^2/2 (1 - sigma^2 + K_c) at the entrance, -rho u^2/2 (1 - sigma^2 - K_e) at the exit (5)
//!
//! sigma is the ratio of the gap's area to that upstream or downstream of it, C_c the contraction of the jet behind the
//! edge, K_d the momentum of the profile divided by that of a uniform one, u the mean velocity in the gap.
//! *Assumes* sharp edges, parallel plates (a narrow annulus), a profile that is developed where K_d > 1. With
//! the friction of a developing profile (`annulus_friction.rs`) use K_d = 1 at the entrance; otherwise the momentum
//! is counted twice.
//! *Neglects* the velocity profile in the wide part, compressibility, swirl.
//! *Sign*: (5) positive = pressure lost downstream; K_e < 0 recovers pressure.
//! *Range*: sigma 0 to 1, limited to this range; (4) at any Re.
//! *Source*: (1), (2) Kays, Trans. ASME 72 (1950) 1067-1074, as drawn in Kays and London, Compact Heat
//! Exchangers, fig. 5-3; (3) free-streamline theory of a slot, von Mises, VDI-Zeitschrift 61 (1917) 447; (4)
//! 6/5 is the exact value of a parabola, 1.04 at Re = 1e4 and 1 at infinity those of fig. 5-3 (`seeds` audit,
//! T36); that K_d - 1 falls as friction does, Re^-0.2, and the interpolation are the project's choice.
//! The audit reads K_c(0) = 0.785 and 0.385 for K_d = 1.2 and 1; (1) with (3), C_c(0) = pi/(pi + 2) = 0.611,
//! gives 0.805 and 0.405. The 0.02 is within the reading error of the figure.

use super::{RE_TURBULENT, turbulent_share};
use std::f64::consts::{FRAC_2_PI, PI};

/// Ratio of momentum K_d between parallel plates, eq. (4), at the Reynolds number on the hydraulic diameter.
#[inline]
pub fn momentum_ratio(re: f64) -> f64 {
    const LAMINAR: f64 = 1.2;
    let re = re.abs().min(1e12);
    let share = turbulent_share(re);
    if share == 0.0 {
        return LAMINAR;
    }
    let turbulent = 1.0 + 0.04 * (re.max(RE_TURBULENT) / 1e4).powf(-0.2);
    LAMINAR + share * (turbulent - LAMINAR)
}

/// Contraction C_c of the jet behind the edge, eq. (3). 0.611 at sigma = 0, 1 at sigma = 1.
pub fn contraction_ratio(sigma: f64) -> f64 {
    let sigma = sigma.clamp(0.0, 1.0);
    if sigma < 1e-9 {
        return PI / (PI + 2.0);
    }
    // (3) rises in c from 0 to 1: bisection cannot fail, and sigma changes only with the geometry.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let c = 0.5 * (low + high);
        if c + FRAC_2_PI * (1.0 - c * c) * f64::atan(c) < sigma {
            low = c;
        } else {
            high = c;
        }
    }
    0.5 * (low + high) / sigma
}

/// Loss of the contraction K_c, eq. (1), from sigma and the ratio of momentum `k_d` in the gap.
#[inline]
pub fn contraction(sigma: f64, k_d: f64) -> f64 {
    let r = 1.0 / contraction_ratio(sigma);
    r * r - 2.0 * r + 2.0 * k_d.clamp(1.0, 2.0) - 1.0
}

/// Loss of the expansion K_e, eq. (2), from sigma and the ratio of momentum `k_d` in the gap.
#[inline]
pub fn expansion(sigma: f64, k_d: f64) -> f64 {
    let sigma = sigma.clamp(0.0, 1.0);
    1.0 - 2.0 * k_d.clamp(1.0, 2.0) * sigma + sigma * sigma
}

/// Pressure drop from the wide part into the gap, eq. (5), Pa: `k_c` of [`contraction`], density in kg/m3,
/// mean velocity `u` in the gap in m/s. It includes the acceleration and the loss.
#[inline]
pub fn entrance_drop(k_c: f64, sigma: f64, rho: f64, u: f64) -> f64 {
    let sigma = sigma.clamp(0.0, 1.0);
    0.5 * rho * u * u * (1.0 - sigma * sigma + k_c)
}

/// Pressure drop from the gap into the wide part, eq. (5), Pa; negative where pressure is recovered.
#[inline]
pub fn exit_drop(k_e: f64, sigma: f64, rho: f64, u: f64) -> f64 {
    let sigma = sigma.clamp(0.0, 1.0);
    -0.5 * rho * u * u * (1.0 - sigma * sigma - k_e)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::RE_LAMINAR;
    use crate::correlations::checks::{close, continuous};

    /// The table of von Mises for a slot of width ratio 0 to 0.9, to its three digits (also Rouse, Elementary
    /// Mechanics of Fluids, 1946, for two dimensions).
    #[test]
    fn contraction_of_a_slot_after_von_mises() {
        let table = [0.611, 0.612, 0.616, 0.622, 0.631, 0.644, 0.662, 0.687, 0.722, 0.781];
        for (k, expected) in table.into_iter().enumerate() {
            let ratio = contraction_ratio(0.1 * k as f64);
            assert!((ratio - expected).abs() <= 6e-4, "{k}: {ratio}");
        }
        close(contraction_ratio(1.0), 1.0, 1e-7);
    }

    /// Kays and London, fig. 5-3 as read in the audit of `seeds` (T36): 0.785 laminar, 0.385 at Re =
    /// infinity for sigma = 0; reading error 0.02. K_e = 1 there, -0.4 and 0 at sigma = 1.
    #[test]
    fn figure_of_kays_and_london() {
        assert!((contraction(0.0, 1.2) - 0.785).abs() <= 0.021);
        assert!((contraction(0.0, 1.0) - 0.385).abs() <= 0.021);
        assert_eq!(expansion(0.0, 1.2), 1.0);
        close(expansion(1.0, 1.2), -0.4, 1e-12);
        assert_eq!(expansion(1.0, 1.0), 0.0);
    }

    /// With a uniform profile (1) is the loss of the reattaching jet, (1/C_c - 1)^2, and (2) the
    /// loss of Borda and Carnot, (1 - sigma)^2.
    #[test]
    fn uniform_profile_is_borda_and_carnot() {
        for sigma in [0.0, 0.2, 0.5, 0.8, 1.0] {
            let r = 1.0 / contraction_ratio(sigma) - 1.0;
            assert!((contraction(sigma, 1.0) - r * r).abs() < 1e-14);
            assert!((expansion(sigma, 1.0) - (1.0 - sigma) * (1.0 - sigma)).abs() < 1e-14);
        }
    }

    /// 6/5 is the mean of (3/2 (1 - y^2))^2 over the gap; 1.04 at Re = 1e4 and 1 at infinity as in the
    /// figure.
    #[test]
    fn ratio_of_momentum() {
        let n = 1000;
        let parabola = |k: i32| 1.5 * (1.0 - ((f64::from(k) + 0.5) / f64::from(n)).powi(2));
        let mean: f64 = (0..n).map(|k| parabola(k).powi(2)).sum::<f64>() / f64::from(n);
        close(momentum_ratio(0.0), mean, 1e-6);
        assert_eq!(momentum_ratio(1e4), 1.04);
        assert!(momentum_ratio(1e12) < 1.002);
    }

    #[test]
    fn nothing_jumps() {
        for re in [RE_LAMINAR, RE_TURBULENT] {
            continuous(momentum_ratio, re);
            continuous(|re| contraction(0.4, momentum_ratio(re)), re);
            continuous(|re| expansion(0.4, momentum_ratio(re)), re);
        }
        continuous(|s| contraction(s, 1.2), 1e-9);
        continuous(|s| contraction(s, 1.2), 1.0);
        let mut last = contraction(0.0, 1.0);
        for k in 1..=1000 {
            let loss = contraction(f64::from(k) * 1e-3, 1.0);
            assert!(loss <= last + 1e-12);
            last = loss;
        }
    }

    /// Loss at both ends: the exit recovers less than the pressure drop of the entrance.
    #[test]
    fn both_ends_together_lose() {
        let (rho, u) = (1.2, 10.0);
        for sigma in [0.0, 0.3, 0.7] {
            let (k_c, k_e) = (contraction(sigma, 1.0), expansion(sigma, 1.0));
            let sum = entrance_drop(k_c, sigma, rho, u) + exit_drop(k_e, sigma, rho, u);
            close(sum, 60.0 * (k_c + k_e), 1e-12);
        }
        close(entrance_drop(0.5, 0.0, rho, u), 90.0, 1e-14);
    }

    #[test]
    fn finite_for_any_finite_number() {
        for sigma in [-1e300, 0.0, 1e-300, 1.0, 1e300] {
            for re in [-1e300, 0.0, 1e300] {
                let k_d = momentum_ratio(re);
                assert!(contraction(sigma, k_d).is_finite() && expansion(sigma, k_d).is_finite());
            }
        }
    }
}
