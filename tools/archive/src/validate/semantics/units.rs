//! Unit definitions, and the units and display units of variables and types.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut units: HashMap<&str, HashSet<&str>> = HashMap::new();
    for unit in children(model.root, "UnitDefinitions").flat_map(|list| children(list, "Unit")) {
        let Some(name) = unit.attribute("name") else { continue };
        let displays = check_definition(model, unit, name, out);
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

/// Checks one `<Unit>` and returns the names of its display units.
fn check_definition<'a>(
    model: &Model,
    unit: Node<'a, 'a>,
    name: &str,
    out: &mut Findings,
) -> HashSet<&'a str> {
    // FMI 2.0.5, section 2.2.3: an empty string is a valid unit.
    if name.is_empty() && model.version == FmiVersion::V3 {
        out.add(model.place(unit), rules::unit_name_empty());
    }
    let base = children(unit, "BaseUnit").next().map(|base| {
        let what = format!("unit \"{}\"", short(name));
        check_factor(model, base, &what, out);
        let meaning = Meaning::of(base);
        if let Some(known) = Meaning::known(name).filter(|known| known.dimension == meaning.dimension) {
            contradiction(model, base, &format!("The {what}"), meaning.linear, known.linear, out);
        }
        meaning
    });
    let mut displays = HashSet::new();
    for display in children(unit, "DisplayUnit") {
        let Some(display_name) = display.attribute("name") else { continue };
        check_factor(model, display, &format!("display unit \"{}\"", short(display_name)), out);
        let known = Meaning::known(display_name);
        if let Some((base, known)) = base.zip(known).filter(|(base, known)| base.dimension == known.dimension)
            && !is_true(display, "inverse")
        {
            // unit -> SI -> display unit, each value = (SI value - offset) / factor
            let ((factor, offset), (known_factor, known_offset)) = (base.linear, known.linear);
            let wanted = (factor / known_factor, (offset - known_offset) / known_factor);
            let written =
                (double(display, "factor").unwrap_or(1.0), double(display, "offset").unwrap_or(0.0));
            let what = format!("The display unit \"{}\" of \"{}\"", short(display_name), short(name));
            contradiction(model, display, &what, written, wanted, out);
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

/// Exponents of kg, m, s, A, K, mol, cd, rad; then factor and offset: SI value = factor * value + offset.
#[derive(Clone, Copy)]
struct Meaning {
    dimension: [i128; 8],
    linear: (f64, f64),
}

/// Units whose name has one meaning, with dimension, factor and offset. The degree Celsius is that of temperatures: FMI marks
/// differences by relativeQuantity.
const KNOWN: [(&[&str], [i128; 8], f64, f64); 7] = [
    (&["K"], [0, 0, 0, 0, 1, 0, 0, 0], 1.0, 0.0),
    (&["degC", "°C"], [0, 0, 0, 0, 1, 0, 0, 0], 1.0, 273.15),
    (&["degF", "°F"], [0, 0, 0, 0, 1, 0, 0, 0], 5.0 / 9.0, 459.67 * 5.0 / 9.0),
    (&["rad"], [0, 0, 0, 0, 0, 0, 0, 1], 1.0, 0.0),
    (&["deg", "°"], [0, 0, 0, 0, 0, 0, 0, 1], std::f64::consts::PI / 180.0, 0.0),
    (&["Pa"], [1, -1, -2, 0, 0, 0, 0, 0], 1.0, 0.0),
    (&["bar"], [1, -1, -2, 0, 0, 0, 0, 0], 1e5, 0.0),
];

impl Meaning {
    fn of(base: Node) -> Self {
        let exponent = |name: &str| base.attribute(name).and_then(parse_integer).unwrap_or(0);
        let number = |name, default| double(base, name).unwrap_or(default);
        let dimension = cosim::BaseUnit::NAMES.map(exponent);
        Self { dimension, linear: (number("factor", 1.0), number("offset", 0.0)) }
    }

    fn known(name: &str) -> Option<Self> {
        let (_, dimension, factor, offset) = KNOWN.iter().find(|(names, ..)| names.contains(&name))?;
        Some(Self { dimension: *dimension, linear: (*factor, *offset) })
    }
}

/// Factor and offset as written must be those of the name; the offset of a temperature may be rounded.
fn contradiction(
    model: &Model,
    node: Node,
    what: &str,
    (factor, offset): (f64, f64),
    (wanted_factor, wanted_offset): (f64, f64),
    out: &mut Findings,
) {
    let close = |a: f64, b: f64, least: f64| (a - b).abs() <= 1e-3 * b.abs().max(least);
    // What is no number has been reported.
    let is_number = factor != 0.0 && factor.is_finite() && offset.is_finite();
    if is_number && !(close(factor, wanted_factor, 0.0) && close(offset, wanted_offset, 1.0)) {
        let breach = rules::unit_contradiction(what, factor, offset, wanted_factor, wanted_offset);
        out.add(model.place(node), breach);
    }
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
