//! Flow through a tube: heat transfer at a wall of uniform temperature and pressure drop, laminar to turbulent.
//!
//! laminar    Nu^3 = 3.66^3 + 0.7^3 + (1.615 Gz^(1/3) - 0.7)^3 + [(2/(1 + 22 Pr))^(1/6) Gz^(1/2)]^3,   Gz = Re Pr d/l  (1)
//! turbulent  Nu = (f/8) (Re - 1000) Pr / [1 + 12.7 (f/8)^(1/2) (Pr^(2/3) - 1)] [1 + (d/l)^(2/3)]                      (2)
//!            f = (1.8 log10 Re - 1.5)^-2                                                                             (3)
//! transition Nu = (1 - g) Nu_laminar(2300) + g Nu_turbulent(4000),   g = (Re - 2300)/1700                            (4)
//! friction   f = 64/Re laminar, (3) turbulent, between as (4)                                                        (5)
//!
//! All Nu are means over the length. (1): velocity and temperature profiles develop together from the inlet.
//! *Assumes* a smooth tube, properties at the mean bulk temperature. *Neglects* the viscosity change at the wall (a few per cent in water
//! for 20 K), natural convection in the tube, curvature, the friction of the developing flow.
//! *Range*: (1) all Re below 2300; (2) 4000 to 1e6, 0.5 < Pr < 1000, d/l <= 1. Re < 0 is set to |Re|, above 1e6 to 1e6; d/l above
//! 1 to 1. Scatter of the data +-10 %, larger in the transition.
//! *Source*: (1) Gnielinski, VDI Heat Atlas, 2nd ed., G1, eqs. 3 to 13; (2) to (4) Gnielinski, Int. J. Heat Mass Transfer 63
//! (2013) 134-140; (3) Konakov (1946), as there; (5) Hagen and Poiseuille.

use super::{RE_LAMINAR, RE_TURBULENT, turbulent_share};

/// Mean Nusselt number on the diameter at `re`, `pr` and diameter over length, eqs. (1), (2), (4).
pub fn nusselt(re: f64, pr: f64, d_over_l: f64) -> f64 {
    let (re, d_over_l) = (re.abs().min(1e6), d_over_l.clamp(0.0, 1.0));
    let share = turbulent_share(re);
    let slow = if share < 1.0 { laminar(re.min(RE_LAMINAR), pr, d_over_l) } else { 0.0 };
    let fast = if share > 0.0 { turbulent(re.max(RE_TURBULENT), pr, d_over_l) } else { 0.0 };
    (1.0 - share) * slow + share * fast
}

fn laminar(re: f64, pr: f64, d_over_l: f64) -> f64 {
    let gz = re * pr * d_over_l;
    let thermal = 1.615 * gz.cbrt() - 0.7;
    let velocity = (2.0 / (1.0 + 22.0 * pr)).powf(1.0 / 6.0) * gz.sqrt();
    (3.66f64.powi(3) + 0.7f64.powi(3) + thermal.powi(3) + velocity.powi(3)).cbrt()
}

fn turbulent(re: f64, pr: f64, d_over_l: f64) -> f64 {
    let eighth = konakov(re) / 8.0;
    let developed = eighth * (re - 1000.0) * pr / (1.0 + 12.7 * eighth.sqrt() * (pr.powf(2.0 / 3.0) - 1.0));
    developed * (1.0 + d_over_l.powf(2.0 / 3.0))
}

fn konakov(re: f64) -> f64 {
    (1.8 * re.log10() - 1.5).powi(-2)
}

/// Friction factor times Reynolds number, eq. (5): 64 up to Re = 2300, so that it is finite at rest.
pub fn friction_times_re(re: f64) -> f64 {
    let re = re.abs().min(1e6);
    let share = turbulent_share(re);
    if share == 0.0 {
        return 64.0;
    }
    let slow = 64.0 / RE_LAMINAR;
    re * ((1.0 - share) * slow + share * konakov(re.max(RE_TURBULENT)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::{close, continuous};

    /// By hand: Re = 1e4, Pr = 6, d/l = 0.05: f = (7.2 - 1.5)^-2 = 0.030779; f/8 = 0.0038473, root 0.062027;
    /// 0.0038473 9000 6 / (1 + 12.7 0.062027 2.30193) = 207.756/2.81331 = 73.847; times 1 + 0.135721.
    #[test]
    fn turbulent_by_hand() {
        close(nusselt(1e4, 6.0, 0.05), 73.847 * 1.135_721, 1e-4);
        close(friction_times_re(1e4), 307.79, 1e-4);
    }

    /// By hand: Re = 1000, Pr = 6, l = 60 d: Gz = 100; 1.615 4.64159 - 0.7 = 6.79617; (2/133)^(1/6) 10 = 4.96815;
    /// 49.371 + 313.90 + 122.63 = 485.90, cube root 7.8616.
    #[test]
    fn laminar_by_hand() {
        close(nusselt(1000.0, 6.0, 1.0 / 60.0), 7.8616, 1e-4);
    }

    /// Incropera, 7th ed., eq. 8.57 (Hausen): a developing temperature profile in developed flow; (1) approaches it for Pr -> infinity.
    #[test]
    fn the_book_of_the_entrance() {
        for gz in [5.0, 20.0, 100.0] {
            let book = 3.66 + 0.0668 * gz / (1.0 + 0.04 * f64::powf(gz, 2.0 / 3.0));
            let pr = 1e9;
            close(nusselt(gz / pr / 0.01, pr, 0.01), book, 0.06);
        }
    }

    /// Incropera, eq. 8.60 (Dittus and Boelter), scatter of the data 25 %, and the smooth tube of the Moody chart.
    #[test]
    fn the_book_of_turbulence() {
        for (re, pr) in [(2e4, 1.0f64), (1e5, 6.0), (5e5, 3.0)] {
            close(nusselt(re, pr, 0.0), 0.023 * f64::powf(re, 0.8) * pr.powf(0.4), 0.25);
        }
        for (re, moody) in [(1e4, 0.0309), (1e5, 0.0180), (1e6, 0.01165)] {
            close(friction_times_re(re) / re, moody, 0.02);
        }
    }

    #[test]
    fn limits_and_switches() {
        close(nusselt(0.0, 6.0, 0.05), 3.66, 1e-9);
        close(nusselt(1.0, 6.0, 0.0), 3.66, 1e-9);
        assert!(nusselt(f64::INFINITY, 6.0, 2.0).is_finite() && friction_times_re(1e300).is_finite());
        for (pr, d_over_l) in [(0.7, 0.01), (6.0, 0.05), (12.0, 0.1)] {
            let mut last = 0.0;
            for k in 0..200 {
                let now = nusselt(100.0 * f64::from(k), pr, d_over_l);
                assert!(now > last, "Nu grows with Re");
                last = now;
            }
            for re in [RE_LAMINAR, RE_TURBULENT] {
                continuous(|re| nusselt(re, pr, d_over_l), re);
                continuous(friction_times_re, re);
            }
        }
    }
}
