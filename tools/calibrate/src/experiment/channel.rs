//! Columns of a bench file: name, unit, and the corresponding variable of the model.
//!
//! A column may be listed more than once if models name its variable differently; the first entry that matches the
//! model is used. The order matters: `power_electrical` is the power at the terminals in one motor model and the copper loss
//! alone in the other, so `supply_power` is listed first.

use physics::declare::{Causality, Unit};
use physics::model::{Declaration, Entry};
use physics::models::ALL;
use physics::terms::Driver;
use std::sync::{Mutex, PoisonError};

/// A quantity recorded by the bench and its column in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column, with the unit as suffix.
    pub column: &'static str,
    /// SI unit of the quantity.
    pub unit: Unit,
    /// The model's input that the column can drive, if any.
    pub input: Option<&'static str>,
    /// The model's output that the column is compared with, if any.
    pub output: Option<&'static str>,
    /// Added to the file's number to convert to SI units.
    pub offset: f64,
}

impl Channel {
    /// The channel of a column, for any model.
    pub fn of(column: &str) -> Option<&'static Channel> {
        CHANNELS.iter().find(|c| c.column == column)
    }

    /// The channel of a further sensor of an output, by its column or its quantity with a number before the unit:
    /// `housing_temperature_2_degC` or `housing_temperature_2`. It is compared with the same output of the model.
    pub fn further(name: &str, outputs: &[&'static Channel]) -> Option<&'static Channel> {
        static KNOWN: Mutex<Vec<&'static Channel>> = Mutex::new(Vec::new());
        let numbered = |channel: &&&'static Channel| {
            let (quantity, unit) = channel.column.split_at(channel.quantity().len());
            let number = name.strip_prefix(quantity)?.strip_prefix('_')?;
            let number = number.strip_suffix(unit).unwrap_or(number);
            // "2" is accepted and "02" is not, so that a sensor has only one name.
            let counts = number.parse::<u8>().is_ok_and(|n| n >= 2 && n.to_string() == number);
            counts.then(|| format!("{quantity}_{number}{unit}"))
        };
        let (channel, column) = outputs.iter().find_map(|c| Some((**c, numbered(&c)?)))?;
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |c: &&&'static Channel| c.column == column && c.output == channel.output;
        if let Some(found) = known.iter().find(same) {
            return Some(found);
        }
        // Allocated once per sensor and kept until the program ends, like the static channels.
        let column: &'static str = Box::leak(column.into_boxed_str());
        let found: &'static Channel = Box::leak(Box::new(Channel { column, input: None, ..channel }));
        known.push(found);
        Some(found)
    }

    /// The channels that can drive a model.
    pub fn inputs_of(model: &Declaration) -> impl Iterator<Item = &'static Channel> {
        CHANNELS.iter().filter(|c| has(model, c.input, Causality::Input))
    }

    /// The channels that a model can be compared with.
    pub fn outputs_of(model: &Declaration) -> impl Iterator<Item = &'static Channel> {
        CHANNELS.iter().filter(|c| has(model, c.output, Causality::Output))
    }

    /// The output that the channel measures, if it is the temperature of a node: a temperature with an initial value.
    pub fn node(&self) -> Option<&'static str> {
        let is_initial = |e: &Entry, output: &str| e.name.strip_prefix("initial.") == Some(output);
        let is_node = |output: &&str| {
            ALL.iter().any(|m| (m.declaration)().entries.iter().any(|e| is_initial(e, output)))
        };
        self.output.filter(|output| self.is_temperature() && is_node(output))
    }

    /// The channel that measures a driver of terms, if the bench has a sensor for it.
    pub fn reading(driver: Driver) -> Option<&'static Channel> {
        let output = match driver {
            Driver::Current => "current",
            Driver::Speed => "shaft_speed",
            Driver::WindingTemperature => "winding_temperature",
            Driver::HousingTemperature => "housing_temperature",
            _ => return None,
        };
        CHANNELS.iter().find(|c| c.output == Some(output))
    }

    /// Whether the channel is a temperature.
    pub fn is_temperature(&self) -> bool {
        self.offset != 0.0
    }
}

/// Whether the model has this variable with this causality.
fn has(model: &Declaration, name: Option<&str>, causality: Causality) -> bool {
    name.and_then(|name| model.by_name(name)).is_some_and(|entry| entry.row.causality == causality)
}

/// Offset between degrees Celsius in a file and kelvin in the model. Definition: of the degree Celsius.
pub const CELSIUS: f64 = 273.15;

const fn channel(
    column: &'static str,
    unit: Unit,
    input: Option<&'static str>,
    output: Option<&'static str>,
) -> Channel {
    // Temperatures are in degC in files.
    let offset = if matches!(unit, Unit::Kelvin) { CELSIUS } else { 0.0 };
    Channel { column, unit, input, output, offset }
}

/// Every column that a file may have in addition to `time_s`.
pub const CHANNELS: &[Channel] = &[
    channel("voltage_V", Unit::Volt, Some("voltage"), Some("terminal_voltage")),
    channel("voltage_V", Unit::Volt, None, Some("voltage")),
    channel("supply_voltage_V", Unit::Volt, Some("supply_voltage"), None),
    channel("current_A", Unit::Ampere, Some("current_command"), Some("current")),
    channel("duty_1", Unit::One, Some("duty"), None),
    channel("electrical_power_W", Unit::Watt, None, Some("supply_power")),
    channel("electrical_power_W", Unit::Watt, Some("electrical_power"), Some("power_electrical")),
    channel("speed_rad_per_s", Unit::RadianPerSecond, Some("imposed_speed"), Some("shaft_speed")),
    channel("load_torque_Nm", Unit::NewtonMetre, Some("load_torque"), None),
    channel("shaft_torque_Nm", Unit::NewtonMetre, None, Some("shaft_torque")),
    channel("fan_command_1", Unit::One, Some("fan_command"), None),
    channel("ambient_temperature_degC", Unit::Kelvin, Some("ambient_temperature"), None),
    channel("ambient_pressure_Pa", Unit::Pascal, Some("ambient_pressure"), None),
    channel("winding_temperature_degC", Unit::Kelvin, None, Some("winding_temperature")),
    channel("stator_temperature_degC", Unit::Kelvin, None, Some("stator_temperature")),
    channel("housing_temperature_degC", Unit::Kelvin, None, Some("housing_temperature")),
    channel("box_temperature_degC", Unit::Kelvin, None, Some("box_temperature")),
    channel("magnet_temperature_degC", Unit::Kelvin, None, Some("magnet_temperature")),
    channel("air_outlet_temperature_degC", Unit::Kelvin, None, Some("air_outlet_temperature")),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn declaration(model: &str) -> &'static Declaration {
        (physics::models::by_name(model).unwrap().declaration)()
    }

    /// Every column refers to variables that exist in a model, with the right causality and the unit of its name.
    #[test]
    fn columns_are_variables_of_a_model() {
        for channel in CHANNELS {
            let mut found = 0;
            for model in physics::models::ALL.iter().map(|m| (m.declaration)()) {
                for name in [channel.input, channel.output].into_iter().flatten() {
                    let Some(entry) = model.by_name(name) else { continue };
                    let unit = match entry.row.unit {
                        Unit::Kelvin => "degC",
                        Unit::NewtonMetre => "Nm",
                        Unit::RadianPerSecond => "rad_per_s",
                        other => other.name(),
                    };
                    assert!(channel.column.ends_with(unit), "{} and {unit}", channel.column);
                    assert_eq!(channel.unit, entry.row.unit, "{}", channel.column);
                    assert_ne!(channel.quantity(), channel.column);
                    found += 1;
                }
            }
            let roles = [channel.input, channel.output].into_iter().flatten().count();
            assert!(roles > 0 && found >= roles, "{}", channel.column);
        }
    }

    /// A number of 2 or more before the unit denotes a further sensor of the same output.
    #[test]
    fn further_sensors_have_numbers() {
        let outputs: Vec<_> = Channel::outputs_of(declaration("AnnulusCooledMotor")).collect();
        let second = Channel::further("housing_temperature_2_degC", &outputs).unwrap();
        assert_eq!(
            (second.column, second.output),
            ("housing_temperature_2_degC", Some("housing_temperature"))
        );
        assert_eq!((second.quantity(), second.offset), ("housing_temperature_2", 273.15));
        assert!(std::ptr::eq(second, Channel::further("housing_temperature_2", &outputs).unwrap()));
        assert_eq!(Channel::further("shaft_torque_3", &outputs).map(|c| c.column), Some("shaft_torque_3_Nm"));
        for none in
            ["housing_temperature_1", "housing_temperature_02_degC", "housing_temperature_2_K", "housing_2"]
        {
            assert_eq!(Channel::further(none, &outputs), None, "{none}");
        }
    }

    #[test]
    fn a_column_belongs_to_other_variables_in_other_models() {
        let (motor, gearmotor) = (declaration("AnnulusCooledMotor"), declaration("BrushedGearmotor"));
        let output =
            |model, column| Channel::outputs_of(model).find(|c| c.column == column).and_then(|c| c.output);
        let input =
            |model, column| Channel::inputs_of(model).find(|c| c.column == column).and_then(|c| c.input);
        assert_eq!(output(motor, "voltage_V"), Some("terminal_voltage"));
        assert_eq!(output(gearmotor, "voltage_V"), Some("voltage"));
        assert_eq!((input(motor, "voltage_V"), input(gearmotor, "voltage_V")), (Some("voltage"), None));
        assert_eq!(output(motor, "electrical_power_W"), Some("power_electrical"));
        assert_eq!(output(gearmotor, "electrical_power_W"), Some("supply_power"));
        assert_eq!(input(gearmotor, "supply_voltage_V"), Some("supply_voltage"));
        assert_eq!(output(gearmotor, "box_temperature_degC"), Some("box_temperature"));
        assert_eq!(output(motor, "box_temperature_degC"), None);
        // Columns of both models have the same meaning in both.
        for column in ["duty_1", "load_torque_Nm", "ambient_temperature_degC"] {
            assert!(
                input(motor, column).is_some() && input(motor, column) == input(gearmotor, column),
                "{column}"
            );
        }
        for column in ["current_A", "speed_rad_per_s", "shaft_torque_Nm", "winding_temperature_degC"] {
            assert!(
                output(motor, column).is_some() && output(motor, column) == output(gearmotor, column),
                "{column}"
            );
        }
    }
}
