//! The drive between supply and terminals in drive_mode pwm: what it loses, and the ripple it leaves.

use super::{DriveMode, Inputs, Parameters, Step};
use crate::effects::{Effect, Port};

/// The drive over one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chopper {
    /// Whether it loses volts.
    loses: bool,
    /// Voltage of the supply at the start of the step, V.
    supply: f64,
    /// Mean square of the ripple at the start of the step, A2; it stays over the step.
    ripple: f64,
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

impl Step<'_> {
    /// Whether the drive loses something.
    #[inline]
    pub(super) fn loses(&self) -> bool {
        self.chopper.loses
    }

    /// Volts lost as heat in the bridge at the current `i`.
    #[inline]
    pub(super) fn bridge(&self, i: f64) -> f64 {
        if self.chopper.loses { self.model.effects.bridge_voltage(i) } else { 0.0 }
    }

    /// Volts that the supply gives less than duty times its voltage at the current `i`.
    #[inline]
    pub(super) fn missed(&self, i: f64) -> f64 {
        if self.chopper.loses { self.model.effects.missed_voltage(i, self.chopper.supply) } else { 0.0 }
    }

    /// Slope of both with the current, Ohm.
    #[inline]
    pub(super) fn drive_slope(&self, i: f64) -> f64 {
        if self.chopper.loses { self.model.effects.drive_voltage_slope(i, self.chopper.supply) } else { 0.0 }
    }

    /// Mean square of the current's ripple, A2.
    #[inline]
    pub(super) fn ripple_square(&self) -> f64 {
        self.chopper.ripple
    }

    /// Copper loss of the ripple with the winding at `t_w`, W.
    #[inline(always)]
    pub(super) fn ripple_loss(&self, t_w: f64) -> f64 {
        if self.chopper.ripple == 0.0 { 0.0 } else { self.resistance(t_w) * self.chopper.ripple }
    }
}
