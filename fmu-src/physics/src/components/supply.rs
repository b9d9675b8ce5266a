//! Supply of a drive: supply power for the electrical power of the motor.
//!
//! driving      P_supply = standby + P / efficiency                                        (1)
//! braking      P_supply = standby + P efficiency regeneration                             (2)
//!
//! *Assumes* one efficiency for the whole range.
//! *Sign*: P > 0 goes to the motor; P_supply - P is lost in the drive, in either direction.

use declare::{Unit, Variable, enumeration, variables};

enumeration! {
    /// Electrical power of the motor that the drive supplies
    pub enum PowerSource {
        /// Commanded voltage times motor_current: an estimate, for a motor that follows the output voltage
        VoltageCommand = 1, "voltage_command";
        /// The input motor_power, connected to the motor's electrical power: exact in every drive mode of the motor
        MotorPower = 2, "motor_power";
    }
}

variables! {
    /// Power balance of the drive.
    pub struct Supply {
        /// Efficiency of the drive
        efficiency: f64 = Variable::tunable(0, 1.0, Unit::One, 0.05, 1.0)
            .source("neutral: no loss"),
        /// Fraction of a braking motor's power that the drive regenerates, before its losses
        regeneration: f64 = Variable::tunable(1, 1.0, Unit::One, 0.0, 1.0)
            .source("neutral: no loss"),
        /// Standby power of the electronics
        standby_power: f64 = Variable::tunable(2, 0.0, Unit::Watt, 0.0, 1e4),
        /// Electrical power of the motor that the drive supplies
        power_source: PowerSource = Variable::choice(3, 1),
    }
}

impl Supply {
    /// Supply power, W, for the motor's terminal power `power`, W: eqs. (1) and (2).
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
    fn the_drive_has_losses_in_both_directions() {
        let supply = Supply { efficiency: 0.9, regeneration: 0.5, standby_power: 2.0, ..Supply::default() };
        assert_eq!(supply.power(90.0), 102.0);
        assert_eq!(supply.power(-100.0), 2.0 - 45.0);
        assert_eq!(Supply::default().power(-100.0), -100.0);
    }
}
