//! The figure of a recording: one panel for each unit, over a common time axis.

use crate::{Column, Error, Kind, Recording};
use present::figure::{Axis, Figure};
use std::path::Path;

impl Recording {
    /// Draws the outputs over time as SVG: one panel for each unit, kelvin as degC if the FMU declares this display unit.
    ///
    /// # Errors
    /// [`Error::Io`], also for a run without numeric outputs.
    pub fn plot_svg(&self, path: &Path) -> Result<(), Error> {
        let svg = svg(self).map_err(|reason| Error::io("draw", path)(std::io::Error::other(reason)))?;
        std::fs::write(path, svg).map_err(Error::io("write", path))
    }
}

/// The SVG text; the error is a plain reason.
fn svg(recording: &Recording) -> Result<String, String> {
    if recording.columns.is_empty() {
        return Err("there are no numeric outputs".to_owned());
    }
    // Constant outputs are listed and not drawn. If all outputs are constant, all are drawn.
    let is_constant = |c: &&Column| c.values.iter().all(|v| *v == c.values[0] || v.is_nan());
    let (mut constant, mut drawn): (Vec<&Column>, Vec<&Column>) =
        recording.columns.iter().partition(is_constant);
    if drawn.is_empty() {
        drawn = std::mem::take(&mut constant);
    }
    let mut panels: Vec<(String, Vec<&Column>)> = Vec::new();
    for column in drawn {
        let axis = axis_title(column);
        match panels.iter_mut().find(|(known, _)| *known == axis) {
            Some((_, columns)) => columns.push(column),
            None => panels.push((axis, vec![column])),
        }
    }
    let mut figure = Figure::stacked(&recording.model_name, Axis::new("time in s"));
    for (title, columns) in panels {
        let flags = columns.iter().all(|c| c.kind == Kind::Boolean);
        let axis = Axis::new(&title);
        figure = figure.panel(if flags { axis.from_to(-0.1, 1.1) } else { axis });
        for column in columns {
            figure = figure.line(&column.name, line(&recording.times, column));
        }
    }
    let value = |c: &&Column| {
        c.last_shown().map(|(v, unit)| {
            format!("{} = {} {}", c.name, present::number(v), readable(unit)).trim_end().to_owned()
        })
    };
    let values: Vec<String> = constant.iter().filter_map(value).collect();
    if !values.is_empty() {
        figure = figure.remark(&format!("Constant: {}.", values.join(", ")));
    }
    Ok(figure.svg())
}

/// A column in its display unit; discrete variables are drawn as steps.
fn line(times: &[f64], column: &Column) -> Vec<(f64, f64)> {
    let show = |y: f64| column.display_unit.as_ref().map_or(y, |d| d.show(y));
    let points = times.iter().copied().zip(column.values.iter().map(|y| show(*y)));
    if column.kind.is_float() {
        return points.collect();
    }
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for (t, y) in points {
        match steps.last() {
            Some(&(_, before)) if before != y => steps.extend([(t, before), (t, y)]),
            _ => steps.push((t, y)),
        }
    }
    steps
}

fn axis_title(column: &Column) -> String {
    let unit = match &column.display_unit {
        Some(display) => display.name.as_str(),
        None => column.unit.as_deref().unwrap_or(""),
    };
    match unit {
        "" | "1" if column.kind == Kind::Boolean => "false 0, true 1".to_owned(),
        "" | "1" => "1".to_owned(),
        _ => readable(unit),
    }
}

/// A unit in its usual notation.
fn readable(unit: &str) -> String {
    unit.replace("degC", "°C")
        .replace("Ohm", "Ω")
        .replace('.', "·")
        .replace("m3", "m³")
        .replace("m2", "m²")
        .replace("s2", "s²")
}
