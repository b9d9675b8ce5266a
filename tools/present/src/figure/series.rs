//! What is drawn in a panel: lines, points, bands, and how those that lie over each other stay visible.

use super::columns::Columns;
use super::layout::Swatch;
use super::points::Drawn;
use super::scale::Scale;
use crate::COLOURS;
use maud::{Markup, html};

/// More points than this are small.
const DENSE: usize = 100;
/// A line of at most so many values has marks at them: what is between them is not known.
const FEW: usize = 30;
/// Radius of a point, of one in a line, and of one of many.
const RADIUS: (f64, f64, f64) = (4.0, 2.2, 2.0);
/// Lines that are this near in pixels hide each other.
const NEAR: f64 = 1.0;
/// Length of a dash of lines that share a way.
const DASH: usize = 6;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Line,
    Dashed,
    Points,
    Rings,
    Band,
}

#[derive(Clone, Debug)]
pub(super) struct Series {
    pub label: String,
    pub kind: Kind,
    pub colour: usize,
    pub points: Vec<(f64, f64)>,
    /// Half-lengths of the error bars of points; half-widths of a band.
    pub bars: Vec<f64>,
}

/// The place of a series among those that lie over each other: how many are below it, and how many they all are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rank {
    nth: usize,
    of: usize,
}

impl Series {
    /// The values that the y axis has to hold.
    pub fn extent(&self) -> impl Iterator<Item = f64> {
        let wide = |k: usize| self.bars.get(k).copied().filter(|w| w.is_finite()).unwrap_or(0.0);
        self.points.iter().enumerate().flat_map(move |(k, p)| [p.1 - wide(k), p.1 + wide(k)])
    }

    pub fn is_line(&self) -> bool {
        matches!(self.kind, Kind::Line | Kind::Dashed)
    }

    /// The points that have a place.
    fn known(&self) -> impl Iterator<Item = (usize, &(f64, f64))> {
        self.points.iter().enumerate().filter(|(_, p)| p.0.is_finite() && p.1.is_finite())
    }

    /// A series without a value is not in the figure, and so not in its legend.
    pub fn is_drawn(&self) -> bool {
        self.known().next().is_some()
    }

    /// Whether the values of a line are marked: few, each at an x of its own. A curve that goes back and forth is no function of x, and steps
    /// have two values at one x.
    pub fn is_marked(&self) -> bool {
        let few = self.known().count() <= FEW;
        let known = || self.known().map(|(_, p)| p.0);
        self.kind == Kind::Line
            && few
            && (known().is_sorted_by(|a, b| a < b) || known().is_sorted_by(|a, b| a > b))
    }

    /// The order of drawing: a dashed line and single points do not hide what is below them.
    pub fn layer(&self) -> usize {
        match self.kind {
            Kind::Dashed => 1,
            Kind::Rings => 2,
            Kind::Points if self.points.len() <= DENSE => 2,
            _ => 0,
        }
    }

    /// Dashes of a line that shares its way with others, so that all are seen: a dash for each in turn. Else dashes if requested, or if all
    /// colours are used.
    fn dash(&self, rank: Rank) -> Option<String> {
        if rank.nth > 0 {
            return Some(format!("{DASH} {}", DASH * (rank.of - 1)));
        }
        let dashes = match (self.kind == Kind::Dashed, self.colour / COLOURS) {
            (true, 0) => "6 4",
            (true, _) => "6 3 1 3",
            (_, 0) => return None,
            (_, 1) => "2 3",
            _ => "9 3 2 3",
        };
        Some(dashes.to_owned())
    }

    /// Whether a line lies below others that share its way, and is wide and pale.
    fn is_wide(&self, rank: Rank) -> bool {
        self.is_line() && rank.nth == 0 && rank.of > 1
    }

    /// Whether points are drawn as rings, and how large.
    fn ring(&self, rank: Rank) -> Option<f64> {
        match self.kind {
            Kind::Points if rank.nth > 0 => Some(RADIUS.0 + 3.0 * rank.nth as f64),
            Kind::Rings => Some(RADIUS.0),
            _ => None,
        }
    }

    /// The symbol in the legend.
    pub fn swatch(&self, rank: Rank) -> Swatch {
        match self.kind {
            Kind::Points | Kind::Rings => self.ring(rank).map_or(Swatch::Point, |_| Swatch::Ring),
            Kind::Band => Swatch::Area,
            // A key has no room for the gaps of many.
            _ if rank.nth > 0 => Swatch::Line(Some(format!("{DASH} {DASH}"))),
            _ if self.is_wide(rank) => Swatch::WideLine(self.dash(rank)),
            _ => Swatch::Line(self.dash(rank)),
        }
    }

    /// Covers what the series covers, in pixels.
    pub fn cover(&self, columns: &mut Columns, x: &Scale, y: &Scale) {
        let bar = |k: usize| self.bars.get(k).copied().filter(|w| w.is_finite()).unwrap_or(0.0);
        let edge = |sign: f64| {
            let points = self.points.iter().enumerate();
            points.map(|(k, p)| place(&(p.0, p.1 + sign * bar(k)), x, y)).collect::<Vec<_>>()
        };
        match self.kind {
            Kind::Band => [1.0, -1.0].into_iter().for_each(|sign| columns.trace(&edge(sign))),
            Kind::Line | Kind::Dashed => columns.trace(&edge(0.0)),
            Kind::Points | Kind::Rings => {
                for (k, p) in self.known() {
                    let ends = (y.at(p.1 + bar(k)) - RADIUS.0, y.at(p.1 - bar(k)) + RADIUS.0);
                    columns.cover(x.at(p.0), RADIUS.0, ends);
                }
            }
        }
    }

    /// The band of a crowded line, which lies below all lines.
    pub fn draw_bands(&self, drawn: &Drawn, x: &Scale, y: &Scale) -> Markup {
        let outline = |band: &[(f64, f64, f64)]| {
            let upper = band.iter().map(|(at, _, high)| (at, high));
            let lower = band.iter().rev().map(|(at, low, _)| (at, low));
            let edge = |(at, value): (&f64, &f64)| format!("{:.1} {:.1}", x.at(*at), y.at(*value));
            format!("M{}Z", upper.chain(lower).map(edge).collect::<Vec<_>>().join("L"))
        };
        html! { @for band in &drawn.bands { path class={ "q d" (self.colour()) " k" (self.colour()) } d=(outline(band)) {} } }
    }

    /// The number of the colour.
    pub fn colour(&self) -> usize {
        self.colour % COLOURS
    }

    pub fn draw(&self, drawn: &Drawn, rank: Rank, x: &Scale, y: &Scale, thin: bool) -> Markup {
        match self.kind {
            Kind::Band => self.draw_band(x, y),
            Kind::Points | Kind::Rings => self.draw_points(rank, x, y),
            Kind::Line | Kind::Dashed => self.draw_line(drawn, rank, x, y, thin),
        }
    }

    fn draw_band(&self, x: &Scale, y: &Scale) -> Markup {
        let known = self.points.iter().zip(&self.bars).filter(|((a, b), w)| (a + b + **w).is_finite());
        let edge = |sign: f64| {
            move |((a, b), w): (&(f64, f64), &f64)| format!("{:.1} {:.1}", x.at(*a), y.within(b + sign * w))
        };
        let outline: Vec<String> = known.clone().map(edge(1.0)).chain(known.rev().map(edge(-1.0))).collect();
        html! { path class={ "w d" (self.colour()) } d={ "M" (outline.join("L")) "Z" } {} }
    }

    fn draw_points(&self, rank: Rank, x: &Scale, y: &Scale) -> Markup {
        let colour = self.colour();
        // The rims of many points would cover their neighbours.
        let (class, radius) = if self.points.len() > DENSE { ("d", RADIUS.2) } else { ("p d", RADIUS.0) };
        html! {
            @for (k, (a, b)) in self.known() {
                @let (px, py) = (x.at(*a), y.at(*b));
                @match (self.bars.get(k), self.ring(rank)) {
                    // A small point, so that a short bar is seen on both sides of it.
                    (Some(bar), _) => {
                        path class={ "k k" (colour) }
                            d=(format_args!("M{px:.1} {0:.1}V{1:.1}M{2:.1} {0:.1}h9M{2:.1} {1:.1}h9", y.at(b - bar), y.at(b + bar), px - 4.5)) {}
                        circle class={ "d" (colour) } cx=(n(px)) cy=(n(py)) r=(RADIUS.1) {}
                    },
                    (None, Some(radius)) => { circle class={ "k k" (colour) } cx=(n(px)) cy=(n(py)) r=(radius) {} },
                    (None, None) => { circle class={ (class) (colour) } cx=(n(px)) cy=(n(py)) r=(radius) {} },
                }
            }
        }
    }

    fn draw_line(&self, drawn: &Drawn, rank: Rank, x: &Scale, y: &Scale, thin: bool) -> Markup {
        let colour = self.colour();
        let mut path = String::new();
        // Outside the frame, or no number: the line is interrupted. A value between two gaps is a point.
        let mut marks = Vec::new();
        let is_marked = self.is_marked();
        for pieces in drawn.line.split(|(a, b)| !(x.holds(*a) && y.holds(*b))) {
            for (k, p) in pieces.iter().enumerate() {
                let (px, py) = place(p, x, y);
                path += &format!("{}{px:.1} {py:.1}", if k > 0 { 'L' } else { 'M' });
            }
            marks.extend_from_slice(if is_marked || pieces.len() == 1 { pieces } else { &[] });
        }
        let weight = match (thin, self.is_wide(rank)) {
            (false, false) => "l",
            (false, true) => "l u",
            (true, false) => "l h",
            (true, true) => "l h u",
        };
        // The only value of a line is as large as a point.
        let radius = if self.known().count() == 1 { RADIUS.0 } else { RADIUS.1 };
        let offset = (rank.nth > 0).then(|| format!("-{}", DASH * rank.nth));
        html! {
            path class={ (weight) " k" (colour) } stroke-dasharray=[self.dash(rank)] stroke-dashoffset=[offset] d=(path) {}
            @for (a, b) in marks { circle class={ "d" (colour) } cx=(n(x.at(a))) cy=(n(y.at(b))) r=(radius) {} }
        }
    }
}

/// A point in pixels; what the panel does not hold has no place.
fn place(p: &(f64, f64), x: &Scale, y: &Scale) -> (f64, f64) {
    let is_inside = x.holds(p.0) && y.holds(p.1);
    if is_inside { (x.at(p.0), y.at(p.1)) } else { (f64::NAN, f64::NAN) }
}

/// Which series of a panel lie over each other, by what is drawn of them. A line that agrees within a pixel with an earlier one over most of
/// the way of one of them would hide it, and so would points that lie on earlier ones.
pub(super) fn ranks(series: &[Series], drawn: &[Drawn], x: &Scale, y: &Scale) -> Vec<Rank> {
    let traced: Vec<Columns> = drawn
        .iter()
        .map(|drawn| {
            let mut columns = Columns::over(x);
            columns.trace(&drawn.line.iter().map(|p| place(p, x, y)).collect::<Vec<_>>());
            columns
        })
        .collect();
    let mut order: Vec<usize> = (0..series.len()).collect();
    order.sort_by_key(|k| series[*k].layer());
    // The first series of each group stands for it.
    let mut group: Vec<usize> = (0..series.len()).collect();
    for (later, k) in order.iter().enumerate() {
        let hides = |j: &&usize| match (series[*k].is_line(), series[**j].is_line()) {
            (true, true) => {
                let shortest = traced[*k].len().min(traced[**j].len());
                2 * traced[*k].shared(&traced[**j], NEAR) > shortest
            }
            (false, false) => hides_points(&series[*k], &series[**j], x, y),
            _ => false,
        };
        if let Some(j) = order[..later].iter().find(hides) {
            group[*k] = group[*j];
        }
    }
    let mut ranks = vec![Rank { nth: 0, of: 1 }; series.len()];
    for (later, k) in order.iter().enumerate() {
        let nth = order[..later].iter().filter(|j| group[**j] == group[*k]).count();
        ranks[*k] = Rank { nth, of: group.iter().filter(|g| **g == group[*k]).count() };
    }
    ranks
}

/// Whether most of the points of one of two series lie on points of the other. Error bars and rings show what is below them.
fn hides_points(later: &Series, earlier: &Series, x: &Scale, y: &Scale) -> bool {
    let is_plain = |s: &Series| s.kind == Kind::Points && s.bars.is_empty() && s.points.len() <= DENSE;
    if !is_plain(later) || !is_plain(earlier) {
        return false;
    }
    let places = |s: &Series| s.known().map(|(_, p)| place(p, x, y)).collect::<Vec<_>>();
    let (above, below) = (places(later), places(earlier));
    let is_near = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).hypot(a.1 - b.1) <= 2.0 * NEAR;
    let hidden = below.iter().filter(|b| above.iter().any(|a| is_near(a, b))).count();
    2 * hidden > above.len().min(below.len())
}

fn n(value: f64) -> String {
    format!("{value:.1}")
}
