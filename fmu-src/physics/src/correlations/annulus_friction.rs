//! Friction in a concentric annulus.
//!
//! developed, laminar: f Re = 16/phi,  phi = [(1 + a^2) ln a + 1 - a^2] / [(1 - a)^2 ln a]  (1)
//! developing: f_app Re = 3.44/s + [f Re + K/(4 x) - 3.44/s] / (1 + C/x^2),  s = sqrt(x)    (2)
//! turbulent: f = max[1/4 (1.8 lg(phi Re) - 1.5)^-2, f_app]                                 (3)
//! transition: f = (1 - g) f_app(2300) + g f(4000),  g = (Re - 2300)/1700                   (4)
//! pressure drop = 4 f L/D_h rho u^2/2 = 2 (f Re) mu u L/D_h^2                              (5)
//!
//! f is Fanning's factor, a quarter of Darcy's; a = D_i/D_o, D_h = D_o - D_i, x = L/(D_h Re).
//! f_app in (2) is the mean over the length L from a sharp entrance with uniform velocity; it includes the momentum change of the
//! profile; combine it only with the contraction loss of a uniform profile (K_d = 1, `entrance_exit.rs`). In a short duct f_app exceeds f
//! of developed turbulence, since the wall layers have not met; hence the maximum in (3).
//! *Assumes* smooth concentric walls, constant properties. *Neglects* turbulence in the wall layers (some 10
//! D_h), eccentricity (lowers f Re by up to half), rotation of the shaft's end.
//! *Sign*: (5) has the sign of u.
//! *Range*: (1) exact; a is limited to 1e-3 ... 0.999 (the limit a -> 0 is approached slowly, as ln a). (2) within 2.4 %. (3) phi Re
//! up to 1e6, here to 1e9. L/D_h below 1e-3 is set to 1e-3. Re -> 0: (1).
//! *Source*: (1) Bird, Stewart, Lightfoot, Transport Phenomena, sec. 2.4; (2) Shah, J. Fluids Eng. 100 (1978)
//! 177-179, with its table of K and C for annuli; (3) Gnielinski, VDI Heat Atlas, 2nd ed. (2010), ch. G2, eq.
//! for f_ann, after the laminar-equivalent diameter of Jones and Leung, J. Fluids Eng. 103 (1981) 615-623;
//! (4) the project's choice, as [`turbulent_share`].

use super::{RE_LAMINAR, RE_TURBULENT, turbulent_share};

/// Shah's constants: D_i/D_o, K (incremental pressure drop of the whole entrance), C.
const ENTRANCE: [[f64; 3]; 6] = [
    [0.0, 1.25, 2.12e-4],
    [0.05, 0.830, 5.0e-5],
    [0.10, 0.784, 4.3e-5],
    [0.50, 0.688, 3.2e-5],
    [0.75, 0.678, 3.0e-5],
    [1.00, 0.674, 2.9e-5],
];

/// Ratio of diameters, limited to the range of this file.
#[inline]
pub(crate) fn limited_ratio(a: f64) -> f64 {
    a.clamp(1e-3, 0.999)
}

/// Length over hydraulic diameter, limited to the range of the annulus correlations.
#[inline]
pub(crate) fn limited_length(l_over_d_h: f64) -> f64 {
    l_over_d_h.clamp(1e-3, 1e9)
}

/// Shape factor phi of eq. (1): Re phi is the Reynolds number of a tube with the same laminar friction.
/// 2/3 between plates; approaches 1 as the core vanishes.
#[inline]
pub fn shape_factor(a: f64) -> f64 {
    let a = limited_ratio(a);
    let ln = a.ln();
    ((1.0 + a * a) * ln + (1.0 - a) * (1.0 + a)) / ((1.0 - a) * (1.0 - a) * ln)
}

/// Fanning's f Re of developed laminar flow, eq. (1), at the ratio of diameters `a`.
#[inline]
pub fn laminar_f_re(a: f64) -> f64 {
    16.0 / shape_factor(a)
}

/// K and C of eq. (2), linear between the rows of the table.
fn entrance_constants(a: f64) -> (f64, f64) {
    let mut k = 0;
    while k + 2 < ENTRANCE.len() && a > ENTRANCE[k + 1][0] {
        k += 1;
    }
    let ([a0, k0, c0], [a1, k1, c1]) = (ENTRANCE[k], ENTRANCE[k + 1]);
    let s = ((a - a0) / (a1 - a0)).clamp(0.0, 1.0);
    (k0 + s * (k1 - k0), c0 + s * (c1 - c0))
}

/// Fanning's factor f of developed turbulent flow, eq. (3), from the shape factor; Re below 2300 is set to 2300.
#[inline]
pub(super) fn turbulent_f(re: f64, shape: f64) -> f64 {
    let re_star = re.abs().clamp(RE_LAMINAR, 1e9) * shape;
    let root = 1.8 * re_star.log10() - 1.5;
    0.25 / (root * root)
}

/// Friction over the length of one annulus: values that depend on geometry only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// D_h/L
    per_length: f64,
    shape: f64,
    /// f Re of eq. (1)
    developed: f64,
    /// K and C of eq. (2)
    entrance: (f64, f64),
    /// f at the ends of the transition, eq. (4)
    transition: [f64; 2],
}

impl Friction {
    /// Over the first `l_over_d_h` hydraulic diameters at the ratio of diameters `a`.
    pub fn new(a: f64, l_over_d_h: f64) -> Friction {
        let mut friction = Friction {
            per_length: 1.0 / limited_length(l_over_d_h),
            shape: shape_factor(a),
            developed: laminar_f_re(a),
            entrance: entrance_constants(limited_ratio(a)),
            transition: [0.0; 2],
        };
        let laminar = friction.laminar(RE_LAMINAR) / RE_LAMINAR;
        friction.transition = [laminar, friction.turbulent(RE_TURBULENT) / RE_TURBULENT];
        friction
    }

    /// Apparent f Re of laminar flow, eq. (2).
    #[inline]
    pub fn laminar(&self, re: f64) -> f64 {
        let (k, c) = self.entrance;
        // 1/x: one division for all terms.
        let z = re.abs().clamp(1e-9, 1e9) * self.per_length;
        let steep = 3.44 * z.sqrt();
        steep + (self.developed + 0.25 * k * z - steep) / (1.0 + c * z * z)
    }

    /// f Re of turbulent flow, eq. (3).
    fn turbulent(&self, re: f64) -> f64 {
        (turbulent_f(re, self.shape) * re).max(self.laminar(re))
    }

    /// f Re at any Reynolds number, eqs. (2) to (4). The product remains finite at zero flow.
    #[inline]
    pub fn f_re(&self, re: f64) -> f64 {
        let re = re.abs().min(1e9);
        let share = turbulent_share(re);
        if share == 0.0 {
            self.laminar(re)
        } else if share == 1.0 {
            self.turbulent(re)
        } else {
            let [laminar, turbulent] = self.transition;
            (laminar + share * (turbulent - laminar)) * re
        }
    }
}

/// Pressure drop by friction, eq. (5), Pa: viscosity `mu` in Pa.s, mean speed `u` in m/s, `length` and
/// hydraulic diameter `d_h` in m.
#[inline]
pub fn pressure_drop(f_re: f64, mu: f64, u: f64, length: f64, d_h: f64) -> f64 {
    let d_h = d_h.max(1e-9);
    2.0 * f_re * mu * u * length / (d_h * d_h)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::{close, continuous, rows};

    const LAMINAR: &str = include_str!("../../tests/data/annulus-laminar/annulus_laminar_computed.csv");

    /// Comparison with the numerical solution in `tests/data/annulus-laminar`.
    #[test]
    fn laminar_closed_form_is_the_numerical_solution() {
        for row in rows(LAMINAR) {
            close(laminar_f_re(row[0]), row[5], 1e-5);
        }
    }

    /// Plates: 24 (Incropera, 7th ed., table 8.1: Darcy 96). The tube's 16 is approached slowly.
    #[test]
    fn limits_of_the_shape() {
        close(laminar_f_re(0.999), 24.0, 1e-5);
        close(laminar_f_re(0.01), 20.03, 1e-3);
        assert!(laminar_f_re(0.001) > 16.0 && laminar_f_re(0.001) < laminar_f_re(0.01));
    }

    /// Entrance region: the displacement thickness of Blasius's boundary layer is 1.7208 sqrt(nu x/u); the core accelerates and the
    /// pressure drops by f_app Re = 2 * 1.7208/sqrt(x). The test fails with a cube root in (2).
    #[test]
    fn short_duct_has_the_boundary_layer_of_blasius() {
        let (re, length) = (2000.0, 0.002);
        let x: f64 = length / re;
        close(Friction::new(0.75, length).laminar(re), 2.0 * 1.7208 / x.sqrt(), 2e-3);
    }

    /// Far downstream f Re grows by K/(4 x): K = 0.674 between plates, 0.688 at a = 0.5 (Shah's table).
    #[test]
    fn long_duct_is_developed_flow_and_its_entrance() {
        for (a, k) in [(0.999, 0.674), (0.5, 0.688)] {
            let (re, length) = (100.0, 1000.0);
            let x = length / re;
            close((Friction::new(a, length).laminar(re) - laminar_f_re(a)) * 4.0 * x, k, 2e-2);
        }
        close(Friction::new(0.6, 6.4).f_re(0.0), laminar_f_re(0.6), 1e-9);
    }

    /// Between plates Dean's fit of measurements, f = 0.073 (u h/nu)^(-1/4), h the gap (J. Fluids Eng. 100
    /// (1978) 215-223): independent of (3), within 3 % from 1e4 to 2e5.
    #[test]
    fn turbulent_between_plates_as_measured() {
        for re in [1e4, 3e4, 1e5, 2e5f64] {
            close(turbulent_f(re, shape_factor(0.999)), 0.073 * (re / 2.0).powf(-0.25), 0.03);
        }
    }

    #[test]
    fn nothing_jumps_at_any_switch() {
        for a in [0.3, 0.75, 0.857] {
            for length in [2.0, 6.4, 13.0, 100.0] {
                continuous(|re| Friction::new(a, length).f_re(re), RE_LAMINAR);
                continuous(|re| Friction::new(a, length).f_re(re), RE_TURBULENT);
            }
        }
        for row in ENTRANCE {
            continuous(|a| Friction::new(a, 10.0).f_re(500.0), row[0]);
        }
        continuous(|a| Friction::new(a, 10.0).f_re(500.0), 0.999);
    }

    /// The pressure drop increases monotonically with the flow.
    #[test]
    fn pressure_drop_rises_with_the_flow() {
        for a in [0.1, 0.5, 0.75, 0.9] {
            for length in [2.0, 6.4, 20.0, 200.0] {
                let mut last = 0.0;
                for k in 1..400 {
                    let re = 25.0 * f64::from(k);
                    let drop = pressure_drop(Friction::new(a, length).f_re(re), 1.8e-5, re, 1.0, 1.0);
                    assert!(drop > last, "a {a}, L/D_h {length}, Re {re}");
                    last = drop;
                }
            }
        }
    }

    /// (5) by hand: f Re 24, 1.8e-5 Pa.s, 5 m/s, 64 mm, gap 5 mm: 48 * 1.8e-5 * 5 * 0.064/1e-4 = 2.7648 Pa.
    #[test]
    fn pressure_drop_by_hand_and_its_sign() {
        close(pressure_drop(24.0, 1.8e-5, 5.0, 0.064, 0.01), 2.7648, 1e-12);
        assert_eq!(
            pressure_drop(24.0, 1.8e-5, -5.0, 0.064, 0.01),
            -pressure_drop(24.0, 1.8e-5, 5.0, 0.064, 0.01)
        );
    }

    #[test]
    fn finite_for_any_finite_number() {
        for re in [-1e300, 0.0, 1e-300, 3000.0, 1e300] {
            for a in [-1.0, 0.0, 0.5, 1.0, 1e300] {
                for length in [-1.0, 0.0, 1e300] {
                    let f = Friction::new(a, length).f_re(re);
                    assert!(f.is_finite() && f > 0.0, "{re} {a} {length}: {f}");
                }
            }
        }
    }
}
