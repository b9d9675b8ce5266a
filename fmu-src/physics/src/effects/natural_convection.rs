//! Natural convection: the conductance of still air increases with the temperature rise.
//!
//! G = G_still (u / rise_ref)^m,   u = sqrt((T_h - T_a)^2 + 1 K^2)                          (1)
//!
//! G_still is the conductance with the fan off (components/conductance.rs); with this effect it is that at the rise rise_ref. Nu ~ Ra^m
//! with m = 1/4 for laminar and 1/3 for turbulent natural convection; less if part of the heat leaves by conduction.
//! *Assumes* that the fan adds its conductance unchanged. *Neglects* radiation (effect.housing_radiation). *Sign*: m > 0 cools less at a
//! smaller rise. *Range*: any rise; below 1 K, where conduction in the air remains, G is constant. The other cooling modes have
//! correlations of natural convection of their own.
//! *Source*: Incropera, Fundamentals of Heat and Mass Transfer, 7th ed., eq. 9.24 (exponents).

use super::prelude::*;

/// Rise below which the conductance is constant, K: conduction in the air remains.
const SMALLEST: f64 = 1.0;

variables! {
    /// The parameters of eq. (1).
    pub struct NaturalConvection {
        /// Exponent of the temperature rise in the conductance with the fan off; 0 switches the effect off
        m: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 0.5).nominal(0.1),
        /// Rise of the housing over ambient at which the conductance is that of still air
        rise_ref: f64 = Variable::tunable(1, 40.0, Unit::Kelvin, 1.0, 500.0).difference().log()
            .source("neutral while m is 0: reference, chosen"),
    }
}

impl Effect for NaturalConvection {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::HousingTemperature, Port::HousingAmbientConductance, &["m"])];
    const EXAMPLE: &'static [f64] = &[0.25];

    #[inline]
    fn still_air<D: Number>(&self, rise: D) -> D {
        if self.m == 0.0 {
            return D::from(0.0);
        }
        let square = (rise * rise + SMALLEST * SMALLEST) / (self.rise_ref * self.rise_ref);
        rise * (square.powf(0.5 * self.m) - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    /// At 16 times the reference rise a quarter power doubles the conductance: (16^0.25 - 1) 480 K = 480 K. At a sixteenth it halves it.
    #[test]
    fn doubles_at_sixteen_times_the_rise() {
        let air = NaturalConvection { m: 0.25, rise_ref: 30.0 };
        let heat = |rise: f64| -> f64 { air.still_air(rise) };
        assert!((heat(480.0) / 480.0 - 1.0).abs() < 1e-5 && heat(-480.0) == -heat(480.0));
        let air = NaturalConvection { m: 0.25, rise_ref: 480.0 };
        assert!((air.still_air(30.0f64) / -15.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn none_at_rest_off_by_default() {
        assert_eq!(NaturalConvection { m: 0.25, rise_ref: 40.0 }.still_air(0.0), 0.0);
        assert_eq!(NaturalConvection::default().still_air(70.0), 0.0);
    }

    /// Smooth through zero, where the conductance is that of a rise of 1 K: 16^-0.25 = 1/2 of that at 16 K.
    #[test]
    fn the_slope_is_the_derivative() {
        let air = NaturalConvection { m: 0.25, rise_ref: 16.0 };
        slope_is_derivative(|rise| air.still_air(rise), &[-30.0, 0.3, 5.0, 80.0], 1e-3, 1e-7);
        let slope = super::super::slope(0.0, |rise| air.still_air(rise));
        assert!((slope + 0.5).abs() < 1e-15, "{slope}");
    }
}
