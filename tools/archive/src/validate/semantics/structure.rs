//! The lists of the model structure: references, outputs, dependencies.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let s = &model.structure;
    let states = model.states();
    let lists = [
        ("outputs", &s.outputs),
        ("state derivatives", &s.derivatives),
        ("clocked states", &s.clocked_states),
        ("initial unknowns", &s.initial_unknowns),
        ("event indicators", &s.event_indicators),
    ];
    for (list, unknowns) in lists {
        let mut seen = HashSet::new();
        for unknown in unknowns {
            let Some(reference) = unknown.reference else { continue };
            let place = model.place(unknown.node);
            let Some(index) = unknown.variable else {
                out.add(place, rules::unknown_reference(list, model.reference_word(), reference));
                continue;
            };
            if !seen.insert(index) {
                out.add(place, rules::unknown_repeated(short(model.variables[index].name), list));
                continue;
            }
            let knowns = match list {
                "initial unknowns" => Knowns::Initial,
                "outputs" | "state derivatives" => Knowns::Running(&states),
                // The standard gives no list of knowns for the others.
                _ => Knowns::Any,
            };
            check_dependencies(model, unknown, &model.variables[index], knowns, out);
        }
    }
    check_outputs(model, out);
    check_event_indicators(model, out);
}

fn check_outputs(model: &Model, out: &mut Findings) {
    let listed: HashSet<usize> = model.structure.outputs.iter().filter_map(|u| u.variable).collect();
    for (i, v) in model.variables.iter().enumerate() {
        if v.causality == "output" && !listed.contains(&i) {
            out.add(model.place(v.node), rules::output_not_listed(v));
        }
    }
    for unknown in &model.structure.outputs {
        if let Some(v) = unknown.variable.map(|i| &model.variables[i]).filter(|v| v.causality != "output") {
            out.add(model.place(unknown.node), rules::output_causality(v, v.causality));
        }
    }
}

fn check_event_indicators(model: &Model, out: &mut Findings) {
    for unknown in &model.structure.event_indicators {
        let Some(v) = unknown.variable.map(|i| &model.variables[i]) else { continue };
        let wrong = if !v.kind.is_float() {
            format!("is of type {}, not a floating point number", v.type_name)
        } else if v.variability != "continuous" {
            format!("has variability {}, not continuous", v.variability)
        } else if !["local", "output"].contains(&v.causality) {
            format!("has causality {}, not local or output", v.causality)
        } else {
            continue;
        };
        out.add(model.place(unknown.node), rules::event_indicator(v, wrong));
    }
}

/// Which variables an unknown may depend on.
#[derive(Clone, Copy)]
enum Knowns<'a> {
    /// In initialisation mode.
    Initial,
    /// Later; with, for each variable, whether it is a continuous state.
    Running(&'a [bool]),
    Any,
}

fn check_dependencies(model: &Model, unknown: &Unknown, v: &Variable, knowns: Knowns, out: &mut Findings) {
    let place = model.place(unknown.node);
    let kinds: Option<Vec<&str>> =
        unknown.node.attribute("dependenciesKind").map(|k| k.split_ascii_whitespace().collect());
    let Some(text) = unknown.node.attribute("dependencies") else {
        if kinds.is_some() {
            out.add(place, rules::kind_alone(v));
        }
        return;
    };
    let written = text.split_ascii_whitespace().count();
    if let Some(kinds) = &kinds {
        check_kinds(v, kinds, written, matches!(knowns, Knowns::Initial), &place, out);
    }
    let dependencies = unsigned_list(text);
    if model.version == FmiVersion::V2 && !dependencies.is_sorted() {
        out.add(&place, rules::dependencies_order(v));
    }
    let mut seen = HashSet::new();
    for reference in dependencies {
        if !seen.insert(reference) {
            out.add(&place, rules::dependency_repeated(v, model.reference_word(), reference));
            continue;
        }
        let Some(index) = model.resolve(reference) else {
            out.add(&place, rules::dependency_reference(v, model.reference_word(), reference));
            continue;
        };
        let known = &model.variables[index];
        let (is_known, mode) = match knowns {
            Knowns::Initial => (is_initial_known(known), "during initialisation"),
            Knowns::Running(states) => (is_known(known, states[index]), "after initialisation"),
            Knowns::Any => (true, ""),
        };
        if !is_known {
            out.add(&place, rules::dependency_not_known(v, known, known.variability, known.causality, mode));
        }
    }
}

fn check_kinds(v: &Variable, kinds: &[&str], written: usize, initial: bool, place: &str, out: &mut Findings) {
    if kinds.len() != written {
        out.add(place, rules::kind_length(v, written, kinds.len()));
    }
    if let Some(kind) = kinds.iter().find(|k| initial && ["fixed", "tunable", "discrete"].contains(*k)) {
        out.add(place, rules::kind_initial(v, kind));
    } else if let Some(kind) = kinds.iter().find(|k| !v.kind.is_float() && **k != "dependent") {
        out.add(place, rules::kind_not_float(v, v.type_name, kind));
    }
}

/// Knowns in event and continuous-time mode and at communication points.
///
/// Discrete-time states are knowns, too, and only clocked ones are marked, so every discrete variable is accepted. Parameters are
/// also accepted in FMI 2: its formulas contain them, but its list of knowns does not.
fn is_known(v: &Variable, is_state: bool) -> bool {
    let computed = matches!(v.causality, "output" | "local" | "calculatedParameter");
    !computed || is_state || v.variability == "discrete" || v.kind == Kind::Clock
}

fn is_initial_known(v: &Variable) -> bool {
    let computed = matches!(v.causality, "output" | "local" | "calculatedParameter");
    !computed || v.initial == Some("exact") || v.kind == Kind::Clock
}
