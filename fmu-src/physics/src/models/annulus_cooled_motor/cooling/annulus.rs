//! A fan that pushes or pulls air through the gap between the motor and a tube; the air enters at segment 1.

use super::{Coefficients, Method, Site};
use crate::components::annulus::{FlowDirection, Gap};
use crate::components::fan::Fan;
use crate::correlations::radiation;
use crate::media::air::{Air, density};
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// The modes `annulus_push` and `annulus_pull`.
#[derive(Debug)]
pub struct Annulus(pub FlowDirection);

impl Method for Annulus {
    fn mass(&self, parameters: &Parameters) -> f64 {
        parameters.cooling.fan.mass + parameters.cooling.annulus.mass
    }

    fn tube_capacity(&self, parameters: &Parameters) -> f64 {
        parameters.cooling.annulus.capacity()
    }

    fn gap(&self, parameters: &Parameters) -> Option<Gap> {
        Some(Gap::new(
            &parameters.cooling.annulus,
            &parameters.housing,
            parameters.cooling.fan.opening(),
            self.0,
        ))
    }

    fn fault(&self, parameters: &Parameters) -> Option<String> {
        parameters.cooling.fan.fault().or_else(|| parameters.cooling.annulus.fault(&parameters.housing))
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn is_slow(&self) -> bool {
        true
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let Some(gap) = site.gap else { return };
        let Site { parameters: p, at, command, .. } = *site;
        let free = site.free();
        let (housing, annulus, fan) = (&p.housing, &p.cooling.annulus, &p.cooling.fan);
        let factor = annulus.factor(self.0);
        let (n, rho) = (site.segments, density(at.ambient, at.ambient_pressure));
        let (inner, outer) = (housing.lateral_area() * gap.length / housing.length, gap.wall_area);
        let table = fan.table();
        let curve = table.curve().ok();
        // Air properties are those at its mean temperature, which depends on the flow: two iterations are enough.
        let (mut mean, mut air) =
            (at.ambient + 0.2 * (at.surface - at.ambient), Air::at(at.ambient, at.ambient_pressure));
        let (mut flow, mut mass_flow) = (None, 0.0);
        for _ in 0..2 {
            air = Air::at(mean, at.ambient_pressure);
            let resistance = gap.resistance(&air);
            let system = |q: f64| {
                let drop = resistance.pressure(rho * q) - site.buoyancy(gap, rho * q, &air, factor);
                (drop, gap.leak(drop, rho))
            };
            flow = curve
                .map(|curve| curve.operating_flow_with_leak(command, rho / fan.density_ref, system, flow));
            c.flow = flow.unwrap_or(0.0);
            mass_flow = rho * c.flow;
            c.m_flow_cp = mass_flow * air.c_p;
            let nu = gap.heated.mean(gap.reynolds(mass_flow, &air), air.pr, gap.length / gap.d_h);
            let g = factor * nu * air.k / gap.d_h * inner;
            let ntu = g / c.m_flow_cp.max(1e-12);
            mean = at.ambient + (at.surface - at.ambient) * (1.0 + (-ntu).exp_m1() / ntu);
        }
        c.pressure_drop = gap.pressure(mass_flow, &air) - site.buoyancy(gap, mass_flow, &air, factor);
        if self.0 == FlowDirection::Push && c.m_flow_cp > 0.0 {
            c.fan_power = warming(fan, command, rho, c, gap);
            c.inlet_rise = c.fan_power / c.m_flow_cp;
        }
        let re = gap.reynolds(mass_flow, &air);
        // Film conductance of developed flow, W/K. Near zero flow it changes to that of air at rest; `still` is the fraction at rest.
        let share = inner / (inner + outer);
        let developed = factor * gap.heated.nu_developed() * air.k / gap.d_h * (inner + outer);
        let graetz = c.m_flow_cp * gap.d_h * gap.d_h / (air.k * gap.section * gap.length);
        let still = (-graetz).exp();
        let beyond = still
            * (gap.at_rest(at.surface, at.tube, at.ambient_pressure) / (share * (1.0 - share)) - developed);
        c.behind = -(-c.m_flow_cp * gap.d_h / (air.k * gap.section)).exp_m1();
        let dx = housing.length / n as f64;
        // Nu times length up to the end of the segment before, in hydraulic diameters.
        let mut before = 0.0;
        for (k, covered) in site.covered(0.0, gap.length) {
            c.ambient_conductance[k] = (1.0 - covered) * free;
            if covered <= 0.0 {
                continue;
            }
            let part = dx * covered / gap.length;
            let upto = gap.heated.integral(re, air.pr, dx * (k as f64 + covered) / gap.d_h);
            let film = factor * (upto - before) * air.k / gap.length;
            before = upto;
            c.film_conductance[k] = film * (inner + outer) + beyond * part;
            c.share[k] = share;
            c.effectiveness[k] = -(-c.film_conductance[k] / c.m_flow_cp.max(1e-12)).exp_m1();
        }
        // Long concentric cylinders, Incropera, 7th ed., eq. 13.20.
        let resistance =
            1.0 / housing.emissivity.max(1e-9) + inner / outer * (1.0 / annulus.emissivity.max(1e-9) - 1.0);
        let black = radiation::coefficient(1.0, at.surface, at.tube);
        c.to_tube = black / resistance * inner / n as f64;
        c.tube_to_ambient = gap.tube_to_ambient(annulus, at.tube, at.ambient, at.ambient_pressure);
    }
}

impl Site<'_> {
    /// Buoyancy pressure in a vertical gap at the mass flow `m`, kg/s, in Pa; the mean air temperature is that between both walls.
    fn buoyancy(&self, gap: &Gap, m: f64, air: &Air, factor: f64) -> f64 {
        if !gap.is_upright() {
            return 0.0;
        }
        let (at, inner) = (self.at, gap.wall_area * gap.ratio());
        let both = inner + gap.wall_area;
        let wall = at.tube + inner / both * (at.surface - at.tube);
        let nu = gap.heated.mean(gap.reynolds(m, air), air.pr, gap.length / gap.d_h);
        let ntu = factor * nu * air.k / gap.d_h * both / (m * air.c_p).max(1e-12);
        let mean = at.ambient + (wall - at.ambient) * (1.0 + (-ntu).exp_m1() / ntu);
        gap.buoyancy(mean, at.ambient, at.ambient_pressure)
    }
}

/// Fan power that warms the air of the gap, W: the fraction of the fan power that equals the gap's fraction of the fan flow.
fn warming(fan: &Fan, command: f64, rho: f64, c: &Coefficients, gap: &Gap) -> f64 {
    let through = (c.flow / (c.flow + gap.leak(c.pressure_drop, rho)).max(1e-12)).min(1.0);
    fan.power_at(command.clamp(0.0, 1.0), rho) * through
}
