//! The list of a model's variables for people.

use crate::preset::StartValues;
use crate::xml::description;
use physics::declare::{Causality, Kind};
use physics::model::ModelType;
use std::fmt::Write;

/// The text of parameters.md.
pub fn parameters(kind: &ModelType) -> String {
    let declaration = (kind.declaration)();
    let starts = StartValues::default();
    let mut text = format!("# {}\n\n{}.\n", declaration.name, declaration.description);
    let sections =
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)];
    for (title, causality) in sections {
        let _ = write!(text, "\n## {title}\n\n");
        text.push_str(
            "| name | unit | start | limits | changes | description |\n|---|---|---|---|---|---|\n",
        );
        for entry in declaration.entries.iter().filter(|e| e.row.causality == causality) {
            let row = entry.row;
            let start = match row.kind {
                _ if causality == Causality::Output => String::new(),
                Kind::Enumeration(t) => t
                    .items
                    .iter()
                    .find(|i| f64::from(i.value) == starts.of(entry))
                    .map(|i| i.name.to_string())
                    .unwrap_or_default(),
                _ => starts.of(entry).to_string(),
            };
            let limits = match row.kind {
                Kind::Enumeration(t) => t.items.iter().map(|i| i.name).collect::<Vec<_>>().join(", "),
                Kind::Boolean => "true, false".to_string(),
                Kind::Real if row.min.is_finite() => format!("{} ... {}", row.min, row.max),
                Kind::Real => String::new(),
            };
            let unit = if row.kind == Kind::Real { row.unit.name() } else { "" };
            let changes = format!("{:?}", row.variability).to_lowercase();
            let _ = writeln!(
                text,
                "| `{}` | {unit} | {start} | {limits} | {changes} | {} |",
                entry.name,
                description(row.doc)
            );
        }
    }
    text
}
