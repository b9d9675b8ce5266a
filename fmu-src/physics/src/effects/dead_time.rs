//! Dead time of the drive's bridge: both switches of a leg are open and the diodes carry the current.
//!
//! V = share V_supply tanh(I / I_small),   share = 2 t_dead f_pwm                           (1)
//!
//! Acts in drive_mode pwm. V is subtracted from the motor's voltage, and the supply's power is lower accordingly: the current flows through
//! the diodes back to the supply. *Assumes* a bridge that switches both legs, diodes without drop (`bridge_drop.rs`).
//! *Sign*: against the current; no loss. *Source*: Mohan, Undeland, Robbins, Power Electronics, 3rd ed., sec. 8-7.

use super::prelude::*;

variables! {
    /// Dead time of the bridge.
    pub struct DeadTime {
        /// Fraction of the supply voltage lost to dead time, 2 t_dead f_pwm; 0 switches the effect off
        share: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 0.5).nominal(0.01),
        /// Current below which the lost voltage goes smoothly to zero
        I_small: f64 = Variable::tunable(1, 0.05, Unit::Ampere, 1e-4, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for DeadTime {
    // Seen where a duty drives the motor; a measured voltage is downstream of the bridge.
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::Current, Port::TerminalVoltage, &["share"])];
    const EXAMPLE: &'static [f64] = &[0.01];

    #[inline]
    fn missed_voltage<D: Number>(&self, i: D, supply: f64) -> D {
        smooth_sign(i, self.I_small) * (self.share * supply.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 us at 20 kHz is 4 % of the supply.
    #[test]
    fn against_the_current() {
        let dead = DeadTime { share: 2.0 * 1e-6 * 20e3, ..DeadTime::default() };
        assert!((dead.missed_voltage(3.0f64, 48.0) - 1.92).abs() < 1e-12);
        assert!((dead.missed_voltage(-3.0f64, -48.0) + 1.92).abs() < 1e-12);
        assert!(!DeadTime::default().is_on());
    }
}
