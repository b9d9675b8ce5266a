//! What the model shows of its state, and the check of the books.

use super::{HOUSING, NODES, Step, WINDING};
use crate::effects::Effect;
use crate::ledger::Account;
use crate::models::annulus_cooled_motor::{DriveMode, Outputs};
use crate::solver::split::{State, System};

impl Step<'_> {
    /// The outputs at the start of the step; `t_sensor` is the temperature that the housing's sensor has reached.
    pub fn outputs(&self, state: &State<NODES>, t_sensor: f64, stored_at_start: f64) -> Outputs {
        use Account::*;
        let model = self.model;
        let (x, temperature) = (&state.x, &state.temperature);
        let (i, w) = (x[0], x[1]);
        let (t_w, t_h) = (temperature[WINDING], temperature[HOUSING]);
        let t_a = self.ambient.at(0.0);
        let p = self.point(0.0, x, temperature);
        let capacity = self.capacity();
        let power_balance_error = p.ledger.error(&[
            (Terminals, -self.power_in(0.0, &p, x)),
            (AirGap, 0.0),
            (Shaft, p.shaft_torque * w),
            (Winding, capacity[WINDING] * p.warming[WINDING]),
            (Housing, capacity[HOUSING] * p.warming[HOUSING]),
            (Ambient, p.to_ambient),
        ]);
        let [energy_in, energy_out, energy_heat] = state.energy;
        let r = self.resistance(t_w);
        let copper = r * i * i + model.effects.terminal_voltage(i) * i;
        let (electrical, copper) = match model.choices.drive_mode {
            DriveMode::Power => {
                let power = self.inputs.electrical_power;
                (power, copper + power - self.drive_loss())
            }
            _ => (p.voltage * i, copper),
        };
        Outputs {
            current: i,
            shaft_angle: state.angle,
            shaft_speed: w,
            shaft_torque: p.shaft_torque,
            winding_temperature: model.effects.winding_sensor(t_w, t_a),
            stator_temperature: t_h,
            magnet_temperature: t_h,
            housing_temperature: model.effects.housing_sensor(t_sensor, t_a),
            winding_resistance: r,
            torque_constant: self.torque_constant(temperature),
            power_electrical: electrical,
            power_mechanical: p.shaft_torque * w,
            loss_copper: copper,
            loss_iron: model.effects.iron_drag(w) * w,
            loss_friction: p.drag * w,
            loss_drive: self.drive_loss(),
            heat_to_ambient: p.to_ambient,
            power_balance_error,
            winding_margin: model.thermal.T_w_max - t_w,
            over_temperature: t_w > model.thermal.T_w_max,
            torque_density: p.shaft_torque / model.motor.mass,
            terminal_voltage: p.voltage,
            energy_electrical: energy_in,
            energy_mechanical: energy_out,
            energy_heat_to_ambient: energy_heat,
            energy_balance_error: energy_in
                - energy_out
                - energy_heat
                - (self.stored(state) - stored_at_start),
        }
    }
}
