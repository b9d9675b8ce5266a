//! The modes of the model that follow from the input columns.

use super::Channel;
use physics::declare::Kind;
use physics::model::Declaration;

/// The input that is heat of the winding, without a current.
const HEAT: &str = "electrical_power_W";
/// Outputs that follow from the current.
const OF_THE_CURRENT: [&str; 3] = ["current_A", "voltage_V", "shaft_torque_Nm"];

/// Modes of the model that follow from the input columns.
pub(super) fn modes(inputs: &[&'static Channel], declaration: &Declaration) -> Vec<(String, f64)> {
    let has = |column: &str| inputs.iter().any(|c| c.column == column);
    let drive = [("current_A", "current"), ("duty_1", "pwm"), (HEAT, "power"), ("voltage_V", "voltage")];
    let drive = drive.iter().find(|(column, _)| has(column)).map(|(_, mode)| *mode);
    let mechanical = if has("speed_rad_per_s") { "imposed_speed" } else { "free_shaft" };
    [("drive_mode", drive), ("mechanical_mode", Some(mechanical))]
        .into_iter()
        .filter_map(|(name, item)| {
            let Kind::Enumeration(table) = declaration.by_name(name)?.row.kind else { return None };
            let item = table.items.iter().find(|i| Some(i.name) == item)?;
            Some((name.to_string(), f64::from(item.value)))
        })
        .collect()
}

/// A sentence on an output that the model does not compute from these inputs.
///
/// # Errors
/// Such an output.
pub(super) fn check(inputs: &[&'static Channel], outputs: &[&'static Channel]) -> Result<(), String> {
    let has = |column: &str| inputs.iter().any(|c| c.column == column);
    let is_heated = has(HEAT) && !["current_A", "duty_1"].into_iter().any(has);
    let missing = outputs.iter().find(|c| OF_THE_CURRENT.contains(&c.column)).filter(|_| is_heated);
    match missing {
        None => Ok(()),
        Some(output) => Err(format!(
            "{} cannot be an output with {HEAT} as an input: all of this power heats the motor, and the model has no current; state the \
             current or the voltage as the input in its place, or leave {} out",
            output.column, output.column
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels(columns: &[&str]) -> Vec<&'static Channel> {
        columns.iter().map(|column| Channel::of(column).unwrap()).collect()
    }

    #[test]
    fn the_drive_follows_from_the_inputs() {
        for (input, drive) in [("voltage_V", 1.0), ("duty_1", 2.0), ("current_A", 3.0), (HEAT, 4.0)] {
            let declaration = (physics::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
            let found = modes(&channels(&[input]), declaration);
            assert_eq!(found, [("drive_mode".to_string(), drive), ("mechanical_mode".to_string(), 1.0)]);
        }
    }

    /// A power that heats the winding gives temperatures, and no current.
    #[test]
    fn a_heated_motor_has_temperatures_only() {
        let of = |inputs: &[&str], outputs: &[&str]| check(&channels(inputs), &channels(outputs));
        let temperatures = ["winding_temperature_degC", "housing_temperature_degC"];
        assert_eq!(of(&[HEAT, "speed_rad_per_s"], &temperatures), Ok(()));
        assert_eq!(of(&["current_A"], &OF_THE_CURRENT[1..]), Ok(()));
        for output in OF_THE_CURRENT {
            let refused = of(&[HEAT], &[temperatures[0], output]).unwrap_err();
            assert!(
                refused.starts_with(output) && refused.contains("the current or the voltage"),
                "{refused}"
            );
        }
    }
}
