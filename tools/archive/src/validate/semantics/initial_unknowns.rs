//! The list of initial unknowns is complete and has no other entries.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let calculated = |i: usize| matches!(model.variables[i].initial, Some("approx" | "calculated"));
    let mut expected: HashSet<usize> = HashSet::new();
    for (i, v) in model.variables.iter().enumerate() {
        let output = v.causality == "output" && calculated(i) && !v.clocked && v.kind != Kind::Clock;
        if output || v.causality == "calculatedParameter" {
            expected.insert(i);
        }
    }
    for derivative in model.structure.derivatives.iter().filter_map(|u| u.variable) {
        let state = model.state_of(&model.variables[derivative]);
        expected.extend([Some(derivative), state].into_iter().flatten().filter(|i| calculated(*i)));
    }
    let listed: HashSet<usize> = model.structure.initial_unknowns.iter().filter_map(|u| u.variable).collect();
    for (i, v) in model.variables.iter().enumerate() {
        if expected.contains(&i) && !listed.contains(&i) {
            let message = format!(
                "Variable {v} is calculated during initialisation but is not listed among the initial unknowns"
            );
            out.add(&rules::INITIAL_UNKNOWN_MISSING, model.place(v.node), message);
        }
    }
    let mut last = 0;
    for unknown in &model.structure.initial_unknowns {
        let Some(i) = unknown.variable else { continue };
        let v = &model.variables[i];
        // FMI 3: "clocked variables that the FMU wishes to initialize".
        if !expected.contains(&i) && !v.clocked && v.kind != Kind::Clock {
            let initial = v.initial.unwrap_or("none");
            let message = format!(
                "Variable {v} is listed among the initial unknowns but is not one: its causality is {}, its initial {initial}",
                v.causality
            );
            out.add(&rules::INITIAL_UNKNOWN_WRONG, model.place(unknown.node), message);
        }
        if model.version == FmiVersion::V2 && i < last {
            let message = format!(
                "Variable {v} is out of order: initial unknowns must be listed in the order of their indices"
            );
            out.add(&rules::INITIAL_UNKNOWNS_ORDER, model.place(unknown.node), message);
        }
        last = last.max(i);
    }
}
