//! Parameters of the motor and its modes of use.

use super::initial::Initial;
use super::variables::Choices;
use crate::components::annulus::Annulus;
use crate::components::chopper::Idle;
use crate::components::conductance::Conductance;
use crate::components::fan::Fan;
use crate::components::housing::Housing;
use crate::components::jacket::Jacket;
use crate::components::motor::Motor;
use crate::components::thermal::Thermal;
use crate::components::validity::{Limits, Validity};
use crate::effects::{Effects, PerNode};
use crate::groups;

/// Parameters of the motor and its modes of use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// Structural choices, constant over the run.
    pub choices: Choices,
    /// The drive.
    pub drive: Idle,
    /// Winding and magnets.
    pub motor: Motor,
    /// Heat capacities and resistances.
    pub thermal: Thermal,
    /// Cooling with a given conductance.
    pub conductance: Conductance,
    /// Dimensions and surface of the motor.
    pub housing: Housing,
    /// The fan.
    pub fan: Fan,
    /// The tube around the motor.
    pub annulus: Annulus,
    /// The water jacket.
    pub jacket: Jacket,
    /// Limits of validity.
    pub validity: Validity,
    /// Initial state.
    pub initial: Initial,
    /// Effects, each off by default.
    pub effects: Effects,
}

groups! {
    Parameters {
        "" @ 0 => choices: Choices,
        "drive." @ 85 => drive: Idle,
        "motor." @ 100 => motor: Motor,
        "thermal." @ 200 => thermal: Thermal,
        "conductance." @ 300 => conductance: Conductance,
        "housing." @ 400 => housing: Housing,
        "fan." @ 500 => fan: Fan,
        "annulus." @ 600 => annulus: Annulus,
        "jacket." @ 670 => jacket: Jacket,
        "validity." @ 650 => validity: Validity,
        "initial." @ 660 => initial: Initial,
    } then effects: Effects
}

impl Parameters {
    /// Limits of validity.
    pub fn limits(&self) -> Limits {
        Limits::new(self.validity, self.motor.T_ref, self.motor.alpha_mag)
    }

    /// Conductances to ambient at the fan command `n`, W/K.
    #[inline]
    pub fn to_ambient(&self, n: f64) -> PerNode {
        let n = self.effects.fan_flow(n);
        let mut conductance = self.effects.ambient_conductance(Conductance::share(n));
        conductance.housing += self.conductance.at(n);
        conductance
    }
}
