//! FMI 2 alias variables: the same value reference and base type.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut sets: BTreeMap<(u32, u8), Vec<&Variable>> = BTreeMap::new();
    for v in &model.variables {
        let Some(reference) = v.reference else { continue };
        // Enumerations are read and set as integers.
        let base = match v.kind {
            Kind::Float32 | Kind::Float64 => 0,
            Kind::Boolean => 1,
            Kind::String => 2,
            _ => 3,
        };
        sets.entry((reference, base)).or_default().push(v);
    }
    for ((reference, _), set) in sets.iter().filter(|(_, set)| set.len() > 1) {
        check_set(model, *reference, set, out);
    }
}

fn check_set(model: &Model, reference: u32, set: &[&Variable], out: &mut Findings) {
    let first = set[0];
    let constants = set.iter().filter(|v| v.variability == "constant").count();
    if constants != 0 && constants != set.len() {
        let other = set.iter().find(|v| (v.variability == "constant") != (first.variability == "constant"));
        let other = other.unwrap_or(&first);
        out.add(model.place(other.node), rules::alias_one_constant(first, other, reference));
        return;
    }
    if constants == set.len() {
        let start = |v: &Variable| v.typed.attribute("start").map(str::trim).map(str::to_owned);
        if let Some(other) = set.iter().find(|v| !same_value(start(v), start(first))) {
            out.add(model.place(other.node), rules::alias_constants_differ(first, other, reference));
        }
        return;
    }
    // Settable variables, those with a start value and the independent one are all free: only one may be in a set.
    let free: Vec<_> =
        set.iter().filter(|v| v.is_settable() || v.has_start || v.causality == "independent").collect();
    if let [one, two, ..] = free[..] {
        out.add(model.place(two.node), rules::alias_start(one, two, reference));
    }
    let unit = |v: &Variable| model.attribute(v, "unit").map(str::to_owned);
    if let Some(other) = set.iter().find(|v| unit(v) != unit(first)) {
        let shown = |v: &Variable| unit(v).map_or("none".to_owned(), |u| format!("\"{}\"", short(&u)));
        out.add(
            model.place(other.node),
            rules::alias_unit(first, shown(first), other, shown(other), reference),
        );
    }
}

/// Equal as text or as numbers (`1` and `1.0`, `true` and `1`).
fn same_value(a: Option<String>, b: Option<String>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return true };
    let number = |t: &str| match t {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => t.parse::<f64>().ok(),
    };
    a == b || number(&a).is_some() && number(&a) == number(&b)
}
