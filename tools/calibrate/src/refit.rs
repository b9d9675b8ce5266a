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
use crate::candidate::{self, Candidate, Change, How};
use crate::experiment::{Experiment, Role, Run};
use crate::noise;
use crate::simulate::{Bench, Drive};
use nalgebra::{DMatrix, DVector};
use std::rc::Rc;

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
#[derive(Clone)]
pub struct Problem<'a> {
    experiment: &'a Experiment,
    bench: Rc<Bench>,
    drives: Rc<Vec<Drive>>,
    parameters: Vec<Free>,
    /// Noise of the outputs.
    sigma: Vec<f64>,
}

/// A number that is fitted.
#[derive(Clone, Debug)]
struct Free {
    name: String,
    how: How,
    /// Where it starts.
    prior: f64,
    /// Standard deviation of its prior; its scale where it has none.
    deviation: f64,
    has_prior: bool,
    limits: (f64, f64),
}

/// How much a candidate would explain.
#[derive(Clone, Debug)]
pub struct Score {
    /// The candidate.
    pub candidate: Candidate,
    /// By how much the weighted sum of squares would fall, to first order.
    pub gain: f64,
    /// The size that it would have.
    pub size: f64,
}

impl<'a> Problem<'a> {
    /// Every candidate by how much it would explain of what a fit to the runs of a role leaves, best first: its
    /// sensitivity, cleared of what the parameters can do by themselves, against the residual. Sizes against their
    /// limits are left out.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn scores(&self, role: Role, fitted: &[Fitted]) -> Result<Vec<Score>, CalibrateError> {
        let at: Vec<f64> = fitted.iter().map(|f| f.value).collect();
        let residual = self.residuals(role, &at)?;
        let slopes = self.slopes(role, &at, &residual)?;
        let Some(information) = (slopes.transpose() * &slopes).cholesky() else {
            return Err(CalibrateError("the parameters cannot be told apart by these runs".to_string()));
        };
        // What is left of a vector beside all that the parameters could do.
        let cleared = |v: &DVector<f64>| v - &slopes * information.solve(&(slopes.transpose() * v));
        let mut scores = Vec::new();
        for candidate in candidate::all(self.bench.declaration()) {
            // Small beside what would be seen, large beside rounding.
            let way = 1e-2 * candidate.size;
            let Ok(moved) = self.with(&candidate).residuals(role, &[at.as_slice(), &[way]].concat()) else {
                continue;
            };
            // Its own row has no prior and no error.
            let moved = moved.rows(0, residual.len()).into_owned();
            let direction = cleared(&((moved - &residual) / way));
            let power = direction.norm_squared();
            if power <= 0.0 {
                continue;
            }
            let size = -direction.dot(&residual) / power;
            if (candidate.limits.0..=candidate.limits.1).contains(&size) {
                scores.push(Score { gain: size * size * power, size, candidate });
            }
        }
        scores.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        Ok(scores)
    }

    /// The problem with the size of a candidate among what is fitted, last.
    pub fn with(&self, candidate: &Candidate) -> Problem<'a> {
        let mut parameters = self.parameters.clone();
        parameters.push(Free {
            name: candidate.name.clone(),
            how: candidate.how.clone(),
            prior: 0.0,
            deviation: candidate.size,
            has_prior: false,
            limits: candidate.limits,
        });
        Problem { parameters, ..self.clone() }
    }

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
            let how = How::Parameter { slot: entry.slot, with: Vec::new() };
            Ok(Free { name: p.name.clone(), how, prior, deviation, has_prior: true, limits })
        };
        let parameters = experiment.priors.iter().map(free).collect::<Result<Vec<_>, CalibrateError>>()?;
        let sigma = noise::of_experiment(experiment)[experiment.inputs.len()..].to_vec();
        Ok(Problem { experiment, bench: Rc::new(bench), drives: Rc::new(drives), parameters, sigma })
    }

    /// Fits the parameters to the runs of a role.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn fit(&self, role: Role) -> Result<Vec<Fitted>, CalibrateError> {
        self.fit_begun(role, self.parameters.iter().map(|p| p.prior).collect())
    }

    /// The same from fitted parameters on, with the size of a candidate last.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn fit_from(&self, role: Role, from: &[Fitted], size: f64) -> Result<Vec<Fitted>, CalibrateError> {
        self.fit_begun(role, from.iter().map(|f| f.value).chain([size]).collect())
    }

    fn fit_begun(&self, role: Role, mut at: Vec<f64>) -> Result<Vec<Fitted>, CalibrateError> {
        let free = &self.parameters;
        let mut residual = self.residuals(role, &at)?;
        let mut damping = 1e-3;
        let mut information = DMatrix::zeros(free.len(), free.len());
        for _ in 0..STEPS {
            let slopes = self.slopes(role, &at, &residual)?;
            information = slopes.transpose() * &slopes;
            let mut downhill = slopes.transpose() * &residual;
            // A parameter that would leave its limits stays there, and the others move as if it were none: clamped
            // after the step, it would spoil theirs.
            let mut curvature = information.clone();
            for (k, (p, x)) in free.iter().zip(&at).enumerate() {
                let leaves = if downhill[k] > 0.0 { *x <= p.limits.0 } else { *x >= p.limits.1 };
                if leaves {
                    curvature.row_mut(k).fill(0.0);
                    curvature.column_mut(k).fill(0.0);
                    curvature[(k, k)] = 1.0;
                    downhill[k] = 0.0;
                }
            }
            let now = residual.norm_squared();
            let mut better = None;
            while better.is_none() && damping < 1e9 {
                let mut damped = curvature.clone();
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

    /// The weighted sum of squares over the runs of a role, without the priors, and its number of readings.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn chi_square(&self, role: Role, fitted: &[Fitted]) -> Result<(f64, usize), CalibrateError> {
        let at: Vec<f64> = fitted.iter().map(|f| f.value).collect();
        let residual = self.residuals(role, &at)?;
        let rows = residual.len() - at.len();
        Ok((residual.rows(0, rows).norm_squared(), rows))
    }

    /// Errors of the model in every role that has runs, with fitted parameters; with none, of the preset.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn errors(&self, fitted: &[Fitted]) -> Result<Vec<Rmse>, CalibrateError> {
        let mut change = Change::default();
        for (free, fitted) in self.parameters.iter().zip(fitted) {
            free.how.apply(fitted.value, &mut change);
        }
        let mut all = Vec::new();
        for role in [Role::Fit, Role::Validate, Role::Test] {
            let mut sums = vec![(0.0, 0usize); self.sigma.len()];
            for (run, drive) in self.runs(role) {
                let shown = self.bench.run(drive, &change)?;
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

    /// Correlations of the fitted parameters by (1) with the runs of a role: which of them are known together only.
    ///
    /// # Errors
    /// What the model says where it cannot be run; parameters that cannot be told apart at all.
    pub fn correlations(&self, role: Role, fitted: &[Fitted]) -> Result<DMatrix<f64>, CalibrateError> {
        let at: Vec<f64> = fitted.iter().map(|f| f.value).collect();
        let slopes = self.slopes(role, &at, &self.residuals(role, &at)?)?;
        let covariance = (slopes.transpose() * &slopes)
            .cholesky()
            .map(|c| c.inverse())
            .ok_or_else(|| CalibrateError("the parameters cannot be told apart by these runs".to_string()))?;
        Ok(DMatrix::from_fn(at.len(), at.len(), |i, k| {
            covariance[(i, k)] / (covariance[(i, i)] * covariance[(k, k)]).sqrt()
        }))
    }

    /// Measured less shown at every counted row of one run, with the output's number, in SI units.
    ///
    /// # Errors
    /// What the model says where it cannot be run.
    pub fn misses(&self, run: usize, fitted: &[Fitted]) -> Result<Vec<(usize, f64)>, CalibrateError> {
        let mut change = Change::default();
        self.parameters.iter().zip(fitted).for_each(|(p, f)| p.how.apply(f.value, &mut change));
        let shown = self.bench.run(&self.drives[run], &change)?;
        let mut all = Vec::new();
        self.each(&self.experiment.runs[run], &shown, |n, off| all.push((n, off)));
        Ok(all)
    }

    fn runs(&self, role: Role) -> impl Iterator<Item = (&Run, &Drive)> {
        self.experiment.runs.iter().zip(self.drives.iter()).filter(move |(run, _)| run.role == role)
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
        let mut change = Change::default();
        self.parameters.iter().zip(at).for_each(|(p, x)| p.how.apply(*x, &mut change));
        let mut all = Vec::new();
        for (run, drive) in self.runs(role) {
            let shown = self.bench.run(drive, &change)?;
            self.each(run, &shown, |n, off| all.push(-off / self.sigma[n]));
        }
        let from_prior = |(p, x): (&Free, &f64)| if p.has_prior { (x - p.prior) / p.deviation } else { 0.0 };
        all.extend(self.parameters.iter().zip(at).map(from_prior));
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
