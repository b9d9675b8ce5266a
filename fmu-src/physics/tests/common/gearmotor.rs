//! The gearmotor beside a reference that integrates its equations without splitting.

use declare::Group;
use physics::model::{Model, Slot};
use physics::models::brushed_gearmotor::{BrushedGearmotor, Constants, Inputs, NODES, STATES, Step};
use physics::terms::Drivers;
use reference::{Tolerance, integrate};

/// The reference's tolerances.
const TIGHT: Tolerance = Tolerance { relative: 1e-10, absolute: 1e-12 };
/// Which states are temperatures, whose size is their rise.
const TEMPERATURES: std::ops::Range<usize> = 3..3 + NODES;

/// The case on which split and reference run: what the inputs are at the corners of lines of `line` seconds.
pub struct Run {
    /// s
    pub line: f64,
    /// Inputs at a corner.
    pub corner: fn(usize) -> Inputs,
    /// End, s.
    pub stop: f64,
    /// Communication step, s.
    pub h: f64,
}

/// Duty through zero, load in both directions, supply and room on ramps.
pub fn drive(k: usize) -> Inputs {
    let x = k as f64;
    Inputs {
        duty: 0.9 * (0.7 * x).sin() + 0.05,
        supply_voltage: 12.0 + (1.3 * x).sin(),
        load_torque: 0.15 * (0.9 * x).sin(),
        ambient_temperature: 293.15 + 3.0 * (0.1 * x).sin(),
    }
}

/// Largest difference between split and reference of each state over its largest size (temperatures: rise).
fn compare(mut m: BrushedGearmotor, run: &Run) -> Vec<(&'static str, f64)> {
    let states = |m: &BrushedGearmotor| -> [f64; STATES] {
        m.state().to_numbers().collect::<Vec<f64>>().try_into().expect("the states of Step::rates")
    };
    m.inputs = (run.corner)(0);
    m.start(0.0).unwrap();
    let mut y = states(&m);
    let (origin, parameters, constants) = (y[3], m.parameters, Constants::of(&m.parameters));
    let (mut error, mut size) = ([0.0f64; STATES], [0.0f64; STATES]);
    let (line, h) = (run.line.min(run.stop), run.h);
    let steps = (line / h).round() as usize;
    for piece in 0..(run.stop / line).round() as usize {
        let (a, b) = ((run.corner)(piece), (run.corner)(piece + 1));
        let t0 = piece as f64 * line;
        let mut slopes = Inputs::zero();
        for row in 0..Inputs::TABLE.len() {
            slopes.set(row, (b.get(row) - a.get(row)) / line);
        }
        // The reference begins anew where the duty turns, as the magnets' event lies between two pieces.
        let turn = Step::turns(a.duty, slopes.duty);
        let times: Vec<f64> = (1..=steps).map(|k| k as f64 * h).collect();
        let cuts = if turn < line { vec![0.0, turn, line] } else { vec![0.0, line] };
        let mut truth: Vec<[f64; STATES]> = Vec::new();
        for cut in cuts.windows(2) {
            let mut inputs = a.after(cut[0], &slopes);
            if cut[0] > 0.0 {
                inputs.duty = 0.0;
            }
            // Temperatures as rises, so that the tolerance is one on the rise.
            let shift = |z: &[f64; STATES], by: f64| -> [f64; STATES] {
                std::array::from_fn(|s| z[s] + if TEMPERATURES.contains(&s) { by } else { 0.0 })
            };
            let mut asked: Vec<f64> = times
                .iter()
                .map(|t| t - cut[0])
                .filter(|t| *t > 1e-12 && *t < cut[1] - cut[0] - 1e-12)
                .collect();
            let inner = asked.len();
            asked.push(cut[1] - cut[0]);
            let rates = |t: f64, z: &[f64; STATES]| {
                let y = shift(z, origin);
                // The drivers that a step of the model holds, at this instant.
                let mut now = parameters;
                let time = t0 + cut[0] + t;
                let then = inputs.after(t, &slopes);
                let ambient = then.ambient_temperature + now.effects.ambient_sensor() * time;
                now.effects.set_drivers(&Drivers {
                    speed: y[1],
                    current: y[0],
                    load_torque: then.load_torque,
                    winding_temperature: y[3],
                    housing_temperature: y[4],
                    ambient_temperature: ambient,
                    time,
                    ..Drivers::default()
                });
                Step::new(&now, &constants, &inputs, &slopes, t0 + cut[0]).rates(t, &y)
            };
            let found = integrate(rates, &shift(&y, -origin), &asked, TIGHT).unwrap();
            let found: Vec<[f64; STATES]> = found.iter().map(|z| shift(z, origin)).collect();
            y = found[inner];
            truth.extend(&found[..inner]);
            if cut[1] == line || times.iter().any(|t| (t - cut[1]).abs() <= 1e-12) {
                truth.push(y);
            }
        }
        assert_eq!(truth.len(), steps);
        for (k, truth) in truth.iter().enumerate() {
            let now = a.after(k as f64 * h, &slopes);
            for row in 0..Inputs::TABLE.len() {
                let slot = Slot { group: 0, row: row as u16 };
                m.set(slot, now.get(row));
                m.set_slope(slot, slopes.get(row));
            }
            m.step(m.time(), h).unwrap();
            for (s, got) in states(&m).into_iter().enumerate() {
                let zero = if TEMPERATURES.contains(&s) { origin } else { 0.0 };
                error[s] = error[s].max((got - truth[s]).abs());
                size[s] = size[s].max((truth[s] - zero).abs());
            }
        }
    }
    let declared = m.declaration();
    let name = |s: usize| declared.entries[declared.states[s][0]].name.as_str();
    (0..STATES).map(|s| (name(s), error[s] / if size[s] > 1e-12 { size[s] } else { 1.0 })).collect()
}

pub fn agrees(m: BrushedGearmotor, run: &Run, limit: f64, what: &str) {
    let errors = compare(m, run);
    println!("{what}: {errors:?}");
    assert!(errors.iter().all(|(_, e)| *e <= limit), "{what}: {errors:?}");
}
