//! The figure of a recording: one panel for each unit, over a common time axis.

use crate::{Column, Error, Kind, Recording, Status};
use present::figure::{Axis, Figure};
use present::words::{is_word, sentence, unit as written};
use std::path::Path;

/// Panels that a figure may have; further outputs are named below it.
const MOST_PANELS: usize = 10;
/// Lines that a panel may have.
const MOST_LINES: usize = 8;
/// Outputs of one unit share a panel if their greatest values differ by at most this factor; a smaller one would be flat.
const SAME_SIZE: f64 = 20.0;

/// A limit of a recorded output: a line across its panel, or a curve where the limit changes over time.
#[derive(Clone, Debug)]
pub struct Limit {
    /// Name of the output's column.
    pub of: String,
    /// What limits.
    pub label: String,
    /// The limit at the times of the recording, in its unit and display unit.
    pub column: Column,
}

impl Recording {
    /// The outputs over time as SVG: one panel for each unit, in display units where the FMU declares them, with the limits of the outputs
    /// that are drawn.
    ///
    /// # Errors
    /// [`Error::Io`] for a run without numeric outputs.
    pub fn svg(&self, limits: &[Limit]) -> Result<String, Error> {
        svg(self, limits)
            .map_err(|reason| Error::io("draw", Path::new(&self.model_name))(std::io::Error::other(reason)))
    }
}

/// The SVG text; the error is a plain reason.
fn svg(recording: &Recording, limits: &[Limit]) -> Result<String, String> {
    let (drawable, empty): (Vec<&Column>, Vec<&Column>) =
        recording.columns.iter().partition(|c| c.values.iter().any(|v| v.is_finite()));
    if drawable.is_empty() {
        let reason =
            if empty.is_empty() { "there are no numeric outputs" } else { "no output has a finite value" };
        return Err(reason.to_owned());
    }
    // Constant outputs are listed and not drawn. If all outputs are constant, all are drawn.
    let is_constant = |c: &&Column| c.values.iter().all(|v| *v == c.values[0] || v.is_nan());
    let (mut constant, mut drawn): (Vec<&Column>, Vec<&Column>) = drawable.into_iter().partition(is_constant);
    if drawn.is_empty() {
        drawn = std::mem::take(&mut constant);
    }
    let mut panels: Vec<(String, Vec<&Column>)> = Vec::new();
    let mut left_out: Vec<&str> = Vec::new();
    for column in drawn {
        let unit = unit(column);
        let room = panels.len() < MOST_PANELS;
        let fits = |columns: &[&Column]| {
            let (one, other) = (size(column), columns.iter().map(|c| size(c)).fold(0.0, f64::max));
            columns.len() < MOST_LINES && one.max(other) <= SAME_SIZE * one.min(other)
        };
        match panels.iter_mut().find(|(known, columns)| *known == unit && fits(columns)) {
            Some((_, columns)) => columns.push(column),
            None if room => panels.push((unit, vec![column])),
            _ => left_out.push(&column.name),
        }
    }
    let mut far: Vec<String> = Vec::new();
    let mut figure = Figure::stacked(&recording.model_name, Axis::time());
    for (_, columns) in panels {
        let flags = columns.iter().all(|c| c.kind == Kind::Boolean);
        let axis = Axis::new(&axis_title(&columns));
        figure = figure.panel(if flags { axis.names(&["false", "true"]) } else { axis });
        for column in &columns {
            figure = figure.line(&words(&column.name), line(&recording.times, column));
        }
        for limit in limits.iter().filter(|limit| columns.iter().any(|c| c.name == limit.of)) {
            figure = limited(figure, &recording.times, limit, &columns, &mut far);
        }
    }
    let value = |c: &&Column| {
        if c.kind == Kind::Boolean {
            return Some(format!("{} = {}", words(&c.name), c.values.last()? != &0.0));
        }
        c.last_shown().map(|(v, unit)| {
            format!("{} = {} {}", words(&c.name), present::number(v), written(unit)).trim_end().to_owned()
        })
    };
    let list = |heading: &str, names: &[String]| {
        if names.is_empty() { String::new() } else { format!("{heading}: {}. ", names.join(", ")) }
    };
    let names = |columns: &[&str]| columns.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let empty: Vec<&str> = empty.iter().map(|c| c.name.as_str()).collect();
    let remark = ended(recording)
        + &list("Limits outside the panels", &far)
        + &list("Constant", &constant.iter().filter_map(value).collect::<Vec<_>>())
        + &list(
            &format!("Not drawn, because a figure has at most {MOST_PANELS} panels (--outputs chooses)"),
            &names(&left_out),
        )
        + &list("Without a finite value", &names(&empty));
    Ok(figure.remark(remark.trim_end()).svg())
}

/// When and why the run ended before its stop time.
fn ended(recording: &Recording) -> String {
    let Some(time) = recording.ended_early else { return String::new() };
    let reason = recording.messages.iter().rev().find(|m| m.status != Status::Ok);
    let reason =
        reason.map_or(String::new(), |message| format!(": {}", sentence(message.text.trim_end_matches('.'))));
    format!(
        "The FMU ended the run in the step from {} s, before the stop time{reason}. ",
        present::number(time)
    )
}

/// A name of whole words in words, after its component; any other name as it is.
fn words(name: &str) -> String {
    let (component, own) = name.rsplit_once('.').map_or(("", name), |(component, own)| (component, own));
    match (own.split('_').all(is_word), component) {
        (false, _) => name.to_owned(),
        (true, "") => present::words::words(own),
        (true, _) => format!("{component}: {}", present::words::words(own)),
    }
}

/// The greatest amount of a column, as it is drawn.
fn size(column: &Column) -> f64 {
    let shown = |value: &f64| column.display_unit.as_ref().map_or(*value, |d| d.show(*value)).abs();
    column.values.iter().map(shown).filter(|v| v.is_finite()).fold(0.0, f64::max)
}

/// The limit where it is near the outputs: one far from all values would flatten their lines, so it is named instead.
fn limited(
    figure: Figure,
    times: &[f64],
    limit: &Limit,
    columns: &[&Column],
    far: &mut Vec<String>,
) -> Figure {
    let show = |c: &Column, y: f64| c.display_unit.as_ref().map_or(y, |d| d.show(y));
    let numbers =
        |c: &Column| c.values.iter().filter(|v| v.is_finite()).map(|v| show(c, *v)).collect::<Vec<_>>();
    let values: Vec<f64> = columns.iter().flat_map(|c| numbers(c)).collect();
    let bounds: Vec<f64> = numbers(&limit.column);
    let Some(first) = bounds.first().copied() else { return figure };
    let extent = |all: &[f64]| all.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let ((low, high), (least, most)) = (extent(&values), extent(&bounds));
    let (unit, label) = (unit(&limit.column), &limit.label);
    if least > high + FAR * (high - low) || most < low - FAR * (high - low) {
        far.push(format!("{label} {} {unit}", present::number(first)));
        return figure;
    }
    match least == most {
        true => figure.limit(first, &format!("{label} {} {unit}", present::number(first))),
        false => figure.dashed(label, line(times, &limit.column)),
    }
}

/// A limit so many times the extent of the values away from them is named, not drawn.
const FAR: f64 = 4.0;

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

/// The unit that a column is drawn in; empty for a number without unit.
fn unit(column: &Column) -> String {
    let unit = match &column.display_unit {
        Some(display) => display.name.as_str(),
        None => column.unit.as_deref().unwrap_or(""),
    };
    match unit {
        "" | "1" if column.kind == Kind::Boolean => BOOLEAN.to_owned(),
        "" | "1" => String::new(),
        _ => written(unit),
    }
}

/// The quantity of a panel with its unit: that of the unit, else the name of the only output.
fn axis_title(columns: &[&Column]) -> String {
    let unit = unit(columns[0]);
    let only = match columns {
        [column] => words(column.name.rsplit('.').next().unwrap_or_default()),
        _ => String::new(),
    };
    let quantity = QUANTITIES.iter().find(|(_, units)| units.contains(&unit.as_str())).map(|(name, _)| *name);
    match (unit.as_str(), quantity) {
        (BOOLEAN, _) if only.is_empty() => unit,
        (BOOLEAN, _) => only,
        ("", _) => {
            if only.is_empty() {
                "value, without unit".to_owned()
            } else {
                only
            }
        }
        (unit, Some(quantity)) => format!("{quantity} in {unit}"),
        // A difference of temperatures in K is named by its output, several outputs by their quantity.
        (unit, None) if !only.is_empty() => format!("{only} in {unit}"),
        ("K", None) => "temperature in K".to_owned(),
        (unit, None) => format!("value in {unit}"),
    }
}

/// The axis of several flags.
const BOOLEAN: &str = "false or true";

/// Quantities by the units that no other quantity of machines has.
const QUANTITIES: [(&str, &[&str]); 12] = [
    ("temperature", &["°C", "°F"]),
    ("current", &["A", "mA"]),
    ("voltage", &["V", "mV"]),
    ("resistance", &["Ω", "mΩ"]),
    ("torque", &["N·m", "mN·m"]),
    ("rotational speed", &["rpm", "rad/s", "deg/s"]),
    ("angle", &["rad", "deg"]),
    ("power", &["W", "kW"]),
    ("energy", &["J", "kJ"]),
    ("pressure", &["Pa", "bar"]),
    ("flow rate", &["m³/s", "L/s", "L/min"]),
    ("force", &["N", "kN"]),
];
