//! What all figures share: frame, style, legend, text and scales.

use crate::typeset::{NO_BREAK, typeset};
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
///
/// A number stays with its unit. The lines are typeset, as everything in figures is.
pub(super) fn wrap(text: &str, room: f64) -> Vec<String> {
    let text = typeset(text);
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
            let end = rest[..most]
                .iter()
                .rposition(|c| BREAKS.contains(c) || *c == NO_BREAK)
                .map_or(most, |k| k + 1);
            lines.push(rest.drain(..end).collect());
        }
        lines.push(rest.into_iter().collect());
    }
    let plain = |line: String| line.replace(NO_BREAK, " ").trim_end().to_owned();
    lines.into_iter().map(plain).filter(|line| !line.is_empty()).collect()
}

/// A text in its signs; within one line its spaces are plain.
fn printed(text: &str) -> String {
    typeset(text).replace(NO_BREAK, " ")
}

/// Text at a place; `class` begins with its anchor: e for its end, m for its middle.
pub(super) fn text(x: f64, y: f64, class: &str, text: &str) -> Markup {
    let one = |class: &str| {
        let class = (!class.is_empty()).then_some(class);
        html! { text class=[class] x=(format_args!("{x:.1}")) y=(format_args!("{y:.1}")) { (printed(text)) } }
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
    html! { text.e transform=(format_args!("translate({:.1} {y:.1}) rotate(-90)", x + BASELINE)) { (printed(label)) } }
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
         .f .a,.f .z,.f .n,.f .k,.f .l{{fill:none}}.f .l{{stroke-width:2;stroke-linejoin:round}}.f .l.h{{stroke-width:1}}.f .l.u{{stroke-width:5;stroke-opacity:.45}}.f .l.h.u{{stroke-width:3.5}}\
         .f .k{{stroke-width:1.5}}.f .p{{stroke-width:1}}.f .n{{stroke-dasharray:3 4}}.f .z{{stroke-dasharray:6 4;stroke-width:1.5}}\
         .f .w{{fill-opacity:.22;stroke:none}}.f .q{{fill-opacity:.25;stroke-opacity:.5;stroke-width:.6}}.f .o{{stroke-width:4;stroke-linejoin:round}}\
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
    Line(Option<String>),
    WideLine(Option<String>),
    Point,
    Ring,
    Area,
    Limit,
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
            @let line = |class: &str, dash: &Option<String>| html! {
                path class={ (class) (colour) } stroke-dasharray=[dash.as_deref()] d=(format_args!("M{x:.1} {middle:.1}h18")) {}
            };
            @match swatch {
                Swatch::Line(dash) => { (line("l k", dash)) },
                Swatch::WideLine(dash) => { (line("l u k", dash)) },
                Swatch::Point => { circle class={ "p d" (colour) } cx=(format_args!("{:.1}", x + 9.0)) cy=(middle) r="4" {} },
                Swatch::Ring => { circle class={ "k k" (colour) } cx=(format_args!("{:.1}", x + 9.0)) cy=(middle) r="4" {} },
                Swatch::Limit => { path.z d=(format_args!("M{x:.1} {middle:.1}h18")) {} },
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

#[cfg(test)]
mod tests {
    use super::*;

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
