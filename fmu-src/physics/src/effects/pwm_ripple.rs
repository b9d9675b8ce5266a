//! Copper loss of the current ripple from PWM.
//!
//! dI = V_supply d (1 - d) / (L f),   I_ripple^2 = dI^2 / 12,   Q = R(T_w) I_ripple^2          (1)
//!
//! Acts in drive_mode pwm, with d the magnitude of the duty. *Assumes* a triangular ripple: a period far below L/R, continuous
//! conduction, one leg switching (both legs at once: twice dI). *Neglects* skin effect and the ripple loss in
//! iron and magnets. *Sign*: Q heats the winding and is drawn from the supply.
//! *Range*: f L/R above about 3; below, (1) overestimates. *Source*: Mohan, Undeland, Robbins, Power Electronics,
//! 3rd ed., sec. 7-7.

use super::prelude::*;

variables! {
    /// Ripple of a chopped current.
    pub struct PwmRipple {
        /// Switching frequency; 0 switches the effect off
        f: f64 = Variable::tunable(0, 0.0, Unit::Hertz, 0.0, 1e7).nominal(2e4),
    }
}

impl Effect for PwmRipple {
    // The size has no value at which the effect is 0: the loss decreases with the square of the frequency.
    const CANDIDATES: &'static [Candidate] = &[];
    const EXAMPLE: &'static [f64] = &[5e4];

    #[inline]
    fn ripple_square(&self, duty: f64, supply: f64, inductance: f64) -> f64 {
        if self.f == 0.0 {
            return 0.0;
        }
        let d = duty.abs().min(1.0);
        let peak_to_peak = supply * d * (1.0 - d) / (inductance * self.f);
        peak_to_peak * peak_to_peak / 12.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 48 V at half duty, 65.3 uH, 50 kHz: 3.675 A from peak to peak, 1.126 A^2.
    #[test]
    fn a_motor_of_low_inductance() {
        let ripple = PwmRipple { f: 50e3 };
        assert!((ripple.ripple_square(0.5, 48.0, 65.3e-6) - 1.125_6).abs() < 1e-3);
        assert_eq!(ripple.ripple_square(1.0, 48.0, 65.3e-6), 0.0);
        assert_eq!(PwmRipple::default().ripple_square(0.5, 48.0, 65.3e-6), 0.0);
    }
}
