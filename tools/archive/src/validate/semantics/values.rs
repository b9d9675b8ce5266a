//! Start values, limits and nominal values.

use super::*;
use crate::validate::rules::Breach;
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
            out.add(model.place(v.typed), rules::limit_nan(name, v));
        }
    }
    let finite = |start: f64, text: &str| match model.version {
        _ if start.is_finite() => None,
        FmiVersion::V2 => Some(rules::value_special(v, text)),
        FmiVersion::V3 => Some(rules::start_not_finite(v, text)),
    };
    check_range(model, v, parse_double, |_| None, finite, out);
}

/// Limits that are not crossed, and start values within them; `before` and `after` check a start value before and after
/// its limits. The first fault ends the check.
fn check_range<T: PartialOrd + Display + Copy>(
    model: &Model,
    v: &Variable,
    parse: fn(&str) -> Option<T>,
    before: impl Fn(T) -> Option<Breach>,
    after: impl Fn(T, &str) -> Option<Breach>,
    out: &mut Findings,
) {
    let limit = |name: &str| model.attribute(v, name).and_then(parse);
    let (min, max) = (limit("min"), limit("max"));
    let crossed = min.zip(max).filter(|(min, max)| min > max);
    let crossed = crossed.map(|(min, max)| rules::limits_crossed(v, min, max));
    let is_outside = |start: T| min.is_some_and(|m| start < m) || max.is_some_and(|m| start > m);
    let shown = |name| short(model.attribute(v, name).map_or("none", str::trim));
    let texts = v.typed.attribute("start").unwrap_or_default().split_ascii_whitespace();
    let mut starts = texts.filter_map(|text| Some((text, parse(text)?))).filter_map(|(text, start)| {
        let outside = || rules::start_outside(v, short(text), shown("min"), shown("max"));
        before(start).or_else(|| is_outside(start).then(outside)).or_else(|| after(start, text))
    });
    if let Some(breach) = crossed.or_else(|| starts.next()) {
        out.add(model.place(v.typed), breach);
    }
}

fn check_nominal(model: &Model, v: &Variable, is_state: bool, out: &mut Findings) {
    let Some(nominal) = model.attribute(v, "nominal").and_then(parse_double) else { return };
    if nominal > 0.0 && nominal.is_finite() {
        return;
    }
    if is_state {
        out.add(model.place(v.typed), rules::nominal_state(v, nominal));
    } else {
        out.add(model.place(v.typed), rules::nominal_doubtful(v, nominal));
    }
}

fn check_integers(model: &Model, v: &Variable, out: &mut Findings) {
    let items: Option<Vec<i128>> = (v.kind == Kind::Enumeration).then_some(()).and_then(|()| {
        let t = model.type_of(v).filter(|t| t.type_name == "Enumeration")?;
        Some(children(t.typed, "Item").filter_map(|i| i.attribute("value").and_then(parse_integer)).collect())
    });
    let is_item = |start: i128| {
        let is_missing = items.as_ref().is_some_and(|items| !items.contains(&start));
        is_missing.then(|| rules::start_no_item(v, start, short(v.declared_type.unwrap_or_default())))
    };
    check_range(model, v, parse_integer, is_item, |_, _| None, out);
}
