//! Start values, limits and nominal values.

use super::*;
use std::fmt::Display;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let states = model.states();
    for (v, is_state) in model.variables.iter().zip(states) {
        if v.kind.is_float() {
            check_floats(model, v, out);
            check_nominal(model, v, is_state, out);
        } else if v.kind.is_integer() {
            check_integers(model, v, out);
        }
    }
}

fn check_floats(model: &Model, v: &Variable, out: &mut Findings) {
    for name in ["min", "max"] {
        if model.attribute(v, name).and_then(parse_double).is_some_and(f64::is_nan) {
            let message = format!("The {name} of variable {v} is NaN and limits nothing");
            out.add(&rules::LIMIT_NAN, model.place(v.typed), message);
        }
    }
    let special = match model.version {
        FmiVersion::V2 => &rules::VALUE_SPECIAL,
        FmiVersion::V3 => &rules::START_NOT_FINITE,
    };
    let finite = |start: f64, text: &str| {
        (!start.is_finite()).then(|| (special, format!("Variable {v} has the start value {text}")))
    };
    check_range(model, v, parse_double, |_| None, finite, out);
}

/// Limits that are not crossed, and start values within them; `before` and `after` check a start value before and after
/// its limits. The first fault ends the check.
fn check_range<T: PartialOrd + Display + Copy>(
    model: &Model,
    v: &Variable,
    parse: fn(&str) -> Option<T>,
    before: impl Fn(T) -> Option<(&'static Rule, String)>,
    after: impl Fn(T, &str) -> Option<(&'static Rule, String)>,
    out: &mut Findings,
) {
    let limit = |name: &str| model.attribute(v, name).and_then(parse);
    let (min, max) = (limit("min"), limit("max"));
    let crossed = min.zip(max).filter(|(min, max)| min > max);
    let crossed = crossed
        .map(|(min, max)| (&rules::LIMITS_CROSSED, format!("Variable {v} has min {min} above max {max}")));
    let is_outside = |start: T| min.is_some_and(|m| start < m) || max.is_some_and(|m| start > m);
    let texts = v.typed.attribute("start").unwrap_or_default().split_ascii_whitespace();
    let mut starts = texts.filter_map(|text| Some((text, parse(text)?))).filter_map(|(text, start)| {
        let outside = || is_outside(start).then(|| (&rules::START_OUTSIDE, outside(v, text, model)));
        before(start).or_else(outside).or_else(|| after(start, text))
    });
    if let Some((rule, message)) = crossed.or_else(|| starts.next()) {
        out.add(rule, model.place(v.typed), message);
    }
}

fn outside(v: &Variable, start: &str, model: &Model) -> String {
    let bound = |name| model.attribute(v, name).map_or("none", str::trim);
    format!(
        "Variable {v} has the start value {} outside its limits (min {}, max {})",
        short(start),
        short(bound("min")),
        short(bound("max"))
    )
}

fn check_nominal(model: &Model, v: &Variable, is_state: bool, out: &mut Findings) {
    let Some(nominal) = model.attribute(v, "nominal").and_then(parse_double) else { return };
    if nominal > 0.0 && nominal.is_finite() {
        return;
    }
    if is_state {
        let message =
            format!("The continuous state {v} has the nominal value {nominal}; it must be greater than 0");
        out.add(&rules::NOMINAL_STATE, model.place(v.typed), message);
    } else {
        let message = format!(
            "Variable {v} has the nominal value {nominal}; tools divide by it and expect a number greater than 0"
        );
        out.add(&rules::NOMINAL_DOUBTFUL, model.place(v.typed), message);
    }
}

fn check_integers(model: &Model, v: &Variable, out: &mut Findings) {
    let items: Option<Vec<i128>> = (v.kind == Kind::Enumeration).then_some(()).and_then(|()| {
        let t = model.type_of(v).filter(|t| t.type_name == "Enumeration")?;
        Some(children(t.typed, "Item").filter_map(|i| i.attribute("value").and_then(parse_integer)).collect())
    });
    let is_item = |start: i128| {
        let missing = items.as_ref().is_some_and(|items| !items.contains(&start));
        missing.then(|| {
            let declared = short(v.declared_type.unwrap_or_default());
            let message = format!(
                "Variable {v} has the start value {start}, which is no item of the enumeration \"{declared}\""
            );
            (&rules::START_NO_ITEM, message)
        })
    };
    check_range(model, v, parse_integer, is_item, |_, _| None, out);
}
