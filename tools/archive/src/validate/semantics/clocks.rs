//! FMI 3 clocks, clocked variables and clocked states.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut previous_of: HashMap<u32, &str> = HashMap::new();
    for v in &model.variables {
        if v.kind == Kind::Clock {
            check_clock(model, v, out);
        }
        check_clocked(model, v, out);
        check_previous(model, v, &mut previous_of, out);
    }
    for unknown in &model.structure.clocked_states {
        let Some(v) = unknown.variable.map(|i| &model.variables[i]) else { continue };
        if v.node.attribute("previous").is_none() || !v.clocked || v.kind == Kind::Clock {
            out.add(model.place(unknown.node), rules::clocked_state(v));
        }
    }
    let has_clocks = model.variables.iter().any(|v| v.kind == Kind::Clock);
    for cs in model.interfaces.iter().filter(|i| i.has_tag_name("CoSimulation")) {
        if has_clocks && !is_true(*cs, "hasEventMode") {
            out.add(model.place(*cs), rules::clocks_without_events());
        }
    }
}

fn check_clock(model: &Model, v: &Variable, out: &mut Findings) {
    let place = model.place(v.node);
    if !["input", "output", "local"].contains(&v.causality) {
        out.add(&place, rules::clock_causality(v, v.causality));
    }
    // Continuous clocks are found by the rule on variability.
    if !["discrete", "continuous"].contains(&v.variability) && v.causality == "local" {
        out.add(&place, rules::clock_variability(v, v.variability));
    }
    let mut interval = |what: String| out.add(&place, rules::clock_interval(v, what));
    let kind = model.attribute(v, "intervalVariability").unwrap_or_default();
    let periodic = ["constant", "fixed", "tunable"].contains(&kind);
    let decimal = model.attribute(v, "intervalDecimal").and_then(parse_double);
    let counter = model.attribute(v, "intervalCounter").and_then(parse_integer);
    let resolution = model.attribute(v, "resolution").and_then(parse_integer);
    if periodic && decimal.is_none() && counter.is_none() {
        interval(format!("has intervalVariability {kind} but no intervalDecimal"));
    } else if !kind.is_empty() && !periodic && (decimal.is_some() || counter.is_some()) {
        interval(format!("has intervalVariability {kind} and must not have an interval"));
    } else if decimal.is_some_and(|d| d.is_nan() || d <= 0.0) || counter == Some(0) || resolution == Some(0) {
        interval("has an interval or a resolution of 0 or less".into());
    } else if counter.is_some() && resolution.is_none() {
        interval("has intervalCounter but no resolution".into());
    } else if model.attribute(v, "shiftDecimal").and_then(parse_double).is_some_and(|s| s.is_nan() || s < 0.0)
    {
        interval("has a negative shiftDecimal".into());
    }
    let priority = model.attribute(v, "priority").is_some();
    if v.causality == "output" && priority {
        out.add(&place, rules::clock_priority_of_output(v));
    } else if v.causality == "input" && !priority && model.has("ScheduledExecution") {
        out.add(&place, rules::clock_priority_missing(v));
    }
}

fn check_clocked(model: &Model, v: &Variable, out: &mut Findings) {
    let Some(text) = v.node.attribute("clocks") else { return };
    let place = model.place(v.node);
    let mut complain = |what: String| out.add(&place, rules::clocks(v, what));
    if text.trim().is_empty() {
        complain("has an empty list of clocks".into());
    }
    if !["discrete", "tunable"].contains(&v.variability) {
        complain(format!(
            "has clocks but variability {}; only discrete and tunable variables may be clocked",
            v.variability
        ));
    }
    for reference in unsigned_list(text) {
        match model.resolve(reference).map(|i| &model.variables[i]) {
            None => {
                complain(format!("names the clock with value reference {reference}, which no variable has"))
            }
            Some(c) if c.kind != Kind::Clock => {
                complain(format!("names {c} as its clock, which is of type {}", c.type_name))
            }
            Some(_) => {}
        }
    }
}

fn check_previous<'a>(
    model: &Model<'a>,
    v: &Variable<'a>,
    seen: &mut HashMap<u32, &'a str>,
    out: &mut Findings,
) {
    let Some(reference) = unsigned(v.node, "previous") else { return };
    let place = model.place(v.node);
    let mut complain = |what: String| out.add(&place, rules::previous(v, what));
    if !v.clocked {
        complain("has the attribute previous but no clocks".into());
        return;
    }
    if v.variability != "discrete" {
        complain(format!("has the attribute previous but variability {}, not discrete", v.variability));
        return;
    }
    let Some(target) = model.resolve(reference).map(|i| &model.variables[i]) else {
        complain(format!("has its previous value at value reference {reference}, which no variable has"));
        return;
    };
    if Some(reference) == v.reference {
        complain("names itself as its previous value".into());
    } else if let Some(other) = seen.insert(reference, v.name) {
        complain(format!("has the same previous value as \"{}\"", short(other)));
    } else if target.type_name != v.type_name
        || target.variability != "discrete"
        || target.causality == "input"
    {
        complain(format!(
            "has {target} as its previous value, which must be a discrete {} and no input",
            v.type_name
        ));
    }
}
