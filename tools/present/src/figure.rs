//! Figures as SVG: lines, points, bands and limits over one or more panels that share the x axis; rows with bars or intervals ([`Rows`]).
//!
//! A figure is 500 units wide with text of 13, so that a column of 390 pixels still shows text of 10. The layout follows the longest texts:
//! labels are wrapped and never cut.

mod axis;
mod columns;
mod layout;
mod notes;
mod panel;
mod points;
mod rows;
mod scale;
mod series;
#[cfg(test)]
mod tests;

pub use axis::Axis;
pub use rows::{Mark, Row, Rows};

use layout::{LINE, PAD, WIDTH, frame, place, text, width, wrap};
use maud::{Markup, html};
use panel::{Panel, Sheet};
use scale::Scale;
use series::{Kind, Series};

/// What can be drawn.
pub trait Drawing {
    /// The SVG, complete in itself.
    fn svg(&self) -> String;
}

/// Height of the only panel, and of one of several.
const HEIGHT: (f64, f64) = (220.0, 120.0);

/// Margins of the x axis in parts of its length: of points alone, of lines with marks or points, and before a line that jumps where it
/// begins.
const MARGINS: (f64, f64, f64) = (0.06, 0.015, 0.01);

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

    fn x_scale(&self, ys: &[Scale], left: f64) -> Scale {
        let series = || self.panels.iter().flat_map(|p| &p.series);
        // Lines may reach the frame, points may not.
        let is_curve = |s: &Series| s.is_line() || s.kind == Kind::Band;
        let margin = if !series().any(is_curve) {
            MARGINS.0
        } else if series().any(|s| s.is_drawn() && (s.is_marked() || !is_curve(s))) {
            MARGINS.1
        } else {
            0.0
        };
        let notes = self.notes.iter().map(|note| note.0);
        let values = series().flat_map(|s| s.points.iter().map(|p| p.0)).chain(notes);
        let mut scale = self.x.scale(values, margin, (left, WIDTH - PAD));
        let (from, length) = (scale.span.0, scale.span.1 - scale.span.0);
        let jumps = |(panel, y): (&Panel, &Scale)| {
            panel.series.iter().any(|s| s.is_line() && jumps(s, from + MARGINS.2 * length, y))
        };
        // A peak at the very begin would lie on the y axis.
        if margin == 0.0 && self.x.range().is_none() && self.panels.iter().zip(ys).any(jumps) {
            scale.span.0 -= MARGINS.2 * length;
        }
        scale
    }

    fn markup(&self) -> (Markup, f64) {
        let many = self.panels.len() > 1;
        let height = if many { HEIGHT.1 } else { HEIGHT.0 };
        let scales: Vec<Scale> = (self.panels.iter())
            .map(|panel| {
                let limits = panel.limits.iter().map(|l| l.0);
                let values = panel.series.iter().flat_map(Series::extent).chain(limits);
                panel.y.scale(values, 0.06, (height, 0.0))
            })
            .collect();
        let count = if many { 4 } else { 6 };
        let ticks: Vec<_> =
            self.panels.iter().zip(&scales).map(|(panel, y)| panel.y.ticks_upwards(y, count)).collect();
        let longest = ticks.iter().flat_map(|t| &t.labels).map(|l| width(l)).fold(0.0, f64::max);
        let x = self.x_scale(&scales, PAD + longest + 8.0);
        let notes = self.notes.iter().filter(|note| note.0.is_finite());
        let notes = notes.map(|(at, note)| (x.within(*at), note.as_str())).collect();
        let sheet = Sheet { axis: &self.x, x, categories: &self.categories, notes, thin: self.thin, height };
        let (mut below, mut has_bands) = (0.0, false);
        let last = self.panels.len().saturating_sub(1);
        let panels = html! {
            @for (k, ((panel, y), ticks)) in self.panels.iter().zip(&scales).zip(&ticks).enumerate() {
                @let sketch = panel.draw(&sheet, y, ticks, (k == 0, k == last));
                (place(0.0, below, sketch.markup))
                @let _ = { below += sketch.height; has_bands |= sketch.has_bands; };
            }
        };
        let mut remark = self.remark.clone();
        if has_bands {
            let pixels = sheet.x.pixels.1 - sheet.x.pixels.0;
            let window = points::WINDOW / pixels * (sheet.x.span.1 - sheet.x.span.0);
            let window = self.x.amount(&sheet.x, window);
            remark = format!("Band: least to greatest value in {window}, line: mean.\n{remark}");
        }
        let lines: Vec<String> = remark.lines().flat_map(|line| wrap(line, WIDTH - 2.0 * PAD)).collect();
        let remark = html! {
            (panels)
            @for (k, line) in lines.iter().enumerate() { (text(PAD, below + LINE * (k as f64 + 1.0), "s", line)) }
        };
        (remark, below + if lines.is_empty() { 0.0 } else { LINE * lines.len() as f64 + PAD })
    }
}

/// Whether a line changes by a quarter of its panel before an x.
fn jumps(series: &Series, until: f64, y: &Scale) -> bool {
    let begin = series.points.iter().filter(|p| p.0 <= until && p.1.is_finite()).map(|p| p.1);
    let (low, high) = begin.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    high - low > 0.25 * (y.span.1 - y.span.0)
}

impl Drawing for Figure {
    fn svg(&self) -> String {
        Figure::svg(self)
    }
}
