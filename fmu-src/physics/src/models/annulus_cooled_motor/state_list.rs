//! List of the continuous states, and their indices.

use crate::components::housing::SEGMENTS;
use declare::{Elements, State, Unit, index_of, states};

// Nominal derivatives, with the default motor at 24 V and 5 A: 24 V / L for the current, k_t 5 A / J for the speed, R (5 A)^2 over the
// heat capacity for temperatures, and powers for the energies.
states! {
    /// The states of the motor.
    pub const STATES = {
        /// Current in the winding; constant where it is imposed or zero (drive_mode current, power)
        "state.current" = State::new(701, 801, Unit::Ampere).nominal(5.0, 4e5),
        /// Speed of the shaft; constant where it is imposed (mechanical_mode imposed_speed)
        "state.shaft_speed" = State::new(702, 802, Unit::RadianPerSecond).nominal(1000.0, 4e4),
        /// Angle of the shaft, initial.shaft_angle at the start
        "state.shaft_angle" = State::new(703, 803, Unit::Radian).unbounded().nominal(100.0, 1000.0),
        /// Mean temperature of the winding
        "state.winding_temperature" = State::new(704, 804, Unit::Kelvin).nominal(300.0, 1.0),
        /// Temperature of the stator, or of the whole housing where it has no segments
        "state.core_temperature" = State::new(705, 805, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of the rotor; constant in cooling_mode conductance
        "state.rotor_temperature" = State::new(706, 806, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of the node of the cooling mode (annulus: the tube); constant in modes without one
        "state.tube_temperature" = State::new(707, 807, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of a lagging housing sensor (effect.housing_sensor_lag); else constant
        "state.sensor_temperature" = State::new(708, 808, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of a lagging winding sensor (effect.winding_sensor_lag); else constant
        "state.winding_sensor_temperature" = State::new(709, 809, Unit::Kelvin).nominal(300.0, 1.0),
        /// Excess of each phase over the mean winding temperature; constant in commutation equivalent_dc
        "state.phase_excess" = State::new(710, 810, Unit::Kelvin).difference().elements(Elements::Fixed(3)),
        /// Energy supplied since the start: at the terminals, and as heat_power
        "state.energy_electrical" = State::new(714, 814, Unit::Joule).unbounded().nominal(1000.0, 100.0),
        /// Mechanical energy to the load since the start
        "state.energy_mechanical" = State::new(715, 815, Unit::Joule).unbounded().nominal(1000.0, 100.0),
        /// Heat to ambient and coolant since the start, fan power excluded
        "state.energy_heat_to_ambient" = State::new(716, 816, Unit::Joule).unbounded().nominal(1000.0, 10.0),
        /// Lagged driver of each term of resources/effects.json, divided by a typical value of the driver; constant without a lag
        "state.term_lag" = State::new(717, 817, Unit::One).elements(Elements::Fixed(3)),
        /// Temperature of each segment of the housing, from the air inlet on; constant in cooling_mode
        /// conductance, except the first with effect.stator_node, which is then the whole housing
        "T_housing" = State::new(721, 821, Unit::Kelvin).nominal(300.0, 0.1)
            .elements(Elements::UpTo(SEGMENTS as u32, "air_segments")).shown(),
    }
}

pub(super) const CURRENT: usize = index_of(STATES, "state.current");
pub(super) const SPEED: usize = index_of(STATES, "state.shaft_speed");
pub(super) const ANGLE: usize = index_of(STATES, "state.shaft_angle");
pub(super) const WINDING: usize = index_of(STATES, "state.winding_temperature");
pub(super) const CORE: usize = index_of(STATES, "state.core_temperature");
pub(super) const ROTOR: usize = index_of(STATES, "state.rotor_temperature");
pub(super) const TUBE: usize = index_of(STATES, "state.tube_temperature");
pub(super) const HOUSING_SENSOR: usize = index_of(STATES, "state.sensor_temperature");
pub(super) const WINDING_SENSOR: usize = index_of(STATES, "state.winding_sensor_temperature");
pub(super) const PHASES: usize = index_of(STATES, "state.phase_excess");
pub(super) const ENERGIES: usize = index_of(STATES, "state.energy_electrical");
pub(super) const LAGS: usize = index_of(STATES, "state.term_lag");
pub(super) const HOUSING: usize = index_of(STATES, "T_housing");
/// Number of states, including all segments.
pub const ALL: usize = HOUSING + SEGMENTS;
/// A number for each state.
pub type All = [f64; ALL];

/// Whether the derivative of another state depends on this one: not for angle and energies, nor for phase temperatures, which change
/// with the angle.
pub(super) fn is_coupled(k: usize) -> bool {
    k != ANGLE && !(PHASES..LAGS).contains(&k)
}
