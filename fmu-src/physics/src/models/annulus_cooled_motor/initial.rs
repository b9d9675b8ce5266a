//! Initial state of the motor.

use crate::components::initial::first_outside;
use crate::components::validity::Limits;
use declare::{Unit, Variable, variables};

variables! {
    /// Initial state.
    pub struct Initial {
        /// Initial temperature of the winding; 0 K = ambient temperature
        winding_temperature: f64 = Variable::initial_temperature(0, &["stator_temperature", "housing_temperature", "magnet_temperature"]),
        /// Initial temperature of the stator; 0 K = ambient temperature; without effect in cooling_mode conductance
        /// unless effect.stator_node is on
        stator_temperature: f64 = Variable::initial_temperature(1, &["housing_temperature", "winding_temperature", "magnet_temperature"]),
        /// Initial temperature of the rotor with its magnets; 0 K = ambient temperature; without effect in cooling_mode
        /// conductance, where it is the housing's
        magnet_temperature: f64 = Variable::initial_temperature(2, &["housing_temperature", "stator_temperature", "winding_temperature"]),
        /// Initial temperature of the housing, of all its segments; 0 K = ambient temperature
        housing_temperature: f64 = Variable::initial_temperature(3, &["stator_temperature", "magnet_temperature", "winding_temperature"]),
        // The node is closer to ambient and air flow than to the motor, so it starts at the ambient temperature.
        /// Initial temperature of the node of the cooling mode (annulus: the tube), where the mode has one; 0 K = ambient temperature
        tube_temperature: f64 = Variable::initial_temperature(4, &[]),
        /// Initial temperature of a lagging housing sensor (effect.housing_sensor_lag); 0 K = initial temperature of the
        /// housing
        sensor_temperature: f64 = Variable::initial_temperature(5, &[]),
        /// Initial temperature of a lagging winding sensor (effect.winding_sensor_lag); 0 K = initial temperature of the
        /// winding
        winding_sensor_temperature: f64 = Variable::initial_temperature(9, &[]),
        /// Initial current (drive_mode voltage and pwm)
        current: f64 = Variable::fixed(6, 0.0, Unit::Ampere, -1e4, 1e4).nominal(5.0),
        /// Initial speed of the shaft (mechanical_mode free_shaft)
        shaft_speed: f64 = Variable::fixed(7, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(1000.0),
        /// Initial angle of the shaft
        shaft_angle: f64 = Variable::fixed(8, 0.0, Unit::Radian, -1e9, 1e9).nominal(100.0),
    }
}

impl Initial {
    /// Initial values outside the limits of validity, in one sentence.
    pub(super) fn fault(&self, limits: &Limits) -> Option<String> {
        let others = [
            ("initial.stator_temperature", self.stator_temperature),
            ("initial.magnet_temperature", self.magnet_temperature),
            ("initial.housing_temperature", self.housing_temperature),
            ("initial.tube_temperature", self.tube_temperature),
            ("initial.sensor_temperature", self.sensor_temperature),
            ("initial.winding_sensor_temperature", self.winding_sensor_temperature),
        ];
        first_outside(limits, ("initial.winding_temperature", self.winding_temperature), &others)
    }
}
