//! Names and value references are unique, and names follow the declared convention.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let structured = model.root.attribute("variableNamingConvention") == Some("structured");
    let mut names: HashMap<&str, String> = HashMap::new();
    let mut references = HashMap::new();
    for v in &model.variables {
        let alias_names = v.aliases.iter().filter_map(|a| Some((*a, a.attribute("name")?)));
        for (node, name) in v.node.attribute("name").map(|n| (v.node, n)).into_iter().chain(alias_names) {
            let place = model.place(node);
            if name.is_empty() {
                out.add(&rules::NAME_EMPTY, &place, "A variable has an empty name");
                continue;
            }
            if let Some(first) = names.get(name) {
                let message = format!("The variable name \"{}\" is already used at {first}", short(name));
                out.add(&rules::NAME_REPEATED, &place, message);
            } else {
                names.insert(name, place.clone());
            }
            if structured && !is_structured(name) {
                let message = format!(
                    "The variable name \"{}\" does not follow the naming convention structured",
                    short(name)
                );
                out.add(&rules::NAME_SYNTAX, &place, message);
            } else if name.contains(['\r', '\n', '\t']) {
                let message = format!("The variable name \"{}\" contains a line break or a tab", short(name));
                out.add(&rules::NAME_CONTROL, &place, message);
            }
        }
        if model.version == FmiVersion::V3 {
            let Some(reference) = v.reference else { continue };
            if let Some(other) = references.insert(reference, v.name) {
                let message = format!(
                    "Variable {v} has the value reference {reference} of variable \"{}\"; value references must be unique",
                    short(other)
                );
                out.add(&rules::REFERENCE_REPEATED, model.place(v.node), message);
            }
        }
    }
    for t in &model.types {
        if let Some(first) = names.get(t.name) {
            let message = format!("The type {t} has the same name as the variable at {first}");
            out.add(&rules::TYPE_NAME_CLASH, model.place(t.node), message);
        }
    }
}

/// The grammar of FMI 2.0 section 2.2.9 and FMI 3.0 section 2.4.7.5.1.
pub(super) fn is_structured(name: &str) -> bool {
    let b = name.as_bytes();
    if let Some(inner) = name.strip_prefix("der(") {
        let b = inner.as_bytes();
        return identifier(b, 0).is_some_and(|at| {
            let at = match b.get(at) {
                Some(b',') => number(b, at + 1),
                _ => Some(at),
            };
            at.is_some_and(|at| b.get(at) == Some(&b')') && at + 1 == b.len())
        });
    }
    identifier(b, 0) == Some(b.len())
}

fn identifier(b: &[u8], mut at: usize) -> Option<usize> {
    loop {
        at = base_name(b, at)?;
        if b.get(at) == Some(&b'[') {
            loop {
                at = number(b, at + 1)?;
                match b.get(at)? {
                    b',' => {}
                    b']' => break,
                    _ => return None,
                }
            }
            at += 1;
        }
        match b.get(at) {
            Some(b'.') => at += 1,
            _ => return Some(at),
        }
    }
}

fn base_name(b: &[u8], start: usize) -> Option<usize> {
    let word = |c: u8| c.is_ascii_alphanumeric() || c == b'_';
    let mut at = start;
    match *b.get(at)? {
        b'\'' => {
            at += 1;
            loop {
                match *b.get(at)? {
                    b'\'' if at > start + 1 => return Some(at + 1),
                    b'\\' if b"'\"?\\abfnrtv".contains(b.get(at + 1)?) => at += 2,
                    c if word(c) || b"!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(&c) => at += 1,
                    _ => return None,
                }
            }
        }
        c if word(c) && !c.is_ascii_digit() => {
            while b.get(at).is_some_and(|c| word(*c)) {
                at += 1;
            }
            Some(at)
        }
        _ => None,
    }
}

fn number(b: &[u8], start: usize) -> Option<usize> {
    let mut at = start;
    while b.get(at).is_some_and(u8::is_ascii_digit) {
        at += 1;
    }
    (at > start).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::is_structured;

    #[test]
    fn the_standards_own_examples_are_structured() {
        for good in [
            "vehicle.engine.speed",
            "resistor12.u",
            "v_min",
            "robot.axis.'motor #234'",
            "der(pipe[3,4].T[14],2)",
            "der(x)",
            "'it\\'s'",
            "_a",
            "derx",
        ] {
            assert!(is_structured(good), "{good}");
        }
        for bad in [
            "",
            "1a",
            "a.",
            ".a",
            "a b",
            "a[]",
            "a[1",
            "a[x]",
            "der(x",
            "der()",
            "der(x,)",
            "''",
            "'a",
            "ä",
            "a-b",
            "der(x)y",
            "der(x, 2)",
        ] {
            assert!(!is_structured(bad), "{bad}");
        }
    }
}
