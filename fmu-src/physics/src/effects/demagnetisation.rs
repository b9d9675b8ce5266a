//! Partial loss of magnetisation.
//!
//! k_t -> k_t (1 - fraction) from time on                                                   (1)
//!
//! The torque constant and, by reciprocity, the back-EMF constant change in a step; current, speed and temperatures
//! are continuous. It is a time event: a communication step that contains it is divided there.
//! *Assumes* a sudden, permanent loss. *Neglects* its cause.
//! *Sign*: fraction > 0 weakens the motor. *Source*: irreversible loss of Nd-Fe-B below the knee point.

use super::prelude::*;

variables! {
    /// Loss of magnetisation.
    pub struct Demagnetisation {
        /// Fraction of the torque constant that is lost; 0 switches the effect off
        fraction: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 0.99).nominal(0.1),
        /// Time of the loss; 0 or less: from the start
        time: f64 = Variable::tunable(1, 0.0, Unit::Second, -1e9, 1e9).nominal(1000.0),
    }
}

impl Effect for Demagnetisation {
    const CANDIDATES: &'static [Candidate] = &[Candidate {
        way: Way::Step,
        ..Candidate::on(Driver::Time, Port::TorqueConstant, &["fraction", "time"])
    }];
    const EXAMPLE: &'static [f64] = &[0.1, 0.25];

    #[inline]
    fn torque_constant(&self, time: f64) -> f64 {
        if self.fraction == 0.0 || self.time > time + IMMINENT { 1.0 } else { 1.0 - self.fraction }
    }

    #[inline]
    fn next_event(&self, time: f64) -> f64 {
        if self.fraction == 0.0 || self.time <= time + IMMINENT { f64::INFINITY } else { self.time }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_at_its_time() {
        let lost = Demagnetisation { fraction: 0.2, time: 5.0 };
        assert_eq!((lost.torque_constant(4.999), lost.torque_constant(5.0)), (1.0, 0.8));
        // A time that is below the event time by rounding only is the event time.
        assert_eq!(lost.torque_constant(5.0 - 1e-12), 0.8);
        assert_eq!((lost.next_event(0.0), lost.next_event(5.0)), (5.0, f64::INFINITY));
    }

    #[test]
    fn off_by_default_and_without_an_event() {
        let off = Demagnetisation { fraction: 0.0, time: 5.0 };
        assert_eq!((off.torque_constant(9.0), off.next_event(0.0)), (1.0, f64::INFINITY));
        assert_eq!(Demagnetisation::default().fraction, 0.0);
    }
}
