//! Comparison of the FMU's results with the reference results in its archive (layered standard `org.fmi-standard.fmi-ls-ref`).

use super::*;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::validate::xml::{Xml, decode};
use cosim::xml::{parse_boolean, parse_double};

/// Where the files are.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
const MANIFEST: &str = "fmi-ls-manifest.xml";
/// Tolerance for another solver, relative to the range and to the magnitude of a result.
const TOLERATED: f64 = 0.005;
const ROUNDING: f64 = 1e-5;
/// Relative tolerance of a solver, unless the default experiment has a smaller one.
const SOLVER: f64 = 1e-6;
/// Time limit of the comparison of long runs.
const PATIENCE: Duration = Duration::from_secs(10);

/// A table of numbers over time.
struct Table {
    names: Vec<String>,
    /// Each begins with its time, s.
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// `None` unless the file is a header and rows with ascending time.
    fn read(path: &Path) -> Option<Table> {
        let text = std::fs::read_to_string(path).ok()?;
        let mut lines = text.trim_start_matches('\u{feff}').lines().filter(|l| !l.trim().is_empty());
        let mut names = cells(lines.next()?);
        if !names.remove(0).eq_ignore_ascii_case("time") {
            return None;
        }
        // Texts and lists are not compared.
        let rows: Vec<Vec<f64>> =
            lines.map(|l| cells(l).iter().map(|c| number(c).unwrap_or(f64::NAN)).collect()).collect();
        let is_table =
            rows.iter().all(|r| r.len() == names.len() + 1) && rows.is_sorted_by(|a, b| a[0] <= b[0]);
        (is_table && !rows.is_empty()).then_some(Table { names, rows })
    }

    /// The value of a column at a time: on a line between rows if it is continuous, after the jump where two rows have
    /// the same time.
    fn at(&self, column: usize, t: f64, is_continuous: bool) -> f64 {
        let after = self.rows.partition_point(|r| r[0] <= t + 1e-9 * t.abs().max(1e-3));
        let row = &self.rows[after.saturating_sub(1)];
        match self.rows.get(after).filter(|_| is_continuous && after > 0) {
            Some(next) => {
                row[column] + (next[column] - row[column]) * ((t - row[0]) / (next[0] - row[0])).max(0.0)
            }
            None => row[column],
        }
    }
}

/// The cells of a line; names may be in quotes.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    let mut chars = line.trim().chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            // Two quotes within quotes are one.
            '"' if quoted && chars.peek() == Some(&'"') => {
                cells.last_mut().expect("there is a first cell").extend(chars.next())
            }
            '"' => quoted = !quoted,
            ',' | ';' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("there is a first cell").push(c),
        }
    }
    cells.iter().map(|c| c.trim().to_owned()).collect()
}

fn number(cell: &str) -> Option<f64> {
    parse_double(cell).or_else(|| parse_boolean(cell).map(|b| f64::from(u8::from(b))))
}

/// Whether the FMU contains reference results.
pub(super) fn is_there(subject: &Subject) -> bool {
    subject.archive.dir().join(FOLDER).join(MANIFEST).is_file()
}

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let folder = subject.archive.dir().join(FOLDER);
    let place = format!("{FOLDER}/{MANIFEST}");
    let Ok(bytes) = std::fs::read(folder.join(MANIFEST)) else { return Ok(()) };
    let Some(text) = decode(&place, &bytes, &mut Findings::new()) else { return Ok(()) };
    let Some(xml) = Xml::parse(&place, &text, &mut Findings::new()) else { return Ok(()) };
    let (mut results, mut inputs) = (Vec::new(), None);
    for related in xml.root().children().filter(|c| c.has_tag_name("Related")) {
        let Some(source) =
            related.attribute("source").filter(|_| related.attribute("type") == Some("text/csv"))
        else {
            continue;
        };
        match (related.attribute("role"), Table::read(&folder.join(source))) {
            (Some("result"), Some(table)) => results.push((source.to_owned(), table)),
            (Some("testcase" | "input"), Some(table)) => inputs = Some(table),
            (_, None) => seen.add(&xml.place(related), rules::reference_file(short(source))),
            _ => {}
        }
    }
    let has_inputs = facts.variables.iter().any(|v| v.is("input"));
    // Without their inputs, results cannot be compared.
    if has_inputs && inputs.is_none() {
        return Ok(());
    }
    let is_blank = |table: &Table, (i, name): (usize, &String)| {
        find(facts, name).is_some_and(|v| v.is("input"))
            && table.rows.iter().any(|row| !row[i + 1].is_finite())
    };
    if let Some(table) = &inputs
        && table.names.iter().enumerate().any(|column| is_blank(table, column))
    {
        seen.add(&place, rules::reference_input_not_finite());
        return Ok(());
    }
    for (source, table) in results {
        compare(subject, &format!("{FOLDER}/{source}"), &table, inputs.as_ref(), seen)?;
    }
    Ok(())
}

fn find<'a>(facts: &'a Facts, name: &str) -> Option<&'a Variable> {
    facts.variables.iter().find(|v| v.name == name && v.size == 1 && v.kind.is_numeric() && !v.clocked)
}

fn compare(
    subject: &Subject,
    place: &str,
    table: &Table,
    inputs: Option<&Table>,
    seen: &mut Seen,
) -> Result<(), Fault> {
    let facts = subject.facts;
    let columns: Vec<(usize, &Variable)> = table
        .names
        .iter()
        .enumerate()
        .filter_map(|(i, name)| {
            Some((i + 1, find(facts, name).filter(|v| v.is_continuous() && !v.is("input"))?))
        })
        .collect();
    let variables: Vec<&Variable> = columns.iter().map(|(_, v)| *v).collect();
    // The element `a[1]` is one of the variable `a`.
    let is_known = |name: &str| {
        let base = name.split_once('[').map_or(name, |(base, _)| base);
        facts.variables.iter().any(|v| v.name == name || v.name == base)
    };
    if let Some(name) = table.names.iter().find(|name| !name.is_empty() && !is_known(name)) {
        seen.add(place, rules::reference_column(short(name)));
    }
    let numbers = table.names.iter().enumerate();
    for (column, v) in numbers.filter_map(|(i, name)| Some((i + 1, find(facts, name)?))) {
        if let Some(row) = table.rows.iter().find(|row| !row[column].is_finite()) {
            seen.add(place, rules::reference_not_finite(v, row[0]));
        }
    }
    let range = |column: usize| {
        let values = || table.rows.iter().map(|r| r[column]).filter(|x| x.is_finite());
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        TOLERATED * (high - low) + ROUNDING * high.abs().max(low.abs())
    };
    // A variable may be the difference of others of its unit, which have the tolerance of a solver.
    let largest = |column: usize| table.rows.iter().map(|r| r[column].abs()).fold(0.0, f64::max);
    let of_unit = largest_of_unit(columns.iter().map(|(c, v)| (*v, largest(*c))));
    let tolerance = facts.tolerance.unwrap_or(SOLVER).min(SOLVER);
    let rooms: Vec<f64> =
        columns.iter().map(|(c, v)| range(*c).max(tolerance * v.nominal.max(of_unit(v)))).collect();
    let started = Instant::now();
    let mut session = subject.instance("probe")?;
    session.setup(None)?;
    session.enter(None)?;
    feed(&mut session, inputs)?;
    session.leave()?;
    for row in &table.rows {
        if started.elapsed() > PATIENCE || !reach(&mut session, row[0], inputs)? {
            return Ok(());
        }
        // A row at a discontinuity of the inputs may be before or after it.
        if inputs
            .is_some_and(|i| i.rows.windows(2).any(|w| w[0][0] == w[1][0] && (w[0][0] - row[0]).abs() < 1e-9))
        {
            continue;
        }
        feed(&mut session, inputs)?;
        let values = session.get_all(&variables)?;
        for (((column, v), value), room) in columns.iter().zip(values).zip(&rooms) {
            let wanted = row[*column];
            let is_near = (value - wanted).abs() <= *room;
            if !is_near && !wanted.is_nan() {
                seen.add(place, rules::reference_differs(v, value, row[0], wanted));
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Sets the inputs that the table has for the session's time.
fn feed(session: &mut Session, inputs: Option<&Table>) -> Result<(), Fault> {
    let Some(table) = inputs else { return Ok(()) };
    let (facts, t) = (session.facts, session.now);
    for (i, name) in table.names.iter().enumerate() {
        if let Some(v) = find(facts, name).filter(|v| v.is("input")) {
            session.set(v, &[table.at(i + 1, t, v.is_continuous())])?;
        }
    }
    Ok(())
}

/// Steps to a time; `false` when the FMU ends before or does not take the last part of a step.
fn reach(session: &mut Session, t: f64, inputs: Option<&Table>) -> Result<bool, Fault> {
    let h = session.facts.step();
    let from = session.now;
    let whole = ((t - from) / h * (1.0 + 1e-9)).floor();
    for k in 0..whole.max(0.0) as u64 {
        session.now = from + h * k as f64;
        feed(session, inputs)?;
        if !session.step(h)? {
            return Ok(false);
        }
    }
    session.now = from + h * whole.max(0.0);
    let rest = t - session.now;
    if rest > 1e-6 * h {
        if !session.interface.can_handle_variable_step || session.interface.fixed_internal_step_size.is_some()
        {
            return Ok(false);
        }
        feed(session, inputs)?;
        if !session.step(rest)? {
            return Ok(false);
        }
    }
    session.now = t;
    Ok(true)
}
