//! Dry friction of bearings and seals.
//!
//! tau = tau_c tanh(w / w_small)                                                            (1)
//!
//! *Assumes* a friction torque that does not depend on speed, load or temperature.
//! *Neglects* static friction above tau_c: below w_small the shaft creeps instead of sticking.
//! *Sign*: against the motion; its power tau w >= 0 is friction heat.
//! *Source*: regularised Coulomb law, Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083.

use super::prelude::*;

variables! {
    /// Dry friction.
    pub struct CoulombFriction {
        /// Friction torque; 0 switches the effect off
        tau_c: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetre, 0.0, 1e3).nominal(0.01),
        /// Speed below which the friction torque goes smoothly to zero
        w_small: f64 = Variable::tunable(1, 1.0, Unit::RadianPerSecond, 1e-3, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for CoulombFriction {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::Speed, Port::DragTorque, &["tau_c"])];
    const EXAMPLE: &'static [f64] = &[0.005, 1.0];

    #[inline]
    fn drag_torque<D: Number>(&self, w: D) -> D {
        smooth_sign(w, self.w_small) * self.tau_c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    #[test]
    fn full_torque_when_running_none_at_rest_odd_in_speed() {
        let friction = CoulombFriction { tau_c: 0.00983, w_small: 1.0 };
        assert!((friction.drag_torque(1000.0f64) - 0.00983).abs() < 1e-17);
        assert_eq!(friction.drag_torque(0.0), 0.0);
        assert_eq!(friction.drag_torque(20.0 + 1e-9), friction.drag_torque(20.0));
        assert_eq!(friction.drag_torque(-3.0), -friction.drag_torque(3.0));
        assert!((friction.drag_torque(0.5f64) - 0.00983 * 0.462_117_157_260_009_76).abs() < 1e-15);
    }

    /// The derivative for the integrator compared with a difference quotient, also far above w_small.
    #[test]
    fn the_slope_is_the_derivative() {
        let friction = CoulombFriction { tau_c: 0.00983, w_small: 1.0 };
        for w in [-2000.0, -1.3, 0.0, 0.4, 19.0, 400.0f64] {
            let slope = friction.drag_torque(Dual64::from(w).derivative()).eps;
            let difference = (friction.drag_torque(w + 1e-4) - friction.drag_torque(w - 1e-4)) / 2e-4;
            assert!((slope - difference).abs() < 1e-9, "{w}: {slope} {difference}");
        }
    }
}
