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

/// Colours of series that differ.
pub(crate) const COLOURS: usize = 8;

pub(crate) struct Palette {
    pub ink: &'static str,
    pub soft: &'static str,
    pub grid: &'static str,
    pub paper: &'static str,
    pub raised: &'static str,
    pub limit: &'static str,
    /// Colours of series, after Okabe and Ito; colour-blind readers can distinguish them, and each is seen as a line on the paper.
    pub series: [&'static str; COLOURS],
}

pub(crate) const LIGHT: Palette = Palette {
    ink: "#24292f",
    soft: "#57606a",
    grid: "#dfe3e8",
    paper: "#ffffff",
    raised: "#f6f8fa",
    limit: "#b3261e",
    series: ["#0072b2", "#c04800", "#009e73", "#a3478a", "#3a3a3a", "#b88e00", "#6a7ff0", "#7b5023"],
};

pub(crate) const DARK: Palette = Palette {
    ink: "#e6edf3",
    soft: "#9aa4af",
    grid: "#30363d",
    paper: "#0d1117",
    raised: "#161b22",
    limit: "#ff7b72",
    series: ["#58b0f0", "#ff8c42", "#3fd1a4", "#e59fce", "#d0d7de", "#f7d560", "#9bd6ff", "#d2a679"],
};

/// Sizes of numbers that are written without an exponent.
pub const PLAIN: std::ops::Range<f64> = 1e-4..1e5;

/// A number with four significant digits, in ASCII: for texts that programs may read. [`typeset()`] gives it the signs of pages and figures.
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
    if PLAIN.contains(&size) {
        let digits = (3.0 - size.log10().floor()).max(0.0) as usize;
        return short(&format!("{value:.digits$}"));
    }
    let text = format!("{value:.3e}");
    text.split_once('e').map_or(text.clone(), |(digits, power)| format!("{}e{power}", short(digits)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [(0.0, "0"), (12345.6, "12346"), (0.012345, "0.01235"), (-9.87654, "-9.877"), (2.0, "2")];
        for (x, text) in cases.into_iter().chain([(1.5e-7, "1.5e-7"), (f64::NAN, "–")]) {
            assert_eq!(number(x), text);
        }
    }

    /// Red, green and blue as light.
    fn light(colour: &str) -> [f64; 3] {
        [1, 3, 5].map(|k| {
            let part = f64::from(u8::from_str_radix(&colour[k..k + 2], 16).unwrap()) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn luminance([r, g, b]: [f64; 3]) -> f64 {
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// WCAG 2.1 asks 3:1 for graphics.
    #[test]
    fn every_series_is_seen_on_the_paper() {
        for palette in [LIGHT, DARK] {
            for colour in palette.series.into_iter().chain([palette.limit, palette.soft]) {
                let of = |colour| luminance(light(colour)) + 0.05;
                let (a, b) = (of(colour), of(palette.paper));
                assert!(a.max(b) / a.min(b) >= 3.0, "{colour}");
            }
        }
    }

    /// Coordinates of CIE 1976, in which a difference of 2 is just seen.
    fn lab(rgb: [f64; 3]) -> [f64; 3] {
        let f = |t: f64| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let [r, g, b] = rgb;
        let x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
        let (y, z) = (f(luminance(rgb)), f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Full colour vision, and deuteranopia and protanopia after Machado et al. (2009).
    #[test]
    fn series_differ_for_colour_blind_readers() {
        let visions = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
        ];
        for (palette, vision) in [LIGHT, DARK].iter().flat_map(|p| visions.map(|v| (p, v))) {
            let seen = palette.series.map(|colour| {
                let rgb = light(colour);
                lab(vision.map(|row| (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]).max(0.0)))
            });
            for (k, a) in seen.iter().enumerate() {
                for (j, b) in seen[..k].iter().enumerate() {
                    let apart = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    assert!(apart > 12.0, "{} and {}: {apart}", palette.series[k], palette.series[j]);
                }
            }
        }
    }
}
