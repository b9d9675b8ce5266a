//! Readings that belong to other times than the inputs beside them: a channel that is filtered, averaged, held, or late by a varying time.
//!
//! With an imposed speed voltage, current and torque follow the inputs at once:
//!
//! y(t) = q(t) + c_u sum_j h_j [u(t - tau_j) - u(t)] + e,   q = a + b p + c^T u                       (1)
//!
//! with the readings y, the prediction p of the preset, the inputs u in the same row, a polynomial f of degree 2 with cubes, which an effect
//! at these inputs may need, c_u the mean dq/du, and a finite impulse response h over times tau before and after the row; only changes that
//! are no noise count. The sum of h is the fraction of a change of u that is read at other
//! times: 0 for readings at the time of the inputs, 1 behind a filter, negative behind a filter of the input. A missing effect with a lag has
//! a small fraction. The rows around changes are set aside. The others, before which the load was constant for long enough, are right,
//! whatever the reason is, which a constant delay ([`super::clocks`]) or the lag of an input (`consistency`) states better.
//! Most runs must agree, as a filter belongs to the instrument.
//! *Source*: finite impulse response by least squares: Ljung, System Identification (2nd ed., 1999), ch. 4.2 and 10.1.

use super::clocks::LEAST;
use super::filtered::{self, Place};
use super::response::{CLEAR, ENOUGH};
use super::{Predicted, Unusable, all_runs, predicted};
use crate::comparison::converted;
use crate::deadline::Deadline;
use crate::experiment::Experiment;
use crate::levels::{FACTOR, PART, SURE};
use crate::noise;
use crate::numbers::{between, interval};
use crate::report::count_of;
use nalgebra::{DMatrix, DVector};

/// Fraction of a change that is read at other times. Definition: the majority.
pub(super) const MAJORITY: f64 = 0.5;
/// The times of h before and after a row, in rows. Numerical: a longer filter is seen as one of this length.
const TIMES: [f64; 10] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0];
/// The longest of these times, s. Limit: instruments average over a minute at most; what follows a load for longer is an effect with a lag.
pub(super) const LONGEST: f64 = 64.0;
/// Fewest readings for each weight of q. Numerical: fewer are fitted by chance.
const PER_WEIGHT: usize = 10;
/// Least fraction of the readings that is left. Numerical: fewer are of one load, which the weights of q fit by chance.
const LEFT: f64 = 0.2;
/// Relative addition to the diagonal of the normal equations. Numerical: neighbouring times are nearly collinear.
const RIDGE: f64 = 1e-4;

/// Sets aside the rows of voltage, current and torque around changes of the load, with a note, in each run in which they belong to
/// other times.
pub fn set_aside(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Option<Unusable> {
    let is_imposed = experiment.inputs.iter().any(|c| c.input == Some("imposed_speed"));
    let fast: Vec<usize> = (0..experiment.outputs.len())
        .filter(|k| is_imposed && experiment.outputs[*k].node().is_none())
        .collect();
    if fast.is_empty() {
        return None;
    }
    let predicted: Predicted = predicted(experiment, preset, &all_runs(experiment), deadline);
    let mut late: Vec<(Place, Found)> = Vec::new();
    for output in fast {
        let of = |(run, model): (usize, &Vec<Vec<f64>>)| {
            let own = found(experiment, model, run, output)?;
            Some((Place { output, run, least: own.of_kept }, own))
        };
        let all: Vec<(Place, Found)> = predicted.iter().enumerate().filter_map(of).collect();
        let is_read = |run: &usize| {
            experiment.readings(*run, output).iter().filter(|y| y.is_finite()).count() >= ENOUGH
        };
        // A filter belongs to the instrument and not to a run.
        if 2 * all.len() > all_runs(experiment).iter().filter(|run| is_read(run)).count() {
            late.extend(all);
        }
    }
    let places: Vec<Place> = late.iter().map(|(place, _)| *place).collect();
    let input = if places.is_empty() { None } else { filtered::input(experiment, preset, &places, deadline) };
    if input.is_some() {
        return input;
    }
    for own in late.chunk_by(|a, b| a.0.output == b.0.output) {
        let least: Vec<f64> = own.iter().map(|(place, _)| place.least).collect();
        let read: Option<Vec<_>> =
            own.iter().map(|(place, _)| filtered::as_is(experiment, &predicted[place.run], place)).collect();
        let filter = read.and_then(|read| filtered::output(&read, &least));
        for (n, (place, found)) in own.iter().enumerate() {
            let (what, rows) = match &filter {
                Some((filter, rows)) => (format!("is behind {filter}"), &rows[n]),
                None => (found.words(), &found.rows),
            };
            blank(experiment, place, &what, rows);
        }
    }
    None
}

/// Sets aside these readings, with a note.
fn blank(experiment: &mut Experiment, place: &Place, what: &str, rows: &[usize]) {
    let (column, channel) = (experiment.place_of(place.output), experiment.outputs[place.output].column);
    let own = &mut experiment.runs[place.run];
    rows.iter().for_each(|row| own.table.columns[column][*row] = f64::NAN);
    let verb = if rows.len() == 1 { "is" } else { "are" };
    let count = count_of(rows.len(), "reading");
    experiment
        .notes
        .push(format!("{}: {channel} {what}; {count} around changes of the load {verb} set aside", own.file));
}

/// Rows whose readings belong to other times, and the greatest distance before and after a row from which they are, s.
struct Found {
    rows: Vec<usize>,
    span: [f64; 2],
    /// Mean square of the residual of the other rows.
    of_kept: f64,
}

impl Found {
    fn words(&self) -> String {
        let [before, after] = self.span.map(converted);
        format!(
            "does not follow the inputs at the same row, but up to {before} s earlier or {after} s later, as behind a filter or a hold, or on \
             another clock: this channel, or an input"
        )
    }
}

/// Known readings of an output in a run.
pub(super) struct Readings {
    pub(super) rows: Vec<usize>,
    pub(super) time: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// The inputs, standardized.
    inputs: Vec<Vec<f64>>,
    /// What is equal to q but for its weights.
    pub(super) levels: Vec<Vec<f64>>,
}

/// u(t - tau) - u(t) in each row, times c_u, for one tau; 0 where it is noise.
struct Tap {
    tau: f64,
    change: Vec<f64>,
}

/// Rows around changes and the others, with the mean square of the others' residual, for one span as in [`Found`].
struct Tried {
    of_kept: f64,
    aside: Vec<usize>,
    kept: Vec<usize>,
    span: [f64; 2],
}

fn found(experiment: &Experiment, model: &[Vec<f64>], run: usize, output: usize) -> Option<Found> {
    let readings = Readings::new(experiment, model, run, output)?;
    let all: Vec<usize> = (0..readings.rows.len()).collect();
    let q = fitted(&readings.levels, &readings.y, &all)?;
    let of_inputs = solved(&readings.inputs.iter().collect::<Vec<_>>(), &q, &all)?;
    let step = readings.step();
    let mut taps: Vec<Tap> = Vec::new();
    for (input, weight) in readings.inputs.iter().zip(&of_inputs[1..]) {
        let part: Vec<f64> = input.iter().map(|u| weight * u).collect();
        let own = readings.taps(&part, step)?;
        if readings.is_elsewhere(&q, &own)? {
            taps.extend(own);
        }
    }
    if taps.is_empty() { None } else { readings.around(&taps, step, &q) }
}

impl Readings {
    /// Those of an output in a run, `None` if they are too few.
    pub(super) fn new(
        experiment: &Experiment,
        model: &[Vec<f64>],
        run: usize,
        output: usize,
    ) -> Option<Readings> {
        let table = &experiment.runs[run].table;
        let (read, p) = (experiment.readings(run, output), model.get(output)?);
        let inputs = &table.columns[..experiment.inputs.len()];
        let is_known =
            |row: &usize| inputs.iter().chain([p]).all(|c| c[*row].is_finite()) && read[*row].is_finite();
        let rows: Vec<usize> = (0..read.len()).filter(is_known).collect();
        let of = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let inputs: Vec<Vec<f64>> = inputs.iter().filter_map(|c| standardized(&of(c))).collect();
        let levels = static_functions(inputs.iter().cloned().chain(standardized(&of(p))).collect());
        let readings = Readings { time: of(&table.time), y: of(read), inputs, levels, rows };
        let enough = (PER_WEIGHT * readings.levels.len()).max(ENOUGH);
        (readings.rows.len() >= enough).then_some(readings)
    }

    /// Usual interval between the rows, s.
    pub(super) fn step(&self) -> f64 {
        interval([&self.time[..]])
    }

    /// Mean square of what q leaves.
    pub(super) fn left(&self) -> Option<f64> {
        self.behind(<[f64]>::to_vec)
    }

    /// The same with q behind a filter.
    pub(super) fn behind(&self, filter: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
        let columns: Vec<Vec<f64>> = self.levels.iter().map(|column| filter(column)).collect();
        let all: Vec<usize> = (0..self.rows.len()).collect();
        Some(mean_square(&self.y, &fitted(&columns, &self.y, &all)?, &all))
    }

    /// The changes of a part of q that are no noise.
    fn taps(&self, part: &[f64], step: f64) -> Option<Vec<Tap>> {
        let sigma = noise::of_column(&self.time, &self.y)?.hypot(noise::of_column(&self.time, part)?);
        let times = times(step).flat_map(|tau| [tau, -tau]);
        let taps = times.map(|tau| Tap { tau, change: changes(&self.time, part, tau, CLEAR * sigma) });
        Some(taps.filter(|tap| tap.change.iter().any(|x| *x != 0.0)).collect())
    }

    /// Whether the majority of the changes is read at other times, by (1).
    fn is_elsewhere(&self, q: &[f64], taps: &[Tap]) -> Option<bool> {
        if taps.is_empty() {
            return Some(false);
        }
        let all: Vec<usize> = (0..self.rows.len()).collect();
        let columns: Vec<&Vec<f64>> = self.levels.iter().chain(taps.iter().map(|tap| &tap.change)).collect();
        let weights = solved(&columns, &self.y, &all)?;
        let full = sum_of(&columns, &weights, all.len());
        let gain =
            all.len() as f64 * (mean_square(&self.y, q, &all) / mean_square(&self.y, &full, &all)).ln();
        let fraction: f64 = weights[1 + self.levels.len()..].iter().sum();
        Some(gain > LEAST && fraction.abs() > MAJORITY)
    }

    /// The fewest rows around changes without which the others agree with their inputs as well as without any more; all rows, if these still
    /// follow the inputs of other times. `None` if no row agrees much better than the others.
    fn around(&self, taps: &[Tap], step: f64, q: &[f64]) -> Option<Found> {
        let noise = [&self.y[..], q].map(|of| noise::of_column(&self.time, of));
        let noise: f64 = noise.iter().flatten().map(|sigma| sigma * sigma).sum();
        let sides = || [0.0].into_iter().chain(times(step));
        let spans = sides().flat_map(|before| sides().map(move |after| [before, after]));
        let mut tried: Vec<Tried> = Vec::new();
        for span in spans {
            let is_in = |tap: &&Tap| (-span[1]..=span[0]).contains(&tap.tau);
            let is_around = |row: &usize| taps.iter().filter(is_in).any(|tap| tap.change[*row] != 0.0);
            let (aside, kept): (Vec<usize>, Vec<usize>) = (0..self.rows.len()).partition(is_around);
            if kept.len() as f64 >= LEFT * self.rows.len() as f64 && !aside.is_empty() {
                let at_rest = fitted(&self.levels, &self.y, &kept)?;
                tried.push(Tried { of_kept: mean_square(&self.y, &at_rest, &kept), aside, kept, span });
            }
        }
        let least = tried.iter().map(|one| one.of_kept).fold(f64::INFINITY, f64::min).max(noise);
        // The mean square of n readings is known to sqrt(2 / n).
        let is_as_good =
            |one: &Tried| one.of_kept <= (1.0 + SURE * (2.0 / one.kept.len() as f64).sqrt()) * least;
        let as_good = tried.into_iter().filter(is_as_good);
        let Tried { of_kept, aside, kept, span } = as_good.min_by_key(|one| one.aside.len())?;
        let columns: Vec<&Vec<f64>> = self.levels.iter().chain(taps.iter().map(|tap| &tap.change)).collect();
        let full = sum_of(&columns, &solved(&columns, &self.y, &kept)?, self.rows.len());
        if mean_square(&self.y, &full, &kept) < (1.0 - PART) * of_kept {
            return Some(Found { rows: self.rows.clone(), span, of_kept });
        }
        let at_rest = fitted(&self.levels, &self.y, &kept)?;
        if mean_square(&self.y, &at_rest, &aside) < FACTOR.powi(2) * of_kept {
            return None;
        }
        let rows = aside.iter().map(|k| self.rows[*k]).collect();
        Some(Found { rows, span, of_kept })
    }
}

fn times(step: f64) -> impl Iterator<Item = f64> {
    TIMES.into_iter().map(move |rows| rows * step).filter(|tau| *tau <= LONGEST)
}

/// These columns with their products of two and their cubes: a missing effect is a function of the same row.
fn static_functions(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(x, y)| x * y).collect() };
    let mut all = columns.clone();
    for (k, own) in columns.iter().enumerate() {
        let squares = columns[k..].iter().map(|other| product(own, other));
        all.extend(squares.chain([product(own, &product(own, own))]).filter_map(|c| standardized(&c)));
    }
    all
}

/// Mean 0 and mean square 1; `None` for a constant.
fn standardized(column: &[f64]) -> Option<Vec<f64>> {
    let n = column.len() as f64;
    let mean = column.iter().sum::<f64>() / n;
    let size = (column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    (size > f64::EPSILON * mean.abs()).then(|| column.iter().map(|x| (x - mean) / size).collect())
}

/// u(t - tau) - u(t) in each row; 0 where it is less than `least` or unknown.
fn changes(time: &[f64], u: &[f64], tau: f64, least: f64) -> Vec<f64> {
    let known = time[0]..=time[time.len() - 1];
    let of = |(t, now): (&f64, &f64)| {
        let change = between(time, u, t - tau) - now;
        if known.contains(&(t - tau)) && change.abs() >= least { change } else { 0.0 }
    };
    time.iter().zip(u).map(of).collect()
}

/// Weights of 1 and of the columns for the least squares over some rows.
fn solved(columns: &[&Vec<f64>], y: &[f64], rows: &[usize]) -> Option<Vec<f64>> {
    let at = |row: usize, k: usize| if k == 0 { 1.0 } else { columns[k - 1][row] };
    let x = DMatrix::from_fn(rows.len(), columns.len() + 1, |i, k| at(rows[i], k));
    let y = DVector::from_iterator(rows.len(), rows.iter().map(|row| y[*row]));
    let mut normal = x.tr_mul(&x);
    for k in 0..normal.nrows() {
        // A column without changes gets the weight 0.
        normal[(k, k)] = if normal[(k, k)] > 0.0 { normal[(k, k)] * (1.0 + RIDGE) } else { 1.0 };
    }
    Some(normal.cholesky()?.solve(&x.tr_mul(&y)).iter().copied().collect())
}

/// [`solved`] for levels.
pub(super) fn weights(levels: &[Vec<f64>], y: &[f64], rows: &[usize]) -> Option<Vec<f64>> {
    solved(&levels.iter().collect::<Vec<_>>(), y, rows)
}

/// [`sum_of`] levels.
pub(super) fn sum(levels: &[Vec<f64>], weights: &[f64], rows: usize) -> Vec<f64> {
    sum_of(&levels.iter().collect::<Vec<_>>(), weights, rows)
}

fn sum_of(columns: &[&Vec<f64>], weights: &[f64], rows: usize) -> Vec<f64> {
    let of =
        |row: usize| weights[0] + columns.iter().zip(&weights[1..]).map(|(c, w)| w * c[row]).sum::<f64>();
    (0..rows).map(of).collect()
}

/// The levels of (1) at every row, fitted to some.
fn fitted(levels: &[Vec<f64>], y: &[f64], rows: &[usize]) -> Option<Vec<f64>> {
    Some(sum(levels, &weights(levels, y, rows)?, y.len()))
}

pub(super) fn mean_square(y: &[f64], q: &[f64], rows: &[usize]) -> f64 {
    rows.iter().map(|row| (y[*row] - q[*row]).powi(2)).sum::<f64>() / rows.len() as f64
}

#[cfg(test)]
mod tests {
    use super::super::tests::{CURRENT, SPEED, TORQUE, VOLTAGE, column, experiment};
    use super::*;
    use crate::testing::{normal, rng};

    /// Number of readings of voltage and torque that are set aside.
    fn aside(data: &mut Experiment) -> [usize; 2] {
        set_aside(data, &[], &Deadline::default());
        [VOLTAGE, TORQUE].map(|k| column(data, k).iter().filter(|x| x.is_nan()).count())
    }

    /// Mean over rows before and after each row.
    fn averaged(column: &mut [f64], before: usize, after: usize) {
        let old = column.to_vec();
        for (k, x) in column.iter_mut().enumerate() {
            let part = &old[k.saturating_sub(before)..(k + after + 1).min(old.len())];
            *x = part.iter().sum::<f64>() / part.len() as f64;
        }
    }

    fn held(column: &mut [f64], rows: usize) {
        (0..column.len()).for_each(|k| column[k] = column[k - k % rows]);
    }

    /// A change of a column.
    type Fault = fn(&mut [f64]);

    #[test]
    fn a_filtered_or_held_output_is_set_aside_around_changes() {
        let cases: [(usize, Fault); 6] = [
            (TORQUE, |c| averaged(c, 20, 0)),
            (VOLTAGE, |c| averaged(c, 7, 0)),
            (TORQUE, |c| averaged(c, 5, 5)),
            (VOLTAGE, |c| held(c, 9)),
            (TORQUE, |c| held(c, 4)),
            (VOLTAGE, |c| {
                let (old, mut rng, mut late) = (c.to_vec(), rng(7), 5.0f64);
                for k in 0..c.len() {
                    late = (late + normal(&mut rng)).clamp(1.0, 12.0);
                    c[k] = old[k.saturating_sub(late as usize)];
                }
            }),
        ];
        for (n, (k, change)) in cases.into_iter().enumerate() {
            let mut data = experiment(61 + n as u64);
            let right = column(&mut data, k).clone();
            change(column(&mut data, k));
            let wrong = column(&mut data, k).clone();
            let [volts, torque] = aside(&mut data);
            let (own, other) = if k == TORQUE { (torque, volts) } else { (volts, torque) };
            assert!(own > 20 && other == 0, "{n}: {own} {other} {:?}", data.notes);
            // What is left is right.
            let step = 0.2 * crate::intake::response::spread(&right);
            let left =
                column(&mut data, k).iter().zip(&right).filter(|(x, y)| (*x - *y).abs() > step).count();
            let all = wrong.iter().zip(&right).filter(|(x, y)| (*x - *y).abs() > step).count();
            assert!(all > 20 && left * 20 <= all, "{n}: {left} of {all} left");
        }
    }

    #[test]
    fn a_filtered_input_concerns_the_outputs() {
        for (n, change) in
            [|c: &mut [f64]| averaged(c, 6, 6), |c: &mut [f64]| held(c, 6)].into_iter().enumerate()
        {
            let mut data = experiment(71 + n as u64);
            change(column(&mut data, CURRENT));
            let [volts, torque] = aside(&mut data);
            assert!(volts + torque > 200 && torque > 20, "{n}: {volts} {torque} {:?}", data.notes);
        }
    }

    /// Other parameters, an unknown law of current and speed, a lag of a part of the voltage, spikes, and a wrong gain.
    #[test]
    fn readings_at_their_time_stay() {
        let cases: [fn(&mut Experiment); 6] = [
            |_| (),
            |data| column(data, TORQUE).iter_mut().for_each(|x| *x *= 0.7),
            |data| {
                let (i, w) = (column(data, CURRENT).clone(), column(data, SPEED).clone());
                for (k, x) in column(data, TORQUE).iter_mut().enumerate() {
                    *x -= 2e-3 * (w[k] / 100.0).sqrt() + 1e-3 * i[k].powi(3) / 30.0;
                }
            },
            |data| {
                let mut lagged = column(data, VOLTAGE).clone();
                averaged(&mut lagged, 30, 0);
                column(data, VOLTAGE).iter_mut().zip(&lagged).for_each(|(x, y)| *x += 0.2 * (y - *x));
            },
            |data| column(data, TORQUE).iter_mut().step_by(37).for_each(|x| *x += 0.5),
            |data| {
                let mut rng = rng(9);
                column(data, CURRENT).iter_mut().for_each(|x| *x += 0.2 * normal(&mut rng));
            },
        ];
        for (n, change) in cases.into_iter().enumerate() {
            let mut data = experiment(81 + n as u64);
            change(&mut data);
            assert_eq!(aside(&mut data), [0, 0], "{n}: {:?}", data.notes);
        }
    }
}
