//! Further run or reading that would distinguish two models between which the data cannot decide: predicted with both.
//!
//! Every output that a bench can measure is compared over the existing runs and over half-hour runs within the inputs' ranges, half of
//! each loaded and half at rest. The greatest difference is selected, in standard deviations of the noise for outputs measured in the
//! experiment, otherwise in hundredths of the output's greatest value.

use crate::experiment::{CHANNELS, Channel};
use crate::hypothesis::Hypothesis;
use crate::report::{column_words, words};
use crate::setup::Setup;
use crate::simulate::Drive;
use physics::model::{Model, Slot};

/// Rows of a proposed run, and their interval, s. Definition: half an hour in steps of a logger.
const ROWS: (usize, f64) = (180, 10.0);
/// Fractions of an input's greatest value at which it is held. Definition: rest, half and full load.
const LEVELS: [f64; 3] = [0.0, 0.5, 1.0];

/// Output that would differ.
struct Reading {
    name: String,
    unit: &'static str,
    slot: Slot,
    /// Standard deviation of its noise.
    noise: Option<f64>,
    is_temperature: bool,
}

/// Difference of two outputs that is not rounding, in SI units. Numerical: accuracy of the integration.
const LEAST: f64 = 1e-9;
/// An experiment must distinguish better by this factor than a gentler one, which comes first. Numerical: otherwise rounding would
/// decide between equal ones.
const CLEARER: f64 = 1.01;

/// Difference between the predictions.
struct Difference {
    sentence: String,
    levels: f64,
}

/// Sentence with the experiment that would distinguish the `other` model from `one`; `names` are their names.
pub fn separate(setup: &Setup, one: &Hypothesis, other: &Hypothesis, names: [&str; 2]) -> Option<String> {
    let readings = readings(setup);
    let mut best: Option<Difference> = None;
    let mut consider = |what: &str, drive: &Drive, run: usize, new: bool| {
        let Some(found) = compare(setup, [one, other], names, drive, run, &readings, what, new) else {
            return;
        };
        if best.as_ref().is_none_or(|b| found.levels > CLEARER * b.levels) {
            best = Some(found);
        }
    };
    let last = active_run(setup, one, other);
    for run in 0..setup.experiment.runs.len() {
        let file = &setup.experiment.runs[run].file;
        consider(&format!("repeat {file} and"), &setup.drives[run], run, false);
    }
    for (what, drive) in designs(setup) {
        consider(&what, &drive, last, true);
    }
    best.map(|found| found.sentence)
}

/// Three significant digits; whole numbers keep all of theirs.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - value.abs().log10().floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits as usize)
}

/// A run in which the additions of the models act.
fn active_run(setup: &Setup, one: &Hypothesis, other: &Hypothesis) -> usize {
    let all = |h: &Hypothesis, run: usize| h.additions.iter().filter(|a| a.active[run]).count();
    let runs = 0..setup.experiment.runs.len();
    runs.max_by_key(|run| all(one, *run) + all(other, *run)).unwrap_or(0)
}

fn readings(setup: &Setup) -> Vec<Reading> {
    let declaration = setup.bench.declaration();
    let measured = |c: &Channel| setup.experiment.outputs.iter().position(|o| o.column == c.column);
    let driven = |c: &Channel| setup.experiment.inputs.iter().any(|i| i.column == c.column);
    let channels = CHANNELS.iter().filter(|c| c.is_usual && !driven(c)).filter_map(|c| {
        let slot = declaration.by_name(c.output?)?.slot;
        let noise = measured(c).map(|output| setup.sigma(output));
        let (name, unit) = column_words(c.column);
        Some(Reading { name, unit, slot, noise, is_temperature: c.is_temperature() })
    });
    let resistance = declaration.by_name("winding_resistance").map(|entry| Reading {
        name: "winding resistance (at a short pause)".to_owned(),
        unit: entry.row.unit.name(),
        slot: entry.slot,
        noise: None,
        is_temperature: false,
    });
    channels.chain(resistance).collect()
}

/// Proposed runs within the inputs' ranges: every input at a level for half of the run, then at rest.
fn designs(setup: &Setup) -> Vec<(String, Drive)> {
    let inputs = &setup.experiment.inputs;
    let most: Vec<f64> =
        (0..inputs.len()).map(|k| setup.drives.iter().map(|d| d.greatest(k)).fold(0.0, f64::max)).collect();
    let rest: Vec<f64> = (0..inputs.len()).map(|k| setup.drives[0].input(k, 0)).collect();
    let moves: Vec<usize> =
        (0..inputs.len()).filter(|k| !inputs[*k].is_temperature() && most[*k] > 0.0).take(4).collect();
    let mut all = Vec::new();
    let mut counter = vec![0usize; moves.len()];
    loop {
        let (rows, step) = ROWS;
        let time: Vec<f64> = (0..rows).map(|k| step * k as f64).collect();
        let mut columns: Vec<Vec<f64>> = rest.iter().map(|x| vec![*x; rows]).collect();
        let mut what = Vec::new();
        for (place, k) in moves.iter().enumerate() {
            let level = LEVELS[counter[place]] * most[*k];
            columns[*k][1..rows / 2].fill(level);
            columns[*k][rows / 2..].fill(0.0);
            let (name, unit) = column_words(inputs[*k].column);
            what.push(format!("{name} = {} {unit}", rounded(level)).trim_end().to_owned());
        }
        all.push((
            format!("make a run with {} for a quarter of an hour, then at rest, and", what.join(", ")),
            Drive::of(time, columns),
        ));
        let mut place = 0;
        while place < counter.len() && counter[place] + 1 == LEVELS.len() {
            counter[place] = 0;
            place += 1;
        }
        if place == counter.len() {
            return all;
        }
        counter[place] += 1;
    }
}

#[allow(clippy::too_many_arguments)] // two models, a run and what is read of it
fn compare(
    setup: &Setup,
    [one, other]: [&Hypothesis; 2],
    [a_name, b_name]: [&str; 2],
    drive: &Drive,
    run: usize,
    readings: &[Reading],
    what: &str,
    new: bool,
) -> Option<Difference> {
    let show = |hypothesis: &Hypothesis| -> Option<Vec<Vec<f64>>> {
        let mut model = setup.bench.begin(drive, &setup.change(hypothesis, run)).ok()?;
        let mut all = vec![Vec::new(); readings.len()];
        let see = |model: &mut dyn Model, _: usize| {
            all.iter_mut().zip(readings).for_each(|(column, r)| column.push(model.get(r.slot)));
        };
        // A run that ends at a limit of validity could destroy the motor and is not proposed.
        let ending = setup.bench.along(drive, model.as_mut(), see).ok()?;
        ending.is_none().then_some(all)
    };
    let (a, b) = (show(one)?, show(other)?);
    let differences = readings.iter().enumerate().filter_map(|(k, reading)| {
        // An output that was already measured in an existing run did not distinguish the models.
        if !new && reading.noise.is_some() {
            return None;
        }
        let apart = a[k].iter().zip(&b[k]).enumerate().map(|(row, (x, y))| (row, x - y));
        let (row, apart) = apart.max_by(|p, q| p.1.abs().total_cmp(&q.1.abs()))?;
        let span = a[k].iter().chain(&b[k]).fold(0.0f64, |m, x| m.max((x - a[k][0]).abs()));
        let size =
            if reading.is_temperature { span } else { a[k].iter().fold(0.0f64, |m, x| m.max(x.abs())) };
        let (levels, unit) = match reading.noise {
            Some(noise) => (apart.abs() / noise, "standard deviations of the noise"),
            None => {
                let of = if reading.is_temperature { "% of the range" } else { "% of the largest value" };
                (100.0 * apart.abs() / size.max(LEAST), of)
            }
        };
        // An output that is nearly constant cannot distinguish models by hundredths of its value.
        (levels.is_finite() && apart.abs() > LEAST).then(|| Difference {
            sentence: format!(
                "{what} measure {}; after {:.0} s the predictions with {} and {} differ by {} ({levels:.0} {unit})",
                reading.name,
                drive.time[row] - drive.time[0],
                words(a_name),
                words(b_name),
                format!("{} {}", rounded(apart.abs()), reading.unit).trim_end(),
            ),
            levels,
        })
    });
    differences.max_by(|p, q| p.levels.total_cmp(&q.levels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    fn with(setup: &Setup, id: &str, size: f64) -> Hypothesis {
        Hypothesis { additions: vec![testing::addition(setup, id, size)], ..setup.preset() }
    }

    /// Drags that grow with the root and with the square of the speed are equal at the one speed of the run: a run at another speed
    /// distinguishes them by the shaft torque.
    #[test]
    fn another_speed_distinguishes_drags() {
        let experiment = testing::experiment("", false);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let (one, other) =
            (with(&setup, "iron_loss", 1e-4), with(&setup, "windage", 1e-4 * 400f64.sqrt() / 400f64.powi(2)));
        let runs = setup.show(&one, &[0]).unwrap().into_iter().zip(setup.show(&other, &[0]).unwrap());
        let apart =
            runs.flat_map(|(a, b)| a.into_iter().zip(b)).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-4, "{apart}");
        let sentence = separate(&setup, &one, &other, ["iron_loss", "windage"]).unwrap();
        assert!(
            sentence.starts_with("make a run with")
                && sentence.contains("the predictions with iron loss and windage differ by")
        );
        assert!(sentence.contains("speed = 200 rad/s") && !sentence.contains('_'), "{sentence}");
        // Friction power becomes heat: a temperature read to a thousandth distinguishes better than the torque.
        assert!(sentence.contains("measure winding temperature;"), "{sentence}");
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!(
            [0.0, 0.0012345, 20.978, 764.16, 1234.5].map(rounded),
            ["0", "0.00123", "21.0", "764", "1234"]
        );
    }

    /// The offset of a winding sensor without readings changes only that sensor's output.
    #[test]
    fn a_reading_that_was_not_taken_is_asked_for() {
        let mut experiment = testing::experiment("", true);
        let place = experiment.outputs.iter().position(|c| c.column == "winding_temperature_degC").unwrap();
        experiment.outputs.remove(place);
        let column = experiment.place_of(place);
        experiment.runs[0].table.columns.remove(column);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let (one, other) =
            (with(&setup, "winding_sensor_offset", 0.0), with(&setup, "winding_sensor_offset", 3.0));
        let sentence = separate(&setup, &one, &other, ["none", "offset"]).unwrap();
        assert!(
            sentence.contains("measure winding temperature;") && sentence.contains("differ by 3.00 K"),
            "{sentence}"
        );
        assert!(separate(&setup, &one, &one, ["a", "b"]).is_none());
    }
}
