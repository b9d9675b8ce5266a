//! A joint of a person who walks: angle, speed and torque over the stride, from measured data.
//!
//! stride      s' = 1 / T(s),   phase = s - floor(s)                                                         (1)
//! angle       angle = a(t) A(s) q(phase),   speed = its derivative                                          (2)
//! torque      torque = a(t) B(s) body_mass support m(phase)                                                 (3)
//! start, stop a(t) = r((t - start) / ramp) - r((t - stop) / ramp),   r(x) = 6 x^5 - 15 x^4 + 10 x^3         (4)
//! variation   T(s) = T_0 (1 + v z_1(s)), A = 1 + v z_2(s), B = 1 + v z_3(s); z runs from one random number
//!             to the next in the middle of each stride, along r                                             (5)
//!
//! q and m are periodic cubic splines through the measured points, so that speed and torque have no corner, within a
//! stride or from one to the next.
//! *Assumes* that torque scales with body mass, that a person who stands holds angle 0 without torque, and that the
//! strides of (5) vary independently of each other: v is the coefficient of variation of each (of stride time about
//! 0.02 in healthy adults on level ground).
//! *Sign*: angle and torque are positive in extension (plantarflexion at the ankle), so that torque times speed > 0 is
//! power into the leg.
//! *Source*: `tables.rs`.

mod spline;
mod tables;
mod variation;

use declare::{Unit, Variable, enumeration, variables};
use tables::{Cycle, cycle};
use variation::Quantity;

enumeration! {
    /// What the person does
    pub enum Activity {
        /// Level walking, very slow: 1.58 s a stride
        WalkVerySlow = 1, "walk_very_slow";
        /// Level walking, slow: 1.38 s a stride
        WalkSlow = 2, "walk_slow";
        /// Level walking at the speed that one chooses: 1.12 s a stride
        Walk = 3, "walk";
        /// Level walking, fast: 0.97 s a stride
        WalkFast = 4, "walk_fast";
        /// Level walking, very fast: 0.81 s a stride
        WalkVeryFast = 5, "walk_very_fast";
        /// Stairs up: 1.11 s a stride, power measured, torque and speed shared out
        StairsUp = 6, "stairs_up";
        /// Stairs down: 1.11 s a stride, power measured, torque and speed shared out
        StairsDown = 7, "stairs_down";
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
    /// Who walks, how, and what the actuator has to give.
    pub struct Gait {
        /// Mass of the body, that of what it carries included
        body_mass: f64 = Variable::tunable(0, 75.0, Unit::Kilogram, 1.0, 500.0)
            .source("usual adult of gait studies"),
        /// What the person does
        activity: Activity = Variable::choice(1, 3),
        /// Which joint is loaded
        joint: Joint = Variable::choice(2, 3),
        /// Share of the biological torque that is asked of the actuator
        support: f64 = Variable::tunable(3, 1.0, Unit::One, -2.0, 2.0)
            .source("the whole biological torque"),
        /// Coefficient of variation from stride to stride, of stride time, range of angle and torque each
        variation: f64 = Variable::tunable(4, 0.0, Unit::One, 0.0, 0.2),
        /// Which series of random strides
        seed: i32 = Variable::tunable_count(5, 1, 0, 1_000_000_000)
            .source("arbitrary"),
        /// Share of the stride, from heel strike, that is over at the start
        initial_phase: f64 = Variable::tunable(6, 0.0, Unit::One, 0.0, 1.0),
        /// Time at which the person sets out; ahead of the start of the simulation by more than the ramp, it walks from there on
        start_time: f64 = Variable::tunable(7, -10.0, Unit::Second, -1e6, 1e9).nominal(10.0)
            .source("earlier than any start by more than the ramp"),
        /// Time at which the person begins to stop
        stop_time: f64 = Variable::tunable(8, 1e9, Unit::Second, -1e6, 1e9).nominal(10.0)
            .source("later than any stop"),
        /// Time that setting out and stopping take
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
    /// Torque asked for, N.m.
    pub torque: f64,
    /// Rate of the stride's coordinate, 1/s.
    pub stride_rate: f64,
}

/// A smooth step from 0 to 1, and its slope.
fn ramp(x: f64) -> (f64, f64) {
    let x = x.clamp(0.0, 1.0);
    (x * x * x * (x * (6.0 * x - 15.0) + 10.0), 30.0 * x * x * (1.0 - x) * (1.0 - x))
}

/// The whole number below, without a call where a conversion will do.
#[inline]
pub fn floor(x: f64) -> f64 {
    /// From here on there are no fractions.
    const WHOLE: f64 = (1u64 << 52) as f64;
    if x.abs() < WHOLE {
        let near = x as i64 as f64;
        if near > x { near - 1.0 } else { near }
    } else {
        x
    }
}

impl Gait {
    fn cycle(&self) -> &'static Cycle {
        cycle(self.activity, self.joint)
    }

    /// Share of the whole gait that is walked at `time`, s, and its rate, 1/s: eq. (4).
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

    /// The joint at `time`, s, where the stride's coordinate is `stride`: eqs. (2) to (5).
    pub fn at(&self, time: f64, stride: f64) -> Motion {
        let cycle = self.cycle();
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
        Motion {
            angle: share * range * q,
            speed: share_rate * range * q + share * (range_slope * q + range * q_slope) * stride_rate,
            torque: share * strength * self.body_mass * self.support * cycle.torque.at(phase).0,
            stride_rate,
        }
    }

    /// Strides walked in the `h` seconds from `time`, s, on, and the work that they ask for, J, where `stride` is the
    /// coordinate before: the integrals of (1) and of torque times speed. `None` where strides differ or the share of the
    /// gait is on its way.
    #[inline]
    pub fn on(&self, time: f64, stride: f64, h: f64) -> Option<(f64, f64)> {
        let changes = |from: f64| time < from + self.ramp_time && time + h > from;
        if self.variation > 0.0 || changes(self.start_time) || changes(self.stop_time) {
            return None;
        }
        let (cycle, (share, _)) = (self.cycle(), self.share(time));
        let strides = h / cycle.stride_time;
        let (from, to) = (stride, stride + strides);
        let (whole_from, whole_to) = (floor(from), floor(to));
        let turns = whole_to - whole_from;
        let work =
            cycle.work.to(to - whole_to) - cycle.work.to(from - whole_from) + turns * cycle.work.whole();
        Some((strides, share * share * self.body_mass * self.support * work))
    }

    /// The first time after `time`, s, at which setting out or stopping begins or ends.
    pub fn next_event(&self, time: f64) -> f64 {
        let ends = |from: f64| [from, from + self.ramp_time];
        let all = ends(self.start_time).into_iter().chain(ends(self.stop_time));
        all.filter(|&t| t > time).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk() -> Gait {
        Gait::default()
    }

    /// The table's ankle at free speed: greatest moment 1.2298 N.m/kg at 48 %, and the power of push-off.
    #[test]
    fn the_ankle_is_the_measured_one() {
        let gait = walk();
        let peak = (0..1000).map(|k| gait.at(0.0, f64::from(k) / 1000.0).torque / 75.0).fold(0.0, f64::max);
        assert!((1.2..1.26).contains(&peak), "{peak}");
        let power = (0..1000)
            .map(|k| gait.at(0.0, f64::from(k) / 1000.0))
            .map(|m| m.torque * m.speed / 75.0)
            .fold(0.0, f64::max);
        // Measured 2.8 W/kg; torque times speed of mean curves is a little less than the mean power.
        assert!((2.2..3.2).contains(&power), "{power}");
        assert_eq!(gait.at(0.0, 0.3).stride_rate, 1.0 / 1.123);
    }

    #[test]
    fn torque_follows_body_mass_and_support() {
        let (one, other) = (walk(), Gait { body_mass: 150.0, support: 0.25, ..walk() });
        let (a, b) = (one.at(0.0, 0.45), other.at(0.0, 0.45));
        assert!((b.torque - 0.5 * a.torque).abs() < 1e-12 && a.angle == b.angle && a.speed == b.speed);
    }

    /// The speed is the derivative of the angle along the gait, in every activity, also where strides differ and while
    /// setting out; angle, speed and torque have no step, from one stride to the next either.
    #[test]
    fn speed_is_the_rate_of_the_angle_and_nothing_jumps() {
        use Activity::*;
        for activity in [WalkVerySlow, WalkSlow, Walk, WalkFast, WalkVeryFast, StairsUp, StairsDown] {
            for joint in [Joint::Hip, Joint::Knee, Joint::Ankle] {
                let gait =
                    Gait { activity, joint, variation: 0.05, start_time: 0.0, stop_time: 6.0, ..walk() };
                let (mut s, h) = (0.0, 1e-4);
                let mut last = gait.at(0.0, s);
                let mut largest = [0.0f64; 2];
                for k in 0..80_000 {
                    // The middle rule on (1), whose right-hand side is smooth.
                    let half = s + 0.5 * h * last.stride_rate;
                    let t = f64::from(k) * h;
                    let middle = gait.at(t + 0.5 * h, half);
                    s += h * middle.stride_rate;
                    let next = gait.at(t + h, s);
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

    /// The integral of torque times speed over parts of a stride, a stride and several, by the middle rule.
    #[test]
    fn the_work_of_a_step_is_the_integral_of_its_power() {
        for activity in [Activity::Walk, Activity::StairsDown] {
            let gait = Gait { activity, support: 0.7, ..walk() };
            let rate = gait.at(0.0, 0.0).stride_rate;
            for (from, h) in [(0.31, 1e-3), (0.9995, 1e-3), (0.2, 0.4), (3.7, 1.0 / rate), (0.1, 3.3)] {
                let (strides, work) = gait.on(7.0, from, h).unwrap();
                assert!((strides - h * rate).abs() < 1e-14 * strides.max(1.0));
                let n = 20_000;
                let dt = h / f64::from(n);
                let power = |k: i32| gait.at(7.0, from + (f64::from(k) + 0.5) * dt * rate);
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
            [0.0, 0.95, 1.5, 2.95, 3.0, 4.85, 4.95, 6.95, 7.0].map(|t| gait.on(t, 0.3, 0.1).is_some());
        assert_eq!(known, [true, false, false, false, true, true, false, false, true]);
        assert_eq!(gait.on(0.0, 0.3, 0.1).unwrap().1, 0.0);
        assert!(Gait { variation: 0.02, ..walk() }.on(0.0, 0.3, 0.1).is_none());
    }

    #[test]
    fn the_whole_number_below() {
        for x in [0.0, 0.3, 1.0, 2.999, -0.2, -1.0, -7.5, 1e14 + 0.5, -1e14 - 0.5, 1e300, -1e300, 4.6e15] {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f64::NAN).is_nan());
    }
}
