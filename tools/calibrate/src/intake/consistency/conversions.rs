//! Conversions of a column that its recording may lack: units, signs, powers of ten.

use crate::comparison::digits;
use crate::experiment::CELSIUS;
use crate::experiment::units::{names, units};
use crate::levels::{FACTOR, SMALL};
use physics::declare::Unit;

/// Two units with factors or offsets that differ by less are the same. Numerical: rounding of the factors.
const SAME: f64 = 1e-3;

/// The conversion by -1, in words.
pub const SIGN: &str = "the opposite sign";
/// Words of a quantity that was recorded on the other side of a transmission.
pub const OTHER_SIDE: &str = " side of ";
/// Degrees Fahrenheit in a kelvin. Definition: of the degree; t degC are 1.8 t + 32 of them.
const FAHRENHEIT: f64 = 1.8;
/// Resistance of a platinum thermometer at 0 degC, Ohm, and its change per kelvin. Definition: IEC 60751, Pt100.
const PT100: (f64, f64) = (100.0, 0.385);

/// Minutes in a radian per second. Definition: 60 s / 2 pi.
const TURNS: f64 = 30.0 / std::f64::consts::PI;

/// Types of thermocouples with their voltage at 100 degC against 0 degC, mV. Source: IEC 60584-1, tables of the types.
const TYPES: [(char, f64); 7] =
    [('E', 6.319), ('J', 5.269), ('T', 4.279), ('K', 4.096), ('N', 2.774), ('R', 0.647), ('S', 0.646)];

/// Ratio by which the rise over the cold junction is too large for a thermocouple at an input that is set to a type of less voltage, with a
/// description of the readings. One of more voltage reads too little, as a stem loss does.
pub fn type_mistakes() -> Vec<(f64, String)> {
    let pairs = TYPES.iter().flat_map(|wire| TYPES.iter().map(move |input| (wire, input)));
    let all = pairs.map(|((wire, own), (input, set))| (own / set, wire, input));
    all.filter(|(ratio, ..)| *ratio > 1.0 + SMALL)
        .map(|(ratio, wire, input)| {
            let words =
                format!("rises over ambient divided by {ratio:.3} (thermocouple of type {wire}, input set to type {input})");
            (ratio, words)
        })
        .collect()
}

/// Factor and offset in SI units of all unit mistakes for a quantity, with a description of the readings.
pub fn unit_mistakes(of: Unit) -> Vec<(f64, f64, String)> {
    let mut all: Vec<(f64, f64, String)> = Vec::new();
    let contract = |name: &str| match of {
        Unit::Kelvin => name == "degC",
        _ => names(of).first() == Some(&name),
    };
    let mut add = |factor: f64, offset: f64, words: String| {
        let same =
            |(a, b, _): &&(f64, f64, String)| (a / factor - 1.0).abs() < SAME && (b - offset).abs() < SAME;
        if !((factor - 1.0).abs() < SAME && offset.abs() < SAME) && all.iter().find(same).is_none() {
            all.push((factor, offset, words));
        }
    };
    let known = units(of);
    if known.is_empty() {
        return all;
    }
    add(-1.0, if of == Unit::Kelvin { 2.0 * CELSIUS } else { 0.0 }, SIGN.to_string());
    // Mistakes from the contract's own unit come first: their description is the simplest.
    let pairs = || known.iter().flat_map(|stated| known.iter().map(move |meant| (stated, meant)));
    for plain in [true, false] {
        for ((as_stated, stated), (as_meant, meant)) in pairs().filter(|(s, _)| contract(s.0) == plain) {
            let factor = meant.factor / stated.factor;
            // Two units of which neither is that of the column are no explanation of what a missing effect may do.
            if !plain && (1.0 / FACTOR..=FACTOR).contains(&factor) && of != Unit::Kelvin {
                continue;
            }
            let words = if plain {
                format!("readings in {as_meant}")
            } else {
                format!("readings times {} (as of {as_meant} and {as_stated})", digits(factor))
            };
            add(factor, meant.offset - factor * stated.offset, words);
        }
    }
    if of == Unit::NewtonMetre {
        // P = 2 pi / 60 n M with the speed in 1/min, as in tables of machines.
        for factor in [TURNS, 1.0 / TURNS] {
            add(factor, 0.0, format!("readings times {factor:.4} (the factor 9.549 between N.m and W min)"));
        }
    }
    if of == Unit::Kelvin {
        let mut in_degrees = |factor: f64, offset: f64, words: &str| {
            add(factor, CELSIUS + factor * (offset - CELSIUS), words.to_string());
        };
        in_degrees(FAHRENHEIT, 0.0, "readings times 1.8 (as of degF without the 32)");
        in_degrees(1.0 / FAHRENHEIT, 0.0, "readings divided by 1.8 (as of degF without the 32)");
        in_degrees(1.0 / PT100.1, -PT100.0, "readings in Ohm of a Pt100");
    }
    let powers: &[i32] =
        if of == Unit::Kelvin { &[-1, 1] } else { &[-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6] };
    for &power in powers {
        let factor = 10f64.powi(power);
        let offset = if of == Unit::Kelvin { CELSIUS * (1.0 - factor) } else { 0.0 };
        add(factor, offset, format!("readings times 1e{power}"));
    }
    if matches!(of, Unit::Volt | Unit::Ampere) {
        // Amplitude, root mean square and peak to peak; line and phase.
        for factor in [2f64.sqrt(), 3f64.sqrt(), 2.0, 8f64.sqrt(), 1.5, 6f64.sqrt()] {
            for factor in [factor, 1.0 / factor] {
                add(
                    factor,
                    0.0,
                    format!("readings times {factor:.4} (amplitude, root mean square; line, phase)"),
                );
            }
        }
    }
    if of == Unit::RadianPerSecond {
        // Electrical and mechanical speed of a motor with pole pairs.
        (2..=16).for_each(|pairs| add(1.0 / f64::from(pairs), 0.0, format!("speeds of {pairs} pole pairs")));
        (2..=16).for_each(|pairs| {
            add(
                f64::from(pairs),
                0.0,
                format!("speeds times {pairs} (divided by the pole pairs once too often)"),
            )
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mistake of two units that are not the column's has to be larger than a missing effect; one of the column's own unit need not.
    #[test]
    fn foreign_units_explain_no_missing_effect() {
        for unit in [Unit::NewtonMetre, Unit::RadianPerSecond, Unit::Ampere, Unit::Volt] {
            let foreign = unit_mistakes(unit).into_iter().filter(|(_, _, words)| words.contains("(as of"));
            let small: Vec<_> = foreign.filter(|(k, ..)| (1.0 / FACTOR..=FACTOR).contains(k)).collect();
            assert!(small.is_empty(), "{small:?}");
        }
        let torque = unit_mistakes(Unit::NewtonMetre);
        let has = |factor: f64| torque.iter().any(|(k, ..)| (k / factor - 1.0).abs() < 1e-3);
        assert!(has(1.355_818) && !has(1.0 / 1.355_818) && !has(0.7062));
        assert!(torque.iter().any(|(.., words)| words.contains("(as of")));
    }
}
