//! The figure of a recording: one panel for each unit, two columns of panels when there are many.
use crate::decimate::decimated;
use crate::{Column, Recording};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Failure = DrawingAreaErrorKind<std::io::Error>;

/// The backend rounds to whole units, so a figure is drawn this many times as large as it is shown.
const SCALE: u32 = 8;
const PANEL_WIDTH: u32 = 640 * SCALE;
/// Height of axes and labels, without the legend.
const PANEL_HEIGHT: u32 = 230 * SCALE;
const LEGEND_ROW: i32 = px(18);
const TITLE_HEIGHT: u32 = 44 * SCALE;
const MARGIN: i32 = px(10);
/// From the left edge of a panel to its axis; ticks may have ten characters.
const AXIS_WIDTH: i32 = px(96);
const FONT_SIZE: i32 = px(12);
const FONT: &str = "sans-serif";
/// Panels from which two columns are used.
const TWO_COLUMNS_FROM: usize = 5;

/// Lines that remain apart on paper and for colour-blind eyes; dark enough on white.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
    RGBColor(123, 80, 40),
];
const GRID: RGBColor = RGBColor(225, 225, 225);
const AXIS: RGBColor = RGBColor(110, 110, 110);
const TEXT: RGBColor = RGBColor(40, 40, 40);

/// A length as it is shown.
const fn px(length: u32) -> i32 {
    (length * SCALE) as i32
}

/// Outputs that share an axis.
struct Panel<'a> {
    /// The unit, as people write it.
    axis: String,
    columns: Vec<&'a Column>,
}

/// The SVG text; the error is a plain reason.
pub(crate) fn svg(recording: &Recording) -> Result<String, String> {
    if recording.columns.is_empty() {
        return Err("there are no numeric outputs".to_owned());
    }
    let panels = panels(&recording.columns);
    let across = if panels.len() < TWO_COLUMNS_FROM { 1 } else { 2 };
    let rows: Vec<&[Panel]> = panels.chunks(across).collect();
    let heights: Vec<u32> = rows.iter().map(|row| row.iter().map(height).max().unwrap_or(0)).collect();
    let width = PANEL_WIDTH * across as u32;
    let total = TITLE_HEIGHT + heights.iter().sum::<u32>();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (width, total)).into_drawing_area();
        draw(&root, recording, &rows, &heights).map_err(|e| e.to_string())?;
    }
    // The view box keeps the fine units; the size is what people see.
    let shown = format!("width=\"{}\" height=\"{}\"", width / SCALE, total / SCALE);
    Ok(text.replacen(&format!("width=\"{width}\" height=\"{total}\""), &shown, 1))
}

fn draw(root: &Area, recording: &Recording, rows: &[&[Panel]], heights: &[u32]) -> Result<(), Failure> {
    root.fill(&WHITE)?;
    let title = (FONT, px(18)).into_font().style(FontStyle::Bold).color(&TEXT);
    root.draw(&Text::new(recording.model_name.clone(), (MARGIN, px(14)), title))?;
    let (_, mut rest) = root.split_vertically(TITLE_HEIGHT);
    let count: usize = rows.iter().map(|row| row.len()).sum();
    let mut drawn = 0;
    for (row, height) in rows.iter().zip(heights) {
        let (band, below) = rest.split_vertically(*height);
        rest = below;
        for (panel, area) in row.iter().zip(band.split_evenly((1, rows[0].len()))) {
            drawn += 1;
            // The lowest panel of each column says what runs along.
            let lowest = drawn + rows[0].len() > count;
            draw_panel(&area, panel, &recording.times, lowest)?;
        }
    }
    root.present()
}

fn draw_panel(area: &Area, panel: &Panel, times: &[f64], name_time: bool) -> Result<(), Failure> {
    let places = legend(panel);
    let legend_height = places.last().map_or(0, |(_, y)| y + LEGEND_ROW);
    for ((column, (x, y)), colour) in panel.columns.iter().zip(&places).zip(COLOURS.iter().cycle()) {
        let middle = y + LEGEND_ROW / 2;
        area.draw(&PathElement::new(
            vec![(*x, middle), (x + px(18), middle)],
            colour.stroke_width(3 * SCALE),
        ))?;
        let anchor = Pos::new(HPos::Left, VPos::Center);
        let style = (FONT, FONT_SIZE).into_font().color(&TEXT).pos(anchor);
        area.draw(&Text::new(column.name.clone(), (x + px(24), middle), style))?;
    }

    let first = times.first().copied().unwrap_or(0.0);
    let last = times.last().copied().filter(|t| *t > first).unwrap_or(first + 1.0);
    let lines: Vec<Vec<(f64, f64)>> = panel.columns.iter().map(|c| line(times, c)).collect();
    let flags = panel.columns.iter().all(|c| c.kind == crate::Kind::Boolean);
    let (low, high) = if flags { (-0.1, 1.1) } else { range(&lines) };
    let mut chart = ChartBuilder::on(area)
        .margin_top(legend_height + px(6))
        .margin_right(MARGIN)
        .margin_left(MARGIN)
        .margin_bottom(px(6))
        .x_label_area_size(if name_time { px(42) } else { px(24) })
        .y_label_area_size(AXIS_WIDTH - MARGIN)
        .build_cartesian_2d(first..last, low..high)?;
    let label = (FONT, FONT_SIZE).into_font().color(&TEXT);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(SCALE))
        .axis_style(AXIS.stroke_width(SCALE))
        .set_all_tick_mark_size(px(4))
        .x_labels(8)
        .y_labels(if flags { 2 } else { 6 })
        .x_label_formatter(&|t| tick(*t, last - first))
        .y_label_formatter(&|y| tick(*y, high - low))
        .x_desc(if name_time { "time in s" } else { "" })
        .y_desc(panel.axis.clone())
        .label_style(label.clone())
        .axis_desc_style(label)
        .draw()?;
    for (points, colour) in lines.into_iter().zip(COLOURS.iter().cycle()) {
        // A value that is no number interrupts the line.
        for part in points.split(|(_, y)| !y.is_finite()).filter(|part| !part.is_empty()) {
            chart.draw_series(LineSeries::new(part.iter().copied(), colour.stroke_width(2 * SCALE)))?;
        }
    }
    Ok(())
}

/// What the plot shows of a column: in the unit for people, with steps for what cannot run continuously.
fn line(times: &[f64], column: &Column) -> Vec<(f64, f64)> {
    let show = |y: f64| column.display_unit.as_ref().map_or(y, |d| d.show(y));
    let points = decimated(times, &column.values).into_iter().map(|(t, y)| (t, show(y)));
    if column.kind.is_float() {
        return points.collect();
    }
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for (t, y) in points {
        if let Some(&(_, before)) = steps.last() {
            steps.push((t, before));
        }
        steps.push((t, y));
    }
    steps
}

/// Outputs grouped by the unit that is shown; Booleans and pure numbers have panels of their own.
fn panels(columns: &[Column]) -> Vec<Panel<'_>> {
    let mut panels: Vec<Panel> = Vec::new();
    for column in columns {
        let axis = axis_title(column);
        match panels.iter_mut().find(|p| p.axis == axis) {
            Some(panel) => panel.columns.push(column),
            None => panels.push(Panel { axis, columns: vec![column] }),
        }
    }
    panels
}

fn axis_title(column: &Column) -> String {
    let unit = match &column.display_unit {
        Some(display) => display.name.as_str(),
        None => column.unit.as_deref().unwrap_or(""),
    };
    match unit {
        "" | "1" if column.kind == crate::Kind::Boolean => "false 0, true 1".to_owned(),
        "" | "1" => "1".to_owned(),
        _ => unit
            .replace("degC", "°C")
            .replace("Ohm", "Ω")
            .replace('.', "·")
            .replace("m3", "m³")
            .replace("m2", "m²")
            .replace("s2", "s²"),
    }
}

/// The top left corner of each legend entry, in rows that do not leave the panel.
fn legend(panel: &Panel) -> Vec<(i32, i32)> {
    let (mut x, mut y) = (AXIS_WIDTH, 0);
    let mut places = Vec::new();
    for column in &panel.columns {
        // Swatch, gap, and generous seven pixels for a letter: the true font is not known here.
        let width = px(24 + 16) + px(7) * column.name.chars().count() as i32;
        if x + width > PANEL_WIDTH as i32 && x > AXIS_WIDTH {
            (x, y) = (AXIS_WIDTH, y + LEGEND_ROW);
        }
        places.push((x, y));
        x += width;
    }
    places
}

fn height(panel: &Panel) -> u32 {
    PANEL_HEIGHT + legend(panel).last().map_or(0, |(_, y)| (y + LEGEND_ROW) as u32)
}

/// Limits of the value axis: all finite values and a margin; never empty.
fn range(lines: &[Vec<(f64, f64)>]) -> (f64, f64) {
    let finite = lines.iter().flatten().map(|(_, y)| *y).filter(|y| y.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
    if low > high {
        return (0.0, 1.0);
    }
    // Values that differ by rounding alone look constant.
    let flat = 1e-9 * low.abs().max(high.abs());
    let margin = if high - low > flat {
        0.06 * (high - low)
    } else {
        (0.05 * high.abs()).max(f64::MIN_POSITIVE.sqrt())
    };
    (low - margin, high + margin)
}

/// A tick label with as many digits as an axis of this span needs.
fn tick(value: f64, span: f64) -> String {
    let size = value.abs().max(span);
    // Rounding noise around the zero tick.
    let value = if value.abs() < 1e-9 * span { 0.0 } else { value };
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.1e}");
    }
    let digits = (1.0 - (span / 5.0).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short_and_tell_neighbours_apart() {
        assert_eq!(tick(0.30000000000000004, 1.0), "0.3");
        assert_eq!(tick(-20.0, 100.0), "\u{2212}20");
        assert_eq!(tick(3600.0, 3600.0), "3600");
        assert_eq!(tick(25.02, 0.05), "25.02");
        assert_eq!(tick(1e-12, 1.0), "0");
        assert_eq!(tick(2e-5, 5e-5), "2.0e-5");
    }

    #[test]
    fn ranges_are_never_empty() {
        for values in [vec![], vec![f64::NAN], vec![0.0], vec![-3.0, -3.0], vec![1.0, 2.0], vec![1e-300]] {
            let (low, high) = range(&[values.iter().map(|y| (0.0, *y)).collect()]);
            assert!(low < high, "{values:?}");
            assert!(values.iter().all(|y| y.is_nan() || (low < *y && *y < high)));
        }
    }
}
