//! Initial temperatures of a run that starts at measured temperatures: the parameters `initial.*` of a model. An FMU can start in the
//! same state.

use physics::model::{Declaration, Slot};

/// A part of a motor whose temperature a bench measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// The winding.
    Winding,
    /// The stator next to the winding.
    Stator,
    /// The rotor with its magnets.
    Magnets,
    /// Housing.
    Housing,
    /// The enclosure of the motor.
    Box,
}

use Node::{Box, Housing, Magnets, Stator, Winding};

/// The initial temperature of each node, and the nodes that it can be taken from, nearest first. The tube of an annulus is not
/// listed: it is closer to ambient and air flow than to the motor, and starts at ambient temperature.
const NEAREST: [(&str, [Node; 5]); 6] = [
    ("initial.winding_temperature", [Winding, Stator, Housing, Magnets, Box]),
    ("initial.stator_temperature", [Stator, Housing, Winding, Magnets, Box]),
    ("initial.magnet_temperature", [Magnets, Housing, Stator, Winding, Box]),
    ("initial.housing_temperature", [Housing, Stator, Magnets, Winding, Box]),
    ("initial.box_temperature", [Box, Housing, Magnets, Winding, Stator]),
    ("initial.gear_temperature", [Housing, Stator, Magnets, Winding, Box]),
];

/// The initial temperatures of a model given the temperatures of these nodes, K; empty if none is given. A node without a
/// temperature takes that of the nearest node with one.
pub fn temperatures(declaration: &Declaration, known: &[(Node, f64)]) -> Vec<(Slot, f64)> {
    let of = |node: &Node| known.iter().find(|(n, _)| n == node).map(|(_, value)| *value);
    let parameters = NEAREST.iter().filter_map(|(name, order)| Some((declaration.by_name(name)?, order)));
    // 0 K is reserved as "ambient temperature".
    let inside = |value: f64, entry: &physics::model::Entry| value.clamp(f64::MIN_POSITIVE, entry.row.max);
    parameters
        .filter_map(|(entry, order)| Some((entry.slot, inside(order.iter().find_map(of)?, entry))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(model: &str, known: &[(Node, f64)]) -> Vec<(String, f64)> {
        let declaration = (physics::models::by_name(model).unwrap().declaration)();
        let name = |slot: Slot| declaration.entries.iter().find(|e| e.slot == slot).unwrap().name.clone();
        temperatures(declaration, known).into_iter().map(|(slot, value)| (name(slot), value)).collect()
    }

    #[test]
    fn a_node_that_is_not_known_takes_the_nearest() {
        let motor = named("AnnulusCooledMotor", &[(Winding, 360.0), (Housing, 330.0)]);
        let values: Vec<f64> = motor.iter().map(|(_, value)| *value).collect();
        assert_eq!(values, [360.0, 330.0, 330.0, 330.0], "{motor:?}");
        let gearmotor = named("BrushedGearmotor", &[(Housing, 320.0), (Box, 305.0)]);
        let (names, values): (Vec<_>, Vec<_>) = gearmotor.into_iter().unzip();
        assert_eq!(names, ["winding", "housing", "box", "gear"].map(|n| format!("initial.{n}_temperature")));
        assert_eq!(values, [320.0, 320.0, 305.0, 320.0]);
        assert!(named("BrushedGearmotor", &[]).is_empty());
    }
}
