//! The equations of the actuator.
//!
//! input shaft    phi = motor_angle + twist + initial,  w = motor_speed                                 rigid      (1)
//!                twist' = w - motor_speed,  J w' = tau_c - tau_in,
//!                tau_c = - k_c twist - d_c (w - motor_speed)                                  elastic    (2)
//! transmission   components/transmission.rs: angle_in, N, tau_in
//! spring         d = angle_in - joint_angle,  d' = w / N - joint_speed; components/springs.rs               (3)
//! joint          joint_torque = tau_s + tau_p                                                              (4)
//! motor          load_torque = tau_in (1), tau_c (2)                                                       (5)
//! control        components/torque_control.rs, for the demand minus the torque of the parallel spring
//! supply         components/supply.rs, for motor_power, or for voltage times motor_current as an estimate   (6)
//!
//! *Sign*: joint_torque > 0 accelerates the joint in the positive direction, load_torque > 0 brakes a motor that turns
//! forwards. Motor and joint have angle and speed as outputs and torque as input, so there is no algebraic loop with either.
//! An elastic coupling of stiffness k_c requires communication steps well below sqrt(J_motor / k_c).
//! The estimate of (6) holds for a motor driven by `voltage`. A motor driven by `current_command` has a different terminal
//! voltage, so its power must be connected to `motor_power`, as in the systems and studies of this project.
//! *Neglects* the mass of springs, lever and nut (add it to the inertia), and the temperature of the motor, for which the
//! integral part of the current control compensates.

use super::{Actuator, At, Balance, Inputs, LIST, OPENING, Outputs, STATES};
use crate::components::springs::Deflected;
use crate::components::supply::PowerSource;
use crate::components::torque_control::{Command, Seen, Wanted};
use crate::components::transmission::Coupling;
use crate::explicit::{Line, sizes};
use crate::ledger::{Account, Ledger};
use crate::solver::explicit::{Tried, share_of};
use crate::solver::lobatto::{AT, POINTS, integral, integrals};

/// Indices of the states.
pub(super) const DEMAND: usize = 0;
const VOLTAGE: usize = 1;
const TWIST: usize = 2;
pub(super) const INPUT_SPEED: usize = 3;
const ENERGY_SHAFT: usize = 4;
const ENERGY_JOINT: usize = 5;
const ENERGY_TRANSMISSION: usize = 6;
const ENERGY_SUPPLY: usize = 7;
/// Number of quadrature points of a step after the first.
const LATER: usize = POINTS - 1;
/// Transmission and springs at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Mechanics {
    /// Twist of the coupling, rad, speed of the input shaft, rad/s, and its speed relative to the motor, rad/s.
    shaft: [f64; 3],
    /// Ratio of the shaft's speed to that of the spring's input.
    ratio: f64,
    /// Torque at the input shaft of the transmission, N.m, and its friction part, N.m.
    tau_in: f64,
    friction: f64,
    /// Torque of an elastic coupling, N.m, and dissipated power of its damping, W.
    coupling: f64,
    damping: f64,
    /// Deflection of the series spring including backlash, rad, and its derivative, rad/s.
    pub deflection: f64,
    rate: f64,
    /// The series spring.
    pub spring: Deflected,
    /// Torque of the parallel spring, N.m, and its energy, J.
    beside: [f64; 2],
    /// Torque at the joint, N.m.
    pub joint_torque: f64,
    /// Load torque at the motor's shaft, N.m.
    pub load_torque: f64,
    /// Dissipated power of friction, coupling and spring, W.
    pub loss: f64,
    /// Torque demand on the series spring, N.m.
    demand: f64,
}

/// Quantities at one instant, for rates and outputs.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Transmission and springs.
    pub mechanics: Mechanics,
    /// Commands of the control.
    pub command: Command,
    /// Power from the supply, W.
    pub supply_power: f64,
    /// Electrical power of the motor, W.
    pub motor_power: f64,
    /// Derivatives of the states.
    pub rates: [f64; STATES],
}

/// The energy balance at one instant.
#[derive(Clone, Copy, Debug)]
pub struct EnergyBalance {
    /// Energy in springs, coupling and inertia, J.
    pub stored: f64,
    /// Power balance residual, W.
    pub error: f64,
}

impl Actuator {
    /// Whether the coupling is elastic.
    pub(super) fn is_elastic(&self) -> bool {
        self.transmission.coupling == Coupling::Elastic
    }

    /// Evaluates the equations at one instant.
    pub fn at(&self, now: &At<'_>) -> Point {
        let (u, x) = (now.inputs, now.states);
        let shaft = if self.is_elastic() { [x[TWIST], x[INPUT_SPEED]] } else { [0.0, u.motor_speed] };
        let m = self.mechanics(u, shaft, now.initial[0]);
        let demand_rate = self.control.demand_rate(m.demand, x[DEMAND]);
        let wanted = self.wanted(u, &m, demand_rate);
        let command = self.control.voltage(&wanted, u.motor_current, x[VOLTAGE]);
        let [motor_power, supply_power] = self.powers(u, &command);
        let mut rates = [0.0; STATES];
        (rates[DEMAND], rates[VOLTAGE]) = (command.rates[0], command.rates[1]);
        if self.is_elastic() {
            (rates[TWIST], rates[INPUT_SPEED]) =
                (m.shaft[2], (m.coupling - m.tau_in) / self.transmission.inertia);
        }
        rates[ENERGY_SHAFT] = m.load_torque * u.motor_speed;
        rates[ENERGY_JOINT] = m.joint_torque * u.joint_speed;
        rates[ENERGY_TRANSMISSION] = m.loss;
        rates[ENERGY_SUPPLY] = supply_power;
        Point { mechanics: m, command, supply_power, motor_power, rates }
    }

    /// The same for the states `x`, `t` seconds after the start of a step.
    pub fn at_line(&self, line: &Line<'_, Inputs, OPENING>, t: f64, x: &[f64; STATES]) -> Point {
        let inputs = line.inputs(t);
        self.at(&At { time: line.time + t, inputs: &inputs, states: x, initial: line.initial })
    }

    /// Transmission and springs; `twist` is that of the input shaft relative to the motor shaft, rad, `w` its speed, rad/s,
    /// `initial` its angle at motor angle 0, rad.
    #[inline(always)]
    fn mechanics(&self, u: &Inputs, [twist, w]: [f64; 2], initial: f64) -> Mechanics {
        let transmission = &self.transmission;
        let (angle_in, n) = transmission.output(u.motor_angle + twist + initial);
        let deflection = angle_in - u.joint_angle;
        let rate = w / n - u.joint_speed;
        let spring = self.spring.deflected(deflection, rate, transmission.backlash);
        let (beside, beside_energy) = self.parallel.at(u.joint_angle);
        let (tau_in, friction) = transmission.input_torque(spring.torque, n, w);
        let slip = w - u.motor_speed;
        let elastic = self.is_elastic();
        let (coupling, damping) = if elastic {
            let damping = transmission.coupling_damping * slip;
            (-transmission.coupling_stiffness * twist - damping, damping * slip)
        } else {
            (0.0, 0.0)
        };
        Mechanics {
            shaft: [twist, w, slip],
            ratio: n,
            tau_in,
            friction,
            coupling,
            damping,
            deflection,
            rate,
            spring,
            beside: [beside, beside_energy],
            joint_torque: spring.torque + beside,
            load_torque: if elastic { coupling } else { tau_in },
            loss: damping + friction * w + spring.loss,
            demand: u.torque_demand - beside,
        }
    }

    /// Motor speed that follows joint and demand, rad/s; `demand_rate` in N.m/s.
    #[inline(always)]
    fn way_speed(&self, u: &Inputs, m: &Mechanics, demand_rate: f64) -> f64 {
        m.ratio * u.joint_speed + m.ratio / self.spring.stiffness * demand_rate
    }

    /// Unlimited current command; `demand_rate` in N.m/s.
    #[inline(always)]
    fn wanted(&self, u: &Inputs, m: &Mechanics, demand_rate: f64) -> Wanted {
        let turns_per_torque = m.ratio / self.spring.stiffness;
        let way_speed = self.way_speed(u, m, demand_rate);
        let seen = Seen {
            demand: m.demand,
            feed_forward: self.transmission.input_torque(m.demand, m.ratio, way_speed).0,
            way_speed,
            torque: [m.spring.torque, m.spring.rate],
            turns_per_torque,
            motor: [u.motor_speed, u.motor_current],
            supply: u.supply_voltage,
        };
        self.control.wanted(&seen, demand_rate)
    }

    /// Electrical power of the motor and power from the supply, W: eq. (6).
    #[inline(always)]
    fn powers(&self, u: &Inputs, command: &Command) -> [f64; 2] {
        let motor = match self.drive.power_source {
            PowerSource::VoltageCommand => command.voltage[1] * u.motor_current,
            PowerSource::MotorPower => u.motor_power,
        };
        [motor, self.drive.power(motor)]
    }

    /// Step of `h` seconds with a rigid coupling and without a kink of the torque. The derivatives depend on no state except the
    /// filtered demand, which has a closed form:
    ///
    /// tau_f = tau_d - T tau_d' + (tau_f0 - tau_d0 + T tau_d') exp(-t / T)                                          (7)
    ///
    /// All other states are integrals. `None` with an elastic coupling, with a limited voltage, whose integral part has feedback,
    /// and at a kink of the torque, whose time the general integrator must locate.
    #[inline]
    pub(super) fn along(
        &self,
        line: &Line<'_, Inputs, OPENING>,
        t: f64,
        x: &[f64; STATES],
        first: &Point,
        h: f64,
    ) -> Option<Tried<Point, STATES>> {
        if self.is_elastic() || first.command.is_limited() {
            return None;
        }
        let on: [Inputs; LATER] = std::array::from_fn(|k| line.inputs(t + AT[1 + k] * h));
        let end = &on[LATER - 1];
        let filter_time = self.control.filter_time;
        let demand = end.torque_demand - self.parallel.at(end.joint_angle).0;
        let slope = (demand - first.mechanics.demand) / h;
        let apart = first.command.rates[0] - slope;
        // The points are symmetric, so three exponentials give all.
        let [early, middle, late] = [1, 2, 3].map(|k| (-AT[k] * h / filter_time).exp());
        let rate = [early, middle, late, early * late].map(|decay| slope + apart * decay);
        let seen: [(Mechanics, Wanted); LATER] = std::array::from_fn(|k| {
            let u = &on[k];
            let m = self.mechanics(u, [0.0, u.motor_speed], line.initial[0]);
            (m, self.wanted(u, &m, rate[k]))
        });
        let begin = line.inputs(t);
        let sides = self.sides(&first.mechanics, begin.joint_angle);
        let corner = first.command.current[0] != first.command.current[1]
            || seen
                .iter()
                .zip(&on)
                .any(|((m, wanted), u)| wanted.is_limited() || self.sides(m, u.joint_angle) != sides);
        let way = |u: &Inputs, m: &Mechanics, rate: f64| self.way_speed(u, m, rate);
        let ways = [
            way(&begin, &first.mechanics, first.command.rates[0]),
            way(end, &seen[LATER - 1].0, rate[LATER - 1]),
        ];
        if corner
            || turns_round(ways, self.transmission.w_small.min(self.control.w_small))
            || turns_round([begin.motor_speed, end.motor_speed], self.transmission.w_small)
        {
            return None;
        }
        // The first point is known; the others are evaluated.
        let all = |first: f64, f: &dyn Fn(usize) -> f64| -> [f64; POINTS] { [first, f(0), f(1), f(2), f(3)] };
        let winding =
            all(first.command.rates[1], &|k| self.control.winding_up(&seen[k].1, on[k].motor_current));
        let wound = integrals(&winding, h);
        let command: [Command; LATER] = std::array::from_fn(|k| {
            self.control.voltage(&seen[k].1, on[k].motor_current, x[VOLTAGE] + wound[1 + k])
        });
        if command.iter().any(Command::is_limited) {
            return None;
        }
        let mut states = *x;
        let mut errors = [0.0; STATES];
        states[DEMAND] = demand - filter_time * rate[LATER - 1];
        let mut add = |state: usize, f: &dyn Fn(usize) -> f64| {
            let (whole, error) = integral(&all(first.rates[state], f), h);
            states[state] += whole;
            errors[state] = error;
        };
        add(VOLTAGE, &|k| winding[1 + k]);
        add(ENERGY_SHAFT, &|k| seen[k].0.load_torque * on[k].motor_speed);
        add(ENERGY_JOINT, &|k| seen[k].0.joint_torque * on[k].joint_speed);
        add(ENERGY_TRANSMISSION, &|k| seen[k].0.loss);
        add(ENERGY_SUPPLY, &|k| self.powers(&on[k], &command[k])[1]);
        let error = share_of(&errors, &sizes(LIST), x, &states);
        Some(Tried { states, error, point: None })
    }

    /// Side of each kink of the torque, one bit each: zero crossing of demand and spring, where friction reverses; end of the
    /// backlash and full contact; engagement of a parallel spring.
    #[inline(always)]
    fn sides(&self, m: &Mechanics, joint_angle: f64) -> u8 {
        let half = 0.5 * self.transmission.backlash;
        let d = m.deflection;
        u8::from(m.demand > 0.0)
            | u8::from(m.spring.torque > 0.0) << 1
            | u8::from(d > half) << 2
            | u8::from(d < -half) << 3
            | u8::from(d > 2.0 * half) << 4
            | u8::from(d < -2.0 * half) << 5
            | u8::from(self.parallel.is_one_sided() && joint_angle > self.parallel.neutral_angle) << 6
    }

    /// The energy balance: power from the motor shaft, to the joint, into springs and inertia, and dissipated.
    pub fn energy_balance(&self, now: &At<'_>, p: &Point) -> EnergyBalance {
        use Account::{Ambient, Joint, Kinetic, Shaft, Spring};
        let (u, transmission, elastic) = (now.inputs, &self.transmission, self.is_elastic());
        let m = &p.mechanics;
        let ([twist, w, slip], [beside, beside_energy]) = (m.shaft, m.beside);
        let twisting = if elastic { transmission.coupling_stiffness * twist * slip } else { 0.0 };
        let mut ledger = Ledger::default();
        ledger.transfer(Shaft, Kinetic, m.load_torque * u.motor_speed);
        ledger.transfer(Kinetic, Ambient, m.damping + m.friction * w);
        ledger.transfer(Kinetic, Spring, twisting + m.spring.torque * w / m.ratio);
        ledger.transfer(Spring, Ambient, m.spring.loss);
        ledger.transfer(Spring, Joint, m.joint_torque * u.joint_speed);
        // Rates of stored energy from the derivatives of the states.
        let stretching = m.spring.torque * m.rate - m.spring.loss;
        let into_springs = stretching + twisting - beside * u.joint_speed;
        let into_inertia = if elastic { w * (m.load_torque - m.tau_in) } else { 0.0 };
        let coupling_energy = if elastic {
            0.5 * (transmission.coupling_stiffness * twist * twist + transmission.inertia * w * w)
        } else {
            0.0
        };
        EnergyBalance {
            stored: m.spring.energy + beside_energy + coupling_energy,
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
        self.energy_balance(now, &self.at(now)).stored
    }

    /// The outputs.
    pub(super) fn show(&self, now: &At<'_>, p: &Point) -> Outputs {
        let (m, u, x) = (&p.mechanics, now.inputs, now.states);
        Outputs {
            voltage: p.command.voltage[1],
            current_command: p.command.current[1],
            load_torque: m.load_torque,
            joint_torque: m.joint_torque,
            spring_deflection: m.deflection,
            supply_power: p.supply_power,
            torque_error: m.joint_torque - u.torque_demand,
            joint_power: m.joint_torque * u.joint_speed,
            loss_transmission: m.loss,
            loss_drive: p.supply_power - p.motor_power,
            energy_shaft: x[ENERGY_SHAFT],
            energy_joint: x[ENERGY_JOINT],
            energy_transmission: x[ENERGY_TRANSMISSION],
            energy_supply: x[ENERGY_SUPPLY],
        }
    }

    /// The balance residuals.
    pub(super) fn show_balance(&self, now: &At<'_>, p: &Point) -> Balance {
        let (balance, x) = (self.energy_balance(now, p), now.states);
        Balance {
            power_balance_error: balance.error,
            energy_balance_error: x[ENERGY_SHAFT]
                - x[ENERGY_JOINT]
                - x[ENERGY_TRANSMISSION]
                - (balance.stored - now.initial[1]),
        }
    }
}

/// Whether friction at these speeds before and after a step, rad/s, reverses too fast for five points: the argument of the
/// tanh changes by more than 2 outside saturation.
#[inline]
fn turns_round([from, to]: [f64; 2], small: f64) -> bool {
    const SATURATED: f64 = 10.0;
    (from - to).abs() > 2.0 * small && (from * to < 0.0 || from.abs().min(to.abs()) < SATURATED * small)
}
