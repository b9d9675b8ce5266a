//! Delimited text (CSV) as loggers and spreadsheets write it.
//!
//! The encoding is UTF-8, UTF-16 with a byte order mark, or else Windows-1252. Columns are separated by semicolons, tabs or commas:
//! the first of these that the header has. Where that is not the comma, numbers may have a decimal comma; where it is, all numbers of a
//! file may have one in quotation marks. Blank lines and lines that begin with `#` do not count. Blank cells behind the last named column
//! do not count either. Thousands separators are refused where they cannot be distinguished from a decimal mark by one number alone, but by
//! those of the column ([`Table::grouped`]).
//!
//! [`Table::parse`] takes the first line as the header. [`Table::with_names`] finds the header by the names that it has to have, below the
//! lines that loggers write before it, and skips what an interrupted or restarted logger leaves in the file.

mod header;
mod number;
mod text;

pub use csv::StringRecord;
use csv::{ReaderBuilder, Trim};
use header::Place;
use number::{Grouping, MANY, Mark, grouping, mark};
use std::borrow::Cow;
use std::fmt;
pub use text::{folder, read_text};

/// What is wrong with a text, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the line, from 1.
    pub line: u64,
    /// One sentence without its full stop.
    pub message: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.message)
    }
}

/// A table of text: a header, and rows that [`Table::rows`] reads.
#[derive(Clone, Debug)]
pub struct Table {
    text: String,
    place: Place,
    header: Vec<String>,
    /// Whether the numbers of a file with commas between columns have decimal commas, in quotation marks.
    has_quoted_commas: bool,
    repeated: Vec<u64>,
    remarks: Vec<Fault>,
}

/// A row of a table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Number of its line, from 1.
    pub line: u64,
    /// A cell for each column of the header.
    pub cells: StringRecord,
}

impl Table {
    /// The table of the bytes of a file, whose header is the first line that is neither blank nor a comment.
    ///
    /// # Errors
    /// An empty file, or one that is no text.
    pub fn parse(bytes: &[u8]) -> Result<Table, Fault> {
        let text = text::of_table(bytes);
        text::check(&text)?;
        let place = header::first(&text).ok_or_else(empty)?;
        Ok(Table::at(text, place))
    }

    /// The table of the bytes of a file, whose header is the line that has these names: for each column those that it may have, first
    /// the column that every row needs. A repeated header, and NUL bytes at the end, are skipped ([`Table::repeated`],
    /// [`Table::remarks`]).
    ///
    /// # Errors
    /// An empty file, or one that is no text.
    pub fn with_names(bytes: &[u8], names: &[Vec<&str>]) -> Result<Table, Fault> {
        let mut text = text::of_table(bytes);
        let tail = text::remove_tail(&mut text);
        text::check(&text)?;
        let place = header::find(&text, names).ok_or_else(empty)?;
        let before = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
        let skipped = text[..place.start].lines().take(place.line as usize - 1).filter(before).count();
        let repeated = header::remove_repeated(&mut text, place);
        let mut table = Table::at(text, place);
        if skipped > 0 {
            let message = format!("the header is in line {}; the lines before it are skipped", place.line);
            table.remarks.push(Fault { line: place.line, message });
        }
        table.remarks.extend(tail);
        table.repeated = repeated;
        Ok(table)
    }

    fn at(text: String, place: Place) -> Table {
        let mut table = Table {
            text,
            place,
            header: Vec::new(),
            has_quoted_commas: false,
            repeated: Vec::new(),
            remarks: Vec::new(),
        };
        let first = table.records().next();
        if let Some(first) = first {
            table.header = first.cells.iter().map(str::to_owned).collect();
            while table.header.last().is_some_and(String::is_empty) {
                table.header.pop();
            }
        }
        table.has_quoted_commas = table.quotes_commas();
        table
    }

    /// Names of the columns.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of the header's line, from 1.
    pub fn header_line(&self) -> u64 {
        self.place.line
    }

    /// The lines before the header, from the one next to it, that have no more cells than it, with a cell for each of its columns; also those
    /// behind a comment sign.
    pub fn above(&self) -> Vec<Row> {
        let before = header::lines(&self.text).take_while(|(line, ..)| *line < self.place.line);
        let row = |(line, _, text)| {
            let mut cells = header::cells(header::uncommented(text), self.place.separator);
            let fits = !cells.is_empty() && cells.len() <= self.header.len();
            cells.resize(self.header.len(), String::new());
            fits.then(|| Row { line, cells: cells.into() })
        };
        let mut rows: Vec<Row> = before.filter_map(row).collect();
        rows.reverse();
        rows
    }

    /// Lines that repeat the header and are skipped: the logger was restarted and continued the file.
    pub fn repeated(&self) -> &[u64] {
        &self.repeated
    }

    /// What was skipped, apart from comments and repeated headers.
    pub fn remarks(&self) -> &[Fault] {
        &self.remarks
    }

    /// The rows below the header; one that does not fit the header is a fault.
    pub fn rows(&self) -> impl Iterator<Item = Result<Row, Fault>> + '_ {
        self.records().skip(1).map(|mut row| {
            let (count, wanted) = (row.cells.len(), self.header.len());
            let fits = count >= wanted && row.cells.iter().skip(wanted).all(str::is_empty);
            if !fits {
                let mut message =
                    format!("the row does not fit the header: it has {count} cells, the header has {wanted}");
                if count > wanted && !self.has_decimal_comma() {
                    message += " (a file with decimal commas needs semicolons between columns)";
                }
                return Err(Fault { line: row.line, message });
            }
            row.cells.truncate(wanted);
            Ok(row)
        })
    }

    /// A cell with a decimal point in place of a decimal comma, and a hyphen in place of a typographic minus.
    pub fn pointed<'c>(&self, cell: &'c str) -> Cow<'c, str> {
        let has_comma = self.has_decimal_comma() && cell.contains(',') && !cell.contains('.');
        match (has_comma, cell.contains(MINUS)) {
            (false, false) => cell.into(),
            (false, true) => cell.replace(MINUS, "-").into(),
            (true, _) => cell.replace(',', ".").replace(MINUS, "-").into(),
        }
    }

    /// Why a cell that looks like a number is none: its thousands separators, or a decimal comma beside decimal points.
    pub fn notation(&self, cell: &str) -> Option<&'static str> {
        if number::has_thousands(cell) {
            return Some("has a thousands separator: write numbers without thousands separators");
        }
        (mark(cell) == Mark::Comma).then_some(
            "has a decimal comma, but other numbers of the file have decimal points: write one decimal mark",
        )
    }

    /// A column whose decimal mark is a thousands separator (`5,432` beside `987`), which would be read as a number below 1000: every
    /// number with a mark has three digits behind it and no zero before it, and the others are whole and below 1000.
    pub fn grouped(&self, column: usize) -> Option<Fault> {
        let (mut first, mut marked, mut whole) = (None, 0, 0);
        for row in self.records().skip(1) {
            let cell = row.cells.get(column).unwrap_or_default();
            match grouping(cell)? {
                Grouping::None => {}
                Grouping::Whole => whole += 1,
                Grouping::Thousands => {
                    marked += 1;
                    first.get_or_insert((row.line, cell.to_owned()));
                }
            }
        }
        let (line, cell) = first.filter(|_| marked >= MANY && whole > 0)?;
        let name = self.header.get(column).map_or("", String::as_str);
        let message = format!(
            "{cell} in column {name} has a thousands separator: all {marked} numbers with such a mark have three digits behind it, and the \
             other {whole} are whole numbers below 1000; write numbers without thousands separators"
        );
        Some(Fault { line, message })
    }

    fn has_decimal_comma(&self) -> bool {
        self.place.separator != b',' || self.has_quoted_commas
    }

    /// Whether cells of a file with commas between columns have commas that are decimal ones, and no number has a decimal point.
    fn quotes_commas(&self) -> bool {
        if self.place.separator != b',' || !self.text.contains('"') {
            return false;
        }
        let mut has_comma = false;
        for row in self.records().skip(1) {
            for cell in &row.cells {
                match mark(cell) {
                    Mark::Point => return false,
                    Mark::Comma => has_comma = true,
                    Mark::Unknown => {}
                }
            }
        }
        has_comma
    }

    /// Header and rows with the cells that they have.
    fn records(&self) -> impl Iterator<Item = Row> + '_ {
        let mut reader = ReaderBuilder::new();
        reader
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .delimiter(self.place.separator);
        let (start, line) = (self.place.start, self.place.line);
        // Text in UTF-8 with rows of any length has no errors.
        reader.from_reader(&self.text.as_bytes()[start..]).into_records().flatten().map(move |cells| {
            let line = cells
                .position()
                .map_or(line, |p| line - 1 + p.line() + self.skipped(start + p.byte() as usize));
            Row { line, cells }
        })
    }

    /// Lines before the first cell at or after byte `start`: those that are blank or comments.
    fn skipped(&self, start: usize) -> u64 {
        let rest = self.text.get(start..).unwrap_or_default();
        let before = rest.split('\n').take_while(|line| line.trim_end().is_empty() || line.starts_with('#'));
        before.count() as u64
    }
}

/// The minus sign of Unicode, which typesetting programs and some loggers write.
const MINUS: char = '\u{2212}';

fn empty() -> Fault {
    Fault { line: 1, message: "the file is empty".to_owned() }
}

/// Name and unit of a header such as `n [rpm]` or `M (mN.m)`; no unit where it does not end in brackets.
pub fn name_and_unit(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    let parts = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (name, unit) = header.strip_suffix(close)?.rsplit_once(open)?;
        Some((name.trim_end(), Some(unit.trim())))
    });
    parts.filter(|(_, unit)| *unit != Some("")).unwrap_or((header, None))
}

#[cfg(test)]
mod tests;
