//! Unit definitions, and the units and display units of variables and types.

use super::unit_meaning::{Declared, check_display, check_meaning};
use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut units: HashMap<&str, HashSet<&str>> = HashMap::new();
    let of_differences = only_of_differences(model);
    for unit in children(model.root, "UnitDefinitions").flat_map(|list| children(list, "Unit")) {
        let Some(name) = unit.attribute("name") else { continue };
        let displays = check_definition(model, unit, name, of_differences.contains(name), out);
        if units.insert(name, displays).is_some() {
            out.add(model.place(unit), rules::unit_repeated(short(name)));
        }
    }
    for t in &model.types {
        let (unit, display) = (t.typed.attribute("unit"), t.typed.attribute("displayUnit"));
        check_use(model, t.typed, &format!("Type {t}"), unit, display, &units, out);
        if unit.is_none() && is_true(t.typed, "relativeQuantity") {
            out.add(model.place(t.typed), rules::type_relative_without_unit(t));
        }
    }
    for v in &model.variables {
        let own = |name| v.typed.attribute(name);
        let unit = model.attribute(v, "unit");
        // What the variable takes from its type has been checked there.
        if own("unit").is_some() || own("displayUnit").is_some() {
            check_use(
                model,
                v.typed,
                &format!("Variable {v}"),
                unit,
                model.attribute(v, "displayUnit"),
                &units,
                out,
            );
        }
        if unit.is_none() && is_true(v.typed, "relativeQuantity") {
            out.add(model.place(v.typed), rules::relative_without_unit(v));
        }
        for alias in v.aliases.iter().filter(|a| a.attribute("displayUnit").is_some()) {
            let label = format!("Alias \"{}\"", short(alias.attribute("name").unwrap_or_default()));
            let known = unit.is_none_or(|u| units.contains_key(u));
            if known {
                check_use(model, *alias, &label, unit, alias.attribute("displayUnit"), &units, out);
            }
        }
    }
}

/// Units of variables with relativeQuantity alone, whose offset has no meaning.
fn only_of_differences<'a>(model: &Model<'a>) -> HashSet<&'a str> {
    let (mut relative, mut absolute) = (HashSet::new(), HashSet::new());
    for v in &model.variables {
        if let Some(unit) = model.attribute(v, "unit") {
            let is_relative = matches!(model.attribute(v, "relativeQuantity"), Some("true" | "1"));
            if is_relative {
                relative.insert(unit)
            } else {
                absolute.insert(unit)
            };
        }
    }
    relative.retain(|unit| !absolute.contains(unit));
    relative
}

/// Checks one `<Unit>` and returns the names of its display units.
fn check_definition<'a>(
    model: &Model,
    unit: Node<'a, 'a>,
    name: &str,
    is_of_differences: bool,
    out: &mut Findings,
) -> HashSet<&'a str> {
    // FMI 2.0.5, section 2.2.3: an empty string is a valid unit.
    if name.is_empty() && model.version == FmiVersion::V3 {
        out.add(model.place(unit), rules::unit_name_empty());
    }
    let base = children(unit, "BaseUnit").next().map(|base| {
        let what = format!("unit \"{}\"", short(name));
        check_factor(model, base, &what, out);
        check_meaning(model, base, name, is_of_differences, out);
        Declared::of(base)
    });
    // A name without base unit is that of a known unit, or says nothing.
    let base = base.or_else(|| Declared::named(name));
    let mut displays = HashSet::new();
    for display in children(unit, "DisplayUnit") {
        let Some(display_name) = display.attribute("name") else { continue };
        check_factor(model, display, &format!("display unit \"{}\"", short(display_name)), out);
        if let Some(base) = base.filter(|_| !is_true(display, "inverse")) {
            check_display(model, display, name, base, is_of_differences, out);
        }
        if is_true(display, "inverse") && double(display, "offset").is_some_and(|o| o != 0.0) {
            out.add(model.place(display), rules::display_unit_inverse(short(display_name)));
        }
        if !displays.insert(display_name) {
            out.add(model.place(display), rules::display_unit_repeated(short(display_name), short(name)));
        }
    }
    displays
}

fn check_factor(model: &Model, node: Node, what: &str, out: &mut Findings) {
    for name in ["factor", "offset"] {
        let is_wrong = |x: &f64| name == "factor" && *x == 0.0 || !x.is_finite();
        if let Some(x) = double(node, name).filter(is_wrong) {
            out.add(model.place(node), rules::unit_factor(name, what, x));
        }
    }
}

fn check_use(
    model: &Model,
    node: Node,
    label: &str,
    unit: Option<&str>,
    display: Option<&str>,
    units: &HashMap<&str, HashSet<&str>>,
    out: &mut Findings,
) {
    let place = model.place(node);
    match (unit, display) {
        (None, Some(display)) => out.add(place, rules::display_unit_alone(label, short(display))),
        (Some(unit), display) => match (units.get(unit), display) {
            (None, _) => out.add(place, rules::unit_undefined(label, short(unit))),
            (Some(known), Some(display)) if !known.contains(display) => {
                let (display, unit) = (short(display), short(unit));
                match model.version {
                    // FMI 2: "then displayUnit is ignored".
                    FmiVersion::V2 => out.add(place, rules::display_unit_ignored(label, display, unit)),
                    FmiVersion::V3 => out.add(place, rules::display_unit_undefined(label, display, unit)),
                }
            }
            _ => {}
        },
        (None, None) => {}
    }
}
