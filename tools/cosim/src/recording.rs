//! The result of a run: time and outputs, and their CSV file.
use crate::{DisplayUnit, Error, Kind, LogMessage};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Time and outputs of a run, one row for each communication point, the start included.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The model's name.
    pub model_name: String,
    /// Times of the rows (s).
    pub times: Vec<f64>,
    /// The outputs, in the order of the model description. An array gives one column for each element; strings,
    /// binaries and clocks are left out.
    pub columns: Vec<Column>,
    /// Communication steps made.
    pub steps: usize,
    /// Wall time from instantiation to termination (s).
    pub seconds_wall: f64,
    /// The time (s) at which the FMU requested the end of the simulation, if before the stop time.
    pub ended_early: Option<f64>,
    /// The last 1000 messages of the FMU.
    pub messages: Vec<LogMessage>,
}

/// One recorded output.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name of the variable; element i of an array is `name[i]`, counted from 1.
    pub name: String,
    /// Its type. All values are recorded as numbers.
    pub kind: Kind,
    /// Unit of the values.
    pub unit: Option<String>,
    /// The display unit, if the FMU defines one.
    pub display_unit: Option<DisplayUnit>,
    /// One value for each time.
    pub values: Vec<f64>,
    /// The same values without rounding, for 64-bit integers; empty for all other types.
    pub exact: Vec<i128>,
}

impl Column {
    /// The last value as an integer without rounding; `None` for other types.
    pub fn last_integer(&self) -> Option<i128> {
        let rounded = || self.values.last().filter(|_| self.kind.is_integer()).map(|x| *x as i128);
        self.exact.last().copied().or_else(rounded)
    }

    /// The last value, in the display unit, and that unit's name ("" for none).
    pub fn last_shown(&self) -> Option<(f64, &str)> {
        let value = *self.values.last()?;
        Some(match &self.display_unit {
            Some(display) => (display.show(value), &display.name),
            None => (value, self.unit.as_deref().unwrap_or("")),
        })
    }
}

impl Recording {
    /// The column called `name`.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// The first output that is NaN: its name and the time (s) from which on it is.
    pub fn first_nan(&self) -> Option<(&str, f64)> {
        let of = |c: &Column| c.values.iter().position(|x| x.is_nan());
        let rows = self.columns.iter().filter_map(|c| Some((of(c)?, c.name.as_str())));
        rows.min_by_key(|(row, _)| *row).map(|(row, name)| (name, self.times[row]))
    }

    /// Writes `time,<outputs>` and the rows with 17 significant digits, which a reader turns into the same bits.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write_csv(&self, path: &Path) -> Result<(), Error> {
        let io = Error::io("write", path);
        let mut out = BufWriter::new(File::create(path).map_err(&io)?);
        self.csv_to(&mut out).and_then(|()| out.flush()).map_err(io)
    }

    /// The table of [`write_csv`](Self::write_csv) as text.
    pub fn csv(&self) -> String {
        let mut text = Vec::new();
        // Writing to memory does not fail.
        let _ = self.csv_to(&mut text);
        String::from_utf8(text).unwrap_or_default()
    }

    fn csv_to(&self, out: &mut impl Write) -> std::io::Result<()> {
        write!(out, "time")?;
        for column in &self.columns {
            write!(out, ",{}", quoted(&column.name))?;
        }
        writeln!(out)?;
        // The shortest digits that read back as the same number. Formatting with a fixed number of digits took half of a short run.
        let mut digits = zmij::Buffer::new();
        for (row, time) in self.times.iter().enumerate() {
            out.write_all(digits.format(*time).as_bytes())?;
            for column in &self.columns {
                out.write_all(b",")?;
                match column.exact.get(row) {
                    Some(integer) => write!(out, "{integer}")?,
                    None => out.write_all(digits.format(column.values[row]).as_bytes())?,
                }
            }
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// Names such as `a[1,2]` need quotes in CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
