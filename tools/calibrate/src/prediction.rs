//! Prediction intervals of the repaired model for single readings.
//!
//! var(y_k - y(t_k)) = sigma^2 + j_k' C j_k + (kappa d_k)^2                                  (1)
//! kappa^2 = max(0, sum_k [(y_k - y(t_k))^2 - sigma^2 - j_k' C j_k] / sum_k d_k^2)           (2)
//!
//! sigma is the noise of an output including the direct contribution of input noise, j the sensitivities of the output to the fitted
//! parameters, and C their covariance. The last term is the structure error, the part that no parameter values can reproduce. It is
//! proportional to the excursion d of the output: for a temperature the rise over the first row, otherwise the value. (2) is a moment
//! estimate from runs that were not fitted, if there are any.
//! *Assumes* a normal distribution, and the same structure error relative to d in the runs of (2) as in those that are predicted.
//! *Source*: Kennedy, O'Hagan, J. R. Stat. Soc. B 63 (2001) 425-464, for the three parts.

use crate::fit::Slopes;
use crate::hypothesis::Hypothesis;
use crate::levels::SURE;
use crate::setup::{Setup, Shown};
use nalgebra::DMatrix;

/// First two terms of (1) at every row of a run, rows times outputs; `r` is the index among the linearised runs, the covariance is in the
/// parameters' units.
pub fn variance(
    setup: &Setup,
    hypothesis: &Hypothesis,
    slopes: &Slopes,
    r: usize,
    covariance: &DMatrix<f64>,
) -> Vec<f64> {
    let m = setup.outputs();
    let rows = slopes.tangents[r].time.len();
    let mut all: Vec<f64> = (0..rows * m).map(|k| setup.sigma(k % m).powi(2)).collect();
    let answers: Vec<(usize, Vec<f64>)> =
        (0..slopes.count()).filter_map(|k| Some((k, slopes.answer(hypothesis, r, k)?))).collect();
    for (a, left) in &answers {
        for (b, right) in answers.iter().filter(|(b, _)| b <= a) {
            let weight = if a == b { 1.0 } else { 2.0 } * covariance[(*a, *b)];
            all.iter_mut().zip(left.iter().zip(right)).for_each(|(sum, (x, y))| *sum += weight * x * y);
        }
    }
    all
}

/// Eq. (2) for each output over runs, from the predicted outputs and their variances.
pub fn structure(setup: &Setup, runs: &[usize], predicted: &[&Shown], variances: &[Vec<f64>]) -> Vec<f64> {
    let m = setup.outputs();
    let mut sums = vec![(0.0, 0.0); m];
    for ((run, shown), variance) in runs.iter().zip(predicted).zip(variances) {
        setup.each(*run, shown, |row, output, off| {
            let place = row * m + output;
            sums[output].0 += off * off - variance[place];
            sums[output].1 += excursion(setup, shown, place).powi(2);
        });
    }
    sums.into_iter().map(|(excess, size)| if size > 0.0 { (excess / size).max(0.0) } else { 0.0 }).collect()
}

/// Half width of the 95 % interval at every row of a run, by (1) with kappa^2 of each output.
pub fn half_widths(setup: &Setup, predicted: &Shown, variance: &[f64], structure: &[f64]) -> Shown {
    let half = |(place, variance): (usize, &f64)| {
        let of_structure = structure[place % setup.outputs()] * excursion(setup, predicted, place).powi(2);
        SURE * (variance.max(0.0) + of_structure).sqrt()
    };
    variance.iter().enumerate().map(half).collect()
}

/// Root mean square of the half widths over the readings of each output, and the fraction of readings inside; NaN without readings.
pub fn coverage(
    setup: &Setup,
    runs: &[usize],
    predicted: &[&Shown],
    half_widths: &[&Shown],
) -> Vec<(f64, f64)> {
    let m = setup.outputs();
    let mut sums = vec![(0.0, 0.0, 0.0); m];
    for ((run, shown), half) in runs.iter().zip(predicted).zip(half_widths) {
        setup.each(*run, shown, |row, output, off| {
            let half = half[row * m + output];
            let (squares, inside, count) = &mut sums[output];
            *squares += half * half;
            *inside += f64::from(u8::from(off.abs() <= half));
            *count += 1.0;
        });
    }
    sums.into_iter().map(|(squares, inside, count)| ((squares / count).sqrt(), inside / count)).collect()
}

/// d of (1).
fn excursion(setup: &Setup, predicted: &Shown, place: usize) -> f64 {
    let output = place % setup.outputs();
    let from = if setup.experiment.outputs[output].is_temperature() { predicted[output] } else { 0.0 };
    predicted[place] - from
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, PRIORS};

    /// The intervals of a correct model contain 95 % of its readings; those of a model with structure error are wider accordingly.
    #[test]
    fn intervals_hold_what_they_promise() {
        let mut experiment = testing::experiment(PRIORS, true);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        let inputs = experiment.inputs.len();
        let (mut rng, exact) = (testing::rng(8), experiment.runs[0].table.columns.clone());
        for (column, own) in experiment.runs[0].table.columns[inputs..].iter_mut().zip(&exact[inputs..]) {
            column
                .iter_mut()
                .zip(own)
                .for_each(|(x, own)| *x = own + testing::NOISE * testing::normal(&mut rng));
        }
        let of = |experiment: &crate::experiment::Experiment| -> (f64, f64, f64) {
            let setup = Setup::new(experiment, &[]).unwrap();
            let hypothesis = setup.preset();
            let predicted = setup.exact().show(&hypothesis, &[0]).unwrap().remove(0);
            let slopes = Slopes::new(&setup, &hypothesis, &[0], &[]).unwrap();
            let covariance = DMatrix::zeros(3, 3);
            let variance = variance(&setup, &hypothesis, &slopes, 0, &covariance);
            let kappa = structure(&setup, &[0], &[&predicted], std::slice::from_ref(&variance));
            let half = half_widths(&setup, &predicted, &variance, &kappa);
            let (width, inside) = coverage(&setup, &[0], &[&predicted], &[&half])[2];
            (width, inside, kappa[2].sqrt())
        };
        let (width, inside, kappa) = of(&experiment);
        // 300 readings: 0.95 +- 3 standard deviations.
        assert!((inside - 0.95).abs() < 0.04 && kappa < 1e-3, "{inside} {kappa}");
        assert!((width / (SURE * testing::NOISE) - 1.0).abs() < 0.1, "{width}");
        // Winding with a temperature rise 2 % higher.
        let column = &mut experiment.runs[0].table.columns[inputs + 2];
        let cold = column[0];
        column.iter_mut().for_each(|x| *x += 0.02 * (*x - cold));
        let (wide, inside, kappa) = of(&experiment);
        assert!(
            (kappa / 0.02 - 1.0).abs() < 0.1 && wide > 10.0 * width && inside > 0.95,
            "{kappa} {wide} {inside}"
        );
    }

    /// Uncertain parameters widen the interval according to the sensitivity of the outputs: R of a winding via the voltage at its current.
    #[test]
    fn uncertain_numbers_widen_the_interval() {
        let mut experiment = testing::experiment(PRIORS, false);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let hypothesis = setup.preset();
        let slopes = Slopes::new(&setup, &hypothesis, &[0], &[]).unwrap();
        let mut covariance = DMatrix::zeros(3, 3);
        let resistance = setup.declared.iter().position(|d| d.name == "motor.R_ref").unwrap();
        covariance[(resistance, resistance)] = 0.01f64.powi(2);
        let own = variance(&setup, &hypothesis, &slopes, 0, &covariance)[0];
        let expected = setup.sigma(0).powi(2) + (0.01f64 * 4.0).powi(2);
        assert!((own / expected - 1.0).abs() < 0.05, "{own} {expected}");
    }
}
