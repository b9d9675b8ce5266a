//! Parameters of the motor and its modes of use.

use super::cooling::{CoolingMode, Parts};
use super::initial::Initial;
use super::variables::{DriveMode, MechanicalMode};
use crate::components::chopper::Idle;
use crate::components::commutation::Commutation;
use crate::components::conductance::Conductance;
use crate::components::housing::Housing;
use crate::components::motor::Motor;
use crate::components::thermal::Thermal;
use crate::components::validity::{Limits, Validity};
use crate::effects::{Effects, PerNode};
use crate::groups;
use crate::terms::LagStarts;
use declare::{Variable, variables};

variables! {
    /// Choices that hold for the whole run.
    pub struct Choices {
        /// Electrical drive
        drive_mode: DriveMode = Variable::choice(80, 1),
        /// Mechanical boundary condition of the shaft
        mechanical_mode: MechanicalMode = Variable::choice(81, 1),
        /// Cooling of the housing
        cooling_mode: CoolingMode = Variable::choice(82, 1),
        /// Commutation of the phase currents
        commutation: Commutation = Variable::choice(83, 1),
        /// Number of housing segments along the axis (not in cooling_mode conductance)
        air_segments: i32 = Variable::count(84, 8, 1, 64)
            .source("grid study: winding within 0.2 K of 64 segments"),
    }
}

groups! {
    /// Parameters of the motor and its modes of use.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Parameters {
        /// Structural choices, constant over the run.
        choices: Choices = "" @ 0,
        /// The drive.
        drive: Idle = "drive." @ 85,
        /// Winding and magnets.
        motor: Motor = "motor." @ 100,
        /// Heat capacities and resistances.
        thermal: Thermal = "thermal." @ 200,
        /// Cooling with a given conductance.
        conductance: Conductance = "conductance." @ 300,
        /// Dimensions and surface of the motor.
        housing: Housing = "housing." @ 400,
        /// Parts of the cooling modes.
        cooling: Parts,
        /// Limits of validity.
        validity: Validity = "validity." @ 650,
        /// Initial state.
        initial: Initial = "initial." @ 660,
        /// Initial lags of terms.
        lag_starts: LagStarts = "initial." @ 660,
        /// Effects, each off by default.
        effects: Effects,
    }
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
