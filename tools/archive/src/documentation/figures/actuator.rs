//! Figures of the series elastic actuator.

use super::{Captioned, characteristic, driven, figure};
use crate::native::Native;

/// Load torque of the motor over joint torque, driving and driven.
pub fn both_ways(native: &Native<'_>) -> Option<Captioned> {
    let speed = native.entry("motor_speed")?.row.nominal;
    let most = native.entry("torque_demand")?.row.nominal;
    let load = |torque: f64, speed: f64| {
        // At the start the spring torque is equal to the demand.
        let mut run = native.start(&[("torque_demand", torque), ("motor_speed", speed)], &[])?;
        run.get("load_torque")
    };
    let line =
        |(speed, label): (f64, &str)| (label.to_string(), characteristic(most, |torque| load(torque, speed)));
    let ways = [(speed, "the motor drives"), (0.0, "at rest"), (-speed, "the joint drives")];
    let caption = format!(
        "Motor speed {speed} rad/s, joint angle 0. Friction of the transmission increases the load torque of a driving motor and \
         decreases that of a driven motor."
    );
    let lines = ways.into_iter().map(line).collect();
    figure(
        "Load torque of the motor over joint torque",
        "joint torque in N·m",
        "load torque in N·m",
        lines,
        caption,
    )
}

/// The greatest current over the motor's speed, for several supply voltages.
pub fn current_limits(native: &Native<'_>) -> Option<Captioned> {
    let nominal = native.starts.of(native.entry("supply_voltage")?);
    let constant = native.starts.of(native.entry("control.k_t")?);
    let fastest = nominal / constant;
    let current = |supply: f64, speed: f64| {
        let demand = native.entry("torque_demand")?.row.max;
        let values = [("supply_voltage", supply), ("motor_speed", speed)];
        let mut run = native.start(&values, &[])?;
        run.set("torque_demand", demand)?;
        run.get("current_command")
    };
    let line = |fraction: f64| {
        let supply = fraction * nominal;
        (format!("supply {supply} V"), driven(fastest, |speed| current(supply, speed)))
    };
    let caption = format!(
        "Torque constant of the control {constant} N·m/A. The drive limits the current at low speed, the supply voltage at high \
         speed."
    );
    let lines = [1.0, 0.75, 0.5].into_iter().map(line).collect();
    figure("Greatest current", "motor speed in rad/s", "current command in A", lines, caption)
}
