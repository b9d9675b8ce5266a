//! Figures with a row for each name: bars from zero, and points with intervals.

use super::{Drawing, Scale, escaped, style, tick};
use std::fmt::Write;

/// Width of a figure, and its margin on the right.
const WIDTH: (f64, f64) = (660.0, 60.0);
/// Width of a letter of a name, and limits of the names' column.
const NAMES: (f64, f64, f64) = (6.9, 120.0, 330.0);
/// Height of a row, of what stands above the rows, and below.
const HEIGHT: (f64, f64, f64) = (30.0, 66.0, 52.0);

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
    label: String,
    series: Vec<String>,
    rows: Vec<Row>,
}

impl Rows {
    /// A figure; `label` is what its axis shows, `series` are the names in its legend.
    pub fn new(title: &str, label: &str, series: &[&str], rows: Vec<Row>) -> Rows {
        let series = series.iter().map(|s| (*s).to_owned()).collect();
        Rows { title: title.to_owned(), label: label.to_owned(), series, rows }
    }

    /// Width of the names' column.
    fn names(&self) -> f64 {
        let longest = self.rows.iter().map(|r| r.name.chars().count()).max().unwrap_or(0);
        (NAMES.0 * longest as f64 + 20.0).clamp(NAMES.1, NAMES.2)
    }

    /// The axis: all that is shown, and zero.
    fn span(&self) -> (f64, f64) {
        let ends = self.rows.iter().flat_map(|r| &r.marks).flat_map(|(_, mark)| match mark {
            Mark::Bar(to, _) => [0.0, *to, 0.0],
            Mark::Span(from, to) => [*from, *to, 0.0],
            Mark::Point(at, (low, high)) => [*at, *low, *high],
        });
        let (low, high) =
            ends.filter(|v| v.is_finite()).fold((0.0f64, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        let pad = 0.04 * (high - low);
        if high > low { (if low < 0.0 { low - pad } else { 0.0 }, high + pad) } else { (0.0, 1.0) }
    }
}

impl Drawing for Rows {
    fn svg(&self) -> String {
        let (row, above, below) = HEIGHT;
        let bottom = above + row * self.rows.len() as f64;
        let (height, left, right) = (bottom + below, self.names(), WIDTH.0 - WIDTH.1);
        let x = Scale::new(self.span(), (left, right));
        let mut out = format!(
            "<svg class=\"f\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" width=\"{}\" \
             height=\"{height}\" role=\"img\" aria-label=\"{title}\"><style>{}</style>\
             <rect class=\"b\" width=\"100%\" height=\"100%\"/><text class=\"t\" x=\"12\" y=\"24\">{title}</text>",
            WIDTH.0,
            WIDTH.0,
            style(),
            title = escaped(&self.title)
        );
        for value in x.ticks(6) {
            let px = x.at(value);
            let _ = write!(
                out,
                "<line class=\"g\" x1=\"{px:.1}\" x2=\"{px:.1}\" y1=\"{above}\" y2=\"{bottom}\"/>\
                 <text text-anchor=\"middle\" x=\"{px:.1}\" y=\"{}\">{}</text>",
                bottom + 18.0,
                tick(value, x.span.1 - x.span.0)
            );
        }
        let zero = x.at(0.0);
        let _ = write!(
            out,
            "<line class=\"a\" x1=\"{zero:.1}\" x2=\"{zero:.1}\" y1=\"{above}\" y2=\"{bottom}\"/>\
             <text text-anchor=\"middle\" x=\"{:.1}\" y=\"{}\">{}</text>",
            0.5 * (left + right),
            bottom + 40.0,
            escaped(&self.label)
        );
        for (k, series) in self.series.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
            let px = left + 110.0 * k as f64;
            let _ = write!(
                out,
                "<circle class=\"p d{k}\" cx=\"{px}\" cy=\"46\" r=\"4.5\"/><text x=\"{}\" y=\"50\">{}</text>",
                px + 10.0,
                escaped(series)
            );
        }
        for (k, row_of) in self.rows.iter().enumerate() {
            let y = above + row * (k as f64 + 0.5);
            let _ = write!(
                out,
                "<text text-anchor=\"end\" x=\"{}\" y=\"{:.1}\">{}</text>",
                left - 10.0,
                y + 4.0,
                escaped(&row_of.name)
            );
            draw(&mut out, row_of, &x, y);
        }
        out + "</svg>"
    }
}

fn draw(out: &mut String, row: &Row, x: &Scale, y: f64) {
    let points = row.marks.iter().filter(|(_, m)| matches!(m, Mark::Point(..))).count();
    let mut nth = 0;
    for (colour, mark) in &row.marks {
        match mark {
            Mark::Bar(to, _) if !to.is_finite() => {}
            Mark::Bar(to, remark) => {
                let (left, right) = (x.at(to.min(0.0)), x.at(to.max(0.0)));
                let _ = write!(
                    out,
                    "<rect class=\"d{colour}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"14\" rx=\"2\"/>\
                     <text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                    y - 7.0,
                    right - left,
                    right + 6.0,
                    y + 4.0,
                    escaped(remark)
                );
            }
            Mark::Span(from, to) => {
                let (left, right) = (x.at(*from), x.at(*to));
                let _ = write!(
                    out,
                    "<rect class=\"w d{colour}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"22\" rx=\"2\"/>",
                    y - 11.0,
                    right - left
                );
            }
            Mark::Point(at, (low, high)) => {
                // One above the other, so that intervals do not hide each other.
                let py = y + 9.0 * (nth as f64 - 0.5 * (points as f64 - 1.0));
                nth += 1;
                if low.is_finite() && high.is_finite() {
                    let _ = write!(
                        out,
                        "<path class=\"l k{colour}\" d=\"M{:.1} {py:.1}H{:.1}\"/>",
                        x.at(*low),
                        x.at(*high)
                    );
                }
                if at.is_finite() {
                    let _ = write!(
                        out,
                        "<circle class=\"p d{colour}\" cx=\"{:.1}\" cy=\"{py:.1}\" r=\"4\"/>",
                        x.at(*at)
                    );
                }
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

    /// From 120 to 600 pixels for 0 to 1.04: a bar of 0.5 is 230.8 pixels wide.
    #[test]
    fn bars_are_as_long_as_their_value() {
        let bars = [1.0, 0.5].map(|v| row("a < b", vec![(0, Mark::Bar(v, String::new()))]));
        let svg = Rows::new("t", "share", &[], bars.to_vec()).svg();
        assert!(svg.contains("width=\"461.5\"") && svg.contains("width=\"230.8\""), "{svg}");
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
        assert!(!svg.contains("NaN") && svg.matches("<circle").count() == 2, "{svg}");
        assert!(!Rows::new("t", "l", &[], Vec::new()).svg().contains("NaN"));
    }
}
