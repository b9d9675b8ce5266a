//! Type definitions, and the declared types of variables.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let mut seen = HashSet::new();
    for t in &model.types {
        if t.name.is_empty() {
            out.add(model.place(t.node), rules::type_name_empty());
        }
        if !seen.insert(t.name) {
            out.add(model.place(t.node), rules::type_repeated(t));
        }
        let (mut names, mut values) = (HashSet::new(), HashSet::new());
        for item in children(t.typed, "Item") {
            let place = model.place(item);
            if let Some(name) = item.attribute("name").filter(|n| !names.insert(*n)) {
                out.add(&place, rules::item_name_repeated(short(name), t));
            }
            if let Some(value) =
                item.attribute("value").and_then(parse_integer).filter(|v| !values.insert(*v))
            {
                out.add(&place, rules::item_value_repeated(value, t));
            }
        }
    }
    for v in &model.variables {
        let Some(declared) = v.declared_type else { continue };
        match model.type_of(v) {
            None => out.add(model.place(v.typed), rules::type_undefined(v, short(declared))),
            Some(t) if t.type_name != v.type_name => {
                out.add(
                    model.place(v.typed),
                    rules::type_mismatch(v, v.type_name, short(declared), t.type_name),
                );
            }
            Some(_) => {}
        }
    }
}
