//! Stem conduction error of the housing temperature sensor.
//!
//! T_indicated = T - k (T - T_a)                                                            (1)
//!
//! T_a is the true ambient temperature.
//! *Assumes* a stem in the ambient air, in thermal equilibrium. *Neglects* the heat that the sensor draws from the housing.
//! *Sign*: k > 0 indicates too small a rise over ambient. *Range*: k from 0 (no loss) to below 1 (indicates ambient).
//! *Source*: two conductances in series, k = G_stem / (G_stem + G_contact).

use super::prelude::*;

variables! {
    /// Stem loss of the housing's sensor.
    pub struct HousingSensorStemLoss {
        /// Stem loss of the housing sensor: fraction of the rise over ambient; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 0.9).nominal(0.05),
    }
}

impl Effect for HousingSensorStemLoss {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::on(Driver::HousingTemperature, Port::HousingSensor, &["k"]).of_the_bench()];
    const EXAMPLE: &'static [f64] = &[0.06];

    #[inline]
    fn housing_sensor(&self, t: f64, t_a: f64) -> f64 {
        t - self.k * (t - t_a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tenth of 50 K is lost; at equal temperatures the error is zero.
    #[test]
    fn a_share_of_the_rise_is_lost() {
        let sensor = HousingSensorStemLoss { k: 0.1 };
        assert_eq!(sensor.housing_sensor(350.0, 300.0), 345.0);
        assert_eq!(sensor.housing_sensor(300.0, 300.0), 300.0);
        assert_eq!(HousingSensorStemLoss::default().housing_sensor(350.1, 300.0), 350.1);
    }
}
