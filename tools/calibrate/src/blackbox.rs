//! Black-box models for comparison with the physical model: prediction from the same inputs without physics.
//!
//! Two kinds are fitted to the fit runs: a network of two thermal nodes with all parameters free ([`network`]), for temperatures,
//! and a linear difference equation ([`arx`]), for every channel. The validation error selects the kind and the order of the
//! equation; without validation runs, Akaike's final prediction error selects them. Both are simulated over a run from its first
//! row: no measured output enters the prediction.
//! *Source*: Ljung, System Identification, 2nd ed. (1999), 4.2 (ARX), 16.4 (choice by validation data; Akaike's final prediction error).

mod arx;
mod network;

use crate::deadline::Deadline;
use crate::experiment::{Role, Start};
use crate::outcome::BlackBox;
use crate::report::ROLES;
use crate::setup::Setup;

/// A run with the scaled inputs of the black boxes.
struct Series {
    role: Role,
    time: Vec<f64>,
    /// Inputs except ambient, divided by their largest magnitude in the fit runs: inputs by rows.
    inputs: Vec<Vec<f64>>,
    /// Ambient temperature at each row; 0 without one.
    ambient: Vec<f64>,
    /// Outputs by rows, NaN if not measured.
    outputs: Vec<Vec<f64>>,
    /// Whether a row is evaluated.
    counts: Vec<bool>,
    /// Whether the run starts at measured temperatures.
    is_warm: bool,
}

/// A candidate: its predictions of one output in every run, and its number of free parameters.
struct Candidate {
    kind: String,
    predicted: Vec<Vec<f64>>,
    parameters: usize,
}

/// The better black box for each channel that is measured in a fit run, for as many channels as the time allows.
pub fn black_boxes(setup: &Setup, deadline: &Deadline) -> Vec<BlackBox> {
    let all = series(setup);
    let experiment = setup.experiment;
    let (networks, equations) = rayon::join(
        || network::candidates(experiment, &all, deadline),
        || -> Vec<Vec<Candidate>> {
            let channels = experiment.outputs.iter().enumerate();
            channels.map(|(k, c)| arx::candidates(&all, k, c.is_temperature(), deadline)).collect()
        },
    );
    let mut found = Vec::new();
    for (k, (mut candidates, network)) in equations.into_iter().zip(networks).enumerate() {
        candidates.extend(network);
        let scored = candidates.into_iter().filter_map(|c| Some((score(&all, k, &c)?, c)));
        let Some((_, best)) = scored.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        let errors = ROLES.iter().filter_map(|role| Some((*role, rmse(&all, k, &best, *role)?.0)));
        found.push(BlackBox {
            column: experiment.outputs[k].column,
            kind: best.kind.clone(),
            errors: errors.collect(),
        });
    }
    found
}

impl BlackBox {
    /// Adds to the errors over means the noise of a reading beyond that of a mean: a reading differs from the mean of its block by noise.
    pub fn at_all_rows(&mut self, means: &Setup, all: &Setup) {
        let Some(k) = means.experiment.outputs.iter().position(|c| c.column == self.column) else { return };
        let within = (all.sensor_noise(k).powi(2) - means.sensor_noise(k).powi(2)).max(0.0);
        self.errors.iter_mut().for_each(|(_, error)| *error = (error.powi(2) + within).sqrt());
    }
}

/// The validation error of a candidate; without validation data, the root of the final prediction error. `None` if not finite.
fn score(all: &[Series], output: usize, candidate: &Candidate) -> Option<f64> {
    let value = match rmse(all, output, candidate, Role::Validate) {
        Some((error, _)) => error,
        None => {
            let (error, count) = rmse(all, output, candidate, Role::Fit)?;
            let share = candidate.parameters as f64 / count as f64;
            if share >= 1.0 {
                return None;
            }
            error * ((1.0 + share) / (1.0 - share)).sqrt()
        }
    };
    value.is_finite().then_some(value)
}

/// The RMS error over the evaluated rows of a role and their number; `None` without rows.
fn rmse(all: &[Series], output: usize, candidate: &Candidate, role: Role) -> Option<(f64, usize)> {
    let (mut sum, mut count) = (0.0, 0usize);
    for (run, predicted) in all.iter().zip(&candidate.predicted).filter(|(run, _)| run.role == role) {
        for (row, (y, p)) in run.outputs[output].iter().zip(predicted).enumerate() {
            if run.counts[row] && y.is_finite() {
                sum += (y - p).powi(2);
                count += 1;
            }
        }
    }
    (count > 0).then(|| ((sum / count as f64).sqrt(), count))
}

fn series(setup: &Setup) -> Vec<Series> {
    let experiment = setup.experiment;
    let is_ambient = |k: usize| experiment.inputs[k].is_temperature();
    let fit = setup.runs(Role::Fit);
    let size = |k: usize| {
        let most =
            fit.iter().flat_map(|r| &setup.drives[*r].inputs()[k]).fold(0.0, |a: f64, x| a.max(x.abs()));
        if most > 0.0 { most } else { 1.0 }
    };
    // Pressure varies too little to identify its effect.
    let used: Vec<usize> = (0..experiment.inputs.len())
        .filter(|k| !is_ambient(*k) && experiment.inputs[*k].unit != physics::declare::Unit::Pascal)
        .collect();
    let sizes: Vec<f64> = used.iter().map(|k| size(*k)).collect();
    let ambient = (0..experiment.inputs.len()).find(|k| is_ambient(*k));
    let one = |(run, of): (usize, &crate::experiment::Run)| {
        let inputs = setup.drives[run].inputs();
        let rows = of.table.time.len();
        let (from, to) = setup.windows[run];
        Series {
            role: of.role,
            time: of.table.time.clone(),
            inputs: used
                .iter()
                .zip(&sizes)
                .map(|(k, of)| inputs[*k].iter().map(|x| x / of).collect())
                .collect(),
            ambient: ambient.map_or_else(|| vec![0.0; rows], |k| inputs[k].clone()),
            outputs: of.table.columns[experiment.inputs.len()..].to_vec(),
            counts: of.table.time.iter().map(|t| (from..=to).contains(t)).collect(),
            is_warm: of.start == Start::Measured,
        }
    };
    experiment.runs.iter().enumerate().map(one).collect()
}
