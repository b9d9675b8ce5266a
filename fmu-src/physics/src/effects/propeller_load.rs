//! Shaft power of a propeller or fan, with the electrical power as input.
//!
//! tau = k w |w|,   P_shaft = k |w|^3                                                        (1)
//!
//! Acts in drive_mode power with an imposed speed: P_shaft is a part of the input `electrical_power` that is delivered at the shaft and
//! does not heat the motor. In the other modes the torque follows from the current, and the load from the torque.
//! *Assumes* a constant power coefficient: P_shaft = C_P rho n^3 D^5, so k = C_P rho D^5 / (2 pi)^3.
//! *Neglects* the advance ratio and changes of air density. *Sign*: k > 0 takes power from the motor.
//! *Range*: P_shaft below electrical_power. *Source*: McCormick, Aerodynamics, Aeronautics and Flight Mechanics (2nd ed., 1995), ch. 6.

use super::prelude::*;

variables! {
    /// A propeller on the shaft.
    pub struct PropellerLoad {
        /// Torque per square of speed; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetreSquareSecond, 0.0, 10.0).nominal(1e-7),
    }
}

impl Effect for PropellerLoad {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::Speed, Port::WindingHeat, &["k"])];
    const EXAMPLE: &'static [f64] = &[1e-8];

    #[inline]
    fn power_mode_torque(&self, w: f64) -> f64 {
        self.k * w * w.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// C_P = 0.05, D = 0.254 m (10 inches), 6000 rpm, 1.2 kg/m3: 0.05 * 1.2 * 100^3 * 0.254^5 = 63.4 W, 0.101 N.m.
    #[test]
    fn the_power_of_a_propeller() {
        let coefficient = 0.05 * 1.2 * 0.254f64.powi(5) / (2.0 * PI).powi(3);
        let (propeller, w) = (PropellerLoad { k: coefficient }, 200.0 * PI);
        let torque = propeller.power_mode_torque(w);
        assert!((torque * w - 63.43).abs() < 0.01 && (torque - 0.1010).abs() < 1e-4, "{torque}");
        assert_eq!(propeller.power_mode_torque(-w), -torque);
        assert_eq!(PropellerLoad::default().power_mode_torque(w), 0.0);
    }
}
