//! Tables of inputs over time, from CSV.
use crate::{Causality, Error, Kind, ModelDescription, Value, Variability};
use std::path::{Path, PathBuf};

/// Inputs over time: header `time,<input names>`, then rows of numbers (enumerations also by item name).
///
/// Continuous reals are interpolated linearly; all other inputs are constant until the next row. Before the first row and after
/// the last one the values are constant. Two rows with the same time define a discontinuity.
#[derive(Clone, Debug)]
pub struct InputTable {
    path: PathBuf,
    times: Vec<f64>,
    columns: Vec<InputColumn>,
}

#[derive(Clone, Debug)]
pub(crate) struct InputColumn {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) value_reference: u32,
    /// Linear between rows, else constant.
    pub(crate) continuous: bool,
    values: Vec<f64>,
}

impl InputTable {
    /// Reads a table for the FMU with this description.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Text`] with the line: an empty file, a first column that is not `time`, a name that
    /// is unknown, not an input or repeated, a row of another length, a value that is no finite number of its type
    /// or outside its limits, time running backwards, no rows.
    pub fn read(path: &Path, description: &ModelDescription) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(Error::io("read", path))?;
        Self::parse(path, &bytes, description)
    }

    /// As [`Self::read`], for text at hand; `path` is for messages.
    fn parse(path: &Path, bytes: &[u8], description: &ModelDescription) -> Result<Self, Error> {
        let fault = |line, message: String| Error::Text { file: path.display().to_string(), line, message };
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let mut table = Self { path: path.to_owned(), times: Vec::new(), columns: Vec::new() };
        let mut have_header = false;
        let mut record = csv::StringRecord::new();
        loop {
            let more = reader.read_record(&mut record).map_err(|e| {
                fault(e.position().map_or(0, csv::Position::line), "the text is not UTF-8".to_owned())
            })?;
            if !more {
                break;
            }
            // The position of a record may include the empty lines before it.
            let line = record.position().map_or(0, |p| line_of(bytes, p.byte()));
            let done = if have_header {
                table.push_row(&record, description)
            } else {
                have_header = true;
                table.push_header(&record, description)
            };
            done.map_err(|message| fault(line, message))?;
        }
        if !have_header {
            return Err(fault(1, "the file is empty".to_owned()));
        }
        if table.times.is_empty() {
            return Err(fault(1, "there are no rows below the header".to_owned()));
        }
        Ok(table)
    }

    /// The file it came from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the inputs in the table.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|c| c.name.as_str())
    }

    /// Times of the rows (s), not falling.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    pub(crate) fn columns(&self) -> &[InputColumn] {
        &self.columns
    }

    /// Value of column `index` at `t`, after a jump at `t`. A row within `slack` of `t` counts as being at `t`:
    /// communication points and row times are rounded differently.
    pub(crate) fn after(&self, index: usize, t: f64, slack: f64) -> f64 {
        self.value(index, t, self.times.partition_point(|x| *x <= t + slack))
    }

    /// Value of column `index` at `t`, before a jump at `t`.
    pub(crate) fn before(&self, index: usize, t: f64, slack: f64) -> f64 {
        self.value(index, t, self.times.partition_point(|x| *x < t - slack))
    }

    /// The value at `t`, between rows `next - 1` and `next`.
    fn value(&self, index: usize, t: f64, next: usize) -> f64 {
        let column = &self.columns[index];
        let values = &column.values;
        if next == 0 || next == values.len() || !column.continuous {
            return values[next.saturating_sub(1)];
        }
        let (t0, t1) = (self.times[next - 1], self.times[next]);
        let (v0, v1) = (values[next - 1], values[next]);
        // Rows at the same time: no interpolation.
        let share = if t1 > t0 { ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { 1.0 };
        if share == 1.0 { v1 } else { v0 + share * (v1 - v0) }
    }

    fn push_header(
        &mut self,
        record: &csv::StringRecord,
        description: &ModelDescription,
    ) -> Result<(), String> {
        if record.get(0) != Some("time") {
            return Err(format!("the first column is {:?}, not \"time\"", record.get(0).unwrap_or("")));
        }
        for name in record.iter().skip(1) {
            let variable = description.settable(name).map_err(|e| format!("unknown column: {e}"))?;
            if variable.causality != Causality::Input {
                return Err(format!(
                    "column {name} is a {}, only inputs can change in time",
                    variable.causality
                ));
            }
            if !variable.kind.is_numeric() || !variable.dimensions.is_empty() {
                return Err(format!("column {name} is not a scalar number"));
            }
            if self.columns.iter().any(|c| c.name == name) {
                return Err(format!("column {name} is repeated"));
            }
            self.columns.push(InputColumn {
                name: name.to_owned(),
                kind: variable.kind,
                value_reference: variable.value_reference,
                continuous: variable.kind.is_float() && variable.variability == Variability::Continuous,
                values: Vec::new(),
            });
        }
        if self.columns.is_empty() { Err("there is no input column besides time".to_owned()) } else { Ok(()) }
    }

    fn push_row(&mut self, record: &csv::StringRecord, description: &ModelDescription) -> Result<(), String> {
        if record.len() != self.columns.len() + 1 {
            return Err(format!("{} cells where the header has {}", record.len(), self.columns.len() + 1));
        }
        let text = record.get(0).unwrap_or("");
        let time: f64 = text
            .parse()
            .ok()
            .filter(|t: &f64| t.is_finite())
            .ok_or_else(|| format!("time = {text:?} is not a finite number (in s)"))?;
        if let Some(last) = self.times.last().filter(|last| time < **last) {
            return Err(format!("time runs backwards from {last} s to {time} s"));
        }
        for (column, text) in self.columns.iter_mut().zip(record.iter().skip(1)) {
            let (_, value) = description.parse_value(&column.name, text).map_err(|e| e.to_string())?;
            column.values.push(match value {
                Value::Real(x) => x,
                Value::Integer(x) => x as f64,
                Value::Boolean(x) => f64::from(u8::from(x)),
                Value::String(_) | Value::Binary(_) => {
                    return Err(format!("column {} is not a number", column.name));
                }
            });
        }
        self.times.push(time);
        Ok(())
    }
}

/// The line (from 1) of the first cell at or after byte `position`: blank lines are skipped.
fn line_of(bytes: &[u8], position: u64) -> u64 {
    let start = (position as usize).min(bytes.len());
    let blank = bytes[start..].iter().take_while(|b| b"\r\n".contains(b)).count();
    1 + bytes[..start + blank].iter().filter(|b| **b == b'\n').count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description() -> ModelDescription {
        ModelDescription::parse(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><ModelVariables>
            <ScalarVariable name="u" valueReference="1" causality="input"><Real start="0" min="-10" max="10"/></ScalarVariable>
            <ScalarVariable name="n" valueReference="2" causality="input" variability="discrete"><Integer start="0"/></ScalarVariable>
            <ScalarVariable name="p" valueReference="3" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
            </ModelVariables></fmiModelDescription>"#,
        )
        .unwrap()
    }

    fn parse(text: &str) -> Result<InputTable, Error> {
        InputTable::parse(Path::new("in.csv"), text.as_bytes(), &description())
    }

    #[test]
    fn reals_run_and_integers_hold() {
        let table = parse("time,u,n\n0,0,1\n1,2,2\n1,4,3\n3,0,4\n").unwrap();
        let at = |t| (table.after(0, t, 1e-9), table.after(1, t, 1e-9));
        assert_eq!(at(-1.0), (0.0, 1.0));
        assert_eq!(at(0.5), (1.0, 1.0));
        assert_eq!(table.before(0, 1.0, 1e-9), 2.0);
        assert_eq!(at(1.0), (4.0, 3.0));
        assert_eq!(at(2.0), (2.0, 3.0));
        assert_eq!(at(9.0), (0.0, 4.0));
        // A point that is a rounding error before a discontinuity counts as after it.
        assert_eq!(at(1.0 - 1e-12).1, 3.0);
    }

    #[test]
    fn faults_name_file_and_line() {
        for [text, expected] in crate::tests::faults("input") {
            assert_eq!(parse(&text).unwrap_err().to_string(), expected);
        }
    }
}
