//! Numbers with as many digits as they are worth.

use present::{PLAIN, number};

/// Digits of a value that is uncertain: a noise, a deviation, an interval.
const UNCERTAIN: i32 = 2;
/// Digits that no interval needs more of.
const MOST: i32 = 6;

/// The power of ten of a size.
fn decade(size: f64) -> i32 {
    size.log10().floor() as i32
}

/// A value with this many decimals, negative ones before the point; with an exponent if `plain` is false.
fn decimals(value: f64, count: i32, plain: bool) -> String {
    let unit = 10f64.powi(-count);
    let value = (value / unit).round() * unit;
    if value == 0.0 {
        return number(0.0);
    }
    // The sign is that of all numbers of the report.
    let sign = if value < 0.0 { number(-1.0).replace('1', "") } else { String::new() };
    let size = value.abs();
    if plain {
        return format!("{sign}{size:.*}", count.max(0) as usize);
    }
    let text = format!("{size:.*e}", (decade(size) + count).max(0) as usize);
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits =
        if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{sign}{digits}e{power}")
}

/// A number with two digits, without zeros at its end.
pub fn rough(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return number(value);
    }
    let size = value.abs();
    let count = UNCERTAIN - 1 - decade(size);
    number((value * 10f64.powi(count)).round() / 10f64.powi(count))
}

/// Decimals that give the half width of an interval two digits, and whether numbers of this size have no exponent; `None` without a width.
fn resolution((low, high): (f64, f64)) -> Option<(i32, bool)> {
    let (half, size) = (0.5 * (high - low), low.abs().max(high.abs()));
    let is_known = half > 0.0 && half.is_finite();
    is_known.then(|| ((UNCERTAIN - 1 - decade(half)).min(MOST - 1 - decade(size)), PLAIN.contains(&size)))
}

/// A number with the decimals that an interval gives it.
fn within(value: f64, ci95: (f64, f64)) -> String {
    match resolution(ci95).filter(|_| value.is_finite()) {
        Some((count, plain)) => decimals(value, count, plain),
        None => number(value),
    }
}

/// An estimated value with the decimals of its interval, but no fewer than two digits.
pub fn estimate(value: f64, ci95: (f64, f64)) -> String {
    let Some((count, plain)) = resolution(ci95).filter(|_| value != 0.0) else { return number(value) };
    let plain = plain && PLAIN.contains(&value.abs());
    decimals(value, count.max(UNCERTAIN - 1 - decade(value.abs())), plain)
}

/// An interval, both ends with the same decimals; one that is not known is said to be so.
pub fn interval(ci95: (f64, f64)) -> String {
    if !(ci95.0.is_finite() && ci95.1.is_finite()) {
        return "unknown".to_owned();
    }
    format!("{} to {}", within(ci95.0, ci95), within(ci95.1, ci95))
}

/// A difference of an information criterion: a whole number where it is large.
pub fn evidence(value: f64) -> String {
    let size = value.abs();
    if !(size >= 10.0 && size.is_finite()) {
        return number(value);
    }
    let unit = 10f64.powi((decade(size) - 3).max(0));
    decimals((value / unit).round() * unit, 0, true)
}

/// A probability.
pub fn probability(value: f64) -> String {
    match value {
        p if p < 1e-3 => "< 0.001".to_owned(),
        p if p > 0.999 => "> 0.999".to_owned(),
        p => decimals(p, 3, true),
    }
}

/// A duration in s.
pub fn seconds(value: f64) -> String {
    if value < 1.0 { "less than 1 s".to_owned() } else { format!("{value:.0} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_have_two_digits_of_their_width() {
        for (ci95, text) in [
            ((0.443, 0.5018), "0.443 to 0.502"),
            ((9.1e-5, 9.9e-5), "9.1e-5 to 9.9e-5"),
            ((0.0, 0.12345), "0 to 0.123"),
            ((101.0, 399.0), "100 to 400"),
            ((290.123_456, 290.123_457), "290.123 to 290.123"),
            ((2.0, 2.0), "2 to 2"),
            ((f64::NAN, 2.0), "unknown"),
            ((1.234e6, 1.256e6), "1.234e6 to 1.256e6"),
        ] {
            assert_eq!(interval(ci95), text);
        }
        for (value, ci95, text) in [
            (0.112_905, (0.112_63, 0.113_18), "0.11291"),
            (0.023_95, (-0.08, 0.17), "0.024"),
            (-46.02, (-71.0, 19.0), "-46"),
            (9.5e-5, (9.1e-5, 9.9e-5), "9.5e-5"),
            (0.0, (-0.1, 0.1), "0"),
            (9.8, (f64::NAN, f64::NAN), "9.8"),
        ] {
            assert_eq!(estimate(value, ci95), text);
        }
    }

    #[test]
    fn numbers_have_no_digits_without_meaning() {
        assert_eq!(
            ["1.53e-66", "0.0004", "0.25", "0.9999"].map(|p| probability(p.parse().unwrap())),
            ["< 0.001", "< 0.001", "0.250", "> 0.999"]
        );
        assert_eq!([238_123.0, 1557.4, 12.3, 3.217].map(evidence), ["238100", "1557", "12", "3.217"]);
        assert_eq!(
            [0.012_05, 0.2381, 9.02e-6, 1234.0, 0.0].map(rough),
            ["0.012", "0.24", "9e-6", "1200", "0"]
        );
        assert_eq!([0.029_31, 4.4, 128.2].map(seconds), ["less than 1 s", "4 s", "128 s"]);
    }
}
