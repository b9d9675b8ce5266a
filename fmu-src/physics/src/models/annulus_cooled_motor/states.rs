//! The continuous states: values, and which of them are in use; `reading.rs` has their derivatives.
//!
//! The list in `state_list.rs` is the same in every mode. A state that a mode does not use is constant: current or speed
//! if an input imposes it, absent network nodes, a sensor without lag, phases that share the current evenly.

use super::motor::AnnulusCooledMotor;
use super::state_list::{
    ANGLE, All, CORE, CURRENT, ENERGIES, HOUSING, HOUSING_SENSOR, LAGS, PHASES, ROTOR, SPEED, TUBE, WINDING,
    WINDING_SENSOR,
};
use super::variables::{DriveMode, MechanicalMode};
use crate::components::commutation::Commutation;
use crate::effects::PerNode;

impl AnnulusCooledMotor {
    /// Temperature of the node that each sensor is on, winding and housing, K.
    pub(super) fn sensed(&self) -> PerNode {
        PerNode { winding: self.own.state.temperature[0], housing: self.housing_temperature() }
    }

    /// Index of a state among the temperatures of the network ([`Network::temperatures`](super::network::Network::temperatures)).
    fn node(k: usize) -> usize {
        match k {
            ROTOR => 0,
            TUBE => 1,
            _ => 2 + k - HOUSING,
        }
    }

    /// Whether a state is in use in the present modes.
    pub(super) fn moves(&self, k: usize) -> bool {
        let choices = &self.parameters.choices;
        match k {
            CURRENT => matches!(choices.drive_mode, DriveMode::Voltage | DriveMode::Pwm),
            SPEED => choices.mechanical_mode == MechanicalMode::FreeShaft,
            WINDING_SENSOR => self.parameters.effects.sensor_lag().winding > 0.0,
            HOUSING_SENSOR => self.parameters.effects.sensor_lag().housing > 0.0,
            LAGS..HOUSING => self.has_lag(k - LAGS),
            PHASES..ENERGIES => choices.commutation != Commutation::EquivalentDc,
            ROTOR | TUBE | HOUSING.. => {
                self.own.network.as_ref().is_some_and(|n| n.body.holds(Self::node(k)))
            }
            _ => true,
        }
    }

    /// Value of a state; the start value if it is not in use.
    pub(super) fn state_value(&self, k: usize) -> f64 {
        if !self.moves(k) {
            let is_zero = matches!(k, CURRENT | SPEED | PHASES..ENERGIES | LAGS..HOUSING);
            return if is_zero { 0.0 } else { self.own.t_start };
        }
        match k {
            CURRENT | SPEED => self.own.state.x[k],
            ANGLE => self.own.state.angle,
            WINDING | CORE => self.own.state.temperature[k - WINDING],
            WINDING_SENSOR => self.own.sensors.winding,
            HOUSING_SENSOR => self.own.sensors.housing,
            PHASES..ENERGIES => self.own.phases.above[k - PHASES],
            ENERGIES..LAGS => self.own.state.energy[k - ENERGIES],
            LAGS..HOUSING => self.lag_state(k - LAGS),
            _ => self.own.network.as_ref().map_or(self.own.t_start, |n| n.temperatures()[Self::node(k)]),
        }
    }

    /// Sets a state that is in use.
    pub(super) fn put_state(&mut self, k: usize, value: f64) {
        match k {
            CURRENT | SPEED => self.own.state.x[k] = value,
            ANGLE => self.own.state.angle = value,
            WINDING | CORE => self.own.state.temperature[k - WINDING] = value,
            WINDING_SENSOR => self.own.sensors.winding = value,
            HOUSING_SENSOR => self.own.sensors.housing = value,
            PHASES..ENERGIES => self.own.phases.above[k - PHASES] = value,
            ENERGIES..LAGS => self.own.state.energy[k - ENERGIES] = value,
            LAGS..HOUSING => self.put_lag_state(k - LAGS, value),
            _ => {
                if let Some(network) = &mut self.own.network {
                    network.temperatures_mut()[Self::node(k)] = value;
                }
            }
        }
    }

    /// Rate of change of the hottest phase's temperature, K/s.
    pub(super) fn warming(&self, rates: &All) -> f64 {
        let hottest = (0..self.own.phases.above.len())
            .max_by(|&a, &b| self.own.phases.above[a].total_cmp(&self.own.phases.above[b]));
        rates[WINDING] + hottest.map_or(0.0, |k| rates[PHASES + k])
    }
}
