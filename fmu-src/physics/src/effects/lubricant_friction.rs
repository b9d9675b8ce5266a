//! Friction of a lubricant whose viscosity decreases with temperature.
//!
//! tau = tau_l exp(-beta (T - T_ref)) (u / w_ref)^n w / u,   u = sqrt(w^2 + w_small^2)            (1)
//!
//! tau_l is the torque at w_ref and T_ref. The torque without load of a lubricated bearing is proportional to (viscosity times
//! speed)^(2/3); stiff grease has n near 0, a full laminar film 1. Mineral oil of 100 mm2/s at 40 degC has 11 mm2/s at 100 degC, so that
//! beta = 2/3 ln(100/11)/60 K = 0.025/K. Friction with less than 0.005/K is no friction of a lubricant, but of another law over speed.
//! *Assumes* bearings at the temperature of the magnets, or of the housing without a rotor node. *Neglects* starvation and the run-in of grease.
//! *Sign*: against the motion; its power is friction heat. *Range*: any speed; below w_small smooth through zero.
//! *Source*: Palmgren, Ball and Roller Bearing Engineering (3rd ed., 1959); Harris, Rolling Bearing Analysis (4th ed., 2001), eq.
//! 14.20 (exponent); ISO 3448 and ISO 2909 (viscosity grade and index).

use super::prelude::*;

variables! {
    /// The parameters of eq. (1).
    pub struct LubricantFriction {
        /// Friction torque at w_ref and T_ref; 0 switches the effect off
        tau_l: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetre, 0.0, 1e3).nominal(0.002),
        /// Exponent of the speed
        n: f64 = Variable::tunable(1, 0.667, Unit::One, 0.0, 1.0).nominal(0.1)
            .source("neutral while tau_l is 0: Harris (2001), eq. 14.20"),
        /// Relative decrease of the friction torque per kelvin
        beta: f64 = Variable::tunable(2, 0.025, Unit::PerKelvin, 0.005, 0.2).nominal(0.01)
            .source("neutral while tau_l is 0: mineral oil ISO VG 100 between 40 and 100 degC"),
        /// Speed at which the torque is tau_l
        w_ref: f64 = Variable::tunable(3, 100.0, Unit::RadianPerSecond, 1e-3, 1e5).log()
            .source("neutral while tau_l is 0: reference, chosen"),
        /// Temperature at which the torque is tau_l
        T_ref: f64 = Variable::tunable(4, 298.15, Unit::Kelvin, 173.15, 473.15)
            .source("neutral while tau_l is 0: reference, chosen"),
        /// Speed below which the friction torque goes smoothly to zero
        w_small: f64 = Variable::tunable(5, 1.0, Unit::RadianPerSecond, 1e-3, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for LubricantFriction {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::HousingTemperature, Port::DragTorque, &["tau_l", "n", "beta"])];
    const EXAMPLE: &'static [f64] = &[0.003];

    #[inline]
    fn warm_drag<D: Number>(&self, w: D, t: f64) -> D {
        if self.tau_l == 0.0 {
            return D::from(0.0);
        }
        let square = (w * w + self.w_small * self.w_small) / (self.w_ref * self.w_ref);
        let thinned = (self.beta * (self.T_ref - t)).exp();
        w * square.powf(0.5 * (self.n - 1.0)) * (self.tau_l * thinned / self.w_ref)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    fn friction(n: f64) -> LubricantFriction {
        LubricantFriction { tau_l: 0.002, n, beta: 0.025, w_small: 1e-3, ..LubricantFriction::default() }
    }

    /// Eight times the speed: four times the torque. ln(4)/0.025 K above the reference it is a quarter, that of w_ref again.
    #[test]
    fn a_power_of_the_speed_that_falls_with_temperature() {
        let torque = |kelvin: f64, w: f64| -> f64 { friction(2.0 / 3.0).warm_drag(w, kelvin) };
        assert!((torque(298.15, 100.0) / 0.002 - 1.0).abs() < 1e-9);
        assert!((torque(298.15, 800.0) / 0.008 - 1.0).abs() < 1e-9);
        assert!((torque(298.15 + 4f64.ln() / 0.025, 800.0) / 0.002 - 1.0).abs() < 1e-9);
        assert_eq!((torque(320.0, 0.0), torque(320.0, -50.0)), (0.0, -torque(320.0, 50.0)));
        let stiff = |w: f64| -> f64 { friction(0.0).warm_drag(w, 298.15) };
        assert!((stiff(20.0) - 0.002).abs() < 1e-10 && (stiff(900.0) - 0.002).abs() < 1e-10);
    }

    #[test]
    fn the_slope_is_the_derivative() {
        slope_is_derivative(|w| friction(0.667).warm_drag(w, 330.0), &[-700.0, 3.0, 250.0], 1e-3, 1e-9);
    }

    #[test]
    fn off_by_default() {
        assert_eq!(LubricantFriction::default().warm_drag(500.0, 350.0), 0.0);
    }
}
