//! Rows of one file in another one, whatever their times: a copy with a shifted clock, fewer decimals, every second row or a part of the rows.
//!
//! Two recordings of one experiment have the same inputs, but each has noise of its own. Let q be the coarser resolution of an output in two
//! files. The probability that two readings of one value differ by less than q is at most the probability P that a reading differs by
//! less than q from the mean of its neighbours: the variance of this difference is 1.5 times that of the noise, that of the difference of
//! two recordings twice. n successive pairs of rows then agree in all outputs by chance with a probability of
//!
//! prod P^n                                                                                           (1)
//!
//! P is that of the rows that agree, in the file with the greater P. An output that is at rest, or whose resolution is coarser than its
//! noise, has P = 1 and says nothing. What an output follows of the inputs is not its noise: the part of the difference that is linear in
//! the changes of the inputs and of their squares before and after the row is subtracted, and rows with a greater rest, after a step, are
//! no part of P.
//! A simulation without noise that is repeated has the same readings as well, and is as little of a test as a copy.
//! *Assumes* independent noise of successive rows. Readings that were averaged or interpolated between rows are not recognised.

use super::Run;
use super::shared_rows::counted;
use crate::levels::{CERTAIN, SMALL};
use crate::numbers::{median, sorted};
use nalgebra::{DMatrix, DVector, SVD};

/// Least magnitude of the logarithm of (1). Derivation: two files of 1e4 rows have 1e8 pairs of rows at which a copy may begin, 1e4 lengths
/// and 40 ratios of their intervals; a probability of 1e-20 for each is one false note in 2e4 pairs of files.
const ENOUGH: f64 = 46.0;
/// Rows of a file that are searched in the other one. Numerical: twenty of them are in a copied tenth.
const SEEDS: usize = 200;
/// Most rows of the other file that agree with a row of which a copy is sought. Numerical: a row that agrees with more says little, and others
/// are left.
const MANY: usize = 50;
/// Greatest ratio of the intervals of two files. Numerical: a limit of effort; from 0.1 s to 2 s.
const THINNED: usize = 20;
/// Distinct readings on one side of a reading from which its resolution is taken. Numerical: ten distances are seldom all multiples of
/// more than the step.
const NEAR: usize = 10;
/// Most rows of which the part of an output that follows the inputs is determined. Numerical: a limit of effort.
const FITTED: usize = 10_000;
/// Least resolution as a share of a reading. Numerical: above the rounding of conversions of units, below the last digit of a logger.
const PRECISION: f64 = 1e-9;
/// Share of the resolution by which rounded conversions of units are off, and least singular value. Numerical: between the precision of
/// a number and a digit.
const SLACK: f64 = 1e-6;

/// The outputs in the evaluated rows of a run.
pub struct Readings(Vec<Output>);

struct Output {
    values: Vec<f64>,
    /// The distance of possible readings at each reading; infinite where it is not known.
    resolution: Vec<f64>,
    /// Difference of each reading and the mean of its neighbours, without what follows the inputs.
    rough: Vec<f64>,
    /// Median magnitude of these differences.
    noise: f64,
    /// Ratio of the noise to the resolution; 0 if either is unknown.
    fineness: f64,
    /// Rows with a reading, by reading.
    order: Vec<usize>,
}

impl Readings {
    /// The first `inputs` columns are inputs.
    pub fn of(inputs: usize, run: &Run) -> Readings {
        let rows: Vec<usize> = counted(inputs, run).collect();
        let of = |column: &Vec<f64>| rows.iter().map(|row| column[*row]).collect::<Vec<f64>>();
        let (inputs, outputs) = run.table.columns.split_at(inputs);
        let causes: Vec<Vec<f64>> = inputs.iter().map(of).collect();
        Readings(outputs.iter().map(|column| Output::of(of(column), &causes)).collect())
    }

    fn rows(&self) -> usize {
        self.0.first().map_or(0, |output| output.values.len())
    }
}

impl Output {
    fn of(values: Vec<f64>, causes: &[Vec<f64>]) -> Output {
        let rough = rough(&values, causes);
        let mut order: Vec<usize> = (0..values.len()).filter(|k| values[*k].is_finite()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let noise = median(rough.iter().map(|x| x.abs()));
        let resolution = resolution(&values);
        let fineness = (noise / median(resolution.iter().copied())).max(0.0);
        Output { values, resolution, rough, noise, fineness, order }
    }

    /// The greatest difference of two readings that are one up to their resolution.
    fn tolerance(&self, row: usize, other: &Output, of: usize) -> f64 {
        (1.0 - SLACK) * self.resolution[row].max(other.resolution[of])
    }

    /// Whether two readings are one up to the coarser resolution; `None` if one is missing.
    fn agrees(&self, row: usize, other: &Output, of: usize) -> Option<bool> {
        let apart = (self.values[row] - other.values[of]).abs();
        (!apart.is_nan()).then(|| apart < self.tolerance(row, other, of))
    }
}

/// Difference of each reading and the mean of its neighbours, without its part that is linear in the changes of the inputs and of their squares.
fn rough(values: &[f64], inputs: &[Vec<f64>]) -> Vec<f64> {
    let around =
        |column: &[f64], k: usize| Some([*column.get(k.checked_sub(1)?)?, column[k], *column.get(k + 1)?]);
    let apart =
        |k: usize| around(values, k).map_or(f64::NAN, |[before, x, after]| x - 0.5 * (before + after));
    let all: Vec<f64> = (0..values.len()).map(apart).collect();
    let size = 4 * inputs.len();
    let changes = |k: usize| {
        let of = |column: &Vec<f64>| {
            let [before, x, after] = around(column, k).unwrap_or([f64::NAN; 3]);
            [x - before, after - x, x * x - before * before, after * after - x * x]
        };
        let changes = DVector::from_iterator(size, inputs.iter().flat_map(of));
        (all[k] + changes.sum()).is_finite().then_some(changes)
    };
    if inputs.is_empty() {
        return all;
    }
    let (mut matrix, mut side) = (DMatrix::zeros(size, size), DVector::zeros(size));
    for k in (0..all.len()).step_by(all.len().div_ceil(FITTED).max(1)) {
        let Some(changes) = changes(k) else { continue };
        side.axpy(all[k], &changes, 1.0);
        matrix.ger(1.0, &changes, &changes, 1.0);
    }
    let scale = matrix.diagonal().map(|x: f64| if x > 0.0 { x.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_diagonal(&scale) * matrix * DMatrix::from_diagonal(&scale);
    let follows = match SVD::new(scaled, true, true).solve(&side.component_mul(&scale), SLACK) {
        Ok(solution) => solution.component_mul(&scale),
        Err(_) => DVector::zeros(size),
    };
    (0..all.len()).map(|k| all[k] - changes(k).map_or(0.0, |changes| changes.dot(&follows))).collect()
}

/// The step of which the distances of the nearest readings are multiples, on the side where it is greater: the resolution of numbers with a
/// certain count of digits changes at powers of ten.
fn resolution(values: &[f64]) -> Vec<f64> {
    let mut distinct = sorted(values.iter().copied());
    distinct.dedup();
    let gaps: Vec<f64> = distinct.windows(2).map(|w| w[1] - w[0]).collect();
    let at = |rank: usize| {
        let (first, last) = (rank.saturating_sub(NEAR), gaps.len().min(rank + NEAR));
        let least = PRECISION * distinct[first].abs().max(distinct[last].abs());
        let step = |part: &[f64]| part.iter().copied().reduce(|a, b| common(a, b, least));
        let sides = [&gaps[first..rank], &gaps[rank..last]];
        // One reading alone has no resolution.
        sides.into_iter().filter_map(step).reduce(f64::max).unwrap_or(f64::INFINITY)
    };
    let steps: Vec<f64> = (0..distinct.len()).map(at).collect();
    let of =
        |value: &f64| steps.get(distinct.partition_point(|x| x < value)).copied().unwrap_or(f64::INFINITY);
    values.iter().map(of).collect()
}

/// The greatest common divisor of two distances down to `least`.
fn common(mut a: f64, mut b: f64, least: f64) -> f64 {
    while b > least {
        (a, b) = (b, a % b);
    }
    a
}

/// Number of rows of one run that are copies of rows of the other; `None` if they are less than a tenth of the shorter run.
pub fn count(a: &Readings, b: &Readings) -> Option<usize> {
    let most = copied(a, b).max(copied(b, a));
    (most as f64 > SMALL * a.rows().min(b.rows()) as f64).then_some(most)
}

/// Rows of `thin` that are rows of `dense`, which may have several rows for each.
fn copied(dense: &Readings, thin: &Readings) -> usize {
    let finest = |k: &usize| dense.0[*k].fineness.min(thin.0[*k].fineness);
    let outputs = 0..thin.0.len();
    let Some(key) = outputs.max_by(|a, b| finest(a).total_cmp(&finest(b))) else { return 0 };
    let mut is_copied = vec![false; thin.rows()];
    let rows: Vec<usize> = (0..thin.rows()).filter(|row| thin.0[key].values[*row].is_finite()).collect();
    for row in rows.iter().copied().step_by(rows.len().div_ceil(SEEDS).max(1)) {
        if is_copied[row] {
            continue;
        }
        let same = alike(dense, thin, row, key);
        let starts = same.iter().filter(|_| same.len() <= MANY);
        let mut chains =
            starts.flat_map(|of| (1..=THINNED).map(|ratio| Chain::at((*of, row), ratio, dense, thin)));
        for (_, row) in chains.find(|chain| chain.is_copy(dense, thin)).iter().flat_map(|chain| &chain.pairs)
        {
            is_copied[*row] = true;
        }
    }
    is_copied.iter().filter(|is| **is).count()
}

/// Rows of `dense` that agree with a row of `thin`; they are sought by the readings of output `key`.
fn alike(dense: &Readings, thin: &Readings, row: usize, key: usize) -> Vec<usize> {
    let (all, own) = (&dense.0[key], &thin.0[key]);
    let value = own.values[row];
    let place = all.order.partition_point(|k| all.values[*k] < value);
    let beside = [place.checked_sub(1), Some(place)].into_iter().flatten().filter_map(|k| all.order.get(k));
    let far = beside.map(|k| all.tolerance(*k, own, row)).fold(0.0, f64::max);
    let near = |k: &&usize| (all.values[**k] - value).abs() <= far;
    let (below, above) = all.order.split_at(place);
    let both = below.iter().rev().take_while(near).chain(above.iter().take_while(near)).copied();
    both.filter(|k| agree(dense, *k, thin, row)).take(MANY + 1).collect()
}

/// Whether two rows agree in all outputs that both have.
fn agree(a: &Readings, row: usize, b: &Readings, of: usize) -> bool {
    let mut both = a.0.iter().zip(&b.0).filter_map(|(a, b)| a.agrees(row, b, of)).peekable();
    both.peek().is_some() && both.all(|same| same)
}

/// Pairs of agreeing rows, one after the other: of the dense file every `ratio`-th or the one after it, of the other one every row.
struct Chain {
    pairs: Vec<(usize, usize)>,
    is_even: bool,
}

impl Chain {
    /// The longest one through a pair.
    fn at(pair: (usize, usize), ratio: usize, dense: &Readings, thin: &Readings) -> Chain {
        let mut chain = Chain { pairs: vec![pair], is_even: true };
        for is_back in [true, false] {
            let (mut row, mut of) = pair;
            let step = |from: usize, by: usize| if is_back { from.checked_sub(by) } else { Some(from + by) };
            while let Some(next) = step(of, 1).filter(|next| *next < thin.rows()) {
                let far = [ratio, ratio + 1].into_iter().filter_map(|by| step(row, by));
                let found = far.filter(|row| *row < dense.rows()).find(|row| agree(dense, *row, thin, next));
                let Some(found) = found else { break };
                chain.is_even &= row.abs_diff(found) == ratio;
                (row, of) = (found, next);
                chain.pairs.push((row, of));
            }
        }
        chain
    }

    /// Whether noise does not explain that all pairs agree.
    fn is_copy(&self, dense: &Readings, thin: &Readings) -> bool {
        // A choice of two rows at each step.
        let choices = if self.is_even { 0.0 } else { self.pairs.len() as f64 * std::f64::consts::LN_2 };
        let both = dense.0.iter().zip(&thin.0);
        both.map(|(a, b)| self.improbability(a, b)).sum::<f64>() - choices > ENOUGH
    }

    /// Magnitude of the logarithm of (1) for one output.
    fn improbability(&self, a: &Output, b: &Output) -> f64 {
        let (mut there, mut within) = (0.0, [(0.0, 0.0); 2]);
        for (row, of) in self.pairs.iter().filter(|(row, of)| a.agrees(*row, b, *of).is_some()) {
            there += 1.0;
            let tolerance = a.tolerance(*row, b, *of);
            for ((output, row), (near, all)) in [(a, *row), (b, *of)].into_iter().zip(&mut within) {
                let rough = output.rough[row].abs();
                if rough <= CERTAIN * tolerance.max(output.noise) {
                    *all += 1.0;
                    *near += f64::from(u8::from(rough <= tolerance));
                }
            }
        }
        // The rule of succession: a share of few rows is not 0.
        let share = |(near, all): (f64, f64)| (near + 1.0) / (all + 2.0);
        -there * share(within[0]).max(share(within[1])).min(1.0).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Role, Start, Table};
    use super::*;
    use crate::testing::{normal, rng};

    /// A load as input; a voltage, a torque, and a temperature as outputs with noise of a multiple of 0.02, 0.001 and 0.1.
    fn driven(load: &dyn Fn(usize) -> f64, seed: u64, noise: f64) -> Vec<Vec<f64>> {
        let mut rng = rng(seed);
        let (mut temperature, mut columns) = (295.0, vec![Vec::new(); 4]);
        for load in (0..900).map(load) {
            temperature += 0.02 * (295.0 + 3.0 * load * load - temperature);
            let exact = [load, 4.0 * load + 0.01 * (temperature - 295.0), 0.04 * load, temperature];
            for ((column, x), sigma) in columns.iter_mut().zip(exact).zip([0.0, 0.02, 0.001, 0.1]) {
                column.push(x + noise * sigma * normal(&mut rng));
            }
        }
        columns
    }

    /// The same under steps.
    fn recorded(seed: u64, noise: f64) -> Vec<Vec<f64>> {
        driven(&|k| [0.0, 3.0, 1.5, 4.5, 2.0][k / 55 % 5], seed, noise)
    }

    fn run(columns: Vec<Vec<f64>>) -> Run {
        let time = (0..columns[0].len()).map(|k| k as f64).collect();
        let table = Table { time, columns, ..Table::default() };
        let (file, priors, set) = (String::new(), Vec::new(), Vec::new());
        Run { file, role: Role::Fit, window: None, start: Start::Ambient, set, priors, table }
    }

    fn found(a: Vec<Vec<f64>>, b: Vec<Vec<f64>>) -> Option<usize> {
        let [a, b] = [a, b].map(|columns| Readings::of(1, &run(columns)));
        assert_eq!(count(&a, &b), count(&b, &a));
        count(&a, &b)
    }

    /// The rows of a recording, in this order.
    fn rows(columns: &[Vec<f64>], rows: impl Iterator<Item = usize> + Clone) -> Vec<Vec<f64>> {
        columns.iter().map(|column| rows.clone().map(|row| column[row]).collect()).collect()
    }

    fn changed(columns: &[Vec<f64>], change: impl Fn(usize, f64) -> f64) -> Vec<Vec<f64>> {
        let column = |(k, column): (usize, &Vec<f64>)| column.iter().map(|x| change(k, *x)).collect();
        columns.iter().enumerate().map(column).collect()
    }

    /// Multiples of these steps.
    fn rounded(columns: &[Vec<f64>], steps: [f64; 3]) -> Vec<Vec<f64>> {
        changed(columns, |k, x| if k == 0 { x } else { (x / steps[k - 1]).round() * steps[k - 1] })
    }

    const FINE: [f64; 3] = [1e-3, 1e-5, 1e-2];

    /// Thinned, cut, put together, with lost rows, with blanks; with fewer decimals, cut off or rounded, or fewer digits.
    #[test]
    fn copies_are_found_at_other_times_and_with_fewer_digits() {
        let own = rounded(&recorded(1, 1.0), FINE);
        let other = rounded(&recorded(2, 1.0), FINE);
        let together = |from: usize, to: usize| -> Vec<Vec<f64>> {
            let part = rows(&own, from..to);
            other.iter().zip(part).map(|(a, b)| [&a[..500], &b[..]].concat()).collect()
        };
        for (rows_of, expected) in [
            (rows(&own, 0..900), 900),
            (rows(&own, 300..700), 400),
            (rows(&own, (1..900).step_by(2)), 450),
            (rows(&own, (0..900).step_by(7)), 129),
            (rows(&own, (0..900).filter(|k| k % 100 != 50)), 891),
            (rows(&own, (0..600).map(|k| k * 3 / 2)), 600),
            (together(200, 400), 200),
        ] {
            assert_eq!(found(own.clone(), rows_of.clone()), Some(expected));
            let coarse = found(own.clone(), rounded(&rows_of, [1e-2, 1e-3, 0.1]));
            assert!(coarse.is_some_and(|rows| rows > expected * 49 / 50), "{coarse:?} of {expected}");
        }
        let cut = changed(&own, |k, x| if k == 3 { (x * 10.0).trunc() / 10.0 } else { x });
        let digits = changed(&own, |k, x| if k == 0 { x } else { format!("{x:.2e}").parse().unwrap() });
        let blank =
            changed(&own, |k, x| if k == 3 && (x * 100.0).round() % 7.0 == 0.0 { f64::NAN } else { x });
        let converted = changed(&own, |_, x| x / 0.3 * 0.3);
        for copy in [cut, digits, blank, converted] {
            assert!(found(own.clone(), copy).is_some_and(|rows| rows > 800));
        }
    }

    /// The same programme again, steps or a load that is another one in each row, at any resolution, also if almost all readings agree; and
    /// rows at rest.
    #[test]
    fn a_repeated_experiment_is_no_copy() {
        let mut rng = rng(9);
        let profile: Vec<f64> = (0..900).map(|_| 2.0 + 2.0 * normal(&mut rng)).collect();
        for noise in [1.0, 0.3, 0.1, 0.03, 0.01] {
            for steps in [FINE, [1e-2, 1e-3, 0.1], [0.1, 1e-3, 0.5], [0.1, 1e-2, 1.0]] {
                let [a, b] = [3, 4].map(|seed| rounded(&recorded(seed, noise), steps));
                assert_eq!(found(a, b), None, "{noise} {steps:?}");
                let [a, b] = [3, 4].map(|seed| rounded(&driven(&|k| profile[k], seed, noise), steps));
                assert_eq!(found(a, b), None, "profile {noise} {steps:?}");
            }
        }
        let rest = |seed: u64| {
            let at_rest = changed(&recorded(seed, 1.0), |_, _| 295.0);
            let column = |(a, b): (&Vec<f64>, Vec<f64>)| [&a[..600], &b[600..]].concat();
            at_rest.iter().zip(recorded(seed, 1.0)).map(column).collect()
        };
        assert_eq!(found(rest(5), rest(6)), None);
        // Another experiment.
        assert_eq!(found(recorded(7, 1.0), rows(&recorded(8, 1.0), (0..900).rev())), None);
    }
}
