//! Voltage drop of brushes or semiconductors.
//!
//! V = V_b tanh(I / I_small)                                                                (1)
//!
//! *Assumes* a drop independent of the current's magnitude. *Neglects* temperature, wear and the brush film.
//! *Sign*: that of the current; the terminal voltage exceeds the winding voltage by V, and its power V I >= 0 heats the winding.
//! *Source*: Modelica Standard Library, Electrical.Machines.Losses.DCMachines.Brush, with a smooth transition.

use super::prelude::*;

variables! {
    /// Drop of the contacts.
    pub struct ContactDrop {
        /// Contact voltage drop at full current; 0 switches the effect off
        V_b: f64 = Variable::tunable(0, 0.0, Unit::Volt, 0.0, 100.0),
        /// Current below which the voltage drop goes smoothly to zero
        I_small: f64 = Variable::tunable(1, 0.05, Unit::Ampere, 1e-4, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

impl Effect for ContactDrop {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::Current, Port::TerminalVoltage, &["V_b"])];
    const EXAMPLE: &'static [f64] = &[0.4];

    #[inline]
    fn terminal_voltage<D: Number>(&self, i: D) -> D {
        smooth_sign(i, self.I_small) * self.V_b
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    const BRUSHES: ContactDrop = ContactDrop { V_b: 0.8, I_small: 0.05 };

    #[test]
    fn the_full_drop_of_the_currents_sign() {
        assert_eq!(BRUSHES.terminal_voltage(5.0), 0.8);
        assert_eq!(BRUSHES.terminal_voltage(-5.0), -0.8);
        // tanh(1) = 0.761594155955765
        assert!((BRUSHES.terminal_voltage(0.05f64) - 0.8 * 0.761_594_155_955_765).abs() < 1e-15);
        assert_eq!(BRUSHES.terminal_voltage(0.0), 0.0);
        assert_eq!(ContactDrop::default().terminal_voltage(5.0f64).to_bits(), 0);
    }

    #[test]
    fn the_slope_is_the_derivative() {
        slope_is_derivative(|i| BRUSHES.terminal_voltage(i), &[-3.0, -0.06, 0.0, 0.02], 1e-6, 1e-7);
    }
}
