//! The list of a model's variables as Markdown.

use crate::preset::StartValues;
use crate::xml::variable_description;
use physics::declare::{Causality, Kind};
use physics::model::{Entry, ModelType, Slot};
use std::fmt::Write;

/// Headings of the columns of [`Section::rows`].
pub const COLUMNS: [&str; 6] = ["name", "unit", "start", "limits", "variability", "description"];

/// Variables of one causality, as cells of text.
#[derive(Clone, Debug)]
pub struct Section {
    /// Heading.
    pub title: &'static str,
    /// One row per variable.
    pub rows: Vec<[String; COLUMNS.len()]>,
}

/// A model's variables by causality.
pub fn sections(kind: &ModelType, starts: &StartValues) -> Vec<Section> {
    let roles =
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)];
    let declaration = (kind.declaration)();
    let entries = || declaration.entries.iter().filter(|e| starts.shows(declaration, e));
    let of = |title, which: &dyn Fn(&Entry) -> bool| {
        let rows = entries().filter(|e| which(e)).map(|e| row(e, starts)).collect();
        Section { title, rows }
    };
    let states = of("States", &|e| e.slot.group == Slot::STATES);
    roles.into_iter().map(|(title, role)| of(title, &|e| e.row.causality == role)).chain([states]).collect()
}

fn row(entry: &Entry, starts: &StartValues) -> [String; COLUMNS.len()] {
    let row = entry.row;
    let start = match row.kind {
        _ if !entry.is_settable() => String::new(),
        Kind::Enumeration(t) => {
            let item = t.items.iter().find(|i| f64::from(i.value) == starts.of(entry));
            item.map(|i| i.name.to_string()).unwrap_or_default()
        }
        _ => starts.of(entry).to_string(),
    };
    let limits = match row.kind {
        Kind::Enumeration(t) => {
            t.items.iter().map(|i| format!("{} = {}", i.value, i.name)).collect::<Vec<_>>().join(", ")
        }
        Kind::Boolean => "true, false".to_string(),
        Kind::Real | Kind::Integer if row.min.is_finite() => format!("{} ... {}", row.min, row.max),
        Kind::Real | Kind::Integer => String::new(),
    };
    let unit = if row.kind == Kind::Real { row.unit.name().to_string() } else { String::new() };
    let changes = format!("{:?}", row.variability).to_lowercase();
    let mut text = variable_description(entry);
    // A preset's value has the preset's source.
    if !row.source.is_empty() && starts.of(entry) == row.start {
        let _ = write!(text, ". Source: {}", row.source);
    }
    [entry.name.clone(), unit, start, limits, changes, text]
}

/// The text of parameters.md.
pub fn parameters(kind: &ModelType, starts: &StartValues) -> String {
    let declaration = (kind.declaration)();
    let mut text = format!("# {}\n\n{}.\n", declaration.name, declaration.description);
    for section in sections(kind, starts) {
        let _ = write!(
            text,
            "\n## {}\n\n| {} |\n|{}\n",
            section.title,
            COLUMNS.join(" | "),
            "---|".repeat(COLUMNS.len())
        );
        for [name, rest @ ..] in section.rows {
            let _ = writeln!(text, "| `{name}` | {} |", rest.join(" | "));
        }
    }
    text
}
