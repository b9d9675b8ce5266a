//! A reduction gear, referred to its output shaft.
//!
//! K = k_t ratio,   J_out = J ratio^2                                                       (1)
//! tau_drag = tau_c tanh(w / w_small) + k v w + (1/efficiency - 1) |tau_load| sign(w)       (2)
//! v = exp[B (1/T_g - 1/T_ref)]                                                             (3)
//!
//! Air-gap torque times ratio is K I, before any loss, so K is also the back-EMF constant at the output shaft. The efficiency belongs
//! to the drag, not to K; otherwise the energy balance would not close. The first two terms are the losses without load (brushes,
//! bearings, gear), the third is the additional loss under load. A driving load is transmitted with the efficiency 2 - 1/efficiency, and
//! is blocked if efficiency is below one half.
//! (3) is the viscosity of the grease at the gear's temperature over that at T_ref, to which viscous friction is proportional. An oil
//! of ISO VG 100 has 100 mm2/s at 40 degC and 11 mm2/s at 100 degC: B = 4300 K. B = 0: friction does not depend on temperature.
//! *Range* of (3): 50 K on both sides of T_ref, above the pour point (far below T_ref oils thicken faster); T_g >= 150 K.
//! *Assumes* a stiff gear without backlash. *Neglects* breakaway: below w_small the shaft creeps.
//! *Sign*: drag against the motion; its power tau_drag w >= 0 heats the housing.
//! *Source*: (3) Andrade, Nature 125 (1930) 309-310; oil: ISO 3448, ISO 2909 at a viscosity index of 95. Regularised Coulomb law:
//! Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083; load-dependent term as in the Modelica Standard Library,
//! Rotational.Components.LossyGear.

use crate::number::{Number, smooth_sign};
use declare::{Unit, Variable, variables};

variables! {
    /// The gear and the friction that it shows at its output shaft.
    pub struct Gear {
        /// Gear ratio: turns of the rotor for one turn of the output shaft
        ratio: f64 = Variable::tunable(0, 131.0, Unit::One, 1.0, 1e5).log()
            .source("paper on the gearmotor 37D"),
        /// Efficiency of the gear with a driven load, without the no-load friction
        efficiency: f64 = Variable::tunable(1, 0.73, Unit::One, 0.05, 1.0)
            .source("estimate: three stages at 0.9"),
        /// Dry friction of motor and gear at the output shaft
        tau_c: f64 = Variable::tunable(2, 0.0769, Unit::NewtonMetre, 0.0, 1e4)
            .source("fitted to the currents of the paper on the gearmotor 37D at 20 and 100 % duty"),
        /// Viscous friction of motor and gear at the output shaft
        k: f64 = Variable::tunable(3, 0.01267, Unit::NewtonMetreSecond, 0.0, 1e4)
            .source("fitted to the currents of the paper on the gearmotor 37D at 20 and 100 % duty"),
        /// Speed of the output shaft below which dry friction goes smoothly to zero
        w_small: f64 = Variable::tunable(4, 0.02, Unit::RadianPerSecond, 1e-6, 1e3).log()
            .source("regularisation width, chosen"),
        /// Load torque below which load-dependent friction falls with its square
        tau_small: f64 = Variable::tunable(5, 1e-3, Unit::NewtonMetre, 1e-9, 10.0).log()
            .source("regularisation width, chosen"),
        /// Temperature coefficient B of the grease's viscosity, Andrade's law; 0 = friction does not depend on temperature
        B: f64 = Variable::tunable(6, 0.0, Unit::Kelvin, 0.0, 2e4).nominal(1e3).difference()
            .source("neutral"),
        /// Temperature of the gear to which k refers
        T_ref: f64 = Variable::tunable(7, 293.15, Unit::Kelvin, 173.15, 473.15)
            .source("paper on the gearmotor 37D: 20 degC"),
    }
}

/// Lowest temperature of the viscosity law, K.
const COLDEST: f64 = 150.0;

impl Gear {
    /// Viscosity ratio of the grease, at `t`, K, to T_ref, eq. (3).
    #[inline]
    pub fn viscosity(&self, t: f64) -> f64 {
        if self.B == 0.0 { 1.0 } else { (self.B * (1.0 / t.max(COLDEST) - 1.0 / self.T_ref)).exp() }
    }

    /// Drag without load at the output speed `w`, rad/s, of a gear at `t`, K: the first two terms of eq. (2), N.m.
    #[inline]
    pub fn drag<D: Number>(&self, w: D, t: f64) -> D {
        smooth_sign(w, self.w_small) * self.tau_c + w * (self.k * self.viscosity(t))
    }

    /// Drag for each newton metre of a load of `tau`, N.m: the third term of eq. (2).
    #[inline]
    pub fn load_drag<D: Number>(&self, w: D, tau: f64) -> D {
        let mu = 1.0 / self.efficiency - 1.0;
        smooth_sign(w, self.w_small) * (mu * smooth_sign(tau, self.tau_small))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's motor at 8.1322 rad/s: 0.0769 + 0.01267 * 8.1322 = 0.17993 N.m, its 0.18 A times 1 N.m/A.
    #[test]
    fn the_drag_without_load() {
        let gear = Gear::default();
        assert!((gear.drag(8.1322f64, 293.15) - 0.179_935).abs() < 1e-6);
        assert_eq!(gear.drag(0.0, 293.15), 0.0);
        assert_eq!(gear.drag(-8.1322, 293.15), -gear.drag(8.1322, 293.15));
        assert_eq!(gear.drag(8.1322, 250.0), gear.drag(8.1322, 350.0), "no temperature coefficient");
    }

    /// Oil of ISO VG 100 with the viscosity index 95: 100 mm2/s at 40 degC, 11.0 mm2/s at 100 degC. Between them, at 70 degC, the
    /// line of ASTM D341 gives 27.0 mm2/s, which the law exceeds by 11 %.
    #[test]
    fn the_viscosity_of_an_oil() {
        let kelvin = 9.09f64.ln() / (1.0 / 313.15 - 1.0 / 373.15);
        let gear = Gear { B: kelvin, T_ref: 313.15, tau_c: 0.0, ..Gear::default() };
        assert!((gear.viscosity(373.15) - 0.11).abs() < 1e-4 && gear.viscosity(313.15) == 1.0);
        // Walther: lg lg (nu + 0.7) is linear in lg T.
        let walther = |nu: f64| (nu + 0.7).log10().log10();
        let slope = (walther(100.0) - walther(11.0)) / (373.15f64 / 313.15).log10();
        let at_70 = 10f64.powf(10f64.powf(walther(100.0) - slope * (343.15f64 / 313.15).log10())) - 0.7;
        assert!((at_70 - 27.0).abs() < 0.1, "{at_70}");
        assert!((gear.viscosity(343.15) * 100.0 / at_70 - 1.11).abs() < 0.01, "{}", gear.viscosity(343.15));
        assert!((gear.drag(2.0f64, 373.15) / gear.drag(2.0, 313.15) - 0.11).abs() < 1e-4);
        assert!(gear.viscosity(0.0).is_finite());
    }

    /// A driven load of 1 N.m requires 1/0.73 N.m; a driving load returns 2 - 1/0.73 N.m.
    #[test]
    fn the_efficiency_is_that_of_a_driven_load() {
        let gear = Gear::default();
        assert!((1.0 + gear.load_drag(5.0f64, 1.0) - 1.0 / 0.73).abs() < 1e-12);
        let back = -1.0 - gear.load_drag(5.0f64, -1.0);
        assert!((back + (2.0 - 1.0 / 0.73)).abs() < 1e-12, "{back}");
    }
}
