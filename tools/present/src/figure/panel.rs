//! A panel: legend, label of the y axis, axes, series, limits, label of the x axis.

use super::axis::Axis;
use super::columns::Columns;
use super::layout::{self, BASELINE, BREAKS, LINE, PAD, Swatch, WIDTH, legend, place, text, width, wrap};
use super::notes::{Strip, strip};
use super::points::{Drawn, drawn};
use super::scale::{Scale, Ticks};
use super::series::{Rank, Series, ranks};
use maud::{Markup, html};

#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub y: Axis,
    pub series: Vec<Series>,
    pub limits: Vec<(f64, String)>,
    pub next_colour: usize,
}

/// What all panels of a figure share.
pub(super) struct Sheet<'a> {
    pub axis: &'a Axis,
    pub x: Scale,
    pub categories: &'a [String],
    /// Notes with their places in pixels.
    pub notes: Vec<(f64, &'a str)>,
    pub thin: bool,
    /// Height of the frame of a panel.
    pub height: f64,
}

/// A panel as it was drawn.
pub(super) struct Sketch {
    pub markup: Markup,
    pub height: f64,
    /// Whether a line is drawn as a band, which needs a remark.
    pub has_bands: bool,
}

impl Panel {
    /// Draws the panel; the notes stand above the first one, the labels of the x axis below the lowest.
    pub fn draw(&self, sheet: &Sheet, y: &Scale, marks: &Ticks, (first, lowest): (bool, bool)) -> Sketch {
        let (x, height) = (&sheet.x, sheet.height);
        let (left, right) = x.pixels;
        let parts: Vec<Drawn> = self.series.iter().map(|s| as_drawn(s, x, y, sheet.thin)).collect();
        let ranks = ranks(&self.series, &parts, x, y);
        let labels = self.labels_of_limits(sheet, y);
        let (legend, above) = self.legend(&ranks, &labels);
        let quantity = wrap(&self.y.title(y, marks), WIDTH - 2.0 * PAD);
        let notes: &[_] = if first { &sheet.notes } else { &[] };
        let strip: Strip = strip(notes, right);
        let top = above + quantity.len() as f64 * LINE + 6.0 + strip.height();
        let mut order: Vec<usize> = (0..self.series.len()).collect();
        order.sort_by_key(|k| self.series[*k].layer());
        let below = BelowX::of(sheet);
        let inside = html! {
            @for (value, name) in marks.marks() {
                @let py = y.at(value);
                path.g d=(format_args!("M{left:.1} {py:.1}H{right:.1}")) {}
                (text(left - 8.0, py + BASELINE, "e", &name))
            }
            @for (value, _) in &below.names { path.g d=(format_args!("M{:.1} 0V{height:.1}", x.at(*value))) {} }
            @if lowest { (below.names(x, height)) }
            path.a d=(format_args!("M{left:.1} 0V{height:.1}H{right:.1}")) {}
            @for (series, part) in self.series.iter().zip(&parts) { (series.draw_bands(part, x, y)) }
            @for k in &order { (self.series[*k].draw(&parts[*k], ranks[*k], x, y, sheet.thin)) }
            @if !first { @for (px, _) in &sheet.notes { path.n d=(format_args!("M{px:.1} 0V{height:.1}")) {} } }
            @for ((value, label), at) in self.limits.iter().zip(&labels) {
                path.z d=(format_args!("M{left:.1} {:.1}H{right:.1}", y.at(*value))) {}
                @if let Some((px, py)) = at { (text(*px, *py, "o", label)) }
            }
            (strip.draw(height))
            @if lowest { (below.label(x, height)) }
        };
        let markup = html! {
            (legend)
            @for (k, line) in quantity.iter().enumerate() {
                (text(PAD, above + LINE * k as f64 + 13.0, "s", line))
            }
            (place(0.0, top, inside))
        };
        let height = top + height + 14.0 + if lowest { below.height() } else { 0.0 };
        Sketch { markup, height, has_bands: parts.iter().any(|part| !part.bands.is_empty()) }
    }

    /// The names of series, and of the limits for which there is no free place in the panel.
    fn legend(&self, ranks: &[Rank], labels: &[Option<(f64, f64)>]) -> (Markup, f64) {
        let named = self.series.iter().zip(ranks).filter(|(s, _)| !s.label.is_empty() && s.is_drawn());
        let named = named.map(|(s, rank)| (s.label.as_str(), s.colour(), s.swatch(*rank)));
        let without_place =
            self.limits.iter().zip(labels).filter(|((_, label), at)| at.is_none() && !label.is_empty());
        let limits = without_place.map(|((_, label), _)| (label.as_str(), 0, Swatch::Limit));
        legend(named.chain(limits).collect())
    }

    /// Begin and baseline of the label of each limit at a place of its line where it hides nothing: from the left, above the line rather than
    /// below it. None where there is no such place.
    fn labels_of_limits(&self, sheet: &Sheet, y: &Scale) -> Vec<Option<(f64, f64)>> {
        let (x, (left, right)) = (&sheet.x, sheet.x.pixels);
        let mut covered = Columns::over(x);
        for series in self.series.iter().filter(|_| !self.limits.is_empty()) {
            series.cover(&mut covered, x, y);
        }
        // Boxes that are taken.
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let mut places = Vec::new();
        for (k, (value, label)) in self.limits.iter().enumerate() {
            let (py, wide) = (y.at(*value), width(label));
            let room = right - left - 12.0 - wide;
            let free = |px: f64, baseline: f64| {
                let (from, to, low, high) = (px - 3.0, px + wide + 3.0, baseline - 12.0, baseline + 4.0);
                let others = self.limits.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, l)| y.at(l.0));
                low >= 0.0
                    && high <= sheet.height
                    && !covered.meets((from, to), (low, high))
                    && others.clone().all(|other| other < low || other > high)
                    && sheet.notes.iter().all(|note| note.0 < from || note.0 > to)
                    && taken.iter().all(|[l, r, t, b]| to < *l || from > *r || high < *t || low > *b)
            };
            let along = [0.0, 1.0, 0.5, 0.25, 0.75].map(|part| left + 6.0 + part * room);
            let candidates = [py - 5.0, py + LINE - 3.0].map(|baseline| along.map(|px| (px, baseline)));
            // Each end above and below before the middle.
            let ordered = (0..along.len()).flat_map(|k| candidates.map(|of| of[k]));
            let found = ordered.into_iter().find(|(px, baseline)| room >= 0.0 && free(*px, *baseline));
            taken.extend(found.map(|(px, b)| [px - 3.0, px + wide + 3.0, b - 12.0, b + 4.0]));
            places.push(found);
        }
        places
    }
}

/// What is drawn of a series; points and bands of half-widths are drawn as they are.
fn as_drawn(series: &Series, x: &Scale, y: &Scale, thin: bool) -> Drawn {
    let weight = if thin { 1.0 } else { 2.0 };
    if series.is_line() { drawn(&series.points, x, y, weight) } else { Drawn::default() }
}

/// Names of ticks or categories, and the label of the x axis.
struct BelowX {
    names: Vec<(f64, String)>,
    /// Width that a name has, and whether names stand upright.
    slot: f64,
    upright: bool,
    /// Height of the names in lines.
    tall: f64,
    title: Vec<String>,
}

impl BelowX {
    fn of(sheet: &Sheet) -> BelowX {
        let (x, (left, right)) = (&sheet.x, sheet.x.pixels);
        let ticks = x.ticks_that_fit();
        let names: Vec<(f64, String)> = match sheet.categories {
            [] => ticks.marks(),
            names => names.iter().enumerate().map(|(k, n)| (k as f64, n.clone())).collect(),
        };
        // A name is wrapped to the width of its category, and stands upright where it would be broken within a part; the tick numbers
        // already fit.
        let slot =
            if sheet.categories.is_empty() { WIDTH } else { (right - left) / names.len() as f64 - PAD };
        let parts = || {
            let words = sheet.categories.iter().flat_map(|name| name.split_inclusive([' ']));
            words.flat_map(|word| word.split_inclusive(BREAKS))
        };
        let upright = parts().any(|part| width(part.trim_end()) > slot);
        let tall = if upright {
            names.iter().map(|(_, name)| width(name) / LINE).fold(0.0, f64::max)
        } else {
            names.iter().map(|(_, name)| wrap(name, slot).len()).max().unwrap_or(0) as f64
        };
        let title = wrap(&sheet.axis.title(x, &ticks), right - left);
        BelowX { names, slot, upright, tall, title }
    }

    fn height(&self) -> f64 {
        LINE * (self.title.len() as f64 + self.tall)
    }

    fn names(&self, x: &Scale, height: f64) -> Markup {
        html! {
            @for (value, name) in &self.names {
                @let px = x.at(*value);
                @if self.upright {
                    (layout::upright(px, height + 6.0, name))
                } @else {
                    @for (k, line) in wrap(name, self.slot).iter().enumerate() {
                        (layout::below(px, height + LINE * (k as f64 + 1.0), line))
                    }
                }
            }
        }
    }

    fn label(&self, x: &Scale, height: f64) -> Markup {
        let middle = 0.5 * (x.pixels.0 + x.pixels.1);
        html! {
            @for (k, line) in self.title.iter().enumerate() {
                (text(middle, height + LINE * (k as f64 + self.tall + 1.1), "m", line))
            }
        }
    }
}
