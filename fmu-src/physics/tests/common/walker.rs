//! Motor, actuator and gait: coupled step by step, and their joined equations integrated as one system.

use physics::exchange::Exchange;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode};
use physics::models::gait_load::GaitLoad;
use physics::models::series_elastic_actuator::SeriesElasticActuator;
use reference::{Tolerance, integrate};
use std::cell::RefCell;

/// Sets a variable by name.
pub fn set(m: &mut dyn Model, name: &str, value: f64) {
    let entry = m.declaration().by_name(name).unwrap_or_else(|| panic!("no {name}"));
    entry.check(value, false).unwrap_or_else(|r| panic!("{}", entry.explain(value, &r)));
    m.set(entry.slot, value);
}

/// Reads a variable by name.
pub fn get(m: &mut dyn Model, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no {name}")).slot;
    m.get(slot)
}

/// What is compared: torque of the joint, N.m, speed of the motor, rad/s, temperature of the winding, K.
pub const LOOKED_AT: [&str; 3] = ["actuator.joint_torque", "motor.shaft_speed", "motor.winding_temperature"];
/// Instants of comparison, s; dense, so that no single one decides where dry friction reverses.
pub const TIMES: [f64; 48] = {
    let (mut times, mut k) = ([0.0; 48], 0);
    while k < times.len() {
        times[k] = (k + 1) as f64 / 100.0;
        k += 1;
    }
    times
};

/// Motor, actuator and gait, one integration step after the other with what the others said before.
pub struct System {
    /// The motor.
    pub motor: AnnulusCooledMotor,
    /// The actuator.
    pub actuator: SeriesElasticActuator,
    /// The gait.
    pub gait: GaitLoad,
}

/// From output to input: gait to actuator.
pub const GAIT: [(&str, &str); 3] =
    [("joint_angle", "joint_angle"), ("joint_speed", "joint_speed"), ("torque_demand", "torque_demand")];
/// Motor to actuator.
pub const MOTOR: [(&str, &str); 3] =
    [("shaft_angle", "motor_angle"), ("shaft_speed", "motor_speed"), ("current", "motor_current")];
/// Actuator to motor; the motor follows one of the first two, as its drive mode says.
pub const COMMAND: [(&str, &str); 3] =
    [("voltage", "voltage"), ("current_command", "current_command"), ("load_torque", "load_torque")];
/// Motor to actuator, after the motor has its command.
pub const POWER: [(&str, &str); 1] = [("power_electrical", "motor_power")];

impl System {
    /// Started, as an importer does it.
    pub fn new(drive: DriveMode) -> System {
        let mut motor = AnnulusCooledMotor::default();
        motor.parameters.choices.drive_mode = drive;
        let mut s = System { motor, actuator: Default::default(), gait: Default::default() };
        // The second item: motor_power.
        set(&mut s.actuator, "drive.power_source", 2.0);
        s.gait.start(0.0).unwrap();
        for (from, to) in GAIT {
            let value = get(&mut s.gait, from);
            set(&mut s.actuator, to, value);
        }
        s.motor.start(0.0).unwrap();
        s.actuator.start(0.0).unwrap();
        s
    }

    /// Hands every output to its input.
    pub fn connect(&mut self) {
        for (from, to) in GAIT {
            let value = get(&mut self.gait, from);
            set(&mut self.actuator, to, value);
        }
        for (from, to) in MOTOR {
            let value = get(&mut self.motor, from);
            set(&mut self.actuator, to, value);
        }
        for (from, to) in COMMAND {
            let value = get(&mut self.actuator, from);
            set(&mut self.motor, to, value);
        }
        for (from, to) in POWER {
            let value = get(&mut self.motor, from);
            set(&mut self.actuator, to, value);
        }
    }

    /// What is compared: [`LOOKED_AT`].
    pub fn look(&mut self) -> [f64; 3] {
        [
            get(&mut self.actuator, "joint_torque"),
            get(&mut self.motor, "shaft_speed"),
            get(&mut self.motor, "winding_temperature"),
        ]
    }
}

/// States of the joined equations: the motor's, the actuator's, the gait's.
const COUNT: [usize; 3] = [15, 8, 2];
const ALL: usize = 25;

/// The joined equations by diffsol, at each of `times`, s.
pub fn joined(drive: DriveMode, times: &[f64]) -> Vec<[f64; 3]> {
    let mut s = System::new(drive);
    s.motor.enter_model_exchange();
    s.motor.start(0.0).unwrap();
    s.connect();
    let split = |x: &[f64; ALL]| {
        let (motor, rest) = x.split_at(COUNT[0]);
        let (actuator, gait) = rest.split_at(COUNT[1]);
        (motor.to_vec(), actuator.to_vec(), gait.to_vec())
    };
    let mut x0 = [0.0; ALL];
    let (m, rest) = x0.split_at_mut(COUNT[0]);
    let (a, g) = rest.split_at_mut(COUNT[1]);
    s.motor.read_states(m);
    s.actuator.read_states(a);
    s.gait.read_states(g);
    let s = RefCell::new(s);
    let put = |t: f64, x: &[f64; ALL]| {
        let mut s = s.borrow_mut();
        let (m, a, g) = split(x);
        s.motor.write_time(t);
        s.motor.write_states(&m);
        s.actuator.write_time(t);
        s.actuator.write_states(&a);
        s.gait.write_time(t);
        s.gait.write_states(&g);
        s.connect();
    };
    let rates = |t: f64, x: &[f64; ALL]| {
        put(t, x);
        let mut s = s.borrow_mut();
        let mut out = [0.0; ALL];
        let (m, rest) = out.split_at_mut(COUNT[0]);
        let (a, g) = rest.split_at_mut(COUNT[1]);
        s.motor.derivatives(m).unwrap();
        s.actuator.derivatives(a).unwrap();
        s.gait.derivatives(g).unwrap();
        out
    };
    let tolerance = Tolerance { relative: 1e-9, absolute: 1e-9 };
    let solution = integrate(rates, &x0, times, tolerance).unwrap();
    let look = |(&t, x): (&f64, &[f64; ALL])| {
        put(t, x);
        s.borrow_mut().look()
    };
    times.iter().zip(&solution).map(look).collect()
}
