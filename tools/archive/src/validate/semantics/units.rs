//! Unit definitions, and the units and display units of variables and types.

use super::*;
use ::units::{Meaning, is_literal, meanings};

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
        check_meaning(model, base, name, out);
        Declared::of(base)
    });
    let mut displays = HashSet::new();
    for display in children(unit, "DisplayUnit") {
        let Some(display_name) = display.attribute("name") else { continue };
        check_factor(model, display, &format!("display unit \"{}\"", short(display_name)), out);
        if let Some(base) = base.filter(|_| !is_true(display, "inverse")) {
            check_display(model, display, name, base, out);
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

/// Unit -> SI -> display unit: each value is (SI value - offset) / factor.
fn check_display(model: &Model, display: Node, name: &str, base: Declared, out: &mut Findings) {
    let display_name = display.attribute("name").unwrap_or_default();
    let written = Declared {
        factor: double(display, "factor").unwrap_or(1.0),
        offset: double(display, "offset").unwrap_or(0.0),
        ..base
    };
    let wanted = |known: &Meaning, turns: f64| {
        (base.factor * turns / known.factor, (base.offset - known.offset) / known.factor)
    };
    let known = meanings(display_name);
    let alike: Vec<(&Meaning, i32)> =
        known.iter().filter_map(|m| Some((m, base.radians_above(m)?))).collect();
    let agrees = |(meaning, radians): &(&Meaning, i32)| {
        [1.0, std::f64::consts::TAU.powi(-radians)].iter().any(|turns| {
            let (factor, offset) = wanted(meaning, *turns);
            close(written.factor, factor, 0.0) && close(written.offset, offset, 1.0)
        })
    };
    if let Some((first, _)) = alike.first().filter(|_| !alike.iter().any(agrees)) {
        let what = format!("The display unit \"{}\" of \"{}\"", short(display_name), short(name));
        contradiction(model, display, &what, (written.factor, written.offset), wanted(first, 1.0), out);
    }
}

/// A base unit as it is declared: SI value = factor * value + offset.
#[derive(Clone, Copy)]
struct Declared {
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    exponents: [i128; 8],
    factor: f64,
    offset: f64,
}

/// Names that are also in use for something that is no unit of the crate `units`: the acidity, the degree Celsius, the acceleration of gravity,
/// the tonne, pressure, radius, voltage, diameter, height.
const OTHER_MEANINGS: [&str; 9] = ["pH", "C", "g", "T", "p", "r", "U", "d", "h"];

impl Declared {
    fn of(base: Node) -> Self {
        let exponent = |name: &str| base.attribute(name).and_then(parse_integer).unwrap_or(0);
        let number = |name, default| double(base, name).unwrap_or(default);
        let exponents = cosim::BaseUnit::NAMES.map(exponent);
        Declared { exponents, factor: number("factor", 1.0), offset: number("offset", 0.0) }
    }

    /// By how many the exponent of the radian is above that of a name, if all others are those of the name.
    fn radians_above(&self, meaning: &Meaning) -> Option<i32> {
        let [kg, m, s, a, k, rad] = meaning.exponents.map(i128::from);
        let without_angle = [kg, m, s, a, k, 0, 0];
        (self.exponents[..7] == without_angle).then(|| i32::try_from(self.exponents[7] - rad).ok()).flatten()
    }

    /// Whether this is what the name means. The radian may be left out; then a turn may count as 1 or as 2 pi.
    fn is(&self, meaning: &Meaning, radians: i32) -> bool {
        let turns = std::f64::consts::TAU.powi(radians);
        // A number without dimension need not be converted.
        let plain = self.exponents == [0; 8] && self.factor == 1.0;
        let factors = [meaning.factor, meaning.factor * turns];
        (plain || factors.iter().any(|factor| close(self.factor, *factor, 0.0)))
            && close(self.offset, meaning.offset, 1.0)
    }
}

/// Rounded numbers are equal; the offset of a temperature to 1 mK.
fn close(a: f64, b: f64, least: f64) -> bool {
    (a - b).abs() <= 1e-3 * b.abs().max(least)
}

/// Exponents, factor and offset of a unit are those of its name, if the name is a known one.
fn check_meaning(model: &Model, base: Node, name: &str, out: &mut Findings) {
    let declared = Declared::of(base);
    let known = meanings(name);
    let alike: Vec<(Meaning, i32)> =
        known.iter().filter_map(|m| Some((*m, declared.radians_above(m)?))).collect();
    if let Some((wanted, _)) = alike.first() {
        if !alike.iter().any(|(meaning, radians)| declared.is(meaning, *radians)) {
            let what = format!("The unit \"{}\"", short(name));
            let written = (declared.factor, declared.offset);
            contradiction(model, base, &what, written, (wanted.factor, wanted.offset), out);
        }
    } else if let Some(wanted) = known.first()
        && is_literal(name)
        && !OTHER_MEANINGS.contains(&name)
    {
        let [kg, m, s, a, k, rad] = wanted.exponents.map(i128::from);
        let (is, named) = (product(&declared.exponents), product(&[kg, m, s, a, k, 0, 0, rad]));
        out.add(model.place(base), rules::unit_exponents(short(name), is, named));
    }
}

/// `kg.m2.s-2`.
fn product(exponents: &[i128; 8]) -> String {
    let named = cosim::BaseUnit::NAMES.iter().zip(exponents).filter(|(_, exponent)| **exponent != 0);
    let all: Vec<String> = named
        .map(|(name, exponent)| if *exponent == 1 { (*name).to_owned() } else { format!("{name}{exponent}") })
        .collect();
    if all.is_empty() { "1".to_owned() } else { all.join(".") }
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
