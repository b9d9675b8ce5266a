//! What a figure of a run shows unless the user chooses: the main outputs of each model, and the variables that limit them.

/// The main outputs of a model.
pub fn main_outputs(model: &str) -> &'static [&'static str] {
    match model {
        "AnnulusCooledMotor" => &[
            "winding_temperature",
            "housing_temperature",
            "current",
            "shaft_torque",
            "shaft_speed",
            "power_electrical",
            "power_mechanical",
            "heat_to_ambient",
        ],
        "BrushedGearmotor" => &[
            "winding_temperature",
            "housing_temperature",
            "box_temperature",
            "voltage",
            "current",
            "shaft_torque",
            "shaft_speed",
        ],
        "SeriesElasticActuator" => &["joint_torque", "current_command", "voltage", "supply_power"],
        "GaitLoad" => &["torque_demand", "joint_angle", "joint_speed"],
        _ => &[],
    }
}

/// A variable that limits an output of its model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// The parameter or input.
    pub variable: &'static str,
    /// The output.
    pub output: &'static str,
    /// Its label in a figure.
    pub label: &'static str,
    /// The limit holds in both directions.
    pub both_signs: bool,
}

/// The limits of all models.
pub const LIMITS: [Limit; 3] = [
    Limit {
        variable: "thermal.T_w_max",
        output: "winding_temperature",
        label: "limit of the winding",
        both_signs: false,
    },
    Limit { variable: "supply_voltage", output: "voltage", label: "supply voltage", both_signs: true },
    Limit {
        variable: "control.current_max",
        output: "current_command",
        label: "current limit",
        both_signs: true,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models;
    use physics::declare::Causality;

    #[test]
    fn outputs_and_limits_are_declared() {
        for kind in models::ALL {
            let declaration = (kind.declaration)();
            assert!(!main_outputs(declaration.name).is_empty(), "{}", declaration.name);
            for name in main_outputs(declaration.name) {
                let entry = declaration.by_name(name).unwrap_or_else(|| panic!("{name}"));
                assert_eq!(entry.row.causality, Causality::Output, "{name}");
            }
        }
        for limit in LIMITS {
            let both = models::ALL.iter().filter_map(|kind| {
                let declaration = (kind.declaration)();
                Some((declaration.by_name(limit.variable)?, declaration.by_name(limit.output)?))
            });
            let units: Vec<_> = both.map(|(a, b)| (a.row.unit, b.row.unit)).collect();
            assert!(!units.is_empty() && units.iter().all(|(a, b)| a == b), "{limit:?}");
        }
    }
}
