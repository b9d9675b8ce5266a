//! Unit definitions, and the units and display units of variables and types.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut units: HashMap<&str, HashSet<&str>> = HashMap::new();
    for unit in children(model.root, "UnitDefinitions").flat_map(|list| children(list, "Unit")) {
        let Some(name) = unit.attribute("name") else { continue };
        let displays = check_definition(model, unit, name, out);
        if units.insert(name, displays).is_some() {
            let message = format!("The unit \"{}\" is defined more than once", short(name));
            out.add(&rules::UNIT_REPEATED, model.place(unit), message);
        }
    }
    for t in &model.types {
        let (unit, display) = (t.typed.attribute("unit"), t.typed.attribute("displayUnit"));
        check_use(model, t.typed, &format!("Type {t}"), unit, display, &units, out);
        if unit.is_none() && is_true(t.typed, "relativeQuantity") {
            let message = format!("Type {t} has relativeQuantity but no unit, so it has no meaning");
            out.add(&rules::RELATIVE_WITHOUT_UNIT, model.place(t.typed), message);
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
            let message = format!("Variable {v} has relativeQuantity but no unit, so it has no meaning");
            out.add(&rules::RELATIVE_WITHOUT_UNIT, model.place(v.typed), message);
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

/// Checks one `<Unit>` and returns the names of its display units.
fn check_definition<'a>(
    model: &Model,
    unit: Node<'a, 'a>,
    name: &str,
    out: &mut Findings,
) -> HashSet<&'a str> {
    // FMI 2.0.5, section 2.2.3: an empty string is a valid unit.
    if name.is_empty() && model.version == FmiVersion::V3 {
        out.add(&rules::UNIT_NAME_EMPTY, model.place(unit), "A unit has an empty name");
    }
    for base in children(unit, "BaseUnit") {
        check_factor(model, base, &format!("unit \"{}\"", short(name)), out);
    }
    let mut displays = HashSet::new();
    for display in children(unit, "DisplayUnit") {
        let Some(display_name) = display.attribute("name") else { continue };
        check_factor(model, display, &format!("display unit \"{}\"", short(display_name)), out);
        if is_true(display, "inverse") && double(display, "offset").is_some_and(|o| o != 0.0) {
            let message = format!(
                "The display unit \"{}\" is inverse and has an offset; inverse is only allowed without",
                short(display_name)
            );
            out.add(&rules::DISPLAY_UNIT_INVERSE, model.place(display), message);
        }
        if !displays.insert(display_name) {
            let message = format!(
                "The display unit \"{}\" is defined more than once for the unit \"{}\"",
                short(display_name),
                short(name)
            );
            out.add(&rules::DISPLAY_UNIT_REPEATED, model.place(display), message);
        }
    }
    displays
}

fn check_factor(model: &Model, node: Node, what: &str, out: &mut Findings) {
    for name in ["factor", "offset"] {
        let is_wrong = |x: &f64| name == "factor" && *x == 0.0 || !x.is_finite();
        if let Some(x) = double(node, name).filter(is_wrong) {
            let message = format!("The {name} of the {what} is {x}; no value can be converted with it");
            out.add(&rules::UNIT_FACTOR, model.place(node), message);
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
        (None, Some(display)) => {
            let message = format!("{label} has the display unit \"{}\" but no unit", short(display));
            out.add(&rules::DISPLAY_UNIT_ALONE, place, message);
        }
        (Some(unit), display) => match (units.get(unit), display) {
            (None, _) => {
                let message = format!(
                    "{label} has the unit \"{}\", which is not defined in <UnitDefinitions>",
                    short(unit)
                );
                out.add(&rules::UNIT_UNDEFINED, place, message);
            }
            (Some(known), Some(display)) if !known.contains(display) => {
                let message = format!(
                    "{label} has the display unit \"{}\", which is not defined for the unit \"{}\"",
                    short(display),
                    short(unit)
                );
                match model.version {
                    // FMI 2: "then displayUnit is ignored".
                    FmiVersion::V2 => {
                        out.add(&rules::DISPLAY_UNIT_IGNORED, place, message + " and is therefore ignored")
                    }
                    FmiVersion::V3 => out.add(&rules::DISPLAY_UNIT_UNDEFINED, place, message),
                }
            }
            _ => {}
        },
        (None, None) => {}
    }
}
