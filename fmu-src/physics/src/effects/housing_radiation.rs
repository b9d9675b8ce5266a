//! Net thermal radiation from the housing to ambient.
//!
//! Q_flow = k (T_h^4 - T_a^4),   k = sigma eps A                                            (1)
//!
//! *Assumes* a grey, diffuse, convex body in a large enclosure at ambient temperature. *Neglects* the annulus wall.
//! *Sign*: Q_flow > 0 leaves the housing. *Range*: temperatures in kelvin.
//! *Source*: Incropera, Fundamentals of Heat and Mass Transfer, 7th ed., eq. 1.7.

use super::prelude::*;

variables! {
    /// Radiation.
    pub struct HousingRadiation {
        /// Emissivity times area times the Stefan-Boltzmann constant; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::WattPerKelvin4, 0.0, 1e-3).nominal(5e-10),
    }
}

impl Effect for HousingRadiation {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::HousingTemperature, Port::HousingAmbientConductance, &["k"])];
    const EXAMPLE: &'static [f64] = &[6e-10];

    #[inline]
    fn housing_to_ambient<D: Number>(&self, t_h: D, t_a: f64) -> D {
        let squares = t_h * t_h + t_a * t_a;
        (t_h - t_a) * (t_h + t_a) * squares * self.k
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;

    /// 100 cm2 of black paint (0.95) at 350 K at 300 K ambient: 5.670374e-8 * 0.95 * 0.01 * 6.90625e9 W.
    #[test]
    fn black_paint_at_350_kelvin() {
        let radiation = HousingRadiation { k: 5.670_374e-8 * 0.95 * 0.01 };
        let q: f64 = radiation.housing_to_ambient(350.0, 300.0);
        assert!((q - 3.720_296).abs() < 1e-5, "{q}");
        assert_eq!(radiation.housing_to_ambient(300.0f64, 350.0), -q);
    }

    #[test]
    fn none_in_balance_off_by_default() {
        assert_eq!(HousingRadiation { k: 5e-10 }.housing_to_ambient(300.0, 300.0), 0.0);
        assert_eq!(HousingRadiation::default().housing_to_ambient(400.0f64, 300.0).to_bits(), 0);
    }

    #[test]
    fn the_slope_is_the_derivative() {
        let radiation = HousingRadiation { k: 5e-10 };
        slope_is_derivative(|t| radiation.housing_to_ambient(t, 300.0), &[250.0, 300.0, 420.0], 1e-2, 1e-8);
    }
}
