//! Natural convection around a cylinder with flat ends, in still air.
//!
//! horizontal cylinder: Nu_D = {0.60 + 0.387 Ra_D^(1/6) / [1 + (0.559/Pr)^(9/16)]^(8/27)}^2  (1)
//! vertical plate:      Nu_L = {0.825 + 0.387 Ra_L^(1/6) / [1 + (0.492/Pr)^(9/16)]^(8/27)}^2 (2)
//! the same, laminar:   Nu_L = 0.68 + 0.670 Ra_L^(1/4) / [1 + (0.492/Pr)^(9/16)]^(4/9)      (2a)
//! vertical cylinder:   Nu_L = (2a) + 4 (272 + 315 Pr) / [35 (64 + 63 Pr)] L/D              (3)
//! end disc, upright:   (2a) with L = pi D/4, the mean chord                                 (4)
//! horizontal concentric cylinders, the inner or the outer one warm:
//!     k_eff/k = max{1, 0.386 [Pr/(0.861 + Pr)]^(1/4) Ra_c^(1/4)}                            (5)
//!     L_c = 2 ln(D_o/D_i)^(4/3) / [(D_i/2)^(-3/5) + (D_o/2)^(-3/5)]^(5/3)
//!     heat per length = 2 pi k_eff (T_i - T_o) / ln(D_o/D_i)
//! temperature difference in Ra: sqrt((T - T_a)^2 + (0.05 K)^2)                              (6)
//!
//! *Assumes* an isothermal surface, properties at the film temperature, large still ambient air.
//! *Neglects* the wake of the cylinder at its own ends. The ends of a vertical motor are horizontal; (4) is then
//! an approximation (the mean of upper and lower face is close to that of an upright disc).
//! *Range*: (1) Ra_D <= 1e12, (2) all Ra_L up to 1e12; both for any Pr. Ra -> 0 gives Nu = 0.36 and 0.68: pure conduction of a finite
//! body in a large space. Ra < 0 is set to |Ra| (heat flows inwards); above 1e12 the same law is used up to 1e30; Pr is limited to 1e-3 ...
//! 1e4. (2a) up to 1e9, which includes all motors; there (2) is up to 18 % above it in air.
//! (3) A cylinder is treated as a plate if D/L >= 35/Gr_L^(1/4) ([`is_plate_like`]); slenderer, its curvature adds
//! the second term of the laminar integral solution. A motor (L/D about 2, Gr_L about 1e6) needs it: 6 %.
//! (5) 0.7 <= Pr <= 6000, Ra_c <= 1e7, extrapolated above; pure conduction where (5) is below it (Ra_c about 100 in air).
//! (6) The derivative of Ra^(1/4) and Ra^(1/6) at Ra = 0 is infinite. Still air is not isothermal (ISO 7730, category A, allows 2 K
//! over 1 m of height, hence 0.06 K over a motor of 30 mm): smaller differences do not determine the coefficient. (6) changes it by
//! less than 1e-3 above 0.6 K, and the heat flow of that motor by less than 1 mW everywhere.
//! *Source*: (1) Churchill and Chu, Int. J. Heat Mass Transfer 18 (1975) 1049-1053; (2) the same, 1323-1329;
//! Incropera, 7th ed., eqs. 9.34, 9.26 to 9.28; (3) Le Fevre and Ede, 9th Int. Congr. Appl. Mech. (1956) 4,
//! 175; (5) Raithby and Hollands, Adv. Heat Transfer 11 (1975) 265-315; Incropera, 7th ed., eqs. 9.58 to 9.60.

use std::f64::consts::PI;

/// Variation of the temperature in still air, K, eq. (6).
const VARIATION: f64 = 0.05;

/// Temperature difference that drives the convection, for surfaces or air that differ by `dt`, eq. (6), K: positive and smooth.
#[inline]
pub fn driving_difference(dt: f64) -> f64 {
    (dt * dt + VARIATION * VARIATION).sqrt()
}

/// Limits the arguments: |Ra| up to 1e30, Pr from 1e-3 to 1e4.
#[inline]
fn limited(ra: f64, pr: f64) -> (f64, f64) {
    (ra.abs().min(1e30), pr.clamp(1e-3, 1e4))
}

/// The common form of (1) and (2).
#[inline]
fn churchill_chu(ra: f64, pr: f64, rest: f64, pr_ref: f64) -> f64 {
    let (ra, pr) = limited(ra, pr);
    let root = rest + 0.387 * ra.powf(1.0 / 6.0) / (1.0 + (pr_ref / pr).powf(9.0 / 16.0)).powf(8.0 / 27.0);
    root * root
}

/// Mean Nusselt number on the diameter of a horizontal cylinder, eq. (1), from Ra on the diameter.
#[inline]
pub fn horizontal_cylinder(ra_d: f64, pr: f64) -> f64 {
    churchill_chu(ra_d, pr, 0.60, 0.559)
}

/// Mean Nusselt number on the height of a vertical plate, eq. (2), from Ra on the height.
#[inline]
pub fn vertical_plate(ra_l: f64, pr: f64) -> f64 {
    churchill_chu(ra_l, pr, 0.825, 0.492)
}

/// Mean Nusselt number on the height of a vertical plate in laminar flow, eq. (2a), Ra up to 1e9.
#[inline]
pub fn vertical_plate_laminar(ra_l: f64, pr: f64) -> f64 {
    let (ra, pr) = limited(ra_l, pr);
    0.68 + 0.670 * ra.sqrt().sqrt() / (1.0 + (0.492 / pr).powf(9.0 / 16.0)).powf(4.0 / 9.0)
}

/// Mean Nusselt number on the height of a vertical cylinder, eq. (3), from Ra on the height and `l_over_d`,
/// the height over the diameter (limited to 0 ... 100).
#[inline]
pub fn vertical_cylinder(ra_l: f64, pr: f64, l_over_d: f64) -> f64 {
    let (_, p) = limited(ra_l, pr);
    let curvature = 4.0 * (272.0 + 315.0 * p) / (35.0 * (64.0 + 63.0 * p));
    vertical_plate_laminar(ra_l, pr) + curvature * l_over_d.clamp(0.0, 100.0)
}

/// Whether a vertical cylinder can be treated as a plate: D/L >= 35/Gr_L^(1/4).
#[inline]
pub fn is_plate_like(ra_l: f64, pr: f64, l_over_d: f64) -> bool {
    let (ra, pr) = limited(ra_l, pr);
    (ra / pr).powf(0.25) >= 35.0 * l_over_d
}

/// Height of the vertical plate that replaces an upright end disc of diameter `d`, eq. (4), m: area over
/// width.
#[inline]
pub fn end_disc_height(d: f64) -> f64 {
    PI / 4.0 * d
}

/// Length L_c of eq. (5) for the diameters `d_i` < `d_o`, m.
#[inline]
pub fn concentric_length(d_i: f64, d_o: f64) -> f64 {
    let root = (0.5 * d_i).powf(-0.6) + (0.5 * d_o).powf(-0.6);
    2.0 * (d_o / d_i).ln().powf(4.0 / 3.0) / root.powf(5.0 / 3.0)
}

/// Ratio of effective to molecular conductivity of the gas between horizontal concentric cylinders, eq. (5), from Ra on
/// [`concentric_length`] and the difference of the two surfaces.
#[inline]
pub fn concentric_cylinders(ra_c: f64, pr: f64) -> f64 {
    let (ra, pr) = limited(ra_c, pr);
    (0.386 * (pr / (0.861 + pr) * ra).sqrt().sqrt()).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;

    /// Incropera, 7th ed., example 9.5: a steam pipe of 0.1 m at 120 degC in a shield of 0.12 m at 35 degC. Air at 350 K:
    /// k 0.030, nu 20.92e-6, alpha 29.9e-6, Pr 0.70, 1/beta 350.5 K; Ra_c 171, k_eff/k 1.14, 100 W/m.
    #[test]
    fn pipe_in_a_radiation_shield_of_the_book() {
        let l = concentric_length(0.1, 0.12);
        let ra = 9.8 / 350.5 * 85.0 * l.powi(3) / (20.92e-6 * 29.9e-6);
        close(ra, 171.0, 0.01);
        let k = concentric_cylinders(ra, 0.70);
        close(k, 1.14, 0.005);
        close(2.0 * PI * 0.030 * k * 85.0 / 1.2f64.ln(), 100.0, 0.01);
    }

    /// Without circulation the result is pure conduction; the maximum of the two is continuous.
    #[test]
    fn gas_at_rest_between_cylinders_conducts() {
        assert_eq!(concentric_cylinders(0.0, 0.7), 1.0);
        assert_eq!(concentric_cylinders(-1e4, 0.7), concentric_cylinders(1e4, 0.7));
        let meets = (0.861 + 0.7) / 0.7 / 0.386f64.powi(4);
        crate::correlations::checks::continuous(|ra| concentric_cylinders(ra, 0.7), meets);
        assert!(concentric_cylinders(1.1 * meets, 0.7) > 1.0);
    }

    /// Cengel, Heat and Mass Transfer, example 9-1 (pipe of 8 cm at 70 degC in air at 20 degC): k 0.02699,
    /// Pr 0.7241, nu 1.750e-5; Ra = 1.869e6, Nu = 17.40, h = 5.869. The test fails with a power of 1/5 instead of 1/6.
    #[test]
    fn hot_pipe_of_the_book() {
        let ra = 9.81 / 318.0 * 50.0 * 0.08f64.powi(3) * 0.7241 / 1.750e-5f64.powi(2);
        close(ra, 1.869e6, 1e-3);
        close(horizontal_cylinder(ra, 0.7241), 17.40, 1e-3);
        close(horizontal_cylinder(ra, 0.7241) * 0.02699 / 0.08, 5.869, 1e-3);
    }

    /// Incropera, 7th ed., example 9.2 (glass door of a fireplace, 0.71 m): Ra = 1.813e9, Pr = 0.690, Nu =
    /// 147.
    #[test]
    fn fire_screen_of_the_book() {
        close(vertical_plate(1.813e9, 0.690), 147.0, 3e-3);
    }

    /// Ostrach's solution of the laminar layer as LeFevre interpolates it (Incropera, 7th ed., eqs. 9.20 and
    /// 9.21): Nu = 4/3 (Gr/4)^(1/4) 0.75 Pr^(1/2) / (0.609 + 1.221 Pr^(1/2) + 1.238 Pr)^(1/4). (2a) without
    /// its 0.68 within 2 %, also for water and oil; (2) in air within 18 %. The test fails with the power 1/3 in (2a).
    #[test]
    fn laminar_plate_is_ostrachs() {
        for pr in [0.71, 7.0, 100.0f64] {
            for ra in [1e4, 1e6, 1e8f64] {
                let g = 0.75 * pr.sqrt() / (0.609 + 1.221 * pr.sqrt() + 1.238 * pr).powf(0.25);
                let exact = 4.0 / 3.0 * (ra / pr / 4.0).powf(0.25) * g;
                close(vertical_plate_laminar(ra, pr) - 0.68, exact, 0.02);
                if pr < 1.0 {
                    close(vertical_plate(ra, pr), 0.68 + exact, 0.18);
                }
            }
        }
        close(vertical_plate_laminar(0.0, 0.7), 0.68, 1e-14);
    }

    #[test]
    fn conduction_is_left_without_buoyancy_and_nothing_jumps_there() {
        close(horizontal_cylinder(0.0, 0.7), 0.36, 1e-12);
        close(vertical_plate(0.0, 0.7), 0.680_625, 1e-12);
        close(horizontal_cylinder(1e-30, 0.7), 0.36, 1e-4);
        assert_eq!(horizontal_cylinder(-1e5, 0.7), horizontal_cylinder(1e5, 0.7));
    }

    /// The extra term of (3) by hand at Pr = 1: 4 * 587 / (35 * 127) = 0.52823.
    #[test]
    fn slender_cylinders_lose_more() {
        close(vertical_cylinder(1e6, 1.0, 2.0) - vertical_plate_laminar(1e6, 1.0), 2.0 * 0.528_234, 1e-5);
        assert_eq!(vertical_cylinder(1e6, 0.7, 0.0), vertical_plate_laminar(1e6, 0.7));
        assert!(is_plate_like(0.7 * 35f64.powi(4) * 1.01, 0.7, 1.0));
        assert!(!is_plate_like(0.7 * 35f64.powi(4) * 0.99, 0.7, 1.0));
    }

    #[test]
    fn disc_height_times_width_is_the_area() {
        close(end_disc_height(0.03) * 0.03, PI * 0.015 * 0.015, 1e-14);
    }

    #[test]
    fn rises_with_ra_and_is_finite_everywhere() {
        let mut last = 0.0;
        for k in 0..38 {
            let nu = horizontal_cylinder(10f64.powi(k - 8), 0.7);
            assert!(nu > last);
            last = nu;
        }
        for ra in [-1e300, 0.0, 1e300] {
            for pr in [-1.0, 0.0, 1e300] {
                assert!(
                    vertical_cylinder(ra, pr, 1e300).is_finite() && horizontal_cylinder(ra, pr).is_finite()
                );
            }
        }
    }
}
