//! docs/glossary.md has every quantity of the interface, with its unit, and no other name.

use describe::{Entry, models};
use physics::declare::Kind;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Unit cell of enumerations, Booleans, whole numbers and texts.
const NO_UNIT: &str = "-";
/// Heading of the column with names; a column that starts so and ends with `(prefix)` lists prefixes of names.
const NAMES: &str = "FMI name";

#[derive(Default)]
struct Glossary {
    units: HashMap<String, String>,
    /// Beginnings of names, up to a dot.
    prefixes: HashSet<String>,
}

impl Glossary {
    fn read() -> Self {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/glossary.md");
        Self::parse(&std::fs::read_to_string(page).unwrap())
    }

    fn parse(text: &str) -> Self {
        let mut glossary = Self::default();
        let (mut names, mut unit, mut prefixes) = (None, None, false);
        for line in text.lines() {
            let cells = cells(line);
            if cells.is_empty() {
                names = None;
            } else if let Some(column) = cells.iter().position(|c| c.starts_with(NAMES)) {
                names = Some(column);
                unit = cells.iter().position(|c| c == "unit");
                prefixes = cells[column].ends_with("(prefix)");
            } else if let Some(column) = names {
                for name in cells.get(column).map(|c| c.split('`').skip(1).step_by(2)).into_iter().flatten() {
                    let new = if prefixes {
                        glossary.prefixes.insert(name.into())
                    } else {
                        let unit = unit.and_then(|u| cells.get(u)).expect("a table of names has units");
                        glossary.units.insert(name.into(), unit.clone()).is_none()
                    };
                    assert!(new, "docs/glossary.md lists `{name}` twice");
                }
            }
        }
        glossary
    }

    /// The name under which the glossary has a variable.
    fn key(&self, entry: &Entry) -> Option<String> {
        let name = entry.name.split('[').next().unwrap_or_default();
        let name = name.strip_prefix("der(").map_or(name, |n| n.trim_end_matches(')'));
        let plain = name.strip_prefix("state.").unwrap_or(name);
        let listed = [name, plain].into_iter().find(|n| self.units.contains_key(*n));
        let prefix = || name.rsplit_once('.').map(|(p, _)| p).filter(|p| self.prefixes.contains(*p));
        listed.or_else(prefix).map(String::from)
    }
}

/// Cells of a row of a Markdown table; `\|` is a bar inside a cell.
fn cells(line: &str) -> Vec<String> {
    let line = line.trim().replace("\\|", "\u{2223}");
    match line.strip_prefix('|').and_then(|l| l.strip_suffix('|')) {
        Some(inner) => inner.split('|').map(|c| c.trim().to_string()).collect(),
        None => Vec::new(),
    }
}

/// Rates (`der(...)`) and event indicators follow from what is listed; they are no quantities of their own.
fn is_derived(entry: &Entry) -> bool {
    entry.name.starts_with("der(") || entry.name.starts_with("event.")
}

#[test]
fn every_quantity_of_the_interface_is_in_the_glossary_with_its_unit() {
    let glossary = Glossary::read();
    let (mut wrong, mut used) = (Vec::new(), HashSet::new());
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        for entry in declaration.entries.iter().filter(|e| !is_derived(e)) {
            let place = format!("{} of {}", entry.name, declaration.name);
            let Some(key) = glossary.key(entry) else {
                wrong.push(format!("{place} is missing"));
                continue;
            };
            let unit = if entry.row.kind == Kind::Real { entry.row.unit.name() } else { NO_UNIT };
            if let Some(shown) = glossary.units.get(&key).filter(|shown| *shown != unit) {
                wrong.push(format!("{place} has the unit {unit:?}, the glossary {shown:?}"));
            }
            used.insert(key);
        }
    }
    let listed = glossary.units.keys().chain(&glossary.prefixes);
    wrong.extend(listed.filter(|n| !used.contains(*n)).map(|n| format!("no model has `{n}`")));
    wrong.sort();
    wrong.dedup();
    assert!(wrong.is_empty(), "docs/glossary.md:\n{}", wrong.join("\n"));
}

#[test]
fn a_table_of_the_glossary_is_read_with_units_and_prefixes() {
    let text = "| unit | FMI name |\n|---|---|\n| K | `a`, `b.c` |\n\n| law \\| 1 | FMI name (prefix) |\n|---|---|\n| x | `effect.x` |\n";
    let glossary = Glossary::parse(text);
    assert_eq!(glossary.units.len(), 2);
    assert_eq!(glossary.units["b.c"], "K");
    assert!(glossary.prefixes.contains("effect.x"));
}
