//! Additional conductance to ambient.
//!
//! Q_flow = G s (T - T_a),   T that of the housing or of the winding                        (1)
//!
//! s = 1 (driver constant: air flow in the laboratory, a mount) or s = n^0.8 (driver fan_command, components/conductance.rs).
//! *Assumes* that it does not depend on temperature. *Neglects* the temperature rise of the air.
//! *Sign*: Q_flow > 0 leaves the motor. *Source*: as components/conductance.rs.

use super::prelude::*;
use declare::enumeration;

enumeration! {
    /// Node with forced convection.
    pub enum CooledNode {
        /// Housing.
        Housing = 1, "housing";
        /// Winding, by air inside the motor.
        Winding = 2, "winding";
    }
}

enumeration! {
    /// Driver of forced convection.
    pub enum ConvectionDriver {
        /// Constant.
        Constant = 1, "constant";
        /// Proportional to fan_command^0.8.
        FanCommand = 2, "fan_command";
    }
}

variables! {
    /// Convection beyond that of the cooling.
    pub struct ForcedConvection {
        /// Conductance to ambient (driver fan_command: at full speed); 0 switches the effect off
        G: f64 = Variable::tunable(0, 0.0, Unit::WattPerKelvin, 0.0, 1e4).nominal(0.05),
        /// Cooled node
        node: CooledNode = Variable::choice(1, 1),
        /// Driver of the conductance
        driver: ConvectionDriver = Variable::choice(2, 1),
    }
}

impl Effect for ForcedConvection {
    const CANDIDATES: &'static [Candidate] = &[
        Candidate {
            settings: &[("node", "housing"), ("driver", "constant")],
            ..Candidate::constant(Port::HousingAmbientConductance, &["G"]).of_the_bench()
        },
        Candidate {
            settings: &[("node", "winding"), ("driver", "constant")],
            ..Candidate::constant(Port::WindingHeat, &["G"]).of_the_bench()
        },
        Candidate {
            settings: &[("node", "winding"), ("driver", "fan_command")],
            ..Candidate::on(Driver::FanCommand, Port::WindingHeat, &["G"])
        },
    ];
    const EXAMPLE: &'static [f64] = &[0.03, 2.0, 2.0];

    #[inline]
    fn ambient_conductance(&self, flow: f64) -> PerNode {
        let mut conductance = PerNode::default();
        let g = match self.driver {
            ConvectionDriver::Constant => self.G,
            ConvectionDriver::FanCommand => self.G * flow,
        };
        match self.node {
            CooledNode::Housing => conductance.housing = g,
            CooledNode::Winding => conductance.winding = g,
        }
        conductance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_the_node_and_with_the_driver_that_are_chosen() {
        let mut forced = ForcedConvection { G: 0.2, ..ForcedConvection::default() };
        assert_eq!(forced.ambient_conductance(0.5), PerNode { winding: 0.0, housing: 0.2 });
        forced.driver = ConvectionDriver::FanCommand;
        assert_eq!(forced.ambient_conductance(0.5), PerNode { winding: 0.0, housing: 0.1 });
        forced.node = CooledNode::Winding;
        assert_eq!(forced.ambient_conductance(0.5), PerNode { winding: 0.1, housing: 0.0 });
        assert_eq!(forced.ambient_conductance(0.0), PerNode::default());
        assert_eq!(ForcedConvection::default().ambient_conductance(1.0), PerNode::default());
    }
}
