//! Constant offset of the winding temperature sensor.
//!
//! T_indicated = T + offset                                                                 (1)
//!
//! *Assumes* the same offset at all temperatures. *Neglects* noise and drift.
//! *Sign*: offset > 0 indicates too high a temperature. The sensor does not affect the motor.
//! *Range*: any temperature. *Source*: tolerance of thermocouples, IEC 60584-1:2013, class 1: 1.5 K.

use super::prelude::*;

variables! {
    /// Offset of the winding's sensor.
    pub struct WindingSensorOffset {
        /// Offset of the winding sensor; 0 switches the effect off
        offset: f64 = Variable::tunable(0, 0.0, Unit::Kelvin, -100.0, 100.0).difference(),
    }
}

impl Effect for WindingSensorOffset {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::constant(Port::WindingSensor, &["offset"]).of_the_bench()];
    const EXAMPLE: &'static [f64] = &[1.2];

    #[inline]
    fn winding_sensor(&self, t: f64, _t_a: f64) -> f64 {
        t + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_added() {
        let sensor = WindingSensorOffset { offset: -1.5 };
        assert_eq!(sensor.winding_sensor(350.0, 300.0), 348.5);
        assert_eq!(WindingSensorOffset::default().winding_sensor(350.0, 300.0), 350.0);
    }
}
