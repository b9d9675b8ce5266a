//! Symbols of units: what is one, and how a power of ten goes into it.

/// Symbols that take a prefix, with the least and the greatest power of ten that is usual with them: no one writes kK or ks.
const WITH_PREFIX: [(&str, i32, i32); 20] = [
    ("A", -12, 6),
    ("V", -9, 6),
    ("W", -9, 9),
    ("J", -9, 9),
    ("N", -9, 6),
    ("Pa", -6, 9),
    ("Hz", -3, 9),
    ("Ω", -9, 9),
    ("F", -12, 0),
    ("H", -9, 0),
    ("C", -12, 0),
    ("T", -9, 0),
    ("Wb", -9, 0),
    ("S", -9, 0),
    ("K", -6, 0),
    ("m", -9, 3),
    ("s", -12, 0),
    ("g", -9, 3),
    ("rad", -6, 0),
    ("L", -6, 0),
];

/// Symbols without a prefix.
const PLAIN: [&str; 19] = [
    "min", "h", "rpm", "deg", "°", "°C", "°F", "°R", "%", "‰", "bar", "mbar", "cm", "dB", "ppm", "mmH2O",
    "VA", "var", "W·h",
];

const PREFIXES: [(&str, i32); 9] =
    [("", 0), ("p", -12), ("n", -9), ("µ", -6), ("μ", -6), ("m", -3), ("k", 3), ("M", 6), ("G", 9)];

/// A symbol as its base and the power of ten of its prefix.
fn base(symbol: &str) -> Option<(&'static (&'static str, i32, i32), i32)> {
    PREFIXES.iter().find_map(|(prefix, power)| {
        let rest = symbol.strip_prefix(prefix)?;
        Some((WITH_PREFIX.iter().find(|known| known.0 == rest)?, *power))
    })
}

/// Whether a word is a unit: factors that are symbols, each with an exponent or without.
pub(crate) fn is_unit(word: &str) -> bool {
    let is_exponent = |c: char| c.is_ascii_digit() || "⁰¹²³⁴⁵⁶⁷⁸⁹⁻^-".contains(c);
    let is_symbol = |factor: &str| {
        let name = factor.trim_end_matches(is_exponent);
        // What is left of 1/min and of an exponent with a decimal point has no letter.
        name.is_empty() || PLAIN.contains(&name) || PLAIN.contains(&factor) || base(name).is_some()
    };
    let factors = || word.split(['·', '.', '/', '(', ')', '*', '√']);
    // 3 is no unit, 1/min is one.
    let begins = !word.starts_with(is_exponent) || word.starts_with("1/");
    begins && word.chars().any(|c| c.is_alphabetic() || "%‰°".contains(c)) && factors().all(is_symbol)
}

/// A power of ten as people write it.
pub(crate) fn ten_to(power: i32) -> String {
    format!("10{}", power.to_string().chars().map(raised).collect::<String>())
}

/// A digit or a sign as part of an exponent.
pub(crate) fn raised(c: char) -> char {
    let digit = || "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c.to_digit(10)? as usize);
    if c == '-' { '⁻' } else { digit().unwrap_or(c) }
}

/// The unit that is a power of ten of a unit: a prefix at its first symbol where one is usual, else the power before the unit, where it
/// cannot be taken for what the numbers are still to be multiplied by.
pub(crate) fn times_ten_to(power: i32, unit: &str) -> String {
    if power == 0 {
        return unit.to_owned();
    }
    let end = unit.find(['·', '.', '/', '*']).unwrap_or(unit.len());
    let (first, rest) = unit.split_at(end);
    // A prefix before m² would be squared, and g is the rest of kg in products.
    let prefixed = base(first).filter(|((symbol, ..), _)| *symbol != "g" || rest.is_empty());
    let prefixed = prefixed.and_then(|((symbol, least, most), own)| {
        let whole = (*least..=*most).contains(&(own + power)).then_some(own + power)?;
        PREFIXES.iter().find(|p| p.1 == whole).map(|(prefix, _)| format!("{prefix}{symbol}{rest}"))
    });
    match (prefixed, unit.strip_prefix('1')) {
        (Some(prefixed), _) => prefixed,
        (None, Some(per)) if per.starts_with('/') => format!("{}{per}", ten_to(power)),
        _ => format!("{} {unit}", ten_to(power)).trim_end().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_goes_into_the_unit() {
        for (power, unit, expected) in [
            (0, "N·m", "N·m"),
            (-3, "N·m", "mN·m"),
            (-6, "Ω", "µΩ"),
            (-9, "A", "nA"),
            (-9, "N·m/A", "nN·m/A"),
            (3, "W/(m²·K)", "kW/(m²·K)"),
            (-3, "mA", "µA"),
            (3, "mN·m", "N·m"),
            (-3, "kg", "g"),
            // No prefix: a square, a product with g, a unit without one, a size that is not usual.
            (-6, "m³/s", "10⁻⁶ m³/s"),
            (-6, "kg·m²", "10⁻⁶ kg·m²"),
            (-3, "°C", "10⁻³ °C"),
            (3, "rad/s", "10³ rad/s"),
            (6, "s", "10⁶ s"),
            (-15, "A", "10⁻¹⁵ A"),
            (3, "1/min", "10³/min"),
            (-3, "%", "10⁻³ %"),
            (-3, "", "10⁻³"),
        ] {
            assert_eq!(times_ten_to(power, unit), expected);
        }
    }

    #[test]
    fn units_are_known() {
        for unit in [
            "N·m",
            "V.s/rad",
            "W/(m²·K)",
            "1/min",
            "%",
            "°C",
            "N·m·s^0.5/rad^0.5",
            "kW",
            "m3/s",
            "µΩ",
            "mmH2O",
        ] {
            assert!(is_unit(unit), "{unit}");
        }
        for word in
            ["", "1", "12", "of", "runs", "points", "at", "e.g.", "…", "·", "-5", "in", "and/or", "walk.toml"]
        {
            assert!(!is_unit(word), "{word}");
        }
    }
}
