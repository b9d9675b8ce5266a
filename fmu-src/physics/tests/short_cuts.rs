//! What the gait takes instead of the general integrator, against diffsol on the same equations along the same lines.

#[path = "common/walker.rs"]
#[allow(dead_code)]
mod walker;

use physics::model::{Model, Slot};
use physics::models::gait_load::GaitLoad;
use physics::models::series_elastic_actuator::SeriesElasticActuator;
use physics::solver::reference::{Tolerance, integrate};
use std::cell::RefCell;
use walker::{get, set};

/// What moves the actuator: input, size, frequency, rad/s.
const MOTION: [(&str, f64, f64); 6] = [
    ("motor_angle", 80.0, 9.0),
    ("motor_speed", 700.0, 9.0),
    ("motor_current", 6.0, 20.0),
    ("joint_angle", 0.2, 14.0),
    ("joint_speed", 2.8, 14.0),
    ("torque_demand", 40.0, 5.0),
];

/// States after a step of `h` seconds along lines, and by diffsol, from wherever `m` stands.
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
    let start: [f64; N] = std::array::from_fn(|k| start[k]);
    let tolerance = Tolerance { relative: 1e-11, absolute: 1e-11 };
    let exact = integrate(rates, &start, &[h], tolerance).unwrap()[0];
    [found, exact.to_vec()]
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
