//! Bounded nonlinear least squares: Levenberg and Marquardt's method.
//!
//! minimise  F(x) = r(x)^T r(x)   subject to  l <= x <= u                                   (1)
//!
//! With the slopes J of r, N = J^T J and g = J^T r, a step d minimises
//!
//! 2 g^T d + d^T (N + lambda D^2) d   subject to  l <= x + d <= u                           (2)
//!
//! D holds the greatest norms of the columns of J so far (Moré), so the units of x do not matter. lambda follows the ratio of the
//! decrease of F to the decrease that the linear model predicts (Nielsen); after a step that fails it increases until the next one is
//! shorter, which takes several times if lambda is small against N. A variable that a step would move out of its range stops at
//! the limit, and the others are solved for again. A prior is a residual like any other.
//!
//! Where a step decreases F less than predicted, r is curved along it, as in a valley of two variables that nearly replace each other. Its
//! second derivative along d follows from r(x + d); with it, (2) becomes
//!
//! 2 (J^T r(x + d) - N d)^T d' + d'^T (N + lambda D^2) d'                                   (3)
//!
//! and d' = d + a/2 with the geodesic acceleration a follows the valley. It costs an evaluation and no slopes.
//! *Sources*: Moré, The Levenberg-Marquardt algorithm (1978); Madsen, Nielsen, Tingleff, Methods for non-linear least squares
//! problems (2004), 3.2; Transtrum, Sethna, arXiv:1201.5885 (2012), for (3); Kanzow, Yamashita, Fukushima, J. Comput. Appl. Math. 172 (2004) for the projection.

use nalgebra::{DMatrix, DVector};

/// Damping at which the iteration ends.
const MOST_DAMPING: f64 = 1e12;
/// Least ratio of decrease to predicted decrease of a step that is accepted.
const ACCEPTED: f64 = 1e-4;
/// Least ratio at which the sensitivities are reused.
const GOOD: f64 = 0.25;
/// Damping of the step that gains all that the model has to offer: enough to keep a singular N solvable.
const UNDAMPED: f64 = 1e-9;
/// Decrease, relative to F, below which the linear model is believed to be right about what can be gained.
const NEAR: f64 = 0.1;
/// Ratio below which the curvature of r is taken into account.
const BENT: f64 = 0.75;
/// Greatest change of a step by the curvature, relative to it (Transtrum and Sethna: 2 |a/2| <= 0.75 |d|).
const MOST_BENT: f64 = 0.375;
/// Greatest length of a step after one that fails, relative to it: a longer one ends at nearly the same point.
const SHORTER: f64 = 0.9;

/// A least-squares problem. `Slopes` may store J in any form; the solver requires only N and g of (2).
pub trait Problem {
    /// The result of an evaluation, such as residuals or a simulation.
    type Point;
    /// The linearisation at a point.
    type Slopes;
    /// Why an evaluation failed.
    type Error;

    /// The residuals at `x`, which is within the limits.
    ///
    /// # Errors
    /// The problem's own. A trial step that fails is shortened.
    fn evaluate(&self, x: &DVector<f64>) -> Result<Self::Point, Self::Error>;

    /// F of (1).
    fn cost(&self, point: &Self::Point) -> f64;

    /// The slopes J.
    ///
    /// # Errors
    /// The problem's own.
    fn linearise(&self, x: &DVector<f64>, point: &Self::Point) -> Result<Self::Slopes, Self::Error>;

    /// N = J^T J.
    fn information(&self, slopes: &Self::Slopes) -> DMatrix<f64>;

    /// g = J^T r, with the residuals at `point`.
    fn gradient(&self, x: &DVector<f64>, point: &Self::Point, slopes: &Self::Slopes) -> DVector<f64>;

    /// Whether to end with the best point so far, as when time is up.
    fn stop(&self) -> bool {
        false
    }

    /// Whether slopes found at `from` are good enough to judge convergence at `x`.
    fn is_near(&self, from: &DVector<f64>, x: &DVector<f64>) -> bool {
        from == x
    }
}

/// When to stop, and how often slopes are used.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Initial damping: small for a start near the solution.
    pub damping: f64,
    /// Most linearisations.
    pub linearisations: usize,
    /// Most steps with the same slopes (chords).
    pub chords: usize,
    /// Converged: F decreases by less than this fraction of itself, and the linear model predicts no more.
    pub relative_decrease: f64,
    /// The same for the decrease itself.
    pub decrease: f64,
    /// Converged: a step is shorter than this fraction of x.
    pub step: f64,
    /// Converged: the cosine between the residuals and every free column of J is smaller.
    pub gradient: f64,
    /// Whether steps follow the curvature of r, eq. (3).
    pub curved: bool,
    /// F of another solution: the search ends where the linear model promises no smaller one.
    pub rival: f64,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            damping: 1e-3,
            linearisations: 200,
            chords: 1,
            relative_decrease: 1e-12,
            decrease: 0.0,
            step: 1e-12,
            gradient: 1e-12,
            curved: true,
            rival: f64::INFINITY,
        }
    }
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The gradient of the free variables is zero.
    Gradient,
    /// F decreases no more.
    Decrease,
    /// The steps are too short to matter, or none decreases F.
    Step,
    /// The most linearisations were used, the problem asked to stop, or a rival is better.
    Unfinished,
}

/// The best point that was found.
pub struct Solution<P: Problem> {
    /// The variables, within their limits.
    pub x: DVector<f64>,
    /// The evaluation there.
    pub point: P::Point,
    /// The last slopes, which may be those of a point before.
    pub slopes: P::Slopes,
    /// Why the search ended.
    pub status: Status,
    /// Evaluations made.
    pub evaluations: usize,
    /// Linearisations made.
    pub linearisations: usize,
}

/// Minimises (1) from a start, which is moved into the limits.
///
/// # Errors
/// An evaluation that fails at the start, or a linearisation that fails.
pub fn minimise<P: Problem>(
    problem: &P,
    start: DVector<f64>,
    limits: &[(f64, f64)],
    options: &Options,
) -> Result<Solution<P>, P::Error> {
    let mut x = DVector::from_fn(start.len(), |k, _| start[k].clamp(limits[k].0, limits[k].1));
    let mut point = problem.evaluate(&x)?;
    let mut cost = problem.cost(&point);
    let mut scale = DVector::<f64>::zeros(x.len());
    let (mut damping, mut growth) = (options.damping, 2.0);
    let (mut evaluations, mut linearisations) = (1, 0);
    let mut before: Option<P::Slopes> = None;
    loop {
        let slopes = match (problem.linearise(&x, &point), before) {
            (Ok(slopes), _) => slopes,
            // What time cuts off is no reason to lose the best point.
            (Err(_), Some(slopes)) if problem.stop() => {
                let status = Status::Unfinished;
                return Ok(Solution { x, point, slopes, status, evaluations, linearisations });
            }
            (Err(error), _) => return Err(error),
        };
        let information = problem.information(&slopes);
        linearisations += 1;
        for k in 0..x.len() {
            scale[k] = scale[k].max(information[(k, k)].max(0.0).sqrt());
        }
        let linearised_at = x.clone();
        let mut chords = 0;
        let end = loop {
            let gradient = problem.gradient(&x, &point, &slopes);
            let model =
                Model { x: &x, limits, information: &information, gradient: &gradient, scale: &scale };
            // At the point of the slopes they are exact.
            let is_near = chords == 0 || problem.is_near(&linearised_at, &x);
            if is_near && model.is_stationary(cost, options.gradient) {
                break Some(Status::Gradient);
            }
            if evaluations > 1 && problem.stop() {
                break Some(Status::Unfinished);
            }
            let next = model.step(damping);
            let length = (&next - &x).norm();
            let is_short = length <= options.step * (x.norm() + options.step);
            if is_short || damping > MOST_DAMPING {
                break is_near.then_some(Status::Step);
            }
            let predicted = model.predicted(&next);
            let enough = options.decrease.max(options.relative_decrease * cost);
            // A short step of a great damping is no convergence: the undamped model has to agree.
            let left = predicted.max(model.predicted(&model.step(UNDAMPED)));
            if chords == 0 && left < NEAR * cost && cost - left > options.rival {
                break Some(Status::Unfinished);
            }
            // What slopes of a point far away still promise is found with new ones.
            if !is_near && left <= enough {
                break None;
            }
            evaluations += 1;
            let mut next = next;
            let evaluated = |x: &DVector<f64>| problem.evaluate(x).ok().map(|p| (problem.cost(&p), p));
            let mut trial = evaluated(&next);
            if let Some((found, reached)) = &trial
                && options.curved
                && chords == 0
                && (cost - found) / predicted < BENT
                && !problem.stop()
                && let Some(bent) = model.bent(&next, &problem.gradient(&next, reached, &slopes), damping)
            {
                evaluations += 1;
                let other = evaluated(&bent);
                if other.as_ref().is_some_and(|(other, _)| other < found) {
                    (next, trial) = (bent, other);
                }
            }
            let ratio = trial.as_ref().map_or(-1.0, |(found, _)| (cost - found) / predicted);
            match trial {
                Some((found, reached)) if found < cost && ratio > ACCEPTED => {
                    let fall = cost - found;
                    let is_all = left - fall <= enough;
                    // Slopes that are not exact promise what no step gains.
                    let is_vain = is_near && predicted <= enough && ratio < GOOD;
                    let settled = fall <= enough && (is_all || is_vain);
                    damping = (damping * f64::max(0.1, 1.0 - (2.0 * ratio - 1.0).powi(3))).max(1e-12);
                    growth = 2.0;
                    (x, point, cost) = (next, reached, found);
                    chords += 1;
                    if settled {
                        break (chords == 1 || problem.is_near(&linearised_at, &x))
                            .then_some(Status::Decrease);
                    }
                    if chords >= options.chords || ratio < GOOD {
                        break None;
                    }
                }
                // Slopes of a point before may be the reason.
                _ if !is_near => break None,
                _ if predicted <= enough => break Some(Status::Decrease),
                _ => {
                    let longest = SHORTER * model.length(&next);
                    loop {
                        damping *= growth;
                        growth *= 2.0;
                        if damping > MOST_DAMPING || model.length(&model.step(damping)) <= longest {
                            break;
                        }
                    }
                }
            }
        };
        let end = end.or((linearisations >= options.linearisations).then_some(Status::Unfinished));
        if let Some(status) = end {
            return Ok(Solution { x, point, slopes, status, evaluations, linearisations });
        }
        before = Some(slopes);
    }
}

/// The linear model about a point.
struct Model<'a> {
    x: &'a DVector<f64>,
    limits: &'a [(f64, f64)],
    information: &'a DMatrix<f64>,
    gradient: &'a DVector<f64>,
    scale: &'a DVector<f64>,
}

impl Model<'_> {
    /// Whether a variable is at a limit that the descent direction of F points beyond.
    fn is_held(&self, k: usize) -> bool {
        let (least, most) = self.limits[k];
        (self.x[k] <= least && self.gradient[k] >= 0.0) || (self.x[k] >= most && self.gradient[k] <= 0.0)
    }

    fn is_stationary(&self, cost: f64, tolerance: f64) -> bool {
        (0..self.x.len()).all(|k| {
            self.is_held(k) || self.gradient[k].abs() <= tolerance * self.scale[k] * cost.max(0.0).sqrt()
        })
    }

    /// The end of the step of (3), with the J^T r of the end of the step of (2), `straight`; `None` where the curvature changes it by more than
    /// [`MOST_BENT`], which is no curvature of a second derivative alone.
    fn bent(&self, straight: &DVector<f64>, there: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
        let gradient = there - self.information * (straight - self.x);
        let bent = Model { gradient: &gradient, ..*self }.step(damping);
        (self.beyond(&bent, straight) <= MOST_BENT * self.length(straight)).then_some(bent)
    }

    /// Length of the step to `next` in units of D.
    fn length(&self, next: &DVector<f64>) -> f64 {
        self.beyond(next, self.x)
    }

    /// Length of the way from `from` to `next` in units of D.
    fn beyond(&self, next: &DVector<f64>, from: &DVector<f64>) -> f64 {
        (0..next.len()).map(|k| self.own(k) * (next[k] - from[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// Element of D^2; a column of zeros has no scale of its own.
    fn own(&self, k: usize) -> f64 {
        if self.scale[k] > 0.0 { self.scale[k] * self.scale[k] } else { 1.0 }
    }

    /// The decrease of F by (2) without damping.
    fn predicted(&self, next: &DVector<f64>) -> f64 {
        let step = next - self.x;
        -(2.0 * self.gradient.dot(&step) + step.dot(&(self.information * &step)))
    }

    /// The end of the step of (2). A variable that would leave its range goes to the limit, and the others are solved for again.
    fn step(&self, damping: f64) -> DVector<f64> {
        let n = self.x.len();
        let mut fixed: Vec<Option<f64>> = (0..n).map(|k| self.is_held(k).then_some(0.0)).collect();
        loop {
            let free: Vec<usize> = (0..n).filter(|k| fixed[*k].is_none()).collect();
            let entry = |i: usize, k: usize| {
                self.information[(i, k)] + if i == k { damping * self.own(i) } else { 0.0 }
            };
            let normal = DMatrix::from_fn(free.len(), free.len(), |a, b| entry(free[a], free[b]));
            let right = DVector::from_fn(free.len(), |a, _| {
                let moved = (0..n).filter_map(|k| Some(self.information[(free[a], k)] * fixed[k]?));
                -self.gradient[free[a]] - moved.sum::<f64>()
            });
            // Rounding can make a matrix of dependent columns indefinite: more damping, and no step at worst.
            let more = || &normal + 1e-9 * DMatrix::from_diagonal(&normal.diagonal());
            let factor = normal.clone().cholesky().or_else(|| more().cholesky());
            let solved = factor.map_or_else(|| DVector::zeros(free.len()), |f| f.solve(&right));
            let mut step = DVector::from_fn(n, |k, _| fixed[k].unwrap_or(0.0));
            let mut left = false;
            for (a, &k) in free.iter().enumerate() {
                let (least, most) = self.limits[k];
                step[k] = solved[a];
                let inside = (self.x[k] + solved[a]).clamp(least, most);
                if inside != self.x[k] + solved[a] {
                    fixed[k] = Some(inside - self.x[k]);
                    left = true;
                }
            }
            if !left {
                return DVector::from_fn(n, |k, _| {
                    (self.x[k] + step[k]).clamp(self.limits[k].0, self.limits[k].1)
                });
            }
        }
    }
}

#[cfg(test)]
mod tests;
