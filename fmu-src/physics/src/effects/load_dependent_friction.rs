//! Friction of gear and bearings under load.
//!
//! tau = mu |tau_s| sign(w), where tau_s is the shaft torque on the load                    (1)
//!
//! Both sign functions are a tanh, of width w_small and tau_small. With the drag as a multiple of tau_s
//! (the port's form), a model that knows only the torque u before this friction solves
//! tau_s = u - load_drag tau_s, so tau_s = u / (1 + load_drag); the sign of u is that of tau_s, as mu < 1.
//! *Assumes* a coefficient that does not depend on speed or temperature. *Neglects* static friction: the shaft creeps.
//! *Sign*: against the motion, for both directions of the load torque; its power mu |tau_s w| >= 0 is friction heat.
//! *Source*: Modelica Standard Library, Rotational.Components.LossyGear: efficiency 1/(1 + mu) when the motor
//! drives, 1 - mu when the load does.

use super::prelude::*;

variables! {
    /// Friction proportional to the load.
    pub struct LoadDependentFriction {
        /// Friction torque over torque at the shaft; 0 switches the effect off
        mu: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 0.9).nominal(0.05),
        /// Speed below which the friction torque goes smoothly to zero
        w_small: f64 = Variable::tunable(1, 1.0, Unit::RadianPerSecond, 1e-3, 1e3).log()
            .source("regularisation width, chosen"),
        /// Load torque below which the friction falls with its square
        tau_small: f64 = Variable::tunable(2, 1e-3, Unit::NewtonMetre, 1e-9, 10.0).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for LoadDependentFriction {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::LoadTorque, Port::DragTorque, &["mu"])];
    const EXAMPLE: &'static [f64] = &[0.06];

    #[inline]
    fn load_drag<D: Number>(&self, w: D, tau: f64) -> D {
        smooth_sign(w, self.w_small) * (self.mu * smooth_sign(tau, self.tau_small))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    const LOADED: LoadDependentFriction = LoadDependentFriction { mu: 0.05, w_small: 1.0, tau_small: 1e-3 };

    /// 5 % of 0.2 N.m is 10 mN.m, against the motion in all four quadrants.
    #[test]
    fn a_share_of_the_load_against_the_motion() {
        for (w, load) in [(300.0f64, 0.2), (300.0, -0.2), (-300.0, 0.2), (-300.0, -0.2)] {
            let drag = LOADED.load_drag(w, load) * load;
            assert!((drag - 0.01 * w.signum()).abs() < 1e-15, "{w} {load}: {drag}");
        }
    }

    #[test]
    fn none_at_rest_none_without_load_off_by_default() {
        assert_eq!(LOADED.load_drag(0.0, 0.2), 0.0);
        assert_eq!(LOADED.load_drag(300.0, 0.0), 0.0);
        assert_eq!(LoadDependentFriction::default().load_drag(300.0f64, 0.2).to_bits(), 0);
    }

    #[test]
    fn the_slope_is_the_derivative() {
        slope_is_derivative(|w| LOADED.load_drag(w, 0.2), &[-300.0, -0.4, 0.0, 1.0], 1e-5, 1e-10);
    }
}
