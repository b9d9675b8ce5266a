//! Quantities of the equations of current and speed that follow the drivers of terms, evaluated within a step.

use super::Step;
use crate::effects::Ports;
use crate::models::brushed_gearmotor::nodes::{HOUSING, Temperatures, WINDING};
use crate::solver::split::Fast;
use crate::terms::{Driver, Drivers};

/// What follows the drivers at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// Resistance, Ohm.
    pub r: f64,
    /// Torque constant at the output shaft, N.m/A.
    pub k: f64,
    /// Voltage drop between terminals and winding, V.
    pub lost: f64,
    /// Drag torque of terms, N.m.
    pub drag: f64,
}

impl Step<'_> {
    #[inline]
    pub(super) fn ports(&self) -> Ports<'_> {
        Ports { effects: &self.model.effects, acts: self.constants.acts }
    }

    /// Drivers of the terms `t` seconds after the start of the step.
    pub(super) fn drivers(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Drivers {
        Drivers {
            speed: x[1],
            current: x[0],
            load_torque: self.load.at(t),
            winding_temperature: temperature[WINDING],
            housing_temperature: temperature[HOUSING],
            ambient_temperature: self.ambient.at(t),
            time: self.time + t,
            lagged: self.lags.map(|lag| lag.at(t)),
            ..Drivers::default()
        }
    }

    /// Torque constant at the output shaft without terms, N.m/A; the magnets have the temperature of the housing.
    #[inline]
    fn own_torque_constant(&self, temperature: &Temperatures) -> f64 {
        self.model.motor.torque_constant(temperature[HOUSING]) * self.strength * self.model.gear.ratio
    }

    /// What follows the drivers.
    #[inline]
    pub(super) fn followed(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Followed {
        let (i, motor, ports) = (x[0], &self.model.motor, self.ports());
        let own = Followed {
            r: motor.resistance(temperature[WINDING]),
            k: self.own_torque_constant(temperature),
            lost: ports.effects.terminal_voltage(i),
            drag: 0.0,
        };
        if !self.constants.driven {
            return own;
        }
        let drivers = self.drivers(t, x, temperature);
        Followed {
            r: own.r * ports.winding_resistance(i, Driver::Current, &drivers),
            k: own.k * ports.driven_torque_constant(i, Driver::Current, &drivers),
            lost: own.lost
                + ports.driven_voltage(i, Driver::Current, &drivers)
                + ports.series_voltage(i, Driver::Current, &drivers),
            drag: ports.driven_drag(x[1], Driver::Speed, &drivers),
        }
    }

    /// Derivatives by the terms with respect to current and speed: of the resistance, of the voltage that opposes the bridge, and of the torque.
    #[inline(never)]
    pub(super) fn driven_slopes(&self, t: f64, x: &Fast, temperature: &Temperatures) -> [Fast; 3] {
        let slopes = self.ports().driven_slopes(&self.drivers(t, x, temperature), 0.0);
        let k = slopes.torque_constant * self.own_torque_constant(temperature);
        let r = self.model.motor.resistance(temperature[WINDING]);
        [slopes.resistance * r, k * x[1] + slopes.voltage, k * x[0] - slopes.drag]
    }
}
