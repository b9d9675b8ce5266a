//! H-bridge with PWM: means over one switching period.
//!
//! The supply is connected for the fraction d (duty) of the period P; the terminal voltage is then V_on = V_s - V_drop. Afterwards the
//! current freewheels through switch and diode against V_off, until the next period begins or the current is zero:
//!
//! ```text
//! on        L di/dt = V_on - e - R i          for d P                                      (1)
//! freewheel L di/dt = -V_off - e - R i        for at most (1 - d) P                        (2)
//! empty     i = 0, terminal voltage e         for the rest of P                            (3)
//! ```
//! With a = exp(-d P R/L), b = exp(-(1 - d) P R/L), I_on = (V_on - e)/R, I_off = -(V_off + e)/R, the periodic
//! solution starts each cycle at
//! ```text
//! i_0 = [I_on (1 - a) b + I_off (1 - b)] / (1 - a b)       continuous conduction, where i_0 > 0    (4)
//! i_0 = 0, freewheel ends after L/R ln(1 - i_peak/I_off)   discontinuous conduction                (5)
//! ```
//! d_2 is the fraction of the period with freewheeling current. The means are
//! ```text
//! V - e = R I = d (V_on - e) - d_2 (V_off + e)                                             (6)
//! q_on  = d I_on - (L/R)(i_peak - i_0)/P,   q_off = d_2 I_off + (L/R)(i_peak - i_0)/P,   I = q_on + q_off   (7)
//! <i^2> = I_on q_on + I_off q_off                                                          (8)
//! ```
//! (6) is the integral of (1) to (3) over a period; (8) is the integral of (1) to (3) times i. The inductance stores no net energy over
//! a period. In continuous conduction d_2 = 1 - d, so (6) is Kirchhoff's law for any mean current, not only for the periodic one. A
//! back-EMF between V_on and V_s + V_f gives zero current; above that, the bridge's diodes rectify: V = V_s + V_f.
//!
//! *Decay*: slow (one switch stays closed): V_off = V_f. Fast (all switches open): V_off = V_s + V_f, and the current
//! flows back into the supply.
//! *Duty 0* (`zero_duty`). Brake: the switches of one side are closed, and the winding is short-circuited through a switch and a
//! diode in either direction: |e| > V_f drives a current against V_f; the supply current is zero. This is the limit of small duties
//! of a bridge whose switches conduct in both directions, and the behaviour of a drive with slow decay at standstill; hence it is the
//! default. Coast: all switches are open.
//! *Assumes* a supply that absorbs regenerated current, e and R constant over a period, drops that do not depend on the
//! current; V_drop is at most V_s. *Neglects* dead time, switching losses, and the bridge's own heat.
//! *Sign*: positive duty is forward; a negative duty is the mirror image.
//! *Range*: any duty from -1 to 1; continuous between (4) and (5), and where the current starts.
//! *Source*: Mohan, Undeland, Robbins, Power Electronics, 3rd ed., sections 7-3 and 13-5, here with the winding resistance.

use crate::number::Number;
use declare::{Unit, Variable, enumeration, variables};

enumeration! {
    /// Path of the freewheeling current.
    pub enum Decay {
        /// Slow decay: through a closed switch and a diode, not through the supply.
        Slow = 1, "slow";
        /// Fast decay: through two diodes into the supply; all switches are open.
        Fast = 2, "fast";
    }
}

enumeration! {
    /// State of the bridge at duty 0.
    pub enum ZeroDuty {
        /// Brake: the bridge short-circuits the winding.
        Brake = 1, "brake";
        /// Coast: all switches are open; no current flows unless the back-EMF exceeds the supply voltage.
        Coast = 2, "coast";
    }
}

variables! {
    /// A drive whose mean voltage is duty times its supply's voltage.
    pub struct Idle {
        /// Bridge at duty 0 (drive_mode pwm)
        zero_duty: ZeroDuty = Variable::choice(0, 1),
    }
}

variables! {
    /// The H-bridge.
    pub struct Drive {
        /// Bridge voltage drop of the two switches that connect the supply
        drop: f64 = Variable::tunable(0, 2.2124, Unit::Volt, 0.0, 100.0)
            .source("paper on the gearmotor 37D: 12 V less the 9.7876 V at 100 % duty"),
        /// Voltage drop of the freewheeling path
        freewheel_drop: f64 = Variable::tunable(1, 1.8, Unit::Volt, 0.0, 100.0)
            .source("estimate: one bipolar switch 1.1 V and a diode 0.7 V"),
        /// Switching frequency
        pwm_frequency: f64 = Variable::tunable(2, 1775.0, Unit::Hertz, 1.0, 1e6).log()
            .source("fitted to the slopes 91.62 mV and 1.04 mA per per cent of the paper on the gearmotor 37D"),
        /// Freewheeling path of the current while the supply is off
        decay: Decay = Variable::choice(3, 1),
        /// Bridge at duty 0
        zero_duty: ZeroDuty = Variable::choice(4, 1),
    }
}

/// Lower limit of the divisor V_on + V_off, V.
const VOLTAGE_SMALL: f64 = 1e-9;

/// The bridge at one instant, in the direction of its duty.
#[derive(Clone, Copy, Debug)]
pub struct Bridge {
    /// 1 forward, -1 reverse.
    direction: f64,
    /// Fraction of the period with the supply connected, 0 to 1.
    duty: f64,
    /// Period, s.
    period: f64,
    /// Voltage of the supply, V.
    supply: f64,
    /// V_on of eq. (1), V.
    on: f64,
    /// V_off of eq. (2), V.
    off: f64,
    /// V_f, V.
    freewheel_drop: f64,
    /// Fraction of the freewheeling current that flows back into the supply.
    returned: f64,
}

/// The periodic cycle at some back-EMF.
#[derive(Clone, Copy, Debug)]
pub struct Cycle<D> {
    /// Mean terminal voltage minus back-EMF, V, which drives the mean current, eq. (6).
    pub drive: D,
    /// Mean square of the current minus the square of its mean, A2.
    pub ripple: f64,
    /// Fraction of the period with nonzero current, 0 to 1.
    pub conducting: f64,
    /// The diodes carry the current into the supply.
    rectifies: bool,
}

/// Relation between supply power and motor power.
#[derive(Clone, Copy, Debug)]
pub struct SupplyPower {
    /// Supply power for each watt of motor power.
    pub per_watt: f64,
    /// Additional supply power for each ampere of mean current, V.
    pub per_ampere: f64,
}

impl Bridge {
    /// A bridge on `supply` volts. `direction` decides at duty 0, where the switches of a slow decay keep their
    /// state; without a direction (0), `zero_duty` selects brake or open.
    #[inline]
    pub fn new(drive: &Drive, duty: f64, direction: f64, supply: f64) -> Bridge {
        // Extrapolation of an input may exceed its limits between two communication points.
        let brakes = direction == 0.0 && drive.zero_duty == ZeroDuty::Brake;
        // A short-circuited winding corresponds to a supply of 0 V, without power flow.
        let supply = if brakes { 0.0 } else { supply.max(0.0) };
        let open = !brakes && (drive.decay == Decay::Fast || direction == 0.0);
        let sign = if direction < 0.0 { -1.0 } else { 1.0 };
        Bridge {
            direction: sign,
            duty: (duty * sign).clamp(0.0, 1.0),
            period: 1.0 / drive.pwm_frequency,
            supply,
            on: (supply - drive.drop).max(0.0),
            off: drive.freewheel_drop + if open { supply } else { 0.0 },
            freewheel_drop: drive.freewheel_drop,
            returned: f64::from(u8::from(open)),
        }
    }

    /// The periodic cycle at the back-EMF `e`, V, of a winding with resistance `r`, Ohm, and inductance `l`, H.
    #[inline]
    pub fn cycle<D: Number>(&self, e: D, r: f64, l: f64) -> Cycle<D> {
        let none = Cycle { drive: D::from(0.0), ripple: 0.0, conducting: 0.0, rectifies: false };
        let e = e * self.direction;
        if e.re() >= self.on {
            let beyond = e - (self.supply + self.freewheel_drop);
            if beyond.re() <= 0.0 {
                return none;
            }
            return Cycle { drive: -beyond * self.direction, conducting: 1.0, rectifies: true, ..none };
        }
        // Times relative to L/R.
        let period = self.period * r / l;
        let (t_on, t_off) = (self.duty * period, (1.0 - self.duty) * period);
        let (rises, falls) = (-(-t_on).exp_m1(), -(-t_off).exp_m1());
        let (i_on, i_off) = ((-e + self.on) / r, -(e + self.off) / r);
        let carried = i_on * (rises * (1.0 - falls)) + i_off * falls;
        let (start, peak, freewheel) = if carried.re() > 0.0 {
            let start = carried / (rises + falls - rises * falls);
            (start, i_on * rises + start * (1.0 - rises), D::from(1.0 - self.duty))
        } else if rises == 0.0 {
            return none;
        } else {
            let peak = i_on * rises;
            (D::from(0.0), peak, (peak / -i_off).ln_1p() / period)
        };
        let drive = (i_on * self.duty + i_off * freewheel) * r;
        let kept = (peak.re() - start.re()) / period;
        let (q_on, q_off) = (i_on.re() * self.duty - kept, i_off.re() * freewheel.re() + kept);
        let mean = drive.re() / r;
        Cycle {
            drive: drive * self.direction,
            ripple: (i_on.re() * q_on + i_off.re() * q_off - mean * mean).max(0.0),
            conducting: self.duty + freewheel.re(),
            rectifies: false,
        }
    }

    /// Current from the supply during the on-time, for motor `power` in W at the mean current `i`: eq. (7) in the periodic solution;
    /// otherwise the fraction that closes the energy balance. Forward is positive.
    fn through_supply(&self, power: f64, i: f64) -> f64 {
        (power + self.off * i * self.direction) / (self.on + self.off).max(VOLTAGE_SMALL)
    }

    /// Supply power as a function of motor power and mean current.
    #[inline]
    pub fn supply_power<D>(&self, cycle: &Cycle<D>) -> SupplyPower {
        if cycle.rectifies {
            return SupplyPower { per_watt: 0.0, per_ampere: self.supply * self.direction };
        }
        let both = self.supply * (1.0 + self.returned);
        let share = both / (self.on + self.off).max(VOLTAGE_SMALL);
        let per_ampere = (share * self.off - self.supply * self.returned) * self.direction;
        SupplyPower { per_watt: share, per_ampere }
    }

    /// Power lost in switches and diodes, W, with the motor taking `power` watts at the mean current `i`.
    #[inline]
    pub fn loss<D>(&self, cycle: &Cycle<D>, power: f64, i: f64) -> f64 {
        let i_forward = i * self.direction;
        if cycle.rectifies {
            return -self.freewheel_drop * i_forward;
        }
        let q_on = self.through_supply(power, i);
        (self.supply - self.on) * q_on + self.freewheel_drop * (i_forward - q_on)
    }
}

#[cfg(test)]
#[path = "chopper_tests.rs"]
mod tests;
