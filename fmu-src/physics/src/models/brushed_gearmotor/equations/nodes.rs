//! Thermal network of the gearmotor: heat capacities, heat paths and heat sources of the nodes.
//!
//! A further node is declared here and in `../states.rs`: its heat capacity, its heat paths ([`PATHS`], `flows`, `flow_slopes`), its
//! heat source (`heats`) and its account. Integrator, energy balance, saved states and Model Exchange need no change.

use super::Step;
use crate::ledger::Account;
use crate::models::brushed_gearmotor::parameters::Parameters;
use crate::models::brushed_gearmotor::states::{BOX, GEAR, HOUSING, NODES, Temperatures, WINDING};

/// Accounts of the nodes in the energy balance.
pub(super) const ACCOUNTS: [Account; NODES] =
    [Account::Winding, Account::Housing, Account::Enclosure, Account::Gear];

/// Heat paths, each from one node to another or to ambient.
pub(super) const PATHS: [(usize, Option<usize>); 5] = [
    (WINDING, Some(HOUSING)),
    (WINDING, Some(BOX)),
    (HOUSING, Some(BOX)),
    (BOX, None),
    (GEAR, Some(HOUSING)),
];

/// Heat capacities of the nodes, J/K; that of an unused gear node is arbitrary, since it receives no heat.
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

    /// Heat from losses in the winding and from friction, by node, W or J.
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

    /// Derivatives of the flows, W/K: with respect to the temperature at the start of a path, and minus that at its end.
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
            // Net radiation is antisymmetric in the two temperatures, so the second derivative follows by exchanging them.
            [
                through + effects.housing_to_ambient_slope(t_h, t_b),
                through + effects.housing_to_ambient_slope(t_b, t_h),
            ],
            [thermal.G_ba; 2],
            [self.gear_conductance(); 2],
        ]
    }
}
