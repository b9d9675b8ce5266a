//! FMI 3 arrays: dimensions, structural parameters, number of start values.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    for v in &model.variables {
        if v.is_array() && v.causality == "structuralParameter" {
            out.add(model.place(v.node), rules::structural_array(v));
        }
        for dimension in children(v.typed, "Dimension") {
            check_dimension(model, v, dimension, out);
        }
        check_start_count(model, v, out);
    }
}

fn check_dimension(model: &Model, v: &Variable, dimension: Node, out: &mut Findings) {
    let place = model.place(dimension);
    let mut complain = |what: String| out.add(&place, rules::dimension(v, what));
    match (dimension.attribute("start"), dimension.attribute("valueReference")) {
        (Some(_), Some(_)) => complain("has both start and valueReference; only one is allowed".into()),
        (None, None) => complain("has neither start nor valueReference".into()),
        (Some(start), None) => {
            if parse_integer(start) == Some(0) {
                complain("has the size 0; initial sizes must be positive".into());
            }
        }
        (None, Some(_)) => {
            let Some(reference) = unsigned(dimension, "valueReference") else { return };
            let Some(size) = model.resolve(reference).map(|i| &model.variables[i]) else {
                complain(format!("refers to value reference {reference}, which no variable has"));
                return;
            };
            if size.kind != Kind::UInt64 {
                complain(format!("refers to {size}, which is of type {}, not UInt64", size.type_name));
            } else if size.causality != "structuralParameter" && size.variability != "constant" {
                complain(format!("refers to {size}, which is neither a structural parameter nor a constant"));
            } else if size.typed.attribute("start").and_then(parse_integer) == Some(0) {
                complain(format!("refers to {size}, whose start value is 0; initial sizes must be positive"));
            }
        }
    }
}

/// The initial number of elements, if it is known.
pub(crate) fn size(model: &Model, v: &Variable) -> Option<u128> {
    children(v.typed, "Dimension").try_fold(1_u128, |product, d| {
        let length = match d.attribute("start") {
            Some(start) => parse_integer(start),
            None => unsigned(d, "valueReference")
                .and_then(|r| model.resolve(r))
                .filter(|i| model.variables[*i].kind == Kind::UInt64)
                .and_then(|i| model.variables[i].typed.attribute("start"))
                .and_then(parse_integer),
        };
        product.checked_mul(u128::try_from(length?).ok()?)
    })
}

fn check_start_count(model: &Model, v: &Variable, out: &mut Findings) {
    let Some(elements) = size(model, v) else { return };
    let count = match v.typed.attribute("start") {
        Some(start) => start.split_ascii_whitespace().count(),
        None => children(v.typed, "Start").count(),
    };
    // A single value applies to all elements; an empty start attribute has no values.
    let empty = count == 0 && v.typed.attribute("start").is_some();
    if empty || count > 1 && count as u128 != elements {
        out.add(model.place(v.typed), rules::start_count(v, count, elements));
    }
}
