//! Numbers with units for the variables of an FMU: units of the FMU, and all others of the quantity.
use crate::system::{Affine, conversion, unit_of};
use crate::{DisplayUnit, Error, ModelDescription, Unit, Variable};

impl DisplayUnit {
    /// `shown` (in the display unit) in the unit this belongs to: the inverse of [`DisplayUnit::show`].
    pub fn back(&self, shown: f64) -> f64 {
        if self.inverse { self.factor / shown } else { (shown - self.offset) / self.factor }
    }
}

/// The number and its unit, if the text of a real variable is no plain number: `300 rpm`, `0,5`.
pub(crate) fn number_with_unit<'t>(variable: &Variable, text: &'t str) -> Option<(f64, &'t str)> {
    let is_scalar = variable.kind.is_float() && variable.dimensions.is_empty();
    let is_plain = text.trim().parse::<f64>().is_ok();
    units::split(text).filter(|_| is_scalar && !is_plain)
}

/// A number with a unit, in the unit of the variable.
pub(crate) fn in_unit(
    description: &ModelDescription,
    variable: &Variable,
    number: f64,
    unit: &str,
) -> Result<f64, Error> {
    let unit = Some(unit).filter(|unit| !unit.is_empty());
    let refused = match from_unit(description, variable, unit, false) {
        Ok(convert) => return Ok(convert.of(number)),
        Err(refused) => refused,
    };
    // A torque constant in rpm/V, a conductance in K/W.
    let own = variable.unit.as_deref().unwrap_or("1");
    let usual = units::conversion(unit.unwrap_or(own), own, variable.relative);
    let refused = |_| {
        let given = format!("= {} {}: it {refused}", crate::error::number(number), unit.unwrap_or_default());
        Error::unsupported(&variable.name, given)
    };
    usual.map(|usual| usual.of(number)).map_err(refused)
}

/// The conversion of numbers in `unit`, by default that of the variable or its display unit, to the unit of the variable.
pub(crate) fn from_unit(
    description: &ModelDescription,
    variable: &Variable,
    unit: Option<&str>,
    display_units: bool,
) -> Result<Affine, String> {
    let display = description.display_unit(variable).filter(|_| display_units);
    let unit = unit.or(display.as_ref().map(|display| display.name.as_str()));
    let Some(wanted) = unit.filter(|unit| variable.unit.as_deref() != Some(unit)) else {
        return Ok(Affine::IDENTITY);
    };
    let own = unit_of(description, variable);
    let shown = own.iter().flat_map(|own| &own.display_units).find(|d| d.name == wanted && !d.inverse);
    if let Some(display) = shown {
        let offset = if variable.relative { 0.0 } else { display.offset };
        return Ok(Affine { factor: 1.0 / display.factor, offset: -offset / display.factor });
    }
    let defined = description.units.iter().find(|u| u.name == wanted);
    if let Some(convert) = conversion(defined, own.as_ref(), variable.relative).filter(|_| defined.is_some())
    {
        return Ok(convert);
    }
    // A unit that the FMU does not define, by its usual meaning.
    let of_variable = variable.unit.as_deref();
    let usual = units::conversion(wanted, of_variable.unwrap_or("1"), variable.relative);
    match usual {
        Ok(usual) if !usual.reciprocal => {
            let offset = usual.of(0.0);
            Ok(Affine { factor: usual.of(1.0) - offset, offset })
        }
        refused => {
            let own = of_variable.map_or("no unit".to_owned(), |u| format!("the unit {u:?}"));
            let why =
                refused.err().map_or(format!("{wanted:?} is a reciprocal"), |refusal| refusal.to_string());
            Err(format!("has {own}, and {why}"))
        }
    }
}

/// The conversion of a column of an input table; the sentence about a unit that does not fit names units that do.
pub(crate) fn of_column(
    description: &ModelDescription,
    variable: &Variable,
    unit: Option<&str>,
    display_units: bool,
) -> Result<Affine, String> {
    from_unit(description, variable, unit, display_units).map_err(|refused| {
        let own = unit_of(description, variable);
        let shown = own.iter().flat_map(|own| own.display_units.iter().map(|d| d.name.as_str()));
        let fits = |unit: &&Unit| conversion(Some(unit), own.as_ref(), variable.relative).is_some();
        let others = description.units.iter().filter(fits).map(|u| u.name.as_str());
        let mut units: Vec<&str> = Vec::new();
        for name in own.iter().map(|own| own.name.as_str()).chain(shown).chain(others) {
            if !units.contains(&name) {
                units.push(name);
            }
        }
        let possible = match units[..] {
            [] => String::new(),
            _ => format!("; possible are {} and other units of the quantity", units.join(", ")),
        };
        format!("column {} {refused}{possible}", variable.name)
    })
}

/// One sentence about a column that is no variable: `speed_rpm` is a variable with a unit that stands in brackets.
pub(crate) fn unknown_column(description: &ModelDescription, name: &str, error: &Error) -> String {
    let with_unit = name.match_indices('_').rev().find_map(|(at, _)| {
        let variable = description.settable(&name[..at]).ok()?;
        Some((variable, name[at + 1..].replace("_per_", "/")))
    });
    let Some((variable, unit)) = with_unit else { return format!("unknown column: {error}") };
    let own = &variable.name;
    match of_column(description, variable, Some(&unit), false) {
        Ok(_) => format!("unknown column: {name}; a unit stands in brackets, as in {own} [{unit}]"),
        Err(refused) => format!("unknown column: {name}; a unit stands in brackets, and {refused}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_value_goes_back() {
        let celsius = DisplayUnit { name: "degC".to_owned(), factor: 1.0, offset: -273.15, inverse: false };
        let period = DisplayUnit { name: "ms".to_owned(), factor: 1000.0, offset: 0.0, inverse: true };
        for (display, value) in [(&celsius, 298.15), (&period, 50.0)] {
            assert!((display.back(display.show(value)) - value).abs() < 1e-12);
        }
    }
}
