//! Columns of a bench file: name, unit, and the corresponding variable of the model.
//!
//! Every continuous input and output of a model is a column, by its name and unit: `coolant_flow_rate_m3_per_s`. The list [`USUAL`] has
//! the columns of the contract, whose names differ from this or which join an input and an output.
//!
//! A column may be listed more than once if models name its variable differently; the first entry that matches the
//! model is used. The order matters: `power_electrical` is the power at the terminals in one motor model and the copper loss
//! alone in the other, so `supply_power` is listed first.

use physics::declare::{Causality, Kind, Unit, Variability, Variable};
use physics::model::{Declaration, Entry};
use physics::models::ALL;
use physics::terms::Driver;
use std::sync::{LazyLock, Mutex, PoisonError};

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
    /// Whether benches usually record it: proposed experiments and lists of columns have only these.
    pub is_usual: bool,
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

    /// The node whose temperature the channel measures, by the name of its initial temperature: that which the output states, or that
    /// with the name of the output.
    pub fn node(&self) -> Option<&'static str> {
        let output = self.output.filter(|_| self.is_temperature())?;
        ALL.iter()
            .map(|model| (model.declaration)())
            .find_map(|model| node_of(model, model.by_name(output)?.row))
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

    /// Whether it is the ambient temperature.
    pub fn is_ambient(&self) -> bool {
        self.input == Some("ambient_temperature")
    }
}

/// The node of a model whose temperature an output is.
fn node_of(model: &Declaration, output: &'static Variable) -> Option<&'static str> {
    let node = if output.node.is_empty() { output.name } else { output.node };
    let is_initial = |e: &Entry| e.name.strip_prefix("initial.") == Some(node);
    model.entries.iter().any(is_initial).then_some(node)
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
    Channel { column, unit, input, output, offset, is_usual: true }
}

/// Every column that a file may have in addition to `time_s`: the usual ones, then the other inputs and outputs of the models.
pub static CHANNELS: LazyLock<Vec<Channel>> = LazyLock::new(|| {
    let mut all = USUAL.to_vec();
    for model in ALL.iter().map(|model| (model.declaration)()) {
        for entry in model.entries.iter().filter(|entry| is_recordable(entry)) {
            let name = entry.row.name;
            let [input, output] = [Causality::Input, Causality::Output]
                .map(|causality| (entry.row.causality == causality).then_some(name));
            let is_known = |known: &Channel| {
                let is_first = |role: fn(&Channel) -> Option<&'static str>, causality| {
                    let of_column = |c: &&Channel| c.column == known.column && has(model, role(c), causality);
                    role(known) == Some(name) && all.iter().find(of_column) == Some(known)
                };
                input.is_some() && is_first(|c| c.input, Causality::Input)
                    || output.is_some() && is_first(|c| c.output, Causality::Output)
            };
            if all.iter().any(is_known) {
                continue;
            }
            let column = format!("{name}_{}", suffix(entry.row.unit));
            // An output of one model can be an input of another, and models share variables.
            match all.iter_mut().find(|c| c.column == column) {
                Some(known) => (known.input, known.output) = (known.input.or(input), known.output.or(output)),
                // Allocated once and kept until the program ends.
                None => {
                    let column = Box::leak(column.into_boxed_str());
                    all.push(Channel { is_usual: false, ..channel(column, entry.row.unit, input, output) });
                }
            }
        }
    }
    all
});

/// Whether a file can have a column for a variable: continuous inputs and outputs, but no differences to a limit.
fn is_recordable(entry: &Entry) -> bool {
    let row = entry.row;
    let is_port = matches!(row.causality, Causality::Input | Causality::Output);
    is_port
        && row.variability == Variability::Continuous
        && row.kind == Kind::Real
        && entry.element.is_none()
        && !row.relative
}

/// The unit at the end of a column.
pub(super) fn suffix(unit: Unit) -> String {
    match unit {
        Unit::Kelvin => "degC".to_string(),
        other => other.name().replace('/', "_per_").replace('.', ""),
    }
}

/// The usual columns.
const USUAL: &[Channel] = &[
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
        for channel in CHANNELS.iter() {
            let mut found = 0;
            for model in physics::models::ALL.iter().map(|m| (m.declaration)()) {
                for name in [channel.input, channel.output].into_iter().flatten() {
                    let Some(entry) = model.by_name(name) else { continue };
                    let unit = suffix(entry.row.unit);
                    assert!(channel.column.ends_with(&unit), "{} and {unit}", channel.column);
                    assert_eq!(channel.unit, entry.row.unit, "{}", channel.column);
                    assert_ne!(channel.quantity(), channel.column);
                    found += 1;
                }
            }
            let roles = [channel.input, channel.output].into_iter().flatten().count();
            assert!(roles > 0 && found >= roles, "{}", channel.column);
        }
    }

    /// What a bench of any model can drive or measure is a column, whose unit a file can state.
    #[test]
    fn every_continuous_input_and_output_is_a_column() {
        for model in physics::models::ALL.iter().map(|m| (m.declaration)()) {
            for entry in model.entries.iter().filter(|entry| is_recordable(entry)) {
                let (name, is_input) = (entry.row.name, entry.row.causality == Causality::Input);
                let channel = if is_input {
                    Channel::inputs_of(model).find(|c| c.input == Some(name))
                } else {
                    Channel::outputs_of(model).find(|c| c.output == Some(name))
                };
                let channel = channel.unwrap_or_else(|| panic!("{}: {name} is no column", model.name));
                assert!(crate::experiment::units::by_name(channel.unit, channel.unit.name()).is_some());
                assert_eq!(Channel::of(channel.column).map(|c| c.column), Some(channel.column));
            }
        }
        let jacket = Channel::of("coolant_flow_rate_m3_per_s").unwrap();
        assert_eq!((jacket.input, jacket.quantity()), (Some("coolant_flow_rate"), "coolant_flow_rate"));
        let gear = Channel::of("gear_temperature_degC").unwrap();
        assert_eq!(
            (gear.output, gear.offset, gear.node()),
            (Some("gear_temperature"), CELSIUS, Some("gear_temperature"))
        );
    }

    /// The temperature of a node finds its initial value by the node that the output states, or by its own name.
    #[test]
    fn an_output_states_its_node() {
        const CONDENSER: &Variable = &Variable::output(1, Unit::Kelvin).of_node("tube_temperature");
        const UNKNOWN: &Variable = &Variable::output(1, Unit::Kelvin).of_node("nothing");
        let motor = declaration("AnnulusCooledMotor");
        assert_eq!((node_of(motor, CONDENSER), node_of(motor, UNKNOWN)), (Some("tube_temperature"), None));
        let node = |column| Channel::of(column).unwrap().node();
        assert_eq!(node("housing_temperature_degC"), Some("housing_temperature"));
        assert_eq!(node("air_outlet_temperature_degC"), None);
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
