//! One CSV file of a run: validated, converted to SI units, blanks as missing readings.

use super::channel::{CHANNELS, Channel};
use super::columns::{Column, TIME, other_unit};
use super::stamp::{DAY, Stamp};
use super::units::FileUnit;
use crate::CalibrateError;
use delimited::Row;
use std::path::Path;

/// Contents of a file, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Time of each row, s, ascending.
    pub time: Vec<f64>,
    /// One column for each requested channel; NaN for a missing reading.
    pub columns: Vec<Vec<f64>>,
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

    /// Reads the requested channels from a file. `wanted` has the order of [`Table::columns`], `mapped` are the
    /// headers of `[columns]`, `blank` the columns that are not in the file.
    ///
    /// # Errors
    /// One sentence with file and line: file not found, column missing, invalid number, or time that does not increase.
    pub fn read(
        path: &Path,
        wanted: &[&'static Channel],
        mapped: &[Column],
        blank: &[&str],
    ) -> Result<Table, CalibrateError> {
        let file = path.display();
        let bytes = std::fs::read(path).map_err(|e| CalibrateError(format!("{file} cannot be read: {e}")))?;
        Table::parse(&bytes, &file.to_string(), wanted, mapped, blank)
    }

    /// Parses the bytes of a file; `file` is its name in error messages.
    pub fn parse(
        bytes: &[u8],
        file: &str,
        wanted: &[&'static Channel],
        mapped: &[Column],
        blank: &[&str],
    ) -> Result<Table, CalibrateError> {
        let at = |line: u64, message: String| CalibrateError(format!("{file}:{line}: {message}"));
        let text = delimited::Table::parse(bytes).map_err(|f| at(f.line, f.message))?;
        let (header, line) = (text.header(), text.header_line());
        let place = |column: &str| source(header, column, mapped).map_err(|message| at(line, message));
        let (time_at, time_unit) = place(TIME)?;
        let places = wanted.iter().map(|c| {
            let found = place(c.column);
            match (blank.contains(&c.column), found) {
                (false, found) => found.map(Some),
                (true, Err(_)) => Ok(None),
                (true, Ok(_)) => {
                    Err(at(line, format!("not_measured names {}, and the file has this column", c.column)))
                }
            }
        });
        let places = places.collect::<Result<Vec<_>, _>>()?;
        if let Some(fault) = places.iter().flatten().find_map(|(k, _)| text.grouped(*k)) {
            return Err(at(fault.line, fault.message));
        }
        let mut table = Table {
            time: Vec::new(),
            columns: vec![Vec::new(); wanted.len()],
            dated: false,
            notes: Vec::new(),
        };
        let (mut repeated, mut midnights, mut before) = (0, 0.0, None);
        for row in text.rows() {
            let Row { line, cells } = row.map_err(|f| at(f.line, f.message))?;
            let cell = |k: usize| text.pointed(&cells[k]);
            if before.as_ref() == Some(&cells) {
                repeated += 1;
                continue;
            }
            let mut time = match time_of(&cell(time_at)).map_err(|m| at(line, m))? {
                Stamp::Number(number) => time_unit.map_or(number, |u| u.factor * number),
                Stamp::Date(seconds) => {
                    table.dated = true;
                    seconds
                }
                Stamp::Clock(seconds) => seconds + midnights,
            };
            if let Some(last) = table.time.last().filter(|last| time <= **last) {
                // A clock without dates that wraps at midnight.
                if cells[time_at].contains(':') && !table.dated && last - time > 0.5 * DAY {
                    midnights += DAY;
                    time += DAY;
                } else {
                    return Err(at(
                        line,
                        format!("time_s = {time} s does not come after {last} s of the row before"),
                    ));
                }
            }
            table.time.push(time);
            for ((channel, source), column) in wanted.iter().zip(&places).zip(&mut table.columns) {
                let Some((k, unit)) = source else {
                    column.push(f64::NAN);
                    continue;
                };
                let value = number(&cell(*k), channel.column).map_err(|m| at(line, m))?;
                column.push(unit.map_or(value + channel.offset, |u| u.factor * value + u.offset));
            }
            before = Some(cells);
        }
        if table.time.len() < 2 {
            return Err(CalibrateError(format!(
                "{file}: {} rows are no run; two are the least",
                table.time.len()
            )));
        }
        if repeated > 0 {
            table.notes.push(format!("{file}: {repeated} rows repeat the row before them and are set aside"));
        }
        table.note_gaps(file);
        Ok(table)
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

/// Index of a contract column in a file, and its unit if `[columns]` gives one; otherwise a one-sentence error.
fn source(header: &[String], column: &str, mapped: &[Column]) -> Result<(usize, Option<FileUnit>), String> {
    let at = |name: &str| header.iter().position(|h| h == name);
    let there: Vec<(usize, &Column)> =
        mapped.iter().filter(|c| c.column == column).filter_map(|c| Some((at(&c.header)?, c))).collect();
    match there[..] {
        [(k, found)] => Ok((k, Some(found.unit))),
        [(_, a), (_, b), ..] => Err(format!("{} and {} both record {column}", a.header, b.header)),
        [] => at(column).map(|k| (k, None)).ok_or_else(|| {
            let names: Vec<&str> =
                mapped.iter().filter(|c| c.column == column).map(|c| c.header.as_str()).collect();
            let or = if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
            let channel = || CHANNELS.iter().filter(|c| c.column == column);
            match header.iter().find_map(|name| other_unit(name, channel())) {
                Some(sentence) => format!("the column {column}{or} is missing; {sentence}"),
                None => format!(
                    "the column {column}{or} is missing; there is {}. [columns] can map another header to it; not_measured = \
                     [\"{column}\"] in [[run]] states that this run did not measure an output",
                    header.join(", ")
                ),
            }
        }),
    }
}

/// The time in a cell; otherwise a one-sentence error.
fn time_of(cell: &str) -> Result<Stamp, String> {
    if cell.is_empty() {
        return Err("time_s is blank; every row needs a time".to_string());
    }
    match Stamp::of(cell) {
        Some(Stamp::Number(number)) if !number.is_finite() => {
            Err(format!("time_s = {cell} is not a finite number"))
        }
        Some(stamp) => Ok(stamp),
        None => {
            Err(format!("time_s = {cell} is not a number, nor a time as 2025-11-19T14:30:00 or 14:30:00"))
        }
    }
}

/// The number in a cell, NaN for a blank; otherwise a one-sentence error.
fn number(cell: &str, column: &str) -> Result<f64, String> {
    if cell.is_empty() {
        return Ok(f64::NAN);
    }
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("{column} = {cell} is not a finite number; leave blank what was not measured")),
        Err(_) => Err(format!("{column} = {cell} is not a number; leave blank what was not measured")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A logger that changes its interval, also more than once, leaves no gap; one that stops does, also at both intervals.
    #[test]
    fn an_interval_that_changes_is_no_gap() {
        let gaps = |steps: &[(usize, f64)]| {
            let mut table = Table { time: vec![0.0], ..Table::default() };
            for (count, step) in steps {
                for _ in 0..*count {
                    table.time.push(table.time[table.time.len() - 1] + step);
                }
            }
            table.note_gaps("a.csv");
            (table.gaps().collect::<Vec<_>>(), table.notes)
        };
        for steady in
            [&[(100, 1.0), (30, 20.0)][..], &[(60, 0.1), (20, 2.0), (60, 0.1), (20, 60.0)], &[(1, 9.0)]]
        {
            assert_eq!(gaps(steady), (vec![], vec![]), "{steady:?}");
        }
        let (rows, notes) = gaps(&[(100, 1.0), (1, 40.0), (50, 1.0), (30, 10.0), (1, 80.0), (30, 10.0)]);
        assert_eq!((rows, notes.len()), (vec![100, 181], 2));
        // Bursts of ten rows.
        let bursts: Vec<(usize, f64)> =
            (0..12).map(|k| if k % 2 == 0 { (10, 1.0) } else { (1, 50.0) }).collect();
        let (rows, notes) = gaps(&bursts[..11]);
        assert_eq!(rows.len(), 5);
        assert!(notes.len() == 1 && notes[0].contains("5 gaps without rows"), "{notes:?}");
    }

    fn read(text: &str) -> Result<Table, CalibrateError> {
        let wanted = ["current_A", "winding_temperature_degC"].map(|c| Channel::of(c).unwrap());
        Table::parse(text.as_bytes(), "run.csv", &wanted, &[], &[])
    }

    const HEADER: &str = "time_s,winding_temperature_degC,current_A\n";

    #[test]
    fn columns_in_any_order_in_si_units_with_blanks() {
        let table = read(&format!("{HEADER}0,20,1.5\n2,,-2\n4, 21.5 ,\n")).unwrap();
        assert_eq!(table.time, [0.0, 2.0, 4.0]);
        assert_eq!(table.columns[0][..2], [1.5, -2.0]);
        assert!(table.columns[0][2].is_nan() && table.columns[1][1].is_nan());
        assert_eq!(table.columns[1][2], 294.65);
        assert!(table.notes.is_empty());
    }

    #[test]
    fn what_cannot_be_is_named_with_file_and_line() {
        for (text, parts) in [
            ("time_s,current_A\n0,1\n", ["run.csv:1:", "winding_temperature_degC is missing"]),
            (
                "time_s,winding_temperature_degC,current_A\n0,20,1\n2,NaN,1\n",
                ["run.csv:3:", "= NaN is not a finite"],
            ),
            (
                "time_s,winding_temperature_degC,current_A\n0,20,1\n2,21,n/a\n",
                ["run.csv:3:", "current_A = n/a"],
            ),
            (
                "time_s,winding_temperature_degC,current_A\n0,20,1\n2,20,1\n1,20,1\n",
                ["run.csv:4:", "does not come after 2 s"],
            ),
            ("time_s,winding_temperature_degC,current_A\n0,20,1\n,20,1\n", ["run.csv:3:", "time_s is blank"]),
            ("time_s,winding_temperature_degC,current_A\n0,20\n", ["run.csv:2:", "does not fit the header"]),
            ("time_s,winding_temperature_degC,current_A\n0,20,1\n", ["run.csv:", "1 rows are no run"]),
        ] {
            let sentence = read(text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| sentence.contains(part)), "{sentence}");
        }
    }

    #[test]
    fn gaps_are_noted() {
        let rows: String = (0..20).map(|k| format!("{k},30,1\n")).collect();
        let table = read(&format!("{HEADER}{rows}100,30,1\n")).unwrap();
        assert!(table.notes.len() == 1 && table.notes[0].contains("from 19 s to 100 s"), "{:?}", table.notes);
    }
}
