//! Delimited text (CSV) as loggers and spreadsheets write it.
//!
//! The encoding is UTF-8, UTF-16 with a byte order mark, or else Windows-1252. Columns are separated by semicolons, tabs or commas:
//! the first of these that the header has. Where that is not the comma, numbers may have a decimal comma. Blank lines and lines
//! that begin with `#` do not count. Blank cells behind the last named column do not count either. Thousands separators are refused where
//! they cannot be distinguished from a decimal mark by one number alone, but by those of the column ([`Table::grouped`]).

use csv::{ReaderBuilder, StringRecord, Trim};
use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use std::borrow::Cow;
use std::path::Path;
use std::{fmt, fs, io};

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
    separator: u8,
    header: Vec<String>,
    line: u64,
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
    /// The table of the bytes of a file.
    ///
    /// # Errors
    /// An empty file, or one that is no text.
    pub fn parse(bytes: &[u8]) -> Result<Table, Fault> {
        let fault = |message: &str| Fault { line: 1, message: message.to_owned() };
        let text = decoded(bytes).into_owned();
        if text.contains('\0') {
            return Err(fault("the file is not text; a spreadsheet must be saved as CSV"));
        }
        let head = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let head = head.ok_or_else(|| fault("the file is empty"))?;
        let separator = *b";\t,".iter().find(|mark| head.as_bytes().contains(mark)).unwrap_or(&b',');
        let mut table = Table { text, separator, header: Vec::new(), line: 1 };
        let first = table.records().next();
        if let Some(first) = first {
            table.line = first.line;
            table.header = first.cells.iter().map(str::to_owned).collect();
            while table.header.last().is_some_and(String::is_empty) {
                table.header.pop();
            }
        }
        Ok(table)
    }

    /// Names of the columns.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of the header's line, from 1.
    pub fn header_line(&self) -> u64 {
        self.line
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

    /// A cell with a decimal point in place of a decimal comma.
    pub fn pointed<'c>(&self, cell: &'c str) -> Cow<'c, str> {
        if self.has_decimal_comma() && cell.contains(',') && !cell.contains('.') {
            return cell.replace(',', ".").into();
        }
        cell.into()
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
        self.separator != b','
    }

    /// Header and rows with the cells that they have.
    fn records(&self) -> impl Iterator<Item = Row> + '_ {
        let mut reader = ReaderBuilder::new();
        reader
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .delimiter(self.separator);
        // Text in UTF-8 with rows of any length has no errors.
        reader.from_reader(self.text.as_bytes()).into_records().flatten().map(|cells| {
            let line = cells.position().map_or(1, |p| p.line() + self.skipped(p.byte() as usize));
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

/// Fewest numbers with a mark that decide. A program that omits trailing zeros writes three decimals in nine of ten numbers with at most three:
/// all of 44 have them with a probability of 1 %.
const MANY: usize = 44;

/// What a cell says of its column's mark.
enum Grouping {
    None,
    /// A whole number from 1 to 999.
    Whole,
    Thousands,
}

/// `None` for a number that has another decimal mark than a thousands separator.
fn grouping(cell: &str) -> Option<Grouping> {
    let digits = cell.trim_start_matches(['-', '+']);
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits.starts_with(|first: char| first.is_ascii_digit()) || digits == "0" {
        // Blank, not a number in any notation, or zero.
        return Some(Grouping::None);
    }
    let mut groups = digits.split([',', '.']);
    groups.next().filter(|lead| is_number(lead) && lead.len() <= 3 && !lead.starts_with('0'))?;
    if !digits.contains([',', '.']) {
        return Some(Grouping::Whole);
    }
    groups.all(|group| group.len() == 3 && is_number(group)).then_some(Grouping::Thousands)
}

/// The text of a file in any of these encodings, without its byte order mark: of a TOML file, too.
///
/// # Errors
/// A file that cannot be read, or one that is no text.
pub fn read_text(path: &Path) -> io::Result<String> {
    let text = decoded(&fs::read(path)?).into_owned();
    match text.contains('\0') {
        true => Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "the file is not text in UTF-8, UTF-16 with a byte order mark or Windows-1252",
        )),
        false => Ok(text),
    }
}

/// The folder to which file names in the text of a file are relative: its own, or the present one where the text comes from a pipe
/// (`/dev/stdin`, a process substitution of the shell).
pub fn folder(path: &Path) -> &Path {
    let is_pipe = fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    path.parent().filter(|_| !is_pipe).unwrap_or(Path::new(""))
}

/// The text of the bytes of a file.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match Encoding::for_bom(bytes) {
        Some((encoding, mark)) => encoding.decode_without_bom_handling(&bytes[mark..]).0,
        None => UTF_8
            .decode_without_bom_handling_and_without_replacement(bytes)
            .unwrap_or_else(|| WINDOWS_1252.decode_without_bom_handling(bytes).0),
    }
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
mod tests {
    use super::*;

    const TEXT: &str = "# Prüfstand\n\nt [s];U [V];\r\n0;1,5;\n\n# Pause\n\"1\"; -2.5 ;;\n";

    #[test]
    fn thousands_separators_are_seen_in_their_column() {
        let column = |separator: &str, cells: &dyn Fn(u32) -> String| {
            let rows: String = (0..200).map(|k| format!("{k}{separator}{}\n", cells(k))).collect();
            Table::parse(format!("t{separator}n\n{rows}").as_bytes()).unwrap().grouped(1)
        };
        let grouped = |mark: char, n: u32| match n {
            0..1000 => n.to_string(),
            1000..1_000_000 => format!("{}{mark}{:03}", n / 1000, n % 1000),
            _ => format!("{}{mark}{:03}{mark}{:03}", n / 1_000_000, n / 1000 % 1000, n % 1000),
        };
        let values: [fn(u32) -> u32; 3] = [|k| 41 * k, |k| 23 * k, |k| k * k * k];
        for (separator, mark, value) in [(";", ',', 0), (";", '.', 0), (",", '.', 1), ("\t", ',', 2)] {
            let sign = |k: u32| if k.is_multiple_of(3) { "-" } else { "" };
            let signed = |k: u32| format!("{}{}", sign(k), grouped(mark, values[value](k)));
            let fault = column(separator, &signed).unwrap();
            assert!(fault.message.contains("thousands separator") && fault.line > 2, "{}", fault.message);
        }
        // Three decimals always; as many as needed; a small number of them; whole numbers alone; no number below 1000.
        let cells: [&dyn Fn(u32) -> String; 5] = [
            &|k| format!("{},{:03}", k / 50, k * 20 % 1000),
            &|k| format!("{}", f64::from(k) / 8.0).replace('.', ","),
            &|k| if k < 40 { format!("{},{}", k + 1, 100 + k) } else { k.to_string() },
            &|k| (k * 40).to_string(),
            &|k| format!("{},{:03}", 1 + k / 50, k * 20 % 1000),
        ];
        for (k, cells) in cells.iter().enumerate() {
            assert_eq!(column(";", cells), None, "{k}");
        }
    }

    /// What comes from a pipe has no folder of its own; a name alone is in the present one.
    #[test]
    fn names_are_relative_to_the_file_or_to_where_its_text_is_piped() {
        let own = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert_eq!(folder(&own.join("Cargo.toml")), own);
        assert_eq!(
            [folder(Path::new("Cargo.toml")), folder(Path::new("a/missing"))],
            [Path::new(""), Path::new("a")]
        );
        if cfg!(unix) {
            assert_eq!(folder(Path::new("/dev/null")), Path::new(""));
        }
    }

    /// As the two files of Excel on a German machine, a logger and PowerShell have it.
    #[test]
    fn encodings_separators_and_decimal_commas() {
        let utf16: Vec<u8> =
            "\u{feff}".encode_utf16().chain(TEXT.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let windows: Vec<u8> = TEXT.chars().map(|c| c as u8).collect();
        for bytes in [TEXT.as_bytes(), format!("\u{feff}{TEXT}").as_bytes(), &utf16, &windows] {
            let table = Table::parse(bytes).unwrap();
            assert_eq!(
                (table.header(), table.header_line()),
                (&["t [s]", "U [V]"].map(str::to_owned)[..], 3)
            );
            let rows: Vec<(u64, Vec<String>)> = table
                .rows()
                .map(|row| row.unwrap())
                .map(|row| (row.line, row.cells.iter().map(|c| table.pointed(c).into_owned()).collect()))
                .collect();
            let expected = [(4, ["0", "1.5"]), (7, ["1", "-2.5"])];
            assert_eq!(rows, expected.map(|(line, cells)| (line, cells.map(str::to_owned).to_vec())));
        }
        let gehäuse = Table::parse(b"Geh\xe4use [\xb0C],t\n1,2\n").unwrap();
        assert_eq!(gehäuse.header()[0], "Gehäuse [°C]");
        assert_eq!(gehäuse.pointed("1,5"), "1,5");
    }

    /// A TOML file as editors and shells write it; not a spreadsheet, and not UTF-16 without mark.
    #[test]
    fn text_of_any_encoding_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.toml");
        let text = "# Prüfstand\nL = \"310 µH\"\n";
        let little: Vec<u8> =
            "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> =
            "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
        let windows: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for bytes in [text.as_bytes(), format!("\u{feff}{text}").as_bytes(), &little, &big, &windows] {
            fs::write(&path, bytes).unwrap();
            assert_eq!(read_text(&path).unwrap(), text);
        }
        for bytes in [&little[2..], b"PK\x03\x04\0\0"] {
            fs::write(&path, bytes).unwrap();
            assert!(read_text(&path).unwrap_err().to_string().contains("not text"));
        }
        assert!(read_text(&folder.path().join("none")).is_err());
    }

    #[test]
    fn faults_have_lines() {
        let fault = |text: &[u8]| match Table::parse(text) {
            Err(fault) => fault.to_string(),
            Ok(table) => table.rows().find_map(Result::err).map_or(String::new(), |f| f.to_string()),
        };
        assert_eq!(fault(b""), "line 1: the file is empty");
        assert_eq!(fault(b"# only a comment\n\n"), "line 1: the file is empty");
        assert!(fault(b"PK\x03\x04\0\0").contains("not text"));
        let fits = "the row does not fit the header: it has";
        assert_eq!(fault(b"a;b\n1;2\n\n1\n"), format!("line 4: {fits} 1 cells, the header has 2"));
        assert!(
            fault(b"a,b\n1,5,2,5\n")
                .ends_with("(a file with decimal commas needs semicolons between columns)")
        );
        assert_eq!(fault(b"a,b\n1,2\n"), "");
    }

    #[test]
    fn units_stand_in_brackets() {
        for (header, parts) in [
            ("n [rpm]", ("n", Some("rpm"))),
            ("M(mN.m)", ("M", Some("mN.m"))),
            (" w[1] [1/min] ", ("w[1]", Some("1/min"))),
            ("T (top) [°C]", ("T (top)", Some("°C"))),
            ("speed", ("speed", None)),
            ("x []", ("x []", None)),
        ] {
            assert_eq!(name_and_unit(header), parts);
        }
    }
}
