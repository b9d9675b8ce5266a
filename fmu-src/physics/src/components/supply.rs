//! The supply of a drive: what it gives for the power at the motor's terminals.
//!
//! driving      P_supply = standby + P / efficiency                                        (1)
//! braking      P_supply = standby + P efficiency regeneration                             (2)
//!
//! *Assumes* one efficiency for the whole range.
//! *Sign*: P > 0 goes to the motor; P_supply - P is lost in the drive, in either direction.

use declare::{Unit, Variable, variables};

variables! {
    /// The drive in front of the motor, as its supply sees it.
    pub struct Supply {
        /// Share of the supply's power that reaches the motor
        efficiency: f64 = Variable::tunable(0, 1.0, Unit::One, 0.05, 1.0)
            .source("neutral: no loss"),
        /// Share of the power of a braking motor that the supply takes back, before the drive's losses
        regeneration: f64 = Variable::tunable(1, 1.0, Unit::One, 0.0, 1.0)
            .source("neutral: no loss"),
        /// Power that the electronics take always
        standby_power: f64 = Variable::tunable(2, 0.0, Unit::Watt, 0.0, 1e4),
    }
}

impl Supply {
    /// Power taken from the supply, W, for `power` at the motor's terminals, W: eqs. (1) and (2).
    #[inline]
    pub fn power(&self, power: f64) -> f64 {
        let passed =
            if power > 0.0 { power / self.efficiency } else { power * self.efficiency * self.regeneration };
        self.standby_power + passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drive_loses_both_ways() {
        let supply = Supply { efficiency: 0.9, regeneration: 0.5, standby_power: 2.0 };
        assert_eq!(supply.power(90.0), 102.0);
        assert_eq!(supply.power(-100.0), 2.0 - 45.0);
        assert_eq!(Supply::default().power(-100.0), -100.0);
    }
}
