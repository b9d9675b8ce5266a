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
            out.add(model.place(v.node), rules::initial_unknown_missing(v));
        }
    }
    let mut last = 0;
    for unknown in &model.structure.initial_unknowns {
        let Some(i) = unknown.variable else { continue };
        let v = &model.variables[i];
        // FMI 3: "clocked variables that the FMU wishes to initialize".
        if !expected.contains(&i) && !v.clocked && v.kind != Kind::Clock {
            let initial = v.initial.unwrap_or("none");
            out.add(model.place(unknown.node), rules::initial_unknown_wrong(v, v.causality, initial));
        }
        if model.version == FmiVersion::V2 && i < last {
            out.add(model.place(unknown.node), rules::initial_unknowns_order(v));
        }
        last = last.max(i);
    }
}
