//! A fan whose jet flows across the middle of the motor; still air outside the jet.

use super::{Coefficients, Method, Site};
use crate::components::housing::Orientation;
use crate::correlations::crossflow;
use crate::media::air::Air;
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// The mode `fan_crossflow`.
#[derive(Debug)]
pub struct FanCrossflow;

impl Method for FanCrossflow {
    fn mass(&self, parameters: &Parameters) -> f64 {
        parameters.cooling.fan.mass
    }

    fn fault(&self, parameters: &Parameters) -> Option<String> {
        parameters.cooling.fan.fault()
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let Site { parameters: p, at, still, command, .. } = *site;
        let (housing, fan) = (&p.housing, &p.cooling.fan);
        let film = Air::at(0.5 * (at.surface + at.ambient), at.ambient_pressure);
        let (jet, flow) = (fan.jet(), fan.flow_max * command.max(0.0));
        let d = housing.diameter;
        let re = film.reynolds(jet.speed(flow, fan.distance), d);
        let forced = (crossflow::cylinder(re, film.pr) - crossflow::NU_AT_REST) * fan.turbulence_factor;
        // Buoyant flow around a horizontal cylinder is parallel to the jet, along a vertical one perpendicular to it.
        let mixing = match housing.orientation {
            Orientation::Horizontal => crossflow::Mixing::HorizontalCylinder,
            Orientation::Vertical => crossflow::Mixing::General,
        };
        let blown = crossflow::mixed(forced, still.lateral * d / film.k, mixing) * film.k / d;
        let covered = jet.covered_length(housing.length, fan.distance);
        let (from, to) = (0.5 * (housing.length - covered), 0.5 * (housing.length + covered));
        for (k, share) in site.covered(from, to) {
            let convection = share * blown + (1.0 - share) * still.lateral;
            c.ambient_conductance[k] =
                housing.lateral_area() / site.segments as f64 * (convection + still.radiation);
        }
        c.flow = flow;
    }
}
