//! Drift of the ambient temperature sensor.
//!
//! T_a = T_indicated + rate time                                                            (1)
//!
//! The input `ambient_temperature` is the indicated temperature; T_a, the true one, acts on the motor.
//! *Assumes* a drift linear in time, zero at time 0. *Neglects* other errors of the sensor.
//! *Sign*: rate > 0 means that the ambient air becomes warmer than indicated. *Source*: contract of the bench.

use super::prelude::*;

variables! {
    /// Drift of the ambient sensor.
    pub struct AmbientDrift {
        /// Drift rate of the true over the indicated ambient temperature; 0 switches the effect off
        rate: f64 = Variable::tunable(0, 0.0, Unit::KelvinPerSecond, -1.0, 1.0).nominal(1e-3).difference(),
    }
}

impl Effect for AmbientDrift {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate { most: 5.0, ..Candidate::on(Driver::Time, Port::AmbientSensor, &["rate"]) }];
    const EXAMPLE: &'static [f64] = &[0.01];

    #[inline]
    fn ambient_sensor(&self) -> f64 {
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_the_rate() {
        assert_eq!(AmbientDrift { rate: -2e-3 }.ambient_sensor(), -2e-3);
        assert_eq!(AmbientDrift::default().ambient_sensor(), 0.0);
    }
}
