//! Continuous states and their derivatives.

use super::*;

/// No equation of motion has more time derivatives than this.
const HIGHEST_ORDER: usize = 64;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut units: HashMap<&str, Node> = HashMap::new();
    for unit in children(model.root, "UnitDefinitions").flat_map(|list| children(list, "Unit")) {
        unit.attribute("name").map(|name| units.entry(name).or_insert(unit));
    }
    for (i, v) in model.variables.iter().enumerate() {
        check_attribute(model, i, v, out);
    }
    let mut derivative_of: HashMap<usize, &str> = HashMap::new();
    for unknown in &model.structure.derivatives {
        let Some(v) = unknown.variable.map(|i| &model.variables[i]) else { continue };
        let place = model.place(unknown.node);
        if !v.kind.is_float() || v.variability != "continuous" {
            out.add(&place, rules::derivative_not_continuous(v, v.variability, v.type_name));
            continue;
        }
        if v.typed.attribute("derivative").is_none() {
            out.add(&place, rules::derivative_missing(v));
            continue;
        }
        let Some(index) = model.state_of(v) else { continue };
        let state = &model.variables[index];
        if let Some(first) = derivative_of.insert(index, v.name) {
            out.add(&place, rules::state_repeated(short(first), v, state));
            continue;
        }
        if !["local", "output"].contains(&state.causality) {
            out.add(model.place(state.node), rules::state_causality(state, state.causality));
        }
        check_unit(model, v, state, &units, out);
        if let (Some(a), Some(b)) = (arrays::size(model, v), arrays::size(model, state))
            && a != b
        {
            out.add(&place, rules::derivative_size(state, b, v, a));
        }
    }
    check_unlisted(model, out);
}

fn check_attribute(model: &Model, index: usize, v: &Variable, out: &mut Findings) {
    let Some(reference) = v.derivative else { return };
    let place = model.place(v.typed);
    let Some(target) = model.state_of(v) else {
        out.add(place, rules::derivative_reference(v, model.reference_word(), reference));
        return;
    };
    let state = &model.variables[target];
    if is_on_cycle(model, index) {
        out.add(place, rules::derivative_cycle(v));
        return;
    }
    if !state.kind.is_float() || state.variability != "continuous" {
        out.add(place, rules::derivative_target(v, state, state.variability, state.type_name));
        return;
    }
    check_name(model, v, target, &place, out);
}

/// Whether the chain of `derivative` is cyclic; reported once, at the cycle's first variable.
fn is_on_cycle(model: &Model, start: usize) -> bool {
    let mut at = start;
    for _ in 0..HIGHEST_ORDER {
        match model.state_of(&model.variables[at]) {
            Some(next) if next == start => return true,
            Some(next) if next > start => at = next,
            _ => return false,
        }
    }
    false
}

/// `der(x)` must be the derivative of `x`, if there is an `x`.
fn check_name(model: &Model, v: &Variable, target: usize, place: &str, out: &mut Findings) {
    let Some(inner) = v.name.strip_prefix("der(").and_then(|n| n.strip_suffix(')')) else { return };
    let has_name =
        |w: &Variable| w.name == inner || w.aliases.iter().any(|a| a.attribute("name") == Some(inner));
    let state = &model.variables[target];
    if has_name(state) {
        return;
    }
    // In FMI 2 an alias is another variable with the same value reference.
    let Some(named) = model.variables.iter().find(|w| has_name(w)) else { return };
    if model.version == FmiVersion::V2 && named.reference == state.reference && named.kind == state.kind {
        return;
    }
    let message = format!("Variable {v} points with derivative to {state} instead of \"{}\"", short(inner));
    if model.root.attribute("variableNamingConvention") == Some("structured") {
        out.add(place, rules::DERIVATIVE_NAME.says(message));
    } else {
        // In the convention "flat" a name has no meaning.
        out.add(place, rules::DERIVATIVE_NAME_DOUBTFUL.says(message));
    }
}

/// Exponents of kg, m, s, A, K, mol, cd (the radian is a number), and the factor.
fn base(unit: Option<&Node>) -> Option<([i128; 7], f64)> {
    let node = children(*unit?, "BaseUnit").next()?;
    let exponent = |name| node.attribute(name).and_then(parse_integer).unwrap_or(0);
    let exponents = ["kg", "m", "s", "A", "K", "mol", "cd"].map(exponent);
    Some((exponents, double(node, "factor").unwrap_or(1.0)))
}

/// The numbers of a derivative are those of the state per unit of time, so their units are tied together.
fn check_unit(
    model: &Model,
    v: &Variable,
    state: &Variable,
    units: &HashMap<&str, Node>,
    out: &mut Findings,
) {
    let unit_of = |w: &Variable| model.attribute(w, "unit").and_then(|u| base(units.get(u)));
    let time = model.variables.iter().find(|w| w.causality == "independent");
    let seconds = time.and_then(|t| model.attribute(t, "unit")).is_none_or(|u| u == "s");
    let (Some((of_v, factor_v)), Some((of_state, factor_state))) = (unit_of(v), unit_of(state)) else {
        return;
    };
    if !seconds {
        return;
    }
    let names = format!(
        "the unit \"{}\" of {state} and the unit \"{}\" of its derivative {v}",
        short(model.attribute(state, "unit").unwrap_or_default()),
        short(model.attribute(v, "unit").unwrap_or_default())
    );
    let place = model.place(v.typed);
    let mut expected = of_state;
    expected[2] -= 1;
    if of_v == of_state {
        out.add(place, rules::derivative_unit_timeless(names));
    } else if of_v != expected {
        out.add(place, rules::derivative_unit(names));
    } else if (factor_v - factor_state).abs() > 1e-3 * factor_state.abs() {
        out.add(place, rules::derivative_factor(factor_state, factor_v, names));
    }
}

/// A derivative of a local variable that is not listed for Model Exchange is a state that is not integrated.
fn check_unlisted(model: &Model, out: &mut Findings) {
    if !model.has("ModelExchange") {
        return;
    }
    let states = model.states();
    for (index, v) in model.variables.iter().enumerate() {
        let Some(target) = model.state_of(v).filter(|t| !states[*t]) else { continue };
        if is_on_cycle(model, index) || is_on_cycle(model, target) {
            continue;
        }
        let state = &model.variables[target];
        if v.causality == "local" && state.causality == "local" && state.variability == "continuous" {
            out.add(model.place(v.node), rules::derivative_not_listed(v, state));
        }
    }
}
