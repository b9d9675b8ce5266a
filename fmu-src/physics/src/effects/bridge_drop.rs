//! Voltage drop of the drive's H-bridge.
//!
//! V = V_0 tanh(I / I_small) + R_on I                                                       (1)
//!
//! Acts in drive_mode pwm. *Assumes* two switches in the current path at all times, so that the drop does not depend on the duty.
//! *Neglects* switching times. *Sign*: that of the current; its power V I >= 0 heats the drive, which is thermally separate from the motor,
//! and thus ambient.
//! *Range*: V_0 is 0 for MOSFETs, 1.4 to 3 V for bipolar bridges (L298: 1.8 V typical at 1 A).
//! *Source*: Mohan, Undeland, Robbins, Power Electronics, 3rd ed., ch. 2 and 20.

use super::prelude::*;

variables! {
    /// Drop of the bridge.
    pub struct BridgeDrop {
        /// Bridge voltage drop at any current
        V_0: f64 = Variable::tunable(0, 0.0, Unit::Volt, 0.0, 100.0),
        /// On-state resistance of the bridge
        R_on: f64 = Variable::tunable(1, 0.0, Unit::Ohm, 0.0, 100.0).nominal(0.01),
        /// Current below which V_0 goes smoothly to zero
        I_small: f64 = Variable::tunable(2, 0.05, Unit::Ampere, 1e-4, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for BridgeDrop {
    // Seen where a duty drives the motor; a measured voltage is downstream of the bridge.
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::Current, Port::TerminalVoltage, &["V_0"])];
    const EXAMPLE: &'static [f64] = &[0.5, 0.05];

    #[inline]
    fn is_on(&self) -> bool {
        self.V_0 != 0.0 || self.R_on != 0.0
    }

    #[inline]
    fn bridge_voltage<D: Number>(&self, i: D) -> D {
        smooth_sign(i, self.I_small) * self.V_0 + i * self.R_on
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    #[test]
    fn a_bipolar_bridge() {
        let bridge = BridgeDrop { V_0: 1.8, R_on: 0.2, ..BridgeDrop::default() };
        assert!((bridge.bridge_voltage(2.0f64) - 2.2).abs() < 1e-15);
        assert!((bridge.bridge_voltage(-2.0f64) + 2.2).abs() < 1e-15);
        slope_is_derivative(|i| bridge.bridge_voltage(i), &[-1.0, 0.0, 0.03], 1e-6, 1e-6);
        assert!(!BridgeDrop::default().is_on());
    }
}
