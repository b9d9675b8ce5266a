//! A water jacket (`components/jacket.rs`): the water flows along the segments from the first to the last.

use super::{Coefficients, Method, Site, Stream};
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::EnergyBalance;

/// The mode `water_jacket`.
#[derive(Debug)]
pub struct WaterJacket;

impl Method for WaterJacket {
    fn mass(&self, parameters: &Parameters) -> f64 {
        parameters.cooling.jacket.mass
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let (at, n) = (site.at, site.segments);
        let jacket = &site.parameters.cooling.jacket;
        let coolant = jacket.coolant(at.coolant_flow_rate, at.coolant_inlet_temperature, at.surface);
        let per_segment = coolant.conductance / n as f64;
        c.film_conductance[..n].fill(per_segment);
        c.effectiveness[..n].fill(-(-per_segment / coolant.m_flow_cp.max(1e-12)).exp_m1());
        c.m_flow_cp = coolant.m_flow_cp;
        c.coolant_inlet = Some(at.coolant_inlet_temperature);
        c.of_mode = [coolant.pressure_drop, coolant.pump_power];
    }

    fn show(&self, stream: &Stream, out: &mut EnergyBalance) {
        (out.coolant_outlet_temperature, out.heat_to_coolant) = (stream.outlet, stream.heat);
        [out.coolant_pressure_drop, out.pump_power] = stream.coefficients.of_mode;
    }
}
