//! Reader and writer of `resources/load.json`: the load table of an FMU ([`LoadTable`]).
//!
//! ```json
//! {"format": "motor-fmu load 1",
//!  "source": "press.csv, columns t [ms], M, n",
//!  "period": 1.2,
//!  "angle": 0.1,
//!  "rows": [
//!   [0.0, 12.5, 3.1],
//!   [0.01, 12.7, 3.3]]}
//! ```
//! A row has time in s, torque in N.m and speed in rad/s; the first time is 0, the last is less than the period. Torque and speed are
//! linear in time between the rows, and from the last row to the first row of the next period. Optional: source, and the angle of the
//! first row in rad (default: the angle has zero mean).

use crate::{GREATEST, TermsError, ascending, within};
use physics::load_table::{LoadTable, MOST_ROWS};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the file in the resources of an archive.
pub const FILE_NAME: &str = "load.json";
/// Format identifier of the file.
pub const FORMAT: &str = "motor-fmu load 1";
/// Limits of the period, s.
const PERIOD: (f64, f64) = (1e-4, 1e7);

/// Content of the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LoadFile {
    /// [`FORMAT`].
    pub format: String,
    /// Source of the table: file and columns.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Period, s.
    pub period: f64,
    /// Angle of the first row, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Time, torque and speed.
    pub rows: Vec<[f64; 3]>,
}

impl LoadFile {
    /// A table as a file.
    pub fn new(table: &LoadTable, source: &str) -> LoadFile {
        let row = |k: usize| [table.times[k], table.torques[k], table.speeds[k]];
        let (period, angle) = (table.period, table.angle);
        let rows = (0..table.times.len()).map(row).collect();
        LoadFile { format: FORMAT.to_owned(), source: source.to_owned(), period, angle, rows }
    }

    /// Parses the text of a file; errors contain the name `file`.
    ///
    /// # Errors
    /// One sentence with file and line or field, value and limits.
    pub fn parse(text: &str, file: &str) -> Result<LoadFile, TermsError> {
        let found: LoadFile =
            serde_json::from_str(text).map_err(|error| TermsError::of_json(&error, file))?;
        found.table().map_err(|TermsError(sentence)| TermsError(format!("{file}: {sentence}")))?;
        Ok(found)
    }

    /// Reads the file at a path.
    ///
    /// # Errors
    /// As [`parse`](LoadFile::parse), or a file that cannot be read.
    pub fn load(path: &Path) -> Result<LoadFile, TermsError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| TermsError(format!("{} cannot be read: {error}", path.display())))?;
        LoadFile::parse(&text, &path.display().to_string())
    }

    /// The table, checked.
    ///
    /// # Errors
    /// One sentence with field, value and limits.
    pub fn table(&self) -> Result<LoadTable, TermsError> {
        if self.format != FORMAT {
            return Err(TermsError(format!("the format is \"{}\", not \"{FORMAT}\"", self.format)));
        }
        let n = self.rows.len();
        if !(1..=MOST_ROWS).contains(&n) {
            return Err(TermsError(format!("the table has {n} rows; the limits are 1 ... {MOST_ROWS}")));
        }
        let column = |place: usize| self.rows.iter().map(|row| row[place]).collect::<Vec<f64>>();
        let table = LoadTable {
            times: column(0),
            torques: column(1),
            speeds: column(2),
            period: self.period,
            angle: self.angle,
        };
        self.check(&table).map_err(TermsError)?;
        Ok(table)
    }

    fn check(&self, table: &LoadTable) -> Result<(), String> {
        within("period", table.period, PERIOD.0, PERIOD.1)?;
        within("angle", table.angle.unwrap_or(0.0), -GREATEST, GREATEST)?;
        for (k, row) in self.rows.iter().enumerate() {
            within(&format!("the torque of rows[{k}]"), row[1], -GREATEST, GREATEST)?;
            within(&format!("the speed of rows[{k}]"), row[2], -GREATEST, GREATEST)?;
        }
        if table.times[0] != 0.0 {
            return Err(format!("the time of rows[0] is {}, not 0", table.times[0]));
        }
        ascending("the time of rows", &table.times)?;
        match table.times.last() {
            Some(last) if *last >= table.period => {
                Err(format!("the last time {last} s is not below the period of {} s", table.period))
            }
            _ => Ok(()),
        }
    }

    /// The text of the file, one line per row.
    pub fn text(&self) -> String {
        let head = LoadFile { rows: Vec::new(), ..self.clone() };
        let json = |value: &dyn Fn() -> serde_json::Result<String>| value().unwrap_or_default();
        let rows: Vec<String> = self.rows.iter().map(|row| json(&|| serde_json::to_string(row))).collect();
        let head = json(&|| serde_json::to_string_pretty(&head));
        head.replace("\"rows\": []", &format!("\"rows\": [\n    {}\n  ]", rows.join(",\n    "))) + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALID: &str = r#"{"format": "motor-fmu load 1", "source": "press.csv", "period": 1.2,
 "rows": [[0, 12.5, 3], [0.1, -7, 3.3],
          [1.1, 1e-3, -0.125]]}"#;

    #[test]
    fn a_table_becomes_text_and_a_table_again() {
        let file = LoadFile::parse(VALID, "x.json").unwrap();
        let table = file.table().unwrap();
        assert_eq!((table.times[2], table.torques[1], table.speeds[2]), (1.1, -7.0, -0.125));
        for angle in [None, Some(0.3)] {
            let file = LoadFile::new(&LoadTable { angle, ..table.clone() }, "[cycle] \"rows\": []");
            let text = file.text();
            assert_eq!(LoadFile::parse(&text, "y.json").unwrap(), file, "{text}");
            assert!(text.lines().any(|line| line.trim() == "[0.1,-7.0,3.3],"), "{text}");
        }
    }

    #[test]
    fn errors_name_what_is_wrong() {
        for (old, new, words) in [
            ("load 1", "effects 1", &["motor-fmu effects 1", "motor-fmu load 1"][..]),
            ("1.2", "1.1", &["1.1 s", "below the period"]),
            ("1.2", "-1", &["period = -1", "0.0001 ... 10000000"]),
            ("[0, 12.5", "[0.01, 12.5", &["rows[0] is 0.01"]),
            ("[1.1, ", "[0.1, ", &["the time of rows[2] = 0.1 is not larger"]),
            ("-7", "1e9", &["the torque of rows[1] = 1000000000"]),
            ("-0.125", "\"fast\"", &["x.json:3:", "fast"]),
            ("-0.125", "1e999", &["x.json:3:", "out of range"]),
            ("\"period\"", "\"time\"", &["x.json:1:", "time"]),
        ] {
            assert_eq!(VALID.matches(old).count(), 1, "{old}");
            let sentence = LoadFile::parse(&VALID.replace(old, new), "x.json").unwrap_err().to_string();
            let named = words.iter().all(|w| sentence.contains(w));
            assert!(
                named && sentence.starts_with("x.json") && !sentence.contains('\n'),
                "{words:?} in {sentence}"
            );
        }
    }
}
