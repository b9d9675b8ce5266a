//! Tables of inputs over time, from CSV.
use crate::quantity::{of_column, unknown_column};
use crate::system::Affine;
use crate::{Causality, Error, Kind, ModelDescription, Value, Variability, Variable};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use units::Conversion;

/// Inputs over time: header `time,<input names>`, then rows of numbers (enumerations also by item name), in any form that
/// [`delimited`] reads. A name may be followed by a unit of the FMU or of the quantity, such as `speed [rpm]`.
///
/// Continuous reals are interpolated linearly; all other inputs are constant until the next row. Before the first row and after
/// the last one the values are constant. Two rows with the same time define a discontinuity.
#[derive(Clone, Debug)]
pub struct InputTable {
    path: PathBuf,
    times: Vec<f64>,
    columns: Vec<InputColumn>,
    notes: Vec<String>,
}

/// Values over time of one input of one component.
#[derive(Clone, Debug)]
pub(crate) struct InputColumn {
    /// The name in the header, without unit.
    pub(crate) name: String,
    /// The component; 0 for a single FMU.
    pub(crate) component: usize,
    /// Place in the FMU's list of variables.
    pub(crate) variable: usize,
    pub(crate) kind: Kind,
    pub(crate) value_reference: u32,
    /// Linear between rows, else constant.
    pub(crate) continuous: bool,
    /// A value beyond the limits was noted.
    noted: bool,
    values: Vec<f64>,
}

/// An input that a column of the file is for.
pub(crate) struct Target<'a> {
    pub(crate) component: usize,
    pub(crate) description: &'a ModelDescription,
    pub(crate) variable: &'a Variable,
    /// From the numbers of the file to those of the input.
    pub(crate) convert: Affine,
}

/// Looks up a name with its unit.
pub(crate) type Find<'a, 'f> = dyn Fn(&str, Option<&str>) -> Result<Vec<Target<'a>>, String> + 'f;

/// A column of the file: the places of its columns in the table, and what they are for.
struct Cell<'a> {
    first: usize,
    targets: Vec<Target<'a>>,
}

impl InputTable {
    /// Reads a table for the FMU with this description, once, so that it may come through a pipe; `-` is the standard input. Columns without a unit are in the unit of the variable, or in its display unit.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Text`] with the line: an empty file, a first column that is not `time`, a name that
    /// is unknown, not an input or repeated, a unit that does not fit, a row of another length, a value that is no finite number of
    /// its type, time running backwards, no rows.
    pub fn read(path: &Path, description: &ModelDescription, display_units: bool) -> Result<Self, Error> {
        let (bytes, path) = content(path)?;
        Self::parse(path, &bytes, description, display_units)
    }

    /// As [`Self::read`], for text at hand; `path` is for messages.
    fn parse(
        path: &Path,
        bytes: &[u8],
        description: &ModelDescription,
        display_units: bool,
    ) -> Result<Self, Error> {
        Self::parse_for(path, bytes, &|name, unit| {
            let variable = description.settable(name).map_err(|e| unknown_column(description, name, &e))?;
            let convert = of_column(description, variable, unit, display_units)?;
            Ok(vec![Target { component: 0, description, variable, convert }])
        })
    }

    /// Reads a table whose names, with their units, `find` looks up.
    pub(crate) fn parse_for<'a>(path: &Path, bytes: &[u8], find: &Find<'a, '_>) -> Result<Self, Error> {
        let file = path.display().to_string();
        let fault = |line, message: String| Error::Text { file: file.clone(), line, message };
        let text = delimited::Table::parse(bytes).map_err(|f| fault(f.line, f.message))?;
        let mut table =
            Self { path: path.to_owned(), times: Vec::new(), columns: Vec::new(), notes: Vec::new() };
        let (time, cells) =
            table.header(text.header(), find).map_err(|message| fault(text.header_line(), message))?;
        if let Some(f) = (0..text.header().len()).find_map(|k| text.grouped(k)) {
            return Err(fault(f.line, f.message));
        }
        for row in text.rows() {
            let row = row.map_err(|f| fault(f.line, f.message))?;
            let cell = |k: usize| text.pointed(row.cells.get(k).unwrap_or_default());
            table.push_row(&cell, time, &cells, row.line).map_err(|message| fault(row.line, message))?;
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

    /// Values beyond the declared limits of their input, the first of each column: the FMU decides about them.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    pub(crate) fn columns(&self) -> &[InputColumn] {
        &self.columns
    }

    /// The next row after `t`, at which inputs have a kink or a discontinuity.
    pub(crate) fn next_row(&self, t: f64) -> Option<f64> {
        self.times.get(self.times.partition_point(|x| *x <= t)).copied()
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

    /// Whether an input jumps at `t`.
    pub(crate) fn jumps(&self, t: f64, slack: f64) -> bool {
        let jump = |c: usize| self.before(c, t, slack).to_bits() != self.after(c, t, slack).to_bits();
        self.next_row(t - slack).is_some_and(|row| row <= t + slack) && (0..self.columns.len()).any(jump)
    }

    /// The first time after `t` and before `end` at which an input jumps.
    pub(crate) fn next_jump(&self, t: f64, end: f64, slack: f64) -> Option<f64> {
        let rows = std::iter::successors(self.next_row(t + slack), |row| self.next_row(*row));
        rows.take_while(|row| *row < end - slack).find(|row| self.jumps(*row, slack))
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

    /// The conversion of the times to s, and the other columns.
    fn header<'a>(
        &mut self,
        header: &[String],
        find: &Find<'a, '_>,
    ) -> Result<(Conversion, Vec<Cell<'a>>), String> {
        let first = header.first().map_or("", String::as_str);
        let time = match name_and_unit(first) {
            ("time", unit) => units::conversion(unit.unwrap_or("s"), "s", false)
                .map_err(|refusal| format!("column time has the unit \"s\": {refusal}"))?,
            _ => return Err(format!("the first column is {first:?}, not \"time\"")),
        };
        let mut cells = Vec::new();
        for text in header.iter().skip(1) {
            let (name, unit) = name_and_unit(text);
            let targets = find(name, unit)?;
            let first = self.columns.len();
            for target in &targets {
                let variable = target.variable;
                if variable.causality != Causality::Input {
                    return Err(format!(
                        "column {name} is a {}, only inputs can change in time",
                        variable.causality
                    ));
                }
                if !variable.kind.is_numeric() || !variable.dimensions.is_empty() {
                    return Err(format!("column {name} is not a scalar number"));
                }
                let place = |v: &Variable| std::ptr::eq(v, variable);
                let place = target.description.variables.iter().position(place).unwrap_or(0);
                let same = |c: &&InputColumn| c.component == target.component && c.variable == place;
                match self.columns.iter().find(same) {
                    Some(other) if other.name == name => return Err(format!("column {name} is repeated")),
                    Some(other) => {
                        return Err(format!("columns {} and {name} are for the same input", other.name));
                    }
                    None => {}
                }
                self.columns.push(InputColumn {
                    name: name.to_owned(),
                    component: target.component,
                    variable: place,
                    kind: variable.kind,
                    value_reference: variable.value_reference,
                    continuous: variable.kind.is_float() && variable.variability == Variability::Continuous,
                    noted: false,
                    values: Vec::new(),
                });
            }
            cells.push(Cell { first, targets });
        }
        if cells.is_empty() {
            return Err("there is no input column besides time".to_owned());
        }
        Ok((time, cells))
    }

    /// Adds the row of a line, of which `text` gives each cell.
    fn push_row<'t>(
        &mut self,
        text: &dyn Fn(usize) -> Cow<'t, str>,
        time: Conversion,
        cells: &[Cell],
        line: u64,
    ) -> Result<(), String> {
        let first = text(0);
        let number = first.parse().ok().filter(|t: &f64| t.is_finite());
        let number = number.ok_or_else(|| format!("time = {first:?} is not a finite number (in s)"))?;
        let time = time.of(number);
        if let Some(last) = self.times.last().filter(|last| time < **last) {
            return Err(format!("time runs backwards from {last} s to {time} s"));
        }
        for (k, cell) in cells.iter().enumerate() {
            let text = text(k + 1);
            for (target, column) in cell.targets.iter().zip(&mut self.columns[cell.first..]) {
                let Target { description, variable, convert, .. } = target;
                let value = description.typed_value(variable, &text).map_err(|e| e.to_string())?;
                let value = match value {
                    Value::Real(x) => Value::Real(convert.of(x)),
                    other => other,
                };
                // An FMU may take values beyond its limits, for example by saturation.
                if let (Err(beyond), false) = (crate::value::check_limits(variable, &value), column.noted) {
                    self.notes.push(format!(
                        "{}, line {line}: {beyond}; the value is passed on to the FMU",
                        self.path.display()
                    ));
                    column.noted = true;
                }
                column.values.push(match value {
                    Value::Real(x) => x,
                    Value::Integer(x) => x as f64,
                    Value::Boolean(x) => f64::from(u8::from(x)),
                    Value::String(_) | Value::Binary(_) => {
                        return Err(format!("column {} is not a number", column.name));
                    }
                });
            }
        }
        self.times.push(time);
        Ok(())
    }
}

/// Whether a path means the standard input. The process of an FMU has another one, so that its parent has to read it.
pub fn is_standard_input(path: &Path) -> bool {
    ["-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"].iter().any(|name| path == Path::new(name))
}

/// The bytes of a file, and its name for messages.
pub(crate) fn content(path: &Path) -> Result<(Vec<u8>, &Path), Error> {
    if !is_standard_input(path) {
        return Ok((std::fs::read(path).map_err(Error::io("read", path))?, path));
    }
    let name = Path::new("standard input");
    Ok((crate::child::standard_input().map_err(Error::io("read", name))?, name))
}

/// `name [unit]`; brackets that follow the name at once belong to it.
fn name_and_unit(text: &str) -> (&str, Option<&str>) {
    let (name, unit) = delimited::name_and_unit(text);
    if text[name.len()..].starts_with(char::is_whitespace) { (name, unit) } else { (text, None) }
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
        InputTable::parse(Path::new("in.csv"), text.as_bytes(), &description(), false)
    }

    #[test]
    fn headers_may_have_units() {
        let described = ModelDescription::parse(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><UnitDefinitions>
            <Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>
            <Unit name="rad/s"><BaseUnit s="-1" rad="1"/></Unit><Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.1"/></Unit>
            </UnitDefinitions><ModelVariables>
            <ScalarVariable name="T" valueReference="1" causality="input"><Real unit="K" displayUnit="degC" start="300"/></ScalarVariable>
            <ScalarVariable name="w[1]" valueReference="2" causality="input"><Real unit="rad/s" start="0"/></ScalarVariable>
            </ModelVariables></fmiModelDescription>"#,
        )
        .unwrap();
        let parse = |text: &str, display_units: bool| {
            InputTable::parse(Path::new("in.csv"), text.as_bytes(), &described, display_units)
        };
        for (text, display_units, expected) in [
            ("time,T [degC],w[1] [rpm]\n0,25,20\n", false, (298.15, 2.0)),
            ("time,T [K],w[1]\n0,25,20\n", false, (25.0, 20.0)),
            ("time,T,w[1]\n0,25,20\n", true, (298.15, 20.0)),
            ("time,T [K],w[1] [rpm]\n0,25,20\n", true, (25.0, 2.0)),
            (
                "\u{feff}time [ms];T [°F];w[1] [deg/s]\n0;77,0;180,0\n500;77;180\n",
                false,
                (298.15, std::f64::consts::PI),
            ),
        ] {
            let table = parse(text, display_units).unwrap();
            let found = (table.after(0, 0.5, 0.0), table.after(1, 0.5, 0.0));
            assert!((found.0 - expected.0).abs() + (found.1 - expected.1).abs() < 1e-12, "{text}: {found:?}");
            assert!(table.times()[0] == 0.0 && table.times().get(1).is_none_or(|t| *t == 0.5));
        }
        let refused = parse("time,T [rpm]\n0,25\n", false).unwrap_err().to_string();
        let expected = r#"in.csv, line 1: column T has the unit "K", and "rpm" is not a unit of the same quantity as "K"; possible are K, degC and other units of the quantity"#;
        assert_eq!(refused, expected);
        for (header, words) in [
            ("w[1]_rpm", "unknown column: w[1]_rpm; a unit stands in brackets, as in w[1] [rpm]"),
            (
                "w[1]_Hz",
                r#"w[1] has the unit "rad/s", and "Hz" is not a unit of the same quantity as "rad/s"; possible are rad/s, rpm and"#,
            ),
            (
                "T_foo",
                r#"and "foo" is not a known unit; possible are K, degC and other units of the quantity"#,
            ),
        ] {
            let refused = parse(&format!("time,{header}\n0,25\n"), false).unwrap_err().to_string();
            assert!(
                refused.starts_with("in.csv, line 1: unknown column") && refused.contains(words),
                "{refused}"
            );
        }
        let refused = parse("time [K],T\n0,25\n", false).unwrap_err().to_string();
        assert!(refused.contains(r#"column time has the unit "s""#), "{refused}");
    }

    #[test]
    fn values_beyond_the_limits_are_passed_on_with_a_note() {
        let table = parse("time,u,n\n0,1,1\n1,11,2\n2,12,3\n").unwrap();
        assert_eq!(table.after(0, 2.0, 1e-9), 12.0);
        let expected =
            "in.csv, line 3: u = 11 is outside its limits -10 ... 10; the value is passed on to the FMU";
        assert_eq!(table.notes(), [expected]);
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
