//! Springs of an actuator: one in series with its transmission, one parallel to it at the joint.
//!
//! series      d = angle_in - angle_joint,   p = d without the backlash, on the side in contact         (1)
//!             tau = k p + c (w_in - w_joint), the damping term only in contact                         (2)
//! parallel    tau = k (neutral - angle_joint), on both sides or on one                                 (3)
//!
//! *Assumes* springs without mass. Damping requires contact: it is zero inside the backlash, and rises to its full value over a further
//! deflection of half the backlash, so that the torque has no step.
//! *Sign*: a positive torque pushes the joint in the positive direction; its power on the joint is tau w.

use declare::{Unit, Variable, enumeration, variables};

variables! {
    /// The spring between transmission and joint.
    pub struct SeriesSpring {
        /// Stiffness of the series spring, at the joint
        stiffness: f64 = Variable::tunable(0, 250.0, Unit::NewtonMetrePerRadian, 1e-3, 1e7).log()
            .source("estimate: series springs of powered ankles"),
        /// Viscous damping of the series spring, at the joint
        damping: f64 = Variable::tunable(1, 0.0, Unit::NewtonMetreSecond, 0.0, 1e5),
    }
}

/// A series spring at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflected {
    /// Torque on the joint, N.m.
    pub torque: f64,
    /// Damping loss, W.
    pub loss: f64,
    /// Rate of the elastic torque, N.m/s.
    pub rate: f64,
    /// Stored energy, J.
    pub energy: f64,
}

/// The part of a deflection outside the backlash.
#[inline]
pub fn beyond(deflection: f64, play: f64) -> f64 {
    deflection - deflection.clamp(-0.5 * play, 0.5 * play)
}

impl SeriesSpring {
    /// Eqs. (1) and (2): the deflection, rad, its rate, rad/s, and the total backlash, rad.
    #[inline]
    pub fn deflected(&self, deflection: f64, rate: f64, play: f64) -> Deflected {
        let p = beyond(deflection, play);
        let contact = if play > 0.0 { (p.abs() / (0.5 * play)).min(1.0) } else { 1.0 };
        let damping = contact * self.damping * rate;
        let touches = if play > 0.0 && p == 0.0 { 0.0 } else { 1.0 };
        Deflected {
            torque: self.stiffness * p + damping,
            loss: damping * rate,
            rate: touches * self.stiffness * rate,
            energy: 0.5 * self.stiffness * p * p,
        }
    }

    /// The deflection, rad, at rest with the torque `torque`, N.m.
    pub fn deflection_of(&self, torque: f64, play: f64) -> f64 {
        let side = if torque == 0.0 { 0.0 } else { 0.5 * play * torque.signum() };
        torque / self.stiffness + side
    }
}

enumeration! {
    /// Side of the neutral angle on which the parallel spring acts
    pub enum Engagement {
        /// Both sides
        Both = 1, "both";
        /// Joint angles above the neutral angle, as a soft stop
        Above = 2, "above";
        /// Joint angles below the neutral angle
        Below = 3, "below";
    }
}

variables! {
    /// The spring parallel to the actuator, between the joint's two segments.
    pub struct ParallelSpring {
        /// Stiffness of the parallel spring, at the joint; 0 for none
        stiffness: f64 = Variable::tunable(0, 0.0, Unit::NewtonMetrePerRadian, 0.0, 1e7),
        /// Joint angle at which the parallel spring is relaxed
        neutral_angle: f64 = Variable::tunable(1, 0.0, Unit::Radian, -4.0, 4.0),
        /// Side of the neutral angle on which the parallel spring acts
        engagement: Engagement = Variable::choice(2, 1),
    }
}

impl ParallelSpring {
    /// Eq. (3): torque on the joint, N.m, and the energy stored, J, at the joint's angle, rad.
    #[inline]
    pub fn at(&self, angle: f64) -> (f64, f64) {
        let off = self.neutral_angle - angle;
        let off = match self.engagement {
            Engagement::Both => off,
            Engagement::Above => off.min(0.0),
            Engagement::Below => off.max(0.0),
        };
        (self.stiffness * off, 0.5 * self.stiffness * off * off)
    }

    /// Whether it acts on one side only.
    #[inline]
    pub fn is_one_sided(&self) -> bool {
        self.engagement != Engagement::Both && self.stiffness != 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_gives_what_it_stores() {
        let spring = SeriesSpring { damping: 3.0, ..SeriesSpring::default() };
        let d = spring.deflected(0.2, 0.5, 0.0);
        assert_eq!((d.torque, d.loss, d.energy), (50.0 + 1.5, 0.75, 5.0));
        // Power in minus power loss is the rate of its energy.
        let next = spring.deflected(0.2 + 0.5e-7, 0.5, 0.0);
        assert!(((next.energy - d.energy) / 1e-7 - (d.torque * 0.5 - d.loss)).abs() < 1e-4);
    }

    #[test]
    fn play_is_free_and_its_ends_are_smooth() {
        let spring = SeriesSpring { damping: 3.0, ..SeriesSpring::default() };
        assert_eq!(spring.deflected(0.009, 1.0, 0.02).torque, 0.0);
        assert!(spring.deflected(0.01 + 1e-9, 1.0, 0.02).torque < 1e-6);
        assert!((spring.deflected(0.11, 0.0, 0.02).torque - 25.0).abs() < 1e-12);
        assert_eq!(spring.deflected(-0.11, 0.0, 0.02).torque, -spring.deflected(0.11, 0.0, 0.02).torque);
        for torque in [-30.0, 0.0, 12.0] {
            let d = spring.deflection_of(torque, 0.02);
            assert!((spring.deflected(d, 0.0, 0.02).torque - torque).abs() < 1e-12);
        }
    }

    #[test]
    fn a_parallel_spring_acts_on_its_side() {
        let both = ParallelSpring { stiffness: 100.0, neutral_angle: 0.1, ..ParallelSpring::default() };
        assert!((both.at(0.3).0 + 20.0).abs() < 1e-12 && (both.at(0.3).1 - 2.0).abs() < 1e-12);
        let above = ParallelSpring { engagement: Engagement::Above, ..both };
        assert_eq!((above.at(0.3), above.at(0.0)), (both.at(0.3), (0.0, 0.0)));
        assert!(above.is_one_sided() && !both.is_one_sided());
        assert!(!ParallelSpring { stiffness: 0.0, ..above }.is_one_sided());
        let below = ParallelSpring { engagement: Engagement::Below, ..both };
        assert_eq!((below.at(0.3), below.at(0.0)), ((0.0, 0.0), both.at(0.0)));
    }
}
