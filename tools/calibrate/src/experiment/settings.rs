//! `[set]`: start values of parameters and inputs.

use super::{Channel, Place};
use crate::CalibrateError;
use physics::declare::{Causality, Kind};
use physics::model::{Declaration, Entry};
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// Start values of a table: name and value of parameters, and of inputs that no column drives.
pub(super) fn settings(
    table: &BTreeMap<Spanned<String>, Value>,
    inputs: &[&'static Channel],
    declaration: &Declaration,
    place: &Place,
) -> Result<Vec<(String, f64)>, CalibrateError> {
    let one = |(name, value): (&Spanned<String>, &Value)| {
        let input = declaration.by_name(name.get_ref()).filter(|e| e.row.causality == Causality::Input);
        if let Some(column) = inputs.iter().find(|c| c.input == Some(name.get_ref())) {
            let message = format!("{} is driven by the column {}", name.get_ref(), column.column);
            return Err(place.at(name.span().start, &message));
        }
        let entry = input.map_or_else(|| parameter(name, declaration, place), Ok)?;
        let number = number(entry, value).map_err(|m| place.at(name.span().start, &m))?;
        Ok((entry.name.clone(), number))
    };
    table.iter().map(one).collect()
}

pub(super) fn parameter<'a>(
    name: &Spanned<String>,
    declaration: &'a Declaration,
    place: &Place,
) -> Result<&'a Entry, CalibrateError> {
    declaration.by_name(name.get_ref()).filter(|e| e.row.causality == Causality::Parameter).ok_or_else(|| {
        let known = name.get_ref();
        let unknown = || format!("{known} is no parameter of {}", declaration.name);
        place.at(name.span().start, &declaration.unserved(known).unwrap_or_else(unknown))
    })
}

/// The value as a number within the parameter's limits; otherwise a one-sentence error.
fn number(entry: &Entry, value: &Value) -> Result<f64, String> {
    let number = match (value, entry.row.kind) {
        (Value::String(item), Kind::Enumeration(table)) => {
            let found = table.items.iter().find(|i| i.name == item);
            let names = || table.items.iter().map(|i| i.name).collect::<Vec<_>>().join(", ");
            let item = found.ok_or_else(|| format!("{} = {item} is none of {}", entry.name, names()))?;
            f64::from(item.value)
        }
        (Value::Float(x), _) => *x,
        (Value::Integer(x), _) => *x as f64,
        (Value::Boolean(x), Kind::Boolean) => f64::from(u8::from(*x)),
        (other, _) => return Err(format!("{} = {other} is not a number", entry.name)),
    };
    entry.check(number, false).map_err(|refusal| entry.explain(number, &refusal))?;
    Ok(number)
}
