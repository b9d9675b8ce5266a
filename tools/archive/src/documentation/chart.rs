//! Line charts as SVG, written by hand: no fonts or scripts from elsewhere, and the same bytes at every run.

use super::escape;
use std::fmt::Write;

/// A line: its label and its points.
pub type Line = (String, Vec<(f64, f64)>);

/// A chart with two axes.
pub struct Chart {
    /// What it shows, one line.
    pub title: String,
    /// Label of the axis below, with unit.
    pub x: String,
    /// Label of the axis at the left, with unit.
    pub y: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// A dashed line across, with its label.
    pub limit: Option<(f64, String)>,
}

/// Size of the picture and of the margins around the axes.
const SIZE: (f64, f64) = (680.0, 340.0);
const LEFT: f64 = 64.0;
const RIGHT: f64 = 200.0;
const TOP: f64 = 34.0;
const BELOW: f64 = 48.0;
/// Colours that stay apart for colour-blind readers.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];

/// An axis: its ends, on round numbers, and the distance of its marks.
struct Axis {
    from: f64,
    to: f64,
    mark: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64>) -> Axis {
        let (low, high) =
            values.filter(|v| v.is_finite()).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        let (low, high) = if low < high { (low, high) } else { (low.min(0.0), low.max(0.0) + 1.0) };
        let rough = (high - low) / 5.0;
        let power = 10f64.powf(rough.log10().floor());
        let mark = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= rough).unwrap_or(10.0);
        Axis { from: (low / mark + 1e-9).floor() * mark, to: (high / mark - 1e-9).ceil() * mark, mark }
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.from) / (self.to - self.from)
    }

    fn marks(&self) -> impl Iterator<Item = f64> {
        let count = ((self.to - self.from) / self.mark).round() as usize;
        (0..=count).map(|k| self.from + k as f64 * self.mark)
    }

    /// A number at a mark, with the digits that marks differ in.
    fn label(&self, value: f64) -> String {
        let digits = (-self.mark.log10().floor()).max(0.0) as usize;
        let text = format!("{value:.digits$}");
        if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".into() } else { text }
    }
}

impl Chart {
    /// The picture.
    pub fn svg(&self) -> String {
        let points = || self.lines.iter().flat_map(|(_, points)| points.iter());
        let x = Axis::over(points().map(|p| p.0));
        let y = Axis::over(points().map(|p| p.1).chain(self.limit.iter().map(|l| l.0)));
        let (right, bottom) = (SIZE.0 - RIGHT, SIZE.1 - BELOW);
        let at_x = |v: f64| LEFT + x.share(v) * (right - LEFT);
        let at_y = |v: f64| bottom - y.share(v) * (bottom - TOP);
        let mut svg = format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\">\n\
             <text x=\"{LEFT}\" y=\"20\" class=\"title\">{}</text>\n",
            SIZE.0,
            SIZE.1,
            escape(&self.title),
            escape(&self.title)
        );
        for mark in x.marks() {
            let at = at_x(mark);
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                x.label(mark)
            );
        }
        for mark in y.marks() {
            let at = at_y(mark);
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{LEFT} {at:.1}H{right}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 8.0,
                at + 4.0,
                y.label(mark)
            );
        }
        let (middle_x, middle_y) = ((LEFT + right) / 2.0, (TOP + bottom) / 2.0);
        let _ = writeln!(
            svg,
            "<text x=\"{middle_x}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
             <text transform=\"translate(16 {middle_y}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            SIZE.1 - 8.0,
            escape(&self.x),
            escape(&self.y)
        );
        let mut entry = TOP + 8.0;
        let mut legend = |svg: &mut String, style: &str, label: &str| {
            let (x1, x2) = (right + 14.0, right + 38.0);
            let _ = writeln!(
                svg,
                "<path {style} d=\"M{x1} {entry}H{x2}\"/><text x=\"{}\" y=\"{}\">{}</text>",
                x2 + 6.0,
                entry + 4.0,
                escape(label)
            );
            entry += 22.0;
        };
        for ((label, points), colour) in self.lines.iter().zip(COLOURS.iter().cycle()) {
            let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"");
            let path: Vec<String> =
                points.iter().map(|p| format!("{:.1} {:.1}", at_x(p.0), at_y(p.1))).collect();
            let _ = writeln!(svg, "<path {style} d=\"M{}\"/>", path.join("L"));
            legend(&mut svg, &style, label);
        }
        if let Some((value, label)) = &self.limit {
            let style = "fill=\"none\" stroke=\"#b00\" stroke-dasharray=\"6 4\"";
            let _ = writeln!(svg, "<path {style} d=\"M{LEFT} {:.1}H{right}\"/>", at_y(*value));
            legend(&mut svg, style, label);
        }
        svg + "</svg>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_on_round_numbers_around_the_values() {
        let axis = Axis::over([0.3, 9.7].into_iter());
        assert_eq!((axis.from, axis.to, axis.mark), (0.0, 10.0, 2.0));
        assert_eq!(axis.marks().count(), 6);
        assert_eq!(axis.label(4.0), "4");
        let flat = Axis::over([5.0, 5.0].into_iter());
        assert!(flat.from < flat.to);
        let small = Axis::over([0.0, 0.05].into_iter());
        assert_eq!(small.label(small.mark), "0.01");
    }

    #[test]
    fn a_point_lies_where_its_value_is() {
        let chart = Chart {
            title: "a < b".into(),
            x: "s".into(),
            y: "K".into(),
            lines: vec![("line".into(), vec![(0.0, 0.0), (10.0, 10.0)])],
            limit: None,
        };
        let svg = chart.svg();
        let (bottom, right) = (SIZE.1 - BELOW, SIZE.0 - RIGHT);
        assert!(svg.contains(&format!("M{LEFT:.1} {bottom:.1}L{right:.1} {TOP:.1}")), "{svg}");
        assert!(svg.contains("a &lt; b") && roxmltree::Document::parse(&svg).is_ok());
    }
}
