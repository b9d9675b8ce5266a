//! The control of a series elastic actuator: a demanded torque becomes a current, a current a voltage.
//!
//! spring          e = tau_d - tau_s,   e' = (tau_d - tau_f) / T - tau_s',   tau_f' = (tau_d - tau_f) / T       (1)
//! current wanted  k_t i = tau_in(tau_d, w_d) + tau_c tanh(w_d / w_s) + (J N / k) (w0^2 e + 2 z w0 e')          (2)
//! limits          |i| <= i_max   and   |R i + k_t w| <= the supply's voltage                                    (3)
//! voltage wanted  u = R i + k_t w + v,   limited to the supply's                                                (4)
//! integral        v' = w_i (R (i - i_m) + u_limited - u)                                                        (5)
//!
//! N tau_s'' / k is the motor's acceleration as the spring sees it, so (2) lets the torque's error die as
//! e'' + 2 z w0 e' + w0^2 e = 0, whatever spring and ratio. w_d is the speed at which the motor moves with joint and
//! demand. (5) finds what R and k_t have become in a warm motor; at a limit it stops.
//! *Assumes* that angle, speed and current are measured without noise. *Neglects* sampling beyond that of the importer,
//! and the joint's acceleration, which (2) leaves to the feedback.
//! *Source*: the law of (2) is computed torque with a linear error equation, as in Robinson et al., Series elastic
//! actuator development for a biomimetic walking robot, AIM 1999; back-calculation (5): Astrom, Hagglund, PID
//! Controllers, 2nd ed. 1995, section 3.5.

use crate::effects::smooth_sign;
use declare::{Unit, Variable, variables};
use std::f64::consts::TAU;

variables! {
    /// The control, and what it believes of its motor: the declared values are those of preset maxon-305015.
    pub struct TorqueControl {
        /// Natural frequency of the torque's error
        natural_frequency: f64 = Variable::tunable(0, 40.0, Unit::Hertz, 0.01, 1e4).log()
            .source("design choice"),
        /// Damping ratio of the torque's error
        damping_ratio: f64 = Variable::tunable(1, 1.0, Unit::One, 0.0, 10.0)
            .source("design choice: no overshoot"),
        /// Time constant of the filter that gives the demand's rate
        filter_time: f64 = Variable::tunable(2, 0.002, Unit::Second, 1e-5, 10.0).log()
            .source("design choice"),
        /// Greatest current of the drive
        current_max: f64 = Variable::tunable(3, 30.0, Unit::Ampere, 0.0, 1e4)
            .source("design choice"),
        /// Bandwidth with which the voltage follows the current's error
        current_bandwidth: f64 = Variable::tunable(4, 50.0, Unit::Hertz, 0.0, 1e4)
            .source("design choice"),
        /// Torque constant that the control counts with
        k_t: f64 = Variable::tunable(5, 0.0276, Unit::NewtonMetrePerAmpere, 1e-6, 1e3).log()
            .source("maxon datasheet 305015"),
        /// Resistance that the control counts with
        R: f64 = Variable::tunable(6, 0.386, Unit::Ohm, 1e-6, 1e4).log()
            .source("maxon datasheet 305015"),
        /// Moment of inertia of rotor and transmission that the control counts with
        J: f64 = Variable::tunable(7, 33.3e-7, Unit::KilogramSquareMetre, 1e-12, 1e3).log()
            .source("maxon datasheet 305015: rotor alone"),
        /// Dry friction of the motor that the control makes up for
        tau_c: f64 = Variable::tunable(8, 9.83e-3, Unit::NewtonMetre, 0.0, 1e3)
            .source("maxon datasheet 305015: no-load current 0.356 A times k_t"),
        /// Speed of the motor below which it makes up for less
        w_small: f64 = Variable::tunable(9, 5.0, Unit::RadianPerSecond, 1e-6, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

/// What the control sees of the spring.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Torque demanded of the spring, N.m.
    pub demand: f64,
    /// Torque that the motor must give for it at rest or on the way, N.m.
    pub feed_forward: f64,
    /// Speed that the motor has on that way, rad/s.
    pub way_speed: f64,
    /// Torque in the spring, N.m, and its rate, N.m/s.
    pub torque: [f64; 2],
    /// Turns of the motor for one of the spring's input, over the spring's stiffness, rad/N.m.
    pub turns_per_torque: f64,
    /// Speed of the motor, rad/s, and its current, A.
    pub motor: [f64; 2],
    /// Voltage of the supply, V.
    pub supply: f64,
}

/// The current that the control wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Before and after the limits, A.
    pub current: [f64; 2],
    /// Least and greatest current that drive and supply allow, A.
    pub limits: [f64; 2],
    /// Voltage that the speed induces, V, and the most that the supply gives, V.
    emf: f64,
    supply: f64,
    /// Rate of the filtered demand, N.m/s.
    demand_rate: f64,
}

/// What the control does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Current wanted, before and after the limits, A.
    pub current: [f64; 2],
    /// Least and greatest current that drive and supply allow, A.
    pub limits: [f64; 2],
    /// Voltage wanted, before and after the limit, V.
    pub voltage: [f64; 2],
    /// Rates of its two states: the filtered demand, N.m/s, and the integral, V/s.
    pub rates: [f64; 2],
}

impl Command {
    /// Whether the supply gives less voltage than is wanted.
    #[inline]
    pub fn is_limited(&self) -> bool {
        self.voltage[0] != self.voltage[1]
    }
}

impl Wanted {
    /// Whether drive or supply allow less current than is wanted.
    #[inline]
    pub fn is_limited(&self) -> bool {
        self.current[0] != self.current[1]
    }
}

impl TorqueControl {
    /// Rate of the demand, N.m/s, that the filter at `filtered` tells.
    #[inline]
    pub fn demand_rate(&self, demand: f64, filtered: f64) -> f64 {
        (demand - filtered) / self.filter_time
    }

    /// Eqs. (1) to (3), for the rate of the demand, N.m/s.
    #[inline(always)]
    pub fn wanted(&self, seen: &Seen, demand_rate: f64) -> Wanted {
        let [e, rate] = [seen.demand - seen.torque[0], demand_rate - seen.torque[1]];
        let w0 = TAU * self.natural_frequency;
        let feedback = self.J * seen.turns_per_torque * (w0 * w0 * e + 2.0 * self.damping_ratio * w0 * rate);
        let friction = self.tau_c * smooth_sign(seen.way_speed, self.w_small);
        let wanted = (seen.feed_forward + friction + feedback) / self.k_t;
        let emf = self.k_t * seen.motor[0];
        // A slope may have led the supply below nothing, which is nothing.
        let supply = seen.supply.max(0.0);
        let low = (-self.current_max).max((-supply - emf) / self.R);
        let high = self.current_max.min((supply - emf) / self.R);
        // A motor that overhauls its supply leaves no current that fits; then it brakes with what the drive can.
        let current = if low <= high {
            wanted.clamp(low, high)
        } else {
            (0.5 * (low + high)).clamp(-self.current_max, self.current_max)
        };
        Wanted { current: [wanted, current], limits: [low, high], emf, supply, demand_rate }
    }

    /// Rate of the integral, V/s, where the voltage is not limited: eq. (5) for the current wanted and the one
    /// measured, A.
    #[inline(always)]
    pub fn winding_up(&self, wanted: &Wanted, measured: f64) -> f64 {
        TAU * self.current_bandwidth * (self.R * (wanted.current[1] - measured))
    }

    /// Eqs. (4) and (5), for the current measured, A, and the integral, V.
    #[inline(always)]
    pub fn voltage(&self, wanted: &Wanted, measured: f64, integral: f64) -> Command {
        let current = wanted.current[1];
        let voltage = self.R * current + wanted.emf + integral;
        let limited = voltage.clamp(-wanted.supply, wanted.supply);
        let rate = TAU * self.current_bandwidth * (self.R * (current - measured) + limited - voltage);
        Command {
            current: wanted.current,
            limits: wanted.limits,
            voltage: [voltage, limited],
            rates: [wanted.demand_rate, rate],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen() -> Seen {
        Seen {
            demand: 50.0,
            feed_forward: 0.2,
            way_speed: 0.0,
            torque: [50.0, 0.0],
            turns_per_torque: 1.0,
            motor: [0.0, 0.2 / 0.0276],
            supply: 48.0,
        }
    }

    fn command(control: &TorqueControl, seen: &Seen, [filtered, integral]: [f64; 2]) -> Command {
        let wanted = control.wanted(seen, control.demand_rate(seen.demand, filtered));
        control.voltage(&wanted, seen.motor[1], integral)
    }

    #[test]
    fn at_rest_with_the_right_torque_it_feeds_forward_alone() {
        let control = TorqueControl::default();
        let c = command(&control, &seen(), [50.0, 0.0]);
        assert!((c.current[1] - 0.2 / 0.0276).abs() < 1e-12);
        assert!((c.voltage[1] - 0.386 * 0.2 / 0.0276).abs() < 1e-12);
        assert!(c.rates.iter().all(|r| r.abs() < 1e-9));
    }

    #[test]
    fn a_supply_below_nothing_gives_nothing() {
        let control = TorqueControl::default();
        let gone = |supply| command(&control, &Seen { supply, ..seen() }, [50.0, 0.0]).voltage[1];
        assert_eq!((gone(-48.0), gone(0.0)), (0.0, 0.0));
    }

    /// 1 N.m short: J (N/k) w0^2 / k_t = 33.3e-7 * (2 pi 40)^2 / 0.0276 = 7.6211 A more.
    #[test]
    fn an_error_is_answered_by_its_natural_frequency() {
        let control = TorqueControl::default();
        let c = command(&control, &Seen { torque: [49.0, 0.0], ..seen() }, [50.0, 0.0]);
        assert!((c.current[0] - 0.2 / 0.0276 - 7.621_1).abs() < 1e-3, "{:?}", c.current);
    }

    #[test]
    fn current_and_voltage_stay_within_their_limits() {
        let control = TorqueControl::default();
        let hard = Seen { demand: 5000.0, feed_forward: 20.0, ..seen() };
        let c = command(&control, &hard, [5000.0, 0.0]);
        assert_eq!(c.current[1], 30.0);
        // At 1500 rad/s the back-EMF leaves 6.6 V, 17.1 A.
        let c = command(&control, &Seen { motor: [1500.0, 0.0], ..hard }, [5000.0, 0.0]);
        assert!((c.current[1] - (48.0 - 0.0276 * 1500.0) / 0.386).abs() < 1e-9 && c.voltage[1] == 48.0);
        // Pushed beyond its supply it brakes with all that the drive can, in either direction.
        for speed in [5000.0, -5000.0] {
            let c = command(&control, &Seen { motor: [speed, 0.0], ..hard }, [5000.0, 0.0]);
            assert!(c.current[1] == -30.0 * speed.signum() && c.voltage[1] == 48.0 * speed.signum());
        }
    }

    #[test]
    fn at_the_limit_the_integral_unwinds() {
        let control = TorqueControl::default();
        let c = command(&control, &seen(), [50.0, 100.0]);
        assert!(c.voltage[1] == 48.0 && c.rates[1] < 0.0);
    }
}
