//! Type definitions, and the declared types of variables.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut seen = HashSet::new();
    for t in &model.types {
        if t.name.is_empty() {
            out.add(&rules::TYPE_NAME_EMPTY, model.place(t.node), "A type definition has an empty name");
        }
        if !seen.insert(t.name) {
            let message = format!("The type {t} is defined more than once");
            out.add(&rules::TYPE_REPEATED, model.place(t.node), message);
        }
        let (mut names, mut values) = (HashSet::new(), HashSet::new());
        for item in children(t.typed, "Item") {
            let place = model.place(item);
            if let Some(name) = item.attribute("name").filter(|n| !names.insert(*n)) {
                let message =
                    format!("The item \"{}\" occurs more than once in the enumeration {t}", short(name));
                out.add(&rules::ITEM_REPEATED, &place, message);
            }
            if let Some(value) =
                item.attribute("value").and_then(parse_integer).filter(|v| !values.insert(*v))
            {
                let message = format!("The value {value} occurs more than once in the enumeration {t}");
                out.add(&rules::ITEM_REPEATED, &place, message);
            }
        }
    }
    for v in &model.variables {
        let Some(declared) = v.declared_type else { continue };
        match model.type_of(v) {
            None => {
                let message = format!(
                    "Variable {v} has the declared type \"{}\", which is not defined in <TypeDefinitions>",
                    short(declared)
                );
                out.add(&rules::TYPE_UNDEFINED, model.place(v.typed), message);
            }
            Some(t) if t.type_name != v.type_name => {
                let message = format!(
                    "Variable {v} is of type {} and cannot have the declared type \"{}\", which defines {}",
                    v.type_name,
                    short(declared),
                    t.type_name
                );
                out.add(&rules::TYPE_MISMATCH, model.place(v.typed), message);
            }
            Some(_) => {}
        }
    }
}
