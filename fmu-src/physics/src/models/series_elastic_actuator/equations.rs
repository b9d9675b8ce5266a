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

/// All that the equations say at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Deflection of the series spring, play included, rad.
    pub deflection: f64,
    /// The series spring.
    pub spring: Deflected,
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
    /// Energy in springs, coupling and inertia, J.
    pub stored: f64,
    /// The books: powers of shaft, joint, and what the stores gain, W.
    pub ledger: Ledger,
    /// Powers that the stores gain by their own derivatives, W: springs and inertia.
    pub gains: [f64; 2],
    /// Derivatives of the states.
    pub rates: [f64; STATES],
}

impl Actuator {
    /// Whether the coupling gives.
    pub(super) fn is_elastic(&self) -> bool {
        self.transmission.coupling == Coupling::Elastic
    }

    /// All that holds at one instant.
    pub fn point(&self, now: &At<'_>) -> Point {
        use Account::{Ambient, Joint, Kinetic, Shaft, Spring};
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

        // The books: the shaft's power goes on to the joint, into springs and inertia, and into heat.
        let mut ledger = Ledger::default();
        ledger.transfer(Shaft, Kinetic, load_torque * u.motor_speed);
        let coupling_damping = if elastic { transmission.coupling_damping * slip * slip } else { 0.0 };
        let coupling_spring = if elastic { transmission.coupling_stiffness * twist * slip } else { 0.0 };
        ledger.transfer(Kinetic, Ambient, coupling_damping + friction * w);
        ledger.transfer(Kinetic, Spring, coupling_spring + spring.torque * w / n);
        ledger.transfer(Spring, Ambient, spring.loss);
        ledger.transfer(Spring, Joint, joint_torque * u.joint_speed);
        let stretching = spring.torque * rate - spring.loss;
        let w_rate = if elastic { (coupling - tau_in) / transmission.inertia } else { 0.0 };
        let gains = [
            stretching + coupling_spring - beside * u.joint_speed,
            if elastic { transmission.inertia * w * w_rate } else { 0.0 },
        ];
        let kinetic = 0.5 * transmission.inertia * w * w;
        let coupling_energy =
            if elastic { 0.5 * transmission.coupling_stiffness * twist * twist } else { 0.0 };
        let loss = ledger.gain(Ambient);

        let mut rates = [0.0; STATES];
        (rates[DEMAND], rates[VOLTAGE]) = (command.rates[0], command.rates[1]);
        if elastic {
            (rates[TWIST], rates[INPUT_SPEED]) = (slip, w_rate);
        }
        rates[ENERGY_SHAFT] = load_torque * u.motor_speed;
        rates[ENERGY_JOINT] = joint_torque * u.joint_speed;
        rates[ENERGY_TRANSMISSION] = loss;
        rates[ENERGY_SUPPLY] = supply_power;
        Point {
            deflection,
            spring,
            joint_torque,
            load_torque,
            command,
            supply_power,
            motor_power,
            loss,
            stored: spring.energy + beside_energy + coupling_energy + if elastic { kinetic } else { 0.0 },
            ledger,
            gains,
            rates,
        }
    }

    /// The outputs.
    pub(super) fn show(&self, now: &At<'_>) -> Outputs {
        let (p, u, x) = (self.point(now), now.inputs, now.states);
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
            power_balance_error: p.ledger.error(&[
                (Account::Shaft, -p.rates[ENERGY_SHAFT]),
                (Account::Joint, p.rates[ENERGY_JOINT]),
                (Account::Spring, p.gains[0]),
                (Account::Kinetic, p.gains[1]),
            ]),
            energy_balance_error: x[ENERGY_SHAFT]
                - x[ENERGY_JOINT]
                - x[ENERGY_TRANSMISSION]
                - (p.stored - now.opening[1]),
        }
    }
}
