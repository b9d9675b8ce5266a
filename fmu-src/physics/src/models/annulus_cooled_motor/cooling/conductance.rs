//! Given conductance to ambient that the fan increases (`components/conductance.rs`): two nodes, winding and housing.

use super::{Coefficients, Method, Site};

/// The mode `conductance`.
#[derive(Debug)]
pub struct GivenConductance;

impl Method for GivenConductance {
    fn has_network(&self) -> bool {
        false
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let n = site.segments;
        c.ambient_conductance[..n].fill(site.parameters.conductance.at(site.command) / n as f64);
    }
}
