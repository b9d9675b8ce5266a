//! Outputs, and the residual of the energy balance.

use super::nodes::ACCOUNTS;
use super::{State, Step};
use crate::ledger::Account;
use crate::models::brushed_gearmotor::initial_energy::InitialEnergy;
use crate::models::brushed_gearmotor::states::{BOX, HOUSING, NODES, WINDING};
use crate::models::brushed_gearmotor::variables::Outputs;
use crate::solver::split::System;

impl Step<'_> {
    /// Present stored energies; heat is relative to the temperature `origin`, K.
    pub fn initial_energy(&self, state: &State, origin: f64) -> InitialEnergy {
        InitialEnergy {
            stored: self.stored(state, origin),
            magnetic: self.magnetic(state.x[0]),
            kinetic: self.kinetic(state.x[1]),
        }
    }

    /// The outputs at the start of the step.
    pub fn outputs(&self, state: &State, origin: f64, initial_energy: &InitialEnergy) -> Outputs {
        use Account::*;
        let (x, temperature) = (&state.x, &state.temperature);
        let (i, w) = (x[0], x[1]);
        let (t_w, effects) = (temperature[WINDING], &self.model.effects);
        let p = self.point(0.0, x, temperature);
        let capacity = self.capacity();
        let shaft_torque = self.load.at(0.0);
        let outside =
            [(Terminals, -p.supply_power), (AirGap, 0.0), (Shaft, shaft_torque * w), (Ambient, p.to_ambient)];
        let nodes: [_; NODES] = std::array::from_fn(|k| (ACCOUNTS[k], capacity[k] * p.warming[k]));
        let power_balance_error = p.ledger.error(&outside) + p.ledger.error(&nodes);
        let gained = self.initial_energy(state, origin) - *initial_energy;
        let [energy_supply, energy_shaft, energy_heat, work_electrical, friction] = state.energy;
        let work_mechanical = gained.kinetic + energy_shaft + friction;
        let [voltage_electrical, voltage_magnetic, voltage_mechanical] = p.voltages;
        let [power_electrical, power_magnetic, power_mechanical] = p.powers;
        let voltage_total = p.voltages.iter().sum();
        Outputs {
            voltage: voltage_total,
            current: i,
            shaft_angle: state.angle,
            shaft_speed: w,
            shaft_torque: effects.torque_sensor(shaft_torque),
            winding_temperature: effects.winding_sensor(t_w, temperature[BOX]),
            housing_temperature: effects.housing_sensor(temperature[HOUSING], temperature[BOX]),
            box_temperature: temperature[BOX],
            gear_temperature: self.gear_temperature(temperature),
            voltage_electrical,
            voltage_magnetic,
            voltage_mechanical,
            voltage_total,
            power_electrical,
            power_magnetic,
            power_mechanical,
            power_total: p.powers.iter().sum(),
            work_electrical,
            work_magnetic: gained.magnetic,
            work_mechanical,
            work_total: work_electrical + gained.magnetic + work_mechanical,
            power_balance_error,
            energy_balance_error: energy_supply - energy_shaft - energy_heat - gained.stored,
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
            winding_resistance: self.model.motor.resistance(t_w),
            torque_constant: self.torque_constant(temperature),
            conduction: p.cycle.conducting,
            current_rms: (i * i + p.cycle.ripple).sqrt(),
        }
    }
}
