//! Parameters of a native model from measured steady states by bounded least squares, the leave-one-out predictions, and what the data
//! identify.
//!
//! Parameters move in units of their scale: a logarithm if declared, else the nominal value.

use crate::StudyError;
use crate::bench::{Bench, STEADY};
use crate::steady::Setup;
use least_squares::{Options, minimise};
use nalgebra::{DMatrix, DVector};
use physics::declare::Scale;
use physics::model::Entry;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Step of the central differences, in units of the scale: large against the 1e-4 K of a steady state.
const DIFFERENCE: f64 = 5e-3;
/// When a fit ends: what a smaller decrease or step would add is noise of the steady states.
const OPTIONS: Options = Options {
    damping: 1e-3,
    linearisations: 40,
    chords: 1,
    relative_decrease: 1e-5,
    decrease: 0.0,
    step: 1e-6,
    gradient: 1e-9,
    curved: false,
    rival: f64::INFINITY,
};
/// The same for a fit without one observation.
const REFIT: Options = Options { damping: 1e-6, step: 1e-5, ..OPTIONS };

/// A steady state that was measured.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Name in the report.
    pub name: String,
    /// The model as it was tested.
    pub setup: Setup,
    /// Output that was measured.
    pub output: &'static str,
    /// The measured value, SI.
    pub measured: f64,
}

/// What a fit found.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Parameters, in order.
    pub parameters: Vec<Fitted>,
    /// Model less measurement for each observation.
    pub residuals: Vec<f64>,
    /// Root of their mean square.
    pub rms: f64,
    /// Singular values of the Jacobian in scaled parameters, largest first: change of all observations along
    /// each direction. Directions below the uncertainty of a measurement are not identifiable.
    pub singular_values: Vec<f64>,
    /// Correlations between the estimates, parameter by parameter.
    pub correlations: Vec<Vec<f64>>,
    #[serde(skip)]
    z: DVector<f64>,
    #[serde(skip)]
    jacobian: DMatrix<f64>,
}

/// A parameter and its estimate.
#[derive(Clone, Debug, Serialize)]
pub struct Fitted {
    /// Name.
    pub name: String,
    /// Estimate, SI.
    pub value: f64,
    /// Standard deviation of the estimate for measurements with a standard deviation of 1; infinite where the
    /// data say nothing.
    pub deviation: Option<f64>,
    /// Whether it is at a limit.
    pub at_limit: bool,
}

/// What a fit without one observation predicts for it.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOut {
    /// Name of the observation.
    pub case: String,
    /// Measured, SI.
    pub measured: f64,
    /// Predicted, SI.
    pub predicted: f64,
    /// Predicted less measured.
    pub error: f64,
    /// Parameters at a limit in the fit without it: the other data do not identify them.
    pub at_limit: Vec<String>,
}

/// A parameter as the fit moves it.
struct Axis {
    entry: &'static Entry,
    scale: f64,
    range: (f64, f64),
}

impl Axis {
    fn new(entry: &'static Entry) -> Axis {
        let row = entry.row;
        let scale = if row.scale == Scale::Log { 1.0 } else { row.nominal };
        let mut axis = Axis { entry, scale, range: (0.0, 0.0) };
        axis.range = (axis.inside(row.min), axis.inside(row.max));
        axis
    }

    /// The scaled value of a value.
    fn inside(&self, value: f64) -> f64 {
        if self.entry.row.scale == Scale::Log { value.ln() } else { value / self.scale }
    }

    /// The value of a scaled value, within the declared limits.
    fn outside(&self, z: f64) -> f64 {
        let value = if self.entry.row.scale == Scale::Log { z.exp() } else { z * self.scale };
        value.clamp(self.entry.row.min, self.entry.row.max)
    }

    /// Whether a scaled value is at a limit.
    fn is_limit(&self, z: f64) -> bool {
        z <= self.range.0 || z >= self.range.1
    }

    /// Change of the value with the scaled value.
    fn slope(&self, z: f64) -> f64 {
        if self.entry.row.scale == Scale::Log { z.exp() } else { self.scale }
    }
}

/// The problem: which parameters, which observations.
pub struct Problem {
    axes: Vec<Axis>,
    observations: Vec<Observed>,
    start: DVector<f64>,
}

/// A fit of all observations, or of all but one with a Jacobian that is held.
struct Fitting<'a> {
    problem: &'a Problem,
    held: Option<(usize, DMatrix<f64>)>,
}

impl least_squares::Problem for Fitting<'_> {
    type Point = DVector<f64>;
    type Slopes = DMatrix<f64>;
    type Error = StudyError;

    fn evaluate(&self, z: &DVector<f64>) -> Result<DVector<f64>, StudyError> {
        self.problem.residuals(z, self.held.as_ref().map(|(without, _)| *without))
    }

    fn cost(&self, residuals: &DVector<f64>) -> f64 {
        residuals.norm_squared()
    }

    fn linearise(&self, z: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, StudyError> {
        self.held.as_ref().map_or_else(|| self.problem.jacobian(z), |(_, jacobian)| Ok(jacobian.clone()))
    }

    fn information(&self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        jacobian.tr_mul(jacobian)
    }

    fn gradient(&self, _: &DVector<f64>, residuals: &DVector<f64>, jacobian: &DMatrix<f64>) -> DVector<f64> {
        jacobian.tr_mul(residuals)
    }
}

/// An observation, and the model in its steady state at the start: from there the next one is not far.
struct Observed {
    observation: Observation,
    settled: Mutex<Bench>,
}

impl Observed {
    fn new(observation: Observation) -> Result<Observed, StudyError> {
        let mut bench = observation.setup.bench()?;
        bench.steady_state()?;
        Ok(Observed { observation, settled: Mutex::new(bench) })
    }

    /// A copy of the settled model.
    fn copy(&self) -> Bench {
        self.settled.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Problem {
    /// Parameters by name, which start where the first observation's setup has them.
    ///
    /// # Errors
    /// No observation, or a parameter that the model does not have.
    pub fn new(parameters: &[&str], observations: Vec<Observation>) -> Result<Problem, StudyError> {
        let observations: Vec<Observed> =
            observations.into_par_iter().map(Observed::new).collect::<Result<_, _>>()?;
        let mut first = match observations.first() {
            Some(observed) => observed.copy(),
            None => return Err(StudyError::new("a fit needs at least one observation")),
        };
        let mut axes = Vec::new();
        let mut start = Vec::new();
        for name in parameters {
            let axis = Axis::new(first.entry(name)?);
            let z = axis.inside(first.get(name)?);
            start.push(z.clamp(axis.range.0, axis.range.1));
            axes.push(axis);
        }
        Ok(Problem { axes, observations, start: DVector::from_vec(start) })
    }

    /// The model's value for an observation.
    fn predict(&self, observed: &Observed, z: &DVector<f64>) -> Result<f64, StudyError> {
        let mut bench = observed.copy();
        for (axis, z) in self.axes.iter().zip(z) {
            bench.set(&axis.entry.name, axis.outside(*z))?;
        }
        bench.settle()?;
        bench.get(observed.observation.output)
    }

    fn residuals(&self, z: &DVector<f64>, without: Option<usize>) -> Result<DVector<f64>, StudyError> {
        let kept: Vec<&Observed> = self.kept(without).collect();
        let found: Result<Vec<f64>, StudyError> =
            kept.par_iter().map(|o| Ok(self.predict(o, z)? - o.observation.measured)).collect();
        Ok(DVector::from_vec(found?))
    }

    fn kept(&self, without: Option<usize>) -> impl Iterator<Item = &Observed> {
        self.observations.iter().enumerate().filter(move |(k, _)| Some(*k) != without).map(|(_, o)| o)
    }

    /// Central differences; one-sided where a limit is near.
    fn jacobian(&self, z: &DVector<f64>) -> Result<DMatrix<f64>, StudyError> {
        let columns: Result<Vec<DVector<f64>>, StudyError> = (0..self.axes.len())
            .into_par_iter()
            .map(|k| {
                let (least, greatest) = self.axes[k].range;
                let (mut below, mut above) = (z.clone(), z.clone());
                below[k] = (z[k] - DIFFERENCE).max(least);
                above[k] = (z[k] + DIFFERENCE).min(greatest);
                let change = self.residuals(&above, None)? - self.residuals(&below, None)?;
                let column = change / (above[k] - below[k]);
                // Below what two steady states can resolve there is only their noise, which must not steer.
                let noise = STEADY / DIFFERENCE * (column.len() as f64).sqrt();
                Ok(if column.norm() > noise { column } else { 0.0 * column })
            })
            .collect();
        Ok(DMatrix::from_columns(&columns?))
    }

    /// Fits all observations.
    ///
    /// # Errors
    /// A model that does not settle at the start.
    pub fn fit(&self) -> Result<Fit, StudyError> {
        let found =
            minimise(&Fitting { problem: self, held: None }, self.start.clone(), &self.limits(), &OPTIONS)?;
        let jacobian = self.jacobian(&found.x)?;
        Ok(self.describe(found.x, &found.point, jacobian))
    }

    /// The parameters that fit all observations but one. The way from the fit of all is short, so that the
    /// Jacobian of that fit serves for all steps.
    fn refit(&self, fit: &Fit, without: usize) -> Result<DVector<f64>, StudyError> {
        let held = Some((without, fit.jacobian.clone().remove_row(without)));
        Ok(minimise(&Fitting { problem: self, held }, fit.z.clone(), &self.limits(), &REFIT)?.x)
    }

    fn limits(&self) -> Vec<(f64, f64)> {
        self.axes.iter().map(|axis| axis.range).collect()
    }

    fn describe(&self, z: DVector<f64>, residuals: &DVector<f64>, jacobian: DMatrix<f64>) -> Fit {
        let n = self.axes.len();
        let decomposition = jacobian.clone().svd(false, true);
        let mut order: Vec<usize> = (0..decomposition.singular_values.len()).collect();
        order.sort_by(|a, b| decomposition.singular_values[*b].total_cmp(&decomposition.singular_values[*a]));
        let largest = order.first().map_or(0.0, |k| decomposition.singular_values[*k]);
        // Covariance of the scaled estimates for measurements of deviation 1; a direction that the data do not
        // see has an infinite one.
        let mut covariance = DMatrix::<f64>::zeros(n, n);
        let mut blind = vec![order.len() < n; n];
        if let Some(v_t) = &decomposition.v_t {
            for &k in &order {
                let s = decomposition.singular_values[k];
                let direction = v_t.row(k).transpose();
                if s > 1e-9 * largest {
                    covariance += &direction * direction.transpose() / (s * s);
                } else {
                    blind.iter_mut().zip(&direction).for_each(|(b, d)| *b |= d.abs() > 1e-6);
                }
            }
        }
        let deviation = |k: usize| covariance[(k, k)].sqrt();
        let correlation = |i: usize, j: usize| {
            let both = deviation(i) * deviation(j);
            if both > 0.0 { covariance[(i, j)] / both } else { 0.0 }
        };
        let parameters = self
            .axes
            .iter()
            .enumerate()
            .map(|(k, axis)| Fitted {
                name: axis.entry.name.clone(),
                value: axis.outside(z[k]),
                deviation: (!blind[k]).then(|| deviation(k) * axis.slope(z[k])),
                at_limit: axis.is_limit(z[k]),
            })
            .collect();
        Fit {
            parameters,
            residuals: residuals.iter().copied().collect(),
            rms: (residuals.norm_squared() / residuals.len() as f64).sqrt(),
            singular_values: order.iter().map(|k| decomposition.singular_values[*k]).collect(),
            correlations: (0..n).map(|i| (0..n).map(|j| correlation(i, j)).collect()).collect(),
            z,
            jacobian,
        }
    }

    /// Leaves each observation out in turn, fits the others from `fit` on, and predicts the one left out.
    ///
    /// # Errors
    /// A model that does not settle.
    pub fn leave_one_out(&self, fit: &Fit) -> Result<Vec<LeftOut>, StudyError> {
        (0..self.observations.len())
            .into_par_iter()
            .map(|k| {
                let observed = &self.observations[k];
                let observation = &observed.observation;
                let z = self.refit(fit, k)?;
                let predicted = self.predict(observed, &z)?;
                let at_limit = self.axes.iter().zip(&z).filter(|(axis, z)| axis.is_limit(**z));
                let at_limit = at_limit.map(|(axis, _)| axis.entry.name.clone()).collect();
                let measured = observation.measured;
                let case = observation.name.clone();
                Ok(LeftOut { case, measured, predicted, error: predicted - measured, at_limit })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steady temperatures at known parameters, as if measured: 10 W at several fan commands.
    fn problem(parameters: &[&str]) -> Problem {
        let observation = |command: f64| {
            let sets = [("electrical_power", "10"), ("fan_command", &command.to_string())];
            let setup = Setup::new("AnnulusCooledMotor", None, &sets);
            // By hand: T_w = T_a + P (R_wh + 1/(G_still + G_forced n^0.8)) with 0.3 K/W, 0.2 and 0.5 W/K.
            let measured = 298.15 + 10.0 * (0.3 + 1.0 / (0.2 + 0.5 * f64::powf(command, 0.8)));
            Observation { name: format!("n={command}"), setup, output: "winding_temperature", measured }
        };
        Problem::new(parameters, [0.0, 0.1, 0.5, 1.0].map(observation).to_vec()).unwrap()
    }

    #[test]
    fn parameters_come_back() {
        let fit = problem(&["conductance.G_still", "conductance.G_forced", "thermal.R_wh"]).fit().unwrap();
        let values: Vec<f64> = fit.parameters.iter().map(|p| p.value).collect();
        for (value, expected) in values.iter().zip([0.2, 0.5, 0.3]) {
            assert!((value / expected - 1.0).abs() < 1e-3, "{values:?}");
        }
        assert!(fit.rms < 1e-3 && fit.parameters.iter().all(|p| !p.at_limit));
    }

    /// A heat capacity has no effect on a steady state: it keeps its start value and has no standard deviation.
    #[test]
    fn a_parameter_that_the_data_do_not_identify_has_no_deviation() {
        let fit = problem(&["conductance.G_still", "thermal.C_w"]).fit().unwrap();
        assert!(fit.singular_values[1] < 1e-9 * fit.singular_values[0], "{:?}", fit.singular_values);
        let capacity = &fit.parameters[1];
        assert!(capacity.deviation.is_none() && capacity.value == 10.05, "{capacity:?}");
    }

    #[test]
    fn a_left_out_case_is_predicted() {
        let problem = problem(&["conductance.G_still", "conductance.G_forced", "thermal.R_wh"]);
        let fit = problem.fit().unwrap();
        for left_out in problem.leave_one_out(&fit).unwrap() {
            assert!(left_out.error.abs() < 0.05, "{left_out:?}");
        }
    }

    #[test]
    fn unknown_parameters_are_named() {
        let error = Problem::new(&["x"], Vec::new()).err().unwrap().to_string();
        assert!(error.contains("at least one"), "{error}");
        let one = problem(&["thermal.R_wh"]).observations;
        let one = one.into_iter().map(|o| o.observation).collect();
        assert!(Problem::new(&["thermal.R_w"], one).err().unwrap().to_string().contains("thermal.R_wh"));
    }
}
