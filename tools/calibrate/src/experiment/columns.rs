//! `[columns]`: headers of a file, their quantities and units.

use super::Place;
use super::channel::{CHANNELS, Channel, suffix};
use super::units::{self, FileUnit};
use crate::CalibrateError;
use physics::declare::Unit;
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// The time column in files, and its quantity.
pub const TIME: &str = "time_s";
const TIME_QUANTITY: &str = "time";

/// A header of a file and the corresponding column of the contract.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The header in the file.
    pub header: String,
    /// The name of the column in the contract.
    pub column: &'static str,
    /// Its unit in the file.
    pub unit: FileUnit,
    /// The name of this unit.
    pub unit_name: String,
    /// Whether the experiment or the header states this unit; otherwise it is that of the column of the contract.
    pub is_stated: bool,
}

/// Reads the columns of `[columns]`.
pub fn read(table: &BTreeMap<Spanned<String>, Value>, place: &Place) -> Result<Vec<Column>, CalibrateError> {
    let one = |(header, value): (&Spanned<String>, &Value)| {
        let at = header.span().start;
        let (name, unit) = parts(value).map_err(|sentence| place.at(at, &sentence))?;
        let (column, si) = quantity(name).ok_or_else(|| {
            let mut known: Vec<&str> = vec![TIME_QUANTITY];
            known.extend(CHANNELS.iter().filter(|c| c.is_usual).map(Channel::quantity));
            // A channel has one entry per model; the entries are adjacent.
            known.dedup();
            place.at(
                at,
                &format!(
                    "{name} is no quantity of a bench; there is {}, and every input and output of the model; a further sensor of an output has a number, as housing_temperature_2",
                    known.join(", ")
                ),
            )
        })?;
        // The text in brackets may also be a remark.
        let in_brackets =
            delimited::name_and_unit(header.get_ref()).1.filter(|unit| units::is_unit(si, unit));
        let own = unit.or(in_brackets);
        let stated = own.unwrap_or_else(|| units::names(si).first().copied().unwrap_or(si.name()));
        let unit = units::by_name(si, stated).ok_or_else(|| {
            place.at(at, &format!("{stated} is no unit of {name}; there is {}", units::names(si).join(", ")))
        })?;
        let (unit_name, is_stated) = (stated.to_owned(), own.is_some());
        Ok(Column { header: header.get_ref().clone(), column, unit, unit_name, is_stated })
    };
    table.iter().map(one).collect()
}

/// Quantity and unit of `"speed"` or `{ name = "speed", unit = "rpm" }`.
fn parts(value: &Value) -> Result<(&str, Option<&str>), String> {
    let form = "a column is \"quantity\" or { name = \"quantity\", unit = \"unit\" }";
    match value {
        Value::String(name) => Ok((name, None)),
        Value::Table(table) => {
            let is_part = |key: &str, value: &Value| matches!(key, "name" | "unit") && value.is_str();
            if let Some((key, _)) = table.iter().find(|(key, value)| !is_part(key, value)) {
                return Err(format!("{key} is not a key of a column or no text; {form}"));
            }
            let of = |key: &str| table.get(key).and_then(Value::as_str);
            Ok((of("name").ok_or(form)?, of("unit")))
        }
        _ => Err(form.to_owned()),
    }
}

/// The column of a quantity or of a column name, and the SI unit.
fn quantity(name: &str) -> Option<(&'static str, Unit)> {
    if name == TIME_QUANTITY || name == TIME {
        return Some((TIME, Unit::Second));
    }
    let first = || CHANNELS.iter().find(|c| c.is_named(name));
    let outputs = || CHANNELS.iter().filter(|c| c.output.is_some()).collect::<Vec<_>>();
    first().or_else(|| Channel::further(name, &outputs())).map(|c| (c.column, c.unit))
}

/// Sentence on a name that is the quantity of a channel with another unit than its column has; `None` if it is none.
pub fn other_unit<'a>(name: &str, channels: impl Iterator<Item = &'a Channel>) -> Option<String> {
    let rest = |c: &'a Channel| Some((c, name.strip_prefix(c.quantity())?.strip_prefix('_')?));
    // The longest quantity that fits; a number is that of a further sensor.
    let is_unit = |(_, unit): &(&Channel, &str)| !unit.starts_with(|c: char| c.is_ascii_digit());
    let (channel, unit) = channels.filter_map(rest).filter(is_unit).min_by_key(|(_, unit)| unit.len())?;
    let (quantity, column, unit) = (channel.quantity(), channel.column, unit.replace("_per_", "/"));
    Some(if units::by_name(channel.unit, &unit).is_some() {
        format!(
            "{name} is {column} in another unit: [columns] with \"{name}\" = {{ name = \"{quantity}\", unit = \"{unit}\" }} converts it, \
             and {column} is its name elsewhere"
        )
    } else {
        let known = units::names(channel.unit).join(", ");
        format!(
            "{name} ends with \"{unit}\", which is no unit of {quantity}; there is {known}, stated in [columns]"
        )
    })
}

impl Channel {
    /// The quantity: the column without its unit.
    pub fn quantity(&self) -> &'static str {
        let quantity = self.column.strip_suffix(suffix(self.unit).as_str());
        quantity.and_then(|quantity| quantity.strip_suffix('_')).unwrap_or(self.column)
    }

    /// Whether the name is its column or its quantity.
    pub fn is_named(&self, name: &str) -> bool {
        self.column == name || self.quantity() == name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name with another unit states the line of `[columns]`; one with a unit of something else states the units; others are no quantity.
    #[test]
    fn a_name_with_another_unit_says_what_to_do() {
        let of = |name: &str| other_unit(name, CHANNELS.iter());
        for (name, quantity, unit) in [
            ("current_mA", "current", "mA"),
            ("housing_temperature_K", "housing_temperature", "K"),
            ("speed_rev_per_s", "speed", "rev/s"),
            ("electrical_power_kW", "electrical_power", "kW"),
        ] {
            let line = format!("\"{name}\" = {{ name = \"{quantity}\", unit = \"{unit}\" }}");
            assert!(of(name).unwrap().contains(&line), "{:?}", of(name));
        }
        for (name, sentence) in [
            ("speed_Hz", "\"Hz\", which is no unit of speed; there is rad/s, rpm"),
            ("winding_temperature_V", "\"V\", which is no unit of winding_temperature; there is degC, K"),
        ] {
            assert!(of(name).unwrap().contains(sentence), "{:?}", of(name));
        }
        assert_eq!((of("currant_A"), of("speed"), of("temperature_degC")), (None, None, None));
    }
}
