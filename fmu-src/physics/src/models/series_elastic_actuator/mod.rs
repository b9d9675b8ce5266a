//! A series elastic actuator between a motor and a joint: transmission, springs, torque control, supply.
//!
//! `variables.rs` declares inputs, outputs and states, `equations.rs` has the equations. The default values are those of an
//! ankle prosthesis with the default motor; [`MOTOR_DATA`] derives the motor data of the control from any other preset. The
//! equations are not stiff, so `explicit.rs` integrates them.

mod equations;
mod variables;

pub use equations::{EnergyBalance, Mechanics, Point};
pub use variables::{Balance, Indicators, Inputs, LIST, Outputs};

use crate::components::springs::{ParallelSpring, SeriesSpring};
use crate::components::supply::Supply;
use crate::components::torque_control::TorqueControl;
use crate::components::transmission::Transmission;
use crate::explicit::{Explicit, Law, Line, Now};
use crate::groups;
use crate::model::{Declaration, Declared, Fault};
use crate::runtime::Runtime;
use crate::solver::explicit::Tried;
use declare::State;

/// Start values of the actuator from its motor: parameter or input of the actuator, variable of the motor. Every tool that
/// combines the actuator with a motor preset derives these start values; explicitly set values have priority.
pub const MOTOR_DATA: [(&str, &str); 5] = [
    ("control.k_t", "motor.k_t"),
    ("control.R", "motor.R_ref"),
    ("control.J", "motor.J"),
    ("control.tau_c", "effect.coulomb_friction.tau_c"),
    // Only for motor presets with a nominal voltage; the default 0 does not change the supply voltage.
    ("supply_voltage", "voltage"),
];

/// Number of states.
pub const STATES: usize = LIST.len();
/// Number of constants from the start: angle of the transmission's input at motor angle 0, rad, and stored energy, J.
pub const OPENING: usize = 2;
/// The actuator as a model.
pub type SeriesElasticActuator = Runtime<Explicit<Actuator, STATES, OPENING>, STATES>;
/// Inputs and states at one instant.
pub type At<'a> = Now<'a, Inputs, STATES, OPENING>;

groups! {
    /// Components of the actuator.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Actuator {
        /// Gear or ball screw.
        transmission: Transmission = "transmission." @ 100,
        /// Spring in series with the transmission.
        spring: SeriesSpring = "spring." @ 200,
        /// Spring parallel to transmission and series spring.
        parallel: ParallelSpring = "parallel." @ 300,
        /// Torque and current control.
        control: TorqueControl = "control." @ 400,
        /// Drive and its supply.
        drive: Supply = "drive." @ 500,
    }
}

impl Law<STATES, OPENING> for Actuator {
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Balance = Balance;
    type Indicators = Indicators;
    type Point = Point;
    const LIST: &'static [State] = LIST;

    fn declaration() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            SeriesElasticActuator::declare(
                "SeriesElasticActuator",
                "Series elastic actuator between a motor and a joint: gear or ball screw with friction and backlash, series \
                 and parallel spring, torque and current control within the limits of current and supply",
                &[],
            )
        })
    }

    /// The spring starts with the demanded torque, so that a gait starts without a transient; the input shaft starts at the motor
    /// speed.
    fn start(&self, _time: f64, inputs: &Inputs) -> Result<([f64; STATES], [f64; OPENING]), Fault> {
        let (beside, _) = self.parallel.at(inputs.joint_angle);
        let carried = inputs.torque_demand - beside;
        let deflection = self.spring.deflection_of(carried, self.transmission.backlash);
        let turn = self.transmission.turn(inputs.joint_angle + deflection) - inputs.motor_angle;
        let mut states = [0.0; STATES];
        states[equations::DEMAND] = carried;
        states[equations::INPUT_SPEED] = if self.is_elastic() { inputs.motor_speed } else { 0.0 };
        let initial = [turn, 0.0];
        let now = Now { time: 0.0, inputs, states: &states, initial: &initial };
        let stored = self.stored(&now);
        Ok((states, [turn, stored]))
    }

    fn point(&self, now: &At<'_>) -> Point {
        self.at(now)
    }

    fn rates(point: &Point) -> [f64; STATES] {
        point.rates
    }

    fn outputs(&self, now: &At<'_>, point: &Point) -> Outputs {
        self.show(now, point)
    }

    fn balance(&self, now: &At<'_>, point: &Point) -> Balance {
        self.show_balance(now, point)
    }

    #[inline]
    fn one(
        &self,
        line: &Line<'_, Inputs, OPENING>,
        t: f64,
        x: &[f64; STATES],
        first: Option<&Point>,
        h: f64,
    ) -> Tried<Point, STATES> {
        let here;
        let first = match first {
            Some(first) => first,
            None => {
                here = self.at_line(line, t, x);
                &here
            }
        };
        self.along(line, t, x, first, h).unwrap_or_else(|| self.general(line, t, x, Some(first), h))
    }

    fn indicators(&self, _: &At<'_>, p: &Point) -> Indicators {
        let (wanted, [least, most]) = (p.command.current[0], p.command.limits);
        let half = 0.5 * self.transmission.backlash;
        Indicators {
            current_above: wanted - most,
            current_below: wanted - least,
            contact_above: p.mechanics.deflection - half,
            contact_below: p.mechanics.deflection + half,
        }
    }

    /// The energy balance excludes the change of stored energy by a tunable parameter.
    fn retuned(&self, before: &Self, now: &At<'_>) -> [f64; OPENING] {
        let [turn, stored] = *now.initial;
        [turn, stored + self.stored(now) - before.stored(now)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::by_name;

    /// The default motor data of the control are those of the default motor.
    #[test]
    fn the_declared_motor_data_are_the_motors() {
        let motor = (by_name("AnnulusCooledMotor").unwrap().declaration)();
        for (own, of_motor) in MOTOR_DATA {
            let value = motor.by_name(of_motor).unwrap().row.start;
            let own = Actuator::declaration().by_name(own).unwrap();
            assert!(
                own.row.start == value || of_motor == "voltage",
                "{} {} {value}",
                own.name,
                own.row.start
            );
        }
    }
}
