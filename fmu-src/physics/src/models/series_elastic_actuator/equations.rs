//! The equations of the actuator.
//!
//! input shaft    phi = motor_angle + twist + opening,  w = motor_speed                                 rigid      (1)
//!                twist' = w - motor_speed,  J w' = tau_c - tau_in,
//!                tau_c = - k_c twist - d_c (w - motor_speed)                                  elastic    (2)
//! transmission   components/transmission.rs: angle_in, N, tau_in
//! spring         d = angle_in - joint_angle,  d' = w / N - joint_speed; components/springs.rs               (3)
//! joint          joint_torque = tau_s + tau_p                                                              (4)
//! motor          load_torque = tau_in (1), tau_c (2)                                                       (5)
//! control        components/torque_control.rs, for the demand less what the parallel spring gives
//! supply         components/supply.rs, for voltage times motor_current                                     (6)
//!
//! *Sign*: joint_torque > 0 pushes the joint in the positive direction, load_torque > 0 brakes a motor that turns
//! forwards. The motor gives angle and speed and gets a torque, the joint the same: no algebraic loop with either. An elastic
//! coupling of stiffness k_c asks for steps between the FMUs well below sqrt(J_motor / k_c).
//! *Neglects* the mass of springs, lever and nut (add it to the inertia), and what the motor's own FMU says of
//! its temperature, which the current control finds out.

use super::{Actuator, At, Outputs, STATES};
use crate::components::springs::Deflected;
use crate::components::torque_control::{Command, Seen};
use crate::components::transmission::Coupling;
use crate::ledger::{Account, Ledger};

/// Places of the states.
pub(super) const DEMAND: usize = 0;
const VOLTAGE: usize = 1;
const TWIST: usize = 2;
pub(super) const INPUT_SPEED: usize = 3;
const ENERGY_SHAFT: usize = 4;
const ENERGY_JOINT: usize = 5;
const ENERGY_TRANSMISSION: usize = 6;
const ENERGY_SUPPLY: usize = 7;

/// All that the rates need to know of one instant.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Twist of the coupling, rad, speed of the input shaft, rad/s, and how much faster it is than the motor, rad/s.
    shaft: [f64; 3],
    /// Turns of the shaft for one of the spring's input.
    ratio: f64,
    /// Torque that the transmission takes from its input shaft, N.m, and how much of it is friction.
    tau_in: f64,
    friction: f64,
    /// Deflection of the series spring, play included, rad, and its rate, rad/s.
    pub deflection: f64,
    rate: f64,
    /// The series spring.
    pub spring: Deflected,
    /// Torque of the parallel spring, N.m, and its energy, J.
    beside: [f64; 2],
    /// Torque that the actuator gives to the joint, N.m.
    pub joint_torque: f64,
    /// Torque that it takes from the motor's shaft, N.m.
    pub load_torque: f64,
    /// What the control does.
    pub command: Command,
    /// Power taken from the supply, W.
    pub supply_power: f64,
    /// Power at the motor's terminals, W.
    pub motor_power: f64,
    /// Heat of friction, coupling and spring, W.
    pub loss: f64,
    /// Derivatives of the states.
    pub rates: [f64; STATES],
}

/// The books at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Books {
    /// Energy in springs, coupling and inertia, J.
    pub stored: f64,
    /// Power that is unaccounted for, W.
    pub error: f64,
}

impl Actuator {
    /// Whether the coupling gives.
    pub(super) fn is_elastic(&self) -> bool {
        self.transmission.coupling == Coupling::Elastic
    }

    /// What holds at one instant.
    pub fn point(&self, now: &At<'_>) -> Point {
        let (u, x, transmission) = (now.inputs, now.states, &self.transmission);
        let elastic = self.is_elastic();
        let (twist, w) = if elastic { (x[TWIST], x[INPUT_SPEED]) } else { (0.0, u.motor_speed) };
        let (angle_in, n) = transmission.output(u.motor_angle + twist + now.opening[0]);
        let deflection = angle_in - u.joint_angle;
        let rate = w / n - u.joint_speed;
        let spring = self.spring.deflected(deflection, rate, transmission.backlash);
        let (beside, beside_energy) = self.parallel.at(u.joint_angle);
        let (tau_in, friction) = transmission.input_torque(spring.torque, n, w);
        let slip = w - u.motor_speed;
        let coupling = -transmission.coupling_stiffness * twist - transmission.coupling_damping * slip;
        let load_torque = if elastic { coupling } else { tau_in };
        let joint_torque = spring.torque + beside;

        let demand = u.torque_demand - beside;
        let demand_rate = self.control.demand_rate(demand, x[DEMAND]);
        let way_speed = n * (u.joint_speed + demand_rate / self.spring.stiffness);
        let command = self.control.command(
            &Seen {
                demand,
                feed_forward: transmission.input_torque(demand, n, way_speed).0,
                way_speed,
                torque: [spring.torque, spring.rate],
                turns_per_torque: n / self.spring.stiffness,
                motor: [u.motor_speed, u.motor_current],
                supply: u.supply_voltage,
            },
            [x[DEMAND], x[VOLTAGE]],
        );
        let motor_power = command.voltage[1] * u.motor_current;
        let supply_power = self.drive.power(motor_power);
        let damping = if elastic { transmission.coupling_damping * slip * slip } else { 0.0 };
        let loss = damping + friction * w + spring.loss;

        let mut rates = [0.0; STATES];
        (rates[DEMAND], rates[VOLTAGE]) = (command.rates[0], command.rates[1]);
        if elastic {
            (rates[TWIST], rates[INPUT_SPEED]) = (slip, (coupling - tau_in) / transmission.inertia);
        }
        rates[ENERGY_SHAFT] = load_torque * u.motor_speed;
        rates[ENERGY_JOINT] = joint_torque * u.joint_speed;
        rates[ENERGY_TRANSMISSION] = loss;
        rates[ENERGY_SUPPLY] = supply_power;
        Point {
            shaft: [twist, w, slip],
            ratio: n,
            tau_in,
            friction,
            deflection,
            rate,
            spring,
            beside: [beside, beside_energy],
            joint_torque,
            load_torque,
            command,
            supply_power,
            motor_power,
            loss,
            rates,
        }
    }

    /// The books: the shaft's power goes on to the joint, into springs and inertia, and into heat.
    pub fn books(&self, now: &At<'_>, p: &Point) -> Books {
        use Account::{Ambient, Joint, Kinetic, Shaft, Spring};
        let (u, transmission, elastic) = (now.inputs, &self.transmission, self.is_elastic());
        let ([twist, w, slip], [beside, beside_energy]) = (p.shaft, p.beside);
        let damping = if elastic { transmission.coupling_damping * slip * slip } else { 0.0 };
        let twisting = if elastic { transmission.coupling_stiffness * twist * slip } else { 0.0 };
        let mut ledger = Ledger::default();
        ledger.transfer(Shaft, Kinetic, p.load_torque * u.motor_speed);
        ledger.transfer(Kinetic, Ambient, damping + p.friction * w);
        ledger.transfer(Kinetic, Spring, twisting + p.spring.torque * w / p.ratio);
        ledger.transfer(Spring, Ambient, p.spring.loss);
        ledger.transfer(Spring, Joint, p.joint_torque * u.joint_speed);
        // What the stores gain by their own derivatives.
        let stretching = p.spring.torque * p.rate - p.spring.loss;
        let into_springs = stretching + twisting - beside * u.joint_speed;
        let into_inertia = if elastic { w * (p.load_torque - p.tau_in) } else { 0.0 };
        let coupling_energy = if elastic {
            0.5 * (transmission.coupling_stiffness * twist * twist + transmission.inertia * w * w)
        } else {
            0.0
        };
        Books {
            stored: p.spring.energy + beside_energy + coupling_energy,
            error: ledger.error(&[
                (Shaft, -p.rates[ENERGY_SHAFT]),
                (Joint, p.rates[ENERGY_JOINT]),
                (Ambient, p.rates[ENERGY_TRANSMISSION]),
                (Spring, into_springs),
                (Kinetic, into_inertia),
            ]),
        }
    }

    /// Energy in springs, coupling and inertia, J.
    pub(super) fn stored(&self, now: &At<'_>) -> f64 {
        self.books(now, &self.point(now)).stored
    }

    /// The outputs.
    pub(super) fn show(&self, now: &At<'_>) -> Outputs {
        let (p, u, x) = (self.point(now), now.inputs, now.states);
        let books = self.books(now, &p);
        Outputs {
            voltage: p.command.voltage[1],
            current_command: p.command.current[1],
            load_torque: p.load_torque,
            joint_torque: p.joint_torque,
            spring_deflection: p.deflection,
            supply_power: p.supply_power,
            torque_error: p.joint_torque - u.torque_demand,
            joint_power: p.joint_torque * u.joint_speed,
            loss_transmission: p.loss,
            loss_drive: p.supply_power - p.motor_power,
            energy_shaft: x[ENERGY_SHAFT],
            energy_joint: x[ENERGY_JOINT],
            energy_transmission: x[ENERGY_TRANSMISSION],
            energy_supply: x[ENERGY_SUPPLY],
            power_balance_error: books.error,
            energy_balance_error: x[ENERGY_SHAFT]
                - x[ENERGY_JOINT]
                - x[ENERGY_TRANSMISSION]
                - (books.stored - now.opening[1]),
        }
    }
}
