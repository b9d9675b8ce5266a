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
                let message = format!(
                    "The list of {list} refers to {} {reference}, which no variable has",
                    model.reference_word()
                );
                out.add(&rules::UNKNOWN_REFERENCE, place, message);
                continue;
            };
            if !seen.insert(index) {
                let message = format!(
                    "Variable \"{}\" is listed more than once among the {list}",
                    short(model.variables[index].name)
                );
                out.add(&rules::UNKNOWN_REPEATED, place, message);
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
            let message =
                format!("Variable {v} is an output but is not listed among the outputs of <ModelStructure>");
            out.add(&rules::OUTPUT_NOT_LISTED, model.place(v.node), message);
        }
    }
    for unknown in &model.structure.outputs {
        if let Some(v) = unknown.variable.map(|i| &model.variables[i]).filter(|v| v.causality != "output") {
            let message =
                format!("Variable {v} is listed among the outputs but its causality is {}", v.causality);
            out.add(&rules::OUTPUT_CAUSALITY, model.place(unknown.node), message);
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
        let message = format!("The event indicator {v} {wrong}");
        out.add(&rules::EVENT_INDICATOR, model.place(unknown.node), message);
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
            let message = format!("The entry of variable {v} has dependenciesKind but no dependencies");
            out.add(&rules::KIND_ALONE, place, message);
        }
        return;
    };
    let written = text.split_ascii_whitespace().count();
    if let Some(kinds) = &kinds {
        check_kinds(v, kinds, written, matches!(knowns, Knowns::Initial), &place, out);
    }
    let dependencies = unsigned_list(text);
    if model.version == FmiVersion::V2 && !dependencies.is_sorted() {
        let message = format!("The dependencies of variable {v} are not in the order of their indices");
        out.add(&rules::DEPENDENCIES_ORDER, &place, message);
    }
    let mut seen = HashSet::new();
    for reference in dependencies {
        if !seen.insert(reference) {
            let message = format!(
                "Variable {v} lists {} {reference} twice among its dependencies",
                model.reference_word()
            );
            out.add(&rules::DEPENDENCY_REPEATED, &place, message);
            continue;
        }
        let Some(index) = model.resolve(reference) else {
            let message = format!(
                "Variable {v} depends on {} {reference}, which no variable has",
                model.reference_word()
            );
            out.add(&rules::DEPENDENCY_REFERENCE, &place, message);
            continue;
        };
        let known = &model.variables[index];
        let (is_known, mode) = match knowns {
            Knowns::Initial => (is_initial_known(known), "during initialisation"),
            Knowns::Running(states) => (is_known(known, states[index]), "after initialisation"),
            Knowns::Any => (true, ""),
        };
        if !is_known {
            let message = format!(
                "Variable {v} depends on {known}, which is {} {} and not among the knowns {mode}",
                known.variability, known.causality
            );
            out.add(&rules::DEPENDENCY_NOT_KNOWN, &place, message);
        }
    }
}

fn check_kinds(v: &Variable, kinds: &[&str], written: usize, initial: bool, place: &str, out: &mut Findings) {
    if kinds.len() != written {
        let message = format!(
            "The entry of variable {v} has {written} dependencies but {} items in dependenciesKind",
            kinds.len()
        );
        out.add(&rules::KIND_LENGTH, place, message);
    }
    if let Some(kind) = kinds.iter().find(|k| initial && ["fixed", "tunable", "discrete"].contains(*k)) {
        let message = format!(
            "The initial unknown {v} has the dependenciesKind {kind}; only dependent and constant are allowed there"
        );
        out.add(&rules::KIND_INITIAL, place, message);
    } else if let Some(kind) = kinds.iter().find(|k| !v.kind.is_float() && **k != "dependent") {
        let message = format!(
            "Variable {v} is of type {} and has the dependenciesKind {kind}, which is meant for floating point numbers",
            v.type_name
        );
        out.add(&rules::KIND_NOT_FLOAT, place, message);
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
