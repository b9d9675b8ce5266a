//! Units in which bench files record a quantity. The conversions come from the crate `units`. This module lists the usual units, which
//! messages name and among which a wrong unit of readings is searched.

use ::units::Refusal;
use physics::declare::Unit;

/// A unit in a file: SI value = factor * reading + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileUnit {
    /// Factor to SI.
    pub factor: f64,
    /// Added after multiplication by the factor.
    pub offset: f64,
}

/// The usual units of a recorded quantity, by its SI unit; the first is that of the column name.
pub const fn names(of: Unit) -> &'static [&'static str] {
    match of {
        Unit::Volt => &["V", "mV", "kV"],
        Unit::Ampere => &["A", "mA", "uA", "kA"],
        Unit::Watt => &["W", "mW", "kW", "hp", "PS"],
        Unit::RadianPerSecond => &["rad/s", "rpm", "krpm", "rev/s", "deg/s"],
        Unit::NewtonMetre => &[
            "N.m", "mN.m", "uN.m", "kN.m", "N.cm", "N.mm", "kgf.m", "kgf.cm", "gf.cm", "ozf.in", "lbf.in",
            "lbf.ft",
        ],
        Unit::Kelvin => &["degC", "K", "degF", "degR"],
        Unit::Pascal => &["Pa", "hPa", "kPa", "MPa", "bar", "atm", "mmHg", "inHg", "psi"],
        Unit::CubicMetrePerSecond => &["m3/s", "l/s", "l/min", "ml/min", "l/h", "m3/h"],
        Unit::Second => &["s", "ms", "us", "min", "h", "d"],
        Unit::One => &["1", "%", "permille"],
        _ => &[],
    }
}

/// The usual units of a quantity, by name.
pub fn units(of: Unit) -> Vec<(&'static str, FileUnit)> {
    names(of).iter().filter_map(|name| Some((*name, by_name(of, name)?))).collect()
}

/// Whether a text is a unit, of this or of another quantity.
pub fn is_unit(of: Unit, name: &str) -> bool {
    !matches!(::units::conversion(usual(of, name), of.name(), false), Err(Refusal::Unknown(_)))
}

/// Common abbreviations in headers that collide with other units: coulomb, farad, temperature difference.
fn usual(of: Unit, name: &str) -> &str {
    match (of, name) {
        (Unit::Kelvin, "C") => "degC",
        (Unit::Kelvin, "F") => "degF",
        (Unit::Kelvin, "R") => "degR",
        (Unit::One, "-") => "1",
        (Unit::RadianPerSecond, "rad_per_s") => "rad/s",
        (_, name) => name,
    }
}

/// The unit with this name if it fits the quantity: any product of units with prefixes, as in datasheets.
pub fn by_name(of: Unit, name: &str) -> Option<FileUnit> {
    let way = ::units::conversion(usual(of, name), of.name(), false).ok().filter(|way| !way.reciprocal)?;
    // Rejects units of another kind, such as a temperature in percent or a time in degC.
    let offset = way.of(0.0);
    Some(FileUnit { factor: way.of(1.0) - offset, offset })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every usual unit exists in the common table of units; the first is that of the column name.
    #[test]
    fn usual_units_are_known() {
        for of in Unit::ALL {
            let all = units(*of);
            assert_eq!(all.len(), names(*of).len(), "{}", of.name());
            assert!(all.first().is_none_or(|(_, first)| first.factor == 1.0), "{}", of.name());
        }
    }

    #[test]
    fn readings_become_si() {
        for (of, name, reading, value) in [
            (Unit::RadianPerSecond, "min^-1", 3000.0, 314.159_265),
            (Unit::RadianPerSecond, "deg/s", 180.0, std::f64::consts::PI),
            (Unit::NewtonMetre, "mN·m", 12.0, 0.012),
            (Unit::NewtonMetre, "ozf.in", 141.611_93, 1.0),
            (Unit::NewtonMetre, "lbf.ft", 0.737_562_15, 1.0),
            (Unit::NewtonMetre, "kgf.cm", 10.197_162, 1.0),
            (Unit::Kelvin, "°F", 212.0, 373.15),
            (Unit::Kelvin, "C", -40.0, 233.15),
            (Unit::Kelvin, "degR", 671.67, 373.15),
            (Unit::Pascal, "psi", 14.695_949, 101_325.0),
            (Unit::Pascal, "inHg", 29.921_26, 101_325.0),
            (Unit::Pascal, "mmHg", 760.0, 101_325.0),
            (Unit::Watt, "hp", 1.0, 745.699_87),
            (Unit::Watt, "PS", 1.0, 735.498_75),
            (Unit::One, "permille", 40.0, 0.04),
            (Unit::Second, "ms", 250.0, 0.25),
        ] {
            let unit = by_name(of, name).unwrap_or_else(|| panic!("{name}"));
            let found = unit.factor * reading + unit.offset;
            assert!((found / value - 1.0).abs() < 1e-6, "{name}: {found} instead of {value}");
        }
        for (of, name) in [(Unit::Kelvin, "rpm"), (Unit::RadianPerSecond, "Hz"), (Unit::Second, "1/s")] {
            assert_eq!(by_name(of, name), None, "{name}");
        }
    }
}
