//! Natural convection and radiation in still air (`components/housing.rs`).

use super::{Coefficients, Method, Site};

/// The mode `bare`.
#[derive(Debug)]
pub struct Bare;

impl Method for Bare {
    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        c.ambient_conductance[..site.segments].fill(site.free());
    }
}
