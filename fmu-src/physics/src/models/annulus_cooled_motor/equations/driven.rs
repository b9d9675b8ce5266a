//! Quantities of the equations of current and speed that follow the drivers of terms, evaluated within a step.

use super::{CORE, Step, Temperatures, WINDING};
use crate::solver::split::Fast;
use crate::terms::{Driver, Drivers};

impl<const FORM: u8> Step<'_, FORM> {
    /// Whether effects at driven ports may act on current and speed.
    #[inline(always)]
    pub(super) fn is_driven(&self) -> bool {
        !Self::PLAIN && self.constants.driven
    }

    /// Drivers of the terms `t` seconds after the start of the step.
    #[inline(always)]
    pub(super) fn drivers(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Drivers {
        if self.is_driven() { self.drivers_at(t, x, temperature) } else { Drivers::default() }
    }

    #[inline(never)]
    fn drivers_at(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Drivers {
        let housing = if self.has_network() { self.coupling.core.at(t) } else { temperature[CORE] };
        let (inputs, slopes, time) = (self.inputs, self.slopes, self.time + t);
        Drivers {
            speed: x[1],
            current: x[0],
            load_torque: match self.is_free() {
                true => self.load.at(t),
                // Without the motor's drag, which may itself be the term that needs this driver.
                false => self.model.motor.torque_constant(housing) * x[0],
            },
            winding_temperature: temperature[WINDING],
            housing_temperature: housing,
            ambient_temperature: inputs.ambient_temperature
                + slopes.ambient_temperature * t
                + self.constants.drift * time,
            fan_command: inputs.fan_command + slopes.fan_command * t,
            time,
            // Only lags follow heat flows.
            copper_loss: 0.0,
            friction_loss: 0.0,
            lagged: self.lags.map(|lag| lag.at(t)),
        }
    }

    /// Factor of the terms on the resistance.
    #[inline(always)]
    pub(super) fn resistance_factor(&self, drivers: &Drivers) -> f64 {
        self.ports().winding_resistance(drivers.current, Driver::Current, drivers)
    }

    /// Resistance at the mean winding temperature `t_w`, Ohm.
    #[inline(always)]
    pub(super) fn resistance(&self, t_w: f64, drivers: &Drivers) -> f64 {
        self.model.motor.resistance(t_w + self.excess) * self.resistance_factor(drivers)
    }

    /// Voltage drop between terminals and winding at the current `i`, V.
    #[inline(always)]
    pub(super) fn lost_voltage(&self, i: f64, drivers: &Drivers) -> f64 {
        let (effects, x) = (self.ports(), drivers.current);
        let driven = effects.driven_voltage(x, Driver::Current, drivers);
        effects.terminal_voltage(i) + driven + effects.series_voltage(x, Driver::Current, drivers)
    }

    /// Torque constant at the temperature of the magnets, N.m/A.
    #[inline(always)]
    pub(super) fn torque_constant(&self, t: f64, temperature: &Temperatures, drivers: &Drivers) -> f64 {
        let factor = self.ports().driven_torque_constant(drivers.current, Driver::Current, drivers);
        self.model.motor.torque_constant(self.magnets(t, temperature)) * self.strength * factor
    }

    /// What the terms add to the Jacobian of current and speed, before it is divided by inductance and inertia; the back-EMF opposes the
    /// source in the ratio `share`.
    #[inline(never)]
    pub(super) fn driven_slopes(
        &self,
        t: f64,
        x: &Fast,
        temperature: &Temperatures,
        drivers: &Drivers,
        share: f64,
    ) -> [Fast; 2] {
        let motor = &self.model.motor;
        // Load torque of an imposed speed: proportional to the current.
        let per_ampere =
            if self.is_free() { 0.0 } else { motor.torque_constant(drivers.housing_temperature) };
        let slopes = self.ports().driven_slopes(drivers, per_ampere);
        let r = motor.resistance(temperature[WINDING] + self.excess);
        let k = motor.torque_constant(self.magnets(t, temperature)) * self.strength;
        let volts =
            slopes.resistance * (x[0] * r) + slopes.voltage + slopes.torque_constant * (k * x[1] * share);
        [volts, slopes.torque_constant * (k * x[0]) - slopes.drag]
    }
}
