//! Start values by variable: read from TOML tables and from text, in any unit of the quantity.

use super::{PresetError, nearest};
use crate::Experiment;
use physics::declare::{Elements, Kind};
use physics::model::{Declaration, Element, Entry};
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use units::Conversion;

/// Start values that differ from the declared ones, by value reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartValues(pub(super) BTreeMap<u32, f64>);

impl StartValues {
    /// The start value of a variable.
    pub fn of(&self, entry: &Entry) -> f64 {
        self.0.get(&entry.value_reference).copied().unwrap_or(entry.row.start)
    }

    /// Whether a model description with these start values contains the variable: elements up to the number that the
    /// structural parameter gives.
    pub fn shows(&self, declaration: &Declaration, entry: &Entry) -> bool {
        match entry.element {
            Some(Element { index, of: Elements::UpTo(_, parameter), .. }) => {
                declaration.by_name(parameter).is_some_and(|count| f64::from(index) <= self.of(count))
            }
            _ => true,
        }
    }

    /// The values of a TOML text with tables for several models, in the order of `tables` (name of the table, declaration
    /// of the model). A missing table has no values. A table of `others` is left to `other`.
    ///
    /// # Errors
    /// A line for each error with file and line: invalid TOML, an unknown table, and all errors of a preset.
    pub fn of_tables(
        text: &str,
        file: &str,
        tables: &[(&str, &'static Declaration)],
        others: &[&str],
        mut other: impl FnMut(&str, &Spanned<DeValue<'_>>, &mut Source<'_>),
    ) -> Result<Vec<StartValues>, PresetError> {
        let mut source = Source::new(text, file);
        let mut found = vec![StartValues::default(); tables.len()];
        let table = source.table();
        for (key, value) in table.get_ref() {
            let place = tables.iter().position(|(name, _)| *name == key.get_ref().as_ref());
            if let (Some(place), DeValue::Table(values)) = (place, value.get_ref()) {
                found[place] = StartValues::of_table(tables[place].1, values, &mut source);
                continue;
            }
            if others.contains(&key.get_ref().as_ref()) {
                other(key.get_ref(), value, &mut source);
                continue;
            }
            let names = tables.iter().map(|(name, _)| name).chain(others);
            let known: Vec<String> = names.map(|name| format!("[{name}]")).collect();
            source.error(
                key.span().start,
                format!("{} is not one of the tables {}", key.get_ref(), known.join(", ")),
            );
        }
        source.finish(found)
    }

    /// The values of a table; its errors go to `source`.
    pub(super) fn of_table(
        declaration: &'static Declaration,
        table: &DeTable<'_>,
        source: &mut Source<'_>,
    ) -> StartValues {
        let mut starts = StartValues::default();
        for (key, value) in table {
            let Some(entry) = declaration.by_name(key.get_ref()) else {
                source.error(key.span().start, with_dot(declaration, key.get_ref(), value.get_ref()));
                continue;
            };
            match number(entry, value) {
                Ok(number) => {
                    starts.0.insert(entry.value_reference, number);
                }
                // A value that broken TOML hides has no place of its own.
                Err(message) => source.error(value.span().start.max(key.span().start), message),
            }
        }
        starts
    }

    /// Gives the start value of a variable, which the caller has checked.
    pub fn set(&mut self, entry: &Entry, value: f64) {
        self.0.insert(entry.value_reference, value);
    }

    /// Whether a start value of the variable is given.
    pub fn names(&self, entry: &Entry) -> bool {
        self.0.contains_key(&entry.value_reference)
    }

    /// Value references and values, ascending.
    pub fn entries(&self) -> Vec<(u32, f64)> {
        self.0.iter().map(|(k, v)| (*k, *v)).collect()
    }
}

/// One sentence about an unknown name. In TOML a name with a dot and without quotation marks is a table.
fn with_dot(declaration: &Declaration, name: &str, value: &DeValue<'_>) -> String {
    let DeValue::Table(table) = value else { return unknown(declaration, name) };
    let mut whole = table.keys().map(|key| format!("{name}.{}", key.get_ref()));
    let starts = |whole: &String| declaration.entries.iter().any(|e| e.name.starts_with(whole.as_str()));
    match whole.find(starts) {
        Some(whole) => format!("names with a dot need quotation marks: \"{whole}\" = ..."),
        None => unknown(declaration, name),
    }
}

/// A TOML text with the errors that were found in it so far.
pub struct Source<'a> {
    text: &'a str,
    file: &'a str,
    /// Offset and sentence of each error.
    errors: Vec<(usize, String)>,
    /// Lines that are not TOML: one error each.
    broken: Vec<(usize, String)>,
}

impl<'a> Source<'a> {
    /// A text of a file.
    pub fn new(text: &'a str, file: &'a str) -> Source<'a> {
        Source { text, file, errors: Vec::new(), broken: Vec::new() }
    }

    /// The table, without the lines that are not TOML.
    pub fn table(&mut self) -> Spanned<DeTable<'a>> {
        let (table, errors) = DeTable::parse_recoverable(self.text);
        for e in errors {
            self.broken.push((e.span().map_or(0, |s| s.start), e.message().replace('\n', " ")));
        }
        table
    }

    /// Notes an error at an offset in the text.
    pub fn error(&mut self, offset: usize, sentence: String) {
        self.errors.push((offset, sentence));
    }

    /// What was found, if there was no error; else a line for each, in the order of the file.
    ///
    /// # Errors
    /// The errors that were noted.
    pub fn finish<T>(self, found: T) -> Result<T, PresetError> {
        let line = |offset: usize| {
            1 + self.text.as_bytes()[..offset.min(self.text.len())].iter().filter(|b| **b == b'\n').count()
        };
        let mut errors: Vec<(usize, &String)> =
            self.broken.iter().map(|(at, what)| (line(*at), what)).collect();
        errors.dedup_by_key(|e| e.0);
        let broken: Vec<usize> = errors.iter().map(|e| e.0).collect();
        let others = self.errors.iter().map(|(at, what)| (line(*at), what));
        errors.extend(others.filter(|(line, _)| !broken.contains(line)));
        errors.sort_by_key(|e| e.0);
        if errors.is_empty() {
            return Ok(found);
        }
        let lines: Vec<String> =
            errors.iter().map(|(line, what)| format!("{}:{line}: {what}", self.file)).collect();
        Err(PresetError(lines.join("\n")))
    }
}

/// One sentence about an unknown name, with the most similar known one.
pub fn unknown(declaration: &Declaration, name: &str) -> String {
    if let Some(sentence) = declaration.unserved(name) {
        return sentence;
    }
    let hint = nearest(name, declaration.entries.iter().map(|e| e.name.as_str()));
    format!("{} has no variable {name}{hint}", declaration.name)
}

/// The value of a variable in SI units, from text: a number with or without unit, the name of an item, true or false. A number
/// without unit is in SI units, with `display` in the unit in which the variable is displayed (degC, rpm).
///
/// # Errors
/// One sentence with name, value, unit or limits.
pub fn from_text(entry: &Entry, text: &str, display: bool) -> Result<f64, String> {
    let name = &entry.name;
    let value = match (entry.row.kind, text.trim()) {
        (Kind::Enumeration(t), item) => match t.items.iter().find(|i| i.name == item) {
            Some(item) => f64::from(item.value),
            None => item.parse().map_err(|_| {
                let names: Vec<&str> = t.items.iter().map(|i| i.name).collect();
                format!(
                    "{name} = {item} is not one of {}{}",
                    names.join(", "),
                    nearest(item, names.iter().copied())
                )
            })?,
        },
        (Kind::Boolean, "true") => 1.0,
        (Kind::Boolean, "false") => 0.0,
        (Kind::Boolean, other) => {
            other.parse().map_err(|_| format!("{name} = {other} is not true or false"))?
        }
        (Kind::Real | Kind::Integer, text) => {
            let (number, unit) = match text.parse::<f64>() {
                Ok(number) => (number, ""),
                Err(_) => {
                    units::split(text).ok_or_else(|| not_a_number(entry, &format!("{name} = {text}")))?
                }
            };
            let shown = entry.row.unit.display().filter(|_| display).map_or("", |d| d.name);
            in_si(entry, number, if unit.is_empty() { shown } else { unit })?
        }
    };
    checked(entry, value)
}

/// The sentence about a value that is no number.
fn not_a_number(entry: &Entry, subject: &str) -> String {
    let unit = match entry.row.unit.name() {
        "1" => String::new(),
        unit => format!(" in {unit}"),
    };
    let (low, high) = (entry.row.min, entry.row.max);
    format!("{subject} is not a number{unit}; it must lie in {low} ... {high}")
}

/// A number of a unit in SI units; an empty unit is that of the variable.
fn in_si(entry: &Entry, number: f64, unit: &str) -> Result<f64, String> {
    if unit.is_empty() {
        return Ok(number);
    }
    Ok(conversion(&entry.name, unit, entry.row.unit.name(), entry.row.relative)?.of(number))
}

/// The conversion of numbers in `unit` to the unit `own` of the variable `name`; of differences, without offset, if `relative`.
///
/// # Errors
/// One sentence about a unit that does not fit.
pub fn conversion(name: &str, unit: &str, own: &str, relative: bool) -> Result<Conversion, String> {
    units::conversion(unit, own, relative)
        .map_err(|refusal| format!("{name} has the unit \"{own}\", not \"{unit}\": {refusal}"))
}

fn checked(entry: &Entry, number: f64) -> Result<f64, String> {
    entry
        .check(number, false)
        .map_err(|refusal| entry.explain(number, &refusal).trim_end_matches('.').to_string())?;
    Ok(number)
}

/// The checked number of a value in a preset, in SI units.
fn number(entry: &Entry, value: &Spanned<DeValue<'_>>) -> Result<f64, String> {
    let name = &entry.name;
    let mut unit = "";
    let value = match value.get_ref() {
        DeValue::Table(table) => {
            if let Some(key) = table.keys().find(|key| !matches!(key.get_ref().as_ref(), "value" | "unit")) {
                return Err(format!(
                    "{name} has the unknown key {}; the keys are value and unit",
                    key.get_ref()
                ));
            }
            unit = match table.get("unit").map(|u| u.get_ref()) {
                Some(DeValue::String(given)) => given.as_ref(),
                Some(_) => return Err(format!("the unit of {name} is not a string")),
                None => "",
            };
            table.get("value").ok_or_else(|| format!("{name} has no value"))?.get_ref()
        }
        plain => plain,
    };
    let plain = match (value, entry.row.kind) {
        (DeValue::Float(text), _) => text.as_str().replace('_', "").parse::<f64>().ok(),
        (DeValue::Integer(text), _) => {
            i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n as f64)
        }
        (DeValue::Boolean(flag), Kind::Boolean) => Some(f64::from(u8::from(*flag))),
        (DeValue::String(text), _) if unit.is_empty() => return from_text(entry, text, false),
        _ => None,
    };
    let plain = plain.ok_or_else(|| not_a_number(entry, &format!("the value of {name}")))?;
    checked(entry, in_si(entry, plain, unit)?)
}

/// The default experiment of a table with `stop` and `step`, numbers in s or texts with a unit; its errors go to `source`.
pub(super) fn experiment(table: &DeTable<'_>, source: &mut Source<'_>) -> Experiment {
    let mut found = Experiment::default();
    for (key, value) in table {
        let (name, at) = (key.get_ref().as_ref(), value.span().start.max(key.span().start));
        let place = match name {
            "stop" => &mut found.stop,
            "step" => &mut found.step,
            _ => {
                source.error(
                    key.span().start,
                    format!("{name} is not a key of [experiment]; the keys are stop and step"),
                );
                continue;
            }
        };
        match seconds(value.get_ref()) {
            Some(seconds) if seconds > 0.0 && seconds.is_finite() => *place = seconds,
            _ => source
                .error(at, format!("{name} is not a time above 0, in s or as text with a unit (\"10 min\")")),
        }
    }
    if found.step > found.stop {
        let sentence = format!("step = {} s is longer than stop = {} s", found.step, found.stop);
        source.error(table.values().map(|value| value.span().start).max().unwrap_or(0), sentence);
    }
    found
}

/// A time of a value, s.
fn seconds(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(text) => text.as_str().replace('_', "").parse().ok(),
        DeValue::Integer(text) => i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n as f64),
        DeValue::String(text) => {
            let (number, unit) = units::split(text)?;
            units::conversion(unit, "s", false).ok().map(|conversion| conversion.of(number))
        }
        _ => None,
    }
}
