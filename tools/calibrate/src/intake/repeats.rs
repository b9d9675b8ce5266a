//! Readings that a slower instrument repeats: a scanner that comes to each thermometer once in ten seconds, a meter that is polled less often
//! than the rows are written. Each reading is of the time of its first row; the others are no readings, and taken as such they look like a
//! sensor that lags by half of the interval, has no noise, and jumps.

use crate::experiment::Experiment;
use crate::noise::{self, LONGEST};
use crate::report::count_of;

/// Sets aside the repeated readings of the outputs, with notes; those of the inputs as well if the logger repeats all channels: the row is one
/// reading. Otherwise an input that is constant for some rows was commanded so.
pub fn set_aside(experiment: &mut Experiment) {
    let inputs = experiment.inputs.len();
    for run in 0..experiment.runs.len() {
        let outputs: Vec<usize> = (inputs..inputs + experiment.outputs.len()).collect();
        let is_read = |k: &usize| experiment.runs[run].table.columns[*k].iter().any(|x| x.is_finite());
        let read = outputs.iter().filter(|k| is_read(k)).count();
        let repeated: Vec<usize> = outputs.into_iter().filter(|k| without(experiment, run, *k)).collect();
        if !repeated.is_empty() && repeated.len() == read {
            (0..inputs).for_each(|k| {
                without(experiment, run, k);
            });
        }
    }
}

/// Sets aside the repeated readings of a channel in a run; whether there are any.
fn without(experiment: &mut Experiment, run: usize, k: usize) -> bool {
    let inputs = experiment.inputs.len();
    let channel = if k < inputs { experiment.inputs[k] } else { experiment.outputs[k - inputs] };
    let own = &mut experiment.runs[run];
    let (time, column) = (&own.table.time, &mut own.table.columns[k]);
    let known: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    let (time, values): (Vec<f64>, Vec<f64>) = known.iter().map(|row| (time[*row], column[*row])).unzip();
    // What follows the inputs at once is constant as long as they are; a temperature of the motor is not.
    let held = match channel.is_temperature() && k >= inputs {
        true => noise::held(&time, &values, usize::MAX).or_else(|| noise::repeated(&values)),
        false => noise::held(&time, &values, LONGEST),
    };
    let Some(held) = held else { return false };
    known.iter().zip(held).filter(|(_, held)| *held).for_each(|(row, _)| column[*row] = f64::NAN);
    let new = column.iter().filter(|x| x.is_finite()).count();
    experiment.notes.push(format!(
        "{}: {} has a new reading in {} of {} only; the repeated ones are set aside",
        own.file,
        channel.column,
        count_of(new, "row"),
        known.len()
    ));
    true
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::super::tests::{HOUSING, SPEED, VOLTAGE, WINDING, experiment};
    use super::*;
    use crate::deadline::Deadline;

    /// Each reading is repeated until the next one, which comes every so many rows.
    fn hold(data: &mut Experiment, k: usize, rows: usize, first: usize) {
        let column = &mut data.runs[0].table.columns[k];
        let read = column.clone();
        column.iter_mut().enumerate().for_each(|(row, x)| {
            *x = read[((row + rows - first) / rows * rows + first).saturating_sub(rows)]
        });
    }

    /// One thermometer or both, with a scan at a different place of the interval: the readings left are those of the scans, and good.
    #[test]
    fn a_scanner_leaves_the_readings_of_its_scans() {
        for (rows, both) in [(4, true), (11, false), (30, true)] {
            let (mut data, whole) = (experiment(31), experiment(31));
            hold(&mut data, WINDING, rows, 0);
            if both {
                hold(&mut data, HOUSING, rows, rows / 2);
            }
            assert_eq!(check(&mut data, &[], &Deadline::default()), Ok(true), "{:?}", data.notes);
            let (own, all) = (&data.runs[0].table.columns, &whole.runs[0].table.columns);
            let left: Vec<usize> = (0..1200).filter(|row| own[WINDING][*row].is_finite()).collect();
            assert!(left.len().abs_diff(1200 / rows) < 3, "{} of {rows}", left.len());
            assert!(left.iter().all(|row| own[WINDING][*row] == all[WINDING][*row]));
            let wrong: Vec<&String> =
                data.notes.iter().filter(|note| !note.contains("a new reading in")).collect();
            assert!(wrong.is_empty(), "{wrong:?}");
        }
    }

    /// A logger that writes each row several times; where one output is read in each row, the inputs are as they were commanded.
    #[test]
    fn a_row_that_is_written_several_times_is_one() {
        let mut data = experiment(32);
        (0..8).for_each(|k| hold(&mut data, k, 5, 0));
        let mut one = data.clone();
        one.runs[0].table.columns[VOLTAGE] = experiment(32).runs[0].table.columns[VOLTAGE].clone();
        set_aside(&mut data);
        set_aside(&mut one);
        let new = |data: &Experiment, k: usize| {
            data.runs[0].table.columns[k].iter().filter(|x| x.is_finite()).count()
        };
        assert!((238..=242).contains(&new(&data, SPEED)), "{}", new(&data, SPEED));
        assert_eq!((new(&one, SPEED), new(&one, VOLTAGE)), (1200, 1200));
        assert!(new(&one, HOUSING) < 243);
    }
}
