//! Modes of the preset that contradict the data: a bridge in another decay mode, a duty of 0 that brakes in place of coasting, another cooling.
//!
//! A mode that nobody stated in `[set]` is that of the preset. With a wrong one, no values of the parameters describe the data, and sensors look
//! dead that are right. Each other mode is a hypothesis without a number of its own. It is taken if the declared parameters describe the fit runs
//! with it, and not with the mode of the preset: if only a small part of the excess over the noise is left,
//!
//! X' < s X,   X = chi^2 / n - 1                                                                       (1)
//!
//! chi^2 of the fit by the noise of the readings, n their number, s [`SMALL`]. X has to be at least [`FACTOR`], more than the noise of the
//! inputs leaves.
//! *Source*: as for mistakes in columns (`consistency.rs`).

use crate::CalibrateError;
use crate::catalogue::is_of_an_effect;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::fit::Fitted;
use crate::levels::{FACTOR, SMALL};
use crate::parallel;
use crate::setup::{Setup, Shown};
use physics::declare::{Causality, Item, Kind};
use std::time::Instant;

/// Part of the time for the checks in which other modes are tried, those that are simulated fastest first. Numerical: a limit of effort; a fit of
/// a cooling mode with a network of nodes takes a thousand times as long as one without.
const SHARE: f64 = 1.0 / 32.0;

/// Takes the mode by which the data agree with the model, with a note.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn correct(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<(), CalibrateError> {
    let runs: Vec<usize> =
        (0..experiment.runs.len()).filter(|run| experiment.runs[*run].role == Role::Fit).collect();
    // As many rows as a search has: a fast logger's fits are not made twice.
    let means = experiment.of_means();
    let own = means.as_ref().unwrap_or(experiment);
    let deadline = &deadline.share(SHARE);
    let as_is = setup(own, preset, deadline)?;
    let fitted = |setup: &Setup| setup.fit(setup.preset(), &runs).ok().as_ref().map(excess);
    let Some(before) = fitted(&as_is).filter(|excess| *excess > FACTOR) else { return Ok(()) };
    let Ok(shown) = as_is.show(&as_is.preset(), &runs) else { return Ok(()) };
    let with = |(name, item): (String, &'static Item)| {
        let mut other = own.clone();
        other.set.push((name.clone(), f64::from(item.value)));
        (other, name, item)
    };
    let all: Vec<_> = unstated(&as_is).into_iter().map(with).collect();
    let mut others = Vec::new();
    for (other, name, item) in &all {
        let begun = Instant::now();
        let setup = setup(other, preset, deadline)?;
        if setup.show(&setup.preset(), &runs).is_ok_and(|other| differs(&shown, &other)) {
            others.push((begun.elapsed(), setup, name, item));
        }
    }
    others.sort_by_key(|(time, ..)| *time);
    let found =
        parallel::map(&others, |(_, setup, ..)| if deadline.is_near() { None } else { fitted(setup) });
    let best = found.into_iter().zip(&others).filter_map(|(left, other)| Some((left?, other)));
    let best = best.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(left, _)| *left < SMALL * before);
    let Some((left, &(_, _, name, item))) = best else { return Ok(()) };
    experiment.set.push((name.clone(), f64::from(item.value)));
    experiment.notes.push(format!(
        "the mode {name} of the preset contradicts the data: with {name} = \"{}\" the declared parameters describe the fit runs to {:.2} times \
         their noise, otherwise to {:.2} times; it was used, add it to [set]",
        item.name,
        (1.0 + left.max(0.0)).sqrt(),
        (1.0 + before).sqrt()
    ));
    Ok(())
}

fn setup<'a>(
    experiment: &'a Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Setup<'a>, CalibrateError> {
    Ok(Setup::new(experiment, preset)?.until(deadline.clone()))
}

/// Every other item of the modes that neither the experiment nor its inputs state.
fn unstated(setup: &Setup) -> Vec<(String, &'static Item)> {
    let open = setup.bench.declaration().entries.iter().filter(|entry| {
        entry.row.causality == Causality::Parameter
            && !is_of_an_effect(&entry.name)
            && !setup.experiment.sets(&entry.name)
    });
    let items = open.filter_map(|entry| match entry.row.kind {
        Kind::Enumeration(table) => Some((entry, table.items)),
        _ => None,
    });
    let others = items.flat_map(|(entry, items)| {
        let own = setup.bench.start_of(entry.slot);
        let other = items.iter().filter(move |item| f64::from(item.value) != own);
        other.map(|item| (entry.name.clone(), item))
    });
    others.collect()
}

/// Whether predictions differ at all.
fn differs(own: &[Shown], other: &[Shown]) -> bool {
    own.iter().flatten().zip(other.iter().flatten()).any(|(a, b)| a != b)
}

/// X of (1).
fn excess(fitted: &Fitted) -> f64 {
    fitted.chi_square / fitted.readings as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    const MODE: &str = "cooling_mode";

    /// Readings of a motor in cooling mode conductance, which the experiment does not state; the value of an item, and that mode in a preset.
    fn read() -> (Experiment, impl Fn(&str) -> f64, u32) {
        let mut experiment = testing::experiment(testing::PRIORS, true);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        experiment.set.retain(|(name, _)| name != MODE);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let row = &setup.bench.declaration().by_name(MODE).unwrap().row;
        let (Kind::Enumeration(table), reference) = (row.kind, row.value_reference) else { panic!() };
        let item = |name: &str| f64::from(table.items.iter().find(|item| item.name == name).unwrap().value);
        (experiment, item, reference)
    }

    #[test]
    fn another_mode_is_taken_if_the_data_agree_with_it() {
        for (own, asked) in [("conductance", 0), ("bare", 1)] {
            let (mut experiment, item, reference) = read();
            let stated = experiment.set.len();
            correct(&mut experiment, &[(reference, item(own))], &Deadline::default()).unwrap();
            let taken = &experiment.set[stated..];
            assert_eq!(taken.len(), asked, "{taken:?}");
            assert!(taken.iter().all(|(name, value)| name == MODE && *value == item("conductance")));
            assert_eq!(experiment.notes.iter().filter(|note| note.contains(MODE)).count(), asked);
        }
    }

    /// A mode that the experiment states stays, and what no mode describes is no other mode.
    #[test]
    fn other_modes_stay() {
        let (mut experiment, item, reference) = read();
        experiment.set.push((MODE.to_string(), item("bare")));
        let stated = experiment.set.clone();
        correct(&mut experiment, &[], &Deadline::default()).unwrap();
        assert_eq!(experiment.set, stated);
        let (mut experiment, ..) = read();
        let (stated, voltage) = (experiment.set.clone(), experiment.place_of(0));
        let column = &mut experiment.runs[0].table.columns[voltage];
        let half = column.len() / 2;
        column[half..].iter_mut().for_each(|v| *v += 2.0);
        correct(&mut experiment, &[(reference, item("bare"))], &Deadline::default()).unwrap();
        assert_eq!(experiment.set, stated);
    }
}
