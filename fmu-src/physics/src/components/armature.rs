//! Winding, brushes and magnets of a brushed direct-current motor.
//!
//! R(T_w)   = R_ref [1 + alpha (T_w - T_ref)]                                               (1)
//! k_t(T_m) = k_t,ref [1 + alpha_mag (T_m - T_ref)]                                         (2)
//!
//! *Assumes*, *neglects*, *sign*: as `motor.rs`; the brushes are included in the winding's resistance.
//! *Source*: the paper in `seeds`, eq. (8), with its constant term, which its eq. (10) omits. R_ref and L are
//! its LCR measurement (section 2.5). k_t: 8.132 V of back-EMF at 8.13 rad/s is 1 V.s/rad at the output shaft, divided by
//! the ratio of 131. J is an estimate: an armature of 50 g with a radius of 12 mm.

use declare::{Unit, Variable, variables};

variables! {
    /// Data of the motor in front of the gear.
    pub struct Armature {
        /// Terminal resistance at T_ref, brushes included
        R_ref: f64 = Variable::tunable(0, 9.20, Unit::Ohm, 1e-4, 1e4).log()
            .source("paper on the gearmotor 37D, section 2.5: LCR meter"),
        /// Reference temperature of R_ref and k_t
        T_ref: f64 = Variable::tunable(1, 293.15, Unit::Kelvin, 173.15, 473.15)
            .source("paper on the gearmotor 37D: 20 degC"),
        /// Temperature coefficient of the winding's resistance
        alpha: f64 = Variable::tunable(2, 0.004, Unit::PerKelvin, 0.0, 0.0045)
            .source("paper on the gearmotor 37D: copper"),
        /// Terminal inductance
        L: f64 = Variable::tunable(3, 1.803e-3, Unit::Henry, 1e-7, 10.0).log()
            .source("paper on the gearmotor 37D, section 2.5: LCR meter"),
        /// Torque constant at the rotor at T_ref, equal to the back-EMF constant in V.s/rad
        k_t: f64 = Variable::tunable(4, 7.634e-3, Unit::NewtonMetrePerAmpere, 1e-6, 100.0).log()
            .source("paper on the gearmotor 37D: 8.132 V at 8.13 rad/s over the ratio 131"),
        /// Temperature coefficient of the torque constant; negative: magnets weaken when hot
        alpha_mag: f64 = Variable::tunable(5, 0.0, Unit::PerKelvin, -0.004, 0.0).nominal(0.001),
        /// Moment of inertia of the rotor and of all parts that turn at its speed
        J: f64 = Variable::tunable(6, 3.6e-6, Unit::KilogramSquareMetre, 1e-10, 10.0).log()
            .source("estimate: armature of 50 g, radius 12 mm"),
    }
}

impl Armature {
    /// Resistance of the winding at `t_w` kelvin, eq. (1), Ohm.
    #[inline]
    pub fn resistance(&self, t_w: f64) -> f64 {
        self.R_ref * (1.0 + self.alpha * (t_w - self.T_ref))
    }

    /// Torque constant at the rotor with the magnets at `t_m` kelvin, eq. (2), N.m/A.
    #[inline]
    pub fn torque_constant(&self, t_m: f64) -> f64 {
        self.k_t * (1.0 + self.alpha_mag * (t_m - self.T_ref))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's motor at its 37.74 degC: 9.2 (1 + 0.004 * 17.74) = 9.853 Ohm, while its eq. (10) gives 17.36.
    #[test]
    fn resistance_at_a_hand_computed_temperature() {
        let armature = Armature::default();
        assert_eq!(armature.resistance(293.15), 9.20);
        assert!((armature.resistance(273.15 + 37.74) - 9.852_832).abs() < 1e-9);
    }
}
