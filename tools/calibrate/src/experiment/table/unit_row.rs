//! A row of units below or above the header, as many loggers write it: `s;mA;degC`, `[s];[mA];[degC]`, `Y_Unit_Label;V;A`.

use super::source::Source;
use crate::experiment::columns::TIME;
use crate::experiment::stamp::{Notation, Stamp};
use crate::experiment::units::{self, FileUnit};
use delimited::{Row, StringRecord};
use physics::declare::Unit;

/// Greatest relative difference of two equal units. Numerical: rounding of products of factors.
const SAME: f64 = 1e-9;

/// Takes the units of the row below the header, if it is a row of units. The result is the rest of a note.
///
/// # Errors
/// One sentence if the row contradicts the experiment or has no unit of the quantity.
pub fn below(cells: &StringRecord, sources: &mut [&mut Source]) -> Result<Option<String>, String> {
    if is_unit_row(cells, sources) { take(cells, sources).map(Some) } else { Ok(None) }
}

/// Takes the units of the nearest line above the header that is a row of units. The result is its line and the rest of a note.
///
/// # Errors
/// The line and one sentence, as [`below`].
pub fn above(rows: &[Row], sources: &mut [&mut Source]) -> Result<Option<(u64, String)>, (u64, String)> {
    // A title, a name or a serial number may look like a unit: most of the cells have to be units of their columns.
    let is_row = |row: &&Row| {
        let channels = sources.iter().filter(|source| source.column != TIME);
        let named = || channels.clone().filter(|s| !bare(&row.cells[s.place]).is_empty());
        let fitting = named().filter(|s| units::by_name(s.si, bare(&row.cells[s.place])).is_some()).count();
        is_unit_row(&row.cells, sources)
            && 2 * named().count() >= channels.clone().count()
            && 2 * fitting > named().count()
    };
    let Some(row) = rows.iter().find(is_row) else { return Ok(None) };
    let note = take(&row.cells, sources).map_err(|message| (row.line, message))?;
    Ok(Some((row.line, note)))
}

/// Takes the units of a row. A stated unit must agree; a unit that is not stated is taken from the row, and is stated by it.
fn take(cells: &StringRecord, sources: &mut [&mut Source]) -> Result<String, String> {
    let mut taken = Vec::new();
    for source in sources {
        let name = bare(&cells[source.place]);
        let column = source.column;
        if name.is_empty() || column == TIME && is_label(name) {
            continue;
        }
        match units::by_name(source.si, name) {
            Some(unit) if same(unit, source.unit) => source.is_stated = true,
            Some(_) if source.is_stated => {
                return Err(format!(
                    "the row of units has {name} for {column}, but the experiment or the header states {}: correct the unit that is wrong",
                    source.unit_name
                ));
            }
            Some(unit) => {
                taken.push(format!("{column} in {name}"));
                (source.unit, source.unit_name, source.is_stated) = (unit, name.to_owned(), true);
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
    Ok(format!("is a row of units and is skipped{taken}"))
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

/// Whether a cell in the column of the time says what the row has: `Y_Unit_Label`, `Units:`, `Einheit`.
fn is_label(cell: &str) -> bool {
    let cell = cell.to_lowercase();
    ["unit", "einheit"].iter().any(|word| cell.contains(word))
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
