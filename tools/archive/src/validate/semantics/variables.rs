//! Causality, variability and initial: which combinations exist, and what else each demands.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let states = model.states();
    let cs_only = model.version == FmiVersion::V2 && model.has("CoSimulation") && !model.has("ModelExchange");
    for (v, is_state) in model.variables.iter().zip(states) {
        check_combination(model, v, out);
        if v.node.attribute("canHandleMultipleSetPerTimeInstant").is_some() {
            if v.causality != "input" {
                out.add(model.place(v.node), rules::multiple_set_not_input(v, v.causality));
            } else if cs_only {
                out.add(model.place(v.node), rules::multiple_set_without_exchange(v));
            }
        }
        if is_true(v.typed, "reinit") {
            if cs_only {
                out.add(model.place(v.typed), rules::reinit_without_exchange(v));
            } else if !is_state && model.has("ModelExchange") {
                out.add(model.place(v.typed), rules::reinit_not_state(v));
            }
        }
        if is_true(v.typed, "intermediateUpdate") && v.variability != "continuous" {
            out.add(model.place(v.node), rules::intermediate_update(v, v.variability));
        }
    }
    check_independent(model, out);
}

fn allowed(causality: &str, variability: &str) -> bool {
    match causality {
        "parameter" | "calculatedParameter" | "structuralParameter" => {
            ["fixed", "tunable"].contains(&variability)
        }
        "input" => ["discrete", "continuous"].contains(&variability),
        "output" => ["constant", "discrete", "continuous"].contains(&variability),
        "local" => true,
        "independent" => variability == "continuous",
        // Not one of the words: the schema rules report it.
        _ => true,
    }
}

fn check_combination(model: &Model, v: &Variable, out: &mut Findings) {
    let place = model.place(v.node);
    let words = ["constant", "fixed", "tunable", "discrete", "continuous"];
    if !words.contains(&v.variability) {
        return;
    }
    let by_default = if v.node.attribute("variability").is_none() { " (the default)" } else { "" };
    if !allowed(v.causality, v.variability) {
        out.add(&place, rules::causality_variability(v, v.causality, v.variability, by_default));
        return;
    }
    if v.variability == "continuous" && !v.kind.is_float() && v.causality != "independent" {
        let floats = if model.version == FmiVersion::V2 { "Real" } else { "Float32 and Float64" };
        out.add(&place, rules::continuous_not_float(v, v.type_name, by_default, floats));
    }
    check_initial(model, v, &place, out);
    check_start(v, &place, out);
}

fn check_initial(model: &Model, v: &Variable, place: &str, out: &mut Findings) {
    let Some(initial) = v.initial_written else { return };
    if v.causality == "independent" || v.causality == "input" && model.version == FmiVersion::V2 {
        out.add(place, rules::initial_forbidden(v, v.causality, initial));
        return;
    }
    let possible: &[&str] = match (v.causality, v.variability) {
        ("parameter" | "structuralParameter" | "input", _) | (_, "constant") => &["exact"],
        ("calculatedParameter", _) | ("local", "fixed" | "tunable") => &["calculated", "approx"],
        _ => &["exact", "approx", "calculated"],
    };
    if ["exact", "approx", "calculated"].contains(&initial) && !possible.contains(&initial) {
        out.add(
            place,
            rules::initial_not_allowed(v, initial, v.causality, v.variability, possible.join(" or ")),
        );
    }
}

fn check_start(v: &Variable, place: &str, out: &mut Findings) {
    if v.kind == Kind::Clock {
        return;
    }
    let reason = match (v.causality, v.variability, v.initial) {
        ("independent", ..) => None,
        ("input", ..) => Some("it is an input".to_owned()),
        ("parameter" | "structuralParameter", ..) => Some("it is a parameter".to_owned()),
        (_, "constant", _) => Some("it is a constant".to_owned()),
        (_, _, Some(i @ ("exact" | "approx"))) => Some(format!("initial is {i}")),
        _ => None,
    };
    if let Some(reason) = reason.filter(|_| !v.has_start) {
        out.add(place, rules::start_missing(v, reason));
    }
    if v.has_start && v.causality == "independent" {
        out.add(place, rules::independent_with_start(v));
    } else if v.has_start && v.initial == Some("calculated") {
        let how = if v.initial_written.is_some() { "" } else { " by default" };
        out.add(place, rules::calculated_with_start(v, how));
    }
}

fn check_independent(model: &Model, out: &mut Findings) {
    let all: Vec<_> = model.variables.iter().filter(|v| v.causality == "independent").collect();
    for v in &all {
        if !v.kind.is_float() {
            out.add(model.place(v.node), rules::independent_not_float(v, v.type_name));
        }
    }
    for v in all.iter().skip(1) {
        out.add(model.place(v.node), rules::independent_repeated(v));
    }
    if all.is_empty() && model.version == FmiVersion::V3 {
        out.add(model.place(model.root), rules::independent_missing());
    }
}
