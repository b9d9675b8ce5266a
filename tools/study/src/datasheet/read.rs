//! A datasheet from a TOML file and from text.
//!
//! ```toml
//! name = "my-motor"
//! description = "..."
//! source = "catalogue 2024, page 123"
//! [datasheet]
//! no_load_current = 68.6                                   # in the datasheet's unit, mA
//! torque_constant = { value = 60.3, unit = "mNm/A" }
//! terminal_inductance = "0.33 mH"
//! ```

use super::quantities::{QUANTITIES, Quantity, by_key};
use super::{Datasheet, Value};
use crate::StudyError;
use describe::preset::{Source, nearest};
use std::path::Path;
use toml::de::DeValue;
use units::{conversion, split};

impl Datasheet {
    /// From a file.
    ///
    /// # Errors
    /// A line for each error, with file and line.
    pub fn read(path: &Path) -> Result<Datasheet, StudyError> {
        let file = path.display().to_string();
        let text = delimited::read_text(path)
            .map_err(|e| StudyError::new(format!("the datasheet {file} cannot be read ({e})")))?;
        Datasheet::parse(&text, &file)
    }

    /// From the text of a file; `file` names it in errors.
    ///
    /// # Errors
    /// As [`read`](Datasheet::read).
    pub fn parse(text: &str, file: &str) -> Result<Datasheet, StudyError> {
        let mut source = Source::new(text, file);
        let table = source.table();
        let mut sheet = Datasheet::default();
        for (key, value) in table.get_ref() {
            let at = value.span().start.max(key.span().start);
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("name", DeValue::String(word)) => sheet.name = word.to_string(),
                ("description", DeValue::String(word)) => sheet.description = word.to_string(),
                ("source", DeValue::String(word)) => sheet.source = word.to_string(),
                (known @ ("name" | "description" | "source"), _) => {
                    source.error(at, format!("{known} must be a string"));
                }
                ("datasheet", DeValue::Table(values)) => {
                    for (key, value) in values {
                        let at = value.span().start.max(key.span().start);
                        let found = quantity(key.get_ref()).and_then(|q| of_toml(q, value.get_ref()));
                        match found {
                            // Two names of one quantity.
                            Ok(value) if sheet.get(value.quantity.key).is_some() => {
                                source.error(at, format!("{} is given twice", value.quantity.key));
                            }
                            Ok(value) => sheet.put(value),
                            Err(sentence) => source.error(at, sentence),
                        }
                    }
                }
                (other, _) => {
                    let keys = "the keys are name, description, source and [datasheet]";
                    source.error(key.span().start, format!("{other} is not a key of a datasheet; {keys}"));
                }
            }
        }
        Ok(source.finish(sheet)?)
    }
}

fn quantity(key: &str) -> Result<&'static Quantity, String> {
    by_key(key).ok_or_else(|| {
        let names = QUANTITIES.iter().flat_map(|q| std::iter::once(&q.key).chain(q.aliases));
        let near = nearest(key, names.copied());
        format!(
            "{key} is not a quantity from which a start value follows; `motor-fmu preset new --help` lists these, leave out others{near}"
        )
    })
}

impl Value {
    /// From text: a number in the datasheet's unit, or with its unit.
    ///
    /// # Errors
    /// One sentence with name, value and unit.
    pub fn parse(quantity: &'static Quantity, text: &str) -> Result<Value, String> {
        let (number, unit) = split(text).ok_or_else(|| {
            let Quantity { key, unit, .. } = quantity;
            format!("{key} = {text} is not a number in {unit} or a number with its unit")
        })?;
        Value::new(quantity, number, if unit.is_empty() { quantity.unit } else { unit })
    }

    fn new(quantity: &'static Quantity, number: f64, unit: &str) -> Result<Value, String> {
        let Quantity { key, si, unit: usual, .. } = *quantity;
        let conversion = conversion(unit, si, false)
            .map_err(|refusal| format!("{key} has a unit such as \"{usual}\", not \"{unit}\": {refusal}"))?;
        let converted = conversion.of(number);
        if !(converted.is_finite() && converted > 0.0) {
            return Err(format!("{key} = {number} {unit} is not a positive number"));
        }
        let multiple_of = if key == "poles" { 2.0 } else { 1.0 };
        if matches!(key, "pole_pairs" | "poles") && converted % multiple_of != 0.0 {
            let kind = if key == "poles" { "an even" } else { "a whole" };
            return Err(format!("{key} = {number} is not {kind} number"));
        }
        if key == "max_efficiency" && !(0.01..=1.0).contains(&converted) {
            return Err(format!(
                "{key} = {number} {unit} is not within 1 ... 100 %; a number without unit is in per cent, a fraction has the unit \"1\""
            ));
        }
        Ok(Value { quantity, si: converted, given: (number, unit.to_owned()) })
    }
}

fn of_toml(quantity: &'static Quantity, value: &DeValue<'_>) -> Result<Value, String> {
    let key = quantity.key;
    let number = |value: &DeValue<'_>| match value {
        DeValue::Float(text) => text.as_str().replace('_', "").parse::<f64>().ok(),
        DeValue::Integer(text) => i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n as f64),
        _ => None,
    };
    match value {
        DeValue::String(text) => Value::parse(quantity, text),
        DeValue::Table(table) => {
            if let Some(other) = table.keys().find(|k| !matches!(k.get_ref().as_ref(), "value" | "unit")) {
                return Err(format!(
                    "{key} has the unknown key {}; the keys are value and unit",
                    other.get_ref()
                ));
            }
            let unit = match table.get("unit").map(|u| u.get_ref()) {
                Some(DeValue::String(unit)) => unit.as_ref(),
                None => quantity.unit,
                Some(_) => return Err(format!("the unit of {key} is not a string")),
            };
            let found = table.get("value").and_then(|v| number(v.get_ref()));
            Value::new(quantity, found.ok_or_else(|| format!("{key} has no value that is a number"))?, unit)
        }
        plain => {
            let found = number(plain).ok_or_else(|| format!("{key} is not a number"))?;
            Value::new(quantity, found, quantity.unit)
        }
    }
}
