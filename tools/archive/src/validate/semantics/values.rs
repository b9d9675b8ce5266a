//! Start values, limits and nominal values.

use super::*;

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
    let place = model.place(v.typed);
    let limit = |name: &str| model.attribute(v, name).and_then(parse_double);
    let (min, max) = (limit("min"), limit("max"));
    for (name, value) in [("min", min), ("max", max)] {
        if value.is_some_and(f64::is_nan) {
            out.add(
                &rules::LIMIT_NAN,
                &place,
                format!("The {name} of variable {v} is NaN and limits nothing"),
            );
        }
    }
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        out.add(&rules::LIMITS_CROSSED, &place, format!("Variable {v} has min {min} above max {max}"));
        return;
    }
    for text in v.typed.attribute("start").unwrap_or_default().split_ascii_whitespace() {
        let Some(start) = parse_double(text) else { continue };
        if min.is_some_and(|m| start < m) || max.is_some_and(|m| start > m) {
            out.add(&rules::START_OUTSIDE, &place, outside(v, text, model));
            return;
        }
        if !start.is_finite() {
            let rule = match model.version {
                FmiVersion::V2 => &rules::VALUE_SPECIAL,
                FmiVersion::V3 => &rules::START_NOT_FINITE,
            };
            out.add(rule, &place, format!("Variable {v} has the start value {text}"));
            return;
        }
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
    let place = model.place(v.typed);
    let limit = |name: &str| model.attribute(v, name).and_then(parse_integer);
    let (min, max) = (limit("min"), limit("max"));
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        out.add(&rules::LIMITS_CROSSED, &place, format!("Variable {v} has min {min} above max {max}"));
        return;
    }
    let items: Option<Vec<i128>> = (v.kind == Kind::Enumeration).then_some(()).and_then(|()| {
        let t = model.type_of(v).filter(|t| t.type_name == "Enumeration")?;
        Some(children(t.typed, "Item").filter_map(|i| i.attribute("value").and_then(parse_integer)).collect())
    });
    for text in v.typed.attribute("start").unwrap_or_default().split_ascii_whitespace() {
        let Some(start) = parse_integer(text) else { continue };
        if items.as_ref().is_some_and(|items| !items.contains(&start)) {
            let message = format!(
                "Variable {v} has the start value {start}, which is no item of the enumeration \"{}\"",
                short(v.declared_type.unwrap_or_default())
            );
            out.add(&rules::START_NO_ITEM, &place, message);
            return;
        }
        if min.is_some_and(|m| start < m) || max.is_some_and(|m| start > m) {
            out.add(&rules::START_OUTSIDE, &place, outside(v, text, model));
            return;
        }
    }
}
