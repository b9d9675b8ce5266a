//! Losses in the stator instead of the winding, as a fraction of the electrical power.
//!
//! Q_w = (1 - fraction) P_m,   Q_s = fraction P_m                                           (1)
//!
//! Acts in drive_mode power, where P_m is the part of the input `electrical_power` that heats the motor. Q_s heats the stator; in
//! cooling_mode conductance it heats the housing, which includes the stator. With an imposed current the effects at the port
//! drag_torque include the iron loss (`iron_loss`).
//! *Assumes* a fraction that does not depend on the power: iron and copper losses are proportional.
//! *Neglects* the dependence of this fraction on speed. *Sign*: fraction > 0 reduces the winding's heat.
//! *Range*: 0 to 1. *Source*: separation of losses, IEC 60034-2-1:2014.

use super::prelude::*;

variables! {
    /// Losses in the stator.
    pub struct StatorLoss {
        /// Fraction of the motor's electrical power that heats the stator or housing; 0 switches the effect off
        fraction: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 1.0).nominal(0.1),
    }
}

impl Effect for StatorLoss {
    const CANDIDATES: &'static [Candidate] = &[Candidate::constant(Port::HousingHeat, &["fraction"])];
    const EXAMPLE: &'static [f64] = &[0.25];

    #[inline]
    fn stator_loss(&self) -> f64 {
        self.fraction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fraction_is_the_fraction() {
        assert_eq!(StatorLoss { fraction: 0.3 }.stator_loss(), 0.3);
        assert_eq!(StatorLoss::default().stator_loss(), 0.0);
    }
}
