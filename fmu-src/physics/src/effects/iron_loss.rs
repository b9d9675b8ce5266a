//! Hysteresis and eddy currents in the stator's iron.
//!
//! tau = k w / (w^2 + w_small^2)^(1/4)     -> k |w|^(1/2) sign(w) for |w| >> w_small        (1)
//!
//! The loss is tau w ~ w^(3/2), between hysteresis (~ w) and eddy currents (~ w^2).
//! The square root has an infinite derivative at rest; the derivative of eq. (1) there is k / w_small^(1/2). Eq. (1) is below the square
//! root by 16 % at w_small, by 0.25 % at 10 w_small, by 25 parts in a million at 100 w_small.
//! *Assumes* a flux that does not depend on the load. *Neglects* temperature.
//! *Sign*: against the motion; its power tau w >= 0 heats the stator, without a stator node the housing.
//! *Source*: Steinmetz, Trans. AIEE 9 (1892) 3, exponent of the frequency set to 3/2.

use super::prelude::*;

variables! {
    /// Loss in the iron.
    pub struct IronLoss {
        /// Torque per square root of speed; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetreRootSecond, 0.0, 10.0).nominal(1e-4),
        /// Speed below which the torque is proportional to speed
        w_small: f64 = Variable::tunable(1, 1.0, Unit::RadianPerSecond, 1e-3, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for IronLoss {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::Speed, Port::DragTorque, &["k"])];
    const EXAMPLE: &'static [f64] = &[1e-4];

    #[inline]
    fn drag_torque<D: Number>(&self, w: D) -> D {
        w * self.k / (w * w + self.w_small * self.w_small).sqrt().sqrt()
    }

    #[inline]
    fn iron_drag(&self, w: f64) -> f64 {
        self.drag_torque(w)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    const IRON: IronLoss = IronLoss { k: 2e-4, w_small: 1.0 };

    /// 2e-4 * sqrt(900) = 6 mN.m: 5.4 W at 900 rad/s; 2^(3/2) times the loss at twice the speed.
    #[test]
    fn the_square_root_of_speed() {
        assert!((IRON.drag_torque(900.0f64) - 6e-3).abs() < 6e-3 * 4e-7);
        let loss = |w: f64| IRON.drag_torque(w) * w;
        assert!((loss(2000.0) / loss(1000.0) - 2.0f64.powf(1.5)).abs() < 1e-6);
    }

    #[test]
    fn the_stated_deviation_from_the_square_root() {
        let below = |w: f64| 1.0 - IRON.drag_torque(w) / (IRON.k * w.sqrt());
        assert!((below(1.0) - (1.0 - 0.5f64.powf(0.25))).abs() < 1e-12);
        assert!((below(10.0) - 0.0025).abs() < 2e-5);
        assert!((below(100.0) - 25e-6).abs() < 1e-8);
    }

    #[test]
    fn odd_and_off_by_default() {
        assert_eq!(IRON.drag_torque(0.0), 0.0);
        assert_eq!(IRON.drag_torque(-30.0), -IRON.drag_torque(30.0f64));
        assert_eq!(IronLoss::default().drag_torque(1e4f64).to_bits(), 0);
        assert_eq!(IRON.iron_drag(30.0), IRON.drag_torque(30.0f64));
    }

    #[test]
    fn the_slope_is_the_derivative_and_finite_at_rest() {
        slope_is_derivative(|w| IRON.drag_torque(w), &[-900.0, -0.7, 0.0, 1.0, 50.0], 1e-4, 1e-9);
    }
}
