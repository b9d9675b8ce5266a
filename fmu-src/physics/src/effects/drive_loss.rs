//! Power loss of the drive.
//!
//! Q_w = (1 - share) P,   Q_drive = share P                                                 (1)
//!
//! Acts in drive_mode power, where P is the input `electrical_power`; the drive is thermally separate from the motor, so
//! its heat flows directly to ambient.
//! *Assumes* a fraction that does not depend on the power. *Neglects* the drive's own heat capacity.
//! *Sign*: share > 0 reduces the winding's heat. *Source*: definition of an efficiency.

use super::prelude::*;

variables! {
    /// Loss of the drive.
    pub struct DriveLoss {
        /// Fraction of electrical_power that is lost in the drive; 0 switches the effect off
        share: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 1.0).nominal(0.1),
    }
}

impl Effect for DriveLoss {
    const CANDIDATES: &'static [Candidate] =
        &[Candidate::constant(Port::WindingHeat, &["share"]).of_the_bench()];
    const EXAMPLE: &'static [f64] = &[0.12];

    #[inline]
    fn drive_loss(&self) -> f64 {
        self.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_the_share() {
        assert_eq!(DriveLoss { share: 0.15 }.drive_loss(), 0.15);
        assert_eq!(DriveLoss::default().drive_loss(), 0.0);
    }
}
