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
    let svg = parsed(&figure().dashed("l", vec![(0.0, 0.0), (10.0, 10.0)]));
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
    let mut line: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 1.0)).collect();
    (line[1].1, line[50].1, line[52].1) = (gap, gap, gap);
    let dots =
        |points: &[(f64, f64)]| parsed(&figure().line("l", points.to_vec())).matches("<circle").count();
    assert_eq!((dots(&line), dots(&line[2..50])), (2, 0));
}

/// Between few values a reader sees a kink as physics, unless the values are marked; the only value of a sweep is as large as a point.
#[test]
fn few_values_are_marked() {
    let line = |count: u32| (0..count).map(|k| (f64::from(k), f64::from(k % 5))).collect::<Vec<_>>();
    let marks = |points: Vec<(f64, f64)>, radius: &str| {
        let svg = parsed(&figure().line("l", points));
        svg.matches("<circle").count() * usize::from(svg.contains(radius))
    };
    let small = "r=\"2.2\"";
    assert_eq!((marks(line(30), small), marks(line(31), small), marks(line(1), "r=\"4\"")), (30, 0, 1));
    // Steps, and a curve that comes back.
    let (steps, curve) = (vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], vec![(0.0, 0.0), (1.0, 1.0), (0.5, 2.0)]);
    assert_eq!((marks(steps, small), marks(curve, small)), (0, 0));
}

/// Points beside a line are whole, also the first and the last one.
#[test]
fn points_at_the_ends_are_inside_the_frame() {
    let line: Vec<(f64, f64)> = (0..200).map(|k| (f64::from(k), f64::from(k))).collect();
    let svg = parsed(&figure().points("p", vec![line[0], line[199]]).dashed("l", line));
    let axis = path(&svg, "a", 0);
    let left: f64 = axis[1..].split(' ').next().unwrap().parse().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let points = document.descendants().filter(|n| n.has_tag_name("circle"));
    let xs: Vec<f64> = points.skip(1).map(|n| n.attribute("cx").unwrap().parse().unwrap()).collect();
    assert!(xs.len() == 2 && xs[0] >= left + 4.0 && xs[1] <= WIDTH - PAD - 4.0, "{xs:?}");
}

/// A peak at the begin of a record is not on the y axis.
#[test]
fn a_jump_at_the_begin_is_off_the_axis() {
    let start = |first: f64| {
        let line = (0..200)
            .map(|k| (f64::from(k), if k == 0 { first } else { 1.0 + 0.01 * f64::from(k) }))
            .collect();
        let svg = parsed(&figure().line("l", line));
        let (axis, line) = (path(&svg, "a", 0), path(&svg, "l k0", 0));
        let x = |path: &str| path[1..].split(' ').next().unwrap().parse::<f64>().unwrap();
        x(&line) - x(&axis)
    };
    assert!(start(40.0) > 4.0 && start(1.0) == 0.0);
}

/// Lines that agree would hide each other: each is seen in turn, also with other corners and other values between them.
#[test]
fn equal_lines_are_seen() {
    let wave = |points: u32, by: f64| {
        (0..=points)
            .map(|k| f64::from(k) / f64::from(points))
            .map(|x| (x, (20.0 * x).sin() + by))
            .collect::<Vec<_>>()
    };
    let svg =
        parsed(&figure().line("a", wave(500, 0.0)).line("b", wave(700, 0.002)).line("c", wave(300, 1.0)));
    assert_eq!(svg.matches("stroke-dasharray=\"6 6\"").count(), 2, "second line and its key: {svg}");
    let thrice =
        parsed(&figure().line("a", wave(500, 0.0)).line("b", wave(500, 0.0)).line("c", wave(500, 0.0)));
    for (dashes, offset) in [("6 12", "-6"), ("6 12", "-12")] {
        assert!(
            thrice.contains(&format!("stroke-dasharray=\"{dashes}\" stroke-dashoffset=\"{offset}\"")),
            "{thrice}"
        );
    }
    // Lines that cross, and one that joins the other at its end, differ.
    let apart = parsed(
        &figure()
            .line("a", wave(500, 0.0))
            .line("b", wave(500, 0.3))
            .line("c", vec![(0.0, 1.0), (1.0, -1.0)]),
    );
    assert!(!apart.contains("stroke-dasharray="), "{apart}");
    // A measured line of which the prediction goes on.
    let longer =
        parsed(&figure().line("measured", wave(500, 0.0)[..100].to_vec()).line("model", wave(500, 0.0)));
    assert!(longer.contains("stroke-dasharray=\"6 6\""));
}

/// A dashed line, such as a limit that changes, lies over the line that it meets, whichever comes first.
#[test]
fn dashes_are_over_lines() {
    let line = vec![(0.0, 1.0), (1.0, 2.0)];
    let svg = parsed(&figure().dashed("limit", line.clone()).line("value", line));
    assert!(svg.rfind("stroke-dasharray=\"6 6\"").unwrap() > svg.rfind("class=\"l u k1\"").unwrap(), "{svg}");
}

#[test]
fn equal_points_are_seen() {
    let points: Vec<(f64, f64)> = (0..6).map(|k| (f64::from(k), f64::from(k * k))).collect();
    let svg = parsed(&figure().points("a", points.clone()).points("b", points.clone()));
    assert_eq!(svg.matches("<circle class=\"k k1\"").count(), 7, "rings and their key: {svg}");
    let moved = points.iter().map(|p| (p.0, p.1 + 5.0)).collect();
    assert!(!parsed(&figure().points("a", points).points("b", moved)).contains("class=\"k k1\""));
}

/// Half an hour of strides fills an area: the mean is a line over the band, and what is smooth stays a line.
#[test]
fn a_crowded_line_is_a_band_with_its_mean() {
    let walk = |t: f64| 2.0 + (6.0 * t).sin() + if t > 900.0 { 1.0 } else { 0.0 };
    let times = || (0..180_000).map(|k| f64::from(k) * 0.01);
    let figure = Figure::new("", Axis::time(), Axis::new("torque in N·m"));
    let figure = figure
        .line("walk", times().map(|t| (t, walk(t))).collect())
        .line("smooth", times().map(|t| (t, 0.001 * t)).collect());
    let svg = parsed(&figure);
    assert_eq!((svg.matches("class=\"q d0 k0\"").count(), svg.matches("class=\"q d1").count()), (1, 0));
    assert!(svg.contains("Band: least to greatest value in 0.66 min, line: mean."), "{svg}");
    // The mean is 2 before the step and 3 behind it: 3 and 2 above the bottom of a range from 0 to 4 with its margins.
    let mean = path(&svg, "l k0", 0);
    let ys: Vec<f64> = mean.split(['M', 'L']).filter_map(|p| p.split_once(' ')?.1.parse().ok()).collect();
    let at = |value: f64| HEIGHT.0 * (1.0 - (value + 0.24) / 4.48);
    assert!((ys[20] - at(2.0)).abs() < 3.0 && (ys[ys.len() - 20] - at(3.0)).abs() < 3.0, "{ys:?}");
    assert!(svg.len() < 60_000, "{}", svg.len());
    // Two crowded lines with one mean, however far they reach.
    let twice = Figure::new("", Axis::time(), Axis::new("torque in N·m"));
    let line = |size: f64| times().map(|t| (t, size * (6.0 * t).sin() + 2.0)).collect();
    let svg = parsed(&twice.line("wide", line(1.0)).line("narrow", line(0.5)));
    assert_eq!(svg.matches("stroke-dasharray=\"6 6\"").count(), 2, "{svg}");
}

/// Strides that can be distinguished stay a line, also with small ripples on them.
#[test]
fn what_can_be_followed_stays_a_line() {
    let stride = |t: f64| (0.5 * t).sin() + 0.03 * (7.0 * t).sin();
    let line = (0..40_000).map(|k| f64::from(k) * 0.01).map(|t| (t, stride(t))).collect();
    let svg = parsed(&figure().line("l", line));
    assert!(!svg.contains("class=\"q") && !svg.contains("Band"), "{svg}");
}

/// A few peaks of a smooth line are not a band, and are not averaged.
#[test]
fn single_peaks_stay_lines() {
    let peak = |k: u32| if k % 10_000 == 5000 { 9.0 } else { 0.0 };
    let line = (0..100_000).map(|k| (f64::from(k), peak(k))).collect();
    let svg = parsed(&figure().line("l", line));
    assert!(!svg.contains("class=\"q") && path(&svg, "l k0", 0).matches(" 11.8").count() == 10, "{svg}");
}

/// The label of a limit stands where no curve is; where there is no such place, it is in the legend.
#[test]
fn labels_of_limits_hide_nothing() {
    let label = "supply voltage 48 V";
    let place = |line: Vec<(f64, f64)>| {
        let svg = parsed(&figure().line("voltage", line).limit(48.0, label));
        let document = roxmltree::Document::parse(&svg).unwrap();
        let text =
            document.descendants().find(|n| n.has_tag_name("text") && n.text() == Some(label)).unwrap();
        let number = |name: &str| text.attribute(name).unwrap().parse::<f64>().unwrap();
        (number("x"), text.attribute("class") == Some("o"))
    };
    let free = place(vec![(0.0, 0.0), (1.0, 10.0)]);
    assert!(free.1 && free.0 < 60.0, "{free:?}");
    // A curve about the limit in a part of the panel, and in the whole panel.
    let busy = |from: f64, to: f64| {
        let value = |x: f64, k: u32| if x >= from && x <= to { 40.0 + 16.0 * f64::from(k % 2) } else { 0.0 };
        (0..=100).map(|k| (f64::from(k) / 100.0, value(f64::from(k) / 100.0, k))).collect::<Vec<_>>()
    };
    let (early, late, all) = (place(busy(0.0, 0.5)), place(busy(0.5, 1.0)), place(busy(0.0, 1.0)));
    assert!(early.1 && early.0 > 250.0 && late.1 && late.0 < 60.0 && !all.1, "{early:?}, {late:?}, {all:?}");
}

/// Words over a curve would delete it: notes stand above the first panel, and only there.
#[test]
fn notes_are_above_the_first_panel() {
    let line: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 1.0)).collect();
    let figure =
        figure().line("a", line.clone()).panel(Axis::new("b in K")).line("b", line).note(50.0, "window ends");
    let svg = parsed(&figure);
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text") && n.text() == Some("window ends"));
    let heights: Vec<f64> = texts.map(|n| n.attribute("y").unwrap().parse().unwrap()).collect();
    // Twice: the text and its outline; the frame is at 0.
    assert!(heights.len() == 2 && heights.iter().all(|y| *y < 0.0), "{heights:?}");
    assert_eq!(svg.matches("class=\"n\"").count(), 2, "a line in each panel");
}

#[test]
fn a_flag_has_two_names() {
    let flag = vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (30.0, 1.0)];
    let svg =
        parsed(&Figure::new("", Axis::time(), Axis::new("alarm").names(&["false", "true"])).line("", flag));
    assert!(svg.contains(">false<") && svg.contains(">true<") && !svg.contains(">0.5<"), "{svg}");
}

/// What is written into a figure has true minus signs; names are as they are.
#[test]
fn numbers_in_a_figure_have_minus_signs() {
    let figure =
        figure().line("at -5 °C", vec![(0.0, -48.0), (1.0, 0.0)]).limit(-48.0, "supply voltage -48 V");
    let svg = parsed(&figure.remark("run-4.csv: -3 K"));
    for text in ["at −5 °C", "supply voltage −48 V", "run-4.csv: −3 K", "−40"] {
        assert!(svg.contains(text), "{text}: {svg}");
    }
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
        let scale = figure.panels[0].y.scale(values, 0.0, (1.0, 0.0));
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
