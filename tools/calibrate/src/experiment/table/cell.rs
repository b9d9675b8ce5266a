//! Cells of a file: times, numbers with and without their unit, blanks, and text in place of a reading.

use super::source::Source;
use super::unit_row::same;
use crate::experiment::stamp::{Notation, Stamp};
use crate::experiment::units;
use delimited::StringRecord;

/// What a cell of a channel is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A number in the unit of the column.
    Value(f64),
    /// Nothing.
    Blank,
    /// Text without digits, which an instrument writes for an open input or an overload: `OPEN`, `-OL`, `#N/A`.
    Word,
}

/// The time of a row; otherwise a one-sentence error.
pub fn time(
    text: &delimited::Table,
    cells: &StringRecord,
    source: &Source,
    notation: &Notation,
) -> Result<Stamp, String> {
    let (name, cell) = (source.column, &cells[source.place]);
    if cell.is_empty() {
        return Err(format!("{name} is blank; every row needs a time"));
    }
    let pointed = text.pointed(cell);
    match Stamp::of(&pointed, notation) {
        Some(Stamp::Number(number)) if !number.is_finite() => {
            Err(format!("{name} = {cell} is not a finite number"))
        }
        Some(stamp) => Ok(stamp),
        None => match with_unit(&pointed, cell, source)? {
            Some(number) => Ok(Stamp::Number(number)),
            None => Err(text.notation(cell).map_or_else(
                || {
                    format!(
                        "{name} = {cell} is not a number, nor a time as 2025-11-19T14:30:00, 19.11.2025 14:30:00 or 14:30:00"
                    )
                },
                |why| format!("{name} = {cell} {why}"),
            )),
        },
    }
}

/// The reading of a channel in a row; otherwise a one-sentence error.
pub fn reading(text: &delimited::Table, cells: &StringRecord, source: &Source) -> Result<Reading, String> {
    let (name, cell) = (source.column, &cells[source.place]);
    if cell.is_empty() {
        return Ok(Reading::Blank);
    }
    let pointed = text.pointed(cell);
    match pointed.parse::<f64>() {
        Ok(value) if value.is_finite() => return Ok(Reading::Value(value)),
        Ok(_) => {
            return Err(format!("{name} = {cell} is not a finite number; leave blank what was not measured"));
        }
        Err(_) => {}
    }
    if let Some(number) = with_unit(&pointed, cell, source)? {
        return Ok(Reading::Value(number));
    }
    if cell.starts_with('#') || !cell.contains(|c: char| c.is_ascii_digit()) {
        return Ok(Reading::Word);
    }
    Err(text.notation(cell).map_or_else(|| not_a_number(name, cell), |why| format!("{name} = {cell} {why}")))
}

/// The sentence on a cell that is not a number.
pub fn not_a_number(column: &str, cell: &str) -> String {
    format!("{column} = {cell} is not a number; leave blank what was not measured")
}

/// A number with the unit of its column behind it.
///
/// # Errors
/// Another unit of the quantity.
fn with_unit(pointed: &str, cell: &str, source: &Source) -> Result<Option<f64>, String> {
    let Some((number, name)) = ::units::split(pointed).filter(|(_, name)| !name.is_empty()) else {
        return Ok(None);
    };
    match units::by_name(source.si, name) {
        Some(unit) if same(unit, source.unit) => Ok(Some(number)),
        Some(_) => Err(format!(
            "{} = {cell} is in {name}, but the unit of the column is {}: write all its numbers in one unit, and state it in [columns]",
            source.column, source.unit_name
        )),
        None => Ok(None),
    }
}

/// Text in place of the readings of a channel.
#[derive(Clone, Debug, Default)]
pub struct Words {
    count: usize,
    first: Option<(u64, String)>,
}

impl Words {
    /// Adds the text of a line.
    pub fn add(&mut self, line: u64, text: &str) {
        self.count += 1;
        self.first.get_or_insert_with(|| (line, text.to_owned()));
    }

    /// The note, if there is text.
    ///
    /// # Errors
    /// The line and a sentence if the channel has text alone.
    pub fn note(&self, column: &str, is_empty: bool) -> Result<Option<String>, (u64, String)> {
        match &self.first {
            None => Ok(None),
            Some((line, text)) if is_empty => Err((*line, not_a_number(column, text))),
            Some((line, text)) => {
                let rows = if self.count == 1 { "row has" } else { "rows have" };
                Ok(Some(format!(
                    "{} {rows} text in place of {column}, the first {text} in line {line}; these readings are taken as blank",
                    self.count
                )))
            }
        }
    }
}
