//! Limits of validity of a motor's equations.
//!
//! winding  T_hot <= winding_temperature: the enamel fails, and R(T) of an intact winding no longer holds          (1)
//! magnets  T_m <= magnet_temperature, and T_m < T_ref - 1/alpha_mag, where the linear k_t(T_m) is zero            (2)
//! cold     winding and magnets above lowest_temperature: below it R(T) of copper is nonlinear                     (3)
//!
//! thermal.T_w_max is the manufacturer's limit; it sets over_temperature and does not end the simulation. At the limits here the
//! equations no longer hold and the simulation ends: thermal runaway, fan failure, a communication step of hours at stall.
//! *Assumes* that the extreme temperature decides: no time at temperature, no partial failure.
//! *Sign*: [`Limits::excess`] is positive outside. *Range*: limits that T_w_max and the ambient temperature do not reach.
//! *Source*: (1) cut-through test of polyester enamel, class 155, at 270 degC: IEC 60317-3:2004+A1:2010, clause 10. (2) Curie
//! temperature of Nd-Fe-B, 310 degC (data sheets of sintered grades), of ferrite, 450 degC. (3) Matula, J. Phys. Chem. Ref.
//! Data 8 (1979) 1147: resistivity of copper is linear in temperature above about 100 K.

use declare::{Unit, Variable, variables};

variables! {
    /// Limits of validity.
    pub struct Validity {
        /// Temperature of the hottest phase of the winding at which the simulation ends
        winding_temperature: f64 = Variable::tunable(0, 543.15, Unit::Kelvin, 373.15, 1273.15)
            .source("IEC 60317-3 (polyester enamel, class 155): cut-through test at 270 degC"),
        /// Temperature of the magnets at which the simulation ends; it also ends where the torque constant falls to 0
        magnet_temperature: f64 = Variable::tunable(1, 583.15, Unit::Kelvin, 373.15, 1273.15)
            .source("Curie temperature of Nd-Fe-B, 310 degC"),
        /// Temperature of the winding or the magnets below which the simulation ends
        lowest_temperature: f64 = Variable::tunable(2, 100.0, Unit::Kelvin, 1.0, 173.15)
            .source("Matula (1979): resistivity of copper linear above 100 K"),
    }
}

variables! {
    /// Limits of validity of a brushed motor with ferrite magnets.
    pub struct BrushedValidity {
        /// Temperature of the winding at which the simulation ends
        winding_temperature: f64 = Variable::tunable(0, 543.15, Unit::Kelvin, 373.15, 1273.15)
            .source("estimate: polyester enamel, IEC 60317-3: cut-through test at 270 degC"),
        /// Temperature of the magnets at which the simulation ends; it also ends where the torque constant falls to 0
        magnet_temperature: f64 = Variable::tunable(1, 723.15, Unit::Kelvin, 373.15, 1273.15)
            .source("estimate: ferrite magnets, Curie temperature 450 degC"),
        /// Temperature of the winding or the magnets below which the simulation ends
        lowest_temperature: f64 = Variable::tunable(2, 100.0, Unit::Kelvin, 1.0, 173.15)
            .source("Matula (1979): resistivity of copper linear above 100 K"),
    }
}

impl From<BrushedValidity> for Validity {
    fn from(brushed: BrushedValidity) -> Validity {
        let BrushedValidity { winding_temperature, magnet_temperature, lowest_temperature } = brushed;
        Validity { winding_temperature, magnet_temperature, lowest_temperature }
    }
}

/// Limits of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    validity: Validity,
    /// Temperature of the magnets at which the linear law gives zero torque constant, K; infinite if k_t does not fall.
    no_torque: f64,
}

/// Temperatures that are limited, K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Hottest phase of the winding.
    pub winding: f64,
    /// Magnets.
    pub magnets: f64,
    /// Lowest temperature of winding and magnets.
    pub lowest: f64,
}

impl Limits {
    /// The limits of a motor whose torque constant is linear about `t_ref`, K, by `alpha_mag`, 1/K.
    pub fn new(validity: Validity, t_ref: f64, alpha_mag: f64) -> Limits {
        let no_torque = if alpha_mag < 0.0 { t_ref - 1.0 / alpha_mag } else { f64::INFINITY };
        Limits { validity, no_torque }
    }

    /// Lowest and highest temperature of the winding, K.
    pub fn of_winding(&self) -> [f64; 2] {
        [self.validity.lowest_temperature, self.validity.winding_temperature]
    }

    /// Lowest and highest temperature of the other nodes, K; the magnets may be at any of them.
    pub fn of_other_nodes(&self) -> [f64; 2] {
        [self.validity.lowest_temperature, self.validity.magnet_temperature.min(self.no_torque)]
    }

    /// Largest excess of a temperature over its limit, K; negative within all limits.
    #[inline]
    pub fn excess(&self, at: &Extremes) -> f64 {
        let v = &self.validity;
        let hot =
            (at.winding - v.winding_temperature).max(at.magnets - v.magnet_temperature.min(self.no_torque));
        hot.max(v.lowest_temperature - at.lowest)
    }

    /// Whether a temperature is outside its limits or not a number.
    #[inline]
    pub fn are_passed(&self, at: &Extremes) -> bool {
        let v = &self.validity;
        // A torque constant of zero is outside. Comparisons with NaN are false.
        !(at.winding < v.winding_temperature
            && at.magnets < v.magnet_temperature
            && at.magnets < self.no_torque
            && at.lowest > v.lowest_temperature)
    }

    /// The limit that is exceeded most, or is nearest.
    fn nearest(&self, at: &Extremes) -> Nearest {
        let v = &self.validity;
        let hot = |what, value, limit, name| Nearest {
            what: What::Hot(what, name),
            value,
            limit,
            excess: value - limit,
        };
        let winding = "hottest phase of the winding";
        let winding = hot(winding, at.winding, v.winding_temperature, "validity.winding_temperature");
        let magnets = "temperature of the magnets";
        let magnets = hot(magnets, at.magnets, v.magnet_temperature, "validity.magnet_temperature");
        let mut nearest = if winding.excess >= magnets.excess { winding } else { magnets };
        for (what, value, limit, excess) in [
            (What::NoTorque, at.magnets, self.no_torque, at.magnets - self.no_torque),
            (What::Lowest, at.lowest, v.lowest_temperature, v.lowest_temperature - at.lowest),
        ] {
            if excess >= nearest.excess {
                nearest = Nearest { what, value, limit, excess };
            }
        }
        nearest
    }

    /// The nearest limit and the cause, for a search of a steady state: time and heat flows are those of an iterate and say nothing.
    pub fn passed(&self, at: &Extremes) -> String {
        let Nearest { what, limit, .. } = self.nearest(at);
        let celsius = limit - 273.15;
        match what {
            What::Hot(what, name) => format!(
                "the {what} passes its limit of validity, {name} = {limit} K ({celsius:.1} degC): overload or thermal runaway"
            ),
            What::NoTorque => format!(
                "the temperature of the magnets passes that at which motor.alpha_mag makes the torque constant 0, {limit} K \
                 ({celsius:.1} degC): overload or thermal runaway"
            ),
            What::Lowest => format!(
                "the lowest temperature of winding and magnets passes its limit of validity, validity.lowest_temperature = {limit} K \
                 ({celsius:.1} degC): heat is taken out by an input"
            ),
        }
    }

    /// Report on the nearest limit at `time`, s, with `losses` and the heat flow `cooling` out of the motor, W: one
    /// sentence.
    pub fn sentence(&self, at: &Extremes, time: f64, [losses, cooling]: [f64; 2]) -> String {
        let Nearest { what, value, limit, excess } = self.nearest(at);
        let (celsius, verb) = (value - 273.15, verb(excess));
        let heating = format!(
            "losses are {losses:.1} W and cooling removes {cooling:.1} W at this instant (overload or thermal runaway)"
        );
        let passing = match what {
            What::Hot(what, name) => format!(
                "{what}, {value:.1} K ({celsius:.1} degC), {verb} its limit of validity, {name} = {limit} K; {heating}"
            ),
            What::NoTorque => format!(
                "temperature of the magnets, {value:.1} K ({celsius:.1} degC), {verb} {limit:.1} K, where the torque constant falls \
                 to 0 by motor.alpha_mag; {heating}"
            ),
            What::Lowest => format!(
                "lowest temperature of winding and magnets, {value:.1} K, {verb} its limit of validity, validity.lowest_temperature = \
                 {limit} K; heat is taken out by an input"
            ),
        };
        format!("The simulation ends at {time:.6} s: the {passing}.")
    }
}

/// What a limit is of.
enum What {
    /// The hottest phase or the magnets: description, and the parameter with the limit.
    Hot(&'static str, &'static str),
    /// The magnets, without which there is no torque.
    NoTorque,
    /// The lowest temperature of winding and magnets.
    Lowest,
}

/// A temperature at its limit, K.
struct Nearest {
    what: What,
    value: f64,
    limit: f64,
    excess: f64,
}

/// What a temperature does at a limit that it exceeds by so many kelvin. A step that would pass the limit may end before it.
fn verb(excess: f64) -> &'static str {
    match excess {
        e if e > 0.1 => "exceeds",
        e if e < -0.1 => "would pass within the next step",
        _ => "reaches",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILD: Extremes = Extremes { winding: 400.0, magnets: 350.0, lowest: 350.0 };

    #[test]
    fn each_limit_counts() {
        let limits = Limits::new(Validity::default(), 298.15, -0.0012);
        assert!(!limits.are_passed(&MILD) && limits.excess(&MILD) < 0.0);
        for (at, word) in [
            (Extremes { winding: 543.15, ..MILD }, "validity.winding_temperature = 543.15 K"),
            (Extremes { magnets: 600.0, ..MILD }, "validity.magnet_temperature = 583.15 K"),
            (Extremes { lowest: 90.0, ..MILD }, "validity.lowest_temperature = 100 K"),
        ] {
            assert!(limits.are_passed(&at), "{at:?}");
            let sentence = limits.sentence(&at, 12.5, [183.0, 121.0]);
            assert!(sentence.contains(word) && sentence.contains("12.5"), "{sentence}");
            let passed = limits.passed(&at);
            let of_an_instant = |unit: &str| passed.contains(unit);
            assert!(
                passed.contains(word) && ![" s:", " W ", "12.5"].into_iter().any(of_an_instant),
                "{passed}"
            );
        }
        assert!(limits.are_passed(&Extremes { winding: f64::NAN, ..MILD }));
    }

    /// 1/0.004 K above 25 degC the linear law gives zero torque constant, below the Curie temperature.
    #[test]
    fn the_torque_constant_stays_positive() {
        let limits = Limits::new(Validity::default(), 298.15, -0.004);
        let at = |magnets: f64| Extremes { magnets, ..MILD };
        assert!(!limits.are_passed(&at(548.0)) && limits.are_passed(&at(548.15)));
        let sentence = limits.sentence(&at(548.15), 1.0, [2.0, 1.0]);
        assert!(sentence.contains("torque constant falls to 0"), "{sentence}");
        let passed = limits.passed(&at(548.15));
        assert!(passed.contains("torque constant 0, 548.15 K (275.0 degC): overload"), "{passed}");
        assert!(!Limits::new(Validity::default(), 298.15, 0.0).are_passed(&at(580.0)));
    }

    /// A value below a limit has not reached it, one above exceeds it.
    #[test]
    fn the_verb_follows_from_the_value() {
        let limits = Limits::new(Validity::default(), 298.15, -0.0012);
        for (winding, verb) in
            [(540.0, "would pass within the next step"), (543.15, "reaches"), (748.9, "exceeds")]
        {
            let sentence = limits.sentence(&Extremes { winding, ..MILD }, 1.0, [1.0, 1.0]);
            assert!(sentence.contains(&format!("degC), {verb} its limit")), "{sentence}");
        }
    }
}
