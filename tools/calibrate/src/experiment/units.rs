//! Units in which bench files record a quantity, and their conversion to SI.
//!
//! SI value = factor * reading + offset                                                            (1)
//!
//! *Sources*: BIPM, The International System of Units, 9th ed. (2019); NIST SP 811 (2008), appendix B, for the units outside SI.

use physics::declare::Unit;
use std::f64::consts::PI;

/// A unit of a file by (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileUnit {
    /// Its names; the first is that of messages.
    pub names: &'static [&'static str],
    /// Factor to SI.
    pub factor: f64,
    /// Added after the factor.
    pub offset: f64,
}

const fn scaled(names: &'static [&'static str], factor: f64) -> FileUnit {
    FileUnit { names, factor, offset: 0.0 }
}

const fn shifted(names: &'static [&'static str], factor: f64, offset: f64) -> FileUnit {
    FileUnit { names, factor, offset }
}

const G: f64 = 9.806_65;
const POUND: f64 = 0.453_592_37 * G;
const INCH: f64 = 0.0254;
const TURN: f64 = 2.0 * PI;

/// The units of a quantity that a bench records, by its SI unit.
pub const fn units(of: Unit) -> &'static [FileUnit] {
    const VOLT: &[FileUnit] = &[scaled(&["V"], 1.0), scaled(&["mV"], 1e-3), scaled(&["kV"], 1e3)];
    const AMPERE: &[FileUnit] =
        &[scaled(&["A"], 1.0), scaled(&["mA"], 1e-3), scaled(&["uA"], 1e-6), scaled(&["kA"], 1e3)];
    const WATT: &[FileUnit] = &[
        scaled(&["W"], 1.0),
        scaled(&["mW"], 1e-3),
        scaled(&["kW"], 1e3),
        scaled(&["hp"], 550.0 * POUND * 12.0 * INCH),
        scaled(&["PS"], 75.0 * G),
    ];
    const SPEED: &[FileUnit] = &[
        scaled(&["rad/s", "rad_per_s"], 1.0),
        scaled(&["rpm", "1/min", "min-1", "r/min", "rev/min", "U/min"], TURN / 60.0),
        scaled(&["krpm"], 1e3 * TURN / 60.0),
        scaled(&["rev/s", "rps", "1/s", "Hz", "r/s"], TURN),
        scaled(&["deg/s", "°/s"], PI / 180.0),
    ];
    const TORQUE: &[FileUnit] = &[
        scaled(&["N.m", "Nm"], 1.0),
        scaled(&["mN.m", "mNm"], 1e-3),
        scaled(&["uN.m", "uNm"], 1e-6),
        scaled(&["kN.m", "kNm"], 1e3),
        scaled(&["N.cm", "Ncm"], 1e-2),
        scaled(&["N.mm", "Nmm"], 1e-3),
        scaled(&["kgf.m", "kgm", "kpm"], G),
        scaled(&["kgf.cm", "kgcm"], 1e-2 * G),
        scaled(&["gf.cm", "gcm"], 1e-5 * G),
        scaled(&["ozf.in", "ozin"], POUND / 16.0 * INCH),
        scaled(&["lbf.in", "lbin"], POUND * INCH),
        scaled(&["lbf.ft", "lbft", "ft.lbf"], POUND * 12.0 * INCH),
    ];
    const TEMPERATURE: &[FileUnit] = &[
        shifted(&["degC", "°C", "C", "Celsius"], 1.0, 273.15),
        scaled(&["K", "Kelvin"], 1.0),
        shifted(&["degF", "°F", "F", "Fahrenheit"], 5.0 / 9.0, 459.67 * 5.0 / 9.0),
        scaled(&["degR", "°R", "R", "Rankine"], 5.0 / 9.0),
    ];
    const PRESSURE: &[FileUnit] = &[
        scaled(&["Pa"], 1.0),
        scaled(&["hPa", "mbar"], 1e2),
        scaled(&["kPa"], 1e3),
        scaled(&["MPa"], 1e6),
        scaled(&["bar"], 1e5),
        scaled(&["atm"], 101_325.0),
        scaled(&["mmHg", "Torr"], 101_325.0 / 760.0),
        scaled(&["inHg"], 3_386.389),
        scaled(&["psi"], POUND / (INCH * INCH)),
    ];
    const ONE: &[FileUnit] =
        &[scaled(&["1", "-"], 1.0), scaled(&["%", "percent"], 1e-2), scaled(&["permille", "‰"], 1e-3)];
    const TIME: &[FileUnit] = &[
        scaled(&["s", "sec"], 1.0),
        scaled(&["ms"], 1e-3),
        scaled(&["us"], 1e-6),
        scaled(&["min"], 60.0),
        scaled(&["h", "hr"], 3600.0),
        scaled(&["d", "day"], 86_400.0),
    ];
    match of {
        Unit::Volt => VOLT,
        Unit::Ampere => AMPERE,
        Unit::Watt => WATT,
        Unit::RadianPerSecond => SPEED,
        Unit::NewtonMetre => TORQUE,
        Unit::Kelvin => TEMPERATURE,
        Unit::Pascal => PRESSURE,
        Unit::Second => TIME,
        Unit::One => ONE,
        _ => &[],
    }
}

/// The unit of this name, however its product sign and micro sign are written; upper and lower case differ, as mN.m and MN.m do,
/// unless only one unit fits.
pub fn by_name(of: Unit, name: &str) -> Option<&'static FileUnit> {
    let plain = |text: &str| -> String {
        let sign = |c: char| match c {
            'µ' | 'μ' => Some('u'),
            '.' | '·' | '*' | '^' | ' ' | '⋅' => None,
            other => Some(other),
        };
        text.chars().filter_map(sign).collect()
    };
    let wanted = plain(name);
    let find = |same: &dyn Fn(&str, &str) -> bool| -> Vec<&'static FileUnit> {
        units(of).iter().filter(|u| u.names.iter().any(|n| same(&plain(n), &wanted))).collect()
    };
    let exact = find(&|a, b| a == b);
    let near = if exact.is_empty() { find(&|a, b| a.eq_ignore_ascii_case(b)) } else { exact };
    if let [one] = near[..] { Some(one) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(of: Unit, name: &str, reading: f64) -> f64 {
        let unit = by_name(of, name).unwrap_or_else(|| panic!("{name}"));
        unit.factor * reading + unit.offset
    }

    #[test]
    fn readings_become_si() {
        for (of, name, reading, value) in [
            (Unit::RadianPerSecond, "rpm", 3000.0, 314.159_265),
            (Unit::RadianPerSecond, "min^-1", 3000.0, 314.159_265),
            (Unit::RadianPerSecond, "deg/s", 180.0, PI),
            (Unit::NewtonMetre, "mN·m", 12.0, 0.012),
            (Unit::NewtonMetre, "ozf.in", 141.611_93, 1.0),
            (Unit::NewtonMetre, "lbf.ft", 0.737_562_15, 1.0),
            (Unit::NewtonMetre, "kgf.cm", 10.197_162, 1.0),
            (Unit::Kelvin, "°F", 212.0, 373.15),
            (Unit::Kelvin, "degC", -40.0, 233.15),
            (Unit::Kelvin, "K", 300.0, 300.0),
            (Unit::Pascal, "psi", 14.695_949, 101_325.0),
            (Unit::Pascal, "inHg", 29.921_26, 101_325.0),
            (Unit::Watt, "hp", 1.0, 745.699_87),
            (Unit::Watt, "PS", 1.0, 735.498_75),
            (Unit::One, "%", 40.0, 0.4),
            (Unit::Second, "ms", 250.0, 0.25),
            (Unit::Volt, "MV", 5.0, 0.005),
        ] {
            let found = si(of, name, reading);
            assert!((found / value - 1.0).abs() < 1e-6, "{name}: {found} instead of {value}");
        }
        assert_eq!(by_name(Unit::Kelvin, "rpm"), None);
    }

    /// A name means one unit of a quantity.
    #[test]
    fn no_name_stands_twice() {
        for of in Unit::ALL {
            let names: Vec<&&str> = units(*of).iter().flat_map(|u| u.names).collect();
            for (k, name) in names.iter().enumerate() {
                assert!(!names[..k].contains(name), "{name}");
                assert!(by_name(*of, name).is_some_and(|u| u.names.contains(name)), "{name}");
            }
        }
    }
}
