//! Figures of the gait.

use super::{Captioned, figure};
use crate::native::Native;
use describe::Kind;

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

/// Torque and speed of the load table.
pub fn load_table(native: &Native<'_>) -> Option<Captioned> {
    let period = native.resources.load.as_ref()?.period;
    let table = [("gait.activity", "table")];
    let line = |(name, output): (&str, &str)| (name.to_owned(), stride(native, output, &table));
    let lines = [("torque in N\u{b7}m", "torque_demand"), ("speed in rad/s", "joint_speed")].map(line);
    let caption = format!("Load table of this FMU; the period is {period} s.");
    figure("Torque and speed of the load table", "period in %", "torque, speed", Vec::from(lines), caption)
}

/// The torque of each joint.
pub fn torques(native: &Native<'_>) -> Option<Captioned> {
    let joints = choices(native, "gait.joint");
    let line = |joint: &&str| {
        let walk = [("gait.joint", *joint), ("gait.activity", "walk")];
        (joint.to_string(), stride(native, "torque_demand", &walk))
    };
    let caption = format!(
        "{}. Body mass {} kg, support {}. Positive is extension, plantarflexion at the ankle; the stride begins \
         at heel strike.",
        source(native, "walk")?,
        native.starts.of(native.entry("gait.body_mass")?),
        native.starts.of(native.entry("gait.support")?)
    );
    figure("Torque over a stride", "stride in %", "torque in N·m", joints.iter().map(line).collect(), caption)
}

/// Subjects and publication of an activity, from its declaration.
fn source(native: &Native<'_>, activity: &str) -> Option<&'static str> {
    match native.entry("gait.activity")?.row.kind {
        Kind::Enumeration(t) => t.items.iter().find(|i| i.name == activity).map(|i| i.doc.trim()),
        _ => None,
    }
}

/// The power of the ankle in several activities.
pub fn powers(native: &Native<'_>) -> Option<Captioned> {
    let activities = ["walk", "stairs_up", "stairs_down", "child_walk"];
    let label = |a: &str| a.replace('_', " ");
    let line = |activity: &&str| {
        let ankle = [("gait.joint", "ankle"), ("gait.activity", *activity)];
        (label(activity), stride(native, "power_demand", &ankle))
    };
    let sources: Option<Vec<String>> =
        activities.iter().map(|a| source(native, a).map(|text| format!("{}: {text}", label(a)))).collect();
    let caption = format!("Positive is power into the leg. {}.", sources?.join(". "));
    figure("Power of the ankle", "stride in %", "power in W", activities.iter().map(line).collect(), caption)
}
