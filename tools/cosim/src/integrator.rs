//! Integration of a Model Exchange FMU with error control, for stiff and other models, with located events.
//!
//! Method: the linearly implicit Euler method with 1, 2, 3, ... substeps, extrapolated to substeps of length zero (Hairer and
//! Wanner, Solving Ordinary Differential Equations II, section IV.9). Each column of the table adds an order. The step is
//! accepted at the first column whose difference from the one before is within the tolerance. The Jacobian comes from difference quotients
//! and is kept for some steps: an old one costs efficiency and no order.
//!
//! A state event is located by shorter steps from the same point: their length is bisected, guided by the indicator.
use crate::{Error, Instance, ModelDescription, Status, Step, number};
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Columns of the table at most, and the first that may be accepted.
const COLUMNS: usize = 8;
const FIRST: usize = 2;
/// Steps for which a Jacobian is kept.
const JACOBIAN_STEPS: usize = 10;
/// Event iterations, and events at one time, at most.
const MOST_ITERATIONS: usize = 1000;

/// What the integrator needs of inputs over time.
pub(crate) trait Inputs {
    /// Sets the continuous inputs for a point in the stretch that begins at `from`.
    fn set_continuous(&mut self, instance: &mut Instance, from: f64, t: f64) -> Result<(), Error>;
    /// Sets all inputs, in event mode.
    fn set_all(&mut self, instance: &mut Instance, t: f64) -> Result<(), Error>;
    /// The next time after `t` at which inputs have a kink or a discontinuity.
    fn next_break(&self, t: f64) -> Option<f64>;
    /// Whether an input is discontinuous at `t`.
    fn jumps(&self, t: f64) -> bool;
}

/// The continuous states of an instance in continuous-time mode.
pub(crate) struct Integrator {
    t: f64,
    x: Vec<f64>,
    nominals: Vec<f64>,
    indicators: Vec<f64>,
    tolerance: f64,
    h: f64,
    next_event: Option<f64>,
    reports_steps: bool,
    jacobian: Option<(DMatrix<f64>, usize)>,
}

/// The result of an attempted step.
struct Attempt {
    x: Vec<f64>,
    /// Error over tolerance, in the last column.
    error: f64,
    /// The length that the next step may have.
    next: f64,
}

impl Integrator {
    /// Handles the events of initialization and enters continuous-time mode; `None` if the FMU requests the end.
    pub(crate) fn start(
        instance: &mut Instance,
        description: &ModelDescription,
        t: f64,
        tolerance: f64,
        reports_steps: bool,
    ) -> Result<Option<Self>, Error> {
        let (states, indicators) = instance.numbers(description)?;
        let mut new = Self {
            t,
            x: vec![0.0; states],
            nominals: vec![1.0; states],
            indicators: vec![0.0; indicators],
            tolerance,
            h: 0.0,
            next_event: None,
            reports_steps,
            jacobian: None,
        };
        let goes_on = new.settle(instance)?;
        Ok(goes_on.then_some(new))
    }

    /// The event iteration, in event mode; then continuous-time mode. `false` if the FMU requests the end.
    fn settle(&mut self, instance: &mut Instance) -> Result<bool, Error> {
        for _ in 0..MOST_ITERATIONS {
            let update = instance.update_discrete(self.t)?;
            self.next_event = update.next.filter(|next| *next >= self.t);
            if update.terminate {
                return Ok(false);
            }
            if !update.again {
                instance.enter_continuous(self.t)?;
                instance.read_states(&mut self.x, &mut self.nominals)?;
                for nominal in &mut self.nominals {
                    *nominal = if *nominal > 0.0 && nominal.is_finite() { *nominal } else { 1.0 };
                }
                instance.read_indicators(self.t, &mut self.indicators)?;
                self.jacobian = None;
                return Ok(true);
            }
        }
        let reason = format!("does not end its event iteration at t = {} s", number(self.t));
        Err(Error::unsupported(instance.name(), reason))
    }

    /// Integrates to `end` (s) and handles the events on the way; the instance is at `end` afterwards.
    pub(crate) fn advance(
        &mut self,
        instance: &mut Instance,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Step, Error> {
        let tiny = 1e-13 * end.abs().max(end - self.t);
        let mut events_here = (self.t, 0);
        while self.t < end - tiny {
            let near = |t: &f64| *t > self.t + tiny;
            let stops = [self.next_event, inputs.next_break(self.t + tiny).filter(near)];
            let target = stops.into_iter().flatten().fold(end, f64::min).max(self.t);
            let mut event = false;
            if target > self.t + tiny {
                // A remainder that rounding leaves is no step of its own.
                let target = if end - target <= tiny { end } else { target };
                match self.step_towards(instance, target, inputs)? {
                    Some(asked) => event = asked,
                    None => return Ok(Step::Terminated),
                }
            }
            event |= self.next_event.is_some_and(|next| self.t >= next - tiny) || inputs.jumps(self.t);
            if event {
                events_here = if self.t > events_here.0 { (self.t, 1) } else { (self.t, events_here.1 + 1) };
                if events_here.1 > MOST_ITERATIONS {
                    let reason = format!("has events without end at t = {} s", number(self.t));
                    return Err(Error::unsupported(instance.name(), reason));
                }
                instance.enter_events(self.t)?;
                inputs.set_all(instance, self.t)?;
                if !self.settle(instance)? {
                    return Ok(Step::Terminated);
                }
            }
        }
        Ok(Step::Done)
    }

    /// One accepted step, at most to `target`; whether there is an event at its end. `None` if the FMU requests the end.
    fn step_towards(
        &mut self,
        instance: &mut Instance,
        target: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<bool>, Error> {
        let from = self.t;
        let whole = target - from;
        let mut h = if self.x.is_empty() || self.h >= whole { whole } else { self.h };
        if self.h == 0.0 && !self.x.is_empty() {
            h = 1e-2 * whole;
        }
        let accepted = loop {
            // Two equal steps rather than a long and a short one.
            if h < whole && 2.0 * h > whole {
                h = 0.5 * whole;
            }
            let attempt = self.attempt(instance, h, inputs)?;
            if attempt.error <= 1.0 {
                break attempt;
            }
            h = attempt.next.min(0.7 * h);
            // An old Jacobian may be the reason.
            self.jacobian = None;
            if from + h <= from + 1e-15 * from.abs() || h < 1e-14 * whole {
                let reason = format!(
                    "cannot be integrated past t = {} s: no step meets the tolerance {}",
                    number(from),
                    number(self.tolerance)
                );
                return Err(Error::unsupported(instance.name(), reason));
            }
        };
        let end = if h == whole { target } else { from + h };
        let (mut end, mut x) = (end, accepted.x);
        let mut z = self.indicators_at(instance, from, end, &x, inputs)?;
        let changed = |z: &[f64], old: &[f64]| z.iter().zip(old).position(|(a, b)| (*a > 0.0) != (*b > 0.0));
        let mut event = false;
        if let Some(first) = changed(&z, &self.indicators) {
            event = true;
            let mut low = (0.0, self.indicators[first]);
            let mut high = (h, z[first]);
            let mut which = first;
            for round in 0..200 {
                let width = high.0 - low.0;
                if width <= 1e-11 * h + 4.0 * f64::EPSILON * end.abs() {
                    break;
                }
                // The secant, kept inside; every third time the middle.
                let share = (low.1 / (low.1 - high.1)).clamp(0.02, 0.98);
                let share = if round % 3 == 2 || !share.is_finite() { 0.5 } else { share };
                let length = low.0 + share * width;
                let trial = self.attempt(instance, length, inputs)?;
                let at = from + length;
                let trial_z = self.indicators_at(instance, from, at, &trial.x, inputs)?;
                match changed(&trial_z, &self.indicators) {
                    Some(index) => {
                        if index != which {
                            low.1 = self.indicators[index];
                            which = index;
                        }
                        high = (length, trial_z[index]);
                        (end, x, z) = (at, trial.x, trial_z);
                    }
                    None => low = (length, trial_z[which]),
                }
            }
            // The instance goes to the point behind the crossing.
            self.indicators_at(instance, from, end, &x, inputs)?;
        }
        (self.t, self.x, self.indicators) = (end, x, z);
        self.h = if event { accepted.next.min(h) } else { accepted.next };
        if let Some((_, age)) = &mut self.jacobian {
            *age += 1;
        }
        if self.reports_steps {
            let (asked, ends) = instance.completed_step(self.t)?;
            if ends {
                return Ok(None);
            }
            event |= asked;
        }
        Ok(Some(event))
    }

    /// Brings the instance to a point and reads its indicators.
    fn indicators_at(
        &self,
        instance: &mut Instance,
        from: f64,
        t: f64,
        x: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Vec<f64>, Error> {
        let mut z = vec![0.0; self.indicators.len()];
        instance.set_point(t, x)?;
        inputs.set_continuous(instance, from, t)?;
        instance.read_indicators(t, &mut z)?;
        Ok(z)
    }

    /// Derivatives at a point; `None` where the FMU discards the point or they are not finite.
    fn rates(
        &self,
        instance: &mut Instance,
        t: f64,
        x: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Option<Vec<f64>>, Error> {
        let mut out = vec![0.0; x.len()];
        let mut read = || -> Result<(), Error> {
            instance.set_point(t, x)?;
            inputs.set_continuous(instance, self.t, t)?;
            instance.rates(t, &mut out)
        };
        match read() {
            Ok(()) => Ok(out.iter().all(|d| d.is_finite()).then_some(out)),
            Err(Error::Call { status: Status::Discard, .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A step of length `h` from the present point.
    fn attempt(
        &mut self,
        instance: &mut Instance,
        h: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Attempt, Error> {
        let n = self.x.len();
        let failed = |factor: f64| Attempt { x: Vec::new(), error: f64::INFINITY, next: factor * h };
        if n == 0 {
            return Ok(Attempt { x: Vec::new(), error: 0.0, next: f64::INFINITY });
        }
        if self.jacobian.as_ref().is_none_or(|(_, age)| *age >= JACOBIAN_STEPS) {
            match self.differences(instance, inputs)? {
                Some(matrix) => self.jacobian = Some((matrix, 0)),
                None => return Ok(failed(0.25)),
            }
        }
        let Some((jacobian, _)) = self.jacobian.clone() else { return Ok(failed(0.25)) };
        let mut table: Vec<Vec<DVector<f64>>> = Vec::new();
        let mut best: Option<(f64, f64)> = None;
        let mut work = 0.0;
        let mut last = (f64::INFINITY, 0.5 * h);
        for column in 0..COLUMNS {
            let parts = column + 1;
            let Some(row) = self.substeps(instance, h, parts, &jacobian, inputs)? else {
                return Ok(failed(0.25));
            };
            work += (parts + 1) as f64;
            let mut entries = vec![row];
            for k in 1..=column {
                let ratio = parts as f64 / (parts - k) as f64 - 1.0;
                let finer: &DVector<f64> = &entries[k - 1];
                let next = finer + (finer - &table[column - 1][k - 1]) / ratio;
                entries.push(next);
            }
            table.push(entries);
            if column < 1 {
                continue;
            }
            let (new, old) = (&table[column][column], &table[column][column - 1]);
            let error = (0..n).fold(0.0_f64, |worst, i| {
                let size = self.x[i].abs().max(new[i].abs()) + self.nominals[i];
                let error = (new[i] - old[i]).abs() / (self.tolerance * size);
                if error.is_nan() { f64::INFINITY } else { worst.max(error) }
            });
            let factor = (0.8 * error.max(1e-10).powf(-1.0 / (column + 1) as f64)).clamp(0.1, 5.0);
            last = (error, factor * h);
            // The length with the least work for a unit of time.
            if best.is_none_or(|(per_work, _)| factor * h / work > per_work) {
                best = Some((factor * h / work, factor * h));
            }
            if column >= FIRST && error <= 1.0 {
                let next = best.map_or(h, |(_, length)| length);
                return Ok(Attempt { x: new.as_slice().to_vec(), error, next });
            }
        }
        let x = table.last().map_or_else(Vec::new, |row| row[COLUMNS - 1].as_slice().to_vec());
        Ok(Attempt { x, error: last.0, next: last.1 })
    }

    /// The linearly implicit Euler method in equal parts.
    fn substeps(
        &self,
        instance: &mut Instance,
        h: f64,
        parts: usize,
        jacobian: &DMatrix<f64>,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<DVector<f64>>, Error> {
        let (n, step) = (self.x.len(), h / parts as f64);
        let solver: LU<f64, Dyn, Dyn> = (DMatrix::identity(n, n) - jacobian * step).lu();
        let mut x = DVector::from_column_slice(&self.x);
        for part in 1..=parts {
            let t = if part == parts { self.t + h } else { self.t + part as f64 * step };
            let Some(rates) = self.rates(instance, t, x.as_slice(), inputs)? else { return Ok(None) };
            let Some(change) = solver.solve(&(DVector::from_vec(rates) * step)) else { return Ok(None) };
            x += change;
        }
        Ok(x.iter().all(|x| x.is_finite()).then_some(x))
    }

    /// The Jacobian by one-sided difference quotients.
    fn differences(
        &self,
        instance: &mut Instance,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<DMatrix<f64>>, Error> {
        let n = self.x.len();
        let Some(middle) = self.rates(instance, self.t, &self.x, inputs)? else { return Ok(None) };
        let mut matrix = DMatrix::zeros(n, n);
        let mut x = self.x.clone();
        for column in 0..n {
            let size = self.x[column].abs().max(1e-3 * self.nominals[column]);
            let by = f64::EPSILON.sqrt() * size * if self.x[column] < 0.0 { -1.0 } else { 1.0 };
            x[column] = self.x[column] + by;
            let by = x[column] - self.x[column];
            let Some(moved) = self.rates(instance, self.t, &x, inputs)? else { return Ok(None) };
            for row in 0..n {
                matrix[(row, column)] = (moved[row] - middle[row]) / by;
            }
            x[column] = self.x[column];
        }
        Ok(Some(matrix))
    }
}
