//! Initial temperatures of a run that starts at measured temperatures: the parameters `initial.*` of a model. An FMU can start in the
//! same state.

use physics::model::{Declaration, Entry, Slot};

/// The initial temperatures of the nodes of a model.
pub fn nodes(declaration: &Declaration) -> Vec<&Entry> {
    declaration.entries.iter().filter(|entry| !entry.row.near.is_empty()).collect()
}

/// The initial temperatures of these nodes given these measured temperatures by the name of their output, K; empty if none is given. A
/// node starts at its own temperature, else at the nearest one that is measured ([`near`](physics::declare::Variable::near)).
pub fn temperatures(nodes: &[&Entry], known: &[(&str, f64)]) -> Vec<(Slot, f64)> {
    let of = |name: &str| known.iter().find(|(output, _)| *output == name).map(|(_, value)| *value);
    // 0 K is reserved as "ambient temperature".
    let inside = |value: f64, entry: &Entry| value.clamp(f64::MIN_POSITIVE, entry.row.max);
    let start = |entry: &&Entry| {
        let value = of(entry.row.name).or_else(|| entry.row.near.iter().find_map(|name| of(name)))?;
        Some((entry.slot, inside(value, entry)))
    };
    nodes.iter().filter_map(start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(model: &str, known: &[(&str, f64)]) -> Vec<(String, f64)> {
        let declaration = (physics::models::by_name(model).unwrap().declaration)();
        let name = |slot: Slot| declaration.entries.iter().find(|e| e.slot == slot).unwrap().name.clone();
        temperatures(&nodes(declaration), known)
            .into_iter()
            .map(|(slot, value)| (name(slot), value))
            .collect()
    }

    #[test]
    fn a_node_that_is_not_known_takes_the_nearest() {
        let motor =
            named("AnnulusCooledMotor", &[("winding_temperature", 360.0), ("housing_temperature", 330.0)]);
        let values: Vec<f64> = motor.iter().map(|(_, value)| *value).collect();
        assert_eq!(values, [360.0, 330.0, 330.0, 330.0], "{motor:?}");
        let gearmotor =
            named("BrushedGearmotor", &[("housing_temperature", 320.0), ("box_temperature", 305.0)]);
        let (names, values): (Vec<_>, Vec<_>) = gearmotor.into_iter().unzip();
        assert_eq!(names, ["winding", "housing", "box", "gear"].map(|n| format!("initial.{n}_temperature")));
        assert_eq!(values, [320.0, 320.0, 305.0, 320.0]);
        assert!(named("BrushedGearmotor", &[]).is_empty());
    }
}
