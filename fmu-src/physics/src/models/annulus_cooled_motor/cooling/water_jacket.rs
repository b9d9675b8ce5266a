//! A water jacket (`components/jacket.rs`): the water flows along the segments from the first to the last.

use super::{Coefficients, Method, Site};
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// The mode `water_jacket`.
#[derive(Debug)]
pub struct WaterJacket;

impl Method for WaterJacket {
    fn mass(&self, parameters: &Parameters) -> f64 {
        parameters.jacket.mass
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let (at, n) = (site.at, site.segments);
        let coolant = site.parameters.jacket.coolant(at.coolant_flow, at.coolant_inlet, at.surface);
        let per_segment = coolant.conductance / n as f64;
        c.film_conductance[..n].fill(per_segment);
        c.effectiveness[..n].fill(-(-per_segment / coolant.m_flow_cp.max(1e-12)).exp_m1());
        c.m_flow_cp = coolant.m_flow_cp;
        c.coolant_inlet = Some(at.coolant_inlet);
        (c.coolant_pressure_drop, c.pump_power) = (coolant.pressure_drop, coolant.pump_power);
    }
}
