//! The drive between supply and terminals in drive_mode pwm: what it loses, and the ripple it leaves.

use crate::effects::{Effect, Port};
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::{DriveMode, Inputs};

/// The drive over one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chopper {
    /// Whether it loses volts.
    pub loses: bool,
    /// Voltage of the supply at the start of the step, V.
    pub supply: f64,
    /// Mean square of the ripple at the start of the step, A2; it stays over the step.
    pub ripple: f64,
}

impl Chopper {
    /// The drive of a motor with these inputs; one that loses nothing in any other drive_mode.
    #[inline]
    pub fn new(model: &Parameters, chops: bool, inputs: &Inputs) -> Chopper {
        if !chops {
            return Chopper::default();
        }
        let ripple = model.effects.ripple_square(inputs.duty, inputs.voltage, model.motor.L);
        Chopper { loses: true, supply: inputs.voltage, ripple }
    }

    /// Whether any effect makes a drive of this motor lose something.
    pub fn acts(model: &Parameters) -> bool {
        model.choices.drive_mode == DriveMode::Pwm
            && (model.effects.acts_at(Port::Bridge) || model.effects.acts_at(Port::Ripple))
    }
}
