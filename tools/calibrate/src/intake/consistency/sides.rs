//! Torques and speeds that were recorded on the other side of a transmission: at the motor instead of behind the gear.

use super::conversions::OTHER_SIDE;
use super::mistakes::{Mistake, channels};
use crate::comparison::digits;
use crate::experiment::Experiment;
use crate::intake::declaration;
use physics::declare::Unit;
use physics::model::Entry;

/// Factors of a torque or speed that was recorded on the other side of a transmission, with a description of the readings: the torque of
/// the motor is that of the load divided by the ratio, its speed that of the load times the ratio.
fn factors(of: Unit, name: &str, ratio: f64) -> Vec<(f64, String)> {
    let [of_motor, of_load] = match of {
        Unit::NewtonMetre => [ratio, 1.0 / ratio],
        Unit::RadianPerSecond => [1.0 / ratio, ratio],
        _ => return Vec::new(),
    };
    let of = |factor: f64, side: &str| {
        let times = if factor < 1.0 {
            format!("divided by {}", digits(1.0 / factor))
        } else {
            format!("times {}", digits(factor))
        };
        (factor, format!("readings {times} (as of the {side}'s{OTHER_SIDE}{name})"))
    };
    vec![of(of_motor, "motor"), of(of_load, "load")]
}

/// Torques and speeds of the other side of a transmission of the model with this preset.
pub fn of_transmissions(experiment: &Experiment, preset: &[(u32, f64)]) -> Vec<Mistake> {
    let Some(declaration) = declaration(experiment) else { return Vec::new() };
    let ratios = declaration.entries.iter().filter(|entry| entry.name.ends_with(".ratio"));
    let value = |entry: &Entry| {
        let set = experiment.set.iter().find(|(name, _)| *name == entry.name).map(|(_, value)| *value);
        let of_preset =
            || preset.iter().find(|(known, _)| *known == entry.value_reference).map(|(_, value)| *value);
        set.or_else(of_preset).unwrap_or(entry.row.start)
    };
    let mut found = Vec::new();
    for entry in ratios {
        for (k, channel) in channels(experiment).into_iter().enumerate() {
            let sides = factors(channel.unit, &entry.name, value(entry)).into_iter();
            found.extend(sides.map(|(factor, words)| Mistake::Affine {
                columns: vec![k],
                factor,
                offset: 0.0,
                words,
            }));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// 1 N.m of a load behind a gear of 86 is 1/86 N.m of its motor, which turns 86 times as fast.
    #[test]
    fn sides_of_a_gear() {
        let factor = |unit: Unit| factors(unit, "gear.ratio", 86.0)[0].0;
        assert!((factor(Unit::NewtonMetre) / 86.0 - 1.0).abs() < 1e-12);
        assert!((factor(Unit::RadianPerSecond) * 86.0 - 1.0).abs() < 1e-12);
        assert!(factors(Unit::Ampere, "gear.ratio", 86.0).is_empty());
        let words = &factors(Unit::RadianPerSecond, "gear.ratio", 86.0)[0].1;
        assert_eq!(words, "readings divided by 86.0 (as of the motor's side of gear.ratio)");
    }

    /// The ratio is that of `[set]`, of the preset, or of the model; a motor without a gear has no other side.
    #[test]
    fn the_ratio_is_that_of_the_experiment() {
        let mut experiment = testing::experiment("", false);
        assert_eq!(of_transmissions(&experiment, &[]), []);
        experiment.model = "BrushedGearmotor".to_string();
        let ratio = declaration(&experiment).unwrap().by_name("gear.ratio").unwrap();
        let speed = |experiment: &Experiment, preset: &[(u32, f64)]| match &of_transmissions(
            experiment, preset,
        )[..]
        {
            [Mistake::Affine { columns, factor, .. }, ..] => (columns[0], 1.0 / factor),
            other => panic!("{other:?}"),
        };
        assert_eq!(speed(&experiment, &[]), (1, ratio.row.start));
        assert_eq!(speed(&experiment, &[(ratio.value_reference, 64.0)]), (1, 64.0));
        experiment.set.push(("gear.ratio".to_string(), 16.0));
        assert_eq!(speed(&experiment, &[(ratio.value_reference, 64.0)]), (1, 16.0));
    }
}
