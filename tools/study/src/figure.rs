//! Figures as SVG that read on light and dark: lines, points, labelled axes with units, a legend.

mod rows;

pub use rows::{Mark, Row, Rows};

use std::fmt::Write;

/// What can be drawn.
pub trait Drawing {
    /// The SVG, complete in itself.
    fn svg(&self) -> String;
}

/// Size of a figure and of its margins: left, right, top, bottom.
const SIZE: (f64, f64) = (660.0, 400.0);
const MARGIN: (f64, f64, f64, f64) = (74.0, 18.0, 40.0, 54.0);
/// Height of a row of the legend, and width of a letter at its size.
const LEGEND: (f64, f64) = (19.0, 6.6);

/// Colours of ink, soft ink, grid and paper, then of the series, on light and on dark; the series' are apart for
/// the colour blind (Okabe and Ito).
const LIGHT: [&str; 12] = [
    "#24292f", "#6e7781", "#e4e7ea", "#ffffff", "#0072b2", "#d55e00", "#009e73", "#a3478a", "#3a3a3a",
    "#b07d00", "#3d9fd6", "#7b5023",
];
const DARK: [&str; 12] = [
    "#e6edf3", "#9aa4af", "#30363d", "#0d1117", "#58b0f0", "#ff8c42", "#3fd1a4", "#e59fce", "#d0d7de",
    "#f0c04a", "#9bd6ff", "#d2a679",
];

/// The style of a figure: plain classes, which any viewer of SVG knows, and the reader's scheme over them.
fn style() -> String {
    let colours = |palette: &[&str; 12]| {
        let [ink, soft, grid, paper, series @ ..] = palette;
        let mut css = format!(
            ".f text{{fill:{ink}}}.f .s{{fill:{soft}}}.f .g{{stroke:{grid}}}.f .a,.f .n{{stroke:{soft}}}\
             .f .b{{fill:{paper}}}.f .p{{stroke:{paper}}}"
        );
        for (k, colour) in series.iter().enumerate() {
            let _ = write!(css, ".f .d{k}{{fill:{colour}}}.f .k{k}{{stroke:{colour}}}");
        }
        css
    };
    format!(
        "\n.f text{{font-family:system-ui,'Segoe UI',Helvetica,Arial,sans-serif;font-size:12px}}\n\
         .f .t{{font-size:14px;font-weight:600}}.f .l{{fill:none;stroke-width:2;stroke-linejoin:round}}\
         .f .p{{stroke-width:1.2}}.f .n{{stroke-dasharray:3 4}}\
         .f .h{{stroke-width:1}}.f .w{{fill-opacity:.22;stroke:none}}\n{}\n\
         @media (prefers-color-scheme:dark){{{}}}\n",
        colours(&LIGHT),
        colours(&DARK)
    )
}

/// An axis: what it shows, and its range where that is not to follow from the data.
#[derive(Clone, Debug)]
pub struct Axis {
    label: String,
    range: Option<(f64, f64)>,
}

impl Axis {
    /// The axis of a quantity with its unit.
    pub fn new(label: &str) -> Axis {
        Axis { label: label.to_owned(), range: None }
    }

    /// With a range.
    pub fn from_to(mut self, from: f64, to: f64) -> Axis {
        self.range = Some((from, to));
        self
    }
}

#[derive(Clone, Debug)]
enum Kind {
    Line,
    Dashed,
    Points,
    Band,
}

#[derive(Clone, Debug)]
struct Series {
    label: String,
    kind: Kind,
    colour: usize,
    points: Vec<(f64, f64)>,
    /// Half-lengths of the error bars of points; half-widths of a band.
    bars: Vec<f64>,
}

/// A figure that is being put together.
#[derive(Clone, Debug)]
pub struct Figure {
    title: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    notes: Vec<(f64, String)>,
    categories: Vec<String>,
    next_colour: usize,
    hair: bool,
}

impl Figure {
    /// An empty figure.
    pub fn new(title: &str, x: Axis, y: Axis) -> Figure {
        let (series, notes, categories) = (Vec::new(), Vec::new(), Vec::new());
        Figure { title: title.to_owned(), x, y, series, notes, categories, next_colour: 0, hair: false }
    }

    fn with(mut self, label: &str, kind: Kind, points: Vec<(f64, f64)>) -> Figure {
        let colour = self.next_colour % 8;
        self.next_colour += 1;
        self.series.push(Series { label: label.to_owned(), kind, colour, points, bars: Vec::new() });
        self
    }

    /// With a line; a value that is no number interrupts it.
    pub fn line(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Line, points)
    }

    /// With a dashed line.
    pub fn dashed(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Dashed, points)
    }

    /// With points.
    pub fn points(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Points, points)
    }

    /// With points that have error bars of these half-lengths.
    pub fn points_with_bars(mut self, label: &str, points: Vec<(f64, f64)>, bars: Vec<f64>) -> Figure {
        self = self.with(label, Kind::Points, points);
        if let Some(last) = self.series.last_mut() {
            last.bars = bars;
        }
        self
    }

    /// With a band of these half-widths about a line.
    pub fn band(mut self, label: &str, line: Vec<(f64, f64)>, widths: Vec<f64>) -> Figure {
        self = self.with(label, Kind::Band, line);
        if let Some(last) = self.series.last_mut() {
            last.bars = widths;
        }
        self
    }

    /// With hairlines, for what trembles.
    pub fn hairlines(mut self) -> Figure {
        self.hair = true;
        self
    }

    /// With the next series in the colour of the last.
    pub fn same_colour(mut self) -> Figure {
        self.next_colour = self.next_colour.saturating_sub(1);
        self
    }

    /// With a remark at a place on the x axis, marked by a vertical line.
    pub fn note(mut self, x: f64, text: &str) -> Figure {
        self.notes.push((x, text.to_owned()));
        self
    }

    /// With names in place of the numbers 0, 1, 2 ... on the x axis.
    pub fn categories(mut self, names: &[&str]) -> Figure {
        self.categories = names.iter().map(|n| (*n).to_owned()).collect();
        self.x.range = Some((-0.5, names.len() as f64 - 0.5));
        self
    }

    /// The SVG, complete in itself.
    pub fn svg(&self) -> String {
        let (places, rows) = self.legend();
        let top = MARGIN.2 + LEGEND.0 * rows as f64;
        let height = SIZE.1 + LEGEND.0 * rows as f64;
        let has_line = self.series.iter().any(|s| matches!(s.kind, Kind::Line));
        let x = Scale::new(self.span(&self.x, |p| p.0, !has_line), (MARGIN.0, SIZE.0 - MARGIN.1));
        let y = Scale::new(self.span(&self.y, |p| p.1, true), (height - MARGIN.3, top));
        let mut out = format!(
            "<svg class=\"f\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" width=\"{}\" \
             height=\"{height}\" role=\"img\" aria-label=\"{title}\"><style>{}</style>\
             <rect class=\"b\" width=\"100%\" height=\"100%\"/><text class=\"t\" x=\"{}\" y=\"24\">{title}</text>",
            SIZE.0,
            SIZE.0,
            style(),
            MARGIN.0,
            title = escaped(&self.title)
        );
        self.draw_axes(&mut out, &x, &y);
        for (at, text) in &self.notes {
            let px = x.at(*at);
            let _ = write!(
                out,
                "<line class=\"n\" x1=\"{px:.1}\" x2=\"{px:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>\
                 <text class=\"s\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                y.pixels.0,
                y.pixels.1,
                px + 4.0,
                y.pixels.1 + 13.0,
                escaped(text)
            );
        }
        for series in &self.series {
            draw_series(&mut out, series, &x, &y, self.hair);
        }
        for (series, (px, py)) in self.series.iter().filter(|s| !s.label.is_empty()).zip(places) {
            let colour = series.colour;
            let dash = if matches!(series.kind, Kind::Dashed) { " stroke-dasharray=\"6 4\"" } else { "" };
            let _ = match series.kind {
                Kind::Points => {
                    write!(out, "<circle class=\"p d{colour}\" cx=\"{}\" cy=\"{py}\" r=\"4.5\"/>", px + 9.0)
                }
                Kind::Band => {
                    write!(
                        out,
                        "<rect class=\"w d{colour}\" x=\"{px}\" y=\"{}\" width=\"18\" height=\"10\"/>",
                        py - 5.0
                    )
                }
                _ => write!(out, "<path class=\"l k{colour}\"{dash} d=\"M{px} {py}h18\"/>"),
            };
            let _ =
                write!(out, "<text x=\"{}\" y=\"{}\">{}</text>", px + 24.0, py + 4.0, escaped(&series.label));
        }
        out.push_str("</svg>");
        out
    }

    /// Left middle of each legend entry, and the number of rows.
    fn legend(&self) -> (Vec<(f64, f64)>, usize) {
        let (mut px, mut row) = (MARGIN.0, 0usize);
        let mut places = Vec::new();
        for series in self.series.iter().filter(|s| !s.label.is_empty()) {
            let width = 40.0 + LEGEND.1 * series.label.chars().count() as f64;
            if px + width > SIZE.0 && px > MARGIN.0 {
                (px, row) = (MARGIN.0, row + 1);
            }
            places.push((px, MARGIN.2 + LEGEND.0 * row as f64 + 2.0));
            px += width;
        }
        let rows = if places.is_empty() { 0 } else { row + 1 };
        (places, rows)
    }

    fn span(&self, axis: &Axis, of: impl Fn(&(f64, f64)) -> f64, margin: bool) -> (f64, f64) {
        if let Some(range) = axis.range {
            return range;
        }
        let edges = |s: &Series| {
            let band = matches!(s.kind, Kind::Band);
            let width =
                move |k: usize, bars: &[f64]| if band { bars.get(k).copied().unwrap_or(0.0) } else { 0.0 };
            let edge = |sign: f64| {
                let points = s.points.iter().enumerate();
                points.map(move |(k, p)| (p.0, p.1 + sign * width(k, &s.bars))).collect::<Vec<_>>()
            };
            [edge(1.0), edge(-1.0)].concat()
        };
        let values = self.series.iter().flat_map(edges).map(|p| of(&p)).filter(|v| v.is_finite());
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return (0.0, 1.0);
        }
        let size = low.abs().max(high.abs()).max(1e-12);
        let flat = high - low < 1e-9 * size;
        let pad = if flat {
            0.05 * size
        } else if margin {
            0.06 * (high - low)
        } else {
            0.0
        };
        (low - pad, high + pad)
    }

    fn draw_axes(&self, out: &mut String, x: &Scale, y: &Scale) {
        let (left, right, bottom, top) = (x.pixels.0, x.pixels.1, y.pixels.0, y.pixels.1);
        for value in y.ticks(6) {
            let py = y.at(value);
            let _ = write!(
                out,
                "<line class=\"g\" x1=\"{left:.1}\" x2=\"{right:.1}\" y1=\"{py:.1}\" y2=\"{py:.1}\"/>\
                 <text text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                left - 8.0,
                py + 4.0,
                tick(value, y.span.1 - y.span.0)
            );
        }
        let names: Vec<(f64, String)> = if self.categories.is_empty() {
            x.ticks(8).into_iter().map(|v| (v, tick(v, x.span.1 - x.span.0))).collect()
        } else {
            self.categories.iter().enumerate().map(|(k, n)| (k as f64, n.clone())).collect()
        };
        for (value, name) in names {
            let px = x.at(value);
            let _ = write!(
                out,
                "<line class=\"g\" x1=\"{px:.1}\" x2=\"{px:.1}\" y1=\"{bottom:.1}\" y2=\"{top:.1}\"/>\
                 <text text-anchor=\"middle\" x=\"{px:.1}\" y=\"{:.1}\">{}</text>",
                bottom + 18.0,
                escaped(&name)
            );
        }
        let _ = write!(
            out,
            "<path class=\"a\" fill=\"none\" d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>\
             <text text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\
             <text text-anchor=\"middle\" transform=\"translate(16 {:.1}) rotate(-90)\">{}</text>",
            0.5 * (left + right),
            bottom + 40.0,
            escaped(&self.x.label),
            0.5 * (top + bottom),
            escaped(&self.y.label)
        );
    }
}

fn draw_series(out: &mut String, series: &Series, x: &Scale, y: &Scale, hair: bool) {
    let colour = series.colour;
    if let Kind::Band = series.kind {
        draw_band(out, series, x, y);
        return;
    }
    if let Kind::Points = series.kind {
        for (k, (a, b)) in
            series.points.iter().enumerate().filter(|(_, p)| p.0.is_finite() && p.1.is_finite())
        {
            let (px, py) = (x.at(*a), y.at(*b));
            if let Some(bar) = series.bars.get(k) {
                let (low, high) = (y.at(b - bar), y.at(b + bar));
                let _ = write!(out, "<path class=\"k{colour}\" d=\"M{px:.1} {low:.1}V{high:.1}\"/>");
            }
            let _ = write!(out, "<circle class=\"p d{colour}\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"4.5\"/>");
        }
        return;
    }
    let mut path = String::new();
    let mut pen_down = false;
    for (a, b) in &series.points {
        // Outside the frame, or no number: the line is interrupted.
        let inside = x.holds(*a) && y.holds(*b);
        if inside {
            let _ = write!(path, "{}{:.1} {:.1}", if pen_down { 'L' } else { 'M' }, x.at(*a), y.at(*b));
        }
        pen_down = inside;
    }
    let dash = if matches!(series.kind, Kind::Dashed) { " stroke-dasharray=\"6 4\"" } else { "" };
    let hair = if hair { " h" } else { "" };
    let _ = write!(out, "<path class=\"l k{colour}{hair}\"{dash} d=\"{path}\"/>");
}

/// The outline of a band: along its upper edge, and back along its lower one.
fn draw_band(out: &mut String, series: &Series, x: &Scale, y: &Scale) {
    let known = series.points.iter().zip(&series.bars).filter(|((a, b), w)| (a + b + **w).is_finite());
    let edge = |sign: f64| move |((a, b), w): (&(f64, f64), &f64)| (*a, b + sign * w);
    let outline = known.clone().map(edge(1.0)).chain(known.rev().map(edge(-1.0)));
    let inside = |v: f64| v.clamp(y.span.0.min(y.span.1), y.span.0.max(y.span.1));
    let points: Vec<String> =
        outline.map(|(a, b)| format!("{:.1} {:.1}", x.at(a), y.at(inside(b)))).collect();
    let _ = write!(out, "<path class=\"w d{}\" d=\"M{}Z\"/>", series.colour, points.join("L"));
}

impl Drawing for Figure {
    fn svg(&self) -> String {
        Figure::svg(self)
    }
}

/// From values to pixels.
struct Scale {
    span: (f64, f64),
    pixels: (f64, f64),
}

impl Scale {
    fn new(span: (f64, f64), pixels: (f64, f64)) -> Scale {
        Scale { span, pixels }
    }

    fn at(&self, value: f64) -> f64 {
        self.pixels.0 + (value - self.span.0) / (self.span.1 - self.span.0) * (self.pixels.1 - self.pixels.0)
    }

    fn holds(&self, value: f64) -> bool {
        let slack = 1e-9 * (self.span.1 - self.span.0);
        value >= self.span.0 - slack && value <= self.span.1 + slack
    }

    /// Round values within the span, about `count` of them.
    fn ticks(&self, count: usize) -> Vec<f64> {
        let rough = (self.span.1 - self.span.0) / count as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= 0.999 * rough);
        let step = step.unwrap_or(power);
        let first = (self.span.0 / step - 1e-9).ceil() as i64;
        let last = (self.span.1 / step + 1e-9).floor() as i64;
        (first..=last).map(|k| k as f64 * step).collect()
    }
}

/// A number on an axis of this span, as short as tells it from its neighbours.
pub fn tick(value: f64, span: f64) -> String {
    let (value, span) = (if value.abs() < 1e-9 * span.abs() { 0.0 } else { value }, span.abs());
    if value == 0.0 {
        return "0".to_owned();
    }
    let size = value.abs().max(span);
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.1e}").replace('-', "\u{2212}");
    }
    let digits = (1.0 - (span.max(1e-12) / 5.0).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "\u{2212}")
}

/// Text within XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::new((290.0, 420.0), (0.0, 100.0));
        assert_eq!(scale.ticks(6), [300.0, 350.0, 400.0]);
        assert_eq!(
            Scale::new((0.0, 1.0), (0.0, 1.0)).ticks(5),
            [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        assert_eq!((tick(0.6000000000000001, 1.0), tick(-20.0, 100.0)), ("0.6".into(), "\u{2212}20".into()));
    }

    #[test]
    fn a_line_is_interrupted_where_it_has_no_value() {
        let line = vec![(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 0.0)];
        let svg = Figure::new("a < b", Axis::new("x"), Axis::new("y")).line("l", line).svg();
        let path = svg.split(" d=\"").find(|p| p.contains('L')).unwrap();
        assert_eq!(path.split('"').next().unwrap().matches('M').count(), 2);
        assert!(svg.contains("a &lt; b") && svg.starts_with("<svg") && svg.ends_with("</svg>"));
    }

    /// Half a unit up and down about a line at 1: the axis holds it, and the outline closes.
    #[test]
    fn a_band_is_held_by_the_axis() {
        let line = vec![(0.0, 1.0), (1.0, 1.0)];
        let figure = Figure::new("t", Axis::new("x"), Axis::new("y")).band("b", line, vec![0.5, 0.5]);
        let svg = figure.svg();
        let path = svg.split("<path class=\"w d0\" d=\"").nth(1).unwrap();
        assert_eq!(path.split('"').next().unwrap().matches(['M', 'L', 'Z']).count(), 5);
        assert_eq!(figure.span(&figure.y, |p| p.1, false), (0.5, 1.5));
    }

    #[test]
    fn flat_and_empty_figures_have_a_range() {
        for points in [vec![], vec![(1.0, 3.0)], vec![(1.0, f64::NAN)], vec![(0.0, 0.0), (1.0, 0.0)]] {
            let svg = Figure::new("t", Axis::new("x"), Axis::new("y")).points("p", points).svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
