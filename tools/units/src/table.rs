//! The units that are not products of others, and the prefixes.

use crate::Dimension;

/// A unit: `SI value = number * factor * 10^tens + offset`.
pub(crate) struct Atom {
    pub names: &'static [&'static str],
    pub factor: f64,
    pub tens: i32,
    pub offset: f64,
    pub dimension: Dimension,
    pub prefixed: bool,
}

/// SI prefixes and their powers of ten.
pub(crate) const PREFIXES: [(&str, i32); 8] =
    [("p", -12), ("n", -9), ("u", -6), ("m", -3), ("c", -2), ("k", 3), ("M", 6), ("G", 9)];

/// Standard gravity in m/s2: units of mass that catalogues use for forces.
pub(crate) const GRAVITY: f64 = 9.80665;

const fn dimension(kg: i8, m: i8, s: i8, a: i8, k: i8, rad: i8) -> Dimension {
    Dimension([2 * kg, 2 * m, 2 * s, 2 * a, 2 * k, 2 * rad])
}

const fn si(names: &'static [&'static str], dimension: Dimension) -> Atom {
    Atom { names, factor: 1.0, tens: 0, offset: 0.0, dimension, prefixed: true }
}

const fn other(names: &'static [&'static str], factor: f64, tens: i32, dimension: Dimension) -> Atom {
    Atom { names, factor, tens, offset: 0.0, dimension, prefixed: false }
}

const ONE: Dimension = dimension(0, 0, 0, 0, 0, 0);
pub(crate) const MASS: Dimension = dimension(1, 0, 0, 0, 0, 0);
const LENGTH: Dimension = dimension(0, 1, 0, 0, 0, 0);
const VOLUME: Dimension = dimension(0, 3, 0, 0, 0, 0);
const TIME: Dimension = dimension(0, 0, 1, 0, 0, 0);
const KELVIN: Dimension = dimension(0, 0, 0, 0, 1, 0);
const ANGLE: Dimension = dimension(0, 0, 0, 0, 0, 1);
const SPEED: Dimension = dimension(0, 0, -1, 0, 0, 1);
const FORCE: Dimension = dimension(1, 1, -2, 0, 0, 0);
const PRESSURE: Dimension = dimension(1, -1, -2, 0, 0, 0);
const ENERGY: Dimension = dimension(1, 2, -2, 0, 0, 0);
const POWER: Dimension = dimension(1, 2, -3, 0, 0, 0);
const TAU: f64 = std::f64::consts::TAU;

/// All units. Conversion factors: SI brochure, 9th edition, and NIST SP 811, appendix B.
pub(crate) const ATOMS: &[Atom] = &[
    other(&["1"], 1.0, 0, ONE),
    other(&["%", "percent"], 1.0, -2, ONE),
    other(&["permille", "‰"], 1.0, -3, ONE),
    other(&["ppm"], 1.0, -6, ONE),
    Atom { names: &["g"], factor: 1.0, tens: -3, offset: 0.0, dimension: MASS, prefixed: true },
    other(&["lb", "lbs", "lbm"], 0.453_592_37, 0, MASS),
    other(&["oz"], 0.028_349_523_125, 0, MASS),
    si(&["m"], LENGTH),
    other(&["in", "inch"], 254.0, -4, LENGTH),
    other(&["ft"], 3048.0, -4, LENGTH),
    Atom { names: &["l", "L"], factor: 1.0, tens: -3, offset: 0.0, dimension: VOLUME, prefixed: true },
    si(&["s", "sec"], TIME),
    other(&["min"], 60.0, 0, TIME),
    other(&["h", "hr"], 3600.0, 0, TIME),
    other(&["d", "day"], 86_400.0, 0, TIME),
    si(&["Hz"], dimension(0, 0, -1, 0, 0, 0)),
    si(&["A", "Arms"], dimension(0, 0, 0, 1, 0, 0)),
    si(&["K"], KELVIN),
    other(&["Kelvin"], 1.0, 0, KELVIN),
    other(&["degR", "Rankine"], 5.0 / 9.0, 0, KELVIN),
    Atom {
        names: &["degC", "Celsius"],
        factor: 1.0,
        tens: 0,
        offset: 273.15,
        dimension: KELVIN,
        prefixed: false,
    },
    Atom {
        names: &["degF", "Fahrenheit"],
        factor: 5.0 / 9.0,
        tens: 0,
        offset: 459.67 * 5.0 / 9.0,
        dimension: KELVIN,
        prefixed: false,
    },
    si(&["rad"], ANGLE),
    other(&["deg"], TAU / 360.0, 0, ANGLE),
    other(&["rev", "r", "turn", "U"], TAU, 0, ANGLE),
    other(&["rpm", "RPM"], TAU / 60.0, 0, SPEED),
    other(&["krpm", "kRPM"], TAU / 60.0, 3, SPEED),
    other(&["rps"], TAU, 0, SPEED),
    si(&["V"], dimension(1, 2, -3, -1, 0, 0)),
    si(&["Ohm", "ohm"], dimension(1, 2, -3, -2, 0, 0)),
    si(&["H"], dimension(1, 2, -2, -2, 0, 0)),
    si(&["C"], dimension(0, 0, 1, 1, 0, 0)),
    si(&["T"], dimension(1, 0, -2, -1, 0, 0)),
    si(&["Wb"], dimension(1, 2, -2, -1, 0, 0)),
    si(&["N"], FORCE),
    other(&["lbf"], 4.448_221_615_260_5, 0, FORCE),
    other(&["ozf"], 0.278_013_850_953_781_2, 0, FORCE),
    other(&["kgf", "kp"], GRAVITY, 0, FORCE),
    other(&["gf", "p"], GRAVITY, -3, FORCE),
    si(&["W"], POWER),
    other(&["hp"], 745.699_871_582_270_2, 0, POWER),
    other(&["PS"], 75.0 * GRAVITY, 0, POWER),
    si(&["J"], ENERGY),
    other(&["cal"], 4184.0, -3, ENERGY),
    other(&["kcal"], 4184.0, 0, ENERGY),
    other(&["BTU", "Btu"], 1_055.055_852_62, 0, ENERGY),
    si(&["Pa"], PRESSURE),
    other(&["hPa", "mbar"], 100.0, 0, PRESSURE),
    other(&["bar"], 1.0, 5, PRESSURE),
    other(&["atm"], 101_325.0, 0, PRESSURE),
    other(&["mmHg", "Torr"], 101_325.0 / 760.0, 0, PRESSURE),
    other(&["inHg"], 3_386.389, 0, PRESSURE),
    other(&["psi"], 6_894.757_293_168_361, 0, PRESSURE),
    other(&["mmH2O"], GRAVITY, 0, PRESSURE),
    other(&["inH2O"], 249.088_91, 0, PRESSURE),
    other(&["cfm", "CFM"], 0.000_471_947_443_2, 0, dimension(0, 3, -1, 0, 0, 0)),
];
