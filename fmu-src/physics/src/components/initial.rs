//! Initial temperatures: meaning of the value 0, and values outside the limits of validity.

use super::validity::Limits;
use declare::Unit;

/// Initial temperature of a node, K: `value`, or `otherwise` if `value` is 0 K (not set).
pub fn temperature(value: f64, otherwise: f64) -> f64 {
    if value == 0.0 { otherwise } else { value }
}

/// The first of the initial temperatures, name and K, that is set and outside the limits of validity: one sentence.
pub fn first_outside(limits: &Limits, winding: (&str, f64), others: &[(&str, f64)]) -> Option<String> {
    let others = others.iter().map(|&(name, value)| (name, value, limits.of_other_nodes()));
    let mut all = std::iter::once((winding.0, winding.1, limits.of_winding())).chain(others);
    let is_outside = |value: f64, [low, high]: [f64; 2]| value != 0.0 && !(value > low && value < high);
    all.find(|&(_, value, range)| is_outside(value, range)).map(|(name, value, [low, high])| {
        // The declared limits begin at 0 K, which stands for the ambient temperature: a value in degC is within them.
        let celsius = Unit::Kelvin.celsius_clause(value, [low, high]);
        format!(
            "{name} = {value} K is outside the limits of validity, {low} ... {high} K (parameters validity.*){celsius}; \
             0 K stands for the ambient temperature."
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::validity::Validity;

    #[test]
    fn a_value_outside_is_named_with_its_limits() {
        let limits = Limits::new(Validity::default(), 298.15, 0.0);
        assert_eq!(first_outside(&limits, ("w", 0.0), &[("h", 0.0)]), None, "0 K is the ambient temperature");
        assert_eq!(first_outside(&limits, ("w", 500.0), &[("h", 570.0)]), None);
        let sentence = first_outside(&limits, ("w", 560.0), &[("h", 570.0)]).unwrap();
        assert!(sentence.starts_with("w = 560 K") && sentence.contains("100 ... 543.15 K"), "{sentence}");
        let sentence = first_outside(&limits, ("w", 500.0), &[("b", 400.0), ("h", 99.0)]).unwrap();
        assert!(sentence.starts_with("h = 99 K") && sentence.contains("100 ... 583.15 K"), "{sentence}");
        let celsius =
            |value: f64| first_outside(&limits, ("w", value), &[]).unwrap().contains("degC is within them");
        assert!(celsius(25.0) && !celsius(99.0 - 273.15) && !celsius(560.0));
        // The magnets have no torque above T_ref - 1/alpha_mag.
        let weak = Limits::new(Validity::default(), 298.15, -0.01);
        assert!(first_outside(&weak, ("w", 500.0), &[("h", 400.0)]).unwrap().contains("398.15 K"));
    }
}
