//! The state in which the gearmotor starts.

use crate::components::initial::{first_outside, temperature};
use crate::components::validity::Limits;
use crate::solver::split::{Fast, State};
use declare::{Unit, Variable, variables};

variables! {
    /// Initial state.
    pub struct Initial {
        /// Initial temperature of the winding; 0 K = ambient temperature
        winding_temperature: f64 = Variable::fixed(0, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial temperature of the housing, with magnets and gear; 0 K = ambient temperature
        housing_temperature: f64 = Variable::fixed(1, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial temperature of the box, air and walls; 0 K = ambient temperature
        box_temperature: f64 = Variable::fixed(2, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial mean current in the winding
        current: f64 = Variable::fixed(3, 0.0, Unit::Ampere, -1e4, 1e4),
        /// Initial speed of the output shaft
        shaft_speed: f64 = Variable::fixed(4, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(10.0),
        /// Initial angle of the output shaft
        shaft_angle: f64 = Variable::fixed(5, 0.0, Unit::Radian, -1e9, 1e9).nominal(100.0),
    }
}

impl Initial {
    /// What is wrong with initial values outside the limits of validity, in one sentence.
    pub(super) fn fault(&self, limits: &Limits) -> Option<String> {
        let others = [
            ("initial.housing_temperature", self.housing_temperature),
            ("initial.box_temperature", self.box_temperature),
        ];
        first_outside(limits, ("initial.winding_temperature", self.winding_temperature), &others)
    }

    /// The initial state; nodes without an initial value are at `ambient`, K.
    pub(super) fn state<const E: usize>(&self, ambient: f64) -> State<3, E> {
        let nodes = [self.winding_temperature, self.housing_temperature, self.box_temperature];
        State {
            x: Fast::new(self.current, self.shaft_speed),
            angle: self.shaft_angle,
            temperature: nodes.map(|node| temperature(node, ambient)).into(),
            ..State::default()
        }
    }
}
