//! Temperature-dependent resistance between winding and housing.
//!
//! R = R_wh [1 + beta (T_w - 298.15)]                                                       (1)
//!
//! Cause: impregnation that opens (beta > 0) or an air gap that closes (beta < 0) with thermal expansion of the winding.
//! *Assumes* a linear law about 25 degC. *Neglects* history. The bracket is at least 0.1.
//! *Sign*: beta > 0 increases the resistance of a hot winding. *Range*: see the limit of the bracket.
//! *Source*: data of the synthetic bench; first-order expansion of any smooth law.

use super::prelude::*;

/// Reference temperature of R_wh, K.
const T_REF: f64 = 298.15;
/// Smallest value of the bracket in eq. (1).
const LEAST: f64 = 0.1;

variables! {
    /// Answer of the interface to temperature.
    pub struct InterfaceTemperature {
        /// Relative change of thermal.R_wh per kelvin of winding temperature; 0 switches the effect off
        beta: f64 = Variable::tunable(0, 0.0, Unit::PerKelvin, -0.05, 0.05).nominal(0.003),
    }
}

impl Effect for InterfaceTemperature {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::WindingTemperature, Port::WindingHousingResistance, &["beta"])];
    const EXAMPLE: &'static [f64] = &[0.004];

    #[inline]
    fn winding_housing_resistance<D: Number>(&self, t_w: D) -> D {
        let bracket = (t_w - T_REF) * self.beta + 1.0;
        if bracket.re() < LEAST { D::from(LEAST) } else { bracket }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    /// 0.3 % per kelvin, 100 K above the reference: 1.3 times the resistance.
    #[test]
    fn linear_about_25_degrees() {
        let interface = InterfaceTemperature { beta: 0.003 };
        assert_eq!(interface.winding_housing_resistance(298.15), 1.0);
        assert!((interface.winding_housing_resistance(398.15f64) - 1.3).abs() < 1e-15);
        assert!((interface.winding_housing_resistance(288.15f64) - 0.97).abs() < 1e-15);
    }

    #[test]
    fn positive_whatever_the_temperature_and_off_by_default() {
        assert_eq!(InterfaceTemperature { beta: -0.05 }.winding_housing_resistance(600.0), 0.1);
        assert_eq!(
            InterfaceTemperature::default().winding_housing_resistance(500.0f64).to_bits(),
            1f64.to_bits()
        );
    }

    #[test]
    fn the_slope_is_the_derivative() {
        let interface = InterfaceTemperature { beta: -0.004 };
        slope_is_derivative(|t| interface.winding_housing_resistance(t), &[280.0, 350.0], 1e-2, 1e-10);
        let limited = InterfaceTemperature { beta: -0.05 };
        slope_is_derivative(|t| limited.winding_housing_resistance(t), &[400.0], 1e-2, 1e-10);
    }
}
