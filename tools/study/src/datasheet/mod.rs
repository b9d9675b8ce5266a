//! From a datasheet to a preset: the printed values in the datasheet's units, checked against each other, converted to start values of the
//! motor.
//!
//! | file | content |
//! |---|---|
//! | `quantities.rs` | what datasheets print, with units, and what it is in terms of the motor's constants |
//! | `read.rs` | a datasheet from TOML and from text |
//! | `consistency.rs` | whether the printed values agree |
//! | `ways.rs` | from which printed values a start value follows, and how |
//! | `derive.rs` | start values with their sources, the variables that keep their defaults, and the preset's text |

mod consistency;
mod derive;
mod quantities;
mod read;
#[cfg(test)]
mod tests;
mod ways;

pub use consistency::{Contradiction, Implausible, contradictions, implausible, is_comparable};
pub use derive::{Certainty, Draft, Given};
pub use quantities::{QUANTITIES, Quantity, by_key};

use units::{Conversion, conversion};

/// A printed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// What it is.
    pub quantity: &'static Quantity,
    /// In SI units.
    pub si: f64,
    /// Number and unit as given.
    pub given: (f64, String),
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Quantity) -> bool {
        self.key == other.key
    }
}

impl std::fmt::Debug for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key)
    }
}

impl Value {
    /// A value of a quantity, from SI, in the datasheet's unit.
    fn shown(quantity: &Quantity, si: f64) -> f64 {
        datasheet_unit(quantity).map_or(si, |c| c.back(si))
    }

    /// As given, with its unit.
    pub fn text(&self) -> String {
        let unit = if self.given.1 == "1" { "" } else { &self.given.1 };
        let number = self.given.0;
        let number = if number < 1e15 { number.to_string() } else { format!("{number:e}") };
        format!("{number} {unit}").trim_end().to_owned()
    }
}

/// The conversion from the datasheet's unit to SI.
fn datasheet_unit(quantity: &Quantity) -> Option<Conversion> {
    conversion(quantity.unit, quantity.si, false).ok()
}

/// The printed values of a motor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Datasheet {
    /// Name of the preset.
    pub name: String,
    /// One line about the motor.
    pub description: String,
    /// Source of the values.
    pub source: String,
    /// The values, in the order of [`QUANTITIES`], each quantity once.
    pub values: Vec<Value>,
}

impl Datasheet {
    /// The printed value of a quantity.
    pub fn value(&self, key: &str) -> Option<&Value> {
        self.values.iter().find(|v| v.quantity.key == key)
    }

    /// In SI units.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.value(key).map(|v| v.si)
    }

    /// The same sheet; if dynamic friction is printed, `friction_torque` is read as the static one.
    fn with_static_friction(&self) -> Datasheet {
        let mut sheet = self.clone();
        let is_split = sheet.value("dynamic_friction").is_some();
        if let (true, None, Some(quantity)) =
            (is_split, sheet.value("static_friction_torque"), by_key("static_friction_torque"))
            && let Some(value) = sheet.values.iter_mut().find(|v| v.quantity.key == "friction_torque")
        {
            value.quantity = quantity;
        }
        sheet
    }

    /// Adds a value, or replaces that of the same quantity.
    pub fn put(&mut self, value: Value) {
        self.values.retain(|v| v.quantity != value.quantity);
        self.values.push(value);
        self.values.sort_by_key(|v| QUANTITIES.iter().position(|q| q == v.quantity));
    }
}
