//! Figures with a row for each name: bars from zero, and points with intervals. The name stands above its marks.

use super::layout::{BASELINE, LINE, PAD, Swatch, WIDTH, below, frame, legend, place, text, width, wrap};
use super::scale::Scale;
use super::{Axis, Drawing};
use maud::{Markup, html};

/// Height of the marks of a row, and of what is free between its name and them and below them.
const STRIP: f64 = 20.0;
const FREE: (f64, f64) = (3.0, 6.0);

/// What stands in a row.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A bar from zero, with a remark at its end.
    Bar(f64, String),
    /// A pale bar from one value to another.
    Span(f64, f64),
    /// A point with its interval; one that is no number is left out.
    Point(f64, (f64, f64)),
}

/// One row.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// What stands in it, each with the number of its series, which is its colour.
    pub marks: Vec<(usize, Mark)>,
}

/// A figure with a row for each name.
#[derive(Clone, Debug)]
pub struct Rows {
    title: String,
    axis: Axis,
    series: Vec<String>,
    rows: Vec<Row>,
}

impl Rows {
    /// A figure; `label` is the quantity of its axis, `series` are the names in its legend.
    pub fn new(title: &str, label: &str, series: &[&str], rows: Vec<Row>) -> Rows {
        let series = series.iter().map(|s| (*s).to_owned()).collect();
        Rows { title: title.to_owned(), axis: Axis::new(label), series, rows }
    }

    fn marks(&self) -> impl Iterator<Item = &(usize, Mark)> {
        self.rows.iter().flat_map(|r| &r.marks)
    }

    /// The axis: all that is shown, and zero; room for the remarks at its ends.
    fn scale(&self) -> Scale {
        let ends = self.marks().flat_map(|(_, mark)| match mark {
            Mark::Bar(to, _) => [0.0, *to, 0.0],
            Mark::Span(from, to) => [*from, *to, 0.0],
            Mark::Point(at, (low, high)) => [*at, *low, *high],
        });
        let remark = self.marks().map(|(_, mark)| if let Mark::Bar(_, r) = mark { width(r) } else { 0.0 });
        let right = WIDTH - PAD - remark.fold(0.0, f64::max) - 6.0;
        let mut scale = self.axis.scale(ends.chain([0.0]), 0.04, (PAD, right));
        if self.marks().all(|(_, m)| matches!(m, Mark::Bar(to, _) if to.is_nan() || *to >= 0.0)) {
            scale.span.0 = 0.0;
        }
        scale
    }

    fn swatch(&self, series: usize) -> Swatch {
        match self.marks().find(|(k, _)| *k == series) {
            Some((_, Mark::Bar(..) | Mark::Span(..))) => Swatch::Area,
            _ => Swatch::Point,
        }
    }
}

impl Drawing for Rows {
    fn svg(&self) -> String {
        let x = self.scale();
        let entries = self.series.iter().enumerate().filter(|(_, s)| !s.is_empty());
        let (legend, top) = legend(entries.map(|(k, s)| (s.as_str(), k, self.swatch(k))).collect());
        let ticks = x.ticks_that_fit();
        let quantity = wrap(&self.axis.title(&x, &ticks), x.pixels.1 - x.pixels.0);
        let names: Vec<_> = self.rows.iter().map(|row| wrap(&row.name, WIDTH - 2.0 * PAD)).collect();
        let tall = |name: &Vec<String>| LINE * name.len() as f64 + FREE.0 + STRIP + FREE.1;
        let bottom = names.iter().map(tall).sum::<f64>() + 2.0;
        let mut y = 0.0;
        let rows = html! {
            @for (value, name) in ticks.marks() {
                // A grid line behind a name would strike it through.
                @let (mut y, mut line) = (0.0, String::new());
                @let _ = for name in &names {
                    let below_name = y + LINE * name.len() as f64 + 1.0;
                    y += tall(name);
                    line += &format!("M{:.1} {below_name:.1}V{y:.1}", x.at(value));
                };
                path class=(if value == 0.0 { "a" } else { "g" }) d=(line) {}
                (below(x.at(value), bottom + LINE - 2.0, &name))
            }
            path.a d=(format_args!("M{:.1} {bottom:.1}H{:.1}", x.pixels.0, x.pixels.1)) {}
            @for (row, name) in self.rows.iter().zip(&names) {
                @for (k, line) in name.iter().enumerate() { (text(PAD + 2.0, y + LINE * (k as f64 + 1.0) - 4.0, "o", line)) }
                (draw(row, &x, y + LINE * name.len() as f64 + FREE.0 + 0.5 * STRIP))
                @let _ = y += tall(name);
            }
            @for (k, line) in quantity.iter().enumerate() {
                (text(0.5 * (x.pixels.0 + x.pixels.1), bottom + LINE * (k as f64 + 2.0), "m", line))
            }
        };
        let content = html! { (legend) (place(0.0, top + 4.0, rows)) };
        frame(&self.title, content, top + bottom + LINE * (quantity.len() as f64 + 1.0) + 16.0)
    }
}

fn draw(row: &Row, x: &Scale, y: f64) -> Markup {
    let points = row.marks.iter().filter(|(_, m)| matches!(m, Mark::Point(..))).count();
    let mut nth = 0;
    // What is wide lies below; points stand in the order of the legend, whatever the order they are given in.
    let mut marks: Vec<_> = row.marks.iter().collect();
    marks.sort_by_key(|(series, mark)| (matches!(mark, Mark::Point(..)), *series));
    let bar = |class: String, from: f64, to: f64, height: f64| {
        let (left, right) = (x.at(from.min(to)), x.at(from.max(to)));
        html! {
            rect class=(class) x=(format_args!("{left:.1}")) y=(format_args!("{:.1}", y - 0.5 * height))
                width=(format_args!("{:.1}", right - left)) height=(height) rx="2" {}
        }
    };
    html! {
        @for (colour, mark) in marks {
            @match mark {
                Mark::Bar(to, remark) if to.is_finite() => {
                    (bar(format!("d{colour}"), 0.0, *to, 14.0))
                    (text(x.at(to.max(0.0)) + 6.0, y + BASELINE, "", remark))
                },
                Mark::Span(from, to) if (from + to).is_finite() => { (bar(format!("w d{colour}"), *from, *to, STRIP)) },
                Mark::Point(at, (low, high)) => {
                    // One above the other, so that intervals do not hide each other.
                    @let py = y + 9.0 * (f64::from(nth) - 0.5 * (points as f64 - 1.0));
                    @let _ = nth += 1;
                    @if (low + high).is_finite() {
                        path class={ "l k" (colour) } d=(format_args!("M{:.1} {py:.1}H{:.1}", x.at(*low), x.at(*high))) {}
                    }
                    @if at.is_finite() {
                        circle class={ "p d" (colour) } cx=(format_args!("{:.1}", x.at(*at))) cy=(format_args!("{py:.1}")) r="4" {}
                    }
                },
                _ => {},
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, marks: Vec<(usize, Mark)>) -> Row {
        Row { name: name.to_owned(), marks }
    }

    /// From 12 to 482 pixels for 0 to 1.04: the bar of 0.5 is half as long as that of 1.
    #[test]
    fn bars_are_as_long_as_their_value() {
        let bars = [1.0, 0.5].map(|v| row("a < b", vec![(0, Mark::Bar(v, String::new()))]));
        let svg = Rows::new("t", "fraction", &[], bars.to_vec()).svg();
        assert!(svg.contains("width=\"451.9\"") && svg.contains("width=\"226.0\""), "{svg}");
        assert!(svg.contains("a &lt; b"));
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let nan = f64::NAN;
        let marks = vec![
            (0, Mark::Bar(nan, String::new())),
            (1, Mark::Point(nan, (nan, nan))),
            (2, Mark::Point(1.0, (nan, 2.0))),
        ];
        let svg = Rows::new("t", "l", &["s"], vec![row("a", marks)]).svg();
        assert!(!svg.contains("NaN") && svg.matches("<circle").count() == 1, "{svg}");
        assert!(!Rows::new("t", "l", &[], Vec::new()).svg().contains("NaN"));
    }

    /// The first name of the legend is the upper point, and no grid line goes through a name.
    #[test]
    fn points_stand_in_the_order_of_the_legend() {
        let point = |series: usize, at: f64| (series, Mark::Point(at, (at - 0.1, at + 0.1)));
        let given = vec![(2, Mark::Span(-1.0, 1.0)), point(1, 0.5), point(0, 0.6)];
        let svg = Rows::new("t", "l", &["after", "refit", "prior"], vec![row("gain_phys", given)]).svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let y = |class: &str| {
            let mut points = document
                .descendants()
                .filter(|n| n.attribute("class") == Some(class) && n.has_tag_name("circle"));
            points.next_back().unwrap().attribute("cy").unwrap().parse::<f64>().unwrap()
        };
        assert!(y("p d0") < y("p d1"), "{svg}");
        let grid = document
            .descendants()
            .filter(|n| n.attribute("class") == Some("g"))
            .filter_map(|n| n.attribute("d"));
        assert!(grid.clone().count() > 2);
        for line in grid {
            let top: f64 = line[1..].split([' ', 'V']).nth(1).unwrap().parse().unwrap();
            assert!(top > LINE, "{line}");
        }
    }
}
