//! Figures as SVG ([`figure`]) and pages as HTML ([`page`]). Both are written with maud, whose escaper is the only one.
//! They need no network, no script library and no font, and follow the reader's light or dark scheme.

// The only statement of a maud template is @let.
#![allow(clippy::let_unit_value)]

pub mod check;
pub mod figure;
pub mod page;

pub(crate) struct Palette {
    pub ink: &'static str,
    pub soft: &'static str,
    pub grid: &'static str,
    pub paper: &'static str,
    pub raised: &'static str,
    pub limit: &'static str,
    /// Colours of series; colour-blind readers can distinguish them (Okabe and Ito).
    pub series: [&'static str; 8],
}

pub(crate) const LIGHT: Palette = Palette {
    ink: "#24292f",
    soft: "#57606a",
    grid: "#dfe3e8",
    paper: "#ffffff",
    raised: "#f6f8fa",
    limit: "#b3261e",
    series: ["#0072b2", "#d55e00", "#009e73", "#a3478a", "#3a3a3a", "#b07d00", "#3d9fd6", "#7b5023"],
};

pub(crate) const DARK: Palette = Palette {
    ink: "#e6edf3",
    soft: "#9aa4af",
    grid: "#30363d",
    paper: "#0d1117",
    raised: "#161b22",
    limit: "#ff7b72",
    series: ["#58b0f0", "#ff8c42", "#3fd1a4", "#e59fce", "#d0d7de", "#f0c04a", "#9bd6ff", "#d2a679"],
};

/// A number with four significant digits.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let short = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    let size = value.abs();
    if (1e-4..1e5).contains(&size) {
        let digits = (3.0 - size.log10().floor()).max(0.0) as usize;
        return short(&format!("{value:.digits$}"));
    }
    let text = format!("{value:.3e}");
    text.split_once('e').map_or(text.clone(), |(digits, power)| format!("{}e{power}", short(digits)))
}

/// A unit of FMI in its usual notation: `N.m.s2` is N·m·s², `N.m.s0.5` is N·m·s^0.5. A pure number has none.
pub fn unit(name: &str) -> String {
    if name == "1" {
        return String::new();
    }
    let all: Vec<char> = name.replace("degC", "°C").replace("Ohm", "Ω").chars().collect();
    let is_digit = |k: usize| all.get(k).is_some_and(char::is_ascii_digit);
    let mut text = String::new();
    let mut k = 0;
    while k < all.len() {
        // Digits after a letter are its exponent; a point within them is a decimal point.
        let end = (k..all.len())
            .find(|e| !is_digit(*e) && !(all[*e] == '.' && is_digit(*e + 1)))
            .unwrap_or(all.len());
        let exponent = &all[k..end];
        let after_letter = k > 0 && all[k - 1].is_alphabetic();
        match exponent {
            ['2'] if after_letter => text.push('²'),
            ['3'] if after_letter => text.push('³'),
            ['4'] if after_letter => text.push('⁴'),
            _ if is_digit(k) => {
                text += if after_letter { "^" } else { "" };
                text.extend(exponent);
            }
            _ => text.push(if all[k] == '.' { '·' } else { all[k] }),
        }
        k = if is_digit(k) { end } else { k + 1 };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{number, unit};

    #[test]
    fn units_have_signs_of_products_and_powers() {
        for (name, text) in [
            ("N.m.s0.5/rad0.5", "N·m·s^0.5/rad^0.5"),
            ("N.m.s^0.5", "N·m·s^0.5"),
            ("W/K4", "W/K⁴"),
            ("m3/s", "m³/s"),
            ("1/K", "1/K"),
            ("Ohm", "Ω"),
            ("degC", "°C"),
            ("1", ""),
        ] {
            assert_eq!(unit(name), text);
        }
    }

    #[test]
    fn numbers_have_four_digits() {
        let cases = [(0.0, "0"), (12345.6, "12346"), (0.012345, "0.01235"), (-9.87654, "-9.877"), (2.0, "2")];
        for (x, text) in cases.into_iter().chain([(1.5e-7, "1.5e-7"), (f64::NAN, "–")]) {
            assert_eq!(number(x), text);
        }
    }
}
