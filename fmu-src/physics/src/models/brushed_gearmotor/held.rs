//! The list of the continuous states, and what is kept between events for a caller who integrates.

use super::equations::Step;
use declare::{Unit, states};

states! {
    /// The states of the gearmotor, in the order of [`Step::rates`].
    pub const LIST = {
        /// Mean current in the winding
        "state.current" = declare::State::new(701, 801, Unit::Ampere),
        /// Speed of the output shaft
        "state.shaft_speed" = declare::State::new(702, 802, Unit::RadianPerSecond).nominal(10.0),
        /// Angle of the output shaft, initial.shaft_angle at the start
        "state.shaft_angle" = declare::State::new(703, 803, Unit::Radian).unbounded().nominal(100.0),
        /// Temperature of the winding
        "state.winding_temperature" = declare::State::new(704, 804, Unit::Kelvin).nominal(300.0),
        /// Temperature of the housing, with magnets and gear
        "state.housing_temperature" = declare::State::new(705, 805, Unit::Kelvin).nominal(300.0),
        /// Temperature of the box, air and walls
        "state.box_temperature" = declare::State::new(706, 806, Unit::Kelvin).nominal(300.0),
        /// Energy from the supply since the start
        "state.energy_supply" = declare::State::new(707, 807, Unit::Joule).unbounded().nominal(1000.0),
        /// Mechanical energy to the load since the start
        "state.energy_shaft" = declare::State::new(708, 808, Unit::Joule).unbounded().nominal(1000.0),
        /// Heat to ambient since the start
        "state.energy_heat_to_ambient" = declare::State::new(709, 809, Unit::Joule).unbounded().nominal(1000.0),
        /// Electrical losses in the winding since the start
        "state.work_electrical" = declare::State::new(710, 810, Unit::Joule).unbounded().nominal(100.0),
        /// Friction losses since the start
        "state.work_friction" = declare::State::new(711, 811, Unit::Joule).unbounded().nominal(100.0),
    }
}

/// What is held between events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Time of the last event, s.
    pub(super) since: f64,
    /// Sign of the duty at the last event.
    pub(super) direction: f64,
    /// Whether the winding was above its limit at the last event.
    pub over_temperature: bool,
}

impl Held {
    pub const NONE: Held = Held { since: 0.0, direction: 0.0, over_temperature: false };

    /// What a saved instance must hold.
    pub fn to_numbers(self) -> [f64; 3] {
        [self.since, self.direction, f64::from(u8::from(self.over_temperature))]
    }

    /// Takes back what [`to_numbers`](Held::to_numbers) gave.
    pub fn from_numbers([since, direction, over]: [f64; 3]) -> Held {
        Held { since, direction, over_temperature: over != 0.0 }
    }

    /// The equations with the bridge and the magnets as the last event has left them. A duty that has just left
    /// zero has the direction in which it left.
    pub fn applied<'a>(&self, step: Step<'a>, duty: f64) -> Step<'a> {
        let direction = if self.direction == 0.0 && duty != 0.0 { duty.signum() } else { self.direction };
        step.with_events(direction, self.since)
    }
}
