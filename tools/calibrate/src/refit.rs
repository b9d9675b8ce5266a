//! Parameters of the declared model from data: bounded Gauss-Newton with priors.
//!
//! minimise  sum_k [(y_k - y(t_k; p)) / sigma]^2 + sum_j [(p_j - p_j0) / (s_j p_j0)]^2             (1)
//!
//! y over all counted rows of the runs that are to be fitted, p_j0 the preset's value and s_j the relative standard
//! deviation of its prior. Steps are damped (Levenberg, Marquardt) and stop at each parameter's limits. Slopes by
//! differences: the native model runs hours in a millisecond. A refit alone is the naive answer to a model that lacks
//! something: it is there to be compared with.
//! *Source*: Bates, Watts, Nonlinear Regression Analysis (1988), ch. 2 and 3; priors as in PEtab.

use crate::CalibrateError;
use crate::experiment::{Experiment, Role, Run};
use crate::noise;
use crate::simulate::{Bench, Drive};
use nalgebra::{DMatrix, DVector};
use physics::model::Slot;

/// What the fit minimises is down to this share of itself from step to step.
const SETTLED: f64 = 1e-6;
/// Most steps.
const STEPS: usize = 40;
/// Relative way over which a slope is taken.
const WAY: f64 = 1e-4;

/// A parameter that is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// The preset's value.
    pub prior: f64,
    /// Its standard deviation by (1).
    pub deviation: f64,
}

/// Root mean square error of one output over all counted rows of a role.
#[derive(Clone, Debug, PartialEq)]
pub struct Rmse {
    /// The role.
    pub role: Role,
    /// One value for each output, in its unit.
    pub outputs: Vec<f64>,
}

/// An experiment, ready to be fitted.
pub struct Problem<'a> {
    experiment: &'a Experiment,
    bench: Bench,
    drives: Vec<Drive>,
    parameters: Vec<Free>,
    /// Noise of the outputs.
    sigma: Vec<f64>,
}

struct Free {
    name: String,
    slot: Slot,
    prior: f64,
    deviation: f64,
    limits: (f64, f64),
}

impl<'a> Problem<'a> {
    /// The problem of an experiment; `preset` are the start values of its preset, by value reference.
    ///
    /// # Errors
    /// A run that the model cannot be driven with.
    pub fn new(experiment: &'a Experiment, preset: &[(u32, f64)]) -> Result<Problem<'a>, CalibrateError> {
        let bench = Bench::new(experiment, preset)?;
        let drives =
            experiment.runs.iter().map(|run| Drive::new(experiment, run)).collect::<Result<Vec<_>, _>>()?;
        let unknown = |name: &str| CalibrateError(format!("{} has no {name}", experiment.model));
        let declaration =
            physics::models::by_name(&experiment.model).ok_or_else(|| unknown("declaration"))?.declaration;
        let free = |p: &crate::experiment::Prior| {
            let entry = declaration().by_name(&p.name).ok_or_else(|| unknown(&p.name))?;
            let prior = bench.start_of(entry.slot);
            let deviation = (p.relative * prior).abs().max(1e-12);
            let limits = (entry.row.min, entry.row.max);
            Ok(Free { name: p.name.clone(), slot: entry.slot, prior, deviation, limits })
        };
        let parameters = experiment.priors.iter().map(free).collect::<Result<Vec<_>, CalibrateError>>()?;
        let sigma = noise::of_experiment(experiment)[experiment.inputs.len()..].to_vec();
        Ok(Problem { experiment, bench, drives, parameters, sigma })
    }

    /// Fits the parameters to the runs of a role.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn fit(&self, role: Role) -> Result<Vec<Fitted>, CalibrateError> {
        let free = &self.parameters;
        let mut at: Vec<f64> = free.iter().map(|p| p.prior).collect();
        let mut residual = self.residuals(role, &at)?;
        let mut damping = 1e-3;
        let mut information = DMatrix::zeros(free.len(), free.len());
        for _ in 0..STEPS {
            let slopes = self.slopes(role, &at, &residual)?;
            information = slopes.transpose() * &slopes;
            let downhill = slopes.transpose() * &residual;
            let now = residual.norm_squared();
            let mut better = None;
            while better.is_none() && damping < 1e9 {
                let mut damped = information.clone();
                for k in 0..free.len() {
                    damped[(k, k)] *= 1.0 + damping;
                }
                let Some(step) = damped.cholesky().map(|c| c.solve(&downhill)) else { break };
                // In units of each prior's deviation.
                let moved = free.iter().zip(&at).zip(step.iter());
                let next: Vec<f64> =
                    moved.map(|((p, x), s)| (x - s * p.deviation).clamp(p.limits.0, p.limits.1)).collect();
                match self.residuals(role, &next) {
                    Ok(found) if found.norm_squared() < now => better = Some((next, found)),
                    _ => damping *= 5.0,
                }
            }
            let Some((next, found)) = better else { break };
            damping = (damping / 10.0).max(1e-9);
            let gain = 1.0 - found.norm_squared() / now;
            (at, residual) = (next, found);
            if gain < SETTLED {
                break;
            }
        }
        let covariance = information.cholesky().map(|c| c.inverse());
        let deviation = |k: usize| covariance.as_ref().map_or(f64::NAN, |c| c[(k, k)].sqrt());
        let fitted = free.iter().zip(&at).enumerate().map(|(k, (p, value))| Fitted {
            name: p.name.clone(),
            value: *value,
            prior: p.prior,
            deviation: deviation(k) * p.deviation,
        });
        Ok(fitted.collect())
    }

    /// Errors of the model in every role that has runs, with fitted parameters; with none, of the preset.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn errors(&self, fitted: &[Fitted]) -> Result<Vec<Rmse>, CalibrateError> {
        let changes: Vec<(Slot, f64)> =
            fitted.iter().filter_map(|f| Some((self.bench.slot(&f.name)?, f.value))).collect();
        let mut all = Vec::new();
        for role in [Role::Fit, Role::Validate, Role::Test] {
            let mut sums = vec![(0.0, 0usize); self.sigma.len()];
            for (run, drive) in self.runs(role) {
                let shown = self.bench.run(drive, &changes)?;
                self.each(run, &shown, |n, off| {
                    sums[n].0 += off * off;
                    sums[n].1 += 1;
                });
            }
            if sums.iter().any(|(_, count)| *count > 0) {
                let outputs = sums.iter().map(|(sum, count)| (sum / *count as f64).sqrt()).collect();
                all.push(Rmse { role, outputs });
            }
        }
        Ok(all)
    }

    fn runs(&self, role: Role) -> impl Iterator<Item = (&Run, &Drive)> {
        self.experiment.runs.iter().zip(&self.drives).filter(move |(run, _)| run.role == role)
    }

    /// Calls with output and error for every counted row that was measured.
    fn each(&self, run: &Run, shown: &[Vec<f64>], mut tell: impl FnMut(usize, f64)) {
        let inputs = self.experiment.inputs.len();
        let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        for (n, column) in shown.iter().enumerate() {
            let rows = run.table.columns[inputs + n].iter().zip(column).zip(&run.table.time);
            for ((measured, shown), t) in rows {
                if (from..=to).contains(t) && measured.is_finite() {
                    tell(n, measured - shown);
                }
            }
        }
    }

    /// What (1) squares: errors over noise, then parameters from their priors.
    fn residuals(&self, role: Role, at: &[f64]) -> Result<DVector<f64>, CalibrateError> {
        let changes: Vec<(Slot, f64)> = self.parameters.iter().zip(at).map(|(p, x)| (p.slot, *x)).collect();
        let mut all = Vec::new();
        for (run, drive) in self.runs(role) {
            let shown = self.bench.run(drive, &changes)?;
            self.each(run, &shown, |n, off| all.push(-off / self.sigma[n]));
        }
        all.extend(self.parameters.iter().zip(at).map(|(p, x)| (x - p.prior) / p.deviation));
        Ok(DVector::from_vec(all))
    }

    /// Slopes of the residuals over each parameter in units of its prior's deviation.
    fn slopes(&self, role: Role, at: &[f64], here: &DVector<f64>) -> Result<DMatrix<f64>, CalibrateError> {
        let mut slopes = DMatrix::zeros(here.len(), at.len());
        for (k, p) in self.parameters.iter().enumerate() {
            let way = WAY * at[k].abs().max(p.deviation);
            let way = if at[k] + way > p.limits.1 { -way } else { way };
            let mut moved = at.to_vec();
            moved[k] += way;
            let column = (self.residuals(role, &moved)? - here) * (p.deviation / way);
            slopes.set_column(k, &column);
        }
        Ok(slopes)
    }
}
