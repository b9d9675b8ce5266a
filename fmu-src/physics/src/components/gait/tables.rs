//! Measured strides, as splines over the phase.
//!
//! *Level walking, adults*: torque and angular velocity, Grimmer and Seyfarth 2014, digitised
//! (`data/gait-walking-stairs-cc0/SOURCE.md`). The angle is the integral of the velocity, with zero mean; the mean of the velocity
//! (1.5 deg/s at the knee) is subtracted. Twelve harmonics are used.
//! *Level walking, children*: normative means of typically developing children at five speeds, Schwartz, Rozumalski,
//! Trost, J. Biomech. 41 (2008) 1639; the stride times are those for which torque times speed equals the measured power
//! (`data/gait-schwartz2008/SOURCE.md`). The means are not exactly periodic (0.2 degrees at self-selected speed); the gap is
//! distributed over the stride.
//! *Stairs, adults*: the power of hip, knee and ankle, Boehme 2022, digitised (`data/gait-walking-stairs-cc0/SOURCE.md`).
//! Torque and speed were not published with the power and are estimated:
//!
//! torque = sign z^(1/2) (p^2 + p_0^2)^(1/4),   speed = p / torque                                         (1)
//!
//! z is chosen so that the peak torque is the published one ([`Peak`]); p_0 is a fiftieth of the peak power, so that torque and speed
//! are smooth where the power changes its sign. The sign is positive at the peak power, and negative in one part of the stride, in which
//! the joint moves back: the part that best closes the angle over the stride and whose ends have little power. The rest of the gap is
//! distributed over the phases of little power. Work, peak power and peak torque are thus measured; speed and angle are an estimate, with
//! less range than a freely swinging leg. The power of the estimate differs from the measured one by 10 % (root mean square), by 20 % at
//! the knee on stairs down: `power_is_kept`.

use super::spline::{Along, Spline};
use super::{Activity, Joint};
use crate::load_table::LoadTable;
use std::sync::{Arc, OnceLock};

/// Joint angle and torque over a stride.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Duration of a stride, s.
    pub stride_time: f64,
    /// Angle over the phase, rad, without the increment `turn`.
    pub angle: Spline,
    /// Increment of the angle per stride, rad.
    pub turn: f64,
    /// Torque over the phase, N.m/kg, or N.m for a load table.
    pub torque: Spline,
    /// Work over the phase, J/kg or J.
    pub work: Along,
}

impl Cycle {
    fn new(stride_time: f64, angle: &[f64], torque: &[f64]) -> Cycle {
        let (angle, torque) = (Spline::through(angle), Spline::through(torque));
        Cycle { stride_time, work: torque.along(&angle), angle, turn: 0.0, torque }
    }

    /// The cycle of a table: straight lines through its rows of torque and speed.
    pub fn of(table: &LoadTable) -> Cycle {
        let knots: Arc<[f64]> = table.times.iter().map(|t| t / table.period).collect();
        let rates: Vec<f64> = table.speeds.iter().map(|speed| speed * table.period).collect();
        let torque = Spline::linear(&knots, &table.torques);
        let (mut angle, turn) = Spline::integral(&knots, &rates, true);
        let work = torque.along(&Spline::integral(&knots, &rates, false).0);
        angle.raise(table.angle.unwrap_or_else(|| -angle.mean()));
        Cycle { stride_time: table.period, angle, turn, torque, work }
    }
}

const CHILDREN: &str =
    include_str!("../../../data/gait-schwartz2008/schwartz2008_joint_angle_moment_power.csv");
const CHILDREN_STRIDES: &str = include_str!("../../../data/gait-schwartz2008/stride_time_inferred_s.csv");
/// Level walking of adults: torque and angular velocity of hip, knee and ankle.
const ADULT: [[&str; 2]; 3] = [
    [
        include_str!("../../../data/gait-walking-stairs-cc0/walking_hip_torque.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/walking_hip_angle_velocity.csv"),
    ],
    [
        include_str!("../../../data/gait-walking-stairs-cc0/walking_knee_torque.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/walking_knee_angle_velocity.csv"),
    ],
    [
        include_str!("../../../data/gait-walking-stairs-cc0/walking_ankle_torque.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/walking_ankle_angle_velocity.csv"),
    ],
];
/// Stairs up and down, each hip, knee and ankle.
const STAIRS: [[&str; 3]; 2] = [
    [
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_up_p_mech_hip_marked.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_up_p_mech_knee_marked.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_up_p_mech_ankle_marked.csv"),
    ],
    [
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_down_p_mech_hip_marked.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_down_p_mech_knee_marked.csv"),
        include_str!("../../../data/gait-walking-stairs-cc0/stairs_down_p_mech_ankle_marked.csv"),
    ],
];
/// Stride times of the adults.
const ADULT_STRIDES: &str = include_str!("../../../data/gait-walking-stairs-cc0/stride_time_s.csv");
/// Equidistant points of a digitised stride.
const POINTS: usize = 100;
/// Number of harmonics for an adult's level walking: up to 10.5 Hz. Higher harmonics are the ripple of the digitisation, up to
/// 0.01 N.m/kg; with a series spring, its second derivative would appear in the motor current.
const HARMONICS: usize = 12;

/// Peak torque of a joint on stairs.
#[derive(Clone, Copy, Debug)]
enum Peak {
    /// Published, N.m/kg.
    Published(f64),
    /// Same joint in level walking of adults.
    LevelWalking,
}

/// Peak torque on stairs up and down at hip, knee and ankle. Up: knee, and the hip's "similar", Costigan,
/// Deluzio, Wyss, Gait Posture 16 (2002) 31. Down: knee, Reid et al., Med. Sci. Sports Exerc. 39 (2007) 2005; hip, 0.25
/// less than up, Protopapadaki et al., Clin. Biomech. 22 (2007) 203. The ankle's is that of level walking, which it does not
/// reach on the way down (Beaulieu, Pelland, Robertson, Gait Posture 27 (2008) 564).
const PEAK_TORQUE: [[Peak; 3]; 2] = [
    [Peak::Published(1.16), Peak::Published(1.16), Peak::LevelWalking],
    [Peak::Published(0.91), Peak::Published(1.05), Peak::LevelWalking],
];
/// Names of the joints in the table, in the order of [`Joint`].
const JOINTS: [&str; 3] = ["hip", "knee", "ankle"];
/// Activities with measured strides.
const ACTIVITIES: usize = 8;

/// Stride of an activity at a joint, computed at its first use; `None` for the load table, which is data of an instance.
#[inline]
pub fn cycle(activity: Activity, joint: Joint) -> Option<&'static Cycle> {
    if activity == Activity::Table {
        return None;
    }
    static ALL: [OnceLock<Cycle>; ACTIVITIES * JOINTS.len()] =
        [const { OnceLock::new() }; ACTIVITIES * JOINTS.len()];
    let joint = joint as usize - 1;
    Some(ALL[(activity as usize - 1) * JOINTS.len() + joint].get_or_init(|| match activity {
        Activity::Walk | Activity::Table => adult(joint),
        Activity::StairsUp => stairs(0, joint),
        Activity::StairsDown => stairs(1, joint),
        Activity::ChildWalkVerySlow => child("VerySlow", joint),
        Activity::ChildWalkSlow => child("Slow", joint),
        Activity::ChildWalk => child("Free", joint),
        Activity::ChildWalkFast => child("Fast", joint),
        Activity::ChildWalkVeryFast => child("VeryFast", joint),
    }))
}

/// A column of a table, by its name.
///
/// # Panics
/// If the compiled-in text has no such column of numbers.
fn column(text: &str, name: &str, row: impl Fn(&str) -> bool) -> Vec<f64> {
    let mut lines = text.lines();
    let place = lines.next().and_then(|head| head.split(',').position(|c| c == name));
    let place = place.unwrap_or_else(|| panic!("the table has no column {name}"));
    let cell = |line: &str| line.split(',').nth(place).and_then(|c| c.trim().parse().ok());
    lines.filter(|line| row(line)).map(|line| cell(line).expect("a number")).collect()
}

/// Level walking of children at one of the table's speeds.
fn child(speed: &str, joint: usize) -> Cycle {
    let of_speed = |line: &str| line.split(',').next() == Some(speed);
    let closed = |name: String| {
        let values = column(CHILDREN, &name, of_speed);
        let last = values.len() - 1;
        let gap = values[last] - values[0];
        let value = |k: usize| values[k] - gap * (k as f64 / last as f64 - 0.5);
        (0..last).map(value).collect::<Vec<f64>>()
    };
    let angle = closed(format!("{}_angles_mean", JOINTS[joint]));
    // The table uses flexion angles and extension moments.
    let angle: Vec<f64> = angle.iter().map(|degrees| -degrees.to_radians()).collect();
    let torque = closed(format!("{}_moment_mean", JOINTS[joint]));
    Cycle::new(column(CHILDREN_STRIDES, "stride_time_s", of_speed)[0], &angle, &torque)
}

/// Level walking of adults.
fn adult(joint: usize) -> Cycle {
    let [torque, velocity] = ADULT[joint].map(|text| low_pass(&equidistant(text)));
    let mean = velocity.iter().sum::<f64>() / POINTS as f64;
    let speed: Vec<f64> = velocity.iter().map(|v| (v - mean).to_radians()).collect();
    let stride_time = adult_stride_time("walk");
    Cycle::new(stride_time, &angle(&speed, stride_time), &torque)
}

/// Stride time of an activity of adults, s.
fn adult_stride_time(activity: &str) -> f64 {
    column(ADULT_STRIDES, "stride_time_s", |line| line.split(',').next() == Some(activity))[0]
}

/// The angle at equidistant points of a closed stride, rad, with zero mean: the trapezoidal integral of the speed, rad/s.
fn angle(speed: &[f64], stride_time: f64) -> Vec<f64> {
    let step = stride_time / speed.len() as f64;
    let mut angle = vec![0.0; speed.len()];
    for k in 1..speed.len() {
        angle[k] = angle[k - 1] + 0.5 * step * (speed[k - 1] + speed[k]);
    }
    let mean = angle.iter().sum::<f64>() / speed.len() as f64;
    angle.iter_mut().for_each(|a| *a -= mean);
    angle
}

/// The mean and the first [`HARMONICS`] of a periodic curve.
fn low_pass(values: &[f64]) -> Vec<f64> {
    let n = values.len() as f64;
    let angle = |harmonic: usize, k: usize| std::f64::consts::TAU * (harmonic * k) as f64 / n;
    let sum = |f: &dyn Fn(usize) -> f64| values.iter().enumerate().map(|(k, v)| v * f(k)).sum::<f64>();
    let mean = sum(&|_| 1.0) / n;
    let factors: Vec<[f64; 2]> = (1..=HARMONICS)
        .map(|h| [sum(&|k| angle(h, k).cos()), sum(&|k| angle(h, k).sin())].map(|s| 2.0 * s / n))
        .collect();
    let at = |k: usize| {
        let waves = factors.iter().zip(1..).map(|([a, b], h)| {
            let (sin, cos) = angle(h, k).sin_cos();
            a * cos + b * sin
        });
        mean + waves.sum::<f64>()
    };
    (0..values.len()).map(at).collect()
}

/// A digitised curve over the stride, linearly interpolated to equidistant phases.
fn equidistant(text: &str) -> Vec<f64> {
    let phases: Vec<f64> = column(text, "pct_cycle", |_| true).iter().map(|pct| pct / 100.0).collect();
    let values = column(text, "value", |_| true);
    let count = phases.len();
    // The digitised points go from near 0 to near 1; outside, the points of the other end are used, shifted by a period.
    let around = |k: isize| {
        let turns = k.div_euclid(count as isize);
        let k = k.rem_euclid(count as isize) as usize;
        (phases[k] + turns as f64, values[k])
    };
    let at = |phase: f64| {
        let next = phases.partition_point(|&p| p <= phase) as isize;
        let ((p0, y0), (p1, y1)) = (around(next - 1), around(next));
        y0 + (y1 - y0) * (phase - p0) / (p1 - p0)
    };
    (0..POINTS).map(|k| at(k as f64 / POINTS as f64)).collect()
}

/// A stride on stairs, up (0) or down (1): eq. (1) for the power of a joint and its peak torque.
fn stairs(way: usize, joint: usize) -> Cycle {
    let power = equidistant(STAIRS[way][joint]);
    let peak = match PEAK_TORQUE[way][joint] {
        Peak::Published(torque) => torque,
        Peak::LevelWalking => {
            low_pass(&equidistant(ADULT[joint][0])).iter().fold(0.0, |most, torque| torque.max(most))
        }
    };
    let stride_time = adult_stride_time(["stairs_up", "stairs_down"][way]);
    let most = power.iter().fold(0.0f64, |most, p| most.max(p.abs()));
    let size: Vec<f64> = power.iter().map(|p| peak * (p.hypot(0.02 * most) / most).sqrt()).collect();
    let speed: Vec<f64> = power.iter().zip(&size).map(|(p, m)| p / m).collect();
    let sign = signs(&power, &speed, most);
    let torque: Vec<f64> = size.iter().zip(&sign).map(|(m, s)| m * s).collect();
    let speed: Vec<f64> = speed.iter().zip(&sign).map(|(w, s)| w * s).collect();
    let idle: Vec<f64> = power.iter().map(|p| 1.0 / (1.0 + (p / (0.1 * most)).powi(4))).collect();
    let back = speed.iter().sum::<f64>() / idle.iter().sum::<f64>();
    let speed: Vec<f64> = speed.iter().zip(&idle).map(|(w, weight)| w - back * weight).collect();
    Cycle::new(stride_time, &angle(&speed, stride_time), &torque)
}

/// The sign of eq. (1) over the stride, -1 in the best part, with smooth transitions of a few points at its ends.
fn signs(power: &[f64], speed: &[f64], most: f64) -> Vec<f64> {
    const SMOOTH: f64 = 1.5;
    let whole: f64 = speed.iter().map(|w| w.abs()).sum();
    let greatest = (0..POINTS).find(|&k| power[k].abs() == most).unwrap_or(0);
    let sign = |k: usize, from: usize, to: usize| {
        let inside = |at: usize| ((k as f64 - at as f64) / SMOOTH).tanh();
        1.0 - (inside(from) - inside(to))
    };
    let all = |from: usize, to: usize| (0..POINTS).map(move |k| sign(k, from, to));
    let cost = |&(from, to): &(usize, usize)| {
        let way: f64 = all(from, to).zip(speed).map(|(s, w)| s * w).sum();
        way.abs() / whole + (power[from].abs() + power[to].abs()) / most
    };
    // Away from heel strike, so that the sign is periodic.
    let ends = 5..POINTS - 5;
    let parts =
        ends.clone().flat_map(|from| ends.clone().filter(move |&to| to >= from).map(move |to| (from, to)));
    let parts = parts.filter(|&(from, to)| !(from..=to).contains(&greatest));
    let (from, to) = parts.min_by(|a, b| cost(a).total_cmp(&cost(b))).expect("there are parts");
    all(from, to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_the_table_are_met() {
        let of_free = |line: &str| line.starts_with("Free,");
        let (angle, moment) =
            (column(CHILDREN, "knee_angles_mean", of_free), column(CHILDREN, "knee_moment_mean", of_free));
        let cycle = cycle(Activity::ChildWalk, Joint::Knee).unwrap();
        for k in 0..50 {
            let phase = k as f64 / 50.0;
            // Within the gap that is distributed over the stride.
            assert!((cycle.angle.at(phase).0 + angle[k].to_radians()).abs() < 0.01);
            assert!((cycle.torque.at(phase).0 - moment[k]).abs() < 0.02);
        }
        let speeds = ["VerySlow", "Slow", "Free", "Fast", "VeryFast"];
        let times: Vec<f64> = speeds.iter().map(|speed| child(speed, 2).stride_time).collect();
        assert!(times.windows(2).all(|w| w[0] > w[1]) && times[0] == 1.58);
    }

    /// Twelve harmonics follow the digitised torque within its ripple, and reproduce a curve of fewer harmonics exactly.
    #[test]
    fn the_low_pass_takes_the_ripple_alone() {
        for (joint, most) in [0.012, 0.008, 0.008].into_iter().enumerate() {
            let raw = equidistant(ADULT[joint][0]);
            let squares = raw.iter().zip(low_pass(&raw)).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            let rms = (squares / POINTS as f64).sqrt();
            assert!((1e-3..most).contains(&rms), "{} {rms}", JOINTS[joint]);
        }
        let wave = |k: usize| 0.3 + (std::f64::consts::TAU * (12 * k) as f64 / 100.0).sin();
        let smooth: Vec<f64> = (0..POINTS).map(wave).collect();
        assert!(smooth.iter().zip(low_pass(&smooth)).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    /// Torque times speed compared with the measured power: root mean square of the difference, and the work.
    #[test]
    fn power_is_kept() {
        for (way, texts) in STAIRS.iter().enumerate() {
            for (joint, text) in texts.iter().enumerate() {
                let cycle = stairs(way, joint);
                let measured = equidistant(text);
                let made: Vec<f64> = (0..POINTS)
                    .map(|k| k as f64 / POINTS as f64)
                    .map(|phase| cycle.torque.at(phase).0 * cycle.angle.at(phase).1 / cycle.stride_time)
                    .collect();
                let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
                let difference: Vec<f64> = made.iter().zip(&measured).map(|(a, b)| a - b).collect();
                let ratio = norm(&difference) / norm(&measured);
                println!("{way} {} differs by {ratio:.3}", JOINTS[joint]);
                assert!(ratio < 0.22, "{way} {} {ratio}", JOINTS[joint]);
            }
        }
    }
}
