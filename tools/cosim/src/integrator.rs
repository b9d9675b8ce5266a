//! Integration of a Model Exchange FMU with error control and located events (`ode.rs`), with inputs over time.
use crate::ode::{Equations, Solver};
use crate::{Error, Instance, ModelDescription, Status, Step, number};

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
    /// Number of event indicators.
    indicators: usize,
    solver: Solver,
    tolerance: f64,
    next_event: Option<f64>,
    reports_steps: bool,
}

/// The equations of an instance with inputs over time, in the stretch that begins at `from`.
struct Driven<'a> {
    instance: &'a mut Instance,
    inputs: &'a mut dyn Inputs,
    from: f64,
}

impl Driven<'_> {
    fn go_to(&mut self, t: f64, x: &[f64]) -> Result<(), Error> {
        self.instance.set_point(t, x)?;
        self.inputs.set_continuous(self.instance, self.from, t)
    }
}

impl Equations for Driven<'_> {
    type Error = Error;

    /// The derivatives do not exist where the FMU discards the point.
    fn derivatives(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<bool, Error> {
        match self.go_to(t, x).and_then(|()| self.instance.rates(t, out)) {
            Ok(()) => Ok(true),
            Err(Error::Call { status: Status::Discard, .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    fn indicators(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<(), Error> {
        self.go_to(t, x)?;
        self.instance.read_indicators(t, out)
    }
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
            indicators,
            solver: Solver::new(tolerance),
            tolerance,
            next_event: None,
            reports_steps,
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
                let mut nominals = vec![1.0; self.x.len()];
                instance.read_states(&mut self.x, &mut nominals)?;
                for nominal in &mut nominals {
                    *nominal = if *nominal > 0.0 && nominal.is_finite() { *nominal } else { 1.0 };
                }
                let mut indicators = vec![0.0; self.indicators];
                instance.read_indicators(self.t, &mut indicators)?;
                self.solver.restart(nominals, indicators);
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
        let mut driven = Driven { instance, inputs, from };
        let Some(taken) = self.solver.step(&mut driven, (from, &self.x), target, usize::MAX)? else {
            let reason = format!(
                "cannot be integrated past t = {} s: no step meets the tolerance {}",
                number(from),
                number(self.tolerance)
            );
            return Err(Error::unsupported(instance.name(), reason));
        };
        (self.t, self.x) = (taken.end, taken.x);
        let mut event = taken.event;
        if self.reports_steps {
            let (asked, ends) = instance.completed_step(self.t)?;
            if ends {
                return Ok(None);
            }
            event |= asked;
        }
        Ok(Some(event))
    }
}
