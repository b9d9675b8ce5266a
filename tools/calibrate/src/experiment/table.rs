//! One CSV file of a run: validated, converted to SI units, blanks as missing readings.

mod cell;
mod order;
mod source;
mod unit_row;

use super::channel::Channel;
use super::columns::Column;
use super::stamp::{DAY, Notation, Stamp};
use crate::CalibrateError;
use cell::{Reading, Words};
use delimited::{Row, StringRecord};
use order::Instant;
use std::path::Path;

/// Contents of a file, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Time of each row, s, ascending.
    pub time: Vec<f64>,
    /// One column for each requested channel; NaN for a missing reading.
    pub columns: Vec<Vec<f64>>,
    /// Number of rows of the file; the intake adds rows at steps of the loads.
    pub logged: usize,
    /// Whether the times are dates: seconds since 1970-01-01.
    pub dated: bool,
    /// Warnings, in sentences.
    pub notes: Vec<String>,
}

/// A pause longer than this many times the usual sampling interval is noted as a gap. Definition: of a gap; the simulation continues
/// across it.
const GAP: f64 = 5.0;
/// Intervals before and after a gap from which the usual one is taken. Numerical: the median of ten is that of the logger's setting.
const NEARBY: usize = 10;
/// Number of gaps from which a note counts them. Numerical: a reader sees three at a glance.
const FEW_GAPS: usize = 4;

/// Largest number of rows of a run in figures. Definition: of the figures and of `residuals.csv`.
const DRAWN: usize = 600;

impl Table {
    /// Time from the first to the last row, s; 0 without rows.
    pub fn span(&self) -> f64 {
        self.time.last().zip(self.time.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// The rows that figures show.
    pub fn drawn(&self) -> Vec<usize> {
        (0..self.time.len()).step_by(self.time.len().div_ceil(DRAWN)).collect()
    }

    /// Reads the requested channels from a file. `wanted` has the order of [`Table::columns`], its first `inputs` are inputs; `mapped` are
    /// the headers of `[columns]`, `blank` the columns that are not in the file.
    ///
    /// # Errors
    /// One sentence with file and line: file not found, column missing, invalid number, or time that does not increase.
    pub fn read(
        path: &Path,
        wanted: &[&'static Channel],
        inputs: usize,
        mapped: &[Column],
        blank: &[&str],
    ) -> Result<Table, CalibrateError> {
        let file = path.display();
        let bytes = std::fs::read(path).map_err(|e| CalibrateError(format!("{file} cannot be read: {e}")))?;
        Table::parse(&bytes, &file.to_string(), wanted, inputs, mapped, blank)
    }

    /// Parses the bytes of a file; `file` is its name in error messages.
    pub fn parse(
        bytes: &[u8],
        file: &str,
        wanted: &[&'static Channel],
        inputs: usize,
        mapped: &[Column],
        blank: &[&str],
    ) -> Result<Table, CalibrateError> {
        let at = |line: u64, message: String| CalibrateError(format!("{file}:{line}: {message}"));
        let text = delimited::Table::with_names(bytes, &source::names(wanted, mapped, blank))
            .map_err(|f| at(f.line, f.message))?;
        let line = text.header_line();
        let mut time_source = source::time(text.header(), mapped).map_err(|message| at(line, message))?;
        let mut sources =
            source::channels(text.header(), wanted, mapped, blank).map_err(|message| at(line, message))?;
        if let Some(fault) = sources.iter().flatten().find_map(|s| text.grouped(s.place)) {
            return Err(at(fault.line, fault.message));
        }
        let mut table = Table {
            time: Vec::new(),
            columns: vec![Vec::new(); wanted.len()],
            logged: 0,
            dated: false,
            notes: text.remarks().iter().map(|remark| format!("{file}: {}", remark.message)).collect(),
        };
        match text.repeated() {
            [] => {}
            [line] => table.notes.push(format!("{file}: line {line} repeats the header and is skipped")),
            [first, .., last] => {
                let count = text.repeated().len();
                table.notes.push(format!(
                    "{file}: {count} lines from {first} to {last} repeat the header and are skipped"
                ));
            }
        }
        let mut all: Vec<_> = std::iter::once(&mut time_source).chain(sources.iter_mut().flatten()).collect();
        let above = unit_row::above(&text.above(), &mut all).map_err(|(line, message)| at(line, message))?;
        table.notes.extend(above.map(|(line, note)| format!("{file}: line {line} {note}")));
        let units = match text.rows().next() {
            Some(Ok(Row { line, cells })) => {
                let note = unit_row::below(&cells, &mut all).map_err(|message| at(line, message))?;
                table.notes.extend(note.iter().map(|note| format!("{file}: line {line} {note}")));
                note.map(|_| cells)
            }
            _ => None,
        };
        let is_units = |cells: &StringRecord| units.as_ref() == Some(cells);
        let stamps = text.rows().flatten().filter(|row| !is_units(&row.cells));
        let notation = Notation::of(stamps.map(|row| (row.line, row.cells[time_source.place].to_owned())))
            .map_err(|(line, message)| at(line, message))?;
        table.notes.extend(notation.notes().iter().map(|note| format!("{file}: {note}")));
        let mut words: Vec<Words> = vec![Words::default(); wanted.len()];
        let (mut repeated, mut midnights, mut before) = (0, 0.0, None);
        let mut last: Option<Instant> = None;
        for row in text.rows() {
            let Row { line, cells } = row.map_err(|f| at(f.line, f.message))?;
            if is_units(&cells) {
                continue;
            }
            if before.as_ref() == Some(&cells) {
                repeated += 1;
                continue;
            }
            let stamp = cell::time(&text, &cells, &time_source, &notation).map_err(|m| at(line, m))?;
            let mut time = match stamp {
                Stamp::Number(number) => time_source.value(number),
                Stamp::Date(seconds) => seconds,
                Stamp::Clock(seconds) => seconds + midnights,
            };
            table.dated |= matches!(stamp, Stamp::Date(_));
            if let Some(last) = last.as_ref().filter(|last| time <= last.time) {
                // A clock without dates that wraps at midnight.
                if matches!(stamp, Stamp::Clock(_)) && !table.dated && last.time - time > 0.5 * DAY {
                    midnights += DAY;
                    time += DAY;
                } else {
                    let now = Instant::new(time, stamp, &cells[time_source.place], line);
                    let interval = table.last_interval();
                    return Err(at(
                        line,
                        order::sentence(&now, last, interval, text.repeated(), &time_source.unit_name),
                    ));
                }
            }
            table.time.push(time);
            last = Some(Instant::new(time, stamp, &cells[time_source.place], line));
            for (k, source) in sources.iter().enumerate() {
                let Some(source) = source else {
                    table.columns[k].push(f64::NAN);
                    continue;
                };
                let reading = cell::reading(&text, &cells, source).map_err(|m| at(line, m))?;
                table.columns[k].push(match reading {
                    Reading::Value(value) => source.value(value),
                    Reading::Blank => f64::NAN,
                    Reading::Word if k < inputs => {
                        return Err(at(line, cell::not_a_number(source.column, &cells[source.place])));
                    }
                    Reading::Word => {
                        words[k].add(line, &cells[source.place]);
                        f64::NAN
                    }
                });
            }
            before = Some(cells);
        }
        if table.time.len() < 2 {
            return Err(CalibrateError(format!(
                "{file}: {} rows are no run; two are the least",
                table.time.len()
            )));
        }
        table.logged = table.time.len() + repeated;
        for ((words, channel), column) in words.iter().zip(wanted).zip(&table.columns) {
            let is_empty = column.iter().all(|value| value.is_nan());
            let note = words.note(channel.column, is_empty).map_err(|(line, message)| at(line, message))?;
            table.notes.extend(note.map(|note| format!("{file}: {note}")));
        }
        if repeated > 0 {
            table.notes.push(format!("{file}: {repeated} rows repeat the row before them and are set aside"));
        }
        table.note_gaps(file);
        Ok(table)
    }

    /// Interval between the last two rows, s; 0 if there are not two.
    fn last_interval(&self) -> f64 {
        self.time.last_chunk().map_or(0.0, |[before, last]| last - before)
    }

    /// The rows that are followed by a gap: an interval far above the usual one of the rows before it and of those after it. A logger may
    /// change its interval.
    pub fn gaps(&self) -> impl Iterator<Item = usize> {
        let steps: Vec<f64> = self.time.windows(2).map(|w| w[1] - w[0]).collect();
        let usual = |near: &[f64]| {
            let mut sorted = near.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
        };
        (0..steps.len()).filter(move |row| {
            let before = usual(&steps[row.saturating_sub(NEARBY)..*row]);
            let after = usual(&steps[row + 1..steps.len().min(row + 1 + NEARBY)]);
            let usual = before.max(after);
            usual > 0.0 && steps[*row] > GAP * usual
        })
    }

    /// Gaps are reported in a note; the simulation continues across them.
    fn note_gaps(&mut self, file: &str) {
        let ends: Vec<(f64, f64)> = self.gaps().map(|row| (self.time[row], self.time[row + 1])).collect();
        let longest = ends.iter().copied().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
        match (longest, ends.len()) {
            (Some((from, to)), FEW_GAPS..) => self.notes.push(format!(
                "{file}: {} gaps without rows, the longest from {from} s to {to} s; simulated across",
                ends.len()
            )),
            _ => self.notes.extend(
                ends.iter()
                    .map(|(from, to)| format!("{file}: no rows from {from} s to {to} s; simulated across")),
            ),
        }
    }
}

#[cfg(test)]
mod tests;
