//! Figures of the gait.

use super::{Captioned, figure};
use crate::native::Native;
use describe::Kind;

/// Points of a stride.
const STRIDE_POINTS: u32 = 100;

/// One stride of a model with these choices: an output over the phase.
fn stride(native: &Native<'_>, name: &str, choices: &[(&str, &str)]) -> Option<Vec<(f64, f64)>> {
    let point = |k: u32| {
        let phase = f64::from(k) / f64::from(STRIDE_POINTS);
        let mut run = native.start(&[("gait.initial_phase", phase), ("gait.variation", 0.0)], choices)?;
        Some((100.0 * phase, run.get(name)?))
    };
    (0..STRIDE_POINTS).map(point).collect()
}

fn choices(native: &Native<'_>, name: &str) -> Vec<&'static str> {
    match native.entry(name).map(|e| e.row.kind) {
        Some(Kind::Enumeration(t)) => t.items.iter().map(|i| i.name).collect(),
        _ => Vec::new(),
    }
}

/// The torque of each joint.
pub fn torques(native: &Native<'_>) -> Option<Captioned> {
    let joints = choices(native, "gait.joint");
    let line = |joint: &&str| {
        let points = stride(native, "torque_demand", &[("gait.joint", joint), ("gait.activity", "walk")]);
        (joint.to_string(), points.unwrap_or_default())
    };
    let caption = format!(
        "Level walking at self-selected speed, body mass {} kg, support {}. Positive is extension, plantarflexion at the ankle; the \
         stride begins at heel strike.",
        native.starts.of(native.entry("gait.body_mass")?),
        native.starts.of(native.entry("gait.support")?)
    );
    figure("Torque over a stride", "stride in %", "torque in N·m", joints.iter().map(line).collect(), caption)
}

/// The power of the ankle in every activity.
pub fn powers(native: &Native<'_>) -> Option<Captioned> {
    let activities = ["walk_slow", "walk", "walk_fast", "stairs_up", "stairs_down"];
    let line = |activity: &&str| {
        let points = stride(native, "power_demand", &[("gait.joint", "ankle"), ("gait.activity", activity)]);
        (activity.replace('_', " "), points.unwrap_or_default())
    };
    let caption = "The ankle in five activities. Positive is power into the leg. On stairs the power is measured; its split into \
                   torque and speed is an estimate."
        .to_string();
    figure("Power of the ankle", "stride in %", "power in W", activities.iter().map(line).collect(), caption)
}
