//! Control of a series elastic actuator: current command from the torque demand, voltage command from the current command.
//!
//! spring          e = tau_d - tau_s,   e' = (tau_d - tau_f) / T - tau_s',   tau_f' = (tau_d - tau_f) / T       (1)
//! current command k_t i = tau_in(tau_d, w_d) + tau_c tanh(w_d / w_s) + (J N / k) (w0^2 e + 2 z w0 e')          (2)
//! limits          |i| <= i_max   and   |R i + k_t w| <= the supply's voltage                                    (3)
//! voltage command u = R i + k_t w + v,   limited to the supply's                                                (4)
//! integral        v' = w_i (R (i - i_m) + u_limited - u)                                                        (5)
//!
//! N tau_s'' / k is the motor's acceleration in terms of the spring torque, so the torque error of (2) decays as
//! e'' + 2 z w0 e' + w0^2 e = 0 for any spring and ratio. w_d is the motor speed that follows joint and demand. (5) compensates the change
//! of R and k_t in a warm motor; it is stopped at a limit (anti-windup).
//! *Assumes* noise-free measurements of angle, speed and current. *Neglects* sampling other than the communication step,
//! and the joint's acceleration, which the feedback of (2) corrects.
//! *Source*: the law of (2) is computed-torque control with a linear error equation, as in Robinson et al., Series elastic
//! actuator development for a biomimetic walking robot, AIM 1999; back-calculation (5): Astrom, Hagglund, PID
//! Controllers, 2nd ed. 1995, section 3.5.

use crate::number::smooth_sign;
use declare::{Unit, Variable, variables};
use std::f64::consts::TAU;

variables! {
    /// The control, with its motor data: the declared values are those of the declared motor.
    pub struct TorqueControl {
        /// Natural frequency of the torque's error
        natural_frequency: f64 = Variable::tunable(0, 40.0, Unit::Hertz, 0.01, 1e4).log()
            .source("design choice"),
        /// Damping ratio of the torque's error
        damping_ratio: f64 = Variable::tunable(1, 1.0, Unit::One, 0.0, 10.0)
            .source("design choice: no overshoot"),
        /// Time constant of the filter that differentiates the demand
        filter_time: f64 = Variable::tunable(2, 0.002, Unit::Second, 1e-5, 10.0).log()
            .source("design choice"),
        /// Current limit of the drive
        current_max: f64 = Variable::tunable(3, 30.0, Unit::Ampere, 0.0, 1e4)
            .source("design choice"),
        /// Bandwidth of the current control's integral part
        current_bandwidth: f64 = Variable::tunable(4, 50.0, Unit::Hertz, 0.0, 1e4)
            .source("design choice"),
        /// Torque constant of the motor, as known to the control
        k_t: f64 = Variable::tunable(5, 0.0276, Unit::NewtonMetrePerAmpere, 1e-6, 1e3).log()
            .source("maxon datasheet 305015"),
        /// Terminal resistance of the motor, as known to the control
        R: f64 = Variable::tunable(6, 0.386, Unit::Ohm, 1e-6, 1e4).log()
            .source("maxon datasheet 305015"),
        /// Moment of inertia of rotor and transmission at the motor's shaft, as known to the control
        J: f64 = Variable::tunable(7, 33.3e-7, Unit::KilogramSquareMetre, 1e-12, 1e3).log()
            .source("maxon datasheet 305015: rotor alone"),
        /// Coulomb friction of the motor, compensated by the control
        tau_c: f64 = Variable::tunable(8, 0.0, Unit::NewtonMetre, 0.0, 1e3),
        /// Speed of the motor below which the friction compensation falls to zero
        w_small: f64 = Variable::tunable(9, 5.0, Unit::RadianPerSecond, 1e-6, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

/// Measurements for the control.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Demanded spring torque, N.m.
    pub demand: f64,
    /// Motor torque for the demand, friction of the transmission included, N.m.
    pub feed_forward: f64,
    /// Motor speed that follows joint and demand, rad/s.
    pub way_speed: f64,
    /// Torque in the spring, N.m, and its rate, N.m/s.
    pub torque: [f64; 2],
    /// Ratio of motor angle to the spring's input angle, divided by the spring's stiffness, rad/N.m.
    pub turns_per_torque: f64,
    /// Speed of the motor, rad/s, and its current, A.
    pub motor: [f64; 2],
    /// Voltage of the supply, V.
    pub supply: f64,
}

/// The commanded current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Before and after the limits, A.
    pub current: [f64; 2],
    /// Lower and upper current limit of drive and supply, A.
    pub limits: [f64; 2],
    /// Back-EMF, V, and supply voltage, V.
    emf: f64,
    supply: f64,
    /// Rate of the filtered demand, N.m/s.
    demand_rate: f64,
}

/// Outputs of the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Current command before and after the limits, A.
    pub current: [f64; 2],
    /// Lower and upper current limit of drive and supply, A.
    pub limits: [f64; 2],
    /// Voltage command before and after the limit, V.
    pub voltage: [f64; 2],
    /// Rates of its two states: the filtered demand, N.m/s, and the integral, V/s.
    pub rates: [f64; 2],
}

impl Command {
    /// Whether the supply voltage limits the voltage command.
    #[inline]
    pub fn is_limited(&self) -> bool {
        self.voltage[0] != self.voltage[1]
    }
}

impl Wanted {
    /// Whether drive or supply limits the current command.
    #[inline]
    pub fn is_limited(&self) -> bool {
        self.current[0] != self.current[1]
    }
}

impl TorqueControl {
    /// Rate of the demand, N.m/s, from the filter state `filtered`.
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
        // Extrapolation of the input may give a negative supply voltage.
        let supply = seen.supply.max(0.0);
        let low = (-self.current_max).max((-supply - emf) / self.R);
        let high = self.current_max.min((supply - emf) / self.R);
        // If the back-EMF exceeds the supply by too much, no current is feasible; the motor brakes at the drive's current limit.
        let current = if low <= high {
            wanted.clamp(low, high)
        } else {
            (0.5 * (low + high)).clamp(-self.current_max, self.current_max)
        };
        Wanted { current: [wanted, current], limits: [low, high], emf, supply, demand_rate }
    }

    /// Rate of the integral, V/s, at unlimited voltage: eq. (5) for the current command and the measured current, A.
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

    /// Torque error 1 N.m: additional current J (N/k) w0^2 / k_t = 33.3e-7 * (2 pi 40)^2 / 0.0276 = 7.6211 A.
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
        // At 1500 rad/s 6.6 V remain above the back-EMF: 17.1 A.
        let c = command(&control, &Seen { motor: [1500.0, 0.0], ..hard }, [5000.0, 0.0]);
        assert!((c.current[1] - (48.0 - 0.0276 * 1500.0) / 0.386).abs() < 1e-9 && c.voltage[1] == 48.0);
        // Above the no-load speed the motor brakes at the drive's current limit, in both directions.
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
