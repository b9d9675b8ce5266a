//! A series elastic actuator between a motor and a joint: transmission, springs, torque control, supply.
//!
//! `variables.rs` says what goes in and out, `equations.rs` what holds between them. The declared values are those of
//! an ankle with the motor of preset maxon-305015. Nothing here is stiff, so `explicit.rs` makes a model of it.

mod equations;
mod variables;

pub use equations::{Books, Mechanics, Point};
use variables::LATE;
pub use variables::{Indicators, Inputs, LIST, Outputs};

use crate::components::springs::{ParallelSpring, SeriesSpring};
use crate::components::supply::Supply;
use crate::components::torque_control::TorqueControl;
use crate::components::transmission::Transmission;
use crate::explicit::{Explicit, Law, Line, Now};
use crate::groups;
use crate::model::{Declaration, Declared, Fault, ModelType};
use crate::solver::explicit::Tried;
use declare::State;

/// States of the actuator.
pub const STATES: usize = LIST.len();
/// Numbers that the start fixes: the turn of the transmission's input where the motor shows 0, rad, and the energy that
/// is stored, J.
pub const OPENING: usize = 2;
/// The actuator as a model.
pub type SeriesElasticActuator = Explicit<Actuator, STATES, OPENING>;
/// Inputs and states at one instant.
pub type At<'a> = Now<'a, Inputs, STATES, OPENING>;

/// What the actuator is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuator {
    /// Gear or ball screw.
    pub transmission: Transmission,
    /// The spring in series with it.
    pub spring: SeriesSpring,
    /// The spring beside it.
    pub parallel: ParallelSpring,
    /// Torque and current control.
    pub control: TorqueControl,
    /// The drive as the supply sees it.
    pub drive: Supply,
}

groups! {
    Actuator {
        "transmission." @ 100 => transmission: Transmission,
        "spring." @ 200 => spring: SeriesSpring,
        "parallel." @ 300 => parallel: ParallelSpring,
        "control." @ 400 => control: TorqueControl,
        "drive." @ 500 => drive: Supply,
    }
}

impl Actuator {
    /// The model in the list of models.
    pub const TYPE: ModelType =
        ModelType { declaration: Self::declaration, new: || Box::new(SeriesElasticActuator::default()) };
}

impl Law<STATES, OPENING> for Actuator {
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Indicators = Indicators;
    type Point = Point;
    const LIST: &'static [State] = LIST;
    const LATE: usize = LATE;

    fn declaration() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            Declaration::new(
                "SeriesElasticActuator",
                "Series elastic actuator between a motor and a joint: gear or ball screw with friction and play, series \
                 and parallel spring, torque and current control within the limits of current and supply",
                SeriesElasticActuator::groups(),
                LIST,
            )
        })
    }

    /// The spring carries the torque that is demanded, so that a gait does not begin with a jerk; the motor's speed is
    /// the input shaft's.
    fn start(&self, _time: f64, inputs: &Inputs) -> Result<([f64; STATES], [f64; OPENING]), Fault> {
        let (beside, _) = self.parallel.at(inputs.joint_angle);
        let carried = inputs.torque_demand - beside;
        let deflection = self.spring.deflection_of(carried, self.transmission.backlash);
        let turn = self.transmission.turn(inputs.joint_angle + deflection) - inputs.motor_angle;
        let mut states = [0.0; STATES];
        states[equations::DEMAND] = carried;
        states[equations::INPUT_SPEED] = if self.is_elastic() { inputs.motor_speed } else { 0.0 };
        let opening = [turn, 0.0];
        let now = Now { time: 0.0, inputs, states: &states, opening: &opening };
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

    fn complete(&self, now: &At<'_>, point: &Point, outputs: &mut Outputs) {
        self.show_books(now, point, outputs);
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

    /// A parameter that changes on the way changes what springs and inertia hold; the books start anew from there.
    fn retuned(&self, before: &Self, now: &At<'_>) -> [f64; OPENING] {
        let [turn, stored] = *now.opening;
        [turn, stored + self.stored(now) - before.stored(now)]
    }
}
