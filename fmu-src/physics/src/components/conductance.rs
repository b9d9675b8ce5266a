//! Cooling by a conductance to ambient that increases with the fan command.
//!
//! G = G_still + G_forced n^0.8,   Q_ambient = G (T_h - T_a)                                (1)
//!
//! n is the fan command from 0 to 1. *Assumes* flow proportional to the command (affinity laws) and turbulent
//! forced convection, Nu ~ Re^0.8. *Neglects* natural convection's own dependence on temperature.
//! *Sign*: Q_ambient > 0 leaves the housing. *Range*: continuous from n = 0, where the derivative is infinite.
//! *Source*: Incropera, Fundamentals of Heat and Mass Transfer, 7th ed., eq. 8.60 for the exponent; datasheet of
//! maxon 305015 for 1/G_still = 7.4 K/W. G_forced from the thesis (`seeds`, table 1): with the fan at full speed 5 mm
//! from the motor and 10 W in the winding it measured R_ha = 4.03 K/W, so G_forced = 1/4.03 - 1/7.4 = 0.113 W/K. That
//! R_ha includes leads and mount, as G_still does.

use declare::{Unit, Variable, variables};

variables! {
    /// Conductance from housing to ambient.
    pub struct Conductance {
        /// Thermal conductance from housing to ambient with the fan off
        G_still: f64 = Variable::tunable(0, 0.1351, Unit::WattPerKelvin, 1e-6, 1e4).log()
            .source("maxon datasheet 305015: 7.4 K/W"),
        /// Additional conductance from housing to ambient at full fan speed
        G_forced: f64 = Variable::tunable(1, 0.113, Unit::WattPerKelvin, 0.0, 1e4)
            .source("thesis, table 1: R_ha 4.03 K/W at 10 W with the fan at 5 mm, 1/4.03 - G_still"),
    }
}

impl Conductance {
    /// Conductance at the fan command `n`, eq. (1), W/K.
    #[inline]
    pub fn at(&self, n: f64) -> f64 {
        self.G_still + self.G_forced * Self::share(n)
    }

    /// n^0.8, with n limited to 0 ... 1, since extrapolation may lead an input beyond its limits between two
    /// communication points.
    #[inline]
    pub fn share(n: f64) -> f64 {
        // A power costs as much as the rest of a step, so the two common commands are treated separately.
        if n <= 0.0 {
            0.0
        } else if n >= 1.0 {
            1.0
        } else {
            n.powf(0.8)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn still_air_full_fan_and_half_fan() {
        let c = Conductance::default();
        assert_eq!(c.at(0.0), 0.1351);
        assert_eq!(c.at(1.0), 0.1351 + 0.113);
        assert!((c.at(0.5) - (0.1351 + 0.113 * 0.574_349_177_498_517_5)).abs() < 1e-15);
    }

    /// The thesis's table 1: R_ha of 4.03 K/W with the fan at 5 mm, 7.4 K/W of the datasheet without.
    #[test]
    fn the_measured_fan() {
        let c = Conductance::default();
        assert!((1.0 / c.at(1.0) - 4.03).abs() < 0.005, "{}", 1.0 / c.at(1.0));
        assert!((1.0 / c.at(0.0) - 7.4).abs() < 0.005);
    }

    #[test]
    fn no_jump_at_the_limits() {
        let c = Conductance::default();
        assert!((c.at(1e-12) - c.at(0.0)) < 1e-9);
        assert!((c.at(1.0) - c.at(1.0 - 1e-12)) < 1e-11);
    }
}
