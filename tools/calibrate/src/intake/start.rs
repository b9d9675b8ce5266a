//! The temperatures at which a run starts.

use super::signals::SENSOR_ERROR;
use super::{FAR, Unusable, ambient};
use crate::experiment::{CELSIUS, Experiment, Run, Start};

/// Run declared to start at ambient temperature although every node deviates from it by more than any sensor error. A deviation beyond the
/// error of one working thermometer is a note, and the run starts as measured: the motor may be warm, or the ambient temperature that of
/// another place.
pub fn elsewhere(experiment: &mut Experiment) -> Option<Unusable> {
    off_ambient(experiment, |nodes| if nodes > 1 { SENSOR_ERROR } else { f64::INFINITY })
}

/// The same for a run with a single thermometer, after those that do not work were set aside: it may have an offset, but none of this size.
pub fn of_single_sensor(experiment: &mut Experiment) -> Option<Unusable> {
    off_ambient(experiment, |nodes| if nodes > 1 { f64::INFINITY } else { FAR })
}

/// Runs whose first temperatures all differ from the ambient one by more than `least` for their number, K.
fn off_ambient(experiment: &mut Experiment, least: impl Fn(usize) -> f64) -> Option<Unusable> {
    let column = experiment.inputs.iter().find(|c| c.is_ambient())?.column;
    let mut notes = Vec::new();
    let mut warm = Vec::new();
    for (r, run) in experiment.runs.iter().enumerate().filter(|(_, run)| run.start == Start::Ambient) {
        let Some(zero) = ambient(experiment, run).first().copied() else { continue };
        let nodes = first_rises(experiment, run, zero);
        let is_off = |least: f64| {
            let off = |sign: f64| nodes.iter().all(|(_, off)| sign * off > least);
            !nodes.is_empty() && (off(1.0) || off(-1.0))
        };
        if !is_off(least(nodes.len())) {
            continue;
        }
        let words: Vec<String> = nodes.iter().map(|(name, off)| format!("{name} by {off:.1} K")).collect();
        let reason = format!(
            "the first readings in {} differ from {column} ({:.1} degC): {}; a run starts at the ambient temperature",
            run.file,
            zero - CELSIUS,
            words.join(", ")
        );
        let alone = if let [(own, _)] = nodes[..] { format!(" and that of {own}") } else { String::new() };
        let suggestion = format!(
            "state start = \"measured\" in [[run]] if the motor was warm, else check the sensor of {column} and its place{alone}"
        );
        if is_off(FAR) {
            return Some(Unusable::new(column, reason, suggestion));
        }
        notes.push(format!("{reason}: {suggestion}; it is simulated from the measured temperatures"));
        warm.push(r);
    }
    experiment.notes.extend(notes);
    warm.into_iter().for_each(|r| experiment.runs[r].start = Start::Measured);
    None
}

/// First readings of each thermometer of the motor in a run, above this temperature, K: the nearest to it, because a motor at the ambient
/// temperature may warm up from one row to the next.
pub fn first_rises(experiment: &Experiment, run: &Run, zero: f64) -> Vec<(&'static str, f64)> {
    /// Number of first readings. Derivation: of three, one may be an outlier.
    const FIRST: usize = 3;
    let inputs = experiment.inputs.len();
    let first = |k: usize| {
        let rises = run.table.columns[inputs + k].iter().take(FIRST).map(|x| x - zero);
        rises.filter(|off| off.is_finite()).min_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    let nodes = experiment.outputs.iter().enumerate().filter(|(_, c)| c.node().is_some());
    nodes.filter_map(|(k, c)| Some((c.column, first(k)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::tests::{AMBIENT, HOUSING, WINDING, column, experiment};

    /// An open ambient sensor at any value and a motor that was warm are detected; an offset of a few kelvin is a note.
    #[test]
    fn a_run_that_starts_elsewhere_is_unusable() {
        for (shift, is_far) in [(-84.0, true), (107.0, true), (-15.0, true), (4.0, false), (0.0, false)] {
            let mut run = experiment(9);
            column(&mut run, AMBIENT).iter_mut().for_each(|x| *x += shift);
            let mut noted = run.clone();
            let found = elsewhere(&mut noted).map(|why| why.channel);
            assert_eq!(found.as_deref(), is_far.then_some("ambient_temperature_degC"), "{shift}");
            assert_eq!(noted.notes.len() - run.notes.len(), usize::from(shift == 4.0), "{:?}", noted.notes);
            run.runs[0].start = Start::Measured;
            assert_eq!(elsewhere(&mut run), None);
        }
    }

    /// With a single temperature sensor a difference that no working sensor has is detected, too; a smaller one is its offset.
    #[test]
    fn a_warm_motor_with_a_single_sensor_is_unusable() {
        for (shift, is_far) in [(35.0, true), (-22.0, true), (8.0, false), (0.0, false)] {
            let mut run = experiment(9);
            column(&mut run, HOUSING).fill(f64::NAN);
            column(&mut run, WINDING).iter_mut().for_each(|x| *x += shift);
            let notes = run.notes.len();
            assert_eq!(elsewhere(&mut run), None);
            let found = of_single_sensor(&mut run);
            assert_eq!(
                found.as_ref().is_some_and(|why| why.suggestion.contains("winding_temperature_degC")),
                is_far,
                "{shift} {found:?}"
            );
            assert_eq!(run.notes.len(), notes);
        }
    }
}
