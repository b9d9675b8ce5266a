//! The continuous states and their rates at one instant, for those who look at the equations and not at steps.
//!
//! In this order: current, where a voltage drives it; speed, where the shaft is free; winding; what stands beside it
//! (stator or housing); with a network rotor, tube and segments as far as they are there; the reading of a housing
//! sensor that lags. What an input imposes is no state, nor are angle and energies, on which no rate depends.

use super::{AnnulusCooledMotor, DriveMode, MechanicalMode, NODES};
use crate::effects::Effect;
use crate::solver::split::System;

impl AnnulusCooledMotor {
    fn has_current(&self) -> bool {
        matches!(self.parameters.choices.drive_mode, DriveMode::Voltage | DriveMode::Pwm)
    }

    fn has_speed(&self) -> bool {
        self.parameters.choices.mechanical_mode == MechanicalMode::FreeShaft
    }

    fn lags(&self) -> bool {
        self.parameters.effects.housing_sensor_lag() > 0.0
    }

    fn state_count(&self) -> usize {
        let beyond = self.network.as_ref().map_or(0, |n| n.body.nodes().count());
        let beside = [self.has_current(), self.has_speed(), self.lags()];
        NODES + beyond + beside.iter().filter(|there| **there).count()
    }

    pub(super) fn push_states(&self, out: &mut Vec<f64>) {
        if self.has_current() {
            out.push(self.state.x[0]);
        }
        if self.has_speed() {
            out.push(self.state.x[1]);
        }
        out.extend(self.state.temperature.iter());
        if let Some(network) = &self.network {
            out.extend(network.body.nodes().map(|k| network.temperatures()[k]));
        }
        if self.lags() {
            out.push(self.t_sensor);
        }
    }

    pub(super) fn take_states(&mut self, states: &[f64]) -> bool {
        if states.len() != self.state_count() {
            return false;
        }
        let mut next = states.iter().copied();
        let mut take = |place: &mut f64| {
            if let Some(value) = next.next() {
                *place = value;
            }
        };
        if self.has_current() {
            take(&mut self.state.x[0]);
        }
        if self.has_speed() {
            take(&mut self.state.x[1]);
        }
        self.state.temperature.iter_mut().for_each(&mut take);
        if let Some(network) = &mut self.network {
            for k in network.body.nodes() {
                take(&mut network.temperatures_mut()[k]);
            }
        }
        self.t_sensor = self.housing_temperature();
        if self.lags() {
            take(&mut self.t_sensor);
        }
        self.outdate();
        true
    }

    pub(super) fn push_rates(&mut self, out: &mut Vec<f64>) {
        let (x, temperature) = (self.state.x, self.state.temperature);
        let step = self.step_equations();
        let fast = step.fast_rates(0.0, &x, &temperature);
        let warming = step.network_rates(0.0, &temperature)
            + step.heat_rates(0.0, &x, &temperature).component_mul(step.inverse_capacity());
        let friction = step.drag_beyond(&x, &temperature);
        let ambient = step.ambient_at_start();
        if self.has_current() {
            out.push(fast[0]);
        }
        if self.has_speed() {
            out.push(fast[1]);
        }
        out.extend(warming.iter());
        if let Some(network) = &self.network {
            let inflow = network.inflow(temperature[0], temperature[1], friction);
            let rates = network.rates_now(ambient, &inflow);
            out.extend(network.body.nodes().map(|k| rates[k]));
        }
        if self.lags() {
            let tau = self.parameters.effects.housing_sensor_lag();
            out.push((self.housing_temperature() - self.t_sensor) / tau);
        }
    }
}
