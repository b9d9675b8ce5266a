//! Residual mean square of an output with its clock shifted or with a first-order lag, minimised over the declared parameters.

use crate::CalibrateError;
use crate::experiment::Table;
use crate::fit::Slopes;
use crate::hypothesis::Hypothesis;
use crate::setup::Setup;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// One output of one run with its prediction: prediction first, then the sensitivities.
#[derive(Clone)]
struct Line {
    time: Vec<f64>,
    read: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Line {
    /// Calls `tell` with each reading and with what reads a column delayed by `late` seconds, at the rows where both are known.
    fn late(&self, late: f64, mut tell: impl FnMut(f64, &dyn Fn(&[f64]) -> f64)) {
        let n = self.time.len();
        let mut j = 0;
        for (t, y) in self.time.iter().zip(&self.read).filter(|(_, y)| y.is_finite()) {
            let at = t - late;
            if at < self.time[0] || at > self.time[n - 1] {
                continue;
            }
            while j + 2 < n && self.time[j + 1] < at {
                j += 1;
            }
            while j > 0 && self.time[j] > at {
                j -= 1;
            }
            let share = (at - self.time[j]) / (self.time[j + 1] - self.time[j]);
            let (a, b) = (1.0 - share, share);
            tell(*y, &|column| a * column[j] + b * column[j + 1]);
        }
    }

    /// Line with a first-order lag applied to every column.
    fn lagged(&self, tau: f64) -> Line {
        let of = |column: &Vec<f64>| {
            let mut at = column[0];
            let mut all = vec![at];
            for k in 1..column.len() {
                let h = (self.time[k] - self.time[k - 1]) / tau;
                // The input is linear between rows.
                let (gone, slope) = ((-h).exp(), (column[k] - column[k - 1]) / h);
                at = column[k] - slope + (at - column[k - 1] + slope) * gone;
                all.push(at);
            }
            all
        };
        Line { columns: self.columns.iter().map(of).collect(), ..self.clone() }
    }
}

/// Relative addition to the diagonal of the normal equations. Numerical: rounding of 1e4 terms.
const ROUNDING: f64 = 1e-12;

/// Prior constraint of delta in (1): for each parameter the ratio of noise variance to prior variance, and the distance to the prior.
type Priors = Vec<(f64, f64)>;

/// Normal equations of (1) for an output, except for the residual: they are the same for all predictions.
struct Normal<'a> {
    lines: &'a [Line],
    late: f64,
    priors: &'a Priors,
    /// Sensitivities and the constant, reading by reading.
    rows: Vec<f64>,
    matrix: DMatrix<f64>,
    /// With the constraints of the priors.
    limited: Cholesky<f64, Dyn>,
}

impl<'a> Normal<'a> {
    /// `None` if too few readings have a value after the delay, or if they do not determine the parameters.
    fn new(lines: &'a [Line], late: f64, priors: &'a Priors) -> Option<Normal<'a>> {
        let q = priors.len();
        let mut matrix = DMatrix::<f64>::zeros(q + 1, q + 1);
        let there = lines.iter().flat_map(|line| &line.read).filter(|y| y.is_finite()).count();
        let mut rows = Vec::with_capacity(there * (q + 1));
        for line in lines {
            line.late(late, |_, at| {
                let from = rows.len();
                rows.extend(line.columns[1..].iter().map(|column| at(column)).chain([1.0]));
                let row = &rows[from..];
                for a in 0..=q {
                    for b in 0..=a {
                        matrix[(a, b)] += row[a] * row[b];
                    }
                }
            });
        }
        let count = rows.len() / (q + 1);
        if 2 * count < there || count <= q + 1 {
            return None;
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        let mut limited = matrix.clone();
        for (k, (weight, _)) in priors.iter().enumerate() {
            limited[(k, k)] += weight + ROUNDING * matrix[(k, k)].max(f64::MIN_POSITIVE);
        }
        limited[(q, q)] += ROUNDING * count as f64;
        let limited = limited.cholesky()?;
        Some(Normal { lines, late, priors, rows, matrix, limited })
    }

    /// S of (1) for a prediction of each line, minimised over delta and a constant, and the number of readings.
    fn mean_square<'b>(&self, predicted: impl Iterator<Item = &'b Vec<f64>>) -> (f64, usize) {
        let width = self.priors.len() + 1;
        let mut right = DVector::<f64>::zeros(width);
        let mut square = 0.0;
        let mut rows = self.rows.chunks_exact(width);
        for (line, column) in self.lines.iter().zip(predicted) {
            line.late(self.late, |y, at| {
                let off = y - at(column);
                let row = rows.next().unwrap_or_default();
                right.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * off);
                square += off * off;
            });
        }
        let mut toward = right.clone();
        for (k, (weight, away)) in self.priors.iter().enumerate() {
            toward[k] += weight * away;
        }
        let delta = self.limited.solve(&toward);
        let rest = square - 2.0 * delta.dot(&right) + (&self.matrix * &delta).dot(&delta);
        let count = self.rows.len() / width;
        (rest.max(f64::MIN_POSITIVE) / count as f64, count)
    }
}

/// S of (1) for the prediction of the fit.
fn mean_square(lines: &[Line], late: f64, priors: &Priors) -> Option<(f64, usize)> {
    Some(Normal::new(lines, late, priors)?.mean_square(lines.iter().map(|line| &line.columns[0])))
}

/// By run, output and row.
type Predictions = [Vec<Vec<f64>>];

/// Fit about which (1) is linearised.
pub struct About {
    /// By output, then by run.
    lines: Vec<Vec<Line>>,
    priors: Vec<Priors>,
}

impl About {
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn new(setup: &Setup, hypothesis: &Hypothesis, runs: &[usize]) -> Result<About, CalibrateError> {
        let slopes = Slopes::new(setup, hypothesis, runs, &[])?;
        let (m, inputs) = (setup.outputs(), setup.experiment.inputs.len());
        let mut lines: Vec<Vec<Line>> = vec![Vec::new(); m];
        for (r, run) in runs.iter().enumerate() {
            let table = &setup.experiment.runs[*run].table;
            let mut all = vec![slopes.tangents[r].shown.clone()];
            let blank = vec![0.0; all[0].len()];
            all.extend(
                (0..slopes.count()).map(|k| slopes.answer(hypothesis, r, k).unwrap_or_else(|| blank.clone())),
            );
            for (k, own) in lines.iter_mut().enumerate() {
                let column = |of: &Vec<f64>| of.iter().skip(k).step_by(m).copied().collect();
                own.push(Line {
                    time: table.time.clone(),
                    read: table.columns[inputs + k].clone(),
                    columns: all.iter().map(column).collect(),
                });
            }
        }
        let limits = |k: usize| -> Priors {
            let own = setup.declared.iter().zip(&hypothesis.declared);
            own.map(|(d, value)| {
                let weight = if d.is_free { 0.0 } else { (setup.sigma(k) / d.deviation).powi(2) };
                (weight, d.prior - value)
            })
            .collect()
        };
        Ok(About { lines, priors: (0..m).map(limits).collect() })
    }

    /// S of a delayed output, and the number of readings.
    pub fn late(&self, output: usize, late: f64) -> Option<(f64, usize)> {
        mean_square(&self.lines[output], late, &self.priors[output])
    }

    /// The same comparison for the readings from `from` to `to` alone.
    pub fn within(mut self, from: f64, to: f64) -> About {
        for line in self.lines.iter_mut().flatten() {
            let outside = line.time.iter().zip(&mut line.read).filter(|(t, _)| **t < from || **t > to);
            outside.for_each(|(_, y)| *y = f64::NAN);
        }
        self
    }

    /// The same for an output whose sensor has a first-order lag.
    pub fn lagged(&self, output: usize, tau: f64) -> Option<(f64, usize)> {
        let lines: Vec<Line> = self.lines[output].iter().map(|l| l.lagged(tau)).collect();
        mean_square(&lines, 0.0, &self.priors[output])
    }

    /// S of an output for other predictions, and the number of readings; for any number of them.
    pub fn with(&self, output: usize) -> Option<impl Fn(&Predictions) -> (f64, usize)> {
        let normal = Normal::new(&self.lines[output], 0.0, &self.priors[output])?;
        Some(move |predicted: &Predictions| normal.mean_square(predicted.iter().map(|run| &run[output])))
    }
}

/// Column after a first-order lag; blank readings remain blank.
pub fn lagging(table: &Table, column: usize, tau: f64) -> Vec<f64> {
    let known = || table.time.iter().zip(&table.columns[column]).filter(|(_, x)| x.is_finite());
    let (time, values): (Vec<f64>, Vec<f64>) = known().unzip();
    if values.is_empty() {
        return table.columns[column].clone();
    }
    let line = Line { time, read: Vec::new(), columns: vec![values] };
    let mut lagged = line.lagged(tau).columns.remove(0).into_iter();
    let of = |x: &f64| if x.is_finite() { lagged.next().unwrap_or(*x) } else { f64::NAN };
    table.columns[column].iter().map(of).collect()
}

/// Column with its delay corrected; blank where there is no reading.
pub fn moved(table: &Table, column: usize, late: f64) -> Vec<f64> {
    let line = Line {
        time: table.time.clone(),
        read: table.time.clone(),
        columns: vec![table.columns[column].clone()],
    };
    let mut all = vec![f64::NAN; table.time.len()];
    let mut rows = table.time.iter().enumerate().filter(|(_, t)| {
        let at = **t + late;
        at >= table.time[0] && at <= table.time[table.time.len() - 1]
    });
    line.late(-late, |_, at| {
        if let Some((row, _)) = rows.next() {
            all[row] = at(&line.columns[0]);
        }
    });
    all
}
