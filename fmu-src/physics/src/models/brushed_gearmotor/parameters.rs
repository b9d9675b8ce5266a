//! What a gearmotor is made of, and how it is used.

use super::initial::Initial;
use crate::components::armature::Armature;
use crate::components::chopper::Drive;
use crate::components::enclosure::Enclosure;
use crate::components::gear::Gear;
use crate::components::validity::{BrushedValidity, Limits};
use crate::effects::Effects;
use crate::groups;

/// What the gearmotor is made of, and how it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// Winding, brushes and magnets.
    pub motor: Armature,
    /// Heat capacities and conductances.
    pub thermal: Enclosure,
    /// The gear and its friction.
    pub gear: Gear,
    /// The H-bridge.
    pub drive: Drive,
    /// Where the equations end.
    pub validity: BrushedValidity,
    /// The state at the start.
    pub initial: Initial,
    /// Effects, each off by default.
    pub effects: Effects,
}

groups! {
    Parameters {
        "motor." @ 100 => motor: Armature,
        "thermal." @ 200 => thermal: Enclosure,
        "gear." @ 300 => gear: Gear,
        "drive." @ 400 => drive: Drive,
        "validity." @ 650 => validity: BrushedValidity,
        "initial." @ 660 => initial: Initial,
    } then effects: Effects
}

impl Parameters {
    /// Where the equations end.
    pub fn limits(&self) -> Limits {
        Limits::new(self.validity.into(), self.motor.T_ref, self.motor.alpha_mag)
    }
}
