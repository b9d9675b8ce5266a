//! Error of good instruments: what is smaller is a property of the instruments, or of a motor with more nodes than the model, as much as of
//! a missing effect, however certain it is.
//!
//! Many readings average the noise of a sensor, but not its error: with 2000 rows an error of 0.1 K at a rise of 60 K is beyond doubt.

use crate::CalibrateError;
use crate::experiment::{Experiment, Role};
use crate::fit::Fitted;
use crate::intake::mean_square;
use crate::setup::{Setup, Shown};

/// Error relative to the readings, of a temperature rise and of any other quantity. Source: resistance thermometer of class B, IEC 60751
/// (0.5 % of the temperature); instruments of class 0.2, as IEC 60034-2-1 asks for in tests of motors.
const CLASS: (f64, f64) = (5e-3, 2e-3);

/// The errors in words.
pub fn words() -> String {
    let [rise, other] = [CLASS.0, CLASS.1].map(|share| 100.0 * share);
    format!("the error of good instruments ({rise} % of a temperature rise, {other} % of other quantities)")
}

/// Error of an output over runs, SI units.
pub fn error(experiment: &Experiment, runs: &[usize], output: usize) -> f64 {
    let (square, _) = mean_square(experiment, runs, output);
    let class = if experiment.outputs[output].is_temperature() { CLASS.0 } else { CLASS.1 };
    class * square.sqrt()
}

/// Decrease of the mean square error of each output with one prediction from that without it, relative to that of instruments.
pub fn decreases(setup: &Setup, runs: &[usize], [with, without]: [&[Shown]; 2]) -> Vec<f64> {
    let pairs = setup.squares(runs, with).into_iter().zip(setup.squares(runs, without));
    relative(setup, runs, pairs.map(|((with, count), (without, _))| (without - with) / count as f64))
}

/// The greatest of such mean squares, as root mean square.
pub fn greatest(squares: &[f64]) -> f64 {
    squares.iter().copied().filter(|square| square.is_finite()).fold(0.0, f64::max).sqrt()
}

/// Whether what a fit leaves of the runs with these roles, beyond the noise, is within the error of instruments.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn explain_rest(setup: &Setup, fitted: &Fitted, roles: &[Role]) -> Result<bool, CalibrateError> {
    for role in roles {
        let runs = setup.runs(*role);
        let shown = match role {
            Role::Fit => fitted.shown.clone(),
            _ => setup.show(&fitted.hypothesis, &runs)?,
        };
        if greatest(&relative(setup, &runs, beyond_noise(setup, &runs, &shown))) >= 1.0 {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Mean square error of each output of a prediction, less that of the noise.
pub fn beyond_noise(setup: &Setup, runs: &[usize], shown: &[Shown]) -> impl Iterator<Item = f64> {
    let squares = setup.squares(runs, shown).into_iter().enumerate();
    squares.map(|(k, (square, count))| square / count as f64 - setup.sigma(k).powi(2))
}

fn relative(setup: &Setup, runs: &[usize], squares: impl Iterator<Item = f64>) -> Vec<f64> {
    squares.enumerate().map(|(k, square)| square / error(setup.experiment, runs, k).powi(2)).collect()
}
