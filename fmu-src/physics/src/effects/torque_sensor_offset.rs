//! Zero offset of the torque sensor.
//!
//! tau_indicated = tau + offset                                                             (1)
//!
//! *Assumes* the same offset at all torques. *Neglects* errors of the sensitivity and crosstalk.
//! *Sign*: offset > 0 indicates a greater torque from the motor to its load. The sensor does not affect the motor:
//! `power_mechanical` and the energies follow from the true torque.
//! *Range*: any torque. *Source*: zero signal of torque transducers, VDI/VDE 2646:2019 (minimum requirements, terms).

use super::prelude::*;

variables! {
    /// Zero of the torque sensor.
    pub struct TorqueSensorOffset {
        /// Indicated torque without load; 0 switches the effect off
        offset: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetre, -1e3, 1e3).nominal(1e-3),
    }
}

impl Effect for TorqueSensorOffset {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::constant(Port::TorqueSensor, &["offset"]).of_the_bench()];
    const EXAMPLE: &'static [f64] = &[2e-3];

    #[inline]
    fn torque_sensor(&self, tau: f64) -> f64 {
        tau + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_added() {
        let sensor = TorqueSensorOffset { offset: -0.005 };
        assert_eq!((sensor.torque_sensor(0.05), sensor.torque_sensor(0.0)), (0.05 - 0.005, -0.005));
        assert_eq!(TorqueSensorOffset::default().torque_sensor(-0.3), -0.3);
    }
}
