//! The drive between supply and terminals in drive_mode pwm: losses, ripple, and open switches.
//!
//! Open switches (`drive.zero_duty` = coast, duty 0): the mean current decays to zero with L/R, and the terminal voltage is
//! the back-EMF e. If |e| exceeds the supply voltage V_s, the diodes rectify:
//! ```text
//! L di/dt = u - R i - V_lost(i) - e,   u = min(max(e, -V_s), V_s)                          (1)
//! ```
//! The gearmotor's bridge has the same equation (`components/chopper.rs`). With brake, or at any other duty, u is duty
//! times V_s.

use super::Step;
use crate::components::chopper::ZeroDuty;
use crate::effects::EffectPort;
use crate::line::Line;
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::{DriveMode, Inputs};

/// The drive over one step.
#[derive(Clone, Copy, Debug)]
pub struct Chopper {
    /// Whether it has voltage losses or ripple.
    pub loses: bool,
    /// Whether all switches are open.
    pub coasts: bool,
    /// Duty cycle.
    duty: Line,
    /// Supply voltage, V.
    supply: Line,
}

impl Chopper {
    /// No chopper.
    const NONE: Chopper = Chopper {
        loses: false,
        coasts: false,
        duty: Line { start: 0.0, slope: 0.0 },
        supply: Line { start: 0.0, slope: 0.0 },
    };

    /// The drive of a motor with these inputs; without losses in any other drive_mode.
    #[inline]
    pub fn new(model: &Parameters, chops: bool, u: &Inputs, slopes: &Inputs) -> Chopper {
        if !chops {
            return Chopper::NONE;
        }
        let opens = model.drive.zero_duty == ZeroDuty::Coast;
        Chopper {
            loses: Chopper::loses(model),
            coasts: opens && u.duty == 0.0 && slopes.duty == 0.0,
            duty: Line { start: u.duty, slope: slopes.duty },
            supply: Line { start: u.voltage, slope: slopes.voltage },
        }
    }

    /// Supply voltage after `t` seconds, V.
    #[inline]
    pub fn supply(&self, t: f64) -> f64 {
        self.supply.at(t)
    }

    /// Terminal voltage of eq. (1) before losses, V, at the back-EMF `e`, and its derivative with respect to e.
    #[inline]
    pub fn open_voltage(&self, t: f64, e: f64) -> (f64, f64) {
        let limit = self.supply.at(t).abs();
        if e.abs() <= limit { (e, 1.0) } else { (limit.copysign(e), 0.0) }
    }

    /// Whether the terminal voltage of this motor's drive differs from duty times supply voltage.
    pub fn acts(model: &Parameters) -> bool {
        let pwm = model.choices.drive_mode == DriveMode::Pwm;
        pwm && (Chopper::loses(model) || model.drive.zero_duty == ZeroDuty::Coast)
    }

    /// Whether an effect acts at the drive.
    fn loses(model: &Parameters) -> bool {
        model.effects.acts_at(EffectPort::Bridge) || model.effects.acts_at(EffectPort::Ripple)
    }
}

/// The drive in drive_mode pwm.
impl<const FORM: u8> Step<'_, FORM> {
    /// Whether the drive has losses.
    #[inline]
    pub(super) fn loses(&self) -> bool {
        !Self::PLAIN && self.chopper.loses
    }

    /// Whether all switches are open.
    #[inline(always)]
    pub(super) fn coasts(&self) -> bool {
        !Self::PLAIN && self.chopper.coasts
    }

    /// Bridge voltage drop at the current `i`, V; it becomes heat.
    #[inline]
    pub(super) fn bridge(&self, i: f64) -> f64 {
        if self.loses() { self.model.effects.bridge_voltage(i) } else { 0.0 }
    }

    /// Source voltage `t` seconds after the start of the step, V; `e` is the back-EMF, which is the voltage with open switches.
    #[inline(always)]
    pub(super) fn source(&self, t: f64, e: f64) -> f64 {
        if self.coasts() {
            self.chopper.open_voltage(t, e).0
        } else if Self::PLAIN {
            Self::at(&self.voltage, t)
        } else {
            self.voltage.at(t) + self.voltage_bend * (t * t)
        }
    }

    /// Supply voltage that dead time reduces, V; zero with open switches.
    #[inline]
    pub(super) fn chopped(&self, t: f64) -> f64 {
        if self.coasts() { 0.0 } else { self.chopper.supply(t) }
    }

    /// Voltage loss by dead time at the current `i`, V.
    #[inline]
    pub(super) fn missed(&self, t: f64, i: f64) -> f64 {
        if self.loses() { self.model.effects.missed_voltage(i, self.chopped(t)) } else { 0.0 }
    }

    /// Derivative of bridge voltage drop and dead-time loss with respect to the current, Ohm.
    #[inline]
    pub(super) fn drive_slope(&self, t: f64, i: f64) -> f64 {
        if self.loses() { self.model.effects.drive_voltage_slope(i, self.chopped(t)) } else { 0.0 }
    }

    /// Mean square of the current ripple, A2.
    #[inline]
    pub(super) fn ripple_square(&self, t: f64) -> f64 {
        if !self.loses() {
            return 0.0;
        }
        let chopper = &self.chopper;
        self.model.effects.ripple_square(chopper.duty.at(t), chopper.supply.at(t), self.model.motor.L)
    }

    /// Copper loss of the current ripple in the resistance `r`, Ohm, W.
    #[inline(always)]
    pub(super) fn ripple_loss(&self, t: f64, r: f64) -> f64 {
        if self.loses() { r * self.ripple_square(t) } else { 0.0 }
    }

    /// The same equations with the switch state of the last event.
    pub fn with_open_switches(mut self, open: bool) -> Self {
        self.chopper.coasts &= open;
        self
    }
}
