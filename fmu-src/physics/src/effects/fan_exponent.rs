//! Cooling by a fan with another exponent of the fan command.
//!
//! n_effective = n^(1 + e)                                                                  (1)
//!
//! The model's forced convection follows the command by Nu ~ Re^0.8, the exponent of turbulent flow, with a flow proportional to the
//! command. e = -0.375 makes that Re^0.5, a laminar boundary layer; cylinders in cross flow have 0.33 to 0.81. A controller whose speed
//! is no multiple of the command has any e.
//! *Assumes* one exponent over the whole range of the fan. *Neglects* the transition between flows.
//! *Sign*: e > 0 reduces the flow below full command. *Range*: n is limited to 0 ... 1; full command is unchanged.
//! *Source*: Incropera, Fundamentals of Heat and Mass Transfer, 7th ed., eq. 7.30 and 8.60, table 7.2.

use super::prelude::*;

variables! {
    /// Exponent of the fan command.
    pub struct FanExponent {
        /// Exponent of the fan command in the effective command, minus 1; 0 switches the effect off
        e: f64 = Variable::tunable(0, 0.0, Unit::One, -0.9, 4.0).nominal(0.2),
    }
}

impl Effect for FanExponent {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::FanCommand, Port::FanFlow, &["e"])];
    const EXAMPLE: &'static [f64] = &[-0.2];

    #[inline]
    fn fan_flow(&self, n: f64) -> f64 {
        if self.e == 0.0 {
            return n;
        }
        n.clamp(0.0, 1.0).powf(1.0 + self.e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of the command gives half of the flow with the exponent 1/2; full command and rest stay.
    #[test]
    fn a_power_of_the_command() {
        let fan = FanExponent { e: -0.5 };
        assert_eq!([0.0, 0.25, 1.0].map(|n| fan.fan_flow(n)), [0.0, 0.5, 1.0]);
        assert_eq!((fan.fan_flow(-0.1), fan.fan_flow(1.2)), (0.0, 1.0));
        assert_eq!(FanExponent::default().fan_flow(0.37), 0.37);
        // Re^0.8 of the model becomes that of a laminar boundary layer.
        let laminar = FanExponent { e: -0.375 }.fan_flow(0.3).powf(0.8);
        assert!((laminar - 0.3f64.powf(0.5)).abs() < 1e-15);
    }
}
