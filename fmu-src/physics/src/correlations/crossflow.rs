//! Cylinder in cross flow: forced and mixed convection.
//!
//! Nu_D = 0.3 + 0.62 Re^(1/2) Pr^(1/3) / [1 + (0.4/Pr)^(2/3)]^(1/4) [1 + (Re/282000)^(5/8)]^(4/5)   (1)
//! Nu^n = (Nu_forced - 0.3)^n + Nu_natural^n                                                (2)
//!
//! (2) with n = 4 for a horizontal cylinder in cross flow, n = 3 in general ([`Mixing`]). The 0.3 of (1) is
//! conduction in still air, which Nu_natural includes too; it is subtracted so that (2) gives natural convection
//! when the fan is off.
//! *Assumes* a uniform approach flow, air at the film temperature; (2) transverse or assisting flow.
//! *Neglects* the turbulence of a fan (raises Nu by 10 to 40 %), free ends, blockage at the jet's edge. Opposing
//! flow would need a minus sign in (2); it does not occur in this motor.
//! *Range*: (1) Re Pr > 0.2 at all Re and Pr; below it decreases smoothly to 0.3. Scatter of the data +-20 %.
//! Re < 0 is set to |Re|; Re above 1e9 to 1e9; Pr is limited to 1e-3 ... 1e4.
//! *Source*: (1) Churchill and Bernstein, J. Heat Transfer 99 (1977) 300-306, the form for the whole range;
//! Incropera, 7th ed., eq. 7.54; (2) ibid. sec. 9.9, eq. 9.64, and Churchill, AIChE J. 23 (1977) 10-16.

/// Nusselt number of (1) at zero flow.
pub const NU_AT_REST: f64 = 0.3;

/// Mean Nusselt number on the diameter in forced cross flow, eq. (1).
#[inline]
pub fn cylinder(re: f64, pr: f64) -> f64 {
    let (re, pr) = (re.abs().min(1e9), pr.clamp(1e-3, 1e4));
    let boundary_layer = 0.62 * re.sqrt() * pr.cbrt() / (1.0 + (0.4 / pr).powf(2.0 / 3.0)).powf(0.25);
    NU_AT_REST + boundary_layer * (1.0 + (re / 282_000.0).powf(0.625)).powf(0.8)
}

/// Combination of forced and natural convection: the exponent n of eq. (2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mixing {
    /// n = 3: plates, flow along a cylinder, flow across an upright cylinder
    General,
    /// n = 4: flow across a horizontal cylinder
    HorizontalCylinder,
}

/// Nusselt number of mixed convection, eq. (2), from a forced one without its value at zero flow and a natural one.
/// Negative numbers are set to 0. Both refer to the same length.
#[inline]
pub fn mixed(nu_forced: f64, nu_natural: f64, mixing: Mixing) -> f64 {
    let larger = nu_forced.max(nu_natural).max(0.0);
    if larger == 0.0 {
        return 0.0;
    }
    let ratio = (nu_forced.min(nu_natural) / larger).max(0.0);
    match mixing {
        Mixing::General => larger * (1.0 + ratio * ratio * ratio).cbrt(),
        Mixing::HorizontalCylinder => larger * (1.0 + ratio * ratio * ratio * ratio).sqrt().sqrt(),
    }
}

/// Nusselt number on the diameter of a horizontal cylinder in cross flow with natural convection
/// `nu_natural`, eqs. (1) and (2).
#[inline]
pub fn cylinder_mixed(re: f64, pr: f64, nu_natural: f64) -> f64 {
    mixed(cylinder(re, pr) - NU_AT_REST, nu_natural, Mixing::HorizontalCylinder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;

    /// Incropera, 7th ed., example 7.4: Re = 6071, Pr = 0.70: Nu = 40.6. The test fails with Pr instead of Pr^(1/3), and with 0.6
    /// instead of the exponent 1/2 of Re.
    #[test]
    fn cylinder_in_a_wind_tunnel_of_the_book() {
        close(cylinder(6071.0, 0.70), 40.6, 2e-3);
    }

    /// Hilpert's measured law for air, 0.683 Re^0.466 Pr^(1/3) from 40 to 4000 and 0.193 Re^0.618 Pr^(1/3) up
    /// to 40000 (Incropera, 7th ed., table 7.2): independent of (1), within 12 %.
    #[test]
    fn near_hilpert() {
        for re in [100.0, 300.0, 1000.0, 3000.0f64] {
            close(cylinder(re, 0.7), 0.683 * re.powf(0.466) * 0.7f64.cbrt(), 0.12);
        }
        for re in [5000.0, 1e4, 3e4f64] {
            close(cylinder(re, 0.7), 0.193 * re.powf(0.618) * 0.7f64.cbrt(), 0.12);
        }
    }

    /// Large Pr: the boundary layer's 0.62 Pr^(1/3) Re^(1/2); small Pr: 0.62/0.4^(1/6) (Re Pr)^(1/2).
    #[test]
    fn limits_of_prandtl() {
        close(cylinder(100.0, 1e4) - 0.3, 0.62 * 10.0 * 1e4f64.cbrt(), 0.01);
        close(cylinder(100.0, 1e-3) - 0.3, 0.62 * 10.0 * 1e-3f64.sqrt() / 0.4f64.powf(1.0 / 6.0), 0.02);
    }

    #[test]
    fn fan_off_is_natural_convection_and_a_strong_fan_hides_it() {
        assert_eq!(cylinder(0.0, 0.7), 0.3);
        close(cylinder_mixed(0.0, 0.7, 6.0), 6.0, 1e-15);
        close(cylinder_mixed(1e-6, 0.7, 6.0), 6.0, 1e-9);
        close(cylinder_mixed(1e5, 0.7, 6.0), cylinder(1e5, 0.7), 2e-3);
    }

    #[test]
    fn equal_parts_give_the_root_of_two() {
        close(mixed(5.0, 5.0, Mixing::General), 5.0 * 2f64.powf(1.0 / 3.0), 1e-14);
        close(mixed(5.0, 5.0, Mixing::HorizontalCylinder), 5.0 * 2f64.powf(0.25), 1e-14);
        assert_eq!(mixed(3.0, 4.0, Mixing::General), mixed(4.0, 3.0, Mixing::General));
        assert_eq!(mixed(-1.0, -2.0, Mixing::General), 0.0);
    }

    #[test]
    fn rises_and_is_finite() {
        let mut last = 0.0;
        for k in 0..150 {
            let nu = cylinder(10f64.powf(-6.0 + 0.1 * f64::from(k)), 0.7);
            assert!(nu > last);
            last = nu;
        }
        for re in [-1e300, 1e300] {
            for pr in [-1.0, 0.0, 1e300] {
                assert!(cylinder_mixed(re, pr, 1e300).is_finite());
            }
        }
    }
}
