//! Heat transfer from the inner wall of a concentric annulus to the air in it, with an insulated outer wall.
//!
//! developed, laminar, uniform flux: Nu_1 = 2 (1 - a) / [a int_a^1 F^2/y dy]                (1)
//! developed, laminar, uniform temperature: Nu_1 = 3.66 + 1.2 a^(-0.8)                      (2)
//! mean over L, laminar: Nu = (Nu_1^3 + Nu_2^3 + Nu_3^3)^(1/3)                              (3)
//!     Nu_2 = 1.615 (1 + 0.14 a^(-1/2)) Gz^(1/3),  Nu_3 = [2/(1 + 22 Pr)]^(1/6) Gz^(1/2)    (4)
//! turbulent: Nu = (f/8) Re Pr [1 + (D_h/L)^(2/3)] F / [k_1 + 12.7 (f/8)^(1/2) (Pr^(2/3) - 1)]   (5)
//!     k_1 = 1.07 + 900/Re - 0.63/(1 + 10 Pr),  F = 0.75 a^(-0.17)
//! transition: Nu = (1 - g) Nu_laminar(2300) + g Nu_turbulent(4000),  g = (Re - 2300)/1700  (6)
//!
//! a = D_i/D_o, D_h = D_o - D_i, Nu = h D_h/k, Gz = Re Pr D_h/L, f Darcy's factor (`annulus_friction.rs`), h based on the difference
//! of wall and bulk temperature. F(y) in (1) is the fraction of the flow outside the radius y r_o; (1) follows from integrating the energy
//! equation twice. Nu_3 applies when flow and heating start together. For uniform flux Nu_2 has the factor of Leveque,
//! 2 pi/(3 sqrt 3) = 1.209, and Nu_3 that of the flat plate, 0.453/0.332 = 1.364. A metal housing is between the two conditions, closer to
//! uniform temperature.
//! *Assumes* smooth concentric walls, properties at the mean temperature of the air.
//! *Neglects* natural convection in the gap, swirl and turbulence from the fan (raise Nu), and the gas property
//! correction (T/T_w)^0.45 in (5) (some 5 % at a wall 40 K above the air).
//! *Range*: a 0.02 to 0.999, limited to this range ((2) within 4 % of exact values from 0.05 on); (3), (4) Pr 0.1 to 1000, Re <= 2300;
//! (5) Re 4000 to 1e6, Pr 0.6 to 1000. L/D_h below 1e-3 is set to 1e-3, Re above 1e7 to 1e7, Pr is limited to 0.1 ... 1e3. Zero
//! flow gives Nu_1. In a duct shorter than about 10 D_h, (6) can decrease with Re: the laminar entrance then gives more at 2300 than (5) at
//! 4000 (one part in 10^4 at L/D_h = 10, uniform flux).
//! *Source*: (1) derived here; (2) to (4) Martin and Gnielinski, VDI Heat Atlas, 2nd ed. (2010), ch. G2; (5)
//! Gnielinski, ibid. and Heat Transfer Eng. 30 (2009) 431; (6) Gnielinski, Int. J. Heat Mass Transfer 63
//! (2013) 134-140; factors of uniform flux: Shah and London (1978), and Incropera, 7th ed., eqs. 7.23 and
//! 7.45.

use super::annulus_friction::{limited_length, shape_factor, turbulent_f};
use super::{RE_LAMINAR, RE_TURBULENT, turbulent_share};
use std::f64::consts::PI;

/// Thermal boundary condition of the inner wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// Uniform temperature along the wall
    UniformTemperature,
    /// Uniform heat flux along the wall
    UniformFlux,
}

/// Velocity profile at the start of the heated length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// Uniform profile: velocity and temperature develop together
    Developing,
    /// Developed laminar profile: only the temperature develops
    Developed,
}

/// Ratio of diameters, limited to the range of this file.
#[inline]
fn limited_ratio(a: f64) -> f64 {
    a.clamp(0.02, 0.999)
}

/// Nu of developed laminar flow with uniform flux at the inner wall, eq. (1). About forty exponentials:
/// evaluate it only when the geometry changes.
pub fn laminar_uniform_flux(a: f64) -> f64 {
    let a = limited_ratio(a);
    let ln = a.ln();
    let b = (a - 1.0) * (a + 1.0) / ln;
    let scale = 2.0 / ((1.0 - a) * (1.0 + a) * (1.0 + a * a - b));
    // int F^2/y dy = int F^2 dt with t = ln y: smooth, so that Simpson's rule gives 7 digits.
    let share_squared = |t: f64| {
        let y2 = (2.0 * t).exp();
        let m = 1.0 - y2;
        let share = scale * (0.5 * m * m - b * (0.5 * m + y2 * t));
        share * share
    };
    const PAIRS: i32 = 20;
    let h = -ln / f64::from(2 * PAIRS);
    let mut sum = 1.0 + share_squared(0.0);
    for k in 1..2 * PAIRS {
        let weight = if k % 2 == 1 { 4.0 } else { 2.0 };
        sum += weight * share_squared(ln + f64::from(k) * h);
    }
    2.0 * (1.0 - a) / (a * sum * h / 3.0)
}

/// Nu of developed laminar flow with uniform temperature of the inner wall, eq. (2).
#[inline]
pub fn laminar_uniform_temperature(a: f64) -> f64 {
    3.66 + 1.2 * limited_ratio(a).powf(-0.8)
}

/// An annulus heated at the inner wall: values that depend on geometry only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatedAnnulus {
    /// Shape factor of the friction
    friction: f64,
    /// Nu_1^3
    developed: f64,
    /// Nu_2^3/Gz
    thermal: f64,
    /// Factor of Nu_3^3
    hydrodynamic: f64,
    /// F in (5)
    shape: f64,
}

impl HeatedAnnulus {
    /// The annulus of the ratio of diameters `a` = D_i/D_o.
    pub fn new(a: f64, wall: Wall, entry: Entry) -> Self {
        let ratio = limited_ratio(a);
        let cube = |x: f64| x * x * x;
        let (developed, leveque, plate) = match wall {
            Wall::UniformTemperature => (laminar_uniform_temperature(ratio), 1.0, 1.0),
            Wall::UniformFlux => (laminar_uniform_flux(ratio), 2.0 * PI / 27f64.sqrt(), 0.453 / 0.332),
        };
        Self {
            friction: shape_factor(ratio),
            developed: cube(developed),
            thermal: cube(1.615 * (1.0 + 0.14 / ratio.sqrt()) * leveque),
            hydrodynamic: if entry == Entry::Developing { cube(plate) } else { 0.0 },
            shape: 0.75 * ratio.powf(-0.17),
        }
    }

    /// Nu_1: developed laminar flow, and zero flow.
    #[inline]
    pub fn nu_developed(&self) -> f64 {
        self.developed.cbrt()
    }

    /// Nu_2^3 and Nu_3^3 of eq. (4).
    #[inline]
    fn entrance(&self, re: f64, pr: f64, l: f64) -> (f64, f64) {
        let gz = re * pr / l;
        (self.thermal * gz, self.hydrodynamic * (2.0 / (1.0 + 22.0 * pr)).sqrt() * gz * gz.sqrt())
    }

    /// Eq. (5) without its entrance factor.
    #[inline]
    fn turbulent(&self, re: f64, pr: f64) -> f64 {
        // Darcy's f / 8 is Fanning's f / 2.
        let f = 0.5 * turbulent_f(re, self.friction);
        let k1 = 1.07 + 900.0 / re - 0.63 / (1.0 + 10.0 * pr);
        f * re * pr * self.shape / (k1 + 12.7 * f.sqrt() * (pr.cbrt() * pr.cbrt() - 1.0))
    }

    /// Nu in any regime from the laminar law and the turbulent entrance factor at this length.
    #[inline]
    fn regimes(&self, re: f64, pr: f64, laminar: impl Fn(f64) -> f64, entrance: impl Fn() -> f64) -> f64 {
        let share = turbulent_share(re);
        if share == 0.0 {
            laminar(re)
        } else {
            let turbulent = self.turbulent(re.max(RE_TURBULENT), pr) * (1.0 + entrance());
            if share == 1.0 {
                turbulent
            } else {
                let at_limit = laminar(RE_LAMINAR);
                at_limit + share * (turbulent - at_limit)
            }
        }
    }

    /// Mean Nu over the first `l_over_d_h` hydraulic diameters, eqs. (3), (5), (6).
    pub fn mean(&self, re: f64, pr: f64, l_over_d_h: f64) -> f64 {
        let (re, pr, l) = limited(re, pr, l_over_d_h);
        let laminar = |re| {
            let (n2, n3) = self.entrance(re, pr, l);
            (self.developed + n2 + n3).cbrt()
        };
        self.regimes(re, pr, laminar, || l.cbrt().powi(-2))
    }

    /// x Nu with the mean Nu over the first `x_over_d_h` = x hydraulic diameters: its difference between two positions is what the length
    /// between them contributes, and the segments' contributions add to that of the whole.
    #[inline]
    pub fn integral(&self, re: f64, pr: f64, x_over_d_h: f64) -> f64 {
        x_over_d_h * self.mean(re, pr, x_over_d_h)
    }
}

/// Arguments limited to the range of the correlations.
#[inline]
fn limited(re: f64, pr: f64, l: f64) -> (f64, f64, f64) {
    (re.abs().min(1e7), pr.clamp(0.1, 1e3), limited_length(l))
}

#[cfg(test)]
#[path = "annulus_heat_transfer_tests.rs"]
mod tests;
