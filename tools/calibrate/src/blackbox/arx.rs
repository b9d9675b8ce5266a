//! Linear difference equation with functions of the inputs (ARX), used in simulation.
//!
//! y_k = sum_{j=1..n} a_j y_{k-j} + sum_{j=0..n} sum_f b_{jf} f(u_{k-j}) + c                        (1)
//!
//! The data are block means over blocks of equal length. y is a temperature rise above ambient or any other output. The functions f
//! are each input, its absolute value, its square and the products of two inputs. a, b and c minimise the one-step error of (1)
//! over the fit runs; the prediction is the simulation of (1) from the first block.

use super::{Candidate, Series};
use crate::comparison::digits;
use crate::deadline::Deadline;
use crate::experiment::Role;
use crate::numbers::{between, interval};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Orders n. Definition: of the black box; up to one more than the nodes of the motor.
const ORDERS: [usize; 4] = [0, 1, 2, 3];
/// Block lengths in rows. Definition: of the black box; from one row to some minutes.
const CELLS: [usize; 4] = [1, 5, 20, 80];
/// Smallest number of blocks in a run. Numerical: fewer determine no equation.
const FEWEST: usize = 12;
/// Eigenvalues below this fraction of the largest are treated as zero: the data cannot distinguish these functions. Numerical: rounding
/// of the sums.
const SINGULAR: f64 = 1e-11;

/// The equations of every order and block length.
pub fn candidates(
    all: &[Series],
    output: usize,
    is_temperature: bool,
    deadline: &Deadline,
) -> Vec<Candidate> {
    let mut found = Vec::new();
    for order in ORDERS {
        for rows in CELLS.into_iter().filter(|rows| order > 0 || *rows == 1) {
            if !deadline.is_near() {
                found.extend(candidate(all, output, is_temperature, order, rows));
            }
        }
    }
    found
}

/// Block means of a run.
struct Cells {
    time: Vec<f64>,
    /// Functions of the inputs, block by block.
    functions: Vec<Vec<f64>>,
    /// The output, a rise above ambient for temperatures; NaN if not measured or not evaluated.
    output: Vec<f64>,
    first: f64,
}

fn candidate(
    all: &[Series],
    output: usize,
    is_temperature: bool,
    order: usize,
    rows: usize,
) -> Option<Candidate> {
    let step = interval(all.iter().filter(|s| s.role == Role::Fit).map(|s| &s.time[..]));
    let length = Some(step).filter(|step| step.is_finite())? * rows as f64;
    let cells: Vec<Cells> = all.iter().map(|run| cut(run, output, is_temperature, order, length)).collect();
    if rows > 1 && cells.iter().any(|c| c.time.len() < FEWEST) {
        return None;
    }
    let p = order + (order + 1) * cells.first()?.functions.first()?.len() + 1;
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(p, p), DVector::<f64>::zeros(p));
    let mut count = 0;
    for run in cells.iter().zip(all).filter(|(_, s)| s.role == Role::Fit).map(|(c, _)| c) {
        for k in order..run.time.len() {
            let (x, y) = (regressors(run, &run.output, order, k), run.output[k]);
            if y.is_finite() && x.iter().all(|v| v.is_finite()) {
                normal.syger(1.0, &x, &x, 1.0);
                right.axpy(y, &x, 1.0);
                count += 1;
            }
        }
    }
    if count <= p {
        return None;
    }
    normal.fill_upper_triangle_with_lower_triangle();
    // Each regressor is scaled by its norm, so that one eigenvalue limit fits all.
    let size = DVector::from_fn(p, |k, _| normal[(k, k)].sqrt().max(f64::MIN_POSITIVE));
    let scaled = DMatrix::from_fn(p, p, |a, b| normal[(a, b)] / (size[a] * size[b]));
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(scaled);
    let most = eigenvalues.max();
    let along = eigenvectors.transpose() * right.component_div(&size);
    let along =
        DVector::from_fn(
            p,
            |k, _| {
                if eigenvalues[k] > SINGULAR * most { along[k] / eigenvalues[k] } else { 0.0 }
            },
        );
    let free = eigenvalues.iter().filter(|e| **e > SINGULAR * most).count();
    let numbers = (eigenvectors * along).component_div(&size);
    let predicted = all.iter().zip(&cells).map(|(run, cells)| {
        let mut shown = vec![0.0; cells.time.len()];
        for k in 0..shown.len() {
            shown[k] =
                if k < order { cells.first } else { numbers.dot(&regressors(cells, &shown, order, k)) };
        }
        let zero = |row: usize| if is_temperature { run.ambient[row] } else { 0.0 };
        run.time.iter().enumerate().map(|(row, t)| zero(row) + between(&cells.time, &shown, *t)).collect()
    });
    let kind = match order {
        0 => "static functions of the inputs".to_string(),
        n => format!("ARX of order {n}, interval {} s", digits(length)),
    };
    Some(Candidate { kind, predicted: predicted.collect(), parameters: free })
}

fn regressors(run: &Cells, output: &[f64], order: usize, k: usize) -> DVector<f64> {
    let past = (1..=order).map(|j| output[k - j]);
    let inputs = (0..=order).flat_map(|j| run.functions[k - j].iter().copied());
    let mut all = Vec::with_capacity(order + (order + 1) * run.functions[k].len() + 1);
    all.extend(past.chain(inputs).chain(std::iter::once(1.0)));
    DVector::from_vec(all)
}

fn cut(run: &Series, output: usize, is_temperature: bool, order: usize, length: f64) -> Cells {
    let rows = run.time.len();
    let own = |row: usize| -> Vec<f64> {
        let u: Vec<f64> = run.inputs.iter().map(|x| x[row]).collect();
        let single = u.iter().flat_map(|x| [*x, x.abs(), x * x]);
        let pairs = (0..u.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let products = pairs.map(|(a, b)| u[a] * u[b]);
        single.chain(products).collect()
    };
    let zero = |row: usize| if is_temperature { run.ambient[row] } else { 0.0 };
    let reading = |row: usize| run.outputs[output][row] - zero(row);
    let first = match (0..rows).find(|row| reading(*row).is_finite()) {
        Some(row) if run.is_warm || !is_temperature => reading(row),
        _ => 0.0,
    };
    // Order 0 has no memory and is evaluated at the rows themselves.
    if order == 0 {
        let kept = |row: usize| if run.counts[row] { reading(row) } else { f64::NAN };
        return Cells {
            time: run.time.clone(),
            functions: (0..rows).map(own).collect(),
            output: (0..rows).map(kept).collect(),
            first,
        };
    }
    let start = run.time[0];
    let count = ((run.time[rows - 1] - start) / length).floor() as usize + 1;
    let mut found = Cells {
        time: (0..count).map(|k| start + k as f64 * length).collect(),
        functions: Vec::with_capacity(count),
        output: Vec::with_capacity(count),
        first,
    };
    let mut row = 0;
    for k in 0..count {
        let end = found.time[k] + 0.5 * length;
        let begin = row;
        while row < rows && run.time[row] < end {
            row += 1;
        }
        // In a gap between rows, the inputs of the previous row are held.
        let inside = if row > begin { begin..row } else { begin.max(1) - 1..begin.max(1) };
        let mut sum = vec![0.0; own(0).len()];
        for r in inside.clone() {
            sum.iter_mut().zip(own(r)).for_each(|(s, x)| *s += x / inside.len() as f64);
        }
        found.functions.push(sum);
        let readings: Vec<f64> =
            (begin..row).filter(|r| run.counts[*r]).map(reading).filter(|y| y.is_finite()).collect();
        found.output.push(readings.iter().sum::<f64>() / readings.len() as f64);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y_k = 0.9 y_{k-1} + 0.5 u_k + 0.2 u_{k-1}, with a switching input; `noise` is added to the readings.
    fn run(role: Role, seed: u64, noise: f64) -> Series {
        let mut rng = crate::testing::rng(seed);
        let inputs: Vec<f64> =
            (0..800u64).map(|k| f64::from(u8::from((k / 37 + seed).is_multiple_of(3)))).collect();
        let mut y = vec![0.0; 800];
        for k in 1..800 {
            y[k] = 0.9 * y[k - 1] + 0.5 * inputs[k] + 0.2 * inputs[k - 1];
        }
        let outputs = vec![y.iter().map(|y| y + noise * crate::testing::normal(&mut rng)).collect()];
        let time: Vec<f64> = (0..800).map(f64::from).collect();
        let counts = vec![true; 800];
        Series { role, time, inputs: vec![inputs], ambient: vec![0.0; 800], outputs, counts, is_warm: false }
    }

    #[test]
    fn the_equation_that_made_the_data_is_found_and_simulated() {
        let all = [run(Role::Fit, 1, 0.01), run(Role::Validate, 2, 0.01), run(Role::Test, 4, 0.0)];
        let candidates = candidates(&all, 0, false, &Deadline::default());
        let scored = candidates.iter().map(|c| (super::super::score(&all, 0, c).unwrap(), c));
        let (_, best) = scored.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let (error, count) = super::super::rmse(&all, 0, best, Role::Test).unwrap();
        // The output varies by 7; a static function of the input has an error of at least 1.
        assert!(error < 0.1 && count == 800, "{}: {error}", best.kind);
        let (worst, _) = super::super::rmse(&all, 0, &candidates[0], Role::Test).unwrap();
        assert!(candidates[0].kind.starts_with("static") && worst > 0.5, "{worst}");
    }
}
