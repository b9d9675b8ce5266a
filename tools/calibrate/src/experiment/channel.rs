//! The columns of a bench file: name, unit, and the variable of the model that each belongs to.

/// A quantity that a bench records, with its column in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column, which ends in its unit.
    pub column: &'static str,
    /// The model's input that it drives, where it can drive one.
    pub input: Option<&'static str>,
    /// The model's output that it is compared with, where there is one.
    pub output: Option<&'static str>,
    /// Added to the file's number for SI units.
    pub offset: f64,
}

impl Channel {
    /// The channel of a column.
    pub fn of(column: &str) -> Option<&'static Channel> {
        CHANNELS.iter().find(|c| c.column == column)
    }

    /// Whether it is a temperature.
    pub fn is_temperature(&self) -> bool {
        self.offset != 0.0
    }
}

/// Celsius in a file, kelvin in the model.
const CELSIUS: f64 = 273.15;

const fn channel(
    column: &'static str,
    input: Option<&'static str>,
    output: Option<&'static str>,
    offset: f64,
) -> Channel {
    Channel { column, input, output, offset }
}

/// Every column that a file may have beside `time_s`.
pub const CHANNELS: &[Channel] = &[
    channel("voltage_V", Some("voltage"), Some("terminal_voltage"), 0.0),
    channel("current_A", Some("current_command"), Some("current"), 0.0),
    channel("duty_1", Some("duty"), None, 0.0),
    channel("electrical_power_W", Some("electrical_power"), Some("power_electrical"), 0.0),
    channel("speed_rad_per_s", Some("imposed_speed"), Some("shaft_speed"), 0.0),
    channel("load_torque_Nm", Some("load_torque"), None, 0.0),
    channel("shaft_torque_Nm", None, Some("shaft_torque"), 0.0),
    channel("fan_command_1", Some("fan_command"), None, 0.0),
    channel("ambient_temperature_degC", Some("ambient_temperature"), None, CELSIUS),
    channel("ambient_pressure_Pa", Some("ambient_pressure"), None, 0.0),
    channel("winding_temperature_degC", None, Some("winding_temperature"), CELSIUS),
    channel("stator_temperature_degC", None, Some("stator_temperature"), CELSIUS),
    channel("housing_temperature_degC", None, Some("housing_temperature"), CELSIUS),
    channel("magnet_temperature_degC", None, Some("magnet_temperature"), CELSIUS),
    channel("air_outlet_temperature_degC", None, Some("air_outlet_temperature"), CELSIUS),
];

#[cfg(test)]
mod tests {
    use super::*;
    use physics::declare::{Causality, Unit};

    /// Every column names variables that the model has, of the right kind, and in the unit that its name says.
    #[test]
    fn columns_are_variables_of_the_motor() {
        let declaration = (physics::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
        for channel in CHANNELS {
            for (name, causality) in [(channel.input, Causality::Input), (channel.output, Causality::Output)]
            {
                let Some(name) = name else { continue };
                let entry = declaration.by_name(name).unwrap_or_else(|| panic!("{name}"));
                assert_eq!(entry.row.causality, causality, "{name}");
                let unit = match entry.row.unit {
                    Unit::Kelvin => "degC",
                    Unit::NewtonMetre => "Nm",
                    Unit::RadianPerSecond => "rad_per_s",
                    other => other.name(),
                };
                assert!(channel.column.ends_with(unit), "{} and {unit}", channel.column);
            }
        }
    }
}
