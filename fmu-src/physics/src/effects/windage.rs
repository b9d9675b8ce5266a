//! Air drag of the rotor.
//!
//! tau = k w |w|                                                                            (1)
//!
//! *Assumes* turbulent flow of constant density. *Neglects* the laminar range at low speed, where the torque is
//! small, and the air's temperature.
//! *Sign*: against the motion; its power k |w|^3 >= 0 is friction heat.
//! *Source*: Vrancik, NASA TN D-4849 (1968); the skin-friction coefficient is assumed constant.

use super::prelude::*;

variables! {
    /// Friction of the air.
    pub struct Windage {
        /// Torque per square of speed; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetreSquareSecond, 0.0, 1.0).nominal(1e-9),
    }
}

impl Effect for Windage {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::Speed, Port::DragTorque, &["k"])];
    const EXAMPLE: &'static [f64] = &[2e-9];

    #[inline]
    fn drag_torque<D: Number>(&self, w: D) -> D {
        w * w.abs() * self.k
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    /// 2e-9 * 1000^2 = 2 mN.m, against the motion in both directions.
    #[test]
    fn the_square_of_speed() {
        let windage = Windage { k: 2e-9 };
        assert!((windage.drag_torque(1000.0f64) - 2e-3).abs() < 1e-17);
        assert!((windage.drag_torque(-2000.0f64) + 8e-3).abs() < 1e-17);
        assert_eq!(windage.drag_torque(0.0), 0.0);
        assert_eq!(Windage::default().drag_torque(1e4f64).to_bits(), 0);
    }

    #[test]
    fn the_slope_is_the_derivative() {
        let windage = Windage { k: 2e-9 };
        slope_is_derivative(|w| windage.drag_torque(w), &[-700.0, 0.0, 3.0, 1500.0], 1e-3, 1e-11);
    }
}
