//! Parameters of the gearmotor and its modes of use.

use super::nodes::Initial;
use crate::components::armature::Armature;
use crate::components::chopper::Drive;
use crate::components::enclosure::Enclosure;
use crate::components::gear::Gear;
use crate::components::validity::{BrushedValidity, Limits};
use crate::effects::{EffectPort, Effects};
use crate::groups;
use crate::model::Unserved;
use crate::terms::{Driver, GenericTerm, LagStarts, Port};

groups! {
    /// Parameters of the gearmotor and its modes of use.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Parameters {
        /// Winding, brushes and magnets.
        motor: Armature = "motor." @ 100,
        /// Heat capacities and conductances.
        thermal: Enclosure = "thermal." @ 200,
        /// The gear and its friction.
        gear: Gear = "gear." @ 300,
        /// The H-bridge.
        drive: Drive = "drive." @ 400,
        /// Limits of validity.
        validity: BrushedValidity = "validity." @ 650,
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
        Limits::new(self.validity.into(), self.motor.T_ref, self.motor.alpha_mag)
    }
}

/// Why this model does not support a port of the effects, and the alternative; `None` for supported ports.
fn reason(port: EffectPort) -> Option<&'static str> {
    use EffectPort::*;
    match port {
        DragTorque | LoadDrag | TerminalVoltage | TorqueConstant | WindingHousingResistance => None,
        AmbientConductance | HousingToAmbient | AmbientSensor | WindingSensor | HousingSensor => None,
        TorqueSensor | Any => None,
        // Terms from data alone act at these.
        WindingHeat | HousingHeat | HeatCapacity | DrivenDrag | DrivenVoltage | SeriesVoltage
        | WindingResistance | DrivenTorqueConstant => None,
        StatorLoss | PowerModeLoad => Some("no power is imposed; the current carries losses and torque"),
        WarmDrag => {
            Some("the friction of its grease is gear.B, which follows the temperature with gear.T_ref")
        }
        StillAir => Some(
            "its conductances are thermal.G_hb and thermal.G_ba; effect.housing_radiation.k increases them with temperature",
        ),
        FanFlow => Some("it has no fan; effect.forced_convection.G is an additional conductance"),
        SensorLag => Some(
            "the sensors have no states; effect.winding_sensor_stem_loss.k and effect.housing_sensor_stem_loss.k are their static errors",
        ),
        DriveLoss => {
            Some("no power is imposed; drive.drop and drive.freewheel_drop are the losses of the bridge")
        }
        Stator => Some(
            "the armature includes the stator; thermal.C_w and thermal.R_wh are its capacity and resistance",
        ),
        Bridge => Some(
            "its bridge has a model of its own; drive.drop and drive.freewheel_drop are the voltage drops",
        ),
        Ripple => Some("the switching cycle gives the ripple; drive.pwm_frequency is the frequency"),
    }
}

/// Why the gearmotor does not take a term; `None` if it does.
pub(super) fn refusal(term: &GenericTerm) -> Option<&'static str> {
    let is_of_a_fan = term.port == Port::FanFlow || term.law.drivers().any(|d| d == Driver::FanCommand);
    is_of_a_fan.then_some("it has no fan")
}

/// Variables of shared components that the gearmotor does not support.
pub(super) fn unserved() -> Vec<Unserved> {
    let mut all = Effects::unserved(reason);
    all.push(Unserved {
        start: "effect.forced_convection.driver",
        reason: "it has no fan command; effect.forced_convection.G is constant",
    });
    all
}
