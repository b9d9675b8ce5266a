//! Convection of the housing that increases with the speed: a rotor, a fan or a propeller on the shaft moves the air.
//!
//! Q_flow = G (|w| / w_ref)^n (T_h - T_a)                                                   (1)
//!
//! The air velocity is proportional to the speed, and the heat transfer coefficient to its power n: 0.5 for a laminar boundary
//! layer, 0.6 for a cylinder in cross flow, 0.8 for a turbulent boundary layer.
//! *Assumes* an air velocity that follows the speed without delay. *Neglects* the temperature rise of the air and the
//! direction of rotation. *Sign*: Q_flow > 0 leaves the motor. *Range*: any speed; at standstill (1) is zero.
//! *Numerics*: the speed is constant over a step, at its midpoint value: second order in the step, which is divided where (1)
//! changes much.
//! *Source*: Incropera and DeWitt, Fundamentals of Heat and Mass Transfer (4th ed., 1996), ch. 7 (exponents); Staton and Cavagnino,
//! IEEE Trans. Ind. Electron. 55 (2008) 3509-3516 (motors).

use super::prelude::*;

variables! {
    /// The parameters of eq. (1).
    pub struct PowerOfSpeed {
        /// Conductance to ambient at the speed w_ref; 0 switches the effect off
        G: f64 = Variable::tunable(0, 0.0, Unit::WattPerKelvin, 0.0, 1e3).nominal(0.05),
        /// Exponent of the speed
        n: f64 = Variable::tunable(1, 0.8, Unit::One, 0.3, 1.2).nominal(0.1)
            .source("neutral while G is 0: turbulent boundary layer, Incropera and DeWitt (1996), ch. 7"),
        /// Speed at which the conductance is G
        w_ref: f64 = Variable::tunable(2, 100.0, Unit::RadianPerSecond, 1e-3, 1e5).log()
            .source("neutral while G is 0: reference, chosen"),
    }
}

/// The effect, with the latest speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedConvection {
    law: PowerOfSpeed,
    /// Speed of the shaft, rad/s.
    speed: f64,
}

parameters_of!(SpeedConvection: law: PowerOfSpeed);

impl SpeedConvection {
    /// The power in (1).
    #[inline]
    fn power(&self, speed: f64) -> f64 {
        (speed.abs() / self.law.w_ref).powf(self.law.n)
    }
}

impl Effect for SpeedConvection {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::Speed, Port::HousingAmbientConductance, &["G", "n"])];
    const EXAMPLE: &'static [f64] = &[0.02];

    #[inline]
    fn set_drivers(&mut self, drivers: &Drivers) -> bool {
        let has_changed = self.speed != drivers.speed;
        self.speed = drivers.speed;
        has_changed && self.is_on()
    }

    fn holds(&self, driver: Driver) -> bool {
        driver == Driver::Speed && self.is_on()
    }

    /// Relative to the greater conductance, at least that at w_ref: noise around standstill is no change.
    fn change(&self, from: &Drivers, to: &Drivers) -> f64 {
        let [from, to] = [from, to].map(|drivers| self.power(drivers.speed));
        (to - from).abs() / from.max(to).max(1.0)
    }

    #[inline]
    fn housing_to_ambient<D: Number>(&self, t_h: D, t_a: f64) -> D {
        (t_h - t_a) * (self.law.G * self.power(self.speed))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    fn at(speed: f64, n: f64) -> SpeedConvection {
        SpeedConvection { law: PowerOfSpeed { G: 0.1, n, w_ref: 100.0 }, speed }
    }

    /// 0.1 W/K at 100 rad/s, in both directions; 0.2 W/K at four times the speed with n = 0.5; 40 K give 8 W.
    #[test]
    fn a_power_of_the_speed() {
        let heat = |speed: f64, n: f64| at(speed, n).housing_to_ambient(340.0, 300.0);
        for (speed, n, expected) in
            [(100.0, 0.8, 4.0), (-100.0, 0.8, 4.0), (400.0, 0.5, 8.0), (-400.0, 0.5, 8.0), (0.0, 0.8, 0.0)]
        {
            assert!(f64::abs(heat(speed, n) - expected) < 1e-12, "{speed} {n}");
        }
        assert_eq!(at(300.0, 0.8).housing_to_ambient(300.0, 300.0), 0.0);
        slope_is_derivative(|t| at(250.0, 0.6).housing_to_ambient(t, 280.0), &[250.0, 340.0], 1e-2, 1e-9);
    }

    /// A laminar boundary layer on a flat plate, Nu = 0.664 Re^0.5 Pr^(1/3) (Incropera and DeWitt, eq. 7.31): 2.7 times the
    /// velocity give 1.643 times the coefficient.
    #[test]
    fn the_ratio_of_a_boundary_layer() {
        let plate = |re: f64| 0.664 * re.sqrt() * 0.707f64.powf(1.0 / 3.0);
        let heat = |speed: f64| at(speed, 0.5).housing_to_ambient(310.0, 300.0);
        assert!((heat(270.0) / heat(100.0) - plate(2.7e4) / plate(1e4)).abs() < 1e-12);
    }

    /// Only a change of the speed changes the cooling.
    #[test]
    fn tells_whether_the_cooling_has_changed() {
        let mut air = at(0.0, 0.8);
        let mut told = |speed: f64| air.set_drivers(&Drivers { speed, ..Drivers::default() });
        assert_eq!([told(100.0), told(100.0), told(-100.0)], [true, false, true]);
        let mut off = SpeedConvection::default();
        assert!(!off.set_drivers(&Drivers { speed: 9.0, ..Drivers::default() }) && !off.is_on());
        assert!(!off.holds(Driver::Speed) && at(0.0, 0.8).holds(Driver::Speed));
        assert_eq!(off.housing_to_ambient(350.0, 300.0), 0.0);
    }
}
