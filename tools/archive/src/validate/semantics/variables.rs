//! Causality, variability and initial: which combinations exist, and what else each demands.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let states = model.states();
    let cs_only = model.version == FmiVersion::V2 && model.has("CoSimulation") && !model.has("ModelExchange");
    for (v, is_state) in model.variables.iter().zip(states) {
        check_combination(model, v, out);
        if v.node.attribute("canHandleMultipleSetPerTimeInstant").is_some() {
            if v.causality != "input" {
                let message = format!(
                    "Variable {v} has canHandleMultipleSetPerTimeInstant but is {}, not input",
                    v.causality
                );
                out.add(&rules::MULTIPLE_SET_NOT_INPUT, model.place(v.node), message);
            } else if cs_only {
                let message = format!(
                    "Variable {v} has canHandleMultipleSetPerTimeInstant, which must not be present without <ModelExchange>"
                );
                out.add(&rules::MODEL_EXCHANGE_ONLY, model.place(v.node), message);
            }
        }
        if is_true(v.typed, "reinit") {
            if cs_only {
                let message =
                    format!("Variable {v} has reinit, which must not be present without <ModelExchange>");
                out.add(&rules::MODEL_EXCHANGE_ONLY, model.place(v.typed), message);
            } else if !is_state && model.has("ModelExchange") {
                let message = format!("Variable {v} has reinit but is not a continuous state");
                out.add(&rules::REINIT_NOT_STATE, model.place(v.typed), message);
            }
        }
        if is_true(v.typed, "intermediateUpdate") && v.variability != "continuous" {
            let message = format!(
                "Variable {v} has intermediateUpdate but its variability is {}, not continuous",
                v.variability
            );
            out.add(&rules::INTERMEDIATE_UPDATE, model.place(v.node), message);
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
        let message = format!(
            "Variable {v} combines causality {} with variability {}{by_default}, which is not allowed",
            v.causality, v.variability
        );
        out.add(&rules::CAUSALITY_VARIABILITY, &place, message);
        return;
    }
    if v.variability == "continuous" && !v.kind.is_float() && v.causality != "independent" {
        let floats = if model.version == FmiVersion::V2 { "Real" } else { "Float32 and Float64" };
        let message = format!(
            "Variable {v} is of type {} with variability continuous{by_default}; only {floats} may be continuous",
            v.type_name
        );
        out.add(&rules::CONTINUOUS_NOT_FLOAT, &place, message);
    }
    check_initial(model, v, &place, out);
    check_start(v, &place, out);
}

fn check_initial(model: &Model, v: &Variable, place: &str, out: &mut Findings) {
    let Some(initial) = v.initial_written else { return };
    if v.causality == "independent" || v.causality == "input" && model.version == FmiVersion::V2 {
        let message = format!(
            "Variable {v} is {} and must not have the attribute initial, which is \"{initial}\"",
            v.causality
        );
        out.add(&rules::INITIAL_FORBIDDEN, place, message);
        return;
    }
    let possible: &[&str] = match (v.causality, v.variability) {
        ("parameter" | "structuralParameter" | "input", _) | (_, "constant") => &["exact"],
        ("calculatedParameter", _) | ("local", "fixed" | "tunable") => &["calculated", "approx"],
        _ => &["exact", "approx", "calculated"],
    };
    if ["exact", "approx", "calculated"].contains(&initial) && !possible.contains(&initial) {
        let message = format!(
            "Variable {v} has initial \"{initial}\", but for causality {} and variability {} only {} is allowed",
            v.causality,
            v.variability,
            possible.join(" or ")
        );
        out.add(&rules::INITIAL_NOT_ALLOWED, place, message);
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
        out.add(&rules::START_MISSING, place, format!("Variable {v} has no start value although {reason}"));
    }
    if v.has_start && v.causality == "independent" {
        let message = format!("Variable {v} is the independent variable and must not have a start value");
        out.add(&rules::START_FORBIDDEN, place, message);
    } else if v.has_start && v.initial == Some("calculated") {
        let how = if v.initial_written.is_some() { "" } else { " by default" };
        let message = format!("Variable {v} has a start value although its initial is calculated{how}");
        out.add(&rules::START_FORBIDDEN, place, message);
    }
}

fn check_independent(model: &Model, out: &mut Findings) {
    let all: Vec<_> = model.variables.iter().filter(|v| v.causality == "independent").collect();
    for v in &all {
        if !v.kind.is_float() {
            let message = format!(
                "Variable {v} is the independent variable and must be a floating point number, not {}",
                v.type_name
            );
            out.add(&rules::INDEPENDENT_NOT_FLOAT, model.place(v.node), message);
        }
    }
    for v in all.iter().skip(1) {
        let message = format!("Variable {v} is a second independent variable; only one is allowed");
        out.add(&rules::INDEPENDENT_REPEATED, model.place(v.node), message);
    }
    if all.is_empty() && model.version == FmiVersion::V3 {
        let message = "No variable has causality independent; exactly one must";
        out.add(&rules::INDEPENDENT_MISSING, model.place(model.root), message);
    }
}
