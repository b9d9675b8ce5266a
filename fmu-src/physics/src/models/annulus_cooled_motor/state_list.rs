//! The list of the continuous states, and their places in it.

use super::network::SEGMENTS;
use declare::{Elements, State, Unit, states};

states! {
    /// The states of the motor.
    pub const STATES = {
        /// Current in the winding; constant in drive_mode current and power
        "state.current" = State::new(701, 801, Unit::Ampere).nominal(5.0),
        /// Speed of the shaft; constant in mechanical_mode imposed_speed
        "state.shaft_speed" = State::new(702, 802, Unit::RadianPerSecond).nominal(1000.0),
        /// Angle of the shaft relative to the start
        "state.shaft_angle" = State::new(703, 803, Unit::Radian).nominal(100.0),
        /// Mean temperature of the winding
        "state.winding_temperature" = State::new(704, 804, Unit::Kelvin).nominal(300.0),
        /// Temperature of the node next to the winding: the stator, or the whole motor body in cooling_mode
        /// conductance
        "state.core_temperature" = State::new(705, 805, Unit::Kelvin).nominal(300.0),
        /// Temperature of the rotor; constant in cooling_mode conductance
        "state.rotor_temperature" = State::new(706, 806, Unit::Kelvin).nominal(300.0),
        /// Temperature of the tube; constant without annulus
        "state.tube_temperature" = State::new(707, 807, Unit::Kelvin).nominal(300.0),
        /// Temperature of the housing sensor with lag (effect.housing_sensor_lag); constant otherwise
        "state.sensor_temperature" = State::new(708, 808, Unit::Kelvin).nominal(300.0),
        /// Temperature of each phase minus mean winding temperature; constant in commutation equivalent_dc
        "state.phase_excess" = State::new(710, 810, Unit::Kelvin).difference().elements(Elements::Fixed(3)),
        /// Energy supplied since the start, at the terminals and as heat_power
        "state.energy_electrical" = State::new(714, 814, Unit::Joule).nominal(1000.0),
        /// Mechanical energy into the load since the start
        "state.energy_mechanical" = State::new(715, 815, Unit::Joule).nominal(1000.0),
        /// Heat to ambient since the start, fan power excluded
        "state.energy_heat_to_ambient" = State::new(716, 816, Unit::Joule).nominal(1000.0),
        /// Temperature of each housing segment, from the air inlet on; constant in cooling_mode conductance,
        /// where with effect.stator_node the first one is the whole housing
        "T_housing" = State::new(721, 821, Unit::Kelvin).nominal(300.0)
            .elements(Elements::UpTo(SEGMENTS as u32, "air_segments")).shown(),
    }
}

pub(super) const CURRENT: usize = 0;
pub(super) const SPEED: usize = 1;
pub(super) const ANGLE: usize = 2;
pub(super) const WINDING: usize = 3;
pub(super) const CORE: usize = 4;
pub(super) const ROTOR: usize = 5;
pub(super) const TUBE: usize = 6;
pub(super) const SENSOR: usize = 7;
pub(super) const PHASES: usize = 8;
pub(super) const ENERGIES: usize = 11;
pub(super) const HOUSING: usize = 14;
/// How many states there are, all segments counted.
pub const ALL: usize = HOUSING + SEGMENTS;
/// A number for each state.
pub type All = [f64; ALL];

/// The states that move and that a rate depends on, by index: looking through all of them costs more than a rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Followed {
    pub(super) list: [u8; ALL],
    pub(super) count: usize,
}

impl Default for Followed {
    fn default() -> Followed {
        Followed { list: [0; ALL], count: 0 }
    }
}

impl Followed {
    /// Their places among all states.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        self.list.into_iter().take(self.count).map(usize::from)
    }
}
