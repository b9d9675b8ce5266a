//! A row of units below the header, as many loggers write it: `s;mA;degC`, `[s];[mA];[degC]`.

use super::source::Source;
use crate::experiment::stamp::{Notation, Stamp};
use crate::experiment::units::{self, FileUnit};
use delimited::StringRecord;
use physics::declare::Unit;

/// Greatest relative difference of two equal units. Numerical: rounding of products of factors.
const SAME: f64 = 1e-9;

/// Takes the units of the row below the header, if it is a row of units. A stated unit must agree; a unit that is not stated is taken
/// from the row. The result is the rest of a note.
///
/// # Errors
/// One sentence if the row contradicts the experiment or has no unit of the quantity.
pub fn read(cells: &StringRecord, sources: Vec<&mut Source>) -> Result<Option<String>, String> {
    if !is_unit_row(cells, &sources) {
        return Ok(None);
    }
    let mut taken = Vec::new();
    for source in sources {
        let name = bare(&cells[source.place]);
        let column = source.column;
        if name.is_empty() {
            continue;
        }
        match units::by_name(source.si, name) {
            Some(unit) if same(unit, source.unit) => {}
            Some(_) if source.is_stated => {
                return Err(format!(
                    "the row of units has {name} for {column}, but the experiment or the header states {}: correct the unit that is wrong",
                    source.unit_name
                ));
            }
            Some(unit) => {
                taken.push(format!("{column} in {name}"));
                (source.unit, source.unit_name) = (unit, name.to_owned());
            }
            // An unknown spelling of a unit that is stated.
            None if source.is_stated && !units::is_unit(source.si, name) => {}
            None => {
                let known = units::names(source.si).join(", ");
                return Err(format!(
                    "the row of units has {name} for {column}, which is no unit of it; there is {known}, stated in [columns]"
                ));
            }
        }
    }
    let taken = if taken.is_empty() { String::new() } else { format!("; it gives {}", taken.join(", ")) };
    Ok(Some(format!("is a row of units and is skipped{taken}")))
}

/// Whether two units convert in the same way.
pub fn same(a: FileUnit, b: FileUnit) -> bool {
    (a.factor / b.factor - 1.0).abs() < SAME && (a.offset - b.offset).abs() < SAME * a.offset.abs().max(1.0)
}

/// Whether no cell is a number or a time, and one is a unit.
fn is_unit_row(cells: &StringRecord, sources: &[&mut Source]) -> bool {
    let is_value = |source: &Source| {
        let (cell, name) = (&cells[source.place], bare(&cells[source.place]));
        let is_one = source.si == Unit::One && name == "1";
        !is_one && Stamp::of(&cell.replace(',', "."), &Notation::default()).is_some()
    };
    let is_unit = |source: &Source| {
        let name = bare(&cells[source.place]);
        !name.is_empty() && units::is_unit(source.si, name)
    };
    !sources.iter().any(|source| is_value(source)) && sources.iter().any(|source| is_unit(source))
}

/// A unit without brackets; nothing for a dash.
fn bare(cell: &str) -> &str {
    let cell = cell.trim();
    let inner = [('[', ']'), ('(', ')'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| cell.strip_prefix(open)?.strip_suffix(close));
    match inner.unwrap_or(cell).trim() {
        "-" | "--" | "\u{2013}" | "\u{2014}" => "",
        name => name,
    }
}
