//! Transmission from the motor's shaft to the spring: a gear, or a ball screw with a lever.
//!
//! gear          angle_out = phi / ratio,                                      N = ratio             (1)
//! ball screw    angle_out = neutral + asin(lead phi / (2 pi lever)),
//!               N = d phi / d angle_out = (2 pi lever / lead) cos(angle_out - neutral)              (2)
//! torque        tau_in = tau_out / N + (1/efficiency - 1) |tau_out / N| sign(w)                     (3)
//!
//! phi is the angle of the shaft, 0 where a screw is perpendicular to its lever. By (3) a driving motor gives 1/efficiency of the load
//! torque, and a driving load returns 2 - 1/efficiency of it. Below an efficiency of one half the transmission is self-locking; `sign`, a
//! tanh, allows creep.
//! *Assumes* no mass except `inertia` on the input shaft behind an elastic coupling (the actuator's equations); with a rigid coupling add
//! it to the motor's inertia.
//! *Range*: the screw up to 0.95 of its lever's length; (2) continues along its tangent there.
//! *Source*: (3) as in the Modelica Standard Library, Rotational.Components.LossyGear; the efficiency of a screw that is
//! back-driven, 2 - 1/efficiency, is the manufacturers' rule.

use crate::number::smooth_sign;
use declare::{Unit, Variable, enumeration, variables};
use std::f64::consts::TAU;

enumeration! {
    /// Kind of transmission
    pub enum TransmissionKind {
        /// A gear, belt or capstan: transmission.ratio
        Gear = 1, "gear";
        /// A ball screw that pushes a lever on the joint: transmission.lead and transmission.lever
        BallScrew = 2, "ball_screw";
    }
}

enumeration! {
    /// Coupling between motor shaft and input shaft
    pub enum Coupling {
        /// Rigid; the inertia of the input shaft belongs to the motor's inertia
        Rigid = 1, "rigid";
        /// Elastic coupling or belt, with an inertia on the input shaft
        Elastic = 2, "elastic";
    }
}

variables! {
    /// The transmission between motor and spring.
    pub struct Transmission {
        /// Kind of transmission
        kind: TransmissionKind = Variable::choice(0, 1),
        /// Gear ratio, motor angle over spring input angle (kind gear)
        ratio: f64 = Variable::tunable(1, 250.0, Unit::One, 0.1, 1e5).log()
            .source("estimate for an ankle in level walking"),
        /// Lead of the ball screw: travel of the nut per revolution
        lead: f64 = Variable::tunable(2, 0.002, Unit::Metre, 1e-5, 1.0).log()
            .source("estimate: catalogue size of ball screws"),
        /// Length of the lever that the nut pushes (kind ball_screw)
        lever: f64 = Variable::tunable(3, 0.06, Unit::Metre, 1e-4, 10.0).log()
            .source("estimate: lever of a powered ankle"),
        /// Angle of the spring's input at which the screw is perpendicular to the lever (kind ball_screw)
        neutral_angle: f64 = Variable::tunable(4, 0.0, Unit::Radian, -4.0, 4.0),
        /// Efficiency when the motor drives the load
        efficiency: f64 = Variable::tunable(5, 0.85, Unit::One, 0.05, 1.0)
            .source("estimate: catalogues of planetary gears and ball screws"),
        /// Speed of the motor below which the friction falls to zero
        w_small: f64 = Variable::tunable(6, 1.0, Unit::RadianPerSecond, 1e-6, 1e3).log()
            .source("regularisation width, chosen"),
        /// Backlash between transmission and spring, total, at the joint
        backlash: f64 = Variable::tunable(7, 0.0, Unit::Radian, 0.0, 1.0).nominal(0.01),
        /// Coupling between motor shaft and input shaft
        coupling: Coupling = Variable::choice(8, 1),
        /// Moment of inertia of the input shaft (coupling elastic)
        inertia: f64 = Variable::tunable(9, 1e-6, Unit::KilogramSquareMetre, 1e-12, 1e3).log()
            .source("estimate"),
        /// Stiffness of the elastic coupling or belt
        coupling_stiffness: f64 = Variable::tunable(10, 1.0, Unit::NewtonMetrePerRadian, 1e-6, 1e6).log()
            .source("estimate"),
        /// Damping of the elastic coupling or belt
        coupling_damping: f64 = Variable::tunable(11, 1e-4, Unit::NewtonMetreSecond, 0.0, 1e3)
            .source("estimate"),
    }
}

/// Fraction of the lever's length up to which the screw's kinematics is exact.
const REACH: f64 = 0.95;

impl Transmission {
    /// Turns of a screw per radian of its lever where they are perpendicular.
    fn screw(&self) -> f64 {
        TAU * self.lever / self.lead
    }

    /// Angle of the spring's input, rad, and the ratio: eqs. (1) and (2) at the shaft angle `phi`, rad.
    #[inline]
    pub fn output(&self, phi: f64) -> (f64, f64) {
        match self.kind {
            TransmissionKind::Gear => (phi / self.ratio, self.ratio),
            TransmissionKind::BallScrew => {
                let way = phi / self.screw();
                let inside = way.clamp(-REACH, REACH);
                let cosine = (1.0 - inside * inside).sqrt();
                (self.neutral_angle + inside.asin() + (way - inside) / cosine, self.screw() * cosine)
            }
        }
    }

    /// Shaft angle, rad, for the angle `angle` of the spring's input, rad: the inverse of
    /// [`output`](Transmission::output).
    pub fn turn(&self, angle: f64) -> f64 {
        match self.kind {
            TransmissionKind::Gear => angle * self.ratio,
            TransmissionKind::BallScrew => {
                let from_square = angle - self.neutral_angle;
                let most = REACH.asin();
                let inside = from_square.clamp(-most, most);
                self.screw() * (inside.sin() + (from_square - inside) * most.cos())
            }
        }
    }

    /// Required shaft torque, N.m: eq. (3) for the output torque `out` at the spring, N.m, the ratio
    /// `n` and the shaft's speed `w`, rad/s; and the friction part.
    #[inline]
    pub fn input_torque(&self, out: f64, n: f64, w: f64) -> (f64, f64) {
        let carried = out / n;
        let friction = (1.0 / self.efficiency - 1.0) * carried.abs() * smooth_sign(w, self.w_small);
        (carried + friction, friction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screw() -> Transmission {
        Transmission { kind: TransmissionKind::BallScrew, neutral_angle: 0.3, ..Transmission::default() }
    }

    /// A screw of 2 mm on a lever of 60 mm: 2 pi 30 = 188.5 turns per turn where they are perpendicular, cos(0.5) of it half a
    /// radian on.
    #[test]
    fn the_ratio_is_the_slope_of_the_way() {
        let screw = screw();
        assert!((screw.output(0.0).1 - 188.495_559).abs() < 1e-6);
        for angle in [-1.4, -0.7, 0.3, 0.8, 1.5] {
            let phi = screw.turn(angle);
            let (back, n) = screw.output(phi);
            assert!((back - angle).abs() < 1e-12, "{angle} {back}");
            let slope = (screw.turn(angle + 1e-6) - screw.turn(angle - 1e-6)) / 2e-6;
            assert!((n / slope - 1.0).abs() < 1e-6, "{angle} {n} {slope}");
        }
        let n = screw.output(screw.turn(0.8)).1;
        assert!((n / 188.495_559 - 0.5f64.cos()).abs() < 1e-8);
    }

    /// Value and derivative are continuous where the tangent begins.
    #[test]
    fn the_tangent_joins_smoothly() {
        let screw = screw();
        let edge = REACH * screw.screw();
        let (low, high) = (screw.output(edge * (1.0 - 1e-9)), screw.output(edge * (1.0 + 1e-9)));
        assert!((low.0 - high.0).abs() < 1e-8 && (low.1 / high.1 - 1.0).abs() < 1e-7);
        assert!(screw.output(2.0 * edge).0.is_finite());
    }

    /// 100 N.m over 250 at 0.85: a driving motor gives 0.4 / 0.85; a driving load returns 0.4 (2 - 1/0.85).
    #[test]
    fn efficiency_counts_against_the_motor_both_ways() {
        let gear = Transmission::default();
        let (drives, friction) = gear.input_torque(100.0, 250.0, 50.0);
        assert!((drives - 0.4 / 0.85).abs() < 1e-12 && friction > 0.0);
        let (driven, friction) = gear.input_torque(100.0, 250.0, -50.0);
        assert!((driven - 0.4 * (2.0 - 1.0 / 0.85)).abs() < 1e-12 && friction < 0.0);
        assert_eq!(gear.input_torque(100.0, 250.0, 0.0), (0.4, 0.0));
    }
}
