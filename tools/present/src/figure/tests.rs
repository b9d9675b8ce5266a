use super::*;

fn figure() -> Figure {
    Figure::new("a < b", Axis::new("time in s"), Axis::new("power in W"))
}

fn parsed(figure: &impl Drawing) -> String {
    let svg = figure.svg();
    roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e}: {svg}"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    svg
}

/// The path of the `k`-th series of a class.
fn path(svg: &str, class: &str, k: usize) -> String {
    let document = roxmltree::Document::parse(svg).unwrap();
    let of_class = document.descendants().filter(|n| n.attribute("class") == Some(class));
    // The legend's swatch is of the same class.
    let mut paths = of_class.filter_map(|n| n.attribute("d")).filter(|d| !d.ends_with("h18"));
    paths.nth(k).unwrap().to_owned()
}

/// 0 to 10 on both axes, without a margin on x and with 6 % on y: the frame's ends by hand.
#[test]
fn a_point_lies_where_its_value_is() {
    let svg = parsed(&figure().line("l", vec![(0.0, 0.0), (10.0, 10.0)]));
    let left = PAD + width("10") + 8.0;
    let (low, high) = (HEIGHT.0 * (1.0 - 0.06 / 1.12), HEIGHT.0 * 0.06 / 1.12);
    assert_eq!(path(&svg, "l k0", 0), format!("M{left:.1} {low:.1}L{:.1} {high:.1}", WIDTH - PAD));
    assert!(svg.contains("a &lt; b"));
}

#[test]
fn a_line_is_interrupted_where_it_has_no_value() {
    let line = vec![(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 0.0)];
    let svg = parsed(&figure().line("l", line));
    assert_eq!(path(&svg, "l k0", 0).matches('M').count(), 2);
}

/// A legend entry without a mark in the figure would be looked for in vain.
#[test]
fn a_series_without_a_value_is_in_no_legend() {
    let nan = f64::NAN;
    let svg = parsed(
        &figure()
            .line("drawn", vec![(0.0, 1.0), (1.0, 2.0)])
            .line("empty", vec![(0.0, nan)])
            .points("none", vec![]),
    );
    assert!(svg.contains("drawn") && !svg.contains("empty") && !svg.contains("none<"), "{svg}");
}

/// Rings leave the points below them visible.
#[test]
fn rings_are_not_filled() {
    let svg = parsed(&figure().points("p", vec![(0.0, 1.0), (1.0, 2.0)]).rings("r", vec![(0.5, 1.5)]));
    assert_eq!(svg.matches("<circle class=\"k k1\"").count(), 2, "ring and legend: {svg}");
    assert!(svg.contains(".f .k,.f .l{fill:none}"));
}

/// A logger that writes each sensor at its own times leaves one reading between blank cells: no line could show it.
#[test]
fn a_value_between_gaps_is_a_point() {
    let gap = f64::NAN;
    let line = vec![(0.0, 1.0), (1.0, gap), (2.0, 2.0), (3.0, 3.0), (4.0, gap), (5.0, 1.5)];
    let dots = |points: Vec<(f64, f64)>| parsed(&figure().line("l", points)).matches("<circle").count();
    assert_eq!((dots(line), dots(vec![(0.0, 1.0)]), dots(vec![(0.0, 1.0), (1.0, 1.0)])), (2, 1, 0));
}

/// Half a unit up and down about a line at 1: the axis holds it, and the outline closes.
#[test]
fn the_axis_holds_bands_bars_and_limits() {
    let line = vec![(0.0, 1.0), (1.0, 1.0)];
    let svg = parsed(&figure().band("b", line.clone(), vec![0.5, 0.5]));
    assert_eq!(path(&svg, "w d0", 0).matches(['M', 'L', 'Z']).count(), 5);
    for figure in [
        figure().band("b", line.clone(), vec![0.5; 2]),
        figure().points_with_bars("b", line.clone(), vec![0.5; 2]),
        figure().line("b", line.clone()).limit(0.5, "least").limit(1.5, "most"),
    ] {
        let values = figure.panels[0].series.iter().flat_map(Series::extent);
        let values = values.chain(figure.limits());
        let scale = Scale::over(&figure.panels[0].y, values, 0.0, (1.0, 0.0));
        assert_eq!(scale.span, (0.5, 1.5));
    }
}

/// An error bar reaches beyond its point even where it is short.
#[test]
fn a_short_error_bar_is_seen() {
    let svg = parsed(&figure().points_with_bars("b", vec![(0.0, 320.0), (1.0, 400.0)], vec![1.2; 2]));
    let bar = path(&svg, "k k0", 0);
    let ends: Vec<f64> = bar[1..].split(['V', ' ', 'M', 'h']).filter_map(|t| t.parse().ok()).collect();
    assert!(ends[1] - ends[2] > 2.0 * 2.2, "{bar}");
}

#[test]
fn degenerate_figures_have_a_range() {
    let sets = [vec![], vec![(1.0, 3.0)], vec![(1.0, f64::NAN)], vec![(0.0, 0.0), (1.0, 0.0)]];
    for points in sets.into_iter().chain([1e300, -1e-300, 1e-154, f64::INFINITY].map(|v| vec![(0.0, v)])) {
        let svg = parsed(&figure().points("p", points.clone()).line("l", points.clone()));
        assert!(!svg.contains("e-1") && !svg.contains("e+"), "{points:?}: {svg}");
    }
}

/// All text stays inside the picture, however long it is, by the width that letters are given.
#[test]
fn no_text_is_cut() {
    let long = "an uncommonly long name of a series, which does not fit into one line of the legend";
    let word = "component.with_a_name_that_has_no_space_at_all_and_is_longer_than_the_figure_is_wide[12]";
    let points = vec![(0.0, -123_456.0), (1.0, 1_234_567.0)];
    let figure = Figure::new(long, Axis::new(long), Axis::new(long));
    let figure = figure.line(long, points.clone()).line(word, points).note(0.9, long).note(0.1, "short");
    let rows = Rows::new(
        long,
        long,
        &[long, word],
        vec![Row {
            name: word.into(),
            marks: vec![(0, Mark::Bar(1.0, "100 %".into())), (1, Mark::Point(0.5, (0.2, 0.9)))],
        }],
    );
    // The last tick of each is at the frame.
    let ends = Figure::new("", Axis::new("x").from_to(0.7, 0.9), Axis::new("y")).points("", vec![(0.8, 1.0)]);
    let negative = Row { name: "a".into(), marks: vec![(0, Mark::Bar(-2000.0, String::new()))] };
    let negative = Rows::new("", "", &[], vec![negative]);
    for svg in [parsed(&figure), parsed(&rows), parsed(&ends), parsed(&negative)] {
        let document = roxmltree::Document::parse(&svg).unwrap();
        for text in document.descendants().filter(|n| n.has_tag_name("text")) {
            let x: f64 = text.attribute("x").unwrap().parse().unwrap();
            let wide = width(text.text().unwrap_or_default());
            let class = text.attribute("class").unwrap_or_default();
            let left = if class.starts_with('e') {
                x - wide
            } else if class.starts_with('m') {
                x - 0.5 * wide
            } else {
                x
            };
            assert!(left >= -1.0 && left + wide <= WIDTH + 1.0, "{left} + {wide}: {:?}", text.text());
        }
    }
}

#[test]
fn more_lines_than_colours_differ_by_their_dashes() {
    let figure = (0..9).fold(figure(), |f, k| f.line("l", vec![(0.0, f64::from(k)), (1.0, 0.0)]));
    let svg = parsed(&figure);
    assert_eq!(svg.matches("stroke-dasharray=\"2 3\"").count(), 2, "line and legend of the ninth");
}

#[test]
fn panels_share_the_x_axis() {
    let figure = figure().line("a", vec![(0.0, 0.0), (1.0, 1.0)]).panel(Axis::new("speed in rad/s"));
    let svg = parsed(&figure.line("b", vec![(0.5, 0.0), (2.0, 5.0)]));
    assert_eq!(svg.matches(">time in s<").count(), 1);
    let (first, second) = (path(&svg, "l k0", 0), path(&svg, "l k0", 1));
    let at =
        |path: &str, k: usize| path.split(['M', 'L']).nth(k).unwrap().split(' ').next().unwrap().to_owned();
    assert_ne!(at(&first, 2), at(&second, 2), "1 s and 2 s");
}

/// Names of five motors fit side by side where they are broken after a hyphen; longer ones are written upwards, whole.
#[test]
fn names_of_categories_do_not_collide() {
    let drawn = |names: &[&str]| {
        let points = (0..names.len()).map(|k| (k as f64, 1.0)).collect();
        parsed(&figure().points("p", points).categories(names))
    };
    let short = drawn(&["maxon-ht60m-936176", "maxon-305015", "maxon-re40-148877", "a", "b"]);
    assert!(short.contains(">maxon-<") && short.contains(">305015<") && !short.contains("rotate"), "{short}");
    let long = drawn(&["faulhaber-1524t006sr"; 9]);
    assert_eq!(long.matches(">faulhaber-1524t006sr</text>").count(), 9, "{long}");
    let height: f64 = roxmltree::Document::parse(&long)
        .unwrap()
        .root_element()
        .attribute("height")
        .unwrap()
        .parse()
        .unwrap();
    assert!(height > HEIGHT.0 + width("faulhaber-1524t006sr"), "{height}");
}

/// Rims of the colour of the paper would cover the neighbours.
#[test]
fn many_points_have_no_rims() {
    let svg = |count: u32| parsed(&figure().points("", (0..count).map(|k| (f64::from(k), 0.0)).collect()));
    assert_eq!(
        (svg(50).matches("class=\"p d0\"").count(), svg(500).matches("class=\"p d0\"").count()),
        (50, 0)
    );
}

/// `height:auto` on the root is 0 for converters; they do not read rules for screens.
#[test]
fn the_height_of_the_root_is_its_attribute() {
    let svg = parsed(&figure().line("l", vec![(0.0, 0.0), (1.0, 1.0)]));
    let automatic = svg.find("height:auto").unwrap();
    assert!(svg[..automatic].ends_with("@media screen{.f{max-width:100%;"), "{svg}");
}
