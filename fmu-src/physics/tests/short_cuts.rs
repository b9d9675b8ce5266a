//! What actuator and gait take instead of the general integrator, against Runge and Kutta on the same equations along the
//! same lines.

use crate::walker::{get, set};
use declare::Group;
use physics::explicit::{Law, Line};
use physics::model::{Model, Slot};
use physics::models::gait_load::GaitLoad;
use physics::models::series_elastic_actuator::{Inputs, SeriesElasticActuator};
use std::cell::RefCell;

/// What moves the actuator: input, size, frequency, rad/s.
const MOTION: [(&str, f64, f64); 6] = [
    ("motor_angle", 80.0, 9.0),
    ("motor_speed", 700.0, 9.0),
    ("motor_current", 6.0, 20.0),
    ("joint_angle", 0.2, 14.0),
    ("joint_speed", 2.8, 14.0),
    ("torque_demand", 40.0, 5.0),
];

/// The same inputs where they go together: joint and demand move by themselves, the motor nearly as the demand wants it
/// behind a transmission of this ratio and a spring of this stiffness, N.m/rad.
fn together(t: f64, ratio: f64, stiffness: f64) -> [f64; 6] {
    let (joint, demand) = (0.2 * (14.0 * t).sin(), 40.0 * (5.0 * t).sin());
    let (joint_speed, rate) = (2.8 * (14.0 * t).cos(), 200.0 * (5.0 * t).cos());
    let motor = |joint: f64, torque: f64| ratio * (joint + 0.99 * torque / stiffness);
    [
        motor(joint, demand),
        motor(joint_speed, rate),
        1.1 * demand / ratio / 0.0276,
        joint,
        joint_speed,
        demand,
    ]
}

/// Parts of a step in which Runge's and Kutta's method takes it: a corner within one of them is no matter.
const PARTS: u32 = 1000;

/// States after a step of `h` seconds along lines, and after the same in so many parts, from wherever `m` stands.
fn both<const N: usize>(m: &dyn Model, lines: &[(Slot, f64)], h: f64) -> [Vec<f64>; 2] {
    let time = m.time();
    let mut stepping = m.boxed_clone();
    let mut at = Vec::new();
    for &(slot, slope) in lines {
        at.push((slot, stepping.get(slot), slope));
        stepping.set_slope(slot, slope);
    }
    stepping.step(time, h).unwrap();
    let (mut found, mut start) = (Vec::new(), Vec::new());
    stepping.states(&mut found);
    m.states(&mut start);
    let asked = RefCell::new(m.boxed_clone());
    let rates = |t: f64, x: &[f64; N]| {
        let (mut m, mut out) = (asked.borrow_mut(), Vec::new());
        for &(slot, value, slope) in &at {
            m.set(slot, value + slope * t);
        }
        m.set_states(time + t, x);
        m.rates(&mut out);
        std::array::from_fn(|k| out[k])
    };
    let mut x: [f64; N] = std::array::from_fn(|k| start[k]);
    let part = h / f64::from(PARTS);
    for k in 0..PARTS {
        let t = f64::from(k) * part;
        let on = |rate: &[f64; N], share: f64| std::array::from_fn(|n| x[n] + share * part * rate[n]);
        let k1 = rates(t, &x);
        let k2 = rates(t + 0.5 * part, &on(&k1, 0.5));
        let k3 = rates(t + 0.5 * part, &on(&k2, 0.5));
        let k4 = rates(t + part, &on(&k3, 1.0));
        x = std::array::from_fn(|n| x[n] + part / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n]));
    }
    [found, x.to_vec()]
}

/// Whether the actuator takes this step by quadrature: no point comes out of that.
fn by_quadrature(m: &SeriesElasticActuator, opening: &[f64; 2], lines: &[(Slot, f64)], h: f64) -> bool {
    let mut slopes = m.inputs;
    for row in 0..Inputs::TABLE.len() {
        slopes.set(row, 0.0);
    }
    for (slot, slope) in lines {
        slopes.set(slot.row.into(), *slope);
    }
    let line = Line { time: m.time(), inputs: &m.inputs, slopes: Some(&slopes), initial: opening };
    let mut states = Vec::new();
    m.states(&mut states);
    let states: [f64; 8] = std::array::from_fn(|k| states[k]);
    m.parameters.one(&line, 0.0, &states, None, h).point.is_none()
}

/// Every state of the actuator, in every way that its springs, its play, its control and its supply change a step: within
/// a ten-millionth of its size where the step goes by quadrature, which it does but near corners, and within what a corner
/// costs the general integrator there.
#[test]
fn a_step_of_the_actuator_is_that_of_its_equations() {
    type Change = fn(&mut SeriesElasticActuator);
    let changes: [(&str, Change); 8] = [
        ("as it is", |_| ()),
        ("with play", |m| set(m, "transmission.backlash", 0.02)),
        ("with a spring beside it", |m| {
            set(m, "parallel.stiffness", 60.0);
            set(m, "spring.damping", 2.0);
        }),
        ("with a stop beside it", |m| {
            set(m, "parallel.stiffness", 300.0);
            set(m, "parallel.engagement", 2.0);
        }),
        ("with a ball screw", |m| set(m, "transmission.kind", 2.0)),
        ("with losses before the motor", |m| {
            set(m, "drive.efficiency", 0.9);
            set(m, "drive.regeneration", 0.3);
        }),
        ("with too little current", |m| set(m, "control.current_max", 2.0)),
        ("with too little voltage", |m| set(m, "supply_voltage", 8.0)),
    ];
    for (what, change) in changes {
        let mut m = SeriesElasticActuator::default();
        change(&mut m);
        let (_, opening) = m.parameters.start(0.0, &m.inputs).unwrap();
        let (ratio, stiffness) = (get(&mut m, "transmission.ratio"), get(&mut m, "spring.stiffness"));
        m.start(0.0).unwrap();
        let declaration = m.declaration();
        let slot = |name: &str| declaration.by_name(name).unwrap().slot;
        let sizes: Vec<f64> =
            declaration.states.iter().map(|s| declaration.entries[s[0]].row.nominal).collect();
        // Of both ways: how many steps, and the greatest error.
        let mut ways = [(0, 0.0f64); 2];
        let h = 1e-3;
        for k in 0..600u32 {
            let t = f64::from(k) * h;
            let mut lines = Vec::new();
            for (place, (name, ..)) in MOTION.into_iter().enumerate() {
                let of = |t: f64| together(t, ratio, stiffness)[place];
                m.set(slot(name), of(t));
                lines.push((slot(name), (of(t + h) - of(t)) / h));
            }
            if k % 3 == 0 {
                let [found, exact] = both::<8>(&m, &lines, h);
                let way = &mut ways[usize::from(by_quadrature(&m, &opening, &lines, h))];
                way.0 += 1;
                for ((a, b), size) in found.iter().zip(&exact).zip(&sizes) {
                    way.1 = way.1.max((a - b).abs() / size.max(b.abs()));
                }
            }
            for (slot, slope) in lines {
                m.set_slope(slot, slope);
            }
            m.step(t, h).unwrap();
        }
        println!("{what}: {ways:?}");
        assert!(ways[1].1 < 1e-7 && ways[0].1 < 3e-5, "{what}: {ways:?}");
    }
}

/// Stride and work of the gait: where strides are alike, where they differ, while setting out, and over many strides.
#[test]
fn a_step_of_the_gait_is_that_of_its_equations() {
    for (variation, start_time, h) in
        [(0.0, -10.0, 1e-3), (0.05, -10.0, 1e-3), (0.0, 0.0, 1e-3), (0.0, -10.0, 0.9)]
    {
        let mut m = GaitLoad::default();
        set(&mut m, "gait.variation", variation);
        set(&mut m, "gait.start_time", start_time);
        m.start(0.0).unwrap();
        for k in 0..60u32 {
            let [found, exact] = both::<2>(&m, &[], h);
            assert!((found[0] - exact[0]).abs() < 1e-9, "{variation} {k}: {found:?} {exact:?}");
            assert!(
                (found[1] - exact[1]).abs() < 1e-7 * exact[1].abs().max(1000.0),
                "{k}: {found:?} {exact:?}"
            );
            for i in 0..23 {
                m.step(f64::from(23 * k + i) * h, h).unwrap();
            }
        }
        assert!(get(&mut m, "energy_demand") != 0.0);
    }
}

/// Whoever has read the outputs before a step gets the same step as who has not, to the bit.
#[test]
fn looking_changes_nothing() {
    let (mut looks, mut steps) = (SeriesElasticActuator::default(), SeriesElasticActuator::default());
    for m in [&mut looks, &mut steps] {
        m.start(0.0).unwrap();
    }
    for k in 0..300u32 {
        let t = f64::from(k) * 1e-3;
        for m in [&mut looks, &mut steps] {
            for (name, size, w) in MOTION {
                let slot = m.declaration().by_name(name).unwrap().slot;
                m.set(slot, size * (w * t).sin());
                m.set_slope(slot, size * w * (w * t).cos());
            }
        }
        assert!(get(&mut looks, "voltage").is_finite() && get(&mut looks, "power_balance_error").is_finite());
        looks.step(t, 1e-3).unwrap();
        steps.step(t, 1e-3).unwrap();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        looks.states(&mut a);
        steps.states(&mut b);
        assert_eq!(a, b, "{t}");
    }
}
