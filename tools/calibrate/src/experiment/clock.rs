//! Detection of clock mismatch between files and between columns of a file.
//!
//! All files of a set share one clock, so two of them cannot overlap in time. Within a file, an output with an instantaneous
//! response must change in the row in which the input changes. Of all shifts l of such an output, l = 0 must then give the best
//! regression:
//!
//! dy(k + l) = sum_j b_j du_j(k) + rest,    R^2(l) = 1 - |rest|^2 / |dy|^2                          (1)
//!
//! d is the change from row to row. Electrical and mechanical channels respond instantaneously. For the winding, the *rate* of
//! temperature rise responds instantaneously to a change of its loss.
//! R^2 of n independent changes exceeds r by chance with a probability of about
//!
//! (1 - r)^((n - m) / 2),    n = (sum dy^2)^2 / sum dy^4                                             (2)
//!
//! where m is the number of inputs, and n is less than the number of rows if a few steps are most of the change. The longest section
//! without a gap is used. *Assumes* approximately equidistant rows. A shift common to all channels is not detectable, nor is a shift in a
//! run whose inputs are nearly constant.
//! *Source*: cross-correlation of increments, Ljung, System Identification (2nd ed., 1999), ch. 6.1.

use super::{Channel, Run};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Largest shift that is tested, rows. Numerical: longer shifts are found by the response of the model (`intake/clocks.rs`).
const FAR: usize = 40;
/// Largest number of rows that is evaluated. Numerical: a limit of effort.
const MOST_ROWS: usize = 8000;
/// Smallest number of rows for a meaningful test. Derivation: half of these rows remain inside of all shifts.
const LEAST_ROWS: usize = 4 * FAR;
/// Columns that respond instantaneously to each other.
const AT_ONCE: [&str; 7] = [
    "voltage_V",
    "supply_voltage_V",
    "current_A",
    "duty_1",
    "electrical_power_W",
    "speed_rad_per_s",
    "shaft_torque_Nm",
];
/// Columns that determine the loss of the winding.
const HEAT: [&str; 2] = ["current_A", "electrical_power_W"];
/// The column that responds to this loss.
const WINDING: &str = "winding_temperature_degC";

/// Least increase of R^2 from no shift to the best one. Derivation: (2) for the 80 inner rows of the shortest record.
const MORE: f64 = 0.25;
/// Probability of a false warning of (2), for all shifts. Definition: one of a thousand channels.
const CHANCE: f64 = 1e-3;
/// Least shift of an instantaneous response, rows. Derivation: the columns of a row are read within one interval.
const INSTANT: usize = 2;
/// Least shift of the winding, rows. Derivation: its second difference spreads over two rows more.
const WARMING: usize = 4;

/// Warnings about clocks, in sentences.
pub fn notes(inputs: &[&'static Channel], outputs: &[&'static Channel], runs: &[Run]) -> Vec<String> {
    let mut files: Vec<&Run> = Vec::new();
    for run in runs {
        // A file may appear in several roles; it is tested once.
        if !files.iter().any(|r| r.file == run.file) {
            files.push(run);
        }
    }
    let mut notes = overlaps(&files);
    for run in &files {
        for (k, output) in outputs.iter().enumerate() {
            notes.extend(shifted(run, inputs, output, &run.table.columns[inputs.len() + k]));
        }
    }
    notes
}

fn overlaps(files: &[&Run]) -> Vec<String> {
    let mut order: Vec<(&str, f64, f64)> = files
        .iter()
        .filter_map(|r| Some((r.file.as_str(), *r.table.time.first()?, *r.table.time.last()?)))
        .collect();
    if let [(_, begin, _), _, ..] = order.as_slice()
        && order.iter().all(|(_, other, _)| other == begin)
    {
        return vec![format!(
            "every file begins at {begin} s, so each has a clock of its own: what drifts from run to run cannot be seen"
        )];
    }
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut notes = Vec::new();
    let mut latest: Option<(&str, f64)> = None;
    for (file, begin, end) in order {
        if let Some((before, until)) = latest
            && begin <= until
        {
            notes.push(format!(
                "{file} begins at {begin} s, before {before} ends at {until} s: the clocks of the two do not agree"
            ));
        }
        if latest.is_none_or(|(_, until)| end > until) {
            latest = Some((file, end));
        }
    }
    notes
}

/// The rows of a run between two gaps that are most, at most [`MOST_ROWS`].
fn without_gap(run: &Run) -> Range<usize> {
    let ends: Vec<usize> = run.table.gaps().map(|row| row + 1).chain([run.table.time.len()]).collect();
    let begins = std::iter::once(0).chain(ends.iter().copied());
    let parts = begins.zip(&ends).map(|(from, to)| from..*to);
    let most = parts.max_by_key(|part| part.len()).unwrap_or(0..0);
    most.start..most.end.min(most.start + MOST_ROWS)
}

/// A sentence if inputs of other rows explain the output best.
fn shifted(run: &Run, inputs: &[&'static Channel], output: &Channel, column: &[f64]) -> Option<String> {
    let part = without_gap(run);
    let (time, column) = (&run.table.time[part.clone()], &column[part.clone()]);
    let rows = time.len();
    if rows < LEAST_ROWS {
        return None;
    }
    let is_winding = output.column == WINDING;
    let (drivers, least): (&[&str], usize) = match output.column {
        WINDING => (&HEAT, WARMING),
        name if AT_ONCE.contains(&name) => (&AT_ONCE, INSTANT),
        _ => return None,
    };
    let causes: Vec<Vec<f64>> = inputs
        .iter()
        .zip(&run.table.columns)
        .filter(|(channel, _)| drivers.contains(&channel.column))
        .map(|(channel, column)| {
            let squared = is_winding && channel.column == "current_A";
            let of = |x: &f64| if squared { x * x } else { *x };
            changes(&column[part.clone()].iter().map(of).collect::<Vec<_>>())
        })
        .collect();
    // Inner rows only, so that every shift uses the same number of rows.
    let inner = FAR..rows - 1 - FAR;
    let mut target = changes(column);
    if is_winding {
        target = changes(&target);
        target.push(0.0);
    }
    let matrix = DMatrix::from_fn(inner.len(), causes.len(), |k, j| causes[j][FAR + k]);
    let information = (matrix.transpose() * &matrix).cholesky()?;
    let explained = |shift: isize| {
        let from = (FAR as isize + shift) as usize;
        let y = DVector::from_column_slice(&target[from..from + inner.len()]);
        let b = matrix.transpose() * &y;
        b.dot(&information.solve(&b)) / y.norm_squared()
    };
    let far = FAR as isize;
    let (shift, best) = (-far..=far)
        .map(|l| (l, explained(l)))
        .filter(|(_, r)| r.is_finite())
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let near = (1 - least as isize..least as isize).map(explained).fold(0.0, f64::max);
    let [square, fourth] =
        [2, 4].map(|power| target[inner.clone()].iter().map(|y| y.powi(power)).sum::<f64>());
    let independent = square * square / fourth;
    let by_chance = 1.0
        - (CHANCE / (2 * FAR + 1) as f64)
            .powf(2.0 / (independent - causes.len() as f64).max(f64::MIN_POSITIVE));
    let seen = shift.unsigned_abs() >= least && best >= near + MORE.max(by_chance);
    seen.then(|| {
        let step = (time[rows - 1] - time[0]) / (rows - 1) as f64;
        let side = if shift > 0 { "after" } else { "before" };
        let (count, seconds) = (shift.unsigned_abs(), step * shift.unsigned_abs() as f64);
        format!(
            "{}: {} moves {count} rows (about {seconds:.3} s) {side} the inputs that move it: their clocks do not agree",
            run.file, output.column
        )
    })
}

/// Changes from row to row; NaN if one of the two readings is missing.
fn changes(column: &[f64]) -> Vec<f64> {
    let change = |w: &[f64]| if (w[1] - w[0]).is_finite() { w[1] - w[0] } else { 0.0 };
    column.windows(2).map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Role, Start, Table};
    use super::*;
    use rand::RngExt;

    const INPUTS: [&str; 2] = ["current_A", "speed_rad_per_s"];
    const OUTPUTS: [&str; 2] = ["voltage_V", WINDING];

    fn channels(columns: [&str; 2]) -> Vec<&'static Channel> {
        columns.iter().map(|c| Channel::of(c).unwrap()).collect()
    }

    /// A motor under steps of current every 60 rows of 2 s with noise, its outputs `late` rows late: voltage, winding.
    fn run(file: &str, begin: f64, late: [usize; 2]) -> Run {
        let mut rng = crate::testing::rng(7);
        let mut noise = || rng.random_range(-0.5..0.5);
        let time: Vec<f64> = (0..1200).map(|k| begin + 2.0 * f64::from(k)).collect();
        let current = |k: usize| [1.0, 6.0, 3.0, 8.0, 0.0][k / 60 % 5];
        let speed = |k: usize| [100.0, 400.0, 900.0][k / 100 % 3];
        let (mut winding, mut body) = (20.0, 20.0);
        let temperature: Vec<f64> = (0..1200)
            .map(|k| {
                let shown = winding;
                for _ in 0..20 {
                    let across = (winding - body) / 0.21;
                    winding += 0.1 * (0.39 * current(k) * current(k) - across) / 10.0;
                    body += 0.1 * (across - 0.14 * (body - 20.0)) / 150.0;
                }
                shown
            })
            .collect();
        let columns = vec![
            (0..1200).map(|k| current(k) + 0.01 * noise()).collect(),
            (0..1200).map(|k| speed(k) + noise()).collect(),
            (0..1200)
                .map(|k: usize| k.saturating_sub(late[0]))
                .map(|k| 0.39 * current(k) + 0.0276 * speed(k) + 0.05 * noise())
                .collect(),
            (0..1200).map(|k: usize| temperature[k.saturating_sub(late[1])] + 0.3 * noise()).collect(),
        ];
        let table = Table { time, columns, ..Table::default() };
        Run {
            priors: Vec::new(),
            file: file.to_string(),
            role: Role::Fit,
            window: None,
            start: Start::Ambient,
            set: Vec::new(),
            table,
        }
    }

    fn notes_of(runs: &[Run]) -> Vec<String> {
        notes(&channels(INPUTS), &channels(OUTPUTS), runs)
    }

    #[test]
    fn a_channel_on_another_clock_is_noted() {
        assert_eq!(notes_of(&[run("a.csv", 0.0, [0, 0])]), Vec::<String>::new());
        let late = notes_of(&[run("a.csv", 0.0, [3, 0])]);
        assert_eq!(late.len(), 1, "{late:?}");
        assert!(late[0].starts_with("a.csv: voltage_V moves 3 rows (about 6.000 s) after"), "{late:?}");
        let late = notes_of(&[run("a.csv", 0.0, [0, 12])]);
        assert_eq!(late.len(), 1, "{late:?}");
        assert!(late[0].starts_with("a.csv: winding_temperature_degC moves 12 rows"), "{late:?}");
        // The inputs are delayed: equivalent to outputs that lead.
        let mut early = run("a.csv", 0.0, [0, 0]);
        for column in &mut early.table.columns[..2] {
            column.rotate_right(5);
        }
        let early = notes_of(&[early]);
        assert!(
            early.len() == 2 && early.iter().all(|n| n.contains("5 rows (about 10.000 s) before")),
            "{early:?}"
        );
    }

    #[test]
    fn files_that_overlap_are_noted() {
        let at = |begin: f64, file: &str| run(file, begin, [0, 0]);
        assert_eq!(notes_of(&[at(0.0, "a.csv"), at(3000.0, "b.csv")]), Vec::<String>::new());
        // A file that is listed twice counts as one file.
        assert_eq!(
            notes_of(&[at(0.0, "a.csv"), at(0.0, "a.csv"), at(3000.0, "b.csv")]),
            Vec::<String>::new()
        );
        let found = notes_of(&[at(2000.0, "b.csv"), at(0.0, "a.csv"), at(5000.0, "c.csv")]);
        assert_eq!(
            found,
            ["b.csv begins at 2000 s, before a.csv ends at 2398 s: the clocks of the two do not agree"]
        );
        let found = notes_of(&[at(0.0, "a.csv"), at(0.0, "b.csv")]);
        assert!(found.len() == 1 && found[0].starts_with("every file begins at 0 s"), "{found:?}");
    }
}
