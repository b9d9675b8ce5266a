//! Names and value references are unique, and names follow the declared convention.

use super::*;
use regex::Regex;
use std::sync::LazyLock;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let structured = model.root.attribute("variableNamingConvention") == Some("structured");
    let mut names: HashMap<&str, String> = HashMap::new();
    let mut references = HashMap::new();
    for v in &model.variables {
        let alias_names = v.aliases.iter().filter_map(|a| Some((*a, a.attribute("name")?)));
        for (node, name) in v.node.attribute("name").map(|n| (v.node, n)).into_iter().chain(alias_names) {
            let place = model.place(node);
            if name.is_empty() {
                out.add(&place, rules::name_empty());
                continue;
            }
            if let Some(first) = names.get(name) {
                out.add(&place, rules::name_repeated(short(name), first));
            } else {
                names.insert(name, place.clone());
            }
            if structured && !is_structured(name) {
                out.add(&place, rules::name_syntax(short(name)));
            } else if name.contains(['\r', '\n', '\t']) {
                out.add(&place, rules::name_control(short(name)));
            }
        }
        if model.version == FmiVersion::V3 {
            let Some(reference) = v.reference else { continue };
            if let Some(other) = references.insert(reference, v.name) {
                out.add(model.place(v.node), rules::reference_repeated(v, reference, short(other)));
            }
        }
    }
    for t in &model.types {
        if let Some(first) = names.get(t.name) {
            out.add(model.place(t.node), rules::type_name_clash(t, first));
        }
    }
}

/// The grammar of FMI 2.0 section 2.2.9 and FMI 3.0 section 2.4.7.5.1.
static STRUCTURED: LazyLock<Regex> = LazyLock::new(|| {
    let quoted = r#"'(?:[A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['"?\\abfnrtv])+'"#;
    let element = format!(r"(?:[A-Za-z_][A-Za-z0-9_]*|{quoted})(?:\[[0-9]+(?:,[0-9]+)*\])?");
    let name = format!(r"{element}(?:\.{element})*");
    Regex::new(&format!(r"^(?:{name}|der\({name}(?:,[0-9]+)?\))$")).expect("the tests use it")
});

pub(in crate::validate) fn is_structured(name: &str) -> bool {
    STRUCTURED.is_match(name)
}
