//! The thesis's model of the annulus as published, including its errors, with the corrections.
//!
//! u = V/(60 A),  A = pi (r_m^2/r*^2 - r_m^2),  Re = 2 u (r_o - r_m)/nu                     eqs. (13), (14), (17)
//! p = rho u^2/2 [(K_c + 1 - sigma^2) + 4 f L/D_h - (1 - sigma^2 - K_e)]                    eq. (15)
//! h = C Pr^(1/3) k/x Re^m,  C = 0.332, m = 1/2 laminar; C = 0.0296, m = 4/5 turbulent      eqs. (11), (12), (18)
//! T_w = T_a + P (1/(h A) - R_wh)                                                           eq. (10), its sign
//!
//! Re in the plate's law is that of the duct, which is the published mistake that puts the optimum at max Re.
//! Values that the thesis does not state are chosen to reproduce its figures: air at 300 K; friction of parallel
//! plates (24/Re, Blasius 0.079 Re^-1/4 where that is more); sigma is annulus over disc; the mean of 1/x over
//! a grid of 1 mm; the switch from laminar to turbulent at Re = 4000. With the local Reynolds number, `u x/nu`,
//! the mean would be twice the value at the end, and the optimum another.
//! *Source*: the thesis, chapter 5; figure 5-3 of Kays and London by Kays' formulas (`physics`,
//! `entrance_exit.rs`) with the contraction 0.617 at sigma = 0, so that K_c(0) = 0.785 and 0.385 (audit, T36).

use super::measured::{FAN_FLOW, FAN_PRESSURE, MOTOR_DIAMETER, MOTOR_LENGTH, POWER, R_WH, T_AMBIENT};
use crate::numeric::{maximum, root};
use physics::correlations::entrance_exit::{contraction_ratio, expansion};
use std::f64::consts::PI;

/// Density of air at 300 K, kg/m3 (Incropera, table A.4).
const RHO: f64 = 1.1614;
/// Kinematic viscosity of air at 300 K, m2/s (as above).
const NU: f64 = 15.89e-6;
/// Conductivity of air, W/(m.K), rounded. The text says that of the housing, some 16: audit, T32.
pub const K_AIR: f64 = 0.026;
/// Prandtl number, as published.
const PR: f64 = 0.7;
/// Step of the grid over the motor's length on which 1/x is averaged, m.
const GRID: f64 = 1e-3;
/// Contraction of the jet at sigma = 0 that gives K_c(0) = 0.785 and 0.385.
const CONTRACTION: f64 = 0.617;
/// Reynolds number of the switch in the figures. Any value between Re(0.75) and the greatest Re leaves both
/// tested annuli on the laminar branch with two jumps between: audit, T40.
pub const RE_SWITCH: f64 = 4000.0;
/// Constant and exponent of the laminar plate, eq. (11).
pub const LAMINAR: (f64, f64) = (0.332, 0.5);
/// Constant and exponent of the turbulent plate, eq. (12).
pub const TURBULENT: (f64, f64) = (0.0296, 0.8);
/// Constant and exponent of the turbulent plate as eq. (19) prints it: the laminar constant.
pub const TURBULENT_AS_PUBLISHED: (f64, f64) = (0.332, 0.8);
/// Ratio of radii of the thesis's grid: from a wide annulus to a narrow one.
pub const R_STAR: (f64, f64) = (0.2, 0.97);

/// The annulus at a ratio of radii r* = r_mot/r_o.
#[derive(Clone, Copy, Debug)]
pub struct Annulus {
    r_star: f64,
}

impl Annulus {
    /// The annulus of this ratio of radii, between 0 and 1.
    pub fn new(r_star: f64) -> Annulus {
        Annulus { r_star }
    }

    /// Free area, m2: between the radii, eq. (13).
    fn area(self) -> f64 {
        let r = 0.5 * MOTOR_DIAMETER;
        PI * r * r * (1.0 / (self.r_star * self.r_star) - 1.0)
    }

    /// Hydraulic diameter, m, eq. (14): twice the gap.
    fn d_h(self) -> f64 {
        MOTOR_DIAMETER * (1.0 / self.r_star - 1.0)
    }

    /// Reynolds number on the hydraulic diameter at a flow in m3/s, eqs. (14) and (17).
    pub fn reynolds_at(self, flow: f64) -> f64 {
        flow / self.area() * self.d_h() / NU
    }

    /// Pressure drop, Pa, eq. (15), at a flow in m3/s; K_c and K_e by the stepwise rule of the text at the
    /// Reynolds number of the rated flow.
    pub fn pressure_drop(self, flow: f64) -> f64 {
        let sigma = 1.0 - self.r_star * self.r_star;
        let k_d = profile(self.reynolds_at(FAN_FLOW));
        let u = flow / self.area();
        let re = self.reynolds_at(flow).max(1e-9);
        let friction = (24.0 / re).max(0.079 * re.powf(-0.25)) * 4.0 * MOTOR_LENGTH / self.d_h();
        let entrance = k_c(sigma, k_d) + 1.0 - sigma * sigma;
        let exit = 1.0 - sigma * sigma - expansion(sigma, k_d);
        0.5 * RHO * u * u * (entrance + friction - exit)
    }

    /// Flow where the drop meets the straight fan curve, m3/s; figure 14.
    pub fn flow(self) -> f64 {
        let excess = |flow: f64| self.pressure_drop(flow) - fan_pressure(flow);
        root(excess, 1e-9 * FAN_FLOW, FAN_FLOW, 1e-9 * FAN_FLOW).unwrap_or(FAN_FLOW)
    }

    /// Reynolds number at the operating point; figure 18.
    pub fn reynolds(self) -> f64 {
        self.reynolds_at(self.flow())
    }

    /// Winding temperature, K, by a law of the plate, with the sign of eq. (10).
    pub fn winding_temperature_by(self, law: (f64, f64)) -> f64 {
        T_AMBIENT + POWER * (resistance(self.reynolds(), law) - R_WH)
    }

    /// The same with the corrected sign.
    pub fn winding_temperature_right_sign(self, law: (f64, f64)) -> f64 {
        T_AMBIENT + POWER * (resistance(self.reynolds(), law) + R_WH)
    }

    /// Winding temperature, K, as in figures 15 and 17: the law switches at [`RE_SWITCH`].
    pub fn winding_temperature(self) -> f64 {
        self.winding_temperature_by(law_at(self.reynolds()))
    }
}

/// The correlation that the text uses at a Reynolds number.
fn law_at(re: f64) -> (f64, f64) {
    if re < RE_SWITCH { LAMINAR } else { TURBULENT }
}

/// 1/(h A) of the housing, K/W, by a law of the plate at the Reynolds number `re`.
pub fn resistance(re: f64, law: (f64, f64)) -> f64 {
    resistance_with(re, law, K_AIR)
}

/// The same with another conductivity, W/(m.K).
pub fn resistance_with(re: f64, (c, m): (f64, f64), k: f64) -> f64 {
    let h = c * PR.cbrt() * k / MOTOR_LENGTH * re.powf(m) * mean_of_l_over_x();
    1.0 / (h * PI * MOTOR_DIAMETER * MOTOR_LENGTH)
}

/// Mean of L/x over the grid: the 64th harmonic number, 4.74. It grows without limit as the grid gets finer.
pub fn mean_of_l_over_x() -> f64 {
    let n = (MOTOR_LENGTH / GRID).round() as u32;
    (1..=n).map(|k| 1.0 / f64::from(k)).sum()
}

/// The fan's curve between the end points of its data sheet, Pa at m3/s.
pub fn fan_pressure(flow: f64) -> f64 {
    FAN_PRESSURE * (1.0 - flow / FAN_FLOW)
}

/// Ratio of momentum of the curve that the text picks: Re 2000, 1e4 or infinity.
fn profile(re: f64) -> f64 {
    match re {
        re if re <= 2000.0 => 1.2,
        re if re <= 1e4 => 1.04,
        _ => 1.0,
    }
}

/// Loss of the contraction, read from figure 5-3.
pub fn k_c(sigma: f64, k_d: f64) -> f64 {
    let c = 1.0 - (1.0 - contraction_ratio(sigma)) * (1.0 - CONTRACTION) / (1.0 - contraction_ratio(0.0));
    (1.0 / c - 2.0) / c + 2.0 * k_d - 1.0
}

/// The ratio of radii with the greatest Reynolds number, and that number: figure 18's summit.
pub fn summit() -> (f64, f64) {
    let r_star = maximum(|r| Annulus::new(r).reynolds(), 0.4, 0.8, 1e-5);
    (r_star, Annulus::new(r_star).reynolds())
}

/// The two ratios of radii at which Re passes `re`, and the curve of figure 15 jumps if the switch is there.
pub fn jumps(re: f64) -> Option<(f64, f64)> {
    let top = summit().0;
    let passes = |r: f64| Annulus::new(r).reynolds() - re;
    Some((root(passes, R_STAR.0, top, 1e-7)?, root(passes, top, R_STAR.1, 1e-7)?))
}

#[cfg(test)]
mod tests {
    use super::super::measured::{NARROW, WIDE};
    use super::*;
    use crate::reproduce::near;

    /// The audit's independent model (Python): T36, T39, T40, T41, T42.
    #[test]
    fn the_published_curve_comes_out() {
        near(k_c(0.0, 1.2), 0.785, 1e-3);
        near(k_c(0.0, 1.0), 0.385, 1e-3);
        near(mean_of_l_over_x(), 4.74, 5e-3);
        let (r_star, re) = summit();
        near(r_star, 0.626, 0.01);
        near(re, 4450.0, 45.0);
        near(Annulus::new(WIDE).reynolds(), 3805.0, 40.0);
        near(Annulus::new(WIDE).winding_temperature(), 343.1, 1.0);
        near(Annulus::new(NARROW).winding_temperature(), 358.3, 1.0);
        near(Annulus::new(0.63).winding_temperature_by(TURBULENT_AS_PUBLISHED), 299.3, 0.3);
        near(Annulus::new(0.63).winding_temperature_by(TURBULENT), 335.3, 0.5);
        let (left, right) = jumps(RE_SWITCH).unwrap();
        near(left, 0.48, 0.01);
        near(right, 0.73, 0.01);
        let (left, right) = jumps(2300.0).unwrap();
        near(left, 0.23, 0.02);
        near(right, 0.85, 0.01);
    }

    /// T30: the sign moves the winding by 2 P R_wh.
    #[test]
    fn the_sign_is_worth_four_kelvin() {
        let annulus = Annulus::new(WIDE);
        let moved = annulus.winding_temperature_right_sign(LAMINAR) - annulus.winding_temperature_by(LAMINAR);
        assert!((moved - 4.2).abs() < 1e-9);
    }

    /// The operating point is on both curves.
    #[test]
    fn flow_balances() {
        for r_star in [0.3, 0.63, 0.9] {
            let annulus = Annulus::new(r_star);
            let flow = annulus.flow();
            assert!((annulus.pressure_drop(flow) - fan_pressure(flow)).abs() < 1e-3);
        }
    }
}
