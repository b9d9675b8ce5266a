//! Figures of the series elastic actuator.

use super::{Figure, POINTS, figure};
use crate::native::Native;

/// What the motor's shaft has to bear for a joint torque, when the motor drives and when it is driven.
pub fn both_ways(native: &Native<'_>) -> Option<Figure> {
    let speed = native.entry("motor_speed")?.row.nominal;
    let most = native.entry("torque_demand")?.row.nominal;
    let load = |torque: f64, speed: f64| {
        // At the start the spring carries the demand.
        let mut run = native.start(&[("torque_demand", torque), ("motor_speed", speed)], &[])?;
        run.get("load_torque")
    };
    let line = |(speed, label): (f64, &str)| {
        let points = (0..=POINTS).map(|k| most * f64::from(k) / f64::from(POINTS));
        let points: Option<Vec<_>> = points.map(|torque| load(torque, speed).map(|t| (torque, t))).collect();
        (label.to_string(), points.unwrap_or_default())
    };
    let ways = [(speed, "the motor drives"), (0.0, "at rest"), (-speed, "the joint drives")];
    let caption = format!(
        "At {speed} rad/s of the motor, joint_angle 0. Friction of the transmission adds to the load of a motor that drives \
         and takes from what a joint that drives gives back."
    );
    let lines = ways.into_iter().map(line).collect();
    figure(
        "Torque on the motor for a torque at the joint",
        "joint_torque, N.m",
        "load_torque, N.m",
        lines,
        caption,
    )
}

/// The greatest current over the motor's speed, for supplies.
pub fn current_limits(native: &Native<'_>) -> Option<Figure> {
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
    let line = |share: f64| {
        let supply = share * nominal;
        let points = (0..=POINTS).map(|k| fastest * f64::from(k) / f64::from(POINTS));
        let points = points.map(|w| current(supply, w).map(|i| (w, i))).collect::<Option<Vec<_>>>();
        (format!("{supply} V"), points.unwrap_or_default().into_iter().filter(|p| p.1 >= 0.0).collect())
    };
    let caption = format!(
        "The control counts with {constant} N.m/A. Up to the bend the drive limits the current, beyond it the supply."
    );
    let lines = [1.0, 0.75, 0.5].into_iter().map(line).collect();
    figure("Greatest current", "motor_speed, rad/s", "current_command, A", lines, caption)
}
