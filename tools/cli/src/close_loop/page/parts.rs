//! A run, or the part of it that ends or begins at a gap, as the figures show it.

use calibrate::experiment::{Experiment, Run, Table};
use calibrate::outcome::{Curve, Curves};
use calibrate::report::role_words;

/// The data of a report.
#[derive(Clone, Copy)]
pub struct Data<'a> {
    /// With the readings that were used.
    pub used: &'a Experiment,
    /// As read from the files, before the checks set readings aside.
    pub read: &'a Experiment,
}

/// Fewer readings than this are a table, not a line.
const FEW: usize = 5;

/// One run of the figures with its data.
#[derive(Clone, Copy)]
pub struct Part<'a> {
    /// The values of the figures.
    pub curves: &'a Curves,
    /// Its rows.
    pub run: &'a Run,
    read: Option<&'a Table>,
    is_only: bool,
}

impl<'a> Part<'a> {
    /// All runs of the figures.
    pub fn all(data: Data<'a>, curves: &'a [Curves]) -> Vec<Part<'a>> {
        let of = |own: &'a Curves| {
            let run = data.used.runs.get(own.run)?;
            let same = |other: &&Run| (&other.file, other.role) == (&run.file, run.role);
            let mut read = data.read.runs.iter().filter(|r| r.file == run.file);
            let is_only = data.used.runs.iter().filter(same).count() == 1;
            Some(Part { curves: own, run, read: read.next().map(|r| &r.table), is_only })
        };
        curves.iter().filter_map(of).collect()
    }

    /// Time of the first row, s.
    pub fn start(&self) -> f64 {
        self.run.table.time[0]
    }

    /// From the first to the last row, s.
    pub fn length(&self) -> f64 {
        self.run.table.time[self.run.table.time.len() - 1] - self.start()
    }

    /// File and role, with the clock of the file where it does not begin at zero, or where the file has several runs of the role.
    pub fn heading(&self) -> String {
        let role = role_words(self.curves.role);
        if self.is_only && self.start() == 0.0 {
            return format!("{} ({role})", self.curves.file);
        }
        let (from, to) = self.run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let (first, last) = (self.start(), self.start() + self.length());
        // The window is what two runs of a file differ in; one run is simulated from its first row.
        let (from, to) = if self.is_only { (first, last) } else { (first.max(from), last.min(to)) };
        format!("{}, clock from {from} s to {to} s ({role})", self.curves.file)
    }

    /// Whether a time counts in the role of the run.
    pub fn counts(&self, time: f64) -> bool {
        let (from, to) = self.curves.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        (from..=to).contains(&time)
    }

    /// Number of readings of an output that count.
    pub fn readings(&self, curve: &Curve) -> usize {
        let rows = self.curves.time.iter().zip(&curve.measured);
        rows.filter(|(t, x)| x.is_finite() && self.counts(**t)).count()
    }

    /// Whether these are readings for a line.
    pub fn is_line(&self, curve: &Curve) -> bool {
        self.readings(curve) >= FEW
    }

    /// Whether an output has a few readings only.
    pub fn is_sparse(&self, curve: &Curve) -> bool {
        let count = curve.measured.iter().filter(|x| x.is_finite()).count();
        (1..FEW).contains(&count)
    }

    /// First and last time of each gap, s, by the rule of the checks.
    pub fn gaps(&self) -> Vec<(f64, f64)> {
        let time = &self.run.table.time;
        self.run
            .table
            .gaps()
            .filter(|row| row + 1 < time.len())
            .map(|row| (time[row], time[row + 1]))
            .collect()
    }

    /// Values of the rows of the figures over the time since the start, interrupted at gaps.
    pub fn line(&self, values: impl IntoIterator<Item = f64>) -> Vec<(f64, f64)> {
        let (gaps, time, start) = (self.gaps(), &self.curves.time, self.start());
        let mut points = Vec::new();
        for (k, value) in values.into_iter().enumerate().take(time.len()) {
            let before = k.checked_sub(1).map(|before| time[before]);
            if before.is_some_and(|before| gaps.iter().any(|gap| before <= gap.0 && gap.1 <= time[k])) {
                points.push((time[k] - start, f64::NAN));
            }
            points.push((time[k] - start, value));
        }
        points
    }

    /// Values of a column of the data at the rows of the figures, in SI units.
    pub fn column(&self, k: usize) -> Vec<f64> {
        let table = &self.run.table;
        let at = |t: &f64| {
            table.time.binary_search_by(|x| x.total_cmp(t)).map_or(f64::NAN, |row| table.columns[k][row])
        };
        self.curves.time.iter().map(at).collect()
    }

    /// Readings of a column that were set aside, in SI units, over the time since the start.
    pub fn set_aside(&self, k: usize) -> Vec<(f64, f64)> {
        let (Some(read), used) = (self.read, &self.run.table) else { return Vec::new() };
        let rows = used.time.iter().zip(&used.columns[k]).filter(|(_, x)| x.is_nan());
        let reading = |(t, _): (&f64, &f64)| {
            let row = read.time.binary_search_by(|x| x.total_cmp(t)).ok()?;
            let value = read.columns[k][row];
            value.is_finite().then_some((t - self.start(), value))
        };
        rows.filter_map(reading).collect()
    }
}
