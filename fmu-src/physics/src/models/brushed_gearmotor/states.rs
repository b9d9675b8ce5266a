//! The states of the gearmotor: thermal nodes, list of the continuous states, initial values.

use crate::components::initial::{first_outside, temperature};
use crate::components::validity::Limits;
use crate::solver::split::{self, Fast};
use declare::{Unit, Variable, states, variables};
use nalgebra::SVector;

/// Thermal nodes: winding, housing, box and gear.
pub const NODES: usize = 4;
pub(super) const WINDING: usize = 0;
pub(super) const HOUSING: usize = 1;
pub(super) const BOX: usize = 2;
pub(super) const GEAR: usize = 3;
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;
// Nominal derivatives, with the default motor at 12 V and 1 A: 12 V / L for the current, torque of 1 A over the rotor inertia at the
// output shaft for its speed, R (1 A)^2 over the heat capacity for temperatures, and powers for the energies.
states! {
    /// The states of the gearmotor, in the order of `Step::rates`.
    pub const LIST = {
        /// Mean current in the winding
        "state.current" = declare::State::new(701, 801, Unit::Ampere).nominal(1.0, 7e3),
        /// Speed of the output shaft
        "state.shaft_speed" = declare::State::new(702, 802, Unit::RadianPerSecond).nominal(10.0, 10.0),
        /// Angle of the output shaft, initial.shaft_angle at the start
        "state.shaft_angle" = declare::State::new(703, 803, Unit::Radian).unbounded().nominal(100.0, 10.0),
        /// Temperature of the winding
        "state.winding_temperature" = declare::State::new(704, 804, Unit::Kelvin).nominal(300.0, 1.0),
        /// Temperature of the housing, with magnets, and with the gear without thermal.C_g
        "state.housing_temperature" = declare::State::new(705, 805, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of the box, air and walls
        "state.box_temperature" = declare::State::new(706, 806, Unit::Kelvin).nominal(300.0, 0.1),
        /// Temperature of the gear; constant without thermal.C_g
        "state.gear_temperature" = declare::State::new(712, 812, Unit::Kelvin).nominal(300.0, 0.1),
        /// Energy from the supply since the start
        "state.energy_supply" = declare::State::new(707, 807, Unit::Joule).unbounded().nominal(1000.0, 10.0),
        /// Mechanical energy to the load since the start
        "state.energy_shaft" = declare::State::new(708, 808, Unit::Joule).unbounded().nominal(1000.0, 10.0),
        /// Heat to ambient since the start
        "state.energy_heat_to_ambient" = declare::State::new(709, 809, Unit::Joule).unbounded().nominal(1000.0, 10.0),
        /// Electrical losses in the winding since the start
        "state.work_electrical" = declare::State::new(710, 810, Unit::Joule).unbounded().nominal(100.0, 10.0),
        /// Friction losses since the start
        "state.work_friction" = declare::State::new(711, 811, Unit::Joule).unbounded().nominal(100.0, 1.0),
    }
}

variables! {
    /// Initial state.
    pub struct Initial {
        /// Initial temperature of the winding; 0 K = ambient temperature
        winding_temperature: f64 = Variable::fixed(0, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial temperature of the housing, with magnets, and with the gear without thermal.C_g; 0 K = ambient temperature
        housing_temperature: f64 = Variable::fixed(1, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial temperature of the box, air and walls; 0 K = ambient temperature
        box_temperature: f64 = Variable::fixed(2, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
        /// Initial mean current in the winding
        current: f64 = Variable::fixed(3, 0.0, Unit::Ampere, -1e4, 1e4),
        /// Initial speed of the output shaft
        shaft_speed: f64 = Variable::fixed(4, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(10.0),
        /// Initial angle of the output shaft
        shaft_angle: f64 = Variable::fixed(5, 0.0, Unit::Radian, -1e9, 1e9).nominal(100.0),
        /// Initial temperature of the gear (not without thermal.C_g); 0 K = ambient temperature
        gear_temperature: f64 = Variable::fixed(6, 0.0, Unit::Kelvin, 0.0, 1273.15).nominal(300.0),
    }
}

impl Initial {
    /// Temperatures of the nodes with their names, K; the winding is first.
    fn nodes(&self) -> [(&'static str, f64); NODES] {
        [
            ("initial.winding_temperature", self.winding_temperature),
            ("initial.housing_temperature", self.housing_temperature),
            ("initial.box_temperature", self.box_temperature),
            ("initial.gear_temperature", self.gear_temperature),
        ]
    }

    /// Initial values outside the limits of validity, in one sentence.
    pub(super) fn fault(&self, limits: &Limits) -> Option<String> {
        let [winding, others @ ..] = self.nodes();
        first_outside(limits, winding, &others)
    }

    /// The initial state; nodes without an initial value start at `ambient`, K.
    pub(super) fn state<const E: usize>(&self, ambient: f64) -> split::State<NODES, E> {
        split::State {
            x: Fast::new(self.current, self.shaft_speed),
            angle: self.shaft_angle,
            temperature: self.nodes().map(|(_, node)| temperature(node, ambient)).into(),
            ..split::State::default()
        }
    }
}
