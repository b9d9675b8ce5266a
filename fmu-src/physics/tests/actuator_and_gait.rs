//! Motor, actuator and gait: the actuator's books and closed forms, and the three coupled against one integration of their
//! joined equations.

use crate::walker::{COMMAND, GAIT, LOOKED_AT, MOTOR, POWER, System, TIMES, get, joined, set};
use physics::components::transmission::Coupling;
use physics::model::Model;
use physics::models::annulus_cooled_motor::DriveMode;
use physics::models::series_elastic_actuator::SeriesElasticActuator;
use reference::{Tolerance, integrate};
use std::cell::RefCell;

/// An actuator that holds a fixed joint with a motor at this angle, started relaxed.
fn twisted(turn: f64, change: impl Fn(&mut SeriesElasticActuator)) -> SeriesElasticActuator {
    let mut m = SeriesElasticActuator::default();
    change(&mut m);
    m.start(0.0).unwrap();
    m.inputs.motor_angle = turn;
    m
}

/// 250 turns for one and 250 N.m/rad: a radian of the motor is 1 N.m at the joint, 4 mN.m at the motor.
#[test]
fn the_spring_turns_angle_into_torque() {
    let mut m = twisted(50.0, |_| ());
    assert!((get(&mut m, "spring_deflection") - 0.2).abs() < 1e-15);
    assert!((get(&mut m, "joint_torque") - 50.0).abs() < 1e-12);
    assert!((get(&mut m, "load_torque") - 0.2).abs() < 1e-15);
    m.inputs.joint_angle = 0.2;
    set(&mut m, "spring.stiffness", 500.0);
    assert!(get(&mut m, "joint_torque").abs() < 1e-12);
}

#[test]
fn at_the_start_the_spring_carries_the_demand() {
    for (kind, backlash, parallel) in [(1.0, 0.0, 0.0), (2.0, 0.01, 80.0)] {
        let mut m = SeriesElasticActuator::default();
        set(&mut m, "transmission.kind", kind);
        set(&mut m, "transmission.backlash", backlash);
        set(&mut m, "parallel.stiffness", parallel);
        set(&mut m, "joint_angle", 0.3);
        set(&mut m, "motor_angle", 17.0);
        set(&mut m, "torque_demand", -42.0);
        m.start(0.0).unwrap();
        assert!((get(&mut m, "joint_torque") + 42.0).abs() < 1e-9);
        assert!(get(&mut m, "torque_error").abs() < 1e-9);
        assert_eq!(get(&mut m, "energy_balance_error"), 0.0);
    }
}

/// A coupled inertia swings against its coupling and the spring: w = sqrt((k_c + k_s / N^2) / J).
#[test]
fn an_inertia_swings_at_its_frequency() {
    let mut m = twisted(0.0, |m| {
        m.parameters.transmission.coupling = Coupling::Elastic;
        m.parameters.transmission.inertia = 1e-6;
        m.parameters.transmission.coupling_damping = 0.0;
        m.parameters.transmission.efficiency = 1.0;
    });
    let w: f64 = ((1.0 + 250.0 / 250.0f64.powi(2)) / 1e-6f64).sqrt();
    m.set_states(0.0, &[0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (mut t, h) = (0.0, 1e-4);
    for _ in 0..100 {
        m.step(t, h).unwrap();
        t += h;
        let (twist, speed) = (get(&mut m, "state.coupling_twist"), get(&mut m, "state.input_speed"));
        assert!((twist - 0.01 * (w * t).cos()).abs() < 2e-7, "{t} {twist}");
        assert!((speed + 0.01 * w * (w * t).sin()).abs() < 2e-4);
    }
}

/// A motor and a joint that swing, every part of the actuator at work, integrated by diffsol: what goes in comes out, is
/// stored, or is heat.
#[test]
fn the_actuators_books_close() {
    for change in [
        (|_| ()) as fn(&mut SeriesElasticActuator),
        |m| {
            m.parameters.spring.damping = 2.0;
            m.parameters.parallel.stiffness = 60.0;
            m.parameters.transmission.backlash = 0.004;
        },
        |m| {
            m.parameters.transmission.coupling = Coupling::Elastic;
            m.parameters.transmission.inertia = 2e-6;
            m.parameters.transmission.coupling_damping = 5e-4;
        },
        |m| {
            m.set(m.declaration().by_name("transmission.kind").unwrap().slot, 2.0);
            m.parameters.drive.efficiency = 0.9;
        },
    ] {
        let m = RefCell::new(twisted(0.0, change));
        let imposed = |t: f64| {
            let mut m = m.borrow_mut();
            let (a, b) = (9.0, 14.0);
            m.inputs.motor_angle = 40.0 * (a * t).sin();
            m.inputs.motor_speed = 40.0 * a * (a * t).cos();
            m.inputs.joint_angle = 0.1 * (b * t).sin();
            m.inputs.joint_speed = 0.1 * b * (b * t).cos();
            m.inputs.motor_current = 3.0 * (20.0 * t).sin();
            m.inputs.torque_demand = 30.0 * (5.0 * t).sin();
        };
        let rates = |t: f64, x: &[f64; 8]| {
            imposed(t);
            let (mut m, mut out) = (m.borrow_mut(), Vec::new());
            m.set_states(t, x);
            m.rates(&mut out);
            std::array::from_fn(|k| out[k])
        };
        let tolerance = Tolerance { relative: 1e-9, absolute: 1e-9 };
        let times: Vec<f64> = (1..=20).map(|k| f64::from(k) * 0.05).collect();
        let mut largest = 0.0f64;
        for (t, x) in times.iter().zip(integrate(rates, &[0.0; 8], &times, tolerance).unwrap()) {
            imposed(*t);
            let mut m = m.borrow_mut();
            m.set_states(*t, &x);
            assert!(get(&mut *m, "power_balance_error") < 1e-9);
            // The play's corners cost the integrator some of its accuracy.
            let error = get(&mut *m, "energy_balance_error");
            assert!(error.abs() < 1e-4, "{t} {error} of {}", get(&mut *m, "energy_shaft"));
            largest = largest.max(get(&mut *m, "energy_shaft").abs());
        }
        assert!(largest > 1.0);
    }
}

impl System {
    /// Lets the inputs run on along the line through their last two values.
    pub fn slope(&mut self, last: &[f64], h: f64) -> Vec<f64> {
        let mut now = Vec::new();
        let mut one = |m: &mut dyn Model, to: &str| {
            let (slot, value) = (m.declaration().by_name(to).unwrap().slot, get(m, to));
            if let Some(before) = last.get(now.len()) {
                m.set_slope(slot, (value - before) / h);
            }
            now.push(value);
        };
        for (_, to) in GAIT.iter().chain(&MOTOR) {
            one(&mut self.actuator, to);
        }
        for (_, to) in COMMAND {
            one(&mut self.motor, to);
        }
        for (_, to) in POWER {
            one(&mut self.actuator, to);
        }
        now
    }

    /// Runs to `stop`, s, by Jacobi steps of `h`, s.
    pub fn run(mut self, stop: f64, h: f64, slopes: bool) -> [f64; 3] {
        let mut last = Vec::new();
        for k in 0..(stop / h).round() as u32 {
            self.connect();
            if slopes {
                last = self.slope(&last, h);
            }
            let t = f64::from(k) * h;
            self.motor.step(t, h).unwrap();
            self.actuator.step(t, h).unwrap();
            self.gait.step(t, h).unwrap();
        }
        self.connect();
        self.look()
    }
}

/// The coupled system runs into the joined equations' solution: with the first order of the step where inputs are held,
/// with the second where they go along slopes.
#[test]
fn the_coupled_system_converges_to_the_joined_equations() {
    let solution = joined(DriveMode::Voltage, &TIMES);
    let (stop, exact) = (TIMES[TIMES.len() - 1], solution[TIMES.len() - 1]);
    let error = |h: f64, slopes: bool| {
        let found = System::new(DriveMode::Voltage).run(stop, h, slopes);
        println!("h = {h} s, slopes {slopes}: {found:?} against {exact:?}");
        [0, 1].map(|k| ((found[k] - exact[k]) / exact[k]).abs())
    };
    for (slopes, order) in [(false, 1.0), (true, 2.0)] {
        let (coarse, fine) = (error(1e-4, slopes), error(2.5e-5, slopes));
        for k in 0..2 {
            let found = (coarse[k] / fine[k]).log2() / 2.0;
            assert!((found - order).abs() < 0.35, "{slopes} {k}: {found} ({coarse:?} {fine:?})");
        }
    }
    let ms = error(1e-3, true);
    assert!(ms[0] < 2e-3 && ms[1] < 1e-2, "{ms:?}");
}

/// The stored solution, which the FMUs are held against through every master, is the joined equations'.
#[test]
fn the_stored_solution_is_that_of_the_joined_equations() {
    let stored = include_str!("../../../tests/reference/coupled-ankle/joined.csv");
    let mut lines = stored.lines();
    assert_eq!(lines.next().unwrap(), format!("time,{}", LOOKED_AT.join(",")));
    for ((line, t), found) in lines.zip(TIMES).zip(joined(DriveMode::Voltage, &TIMES)) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(row[0], t);
        for (a, b) in row[1..].iter().zip(found) {
            assert!((a - b).abs() < 1e-6 * b.abs(), "{t}: {a} {b}");
        }
    }
    assert_eq!(stored.lines().count(), 1 + TIMES.len());
}

/// The supply gives what the motor takes and the drive loses, whatever the motor follows; warm and near its current
/// limit the voltage of the motor is not the one that the actuator commands.
#[test]
fn the_supply_gives_what_the_motor_takes() {
    for drive in [DriveMode::Voltage, DriveMode::Current] {
        for efficiency in [1.0, 0.9] {
            let mut s = System::new(drive);
            set(&mut s.actuator, "drive.efficiency", efficiency);
            set(&mut s.actuator, "drive.regeneration", 0.0);
            set(&mut s.motor, "ambient_temperature", 340.0);
            set(&mut s.gait, "gait.body_mass", 90.0);
            // The coupling error falls with the square of the step: 3e-3 at 1 ms.
            let h = 2.5e-4;
            let (mut last, mut drawn) = (Vec::new(), 0.0);
            for k in 0..8000u32 {
                s.connect();
                last = s.slope(&last, h);
                let t = f64::from(k) * h;
                let before = get(&mut s.motor, "energy_electrical");
                s.motor.step(t, h).unwrap();
                s.actuator.step(t, h).unwrap();
                s.gait.step(t, h).unwrap();
                drawn += (get(&mut s.motor, "energy_electrical") - before).max(0.0) / efficiency;
            }
            let supplied = get(&mut s.actuator, "energy_supply");
            println!("{drive:?} {efficiency}: {supplied} J from the supply, {drawn} J drawn");
            assert!(drawn > 50.0 && (supplied / drawn - 1.0).abs() < 1e-3, "{supplied} {drawn}");
        }
    }
}

/// A minute of walking by the ankle of the declared values: the torque is given, and nothing is lost on the way.
#[test]
fn the_ankle_walks() {
    let mut s = System::new(DriveMode::Voltage);
    let h = 1e-3;
    let (mut squares, mut peak) = (0.0, 0.0f64);
    let mut last = Vec::new();
    for k in 0..60_000u32 {
        s.connect();
        last = s.slope(&last, h);
        let t = f64::from(k) * h;
        s.motor.step(t, h).unwrap();
        s.actuator.step(t, h).unwrap();
        s.gait.step(t, h).unwrap();
        squares += get(&mut s.actuator, "torque_error").powi(2);
        peak = peak.max(get(&mut s.actuator, "joint_torque"));
    }
    let error = (squares / 6e4).sqrt();
    println!("error {error} N.m of {peak} N.m, winding {} K", get(&mut s.motor, "winding_temperature"));
    // 75 kg times the adult's 1.37 N.m/kg.
    assert!((101.0..105.0).contains(&peak), "{peak}");
    assert!(error < 0.02 * peak, "{error} of {peak}");
    let asked = get(&mut s.gait, "energy_demand");
    let given = get(&mut s.actuator, "energy_joint");
    assert!((given / asked - 1.0).abs() < 0.02, "{given} {asked}");
    let shaft = get(&mut s.motor, "energy_mechanical");
    let taken = get(&mut s.actuator, "energy_shaft");
    println!(
        "shaft {shaft} J, taken {taken} J, joint {given} J, books {}",
        get(&mut s.actuator, "energy_balance_error")
    );
    assert!((shaft / taken - 1.0).abs() < 2e-3, "{shaft} {taken}");
}
