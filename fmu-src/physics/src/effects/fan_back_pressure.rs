//! Flow reduction of a fan by back pressure.
//!
//! n_effective = n (1 - k n)                                                                (1)
//!
//! *Assumes* a flow reduction proportional to the pressure drop of the flow. *Neglects* stall.
//! *Sign*: k > 0 reduces the flow. *Range*: n is limited to 0 ... 1.
//! *Source*: data of the synthetic bench; second-order expansion of a falling fan curve with a rising system curve.

use super::prelude::*;

variables! {
    /// Loss of flow at high command.
    pub struct FanBackPressure {
        /// Fraction of the air flow lost at full command; 0 switches the effect off
        k: f64 = Variable::tunable(0, 0.0, Unit::One, 0.0, 1.0).nominal(0.2),
    }
}

impl Effect for FanBackPressure {
    const CANDIDATES: &'static [Candidate] = &[Candidate::on(Driver::FanCommand, Port::FanFlow, &["k"])];
    const EXAMPLE: &'static [f64] = &[0.3];

    #[inline]
    fn fan_flow(&self, n: f64) -> f64 {
        if self.k == 0.0 {
            return n;
        }
        let n = n.clamp(0.0, 1.0);
        n * (1.0 - self.k * n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 30 % lost at full command, 15 % at half.
    #[test]
    fn loses_in_proportion_to_the_command() {
        let fan = FanBackPressure { k: 0.3 };
        assert_eq!(fan.fan_flow(1.0), 0.7);
        assert!((fan.fan_flow(0.5) - 0.425).abs() < 1e-16);
        assert_eq!(fan.fan_flow(0.0), 0.0);
        assert_eq!((fan.fan_flow(-0.1), fan.fan_flow(1.2)), (0.0, 0.7));
        assert_eq!(FanBackPressure::default().fan_flow(0.37), 0.37);
    }
}
