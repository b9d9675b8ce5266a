//! The table `[mix]` of a load file: its period and its phases.

use crate::StudyError;
use describe::preset::Source;
use toml::Spanned;
use toml::de::DeValue;
use units::{conversion, split};

/// Period of a mix that gives none, s.
const PERIOD: f64 = 600.0;
/// How far the sum of the fractions may be from 1.
const SUM: f64 = 1e-3;

/// A phase of a mix; `L` is a load.
#[derive(Clone)]
pub(super) struct Phase<L> {
    /// Fraction of the period.
    pub fraction: f64,
    /// No current and no motion.
    pub rest: bool,
    /// Another load file.
    pub file: Option<String>,
    /// Values that differ from those of the file.
    pub sets: Vec<(String, String)>,
    /// The load of the phase.
    pub load: Option<Box<L>>,
}

/// A mix of phases.
#[derive(Clone)]
pub(super) struct MixFile<L> {
    /// s.
    pub period: f64,
    pub phases: Vec<Phase<L>>,
}

impl<L> MixFile<L> {
    /// From the table; errors go to `source`.
    pub fn read(value: &Spanned<DeValue<'_>>, source: &mut Source<'_>) -> Option<MixFile<L>> {
        match mix(value.get_ref()) {
            Ok(found) => Some(found),
            Err(sentence) => {
                source.error(value.span().start, format!("[mix]: {sentence}"));
                None
            }
        }
    }

    /// Makes the loads of the phases.
    pub fn load(&mut self, make: impl Fn(&Phase<L>) -> Result<L, StudyError>) -> Result<(), StudyError> {
        for phase in &mut self.phases {
            phase.load = Some(Box::new(make(phase)?));
        }
        Ok(())
    }
}

fn mix<L>(value: &DeValue<'_>) -> Result<MixFile<L>, String> {
    let DeValue::Table(table) = value else { return Err("it must be a table".to_owned()) };
    let mut found = MixFile { period: PERIOD, phases: Vec::new() };
    for (key, value) in table {
        match (key.get_ref().as_ref(), value.get_ref()) {
            ("period", value) => {
                found.period =
                    quantity(value, "s").filter(|p| *p > 0.0).ok_or("period must be a positive time")?;
            }
            ("phase", DeValue::Array(phases)) => {
                found.phases = phases.iter().map(|p| phase(p.get_ref())).collect::<Result<_, _>>()?;
            }
            (other, _) => {
                return Err(format!(
                    "{other} is not a key; the keys are period and phase (a list of tables)"
                ));
            }
        }
    }
    if found.phases.is_empty() {
        return Err("it has no phase; the key phase is a list of tables".to_owned());
    }
    let sum: f64 = found.phases.iter().map(|p| p.fraction).sum();
    if (sum - 1.0).abs() > SUM {
        return Err(format!("the fractions of its {} phases add up to {sum}, not to 1", found.phases.len()));
    }
    if found.phases.iter().all(|p| p.rest) {
        return Err("no phase has a load".to_owned());
    }
    Ok(found)
}

fn phase<L>(value: &DeValue<'_>) -> Result<Phase<L>, String> {
    let DeValue::Table(table) = value else { return Err("a phase must be a table".to_owned()) };
    let mut found = Phase { fraction: f64::NAN, rest: false, file: None, sets: Vec::new(), load: None };
    for (key, value) in table {
        match (key.get_ref().as_ref(), value.get_ref()) {
            ("fraction", value) => {
                let fraction = quantity(value, "1").filter(|f| *f > 0.0 && *f <= 1.0);
                found.fraction = fraction.ok_or("fraction must be within 0 ... 1, or in %")?;
            }
            ("rest", DeValue::Boolean(rest)) => found.rest = *rest,
            ("load", DeValue::String(file)) => found.file = Some(file.to_string()),
            (name, value) => {
                let text = text(value).ok_or_else(|| format!("{name} must be a string or a number"))?;
                found.sets.push((name.to_owned(), text));
            }
        }
    }
    if found.fraction.is_nan() {
        return Err("a phase has no fraction".to_owned());
    }
    if found.rest && (found.file.is_some() || !found.sets.is_empty()) {
        return Err("a phase of rest has no load and no values".to_owned());
    }
    Ok(found)
}

fn text(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Float(text) => Some(text.as_str().replace('_', "")),
        DeValue::Integer(text) => {
            i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n.to_string())
        }
        DeValue::Boolean(flag) => Some(flag.to_string()),
        _ => None,
    }
}

/// A number in a unit, or a text with a unit.
fn quantity(value: &DeValue<'_>, unit: &str) -> Option<f64> {
    let text = text(value)?;
    let (number, given) = split(&text)?;
    Some(if given.is_empty() { number } else { conversion(given, unit, false).ok()?.of(number) })
}
