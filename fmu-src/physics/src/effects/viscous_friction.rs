//! Viscous friction of lubricant.
//!
//! tau = k w                                                                                (1)
//!
//! Eddy-current loss has the same law; a measurement of drag against speed cannot distinguish the two.
//! *Assumes* laminar lubricant films of constant viscosity. *Neglects* the decrease of viscosity with temperature.
//! *Sign*: against the motion; its power k w^2 >= 0 is friction heat.
//! *Source*: Modelica Standard Library, Electrical.Machines.Losses.Friction, with power_w = 1 (exponent of the torque).

use super::prelude::*;

variables! {
    /// Friction proportional to speed.
    pub struct ViscousFriction {
        /// Torque per speed; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetreSecond, 0.0, 10.0).nominal(1e-6),
    }
}

impl Effect for ViscousFriction {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::Speed, Port::DragTorque, &["k"])];
    const EXAMPLE: &'static [f64] = &[2e-6];

    #[inline]
    fn drag_torque<D: Number>(&self, w: D) -> D {
        w * self.k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_and_against_the_motion() {
        let friction = ViscousFriction { k: 2e-6 };
        assert_eq!(friction.drag_torque(500.0), 1e-3);
        assert_eq!(friction.drag_torque(-500.0), -1e-3);
        assert_eq!(ViscousFriction::default().drag_torque(1e4), 0.0);
    }
}
