//! Given conductance to ambient that the fan increases (`components/conductance.rs`): two nodes, winding and housing.

use super::{Coefficients, Method, Site};

/// The mode `conductance`.
#[derive(Debug)]
pub struct GivenConductance;

impl Method for GivenConductance {
    fn has_network(&self) -> bool {
        false
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let (n, parameters) = (site.segments, site.parameters);
        let (rise, effects) = (site.at.surface - site.at.ambient, &parameters.effects);
        let secant = if rise == 0.0 { effects.still_air_slope(0.0) } else { effects.still_air(rise) / rise };
        let conductance = parameters.conductance.at(site.command) + parameters.conductance.G_still * secant;
        c.ambient_conductance[..n].fill(conductance / n as f64);
    }
}
