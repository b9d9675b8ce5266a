//! Rows that are means over the interval between rows: a logger that averages, a file that was resampled.
//!
//! Where a load steps within an interval, the row is between the two levels, and tells when:
//!
//! m = f a + (1 - f) b,   the step is at t - T/2 + f T                                              (1)
//!
//! m the row at t, a and b the levels before and after it, T the interval. With lines between the rows, the load would change over two
//! intervals, with the same mean but a smaller mean square: for a step from 0 to b, b^2 T / 3 of its heat would be missing, more than a winding
//! stores between two readings if T is a third of its time constant. If the loads of most files change in this way, and in no other, they get
//! a step there in place of the row. Steps between two intervals, which leave no such row, are in the middle between their rows. A load that takes the time d < T for
//! its change leaves two such rows if it changes across the border of two intervals, and these tell how long it took:
//!
//! d = 2 (sqrt g_1 + sqrt g_2)^2,   g_1 = T (m_1 - a) / (b - a),   g_2 = T (b - m_2) / (b - a)      (2)
//!
//! The other changes of this load last as long as these usually do. A slower change stays as it is.
//!
//! That the stamp of a row is at the start or at the end of its interval is a shift of all channels together, which changes nothing. A row of
//! a sampled signal is seldom between two levels; if it is, the step (1) changes the mean square by less than the lines do, and the mean by
//! nothing.
//!
//! The means of the outputs over an interval with a step are not used. Elsewhere a mean of a temperature is its value in the middle, and
//! the error of second order,
//!
//! y - mean y = -T^2 y'' / 24,   y'' from the mean's neighbours on the same side of a step              (3)
//!
//! is that of the mean over a parabola.
//!
//! *Source*: (1) keeps the mean of each interval, and (3) its value, as the reconstruction of a finite volume method: LeVeque, Finite Volume
//! Methods for Hyperbolic Problems (2002), sections 4.10 and 10.

use super::median;
use crate::experiment::{Experiment, Run, Start, Table};
use crate::levels::{CERTAIN, NEARLY, SMALL};
use crate::noise;
use crate::numbers::{between, interval};
use crate::report::count_of;
use physics::declare::Unit;

/// Fraction of the steps of a load that have a row between their levels, from which rows are means. Definition: the majority.
const MEANS: f64 = 0.5;
/// Fewest such rows of a file. Derivation: if a sampled step has such a row as often as not, six have one each with a probability of 2 %.
const FEWEST: usize = 6;
/// Shortest duration of a step that is put in, as a fraction of the interval between rows. Numerical: its heat is known to 1e-3.
const WIDTH: f64 = 1e-3;

/// Fewest rows of a part between two steps for (3). Definition: two second differences, of which the line gives that of its first row.
const LEAST_PART: usize = 4;
/// Standard deviation of a second difference of readings, and of one that is continued as a line, in that of a reading. Derivation: the
/// weights 1, -2, 1 and 2, -5, 4, -1.
const BEND: (f64, f64) = (2.449, 6.782);

/// Second difference of the means of a parabola relative to the difference of its mean and its value in the middle. Derivation: the mean of t^2
/// from -T/2 to T/2 is T^2 / 12, half of it that of y'' t^2 / 2.
const OF_A_PARABOLA: f64 = 24.0;

/// A step of a load.
#[derive(Clone, Copy)]
struct Step {
    /// The column of the load.
    column: usize,
    /// The last row at the level before it.
    before: usize,
    /// The first row at the level after it.
    after: usize,
    /// Whether a row is between the levels.
    is_mixed: bool,
    /// The time of its middle, and the standard deviation of that, s.
    time: f64,
    error: f64,
    /// Its duration, s, if two rows show it.
    duration: Option<f64>,
}

/// Puts steps of the loads in files whose rows are means, with notes.
pub fn reconstruct(experiment: &mut Experiment) {
    let inputs = &experiment.inputs;
    let loads: Vec<usize> = (0..inputs.len()).filter(|k| !inputs[*k].is_temperature()).collect();
    let is_zero_at_rest = |unit| !matches!(unit, Unit::Kelvin | Unit::Pascal | Unit::CubicMetrePerSecond);
    let is_load: Vec<bool> = inputs.iter().map(|channel| is_zero_at_rest(channel.unit)).collect();
    let from_rest = |run: &Run| {
        let mut table = run.table.clone();
        if run.start == Start::Ambient {
            from_rest(&mut table, &is_load, interval([&run.table.time[..]]));
        }
        table
    };
    let tables: Vec<Table> = experiment.runs.iter().map(from_rest).collect();
    let steps: Vec<Vec<Step>> = tables.iter().map(|table| steps(table, &loads)).collect();
    let is_temperature: Vec<bool> = experiment.outputs.iter().map(|c| c.is_temperature()).collect();
    let files: Vec<(String, Vec<usize>)> = super::consistency::files(experiment)
        .into_iter()
        .map(|(file, runs)| (file.to_string(), runs))
        .collect();
    let number = files.len();
    let is_fan = |column: usize| experiment.inputs[column].input == Some("fan_command");
    // Another load may be changed at full minutes, between two rows; a fan takes some seconds.
    let mixed = |runs: &[usize]| {
        let of = |column: &usize| {
            let own = runs.iter().flat_map(|run| &steps[*run]).filter(|step| step.column == *column);
            own.fold((0, 0), |(all, mixed), step| (all + 1, mixed + usize::from(step.is_mixed)))
        };
        let is_mean =
            |(all, mixed): &(usize, usize)| *mixed >= FEWEST && *mixed as f64 >= MEANS * *all as f64;
        let found = loads.iter().filter(|column| !is_fan(**column)).map(of).filter(is_mean);
        let of_run =
            |run: &usize| loads.iter().all(|column| steps_only(&tables[*run], *column, &steps[*run]));
        found.map(|(_, mixed)| mixed).max().filter(|_| runs.iter().all(of_run))
    };
    let means: Vec<(String, Vec<usize>, usize)> =
        files.into_iter().filter_map(|(file, runs)| mixed(&runs).map(|mixed| (file, runs, mixed))).collect();
    // A logger that averages does so in most files; in a single one, slower edges are as likely.
    if 2 * means.len() <= number {
        return;
    }
    // One bench changes its loads alike in all files. A change of duration d crosses a border with probability d / T.
    let duration = |column: &usize| {
        let own = means.iter().flat_map(|(_, runs, _)| runs).flat_map(|run| &steps[*run]);
        let own: Vec<&Step> = own.filter(|step| step.column == *column).collect();
        let shown: Vec<f64> = own.iter().filter_map(|step| step.duration).collect();
        let part = shown.len() as f64 / own.len().max(1) as f64;
        let interval = interval(tables.iter().map(|table| &table.time[..]));
        (*column, if part > 0.0 { median(shown.into_iter()).min(part * interval) } else { 0.0 })
    };
    let durations: Vec<(usize, f64)> = loads.iter().map(duration).collect();
    for (file, runs, mixed) in means {
        let interval = interval(runs.iter().map(|run| &experiment.runs[*run].table.time[..]));
        for run in runs {
            experiment.runs[run].table = with_steps(&tables[run], &is_temperature, &steps[run], &durations);
        }
        experiment.notes.push(format!(
            "{file}: {} between the levels before and after a step of a load, as means over {interval:.3} s are: the loads step at the times \
             that give these means",
            count_of(mixed, "row"),
        ));
    }
}

/// The steps of the loads of a run, in the order of the columns.
fn steps(table: &Table, loads: &[usize]) -> Vec<Step> {
    let usual = interval([&table.time[..]]);
    let mut all = Vec::new();
    for column in loads {
        let values = &table.columns[*column];
        let noise = noise::of_column(&table.time, values).unwrap_or(0.0);
        let span = super::range(values.iter().copied());
        let own = Load { time: &table.time, values, noise, span, usual };
        let mut row = 1;
        while row + 1 < values.len() {
            let step = own.step(*column, row);
            row = step.map_or(row + 1, |step| step.after.max(row + 1));
            all.extend(step);
        }
    }
    all
}

/// Whether nearly all changes of a load are those of its steps: a load that always changes is between its neighbours in many rows.
fn steps_only(table: &Table, column: usize, steps: &[Step]) -> bool {
    let values = &table.columns[column];
    let least = CERTAIN * noise::of_column(&table.time, values).unwrap_or(0.0);
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let all: f64 = changes.filter(|change| *change > least).sum();
    let own = steps.iter().filter(|step| step.column == column);
    own.map(|step| (values[step.after] - values[step.before]).abs()).sum::<f64>() >= NEARLY * all
}

/// A load of a run.
struct Load<'a> {
    time: &'a [f64],
    values: &'a [f64],
    noise: f64,
    span: f64,
    /// Usual interval between rows, s.
    usual: f64,
}

impl Load<'_> {
    /// The step whose levels are those of the rows beside this one, or beside this one and the next.
    fn step(&self, column: usize, row: usize) -> Option<Step> {
        let two = self.over(column, row - 1, row + 2);
        let both = two.filter(|step| step.duration.is_some());
        let sharp = two.filter(|step| !step.is_mixed);
        // Of two rows between the levels, the second may be nearly at its level; if only one is, it is found alone.
        both.or_else(|| self.over(column, row - 1, row + 1)).or(sharp)
    }

    /// (1) for one row or two between two levels, (2) if both are.
    fn over(&self, column: usize, before: usize, after: usize) -> Option<Step> {
        let (a, b) = (*self.values.get(before)?, *self.values.get(after)?);
        let (change, least) = (b - a, CERTAIN * self.noise);
        let is_step = self.is_change(change)
            && self.is_usual(before, after)
            && self.is_level(before, -1, change)
            && self.is_level(after, 1, change);
        if !is_step {
            return None;
        }
        let between = &self.values[before + 1..after];
        let shares = || between.iter().map(|m| (m - a) / change);
        let tolerance = least / change.abs();
        let is_monotone = shares().is_sorted_by(|x, y| x <= &(y + tolerance));
        if !is_monotone || !shares().all(|share| (-tolerance..1.0 + tolerance).contains(&share)) {
            return None;
        }
        let is_mixed = |share: &f64| *share > tolerance && *share < 1.0 - tolerance;
        let mixed: Vec<f64> = shares().filter(is_mixed).collect();
        let duration = match mixed[..] {
            [first, second] => Some(2.0 * self.usual * (first.sqrt() + (1.0 - second).sqrt()).powi(2)),
            _ => None,
        };
        // A longer change is one that was read at instants.
        if duration.is_some_and(|duration| duration > self.usual) {
            return None;
        }
        let time = self.time[before] + self.usual * (0.5 + shares().map(|share| 1.0 - share).sum::<f64>());
        let error = self.usual * self.noise * (between.len() as f64).sqrt() / change.abs();
        Some(Step { column, before, after, is_mixed: !mixed.is_empty(), time, error, duration })
    }

    /// Whether rows follow each other at the usual interval.
    fn is_usual(&self, from: usize, to: usize) -> bool {
        let length = (to - from) as f64 * self.usual;
        (self.time[to] - self.time[from] - length).abs() < SMALL * length
    }

    /// Whether a change is more than the noise, and than a ripple.
    fn is_change(&self, change: f64) -> bool {
        change.abs() > (2.0 * CERTAIN * self.noise).max(SMALL * self.span)
    }

    /// Whether the load was at the level of a row at the next row in this direction, too, or returns there: one that goes on changes slowly.
    fn is_level(&self, row: usize, direction: isize, change: f64) -> bool {
        let Some(next) = row.checked_add_signed(direction).filter(|next| *next < self.values.len()) else {
            return true;
        };
        let by = (self.values[next] - self.values[row]) * change.signum() * direction as f64;
        by < (CERTAIN * self.noise).max(SMALL * change.abs())
    }
}

/// A step that is put in.
struct Break {
    column: usize,
    /// Times of the rows at its levels, s.
    ends: (f64, f64),
    levels: (f64, f64),
    /// Its middle and its duration, s.
    time: f64,
    duration: f64,
}

impl Break {
    fn spans(&self, at: f64) -> bool {
        self.ends.0 <= at && at <= self.ends.1
    }

    fn level(&self, at: f64) -> f64 {
        let share = ((at - self.time) / self.duration + 0.5).clamp(0.0, 1.0);
        self.levels.0 + share * (self.levels.1 - self.levels.0)
    }
}

/// The table with two rows at each step in place of a change over the rows beside it. `durations` are the usual ones of the loads, s.
fn with_steps(table: &Table, is_temperature: &[bool], steps: &[Step], durations: &[(usize, f64)]) -> Table {
    let inputs = table.columns.len() - is_temperature.len();
    let usual = interval([&table.time[..]]);
    let shortest = WIDTH * usual;
    let mut own = table.clone();
    let mut is_blank = vec![false; table.time.len()];
    let mut breaks: Vec<Break> = Vec::new();
    let middles = middles(steps, shortest);
    for step in steps {
        let nearest = |a: &&f64, b: &&f64| (*a - step.time).abs().total_cmp(&(*b - step.time).abs());
        let time = middles.iter().min_by(nearest).copied().unwrap_or(step.time);
        let ends = (table.time[step.before], table.time[step.after]);
        // A change that one row shows is within its interval.
        let room = (time - ends.0).min(ends.1 - time) - 0.5 * usual;
        let of_load = durations.iter().find(|(column, _)| *column == step.column).map_or(0.0, |own| own.1);
        let duration = step.duration.unwrap_or(of_load.min(2.0 * room)).max(shortest);
        let levels = (table.columns[step.column][step.before], table.columns[step.column][step.after]);
        let one = Break { column: step.column, ends, levels, time, duration };
        let is_mixed = |t: f64| (t - time).abs() - 0.5 * (usual + duration) < CERTAIN * step.error;
        let between = step.before + 1..step.after;
        between.clone().for_each(|row| is_blank[row] |= is_mixed(table.time[row]));
        between.for_each(|row| own.columns[step.column][row] = one.level(table.time[row]));
        breaks.push(one);
    }
    for (k, column) in own.columns.iter_mut().enumerate().skip(inputs) {
        (0..is_blank.len()).filter(|row| is_blank[*row]).for_each(|row| column[row] = f64::NAN);
        if is_temperature[k - inputs] {
            point_values(&own.time, column);
        }
    }
    let edges = |one: &Break| [one.time - 0.5 * one.duration, one.time + 0.5 * one.duration];
    for at in breaks.iter().flat_map(edges) {
        let row = own.time.partition_point(|t| *t < at);
        let is_near = |row: usize| own.time.get(row).is_some_and(|t| (t - at).abs() < WIDTH * shortest);
        // A row there is on the line already.
        if is_near(row) || row.checked_sub(1).is_some_and(is_near) {
            continue;
        }
        let value = |column: usize| match breaks.iter().find(|one| one.column == column && one.spans(at)) {
            _ if column >= inputs => f64::NAN,
            Some(one) => one.level(at),
            None => between(&own.time, &own.columns[column], at),
        };
        let values: Vec<f64> = (0..own.columns.len()).map(value).collect();
        own.time.insert(row, at);
        own.columns.iter_mut().zip(values).for_each(|(column, value)| column.insert(row, value));
    }
    own
}

/// The different times of steps, s: loads that step together do so at one time, known best from the greatest step.
fn middles(steps: &[Step], least: f64) -> Vec<f64> {
    let mut times: Vec<(f64, f64)> = steps.iter().map(|step| (step.time, step.error)).collect();
    times.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut all: Vec<(f64, f64)> = Vec::new();
    for one in times {
        let is_same =
            |other: &(f64, f64)| (one.0 - other.0).abs() <= CERTAIN * one.1.hypot(other.1) + 2.0 * least;
        if !all.iter().any(is_same) {
            all.push(one);
        }
    }
    all.into_iter().map(|one| one.0).collect()
}

/// (3) between the blank rows of a temperature, where y'' is more than noise.
fn point_values(time: &[f64], column: &mut [f64]) {
    let noise = noise::of_column(time, column).unwrap_or(0.0);
    let is_known: Vec<bool> = column.iter().map(|x| x.is_finite()).collect();
    let mut from = 0;
    for part in is_known.chunk_by(|a, b| a == b) {
        let to = from + part.len();
        if part[0] && part.len() >= LEAST_PART {
            let means = column[from..to].to_vec();
            let bend = |k: usize| means[k - 1] - 2.0 * means[k] + means[k + 1];
            for k in 0..means.len() {
                let last = means.len() - 1;
                let (bend, size) = match k {
                    0 => (2.0 * bend(1) - bend(2), BEND.1),
                    _ if k == last => (2.0 * bend(last - 1) - bend(last - 2), BEND.1),
                    _ => (bend(k), BEND.0),
                };
                if bend.abs() > CERTAIN * size * noise {
                    column[from + k] = means[k] - bend / OF_A_PARABOLA;
                }
            }
        }
        from = to;
    }
}

/// A row at rest, an interval before the first: a motor that starts at the ambient temperature had no load.
fn from_rest(table: &mut Table, is_load: &[bool], interval: f64) {
    let Some(first) = table.time.first().copied() else { return };
    table.time.insert(0, first - interval);
    for (k, column) in table.columns.iter_mut().enumerate() {
        let value = match is_load.get(k) {
            Some(true) => 0.0,
            Some(false) => column[0],
            None => f64::NAN,
        };
        column.insert(0, value);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{
        CURRENT, FAN, HOUSING, SPEED, TORQUE, VOLTAGE, WINDING, experiment, with_inputs,
    };
    use super::*;

    /// Means over so many rows, from the readings of a motor whose loads step at irregular times.
    fn averaged(seed: u64, rows: usize) -> (Experiment, Experiment) {
        let whole = with_inputs(seed, |columns| {
            let mut at = 0;
            for (n, length) in [50, 83, 61, 97, 72].into_iter().cycle().enumerate() {
                let to = (at + length).min(1200);
                columns[CURRENT][at..to].fill([1.0, 4.0, 2.0, 6.0][n % 4]);
                at = to;
                if at == 1200 {
                    break;
                }
            }
        });
        let mut own = whole.clone();
        let mean = |column: &Vec<f64>| {
            column.chunks_exact(rows).map(|part| part.iter().sum::<f64>() / rows as f64).collect()
        };
        let table = &mut own.runs[0].table;
        table.time = mean(&table.time);
        table.columns = table.columns.iter().map(mean).collect();
        (own, whole)
    }

    /// The integral of the square of a column over time.
    fn square(table: &Table, column: usize) -> f64 {
        let x = &table.columns[column];
        let part = |k: usize| {
            (table.time[k] - table.time[k - 1]) * (x[k] * x[k] + x[k] * x[k - 1] + x[k - 1] * x[k - 1]) / 3.0
        };
        (1..x.len()).map(part).sum()
    }

    /// The heat of the loads, and the times of their steps, are those of the motor; the outputs that are left are, too.
    #[test]
    fn the_loads_step_where_they_did() {
        for (seed, rows) in [(41, 4), (42, 7), (43, 12)] {
            let (mut own, whole) = averaged(seed, rows);
            let lines = own.clone();
            reconstruct(&mut own);
            assert!(own.notes.iter().any(|note| note.contains("as means over")), "{rows}: {:?}", own.notes);
            let (table, all) = (&own.runs[0].table, &whole.runs[0].table);
            for k in [CURRENT, SPEED] {
                let missing = square(all, k) - square(&lines.runs[0].table, k);
                let left = (square(all, k) - square(table, k)).abs();
                // The motor's own loads are lines over a row of 3 s.
                assert!(
                    left < (0.05 + 1.1 / rows as f64) * missing,
                    "{rows} rows, input {k}: {left} of {missing}"
                );
            }
            // A temperature in the middle of an interval is within its noise, and no row mixes two levels.
            for (k, most) in [(WINDING, 0.25), (HOUSING, 0.2), (VOLTAGE, 0.2), (TORQUE, 3e-3)] {
                let at = |t: f64| all.time.partition_point(|own| *own < t - 1.6).min(1198);
                let off = |row: &usize| {
                    let k0 = at(table.time[*row]);
                    let share = (table.time[*row] - all.time[k0]) / 3.0;
                    let right = all.columns[k][k0] + share * (all.columns[k][k0 + 1] - all.columns[k][k0]);
                    (table.columns[k][*row] - right).abs()
                };
                let known: Vec<usize> =
                    (0..table.time.len()).filter(|row| table.columns[k][*row].is_finite()).collect();
                let wrong = known.iter().filter(|row| off(row) > most).count();
                assert!(known.len() > 40 && wrong * 20 <= known.len(), "{rows} rows, output {k}: {wrong}");
            }
        }
    }

    /// Steps between rows, with a slower edge in some of them; ramps; a load that is never the same.
    #[test]
    fn readings_of_an_instant_stay() {
        let wave = |columns: &mut [Vec<f64>]| {
            columns[CURRENT]
                .iter_mut()
                .enumerate()
                .for_each(|(k, x)| *x = 3.0 + 2.0 * (k as f64 / 4.0).sin());
        };
        let ramps = |columns: &mut [Vec<f64>]| {
            let levels = columns[CURRENT].clone();
            (0..levels.len()).for_each(|k| {
                let part = &levels[k.saturating_sub(9)..=k];
                columns[CURRENT][k] = part.iter().sum::<f64>() / part.len() as f64;
            });
        };
        let edges = |columns: &mut [Vec<f64>]| {
            for k in (55..1199).step_by(220) {
                columns[CURRENT][k] = 0.5 * (columns[CURRENT][k - 1] + columns[CURRENT][k + 1]);
            }
        };
        let all = [experiment(44), with_inputs(45, wave), with_inputs(46, ramps), with_inputs(47, edges)];
        for (n, mut data) in all.into_iter().enumerate() {
            let as_is = data.runs[0].table.clone();
            reconstruct(&mut data);
            assert!(data.notes.is_empty(), "{n}: {:?}", data.notes);
            let columns = [CURRENT, SPEED, FAN, WINDING].map(|k| &as_is.columns[k]);
            assert_eq!(columns, [CURRENT, SPEED, FAN, WINDING].map(|k| &data.runs[0].table.columns[k]));
        }
    }
}
