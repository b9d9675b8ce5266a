//! A solver of ordinary differential equations with error control and located events, for stiff and other systems.
//!
//! Method: the linearly implicit Euler method with 1, 2, 3, ... substeps, extrapolated to substeps of length zero (Hairer and
//! Wanner, Solving Ordinary Differential Equations II, section IV.9). Each column of the table adds an order. The Jacobian comes from
//! difference quotients and is kept for some steps: an old one costs efficiency and no order.
//!
//! A step is accepted at the first column that passes two tests, both with errors of the same order. The first compares the result with the
//! column before. The substeps evaluate the equations at the beginning of each substep only, so this test does not see a change
//! of the equations near the end of a long step. The second test therefore evaluates the derivatives at the end of the step and
//! compares them with the slope of the extrapolated solution there (the defect: Enright, Journal of Computational and Applied Mathematics
//! 125 (2000) 159-170). A sign change of an event indicator ends the step behind it: shorter steps from the same point locate it. The first step is that of Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, section II.4.

mod jacobian;

use jacobian::{Implicit, Jacobian};
use nalgebra::DVector;
use std::rc::Rc;

/// Columns of the table at most, and the first that may be accepted.
const COLUMNS: usize = 8;
const FIRST: usize = 2;
/// Steps for which a Jacobian is kept.
const JACOBIAN_STEPS: usize = 10;
/// States up to which there is a Jacobian, at most a full matrix of 32 MB. With more the method is explicit: the Jacobian is taken as zero.
const MOST_IMPLICIT: usize = 2000;

/// The right-hand side of a system of ordinary differential equations.
pub trait Equations {
    /// Why the derivatives cannot be computed.
    type Error;

    /// Writes the derivatives of the states `x` at the time `t` (s); `false` where they do not exist, so that a shorter step is tried.
    fn derivatives(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<bool, Self::Error>;

    /// Writes the event indicators there. After a step the last call is for its end.
    fn indicators(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<(), Self::Error>;
}

/// [`Equations`] whose error is kept aside ([`Kept`]), so that the solver is compiled once and not for each kind of equations.
type System<'a> = dyn Equations<Error = Stopped> + 'a;

/// The equations cannot be evaluated; [`Kept`] has the reason.
struct Stopped;

/// Equations and the error that ended their evaluation.
struct Kept<'a, E: Equations> {
    equations: &'a mut E,
    error: Option<E::Error>,
}

impl<E: Equations> Kept<'_, E> {
    fn keep<T>(&mut self, result: Result<T, E::Error>) -> Result<T, Stopped> {
        result.map_err(|error| {
            self.error = Some(error);
            Stopped
        })
    }
}

impl<E: Equations> Equations for Kept<'_, E> {
    type Error = Stopped;

    fn derivatives(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<bool, Stopped> {
        let result = self.equations.derivatives(t, x, out);
        self.keep(result)
    }

    fn indicators(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<(), Stopped> {
        let result = self.equations.indicators(t, x, out);
        self.keep(result)
    }
}

/// The solver: what it remembers from step to step.
#[derive(Debug)]
pub struct Solver {
    /// Relative tolerance of a step.
    tolerance: f64,
    /// The size of each state below which its error is absolute.
    sizes: Vec<f64>,
    /// Length of the next step (s); 0 before the first.
    next: f64,
    /// Jacobian, and the number of steps that have used it.
    jacobian: Option<(Rc<Jacobian>, usize)>,
    /// Event indicators at the end of the last step.
    indicators: Vec<f64>,
    evaluations: usize,
}

/// An attempted step.
struct Attempt {
    /// States at its end; empty where the derivatives do not exist on the way.
    x: Vec<f64>,
    /// Error over tolerance.
    error: f64,
    /// The length that the next step may have.
    next: f64,
}

impl Attempt {
    fn failed(h: f64) -> Attempt {
        Attempt { x: Vec::new(), error: f64::INFINITY, next: 0.25 * h }
    }
}

/// An accepted step.
#[derive(Debug)]
pub struct Taken {
    /// Time at its end (s).
    pub end: f64,
    /// States at its end.
    pub x: Vec<f64>,
    /// Whether an event indicator changes its sign at its end.
    pub event: bool,
}

impl Solver {
    /// A solver, before [`Solver::restart`]. The error of a step is at most `tolerance` times the sum of a state and its size.
    pub fn new(tolerance: f64) -> Solver {
        Solver {
            tolerance,
            sizes: Vec::new(),
            next: 0.0,
            jacobian: None,
            indicators: Vec::new(),
            evaluations: 0,
        }
    }

    /// Begins, or continues after an event, which may have changed the equations and the sizes; `indicators` are those at the present point.
    pub fn restart(&mut self, sizes: Vec<f64>, indicators: Vec<f64>) {
        (self.sizes, self.indicators, self.jacobian) = (sizes, indicators, None);
    }

    /// Number of evaluations of the equations so far.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// One accepted step from `t` and `x`, at most to `target`. `None` if no step meets the tolerance, or if the evaluations
    /// reach `most_evaluations`.
    pub fn step<E: Equations>(
        &mut self,
        equations: &mut E,
        (t, x): (f64, &[f64]),
        target: f64,
        most_evaluations: usize,
    ) -> Result<Option<Taken>, E::Error> {
        let mut kept = Kept { equations, error: None };
        match (self.accepted(&mut kept, (t, x), target, most_evaluations), kept.error) {
            (Err(Stopped), Some(error)) => Err(error),
            (taken, _) => Ok(taken.unwrap_or(None)),
        }
    }

    fn accepted(
        &mut self,
        equations: &mut System,
        (t, x): (f64, &[f64]),
        target: f64,
        most_evaluations: usize,
    ) -> Result<Option<Taken>, Stopped> {
        let whole = target - t;
        if self.next == 0.0 {
            self.next = if x.is_empty() { whole } else { self.first_length(equations, (t, x), whole)? };
        }
        let mut h = self.next.min(whole);
        loop {
            let is_tiny = t + h <= t + 1e-15 * t.abs() || h < 1e-14 * whole;
            if is_tiny || self.evaluations >= most_evaluations {
                return Ok(None);
            }
            // Two equal steps rather than a long and a short one.
            if h < whole && 2.0 * h > whole {
                h = 0.5 * whole;
            }
            let attempt = self.attempt(equations, (t, x), h)?;
            if attempt.error <= 1.0 {
                self.next = attempt.next;
                if let Some((_, age)) = &mut self.jacobian {
                    *age += 1;
                }
                let end = if h == whole { target } else { t + h };
                let taken = Taken { end, x: attempt.x, event: false };
                return self.up_to_event(equations, (t, x), h, taken).map(Some);
            }
            h = attempt.next.min(0.7 * h);
            // An old Jacobian may be the reason.
            self.jacobian.take_if(|(_, age)| *age > 0);
        }
    }

    /// The step, shortened to the first sign change of an event indicator.
    fn up_to_event(
        &mut self,
        equations: &mut System,
        (t, x): (f64, &[f64]),
        h: f64,
        mut taken: Taken,
    ) -> Result<Taken, Stopped> {
        let old = self.indicators.clone();
        let changed = |z: &[f64]| z.iter().zip(&old).position(|(a, b)| (*a > 0.0) != (*b > 0.0));
        let mut z = old.clone();
        equations.indicators(taken.end, &taken.x, &mut z)?;
        if let Some(mut which) = changed(&z) {
            taken.event = true;
            self.next = self.next.min(h);
            let (mut low, mut high) = ((0.0, old[which]), (h, z[which]));
            let mut trial_z = z.clone();
            for round in 0..200 {
                let width = high.0 - low.0;
                if width <= 1e-11 * h + 4.0 * f64::EPSILON * taken.end.abs() {
                    break;
                }
                // The secant, kept inside; every third time the middle.
                let fraction = (low.1 / (low.1 - high.1)).clamp(0.02, 0.98);
                let fraction = if round % 3 == 2 || !fraction.is_finite() { 0.5 } else { fraction };
                let length = low.0 + fraction * width;
                let (end, trial) = (t + length, self.attempt(equations, (t, x), length)?.x);
                if trial.len() < x.len() {
                    break;
                }
                equations.indicators(end, &trial, &mut trial_z)?;
                match changed(&trial_z) {
                    Some(index) => {
                        if index != which {
                            (low.1, which) = (old[index], index);
                        }
                        high = (length, trial_z[index]);
                        (taken.end, taken.x) = (end, trial);
                        z.copy_from_slice(&trial_z);
                    }
                    None => low = (length, trial_z[which]),
                }
            }
            // The equations go to the point behind the crossing.
            equations.indicators(taken.end, &taken.x, &mut trial_z)?;
        }
        self.indicators = z;
        Ok(taken)
    }

    /// Length of the first step: one that changes the states by little, and in which a method of second order is accurate.
    fn first_length(
        &mut self,
        equations: &mut System,
        (t, x): (f64, &[f64]),
        whole: f64,
    ) -> Result<f64, Stopped> {
        let tiny = 1e-6 * whole;
        let state = DVector::from_column_slice(x);
        let Some(rates) = self.rates(equations, t, x)? else { return Ok(tiny) };
        let (size, rate) = (self.error(x, &state, &state), self.error(x, &state, &rates));
        let short = if size < 1e-5 || rate < 1e-5 { tiny } else { (0.01 * size / rate).min(whole) };
        let moved = &state + &rates * short;
        let Some(later) = self.rates(equations, t + short, moved.as_slice())? else { return Ok(tiny) };
        let largest = rate.max(self.error(x, &state, &(later - rates)) / short);
        let long = (0.01 / largest).powf(1.0 / (FIRST + 1) as f64);
        Ok((100.0 * short).min(long).min(whole))
    }

    /// A step of length `h` from `t` and `x`.
    fn attempt(&mut self, equations: &mut System, (t, x): (f64, &[f64]), h: f64) -> Result<Attempt, Stopped> {
        if x.is_empty() {
            return Ok(Attempt { x: Vec::new(), error: 0.0, next: f64::INFINITY });
        }
        if x.len() <= MOST_IMPLICIT && self.jacobian.as_ref().is_none_or(|(_, age)| *age >= JACOBIAN_STEPS) {
            self.jacobian = self.differences(equations, t, x)?.map(|jacobian| (Rc::new(jacobian), 0));
            if self.jacobian.is_none() {
                return Ok(Attempt::failed(h));
            }
        }
        let mut table: Vec<Row> = Vec::new();
        let mut best: Option<(f64, f64)> = None;
        let mut work = 0.0;
        let mut last = Attempt::failed(h);
        let whole = self.matrix(h);
        for column in 0..COLUMNS {
            let parts = column + 1;
            let part = (parts > 1).then(|| self.matrix(h / parts as f64));
            let matrix = part.as_ref().unwrap_or(&whole);
            let Some(first) = self.substeps(equations, (t, x), h, parts, matrix.as_ref())? else {
                return Ok(Attempt::failed(h));
            };
            work += (parts + 1) as f64;
            table.push(first.extrapolated(table.last(), parts));
            let [.., old, new] = &table[column].states[..] else { continue };
            let mut error = self.error(x, new, &(new - old));
            if column >= FIRST && error <= 1.0 {
                let Some(rates) = self.rates(equations, t + h, new.as_slice())? else {
                    return Ok(Attempt::failed(h));
                };
                let defect = (&table[column].slopes[column] - rates) * h;
                // (I - h J)^-1 damps the error that a change of the increments causes in stiff states.
                let defect = solved(whole.as_ref(), defect);
                error = error.max(defect.map_or(f64::INFINITY, |defect| self.error(x, new, &defect)));
            }
            let factor = (0.8 * error.max(1e-10).powf(-1.0 / (column + 1) as f64)).clamp(0.1, 5.0);
            // The length with the least work for a unit of time.
            if best.is_none_or(|(per_work, _)| factor * h / work > per_work) {
                best = Some((factor * h / work, factor * h));
            }
            let accepted = column >= FIRST && error <= 1.0;
            let next = best.filter(|_| accepted).map_or(factor * h, |(_, length)| length);
            last = Attempt { x: new.as_slice().to_vec(), error, next };
            if accepted {
                break;
            }
        }
        Ok(last)
    }

    /// The largest error of a state over its tolerance.
    fn error(&self, x: &[f64], new: &DVector<f64>, error: &DVector<f64>) -> f64 {
        (0..x.len()).fold(0.0_f64, |worst, i| {
            let size = x[i].abs().max(new[i].abs()) + self.sizes[i];
            let error = error[i].abs() / (self.tolerance * size);
            if error.is_nan() { f64::INFINITY } else { worst.max(error) }
        })
    }

    /// I - h J; `None` without Jacobian.
    fn matrix(&self, h: f64) -> Option<Implicit> {
        self.jacobian.as_ref().map(|(jacobian, _)| Implicit::new(jacobian, h))
    }

    /// The linearly implicit Euler method in equal parts.
    fn substeps(
        &mut self,
        equations: &mut System,
        (t, x): (f64, &[f64]),
        h: f64,
        parts: usize,
        matrix: Option<&Implicit>,
    ) -> Result<Option<Row>, Stopped> {
        let step = h / parts as f64;
        let mut state = DVector::from_column_slice(x);
        let mut slope = DVector::zeros(x.len());
        for part in 1..=parts {
            let at = if part == parts { t + h } else { t + part as f64 * step };
            let Some(rates) = self.rates(equations, at, state.as_slice())? else { return Ok(None) };
            let Some(own) = solved(matrix, rates) else { return Ok(None) };
            slope = own;
            state += &slope * step;
        }
        let is_finite = state.iter().all(|x| x.is_finite());
        Ok(is_finite.then(|| Row { states: vec![state], slopes: vec![slope] }))
    }

    /// The Jacobian by one-sided difference quotients.
    fn differences(
        &mut self,
        equations: &mut System,
        t: f64,
        x: &[f64],
    ) -> Result<Option<Jacobian>, Stopped> {
        let Some(middle) = self.rates(equations, t, x)? else { return Ok(None) };
        let mut columns = Vec::with_capacity(x.len());
        let mut moved = x.to_vec();
        for column in 0..x.len() {
            let size = x[column].abs().max(1e-3 * self.sizes[column]);
            let by = f64::EPSILON.sqrt() * size * if x[column] < 0.0 { -1.0 } else { 1.0 };
            moved[column] = x[column] + by;
            let by = moved[column] - x[column];
            let Some(rates) = self.rates(equations, t, &moved)? else { return Ok(None) };
            columns.push((rates - &middle) / by);
            moved[column] = x[column];
        }
        Ok(Some(Jacobian::new(columns)))
    }

    /// The derivatives; `None` where they do not exist or are not finite.
    fn rates(&mut self, equations: &mut System, t: f64, x: &[f64]) -> Result<Option<DVector<f64>>, Stopped> {
        self.evaluations += 1;
        let mut out = DVector::zeros(x.len());
        let exists = equations.derivatives(t, x, out.as_mut_slice())?;
        Ok((exists && out.iter().all(|d| d.is_finite())).then_some(out))
    }
}

/// The rates times the inverse of I - h J; unchanged without Jacobian.
fn solved(matrix: Option<&Implicit>, rates: DVector<f64>) -> Option<DVector<f64>> {
    match matrix {
        Some(matrix) => matrix.solve(rates),
        None => Some(rates),
    }
}

/// A row of the table: states at the end of the step and their slopes there, each extrapolated once more than the one before.
struct Row {
    states: Vec<DVector<f64>>,
    slopes: Vec<DVector<f64>>,
}

impl Row {
    /// The row with its extrapolations (Aitken and Neville); `before` is the row with one part less.
    fn extrapolated(mut self, before: Option<&Row>, parts: usize) -> Row {
        let Some(before) = before else { return self };
        for k in 0..before.states.len() {
            let ratio = parts as f64 / (parts - k - 1) as f64 - 1.0;
            let better = |finer: &DVector<f64>, coarser: &DVector<f64>| finer + (finer - coarser) / ratio;
            self.states.push(better(&self.states[k], &before.states[k]));
            self.slopes.push(better(&self.slopes[k], &before.slopes[k]));
        }
        self
    }
}
