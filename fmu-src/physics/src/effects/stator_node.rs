//! Stator with its own temperature between winding and housing.
//!
//! C_s dT_s/dt = (T_w - T_s)/R_wh - (T_s - T_h)/R_sh                                        (1)
//!
//! In cooling_mode conductance the stator is in series between winding and housing; in the other modes, which have a
//! stator node, R_sh adds to its contact resistance and C_s to its heat capacity.
//! *Assumes* one temperature for the stator. *Neglects* radial conduction within it.
//! *Sign*: heat flows from the winding through the stator to the housing.
//! *Source*: lumped-parameter network, e.g. Mellor, Roberts, Turner, IEE Proc. B 138 (1991) 205-218.

use super::prelude::*;

variables! {
    /// Stator between winding and housing.
    pub struct StatorNode {
        /// Thermal resistance from stator to housing; 0 switches the effect off
        R_sh: f64 = Variable::tunable(0, 0.0, Unit::KelvinPerWatt, 0.0, 1e3).nominal(0.1),
        /// Heat capacity of the stator; 0 switches the effect off
        C_s: f64 = Variable::tunable(1, 0.0, Unit::JoulePerKelvin, 0.0, 1e6).nominal(50.0),
    }
}

impl Effect for StatorNode {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate { way: Way::Store, ..Candidate::constant(Port::HeatCapacity, &["C_s", "R_sh"]) }];
    const EXAMPLE: &'static [f64] = &[0.3, 40.0];

    #[inline]
    fn is_on(&self) -> bool {
        self.R_sh > 0.0 && self.C_s > 0.0
    }

    #[inline]
    fn stator(&self) -> Stator {
        if self.is_on() { Stator { resistance: self.R_sh, capacity: self.C_s } } else { Stator::from(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn off_unless_it_has_both() {
        assert!(!StatorNode::default().is_on());
        assert!(!StatorNode { R_sh: 0.1, C_s: 0.0 }.is_on());
        assert_eq!(StatorNode { R_sh: 0.1, C_s: 0.0 }.stator(), Stator::from(0.0));
        assert_eq!(StatorNode { R_sh: 0.1, C_s: 50.0 }.stator(), Stator { resistance: 0.1, capacity: 50.0 });
    }
}
