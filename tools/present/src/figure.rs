//! Figures as SVG: lines, points, bands and limits over one or more panels that share the x axis; rows with bars or intervals ([`Rows`]).
//!
//! A figure is 500 units wide with text of 13, so that a column of 390 pixels still shows text of 10. The layout follows the longest texts:
//! labels are wrapped and never cut.

mod axis;
mod layout;
mod points;
mod rows;
#[cfg(test)]
mod tests;

pub use axis::Axis;
pub use rows::{Mark, Row, Rows};

use layout::{BASELINE, BREAKS, LINE, PAD, Scale, Swatch, WIDTH, frame, legend, place, text, width, wrap};
use maud::{Markup, html};
use points::thinned;

/// What can be drawn.
pub trait Drawing {
    /// The SVG, complete in itself.
    fn svg(&self) -> String;
}

/// More points than this are small.
const DENSE: usize = 100;

/// Height of the only panel, and of one of several.
const HEIGHT: (f64, f64) = (220.0, 120.0);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Line,
    Dashed,
    Points,
    Rings,
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

impl Series {
    /// The values that the y axis has to hold.
    fn extent(&self) -> impl Iterator<Item = f64> {
        let wide = |k: usize| self.bars.get(k).copied().filter(|w| w.is_finite()).unwrap_or(0.0);
        self.points.iter().enumerate().flat_map(move |(k, p)| [p.1 - wide(k), p.1 + wide(k)])
    }

    /// Dashes if requested, or if all colours are used.
    fn dash(&self) -> Option<&'static str> {
        match (self.kind == Kind::Dashed, self.colour / 8) {
            (true, _) => Some("6 4"),
            (_, 0) => None,
            (_, 1) => Some("2 3"),
            _ => Some("9 3 2 3"),
        }
    }
}

#[derive(Clone, Debug)]
struct Panel {
    y: Axis,
    series: Vec<Series>,
    limits: Vec<(f64, String)>,
    next_colour: usize,
}

/// A figure that is being put together. What is added goes to the last panel.
#[derive(Clone, Debug)]
pub struct Figure {
    title: String,
    x: Axis,
    panels: Vec<Panel>,
    notes: Vec<(f64, String)>,
    categories: Vec<String>,
    remark: String,
    thin: bool,
}

impl Figure {
    /// A figure with one panel.
    pub fn new(title: &str, x: Axis, y: Axis) -> Figure {
        Figure::stacked(title, x).panel(y)
    }

    /// A figure whose panels are still to come.
    pub fn stacked(title: &str, x: Axis) -> Figure {
        let (panels, notes, categories) = (Vec::new(), Vec::new(), Vec::new());
        Figure { title: title.to_owned(), x, panels, notes, categories, remark: String::new(), thin: false }
    }

    /// With a remark below, in lines as given.
    pub fn remark(mut self, text: &str) -> Figure {
        text.clone_into(&mut self.remark);
        self
    }

    /// With a further panel below.
    pub fn panel(mut self, y: Axis) -> Figure {
        self.panels.push(Panel { y, series: Vec::new(), limits: Vec::new(), next_colour: 0 });
        self
    }

    fn last(&mut self) -> &mut Panel {
        self.panels.last_mut().expect("a figure begins with a panel")
    }

    fn with(mut self, label: &str, kind: Kind, points: Vec<(f64, f64)>, bars: Vec<f64>) -> Figure {
        let panel = self.last();
        let colour = panel.next_colour;
        panel.next_colour += 1;
        panel.series.push(Series { label: label.to_owned(), kind, colour, points, bars });
        self
    }

    /// With a line; a value that is no number interrupts it.
    pub fn line(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Line, points, Vec::new())
    }

    /// With a dashed line.
    pub fn dashed(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Dashed, points, Vec::new())
    }

    /// With points.
    pub fn points(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Points, points, Vec::new())
    }

    /// With rings, which leave the points below them visible.
    pub fn rings(self, label: &str, points: Vec<(f64, f64)>) -> Figure {
        self.with(label, Kind::Rings, points, Vec::new())
    }

    /// With points that have error bars of these half-lengths.
    pub fn points_with_bars(self, label: &str, points: Vec<(f64, f64)>, bars: Vec<f64>) -> Figure {
        self.with(label, Kind::Points, points, bars)
    }

    /// With a band of these half-widths about a line.
    pub fn band(self, label: &str, line: Vec<(f64, f64)>, widths: Vec<f64>) -> Figure {
        self.with(label, Kind::Band, line, widths)
    }

    /// With a limit: a dashed line across the panel with its label.
    pub fn limit(mut self, value: f64, label: &str) -> Figure {
        self.last().limits.push((value, label.to_owned()));
        self
    }

    /// With thin lines, for noise.
    pub fn thin(mut self) -> Figure {
        self.thin = true;
        self
    }

    /// With the next series in this colour, the following ones in the colours after it.
    pub fn colour(mut self, colour: usize) -> Figure {
        self.last().next_colour = colour;
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
        self.x = self.x.from_to(-0.5, names.len() as f64 - 0.5);
        self
    }

    /// Labels and points of all series, panel by panel.
    pub fn series(&self) -> impl Iterator<Item = (&str, &[(f64, f64)])> {
        self.panels.iter().flat_map(|p| &p.series).map(|s| (s.label.as_str(), s.points.as_slice()))
    }

    /// Values of all limits.
    pub fn limits(&self) -> impl Iterator<Item = f64> {
        self.panels.iter().flat_map(|p| &p.limits).map(|l| l.0)
    }

    /// The title.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The SVG, complete in itself.
    pub fn svg(&self) -> String {
        let (content, height) = self.markup();
        frame(&self.title, content, height)
    }

    fn x_scale(&self, left: f64) -> Scale {
        let series = || self.panels.iter().flat_map(|p| &p.series);
        // Lines may reach the frame, points may not.
        let margin = if series().any(|s| !matches!(s.kind, Kind::Points | Kind::Rings)) { 0.0 } else { 0.06 };
        let values = series().flat_map(|s| s.points.iter().map(|p| p.0));
        Scale::over(&self.x, values, margin, (left, WIDTH - PAD))
    }

    fn markup(&self) -> (Markup, f64) {
        let many = self.panels.len() > 1;
        let height = if many { HEIGHT.1 } else { HEIGHT.0 };
        let scales: Vec<Scale> = (self.panels.iter())
            .map(|panel| {
                let limits = panel.limits.iter().map(|l| l.0);
                let values = panel.series.iter().flat_map(Series::extent).chain(limits);
                Scale::over(&panel.y, values, 0.06, (height, 0.0))
            })
            .collect();
        let ticks: Vec<_> = scales.iter().map(|y| y.ticks(if many { 4 } else { 6 })).collect();
        let longest = ticks.iter().flat_map(|t| &t.labels).map(|l| width(l)).fold(0.0, f64::max);
        let left = PAD + longest + 8.0;
        let x = self.x_scale(left);
        let mut below = 0.0;
        let count = self.panels.len();
        let panels = html! {
            @for (k, ((panel, y), ticks)) in self.panels.iter().zip(&scales).zip(&ticks).enumerate() {
                @let (drawn, tall) = self.draw(panel, &x, y, ticks, (height, k + 1 == count));
                (place(0.0, below, drawn))
                @let _ = below += tall;
            }
        };
        let lines: Vec<String> = self.remark.lines().flat_map(|line| wrap(line, WIDTH - 2.0 * PAD)).collect();
        let remark = html! {
            (panels)
            @for (k, line) in lines.iter().enumerate() { (text(PAD, below + LINE * (k as f64 + 1.0), "s", line)) }
        };
        (remark, below + if lines.is_empty() { 0.0 } else { LINE * lines.len() as f64 + PAD })
    }

    /// A panel, with its height: legend, label of the y axis, axes and series, label of the x axis.
    fn draw(
        &self,
        panel: &Panel,
        x: &Scale,
        y: &Scale,
        marks: &layout::Ticks,
        (height, lowest): (f64, bool),
    ) -> (Markup, f64) {
        // A series without a value is not in the figure, and so not in its legend.
        let is_drawn = |s: &Series| s.points.iter().any(|(a, b)| a.is_finite() && b.is_finite());
        let entries = panel.series.iter().filter(|s| !s.label.is_empty() && is_drawn(s)).map(|s| {
            let swatch = match s.kind {
                Kind::Rings => Swatch::Ring,
                Kind::Points => Swatch::Point,
                Kind::Band => Swatch::Area,
                _ => Swatch::Line(s.dash()),
            };
            (s.label.as_str(), s.colour % 8, swatch)
        });
        let (legend, above) = legend(entries.collect());
        let quantity = wrap(&marks.with_power(&panel.y.label(y)), WIDTH - 2.0 * PAD);
        let top = above + quantity.len() as f64 * LINE + 6.0;
        let (left, right) = x.pixels;
        let names: Vec<(f64, String)> = match self.categories.as_slice() {
            [] => x.ticks_that_fit().marks(),
            names => names.iter().enumerate().map(|(k, n)| (k as f64, n.clone())).collect(),
        };
        // A name is wrapped to the width of its category, and stands upright where it would be broken within a part; the tick numbers
        // already fit.
        let slot = if self.categories.is_empty() { WIDTH } else { (right - left) / names.len() as f64 - PAD };
        let parts = || {
            self.categories
                .iter()
                .flat_map(|name| name.split_inclusive([' ']).flat_map(|w| w.split_inclusive(BREAKS)))
        };
        let upright = parts().any(|part| width(part.trim_end()) > slot);
        let tall_names = if upright {
            names.iter().map(|(_, name)| width(name) / LINE).fold(0.0, f64::max)
        } else {
            names.iter().map(|(_, name)| wrap(name, slot).len()).max().unwrap_or(0) as f64
        };
        let x_label = wrap(&x.ticks_that_fit().with_power(&self.x.label(x)), right - left);
        let mut bottom = 14.0;
        let inside = html! {
            @for (value, name) in marks.marks() {
                @let py = y.at(value);
                path.g d={ "M" (n(left)) " " (n(py)) "H" (n(right)) } {}
                (text(left - 8.0, py + BASELINE, "e", &name))
            }
            @for (value, name) in &names {
                @let px = x.at(*value);
                path.g d={ "M" (n(px)) " 0V" (n(height)) } {}
                @if lowest && upright {
                    (layout::upright(px, height + 6.0, name))
                } @else if lowest {
                    @for (k, line) in wrap(name, slot).iter().enumerate() {
                        (layout::below(px, height + LINE * (k as f64 + 1.0), line))
                    }
                }
            }
            path.a d={ "M" (n(left)) " 0V" (n(height)) "H" (n(right)) } {}
            @for series in &panel.series { (draw_series(series, x, y, self.thin)) }
            @for (value, label) in &panel.limits {
                path.z d={ "M" (n(left)) " " (n(y.at(*value))) "H" (n(right)) } {}
                // Below the line where there is no room above.
                @let dy = if y.at(*value) < LINE { LINE - 3.0 } else { -5.0 };
                (text(left + 6.0, y.at(*value) + dy, "o", label))
            }
            // Below the label of a limit that is near the top.
            @let near_top = panel.limits.iter().map(|l| y.at(l.0)).filter(|py| *py < 2.5 * LINE);
            @let above = near_top.fold(0.0, |all: f64, py| all.max(py + LINE));
            @for (at, note) in &self.notes { (draw_note(x.at(*at), note, (left, right), above, height)) }
            @if lowest {
                @for (k, line) in x_label.iter().enumerate() {
                    (text(0.5 * (left + right), height + LINE * (k as f64 + tall_names + 1.1), "m", line))
                }
                @let _ = bottom += LINE * (x_label.len() as f64 + tall_names);
            }
        };
        let drawn = html! {
            (legend)
            @for (k, line) in quantity.iter().enumerate() {
                (text(PAD, above + LINE * k as f64 + 13.0, "s", line))
            }
            (place(0.0, top, inside))
        };
        (drawn, top + height + bottom)
    }
}

fn n(value: f64) -> String {
    format!("{value:.1}")
}

/// A vertical line with its remark, which is wrapped on the side that has more room.
fn draw_note(px: f64, note: &str, (left, right): (f64, f64), above: f64, height: f64) -> Markup {
    let after = right - px >= px - left;
    let (at, class, room) = if after { (px + 5.0, "o", right - px) } else { (px - 5.0, "e o", px - left) };
    html! {
        path.n d={ "M" (n(px)) " 0V" (n(height)) } {}
        @for (k, line) in wrap(note, room - 10.0).iter().enumerate() {
            (text(at, above + LINE * (k as f64 + 1.0) - 4.0, class, line))
        }
    }
}

fn draw_series(series: &Series, x: &Scale, y: &Scale, thin: bool) -> Markup {
    let colour = series.colour % 8;
    match series.kind {
        Kind::Band => {
            let known =
                series.points.iter().zip(&series.bars).filter(|((a, b), w)| (a + b + **w).is_finite());
            let edge = |sign: f64| {
                move |((a, b), w): (&(f64, f64), &f64)| {
                    format!("{:.1} {:.1}", x.at(*a), y.within(b + sign * w))
                }
            };
            let outline = known.clone().map(edge(1.0)).chain(known.rev().map(edge(-1.0)));
            let outline: Vec<String> = outline.collect();
            html! { path class={ "w d" (colour) } d={ "M" (outline.join("L")) "Z" } {} }
        }
        Kind::Rings => html! {
            @for (a, b) in series.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()) {
                circle class={ "k k" (colour) } cx=(n(x.at(*a))) cy=(n(y.at(*b))) r="4" {}
            }
        },
        Kind::Points => html! {
            // The rims of many points would cover their neighbours.
            @let (class, radius) = if series.points.len() > DENSE { ("d", "2") } else { ("p d", "4") };
            @for (k, (a, b)) in series.points.iter().enumerate().filter(|(_, p)| p.0.is_finite() && p.1.is_finite()) {
                @let (px, py) = (x.at(*a), y.at(*b));
                @match series.bars.get(k) {
                    // A small point, so that a short bar is seen on both sides of it.
                    Some(bar) => {
                        path class={ "k k" (colour) }
                            d=(format_args!("M{px:.1} {0:.1}V{1:.1}M{2:.1} {0:.1}h9M{2:.1} {1:.1}h9", y.at(b - bar), y.at(b + bar), px - 4.5)) {}
                        circle class={ "d" (colour) } cx=(n(px)) cy=(n(py)) r="2.2" {}
                    },
                    None => { circle class={ (class) (colour) } cx=(n(px)) cy=(n(py)) r=(radius) {} },
                }
            }
        },
        Kind::Line | Kind::Dashed => {
            let mut path = String::new();
            let points = thinned(&series.points);
            // Outside the frame, or no number: the line is interrupted. A value between two gaps is a point.
            let mut alone = Vec::new();
            for pieces in points.split(|(a, b)| !(x.holds(*a) && y.holds(*b))) {
                for (k, (a, b)) in pieces.iter().enumerate() {
                    path += &format!("{}{:.1} {:.1}", if k > 0 { 'L' } else { 'M' }, x.at(*a), y.at(*b));
                }
                alone.extend(if let [only] = pieces { Some(*only) } else { None });
            }
            let weight = if thin { "l h" } else { "l" };
            html! {
                path class={ (weight) " k" (colour) } stroke-dasharray=[series.dash()] d=(path) {}
                @for (a, b) in alone { circle class={ "d" (colour) } cx=(n(x.at(a))) cy=(n(y.at(b))) r="2.2" {} }
            }
        }
    }
}

impl Drawing for Figure {
    fn svg(&self) -> String {
        Figure::svg(self)
    }
}
