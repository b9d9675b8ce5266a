//! What all figures share: frame, style, legend, text and scales.

use super::Axis;
use crate::{DARK, LIGHT, Palette};
use maud::{Markup, PreEscaped, html};
use std::fmt::Write;

/// Width of a figure, and its margin.
pub(super) const WIDTH: f64 = 500.0;
pub(super) const PAD: f64 = 12.0;
/// Height of a line of text, and from the middle of a letter to its baseline.
pub(super) const LINE: f64 = 18.0;
pub(super) const BASELINE: f64 = 4.5;
/// Width of a letter at 13, generously: the true font is not known here. Digits, which fill tick labels, and the minus sign are as wide as
/// in DejaVu Sans, the widest of the usual fonts.
const LETTER: f64 = 7.4;
const DIGIT: f64 = 8.3;
const MINUS: f64 = 11.0;
/// Width of a legend's swatch with its gap.
const SWATCH: f64 = 24.0;

/// The width that a text is given.
pub(super) fn width(text: &str) -> f64 {
    let of = |c: char| match c {
        '\u{2212}' => MINUS,
        '0'..='9' => DIGIT,
        _ => LETTER,
    };
    text.chars().map(of).sum()
}

/// Letters after which a long word is broken.
pub(super) const BREAKS: [char; 4] = ['-', '_', '.', '/'];

/// A text in lines of at most this width, broken at spaces; within a word that is longer than a line after one of [`BREAKS`], or anywhere.
pub(super) fn wrap(text: &str, room: f64) -> Vec<String> {
    let room = room.max(width("letter"));
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if width(line) + width(" ") + width(word) <= room => {
                *line += " ";
                *line += word;
                continue;
            }
            _ => {}
        }
        let mut rest: Vec<char> = word.chars().collect();
        while width(&rest.iter().collect::<String>()) > room {
            let most = (1..rest.len()).rev().find(|k| width(&rest[..*k].iter().collect::<String>()) <= room);
            let most = most.unwrap_or(1);
            let end = rest[..most].iter().rposition(|c| BREAKS.contains(c)).map_or(most, |k| k + 1);
            lines.push(rest.drain(..end).collect());
        }
        lines.push(rest.into_iter().collect());
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// Text at a place; `class` begins with its anchor: e for its end, m for its middle.
pub(super) fn text(x: f64, y: f64, class: &str, text: &str) -> Markup {
    let one = |class: &str| {
        let class = (!class.is_empty()).then_some(class);
        html! { text class=[class] x=(format_args!("{x:.1}")) y=(format_args!("{y:.1}")) { (text) } }
    };
    // Text over lines stands on its own outline, in the colour of the paper; some converters paint the outline of a text last.
    match class.strip_suffix('o') {
        Some(plain) => html! { (one(class)) (one(plain.trim_end())) },
        None => one(class),
    }
}

/// A label below an axis at a place, moved to stay inside the figure.
pub(super) fn below(x: f64, y: f64, label: &str) -> Markup {
    let half = 0.5 * width(label);
    text(x.clamp(half, (WIDTH - half).max(half)), y, "m", label)
}

/// A label below an axis at a place, written upwards.
pub(super) fn upright(x: f64, y: f64, label: &str) -> Markup {
    html! { text.e transform=(format_args!("translate({:.1} {y:.1}) rotate(-90)", x + BASELINE)) { (label) } }
}

/// A part of a figure, moved.
pub(super) fn place(x: f64, y: f64, content: Markup) -> Markup {
    html! { g transform=(format_args!("translate({x:.1} {y:.1})")) { (content) } }
}

/// Classes with colours, which every viewer of SVG knows, and the dark scheme over them. Converters to PDF and PNG take `height:auto` for 0
/// and do not read rules for screens.
fn style() -> String {
    let colours = |p: &Palette| {
        let mut css = format!(
            ".f text{{fill:{}}}.f .s{{fill:{}}}.f .g{{stroke:{}}}.f .a,.f .n{{stroke:{}}}.f .b{{fill:{paper}}}\
             .f .p,.f .o{{stroke:{paper}}}.f .z{{stroke:{}}}",
            p.ink,
            p.soft,
            p.grid,
            p.soft,
            p.limit,
            paper = p.paper
        );
        for (k, colour) in p.series.iter().enumerate() {
            let _ = write!(css, ".f .d{k}{{fill:{colour}}}.f .k{k}{{stroke:{colour}}}");
        }
        css
    };
    format!(
        "@media screen{{.f{{max-width:100%;height:auto}}}}.f text{{font:13px system-ui,'Segoe UI',Helvetica,Arial,sans-serif}}\
         .f .t{{font-weight:600;font-size:14px}}.f .e{{text-anchor:end}}.f .m{{text-anchor:middle}}\
         .f .a,.f .z,.f .n,.f .k,.f .l{{fill:none}}.f .l{{stroke-width:2;stroke-linejoin:round}}.f .l.h{{stroke-width:1}}\
         .f .k{{stroke-width:1.5}}.f .p{{stroke-width:1}}.f .n{{stroke-dasharray:3 4}}.f .z{{stroke-dasharray:6 4;stroke-width:1.5}}\
         .f .w{{fill-opacity:.22;stroke:none}}.f .o{{stroke-width:4;stroke-linejoin:round}}\
         {}@media (prefers-color-scheme:dark){{{}}}",
        colours(&LIGHT),
        colours(&DARK)
    )
}

/// The whole figure: style, title, content.
pub(super) fn frame(title: &str, content: Markup, height: f64) -> String {
    let lines = wrap(title, (WIDTH - 2.0 * PAD) * 0.9);
    let top = PAD + LINE * lines.len() as f64;
    let height = (top + height).ceil();
    let svg = html! {
        svg.f xmlns="http://www.w3.org/2000/svg" viewBox=(format_args!("0 0 {WIDTH} {height}")) width=(WIDTH) height=(height)
            role="img" aria-label=(title) {
            style { (PreEscaped(style())) }
            rect.b width="100%" height="100%" {}
            @for (k, line) in lines.iter().enumerate() { (text(PAD, PAD + LINE * k as f64 + 9.0, "t", line)) }
            (place(0.0, top, content))
        }
    };
    svg.into_string()
}

/// The symbol before a name in a legend.
pub(super) enum Swatch {
    Line(Option<&'static str>),
    Point,
    Ring,
    Area,
}

/// Names with their colours in rows that do not leave the figure, and the height of all rows.
pub(super) fn legend(entries: Vec<(&str, usize, Swatch)>) -> (Markup, f64) {
    let (mut x, mut y, mut tall) = (PAD, 0.0, 0.0);
    let any = !entries.is_empty();
    let drawn = html! {
        @for (name, colour, swatch) in &entries {
            @let lines = wrap(name, WIDTH - 2.0 * PAD - SWATCH);
            @let wide = SWATCH + lines.iter().map(|l| width(l)).fold(0.0, f64::max);
            @let _ = if x + wide > WIDTH - PAD && x > PAD { (x, y) = (PAD, y + tall); tall = 0.0; };
            @let middle = y + 0.5 * LINE;
            @match swatch {
                Swatch::Line(dash) => { path class={ "l k" (colour) } stroke-dasharray=[*dash] d=(format_args!("M{x:.1} {middle:.1}h18")) {} },
                Swatch::Point => { circle class={ "p d" (colour) } cx=(format_args!("{:.1}", x + 9.0)) cy=(middle) r="4" {} },
                Swatch::Ring => { circle class={ "k k" (colour) } cx=(format_args!("{:.1}", x + 9.0)) cy=(middle) r="4" {} },
                Swatch::Area => { rect class={ "w d" (colour) } x=(format_args!("{x:.1}")) y=(middle - 5.0) width="18" height="10" {} },
            }
            @for (k, line) in lines.iter().enumerate() {
                (text(x + SWATCH, middle + BASELINE + LINE * k as f64, "", line))
            }
            @let _ = { x += wide + 16.0; tall = f64::max(tall, LINE * lines.len() as f64); };
        }
    };
    (drawn, if any { y + tall } else { 0.0 })
}

/// From values to pixels.
pub(super) struct Scale {
    /// The ends, in the unit of the data.
    pub span: (f64, f64),
    pub pixels: (f64, f64),
    /// The unit of the ticks in that of the data: 60 for min where the data are in s.
    pub unit: f64,
}

impl Scale {
    /// Over the range of an axis, or over all numbers with a margin; never empty.
    pub fn over(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64, pixels: (f64, f64)) -> Scale {
        // Beyond these sizes a span has no inverse; below, a number is rounding about zero.
        let numbers = values.filter(|v| v.abs() < 1e150).map(|v| if v.abs() < 1e-60 { 0.0 } else { v });
        let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let span = match (axis.range(), low.abs().max(high.abs())) {
            (Some(range), _) => range,
            _ if low > high => (0.0, 1.0),
            (None, 0.0) => (-1.0, 1.0),
            // Values that differ by rounding alone are constant.
            (None, size) if high - low < 1e-9 * size => (low - 0.05 * size, high + 0.05 * size),
            _ => (low - margin * (high - low), high + margin * (high - low)),
        };
        Scale { span, pixels, unit: axis.unit_over(span) }
    }

    pub fn at(&self, value: f64) -> f64 {
        self.pixels.0 + (value - self.span.0) / (self.span.1 - self.span.0) * (self.pixels.1 - self.pixels.0)
    }

    /// The place of a value, or of the end of the scale that is next to it.
    pub fn within(&self, value: f64) -> f64 {
        self.at(value.clamp(self.span.0.min(self.span.1), self.span.0.max(self.span.1)))
    }

    pub fn holds(&self, value: f64) -> bool {
        let slack = 1e-9 * (self.span.1 - self.span.0);
        value >= self.span.0 - slack && value <= self.span.1 + slack
    }

    /// Round values within the span, about `count` of them.
    pub fn ticks(&self, count: usize) -> Ticks {
        let span = (self.span.0 / self.unit, self.span.1 / self.unit);
        let rough = (span.1 - span.0) / count as f64;
        let decade = (rough * 1.000_001).log10().floor();
        let (factor, decade) = [1.0, 2.0, 5.0]
            .into_iter()
            .find(|m| m * 10f64.powf(decade) >= 0.999 * rough)
            .map_or((1.0, decade + 1.0), |m| (m, decade));
        let step = factor * 10f64.powf(decade);
        let first = (span.0 / step - 1e-9).ceil() as i64;
        let last = (span.1 / step + 1e-9).floor() as i64;
        let places: Vec<f64> = (first..=last).map(|k| k as f64 * step).collect();
        let greatest = |values: &[f64]| values.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
        // Labels that would all begin with the same four digits or more are differences from a round value of 100 units of the last digit.
        let unit = (100.0 / factor) as i64;
        let origin = match greatest(&places) >= 0.999e4 * step {
            true => ((first + last + unit) / 2).div_euclid(unit) * unit,
            false => 0,
        };
        let size = greatest(&places.iter().map(|v| v - origin as f64 * step).collect::<Vec<_>>());
        let power = match size {
            0.0 => 0,
            _ if (1e-2..1e5).contains(&size) => 0,
            _ => 3 * ((size * 1.000_001).log10() / 3.0).floor() as i32,
        };
        let digits = (f64::from(power) - decade).clamp(0.0, 12.0) as usize;
        let label = |k: i64| match k {
            0 => "0".to_owned(),
            _ => format!("{:.digits$}", k as f64 * factor * 10f64.powf(decade - f64::from(power)))
                .replace('-', "\u{2212}"),
        };
        let labels = (first..=last).map(|k| label(k - origin)).collect();
        let origin = (origin != 0).then(|| rounded(origin as f64 * step, decade + 2.0));
        let places = places.into_iter().map(|place| place * self.unit).collect();
        Ticks { labels, places, power, origin }
    }

    /// As many ticks as have room side by side.
    pub fn ticks_that_fit(&self) -> Ticks {
        let room = (self.pixels.1 - self.pixels.0).abs();
        let fits = |t: &Ticks| {
            let widest = t.labels.iter().map(|l| width(l)).fold(0.0, f64::max);
            t.labels.len() as f64 * (widest + 14.0) <= room
        };
        [8, 6, 5, 4, 3].map(|count| self.ticks(count)).into_iter().find(fits).unwrap_or_else(|| self.ticks(2))
    }
}

/// A number down to the digit of this power of ten.
fn rounded(value: f64, last: f64) -> String {
    let size = value.abs();
    match (1e-4..1e7).contains(&size) {
        true => format!("{value:.*}", (-last).clamp(0.0, 12.0) as usize),
        false => format!("{value:.*e}", (size.log10().floor() - last).clamp(0.0, 12.0) as usize),
    }
    .replace('-', "\u{2212}")
}

/// Round places on an axis; their labels are differences from an origin, in units of a power of ten.
pub(super) struct Ticks {
    pub places: Vec<f64>,
    pub labels: Vec<String>,
    pub power: i32,
    pub origin: Option<String>,
}

impl Ticks {
    pub fn marks(&self) -> Vec<(f64, String)> {
        self.places.iter().copied().zip(self.labels.iter().cloned()).collect()
    }

    /// The axis label with the origin and the power of ten.
    pub fn with_power(&self, label: &str) -> String {
        let raised = |c: char| match c {
            '-' => '⁻',
            digit => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize - '0' as usize).unwrap_or(digit),
        };
        let power = match self.power {
            0 => String::new(),
            power => format!(" × 10{}", power.to_string().chars().map(raised).collect::<String>()),
        };
        match &self.origin {
            None => format!("{label}{power}"),
            Some(origin) => format!("{label} = {origin} + value{power}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(from: f64, to: f64, count: usize) -> Ticks {
        Scale { span: (from, to), pixels: (0.0, 100.0), unit: 1.0 }.ticks(count)
    }

    #[test]
    fn ticks_are_round_short_and_inside() {
        for ((from, to), labels, power) in [
            ((290.0, 420.0), vec!["300", "350", "400"], 0),
            ((0.0, 1.0), vec!["0", "0.2", "0.4", "0.6", "0.8", "1.0"], 0),
            ((-20.0, 20.0), vec!["\u{2212}20", "\u{2212}10", "0", "10", "20"], 0),
            ((0.0, 2e-5), vec!["0", "5", "10", "15", "20"], -6),
            ((0.0, 3e6), vec!["0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"], 6),
            ((25.0, 25.05), vec!["25.00", "25.01", "25.02", "25.03", "25.04", "25.05"], 0),
            ((1.13008, 1.13022), vec!["100", "150", "200"], -6),
            ((-0.060_300_1, -0.060_299_4), vec!["0", "200", "400", "600"], -9),
            ((100_000.0, 100_010.0), vec!["0", "2", "4", "6", "8", "10"], 0),
        ] {
            let found = ticks(from, to, 6);
            assert_eq!((found.labels, found.power), (labels.into_iter().map(str::to_owned).collect(), power));
        }
        assert_eq!(ticks(0.0, 2e-5, 6).with_power("flow in m³/s"), "flow in m³/s × 10⁻⁶");
        assert_eq!(ticks(1.13008, 1.13022, 3).with_power("torque"), "torque = 1.130 + value × 10⁻⁶");
        assert_eq!(ticks(1e5, 1.0001e5, 6).with_power("time in s"), "time in s = 100000 + value");
    }

    /// Advance widths of DejaVu Sans, in which a label that is too narrow is cut at the frame: 0.636 of 13 for a digit, 0.838 for a minus.
    #[test]
    fn tick_labels_have_room_in_the_widest_font() {
        for (label, true_width) in
            [("17000", 5.0 * 0.636 * 13.0), ("\u{2212}2000", (0.838 + 4.0 * 0.636) * 13.0)]
        {
            assert!(width(label) >= true_width, "{label}: {} < {true_width}", width(label));
        }
    }

    #[test]
    fn texts_are_wrapped_at_spaces_and_in_long_words() {
        assert_eq!(wrap("one two three", 7.0 * LETTER), ["one two", "three"]);
        assert_eq!(wrap("abcdefghij", 6.0 * LETTER), ["abcdef", "ghij"]);
        assert_eq!(wrap("abc-defghij", 8.0 * LETTER), ["abc-", "defghij"]);
        assert!(wrap("", 100.0).is_empty());
    }
}
