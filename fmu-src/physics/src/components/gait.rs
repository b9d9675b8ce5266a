//! A joint of a walking person: angle, speed and torque over the stride, from measured data.
//!
//! stride      s' = 1 / T(s),   phase = s - floor(s)                                                         (1)
//! angle       angle = a(t) A(s) q(phase),   speed = its derivative                                          (2)
//! torque      torque = a(t) B(s) body_mass support m(phase)                                                 (3)
//! start, stop a(t) = r((t - start) / ramp) - r((t - stop) / ramp),   r(x) = 6 x^5 - 15 x^4 + 10 x^3         (4)
//! variation   T(s) = T_0 (1 + v z_1(s)), A = 1 + v z_2(s), B = 1 + v z_3(s); z is interpolated along r
//!             between random numbers at the middle of each stride                                           (5)
//!
//! q and m are periodic cubic splines through the measured points, so that speed and torque are smooth within a stride
//! and from one stride to the next.
//!
//! With the activity `table` q and B(s) m are those of a [`LoadTable`](crate::load_table::LoadTable): straight lines through its rows
//! of torque and speed, without the factor
//! body_mass. If its shaft turns by D in each period, D s is added to (2): a(t) and A(s) act on the motion relative to the mean speed.
//! *Assumes* that torque scales with body mass, that a standing person has joint angle 0 and no torque, and that the
//! strides of (5) vary independently: v is the coefficient of variation of each quantity (of stride time about 0.02 in
//! healthy adults on level ground).
//! *Sign*: angle and torque are positive in extension (plantarflexion at the ankle), so that torque times speed > 0 is
//! power into the leg.
//! *Source*: `tables.rs`. Each item of [`Activity`] names its subjects and publication; every report of a result includes that text.

mod spline;
mod tables;
mod variation;

use declare::{Unit, Variable, enumeration, variables};
pub use tables::Cycle;
use tables::cycle;
use variation::Quantity;

enumeration! {
    /// Activity, with the subjects and the publication of its data
    pub enum Activity {
        /// Level walking of children, very slow, 1.58 s per stride (Schwartz et al. 2008)
        ChildWalkVerySlow = 1, "child_walk_very_slow";
        /// Level walking of children, slow, 1.38 s per stride (Schwartz et al. 2008)
        ChildWalkSlow = 2, "child_walk_slow";
        /// Level walking of adults, 1.14 s per stride (Grimmer and Seyfarth 2014)
        Walk = 3, "walk";
        /// Level walking of children, fast, 0.97 s per stride (Schwartz et al. 2008)
        ChildWalkFast = 4, "child_walk_fast";
        /// Level walking of children, very fast, 0.81 s per stride (Schwartz et al. 2008)
        ChildWalkVeryFast = 5, "child_walk_very_fast";
        /// Stairs up, adults, 1.11 s per stride; power measured, torque and speed estimated (Boehme 2022)
        StairsUp = 6, "stairs_up";
        /// Stairs down, adults, 1.11 s per stride; power measured, torque and speed estimated (Boehme 2022)
        StairsDown = 7, "stairs_down";
        /// Level walking of children at self-selected speed, 1.12 s per stride (Schwartz et al. 2008)
        ChildWalk = 8, "child_walk";
        /// Torque and speed of resources/load.json, which motor-fmu build --load writes; body mass and joint have no effect
        Table = 9, "table";
    }
}

enumeration! {
    /// Which joint is loaded
    pub enum Joint {
        /// The hip
        Hip = 1, "hip";
        /// The knee
        Knee = 2, "knee";
        /// The ankle
        Ankle = 3, "ankle";
    }
}

variables! {
    /// Person, activity, and the fraction of the torque that the actuator provides.
    pub struct Gait {
        /// Body mass, including carried loads
        body_mass: f64 = Variable::tunable(0, 75.0, Unit::Kilogram, 1.0, 500.0)
            .source("usual adult of gait studies"),
        /// Activity, with the subjects and the publication of its data
        activity: Activity = Variable::choice(1, 3),
        /// Loaded joint
        joint: Joint = Variable::choice(2, 3),
        /// Fraction of the biological torque that is demanded of the actuator
        support: f64 = Variable::tunable(3, 1.0, Unit::One, -2.0, 2.0)
            .source("the whole biological torque"),
        /// Coefficient of variation between strides, of stride time, range of angle and torque each
        variation: f64 = Variable::tunable(4, 0.0, Unit::One, 0.0, 0.2),
        /// Seed of the random numbers of the variation
        seed: i32 = Variable::tunable_count(5, 1, 0, 1_000_000_000)
            .source("arbitrary"),
        /// Gait phase at the start, from heel strike
        initial_phase: f64 = Variable::tunable(6, 0.0, Unit::One, 0.0, 1.0),
        /// Time at which walking begins; where it is earlier than the start of the simulation by more than the ramp, the person walks from the start
        start_time: f64 = Variable::tunable(7, -10.0, Unit::Second, -1e6, 1e9).nominal(10.0)
            .source("earlier than any start by more than the ramp"),
        /// Time at which the person begins to stop
        stop_time: f64 = Variable::tunable(8, 1e9, Unit::Second, -1e6, 1e9).nominal(10.0)
            .source("later than any stop"),
        /// Duration of starting and of stopping
        ramp_time: f64 = Variable::tunable(9, 2.0, Unit::Second, 0.01, 1e3).log()
            .source("estimate"),
    }
}

/// The joint at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Angle, rad.
    pub angle: f64,
    /// Speed, rad/s.
    pub speed: f64,
    /// Demanded torque, N.m.
    pub torque: f64,
    /// Stride rate, 1/s.
    pub stride_rate: f64,
}

/// A smooth step from 0 to 1, and its derivative.
fn ramp(x: f64) -> (f64, f64) {
    let x = x.clamp(0.0, 1.0);
    (x * x * x * (x * (6.0 * x - 15.0) + 10.0), 30.0 * x * x * (1.0 - x) * (1.0 - x))
}

/// Floor of `x`, by conversion where possible: faster than the library call.
#[inline]
pub fn floor(x: f64) -> f64 {
    /// From here on every f64 is an integer.
    const WHOLE: f64 = (1u64 << 52) as f64;
    if x.abs() < WHOLE {
        let near = x as i64 as f64;
        if near > x { near - 1.0 } else { near }
    } else {
        x
    }
}

/// Why the activity `table` cannot start.
pub const NO_TABLE: &str = "gait.activity = table needs a load table, and this model has none: build the FMU with \
                            motor-fmu build GaitLoad --load FILE, or select another activity.";

impl Gait {
    /// Amplitude a(t) of the gait at `time`, s, and its rate, 1/s: eq. (4).
    #[inline]
    fn share(&self, time: f64) -> (f64, f64) {
        let at = |from: f64| {
            let since = time - from;
            if since <= 0.0 {
                (0.0, 0.0)
            } else if since >= self.ramp_time {
                (1.0, 0.0)
            } else {
                ramp(since / self.ramp_time)
            }
        };
        let (on, off) = (at(self.start_time), at(self.stop_time));
        let rate = on.1 - off.1;
        (on.0 - off.0, if rate == 0.0 { 0.0 } else { rate / self.ramp_time })
    }

    /// The cycle of the activity, and the mass that its torque refers to, kg.
    fn cycle<'a>(&self, table: Option<&'a Cycle>) -> Option<(&'a Cycle, f64)> {
        match cycle(self.activity, self.joint) {
            Some(measured) => Some((measured, self.body_mass)),
            None => Some((table?, 1.0)),
        }
    }

    /// State of the joint at `time`, s, and stride coordinate `stride`: eqs. (2) to (5); at rest if the required load table is missing.
    pub fn at(&self, table: Option<&Cycle>, time: f64, stride: f64) -> Motion {
        let Some((cycle, mass)) = self.cycle(table) else { return Motion::default() };
        let varied = |quantity| {
            let (z, slope) =
                if self.variation > 0.0 { variation::of(self.seed, quantity, stride) } else { (0.0, 0.0) };
            (1.0 + self.variation * z, self.variation * slope)
        };
        let (share, share_rate) = self.share(time);
        let stride_rate = 1.0 / (cycle.stride_time * varied(Quantity::Time).0);
        let phase = stride - floor(stride);
        let (q, q_slope) = cycle.angle.at(phase);
        let (range, range_slope) = varied(Quantity::Angle);
        let (strength, _) = varied(Quantity::Torque);
        let mut motion = Motion {
            angle: share * range * q,
            speed: share_rate * range * q + share * (range_slope * q + range * q_slope) * stride_rate,
            torque: share * strength * mass * self.support * cycle.torque.at(phase).0,
            stride_rate,
        };
        if cycle.turn != 0.0 {
            motion.angle += cycle.turn * stride;
            motion.speed += cycle.turn * stride_rate;
        }
        motion
    }

    /// Number of strides and demanded work, J, over the `h` seconds from `time`, s, and stride coordinate `stride`: the integrals of
    /// (1) and of torque times speed. `None` where strides vary or the amplitude changes.
    #[inline]
    pub fn on(&self, table: Option<&Cycle>, time: f64, stride: f64, h: f64) -> Option<(f64, f64)> {
        let changes = |from: f64| time < from + self.ramp_time && time + h > from;
        if self.variation > 0.0 || changes(self.start_time) || changes(self.stop_time) {
            return None;
        }
        let ((cycle, mass), (share, _)) = (self.cycle(table)?, self.share(time));
        // At a different amplitude the mean speed and the motion relative to it have different factors.
        if cycle.turn != 0.0 && share != 1.0 {
            return None;
        }
        let strides = h / cycle.stride_time;
        let (from, to) = (stride, stride + strides);
        let (whole_from, whole_to) = (floor(from), floor(to));
        let turns = whole_to - whole_from;
        let work =
            cycle.work.to(to - whole_to) - cycle.work.to(from - whole_from) + turns * cycle.work.whole();
        Some((strides, share * share * mass * self.support * work))
    }

    /// The first time after `time`, s, at which the start or stop ramp begins or ends.
    pub fn next_event(&self, time: f64) -> f64 {
        let ends = |from: f64| [from, from + self.ramp_time];
        let all = ends(self.start_time).into_iter().chain(ends(self.stop_time));
        all.filter(|&t| t > time).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_table::LoadTable;

    fn walk() -> Gait {
        Gait::default()
    }

    /// The adult's ankle compared with the digitised curve: peak torque, and its phase in the stride; the children's data stay
    /// available under their own name.
    #[test]
    fn the_default_ankle_is_the_measured_adult() {
        let text = include_str!("../../data/gait-walking-stairs-cc0/walking_ankle_torque.csv");
        let rows = text.lines().skip(1).map(|line| {
            let mut cells = line.split(',').map(|cell| cell.parse::<f64>().unwrap());
            (cells.next().unwrap(), cells.next().unwrap())
        });
        let (percent, measured) = rows.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((measured - 1.37).abs() < 1e-3);
        let peak = |gait: &Gait| {
            let torque = |k: u32| gait.at(None, 0.0, f64::from(k) / 1000.0).torque / 75.0;
            (0..1000).map(|k| (k, torque(k))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
        };
        let (at, found) = peak(&walk());
        assert!((found - measured).abs() < 5e-3, "{found} {measured}");
        assert!((f64::from(at) / 10.0 - percent).abs() < 0.5, "{at} {percent}");
        let (_, child) = peak(&Gait { activity: Activity::ChildWalk, ..walk() });
        assert!((child - 1.2298).abs() < 0.01, "{child}");
        assert_eq!(Activity::Walk as i32, 3);
    }

    /// Push-off power, and the ranges of motion from the integrated speeds with the stride time of adults.
    #[test]
    fn the_adult_moves_as_adults_do() {
        let at = |joint, k: u32| Gait { joint, ..walk() }.at(None, 0.0, f64::from(k) / 1000.0);
        let power =
            (0..1000).map(|k| at(Joint::Ankle, k)).map(|m| m.torque * m.speed / 75.0).fold(0.0, f64::max);
        assert!((1.8..2.1).contains(&power), "{power}");
        assert_eq!(at(Joint::Ankle, 300).stride_rate, 1.0 / 1.14);
        for (joint, least, most) in [(Joint::Knee, 58.0, 66.0), (Joint::Ankle, 24.0, 32.0)] {
            let angles = (0..1000).map(|k| at(joint, k).angle.to_degrees());
            let (low, high) =
                angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
            assert!((least..most).contains(&(high - low)), "{joint:?} {}", high - low);
        }
    }

    #[test]
    fn torque_follows_body_mass_and_support() {
        let (one, other) = (walk(), Gait { body_mass: 150.0, support: 0.25, ..walk() });
        let (a, b) = (one.at(None, 0.0, 0.45), other.at(None, 0.0, 0.45));
        assert!((b.torque - 0.5 * a.torque).abs() < 1e-12 && a.angle == b.angle && a.speed == b.speed);
    }

    /// The speed is the derivative of the angle in every activity, also with varying strides and during the start ramp;
    /// angle, speed and torque are continuous, also between strides.
    #[test]
    fn speed_is_the_rate_of_the_angle_and_nothing_jumps() {
        use Activity::*;
        for activity in [
            ChildWalkVerySlow,
            ChildWalkSlow,
            ChildWalk,
            ChildWalkFast,
            ChildWalkVeryFast,
            Walk,
            StairsUp,
            StairsDown,
        ] {
            for joint in [Joint::Hip, Joint::Knee, Joint::Ankle] {
                let gait =
                    Gait { activity, joint, variation: 0.05, start_time: 0.0, stop_time: 6.0, ..walk() };
                let (mut s, h) = (0.0, 1e-4);
                let mut last = gait.at(None, 0.0, s);
                let mut largest = [0.0f64; 2];
                for k in 0..80_000 {
                    // Midpoint rule on (1), whose right-hand side is smooth.
                    let half = s + 0.5 * h * last.stride_rate;
                    let t = f64::from(k) * h;
                    let middle = gait.at(None, t + 0.5 * h, half);
                    s += h * middle.stride_rate;
                    let next = gait.at(None, t + h, s);
                    let rate = (next.angle - last.angle) / h;
                    assert!(
                        (rate - middle.speed).abs() < 2e-3,
                        "{activity:?} {joint:?} {t} {rate} {middle:?}"
                    );
                    largest[0] = largest[0].max((next.speed - last.speed).abs());
                    largest[1] = largest[1].max((next.torque - last.torque).abs() / 75.0);
                    last = next;
                }
                assert!(largest[0] < 0.05 && largest[1] < 0.01, "{activity:?} {joint:?} {largest:?}");
                assert_eq!((last.angle, last.speed, last.torque), (0.0, 0.0, 0.0));
            }
        }
    }

    /// tau = 3 + 2 cos, w = 5 + 4 sin over 0.8 s, in rows at unequal distances: values, angle and work by hand.
    #[test]
    fn a_load_table_has_its_torque_and_motion() {
        use std::f64::consts::TAU;
        let (period, rows) = (0.8, 4000);
        let times: Vec<f64> = (0..rows)
            .map(|k| f64::from(k) / f64::from(rows))
            .map(|x| period * (x + 0.08 * (TAU * x).sin() / TAU))
            .collect();
        let of = |f: &dyn Fn(f64) -> f64| times.iter().map(|t| f(TAU * t / period)).collect::<Vec<f64>>();
        let (torques, speeds) = (of(&|p| 3.0 + 2.0 * p.cos()), of(&|p| 5.0 + 4.0 * p.sin()));
        let table = Cycle::of(&LoadTable { period, times, torques, speeds, angle: Some(0.3) });
        let gait = Gait { activity: Activity::Table, body_mass: 20.0, support: 0.5, ..walk() };
        let rate = TAU / period;
        for k in 0..200 {
            let t = f64::from(k) * 0.0137;
            let motion = gait.at(Some(&table), t, t / period);
            let angle = 0.3 + 5.0 * t + 4.0 / rate * (1.0 - (rate * t).cos());
            assert!((motion.angle - angle).abs() < 2e-6, "{t} {motion:?} {angle}");
            assert!((motion.speed - (5.0 + 4.0 * (rate * t).sin())).abs() < 1e-5);
            assert!((motion.torque - 0.5 * (3.0 + 2.0 * (rate * t).cos())).abs() < 1e-5);
            // 0.5 (15 t + 10/w sin + 12/w (1 - cos) + 4/w sin^2).
            let (sin, cos) = (rate * t).sin_cos();
            let work = 0.5 * (15.0 * t + (10.0 * sin + 12.0 * (1.0 - cos) + 4.0 * sin * sin) / rate);
            let (strides, found) = gait.on(Some(&table), 0.0, 0.0, t).unwrap();
            assert!(
                (strides - t / period).abs() < 1e-12 && (found - work).abs() < 1e-5,
                "{t} {found} {work}"
            );
        }
        // Standing still: the mean speed remains, the motion relative to it and the torque are zero.
        let still = Gait { stop_time: 10.0, ..gait };
        let motion = still.at(Some(&table), 20.0, 25.0);
        assert!(
            (motion.speed - 5.0).abs() < 1e-5
                && motion.torque == 0.0
                && still.on(Some(&table), 20.0, 25.0, 0.1).is_none()
        );
        assert_eq!(gait.at(None, 0.0, 0.3), Motion::default());
    }

    #[test]
    fn events_are_where_the_ramps_begin_and_end() {
        let gait = Gait { start_time: 1.0, stop_time: 5.0, ramp_time: 2.0, ..walk() };
        let mut t = 0.0;
        let found: Vec<f64> = std::iter::from_fn(|| {
            t = gait.next_event(t);
            t.is_finite().then_some(t)
        })
        .collect();
        assert_eq!(found, [1.0, 3.0, 5.0, 7.0]);
    }

    /// The integral of torque times speed over parts of a stride, one stride and several, compared with the midpoint rule.
    #[test]
    fn the_work_of_a_step_is_the_integral_of_its_power() {
        for activity in [Activity::Walk, Activity::StairsDown] {
            let gait = Gait { activity, support: 0.7, ..walk() };
            let rate = gait.at(None, 0.0, 0.0).stride_rate;
            for (from, h) in [(0.31, 1e-3), (0.9995, 1e-3), (0.2, 0.4), (3.7, 1.0 / rate), (0.1, 3.3)] {
                let (strides, work) = gait.on(None, 7.0, from, h).unwrap();
                assert!((strides - h * rate).abs() < 1e-14 * strides.max(1.0));
                let n = 20_000;
                let dt = h / f64::from(n);
                let power = |k: i32| gait.at(None, 7.0, from + (f64::from(k) + 0.5) * dt * rate);
                let sum: f64 = (0..n).map(power).map(|m| m.torque * m.speed * dt).sum();
                assert!(
                    (work - sum).abs() < 1e-7 + 1e-6 * sum.abs(),
                    "{activity:?} {from} {h}: {work} {sum}"
                );
            }
        }
    }

    #[test]
    fn what_changes_on_the_way_has_no_short_cut() {
        let gait = Gait { start_time: 1.0, stop_time: 5.0, ramp_time: 2.0, ..walk() };
        let known =
            [0.0, 0.95, 1.5, 2.95, 3.0, 4.85, 4.95, 6.95, 7.0].map(|t| gait.on(None, t, 0.3, 0.1).is_some());
        assert_eq!(known, [true, false, false, false, true, true, false, false, true]);
        assert_eq!(gait.on(None, 0.0, 0.3, 0.1).unwrap().1, 0.0);
        assert!(Gait { variation: 0.02, ..walk() }.on(None, 0.0, 0.3, 0.1).is_none());
    }

    #[test]
    fn the_whole_number_below() {
        for x in [0.0, 0.3, 1.0, 2.999, -0.2, -1.0, -7.5, 1e14 + 0.5, -1e14 - 0.5, 1e300, -1e300, 4.6e15] {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f64::NAN).is_nan());
    }
}
