//! First-order lag of the winding temperature sensor.
//!
//! tau dy/dt = T_w - y                                                                      (1)
//!
//! y is the reading of the sensor; it starts at the temperature of the winding. The solution is in components/sensor.rs.
//! *Assumes* a sensor of one heat capacity behind one resistance. *Neglects* the heat that it draws from the winding.
//! *Sign*: tau > 0 indicates too low a temperature while the winding warms up. *Range*: tau >= 0; 0 is no lag.
//! *Source*: first-order response of a contact thermometer, VDI/VDE 3522-1.

use super::prelude::*;

variables! {
    /// Lag of the winding's sensor.
    pub struct WindingSensorLag {
        /// Time constant of the winding sensor; 0 switches the effect off
        tau: f64 = Variable::tunable(0, 0.0, Unit::Second, 0.0, 1e5).nominal(30.0),
    }
}

impl Effect for WindingSensorLag {
    const CANDIDATES: &'static [Candidate] = &[Candidate {
        way: Way::Store,
        follows: Follows::History,
        ..Candidate::constant(Port::WindingSensor, &["tau"])
    }];
    const EXAMPLE: &'static [f64] = &[20.0];

    #[inline]
    fn sensor_lag(&self) -> PerNode {
        PerNode { winding: self.tau, housing: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_constant_is_the_time_constant() {
        let lag = PerNode { winding: 30.0, housing: 0.0 };
        assert_eq!(WindingSensorLag { tau: 30.0 }.sensor_lag(), lag);
        assert_eq!(WindingSensorLag::default().sensor_lag(), PerNode::default());
    }
}
