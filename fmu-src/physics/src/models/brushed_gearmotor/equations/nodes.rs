//! The states of the gearmotor and its thermal network: nodes, heat paths, initial values.
//!
//! A further node is declared here: an index, its capacity, its heat paths ([`PATHS`], `flows`, `flow_slopes`), the heat that is set
//! free in it (`heats`), its account, its state and its initial value. Integrator, energy balance, saved states and Model Exchange follow.

use super::Step;
use crate::components::initial::{first_outside, temperature};
use crate::components::validity::Limits;
use crate::ledger::Account;
use crate::models::brushed_gearmotor::parameters::Parameters;
use crate::solver::split::{self, Fast};
use declare::{Unit, Variable, states, variables};
use nalgebra::SVector;

/// Thermal nodes: winding, housing, box and gear.
pub const NODES: usize = 4;
pub(super) const WINDING: usize = 0;
pub(super) const HOUSING: usize = 1;
pub(super) const BOX: usize = 2;
const GEAR: usize = 3;
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;
/// Accounts of the nodes in the energy balance.
pub(super) const ACCOUNTS: [Account; NODES] =
    [Account::Winding, Account::Housing, Account::Enclosure, Account::Gear];

/// Heat paths, each from a node to another one, or to ambient.
pub(super) const PATHS: [(usize, Option<usize>); 5] = [
    (WINDING, Some(HOUSING)),
    (WINDING, Some(BOX)),
    (HOUSING, Some(BOX)),
    (BOX, None),
    (GEAR, Some(HOUSING)),
];

states! {
    /// The states of the gearmotor, in the order of [`Step::rates`].
    pub const LIST = {
        /// Mean current in the winding
        "state.current" = declare::State::new(701, 801, Unit::Ampere),
        /// Speed of the output shaft
        "state.shaft_speed" = declare::State::new(702, 802, Unit::RadianPerSecond).nominal(10.0),
        /// Angle of the output shaft, initial.shaft_angle at the start
        "state.shaft_angle" = declare::State::new(703, 803, Unit::Radian).unbounded().nominal(100.0),
        /// Temperature of the winding
        "state.winding_temperature" = declare::State::new(704, 804, Unit::Kelvin).nominal(300.0),
        /// Temperature of the housing, with magnets, and with the gear without thermal.C_g
        "state.housing_temperature" = declare::State::new(705, 805, Unit::Kelvin).nominal(300.0),
        /// Temperature of the box, air and walls
        "state.box_temperature" = declare::State::new(706, 806, Unit::Kelvin).nominal(300.0),
        /// Temperature of the gear; constant without thermal.C_g
        "state.gear_temperature" = declare::State::new(712, 812, Unit::Kelvin).nominal(300.0),
        /// Energy from the supply since the start
        "state.energy_supply" = declare::State::new(707, 807, Unit::Joule).unbounded().nominal(1000.0),
        /// Mechanical energy to the load since the start
        "state.energy_shaft" = declare::State::new(708, 808, Unit::Joule).unbounded().nominal(1000.0),
        /// Heat to ambient since the start
        "state.energy_heat_to_ambient" = declare::State::new(709, 809, Unit::Joule).unbounded().nominal(1000.0),
        /// Electrical losses in the winding since the start
        "state.work_electrical" = declare::State::new(710, 810, Unit::Joule).unbounded().nominal(100.0),
        /// Friction losses since the start
        "state.work_friction" = declare::State::new(711, 811, Unit::Joule).unbounded().nominal(100.0),
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
    /// Temperatures of the nodes with their names, K; the winding comes first.
    fn nodes(&self) -> [(&'static str, f64); NODES] {
        [
            ("initial.winding_temperature", self.winding_temperature),
            ("initial.housing_temperature", self.housing_temperature),
            ("initial.box_temperature", self.box_temperature),
            ("initial.gear_temperature", self.gear_temperature),
        ]
    }

    /// What is wrong with initial values outside the limits of validity, in one sentence.
    pub(in crate::models::brushed_gearmotor) fn fault(&self, limits: &Limits) -> Option<String> {
        let [winding, others @ ..] = self.nodes();
        first_outside(limits, winding, &others)
    }

    /// The initial state; nodes without an initial value are at `ambient`, K.
    pub(in crate::models::brushed_gearmotor) fn state<const E: usize>(
        &self,
        ambient: f64,
    ) -> split::State<NODES, E> {
        split::State {
            x: Fast::new(self.current, self.shaft_speed),
            angle: self.shaft_angle,
            temperature: self.nodes().map(|(_, node)| temperature(node, ambient)).into(),
            ..split::State::default()
        }
    }
}

/// Heat capacities of the nodes, J/K; that of a gear without a temperature of its own is any, since no heat reaches its node.
pub(super) fn capacity(parameters: &Parameters) -> Temperatures {
    let thermal = &parameters.thermal;
    let gear = if thermal.has_gear() { thermal.C_g } else { thermal.C_h };
    Temperatures::new(thermal.C_w, thermal.C_h, thermal.C_b, gear)
}

impl Step<'_> {
    /// Temperature of the gear, K.
    #[inline]
    pub(super) fn gear_temperature(&self, temperature: &Temperatures) -> f64 {
        temperature[if self.model.thermal.has_gear() { GEAR } else { HOUSING }]
    }

    /// Conductance from gear to housing, W/K.
    #[inline]
    fn gear_conductance(&self) -> f64 {
        let thermal = &self.model.thermal;
        if thermal.has_gear() { 1.0 / thermal.R_gh } else { 0.0 }
    }

    /// Heat that is set free in the nodes by losses in the winding and by friction, W or J.
    #[inline]
    pub(super) fn heats(&self, winding: f64, friction: f64) -> Temperatures {
        let thermal = &self.model.thermal;
        let in_gear = if thermal.has_gear() { thermal.friction_to_gear * friction } else { 0.0 };
        Temperatures::new(winding, friction - in_gear, 0.0, in_gear)
    }

    /// Heat flows along the paths, W.
    #[inline]
    pub(super) fn flows(&self, t: f64, temperature: &Temperatures) -> [f64; PATHS.len()] {
        let (thermal, effects) = (&self.model.thermal, &self.model.effects);
        let (t_w, t_h, t_b) = (temperature[WINDING], temperature[HOUSING], temperature[BOX]);
        let to_box = self.constants.to_box;
        [
            (t_w - t_h) / (thermal.R_wh * effects.winding_housing_resistance(t_w)),
            to_box.winding * (t_w - t_b),
            (thermal.G_hb + to_box.housing) * (t_h - t_b) + effects.housing_to_ambient(t_h, t_b),
            thermal.G_ba * (t_b - self.ambient.at(t)),
            self.gear_conductance() * (temperature[GEAR] - t_h),
        ]
    }

    /// By how much the flows grow with the temperature where a path begins and fall with that where it ends, W/K.
    #[inline]
    pub(super) fn flow_slopes(&self, temperature: &Temperatures) -> [[f64; 2]; PATHS.len()] {
        let (thermal, effects) = (&self.model.thermal, &self.model.effects);
        let (t_w, t_h, t_b) = (temperature[WINDING], temperature[HOUSING], temperature[BOX]);
        let share = 1.0 / effects.winding_housing_resistance(t_w);
        let cold = share / thermal.R_wh;
        let hot = cold - cold * (t_w - t_h) * effects.winding_housing_resistance_slope(t_w) * share;
        let direct = self.constants.to_box;
        let through = thermal.G_hb + direct.housing;
        [
            [hot, cold],
            [direct.winding; 2],
            // What one body radiates to the other is what the other does not to the one.
            [
                through + effects.housing_to_ambient_slope(t_h, t_b),
                through + effects.housing_to_ambient_slope(t_b, t_h),
            ],
            [thermal.G_ba; 2],
            [self.gear_conductance(); 2],
        ]
    }
}
