//! Outputs, and the residual of the energy balance.

use super::{State, Step, Stored};
use crate::ledger::Account;
use crate::models::brushed_gearmotor::nodes::{NODES, WINDING};
use crate::models::brushed_gearmotor::variables::Outputs;
use crate::solver::split::System;

impl Step<'_> {
    /// Present stored energies; heat is relative to the temperature `origin`, K.
    pub fn stored_energies(&self, state: &State, origin: f64) -> Stored {
        Stored::new(self.stored(state, origin), self.magnetic(state.x[0]), self.kinetic(state.x[1]))
    }

    /// Copper loss and friction loss, W.
    pub fn heat_flows(&self, state: &State) -> [f64; 2] {
        let p = self.point(0.0, &state.x, &state.temperature);
        [p.powers[0], p.drag * state.x[1]]
    }

    /// The outputs at the start of the step.
    pub fn outputs(&self, state: &State, origin: f64, at_start: &Stored) -> Outputs {
        use Account::*;
        let (x, temperature) = (&state.x, &state.temperature);
        let (i, w) = (x[0], x[1]);
        let t_w = temperature[WINDING];
        let p = self.point(0.0, x, temperature);
        let capacity = self.capacity().values;
        let shaft_torque = self.load.at(0.0);
        let outside =
            [(Terminals, -p.supply_power), (AirGap, 0.0), (Shaft, shaft_torque * w), (Ambient, p.to_ambient)];
        let nodes: [_; NODES] = std::array::from_fn(|k| (Node(k), capacity[k] * p.warming[k]));
        let power_balance_error = p.ledger.error(&outside) + p.ledger.error(&nodes);
        let gained = self.stored_energies(state, origin) - at_start;
        let (work_magnetic, nodes) = (gained[1], self.nodes());
        let [energy_supply, energy_shaft, energy_heat, work_electrical, friction] = state.energy;
        let work_mechanical = gained[2] + energy_shaft + friction;
        let [voltage_electrical, voltage_magnetic, voltage_mechanical] = p.voltages;
        let [power_electrical, power_magnetic, power_mechanical] = p.powers;
        let voltage_total = p.voltages.iter().sum();
        Outputs {
            voltage: voltage_total,
            current: i,
            shaft_angle: state.angle,
            shaft_speed: w,
            shaft_torque: self.model.effects.torque_sensor(shaft_torque),
            voltage_electrical,
            voltage_magnetic,
            voltage_mechanical,
            voltage_total,
            power_electrical,
            power_magnetic,
            power_mechanical,
            power_total: p.powers.iter().sum(),
            work_electrical,
            work_magnetic,
            work_mechanical,
            work_total: work_electrical + work_magnetic + work_mechanical,
            power_balance_error,
            energy_balance_error: energy_supply - energy_shaft - energy_heat - gained[0],
            supply_power: p.supply_power,
            shaft_power: shaft_torque * w,
            loss_copper: power_electrical,
            loss_friction: p.drag * w,
            loss_drive: p.loss_drive,
            heat_to_ambient: p.to_ambient,
            energy_supply,
            energy_shaft,
            energy_heat_to_ambient: energy_heat,
            winding_margin: self.model.thermal.T_w_max - t_w,
            over_temperature: t_w > self.model.thermal.T_w_max,
            winding_resistance: p.constants[0],
            torque_constant: p.constants[1],
            conduction: p.cycle.conducting,
            current_rms: (i * i + p.cycle.ripple).sqrt(),
            ..Outputs::of_nodes(std::array::from_fn(|node| nodes.indicated(node, temperature)))
        }
    }
}
