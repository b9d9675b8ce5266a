//! Units as people and datasheets write them (`mH`, `g.cm2`, `mNm/A`, `rpm/V`, `degC`, `oz-in`, `min⁻¹`), converted by their dimension.
//!
//! A text that can be read in several ways is read as the dimension of the quantity requires: `kg.cm` is a torque where a torque is
//! expected, `min-1` a speed of rotation where a speed is expected. A text with two possible values is refused.

mod parse;
mod table;

use parse::{Reading, readings};

/// Exponents of kg, m, s, A, K and rad, in halves: exponents such as 0.5 are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dimension(pub [i8; 6]);

const ANGLE: usize = 5;

impl Dimension {
    fn plus(self, other: Dimension, times: i8) -> Dimension {
        Dimension(std::array::from_fn(|k| self.0[k].saturating_add(other.0[k].saturating_mul(times))))
    }

    fn power(self, halves: i8) -> Option<Dimension> {
        let mut found = [0; 6];
        for (to, from) in found.iter_mut().zip(self.0) {
            let whole = i16::from(from) * i16::from(halves);
            *to = i8::try_from(whole / 2).ok().filter(|_| whole % 2 == 0)?;
        }
        Some(Dimension(found))
    }

    fn without_angle(mut self) -> Dimension {
        self.0[ANGLE] = 0;
        self
    }

    /// How far this is from a wanted dimension: 0 where equal, 1 where only a radian is left out, as in N.m.s for N.m.s/rad. Speeds
    /// and frequencies differ by 2 pi, so that nothing is left out there.
    fn distance(self, wanted: Dimension) -> Option<u32> {
        if self == wanted {
            return Some(0);
        }
        let mass = self.0[0] != 0;
        let one_without = self.0[ANGLE] == 0 || wanted.0[ANGLE] == 0;
        (mass && one_without && self.without_angle() == wanted.without_angle()).then_some(1)
    }
}

/// A conversion from one unit to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    from: Reading,
    to: Reading,
    relative: bool,
    /// Whether the unit is of the reciprocal quantity: rpm/V for a torque constant, K/W for a conductance.
    pub reciprocal: bool,
}

impl Conversion {
    /// The value in the second unit.
    pub fn of(&self, value: f64) -> f64 {
        if self.from == self.to && !self.reciprocal {
            return value;
        }
        let offset = |r: &Reading| if self.relative { 0.0 } else { r.offset };
        let si = scaled(value, self.from.factor, self.from.tens) + offset(&self.from);
        let si = if self.reciprocal { 1.0 / si } else { si };
        let shown = si - offset(&self.to);
        scaled(if self.to.factor == 1.0 { shown } else { shown / self.to.factor }, 1.0, -self.to.tens)
    }

    /// The value in the first unit.
    pub fn back(&self, value: f64) -> f64 {
        Conversion { from: self.to, to: self.from, ..*self }.of(value)
    }
}

/// A number times a factor and a power of ten, which shifts the decimal point: 27.6 m is 0.0276, to the last bit.
fn scaled(value: f64, factor: f64, tens: i32) -> f64 {
    let value = if factor == 1.0 { value } else { value * factor };
    if tens == 0 { value } else { format!("{value}e{tens}").parse().unwrap_or(f64::NAN) }
}

/// Why a unit is not taken: one sentence without its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The text is no unit.
    Unknown(String),
    /// A unit of another quantity.
    Dimension(String, String),
    /// Two readings with different values.
    Ambiguous(String, String),
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Refusal::Unknown(text) => write!(f, "\"{text}\" is not a known unit"),
            Refusal::Dimension(text, wanted) => {
                write!(f, "\"{text}\" is not a unit of the same quantity as \"{wanted}\"")
            }
            Refusal::Ambiguous(text, wanted) => {
                write!(f, "\"{text}\" can be read in two ways for \"{wanted}\": put a dot between its parts")
            }
        }
    }
}

impl std::error::Error for Refusal {}

/// Quantities for which the reciprocal is in use, by the unit of the one and of the other.
const RECIPROCAL: [(&str, &str); 2] = [("N.m/A", "rad/(s.V)"), ("W/K", "K/W")];
/// Cost of a reciprocal: more than that of any direct reading.
const RECIPROCAL_COST: u32 = 100;

/// The conversion from the unit `from` to the unit `to`; of differences, without offset, if `relative`.
///
/// # Errors
/// A text that is no unit, a unit of another quantity, or a text with two meanings.
pub fn conversion(from: &str, to: &str, relative: bool) -> Result<Conversion, Refusal> {
    let target = readings(to);
    let Some(target) = target.iter().min_by_key(|r| r.cost).copied() else {
        return match from == to {
            true => Ok(unchanged()),
            false => Err(Refusal::Unknown(to.to_owned())),
        };
    };
    if from == to {
        return Ok(Conversion { from: target, to: target, relative, reciprocal: false });
    }
    let given = readings(from);
    if given.is_empty() {
        return Err(Refusal::Unknown(from.to_owned()));
    }
    let inverse = |text: &str| readings(text).first().map(|r| r.dimension);
    let other_way = RECIPROCAL.iter().flat_map(|(a, b)| [(a, b), (b, a)]).find_map(|(this, that)| {
        let of_this = target.dimension.distance(inverse(this)?).is_some();
        of_this.then(|| inverse(that)).flatten()
    });
    let mut fitting: Vec<(u32, Reading, bool)> = Vec::new();
    for reading in given {
        if let Some(distance) = reading.dimension.distance(target.dimension) {
            fitting.push((reading.cost + distance, reading, false));
        }
        if let Some(distance) = other_way.and_then(|wanted| reading.dimension.distance(wanted)) {
            fitting.push((reading.cost + distance + RECIPROCAL_COST, reading, true));
        }
    }
    let least = fitting.iter().map(|f| f.0).min();
    let mut best = fitting.iter().filter(|f| Some(f.0) == least);
    let Some(&(_, reading, reciprocal)) = best.next() else {
        return Err(Refusal::Dimension(from.to_owned(), to.to_owned()));
    };
    let size = |r: &Reading| scaled(1.0, r.factor, r.tens);
    if best.any(|(_, other, _)| (size(other) / size(&reading) - 1.0).abs() > 1e-9) {
        return Err(Refusal::Ambiguous(from.to_owned(), to.to_owned()));
    }
    Ok(Conversion { from: reading, to: target, relative, reciprocal })
}

/// What a name may mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meaning {
    /// Exponents of kg, m, s, A, K and rad.
    pub exponents: [i8; 6],
    /// SI value = factor * value + offset.
    pub factor: f64,
    /// See `factor`; of a unit of temperature that stands alone.
    pub offset: f64,
}

/// All meanings of a name with whole exponents, the likeliest first; none for a text that is no unit.
pub fn meanings(name: &str) -> Vec<Meaning> {
    let mut found = readings(name);
    found.sort_by_key(|r| r.cost);
    let whole = found.iter().filter(|r| r.dimension.0.iter().all(|halves| halves % 2 == 0));
    let meaning = |r: &Reading| Meaning {
        exponents: r.dimension.0.map(|halves| halves / 2),
        factor: scaled(1.0, r.factor, r.tens),
        offset: r.offset,
    };
    whole.map(meaning).collect()
}

/// The names of units in a text, such as `m` and `s` in `m/s`, and whether each is a unit by itself: `mph` is none, though it could be read
/// as `m.p.h`.
pub fn names(text: &str) -> Vec<(String, bool)> {
    parse::names(text)
}

/// The conversion that changes nothing.
pub fn unchanged() -> Conversion {
    let one = Reading { factor: 1.0, tens: 0, offset: 0.0, dimension: Dimension::default(), cost: 0 };
    Conversion { from: one, to: one, relative: false, reciprocal: false }
}

/// A number and the unit behind it, as in `3.5 mH`, `3,5 mH` or `25degC`; the unit is empty where there is none. `None` where there is no
/// number, or a comma that may separate thousands or decimals, as in `7,590`.
pub fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    // A dot of the unit, as in N.m, is none of the number.
    let numeric = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',');
    let digits = text.find(|c| !numeric(c)).map_or(text, |end| &text[..end]);
    let pointed = if digits.contains('.') { text.to_owned() } else { text.replacen(',', ".", 1) };
    // The longest beginning that is a number: 1e3 is one, 1eV is 1 with a unit.
    let ends = pointed.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
    let (number, end) =
        ends.filter_map(|end| Some((pointed[..end].trim_end().parse::<f64>().ok()?, end))).next()?;
    if let Some((whole, decimals)) = text[..end].trim_end().split_once(',')
        && decimals.find(|c: char| !c.is_ascii_digit()).unwrap_or(decimals.len()) == 3
        && !whole.trim_start_matches(['+', '-', '0']).is_empty()
    {
        return None;
    }
    let starts_as_number = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    let unit = text[end..].trim();
    (starts_as_number && !unit.starts_with([',', '.'])).then_some((number, unit))
}

/// The number of a text in the unit `unit`; a unit behind the number may be another of the same quantity.
///
/// # Errors
/// A text that is no finite number, a unit that does not fit: one sentence without its end.
pub fn number(text: &str, unit: &str) -> Result<f64, String> {
    let plain = text.trim().parse::<f64>().ok().map(|number| (number, ""));
    let (number, given) =
        plain.or_else(|| split(text)).ok_or_else(|| format!("expected a number in {unit}"))?;
    let number = match given {
        "" => number,
        given => conversion(given, unit, false).map_err(|refusal| refusal.to_string())?.of(number),
    };
    if number.is_finite() { Ok(number) } else { Err(format!("expected a finite number in {unit}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_the_unit_that_is_wanted_or_its_own() {
        for (text, seconds) in [
            ("2.5", 2.5),
            ("10 min", 600.0),
            ("1ms", 1e-3),
            ("-0,5 h", -1800.0),
            ("0,1 N.m.s/(N.m)", 0.1),
            ("1,2e1 min", 720.0),
            ("1e3", 1e3),
        ] {
            assert_eq!(number(text, "s"), Ok(seconds), "{text}");
        }
        for (text, why) in [
            ("soon", "expected a number in s"),
            ("3 rpm", "\"rpm\" is not a unit of the same quantity as \"s\""),
            ("inf", "expected a finite number in s"),
            ("", "expected a number in s"),
        ] {
            assert_eq!(number(text, "s"), Err(why.to_owned()), "{text}");
        }
    }

    fn si(value: f64, from: &str, to: &str) -> f64 {
        conversion(from, to, false).unwrap_or_else(|e| panic!("{from} to {to}: {e}")).of(value)
    }

    /// Factors from NIST SP 811, appendix B, and from the definitions.
    #[test]
    fn datasheet_units_convert() {
        let tau = std::f64::consts::TAU;
        for (value, from, to, expected) in [
            (65.3, "uH", "H", 65.3e-6),
            (0.33, "mH", "H", 3.3e-4),
            (33.3, "g.cm2", "kg.m2", 33.3e-7),
            (33.3, "gcm²", "kg.m2", 33.3e-7),
            (33.3, "g·cm^2", "kg.m2", 33.3e-7),
            (1.0, "kgcm2", "kg.m2", 1e-4),
            (27.6, "mN.m/A", "N.m/A", 0.0276),
            (27.6, "mNm/A", "N.m/A", 0.0276),
            (27.6, "mN·m/A", "N.m/A", 0.0276),
            (2.89, "V/krpm", "N.m/A", 2.89 * 60.0 / (1000.0 * tau)),
            (2.89, "mV/rpm", "N.m/A", 2.89e-3 * 60.0 / tau),
            (2.89, "mV/min-1", "N.m/A", 2.89e-3 * 60.0 / tau),
            (0.0276, "V.s/rad", "N.m/A", 0.0276),
            (346.0, "rpm/V", "N.m/A", 60.0 / (346.0 * tau)),
            (346.0, "min⁻¹/V", "N.m/A", 60.0 / (346.0 * tau)),
            (346.0, "1/min/V", "N.m/A", 60.0 / (346.0 * tau)),
            (25.0, "degC", "K", 298.15),
            (77.0, "°F", "K", 298.15),
            (3000.0, "rpm", "rad/s", 3000.0 * tau / 60.0),
            (3000.0, "min-1", "rad/s", 3000.0 * tau / 60.0),
            (3000.0, "1/min", "rad/s", 3000.0 * tau / 60.0),
            (3000.0, "U/min", "rad/s", 3000.0 * tau / 60.0),
            (3000.0, "r/min", "rad/s", 3000.0 * tau / 60.0),
            (360.0, "deg/s", "rad/s", tau),
            (60.0, "1/min", "Hz", 1.0),
            (20.0, "kHz", "Hz", 2e4),
            (2.0, "min", "s", 120.0),
            (4.65, "K/W", "W/K", 1.0 / 4.65),
            (4.65, "°C/W", "K/W", 4.65),
            (0.39, "%/K", "1/K", 0.0039),
            (0.39, "%/degC", "1/K", 0.0039),
            (-1200.0, "ppm/K", "1/K", -0.0012),
            (386.0, "mΩ", "Ohm", 0.386),
            (16.0, "oz-in", "N.m", 16.0 * 0.007_061_551_814),
            (1.0, "oz.in/A", "N.m/A", 0.007_061_551_814),
            (1.0, "lb-ft", "N.m", 1.355_817_948),
            (1.0, "lbf.in", "N.m", 0.112_984_829),
            (1.0, "oz-in-s2", "kg.m2", 7.061_551_814e-3),
            (10.0, "kg.cm", "N.m", 0.980_665),
            (10.0, "gf.cm", "N.m", 9.80665e-4),
            (500.0, "mNms", "N.m.s/rad", 0.5),
            (2.0, "Nms", "N.m.s/rad", 2.0),
            (2.0, "Nms/rad", "N.m.s/rad", 2.0),
            (2.0, "kNms", "N.m.s/rad", 2e3),
            (3.0, "Nmm", "N.m", 3e-3),
            (1.0, "N.m/rpm", "N.m.s/rad", 60.0 / tau),
            (1.0, "N.m/deg", "N.m/rad", 360.0 / tau),
            (480.0, "g", "kg", 0.48),
            (40.0, "mm", "m", 0.04),
            (10.0, "CFM", "m3/s", 0.004_719_474_432),
            (0.28, "m3/min", "m3/s", 0.28 / 60.0),
            (60.0, "l/min", "m3/s", 0.001),
            (7.24, "mmH2O", "Pa", 7.24 * 9.80665),
            (1.0, "bar", "Pa", 1e5),
            (1.0, "Wh", "J", 3600.0),
            (150.0, "Ws/K", "J/K", 150.0),
            (8.0, "W/m2.K", "W/(m2.K)", 8.0),
            (8.0, "W/m²K", "W/(m2.K)", 8.0),
            (50.0, "%", "1", 0.5),
            (1.0, "mN.m.s0.5/rad0.5", "N.m.s0.5/rad0.5", 1e-3),
            (2.0, "mS", "K", f64::NAN),
        ] {
            match conversion(from, to, false) {
                Ok(found) => {
                    let got = found.of(value);
                    assert!(
                        (got / expected - 1.0).abs() < 1e-9,
                        "{value} {from} is {got} {to}, not {expected}"
                    );
                    assert!((found.back(got) / value - 1.0).abs() < 1e-12, "{from} and back");
                }
                Err(refusal) => assert!(expected.is_nan(), "{from}: {refusal}"),
            }
        }
    }

    /// A decimal number with a decimal prefix gives the double that the decimal number in SI is.
    #[test]
    fn decimal_prefixes_round_once() {
        for (value, from, to, expected) in [
            (33.3, "g.cm2", "kg.m2", 3.33e-6),
            (27.6, "mN.m/A", "N.m/A", 0.0276),
            (0.0653, "mH", "H", 6.53e-5),
        ] {
            assert_eq!(si(value, from, to), expected, "{value} {from}");
        }
        assert_eq!(si(0.1 + 0.2, "Ohm", "Ohm"), 0.1 + 0.2, "the same unit changes no bit");
    }

    #[test]
    fn decimal_commas_are_taken_and_thousands_are_not_guessed() {
        for (text, parts) in [
            ("3,5 mH", Some((3.5, "mH"))),
            ("-0,125", Some((-0.125, ""))),
            ("27,61degC", Some((27.61, "degC"))),
            ("7,590 rpm", None),
            ("1,234.5", None),
            ("1,2,3", None),
            ("1e3 V", Some((1000.0, "V"))),
        ] {
            assert_eq!(split(text), parts, "{text}");
        }
    }

    #[test]
    fn a_difference_of_temperatures_has_no_offset() {
        let rise = conversion("degC", "K", true).unwrap();
        assert_eq!((rise.of(40.0), rise.back(40.0)), (40.0, 40.0));
        assert_eq!(si(130.0, "degC", "degF"), 266.0);
    }

    /// A frequency is no speed of rotation: they differ by 2 pi. Torque and energy have one dimension.
    #[test]
    fn units_of_other_quantities_are_refused() {
        for (from, to) in [
            ("Hz", "rad/s"),
            ("rpm", "Hz"),
            ("V", "Ohm"),
            ("mH", "Ohm"),
            ("g", "kg.m2"),
            ("K", "1/K"),
            ("1", "rad"),
            ("deg", "1"),
        ] {
            assert!(matches!(conversion(from, to, false), Err(Refusal::Dimension(..))), "{from} for {to}");
        }
        for text in
            ["", "furlong", "N..m", "(N.m", "N.m)", "m/", "kg^", "5", "µ", "mH2", "x".repeat(3000).as_str()]
        {
            let refused = conversion(text, "Ohm", false);
            assert!(refused.is_err(), "{text}: {refused:?}");
        }
    }

    #[test]
    fn numbers_are_split_from_their_units() {
        for (text, expected) in [
            ("3.5 mH", Some((3.5, "mH"))),
            ("25degC", Some((25.0, "degC"))),
            ("-1e-3", Some((-1e-3, ""))),
            ("1e3rpm", Some((1e3, "rpm"))),
            ("5 1/min", Some((5.0, "1/min"))),
            ("current", None),
            ("inf", None),
            ("nan", None),
            ("", None),
        ] {
            assert_eq!(split(text), expected, "{text}");
        }
    }
}
