//! Clocks that were set during a run: a gap in the times across which the motor goes on as if none had passed.
//!
//! The simulation continues across a gap with the inputs between its two rows. A jump of the clock (summer time, a synchronisation) is a
//! gap in which each temperature changes by less than [`SMALL`] of what the fitted model predicts, where that is more than [`FACTOR`] times the
//! error of a thermometer. Where a load is switched to and fro beside the gap, these inputs are not those in the gap, and predict nothing.

use super::signals::{NEAR, SENSOR_ERROR};
use super::{Predicted, Unusable, range};
use crate::comparison::converted;
use crate::experiment::{Experiment, Run};
use crate::levels::{FACTOR, SMALL};

/// The first jump of a clock; `predicted` by run and output.
pub fn found(experiment: &Experiment, predicted: &Predicted) -> Option<Unusable> {
    let runs = experiment.runs.iter().zip(predicted);
    let (run, row, (name, measured, meant)) = runs
        .flat_map(|(run, model)| run.table.gaps().map(move |row| (run, model, row)))
        .find_map(|(run, model, row)| Some((run, row, jump(experiment, run, model, row)?)))?;
    let (from, to) = (run.table.time[row], run.table.time[row + 1]);
    let gap = converted(to - from);
    Some(Unusable::new(
        "time_s",
        format!(
            "time_s in {} goes from {from} s to {to} s in one row, while the motor goes on: {name} changes by {measured:.2} K, and by \
             {meant:.2} K in the model",
            run.file
        ),
        format!(
            "if the clock was set there (summer time, synchronisation), subtract about {gap} s from the later times of {}",
            run.file
        ),
    ))
}

/// The output whose change across a gap is most unlike the predicted one: its column, the measured and the predicted change; `None` if one
/// of them changes as time has passed.
fn jump(
    experiment: &Experiment,
    run: &Run,
    model: &[Vec<f64>],
    row: usize,
) -> Option<(&'static str, f64, f64)> {
    let outputs = experiment.outputs.iter().enumerate().filter(|(_, channel)| channel.is_temperature());
    let changes = outputs.filter_map(|(k, channel)| {
        let change = |column: &[f64]| column[row + 1] - column[row];
        let (measured, meant) = (change(&run.table.columns[experiment.place_of(k)]), change(model.get(k)?));
        (measured.is_finite() && meant.abs() > FACTOR * SENSOR_ERROR).then_some((
            channel.column,
            measured,
            meant,
        ))
    });
    let all: Vec<_> = changes.filter(|_| !alternates(experiment, run, row)).collect();
    let goes_on = all.iter().all(|(_, measured, meant)| measured.abs() < SMALL * meant.abs());
    all.into_iter().filter(|_| goes_on).max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
}

/// Whether a load changes twice or more within [`NEAR`] rows on either side of a gap.
fn alternates(experiment: &Experiment, run: &Run, row: usize) -> bool {
    let loads =
        experiment.inputs.iter().zip(&run.table.columns).filter(|(channel, _)| !channel.is_temperature());
    loads.into_iter().any(|(_, column)| {
        let least = SMALL * range(column.iter().copied());
        let near = &column[(row + 1).saturating_sub(NEAR)..(row + 1 + NEAR).min(column.len())];
        near.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > least).count() > 1
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::experiment;
    use super::super::{Refusal, check};
    use super::*;
    use crate::deadline::Deadline;

    /// Channel and suggestion if a run with this change is unusable.
    fn channel_after(change: impl Fn(&mut Experiment)) -> Option<String> {
        let mut data = experiment(7);
        change(&mut data);
        match check(&mut data, &[], &Deadline::default()) {
            Err(Refusal::Unusable(why)) => Some(format!("{} {}", why.channel, why.suggestion)),
            _ => None,
        }
    }

    #[test]
    fn a_clock_that_was_set_is_no_gap() {
        for (row, seconds) in [(75, 3600.0), (450, 900.0)] {
            let found =
                channel_after(|data| data.runs[0].table.time[row..].iter_mut().for_each(|t| *t += seconds));
            let found = found.unwrap();
            assert!(found.starts_with("time_s") && found.contains(&format!("{}", seconds + 3.0)), "{found}");
        }
        // A real gap: rows are missing, and the motor has gone on meanwhile.
        let (from, to) = (400, 700);
        let found = channel_after(|data| {
            let table = &mut data.runs[0].table;
            table.time.drain(from..to);
            table.columns.iter_mut().for_each(|column| drop(column.drain(from..to)));
        });
        assert!(found.is_none_or(|found| !found.starts_with("time_s")));
    }
}
