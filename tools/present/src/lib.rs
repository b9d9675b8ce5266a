//! Figures as SVG ([`figure`]) and pages as HTML ([`page`]). Both are written with maud, whose escaper is the only one.
//! They need no network, no script library and no font, and follow the reader's light or dark scheme.

// The only statement of a maud template is @let.
#![allow(clippy::let_unit_value)]

pub mod check;
pub mod figure;
pub mod page;
mod typeset;
mod units;
pub mod words;

pub use typeset::typeset;

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

/// A number with four significant digits, in ASCII: for texts that programs may read. [`typeset`] gives it the signs of pages and figures.
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

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [(0.0, "0"), (12345.6, "12346"), (0.012345, "0.01235"), (-9.87654, "-9.877"), (2.0, "2")];
        for (x, text) in cases.into_iter().chain([(1.5e-7, "1.5e-7"), (f64::NAN, "–")]) {
            assert_eq!(number(x), text);
        }
    }
}
