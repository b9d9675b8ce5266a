//! Winding and magnets of an equivalent DC motor.
//!
//! R(T_w)   = R_ref [1 + alpha (T_w - T_ref)]                                               (1)
//! k_t(T_m) = k_t,ref [1 + alpha_mag (T_m - T_ref)]                                         (2)
//! back-EMF = k_t(T_m) w        torque in the air gap = k_t(T_m) I                          (3)
//!
//! *Assumes* one k_t for torque and back-EMF (SI units; reciprocity), magnets below their knee.
//! *Neglects* saturation, torque ripple and the temperature dependence of L.
//! *Sign*: a positive current gives a positive torque; a positive speed a positive back-EMF.
//! *Range*: (1) copper between -100 and 250 degC; (2) Nd-Fe-B up to about 150 degC.
//! *Source*: thesis in `seeds`, eqs. (2) and (5), with the magnets at their own temperature; data of maxon
//! EC-4pole 30, 305015 (datasheet, reference temperature 25 degC).

use declare::{Unit, Variable, variables};

variables! {
    /// Data of the motor.
    pub struct Motor {
        /// Terminal resistance at T_ref
        R_ref: f64 = Variable::tunable(0, 0.386, Unit::Ohm, 1e-4, 1e4).log()
            .source("maxon datasheet 305015"),
        /// Reference temperature of R_ref and k_t
        T_ref: f64 = Variable::tunable(1, 298.15, Unit::Kelvin, 173.15, 473.15)
            .source("maxon datasheet 305015"),
        /// Temperature coefficient of the winding's resistance
        alpha: f64 = Variable::tunable(2, 0.0039, Unit::PerKelvin, 0.0, 0.0045)
            .source("copper, thesis eq. (2)"),
        /// Terminal inductance
        L: f64 = Variable::tunable(3, 65.3e-6, Unit::Henry, 1e-7, 10.0).log()
            .source("maxon datasheet 305015"),
        /// Torque constant at T_ref, equal to the back-EMF constant in V.s/rad
        k_t: f64 = Variable::tunable(4, 0.0276, Unit::NewtonMetrePerAmpere, 1e-5, 100.0).log()
            .source("maxon datasheet 305015"),
        /// Temperature coefficient of the torque constant; negative: magnets weaken when hot
        alpha_mag: f64 = Variable::tunable(5, -0.0012, Unit::PerKelvin, -0.004, 0.0).nominal(0.001)
            .source("NdFeB, thesis eq. (5)"),
        /// Moment of inertia of the rotor
        J: f64 = Variable::tunable(6, 33.3e-7, Unit::KilogramSquareMetre, 1e-10, 10.0).log()
            .source("maxon datasheet 305015"),
        /// Number of pole pairs
        pole_pairs: i32 = Variable::tunable_count(7, 2, 1, 100)
            .source("maxon datasheet 305015 (4 poles)"),
        /// Mass of the motor
        mass: f64 = Variable::tunable(8, 0.3, Unit::Kilogram, 1e-4, 1e3).log()
            .source("maxon datasheet 305015"),
    }
}

impl Motor {
    /// Resistance of the winding at `t_w` kelvin, eq. (1), Ohm.
    #[inline]
    pub fn resistance(&self, t_w: f64) -> f64 {
        self.R_ref * (1.0 + self.alpha * (t_w - self.T_ref))
    }

    /// Torque constant with the magnets at `t_m` kelvin, eq. (2), N.m/A.
    #[inline]
    pub fn torque_constant(&self, t_m: f64) -> f64 {
        self.k_t * (1.0 + self.alpha_mag * (t_m - self.T_ref))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The thesis's temperature from resistance, eq. (7): 0.4 Ohm is 25 + (0.4/0.386 - 1)/0.0039 degC.
    #[test]
    fn resistance_at_the_reference_and_at_a_hand_computed_temperature() {
        let motor = Motor::default();
        assert_eq!(motor.resistance(298.15), 0.386);
        let t: f64 = 298.15 + (0.4 / 0.386 - 1.0) / 0.0039;
        assert!((t - 307.450).abs() < 1e-3);
        assert!((motor.resistance(t) - 0.4).abs() < 1e-15);
    }

    /// Heating by 100 K reduces the torque constant by 12 %.
    #[test]
    fn hot_magnets_are_weaker() {
        let motor = Motor::default();
        assert_eq!(motor.torque_constant(298.15), 0.0276);
        assert!((motor.torque_constant(398.15) - 0.88 * 0.0276).abs() < 1e-16);
    }
}
