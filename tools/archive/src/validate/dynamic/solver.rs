//! Model Exchange: integration of the states by the method of Dormand and Prince with error control.

use super::report::Fault;
use super::session::Session;
use crate::validate::rules;

/// Stages: nodes, and the rows of the tableau.
const C: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Fifth order minus fourth order.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Evaluations that one integration may take.
const MOST_EVALUATIONS: usize = 200_000;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reached {
    End,
    /// An event came before, and has been handled if that was wanted.
    Event,
    /// Too many evaluations: stiff, or over a long time.
    Exhausted,
}

/// The continuous states of a session in continuous-time mode.
pub(super) struct Solver {
    pub(super) x: Vec<f64>,
    nominals: Vec<f64>,
    indicators: Vec<f64>,
    tolerance: f64,
    h: f64,
    evaluations: usize,
}

impl Solver {
    /// Reads states, nominals and indicators.
    pub(super) fn new(session: &mut Session, tolerance: f64) -> Result<Solver, Fault> {
        let facts = session.facts;
        let n = facts.state_count();
        let mut solver = Solver {
            x: vec![0.0; n],
            nominals: vec![1.0; n],
            indicators: vec![0.0; facts.indicators],
            tolerance,
            h: 0.0,
            evaluations: 0,
        };
        solver.reload(session)?;
        Ok(solver)
    }

    /// Reads what an event may have changed.
    fn reload(&mut self, session: &mut Session) -> Result<(), Fault> {
        if !self.x.is_empty() {
            session.call("GetContinuousStates", |raw| raw.get_states(&mut self.x))?;
            session.call("GetNominalsOfContinuousStates", |raw| raw.get_nominals(&mut self.nominals))?;
        }
        self.indicators = indicators(session, self.indicators.len())?;
        Ok(())
    }

    /// The derivatives at a time and at states, which become the session's.
    pub(super) fn rates(session: &mut Session, t: f64, x: &[f64]) -> Result<Vec<f64>, Fault> {
        session.now = t;
        session.call("SetTime", |raw| raw.set_time(t))?;
        let mut rates = vec![0.0; x.len()];
        if !x.is_empty() {
            session.call("SetContinuousStates", |raw| raw.set_states(x))?;
            let status = session.raw.get_derivatives(&mut rates);
            session.ok(session.facts.pick("GetDerivatives", "GetContinuousStateDerivatives"), status)?;
        }
        Ok(rates)
    }

    /// Integrates to `end`, s. At an event it stops, or handles it and continues.
    pub(super) fn advance(
        &mut self,
        session: &mut Session,
        end: f64,
        through_events: bool,
    ) -> Result<Reached, Fault> {
        self.evaluations = 0;
        let nothing = 1e-13 * (end - session.now).abs().max(end.abs());
        while session.now < end - nothing {
            let target = session.next.map_or(end, |t| t.min(end));
            let mut event = false;
            if target - session.now > nothing {
                match self.one_step(session, target)? {
                    Some(seen) => event = seen,
                    None => return Ok(Reached::Exhausted),
                }
            }
            if event || session.next.is_some_and(|t| session.now >= t - nothing) {
                if !through_events {
                    return Ok(Reached::Event);
                }
                self.handle_event(session)?;
            }
        }
        Ok(Reached::End)
    }

    pub(super) fn handle_event(&mut self, session: &mut Session) -> Result<(), Fault> {
        session.call("EnterEventMode", |raw| raw.enter_event_mode())?;
        session.iterate_events()?;
        session.call("EnterContinuousTimeMode", |raw| raw.enter_continuous_time_mode())?;
        self.reload(session)
    }

    /// One accepted step, at most to `target`; then whether there was an event. `None` after too many evaluations.
    pub(super) fn one_step(&mut self, session: &mut Session, target: f64) -> Result<Option<bool>, Fault> {
        let t = session.now;
        let mut h = if self.h > 0.0 { self.h.min(target - t) } else { 1e-3 * (target - t) };
        let first = Self::rates(session, t, &self.x)?;
        let new = loop {
            // A remainder too small to matter belongs to this step.
            if target - t - h < 1e-9 * h {
                h = target - t;
            }
            self.evaluations += C.len();
            if self.evaluations > MOST_EVALUATIONS || t + h <= t {
                return Ok(None);
            }
            let (new, error) = self.trial(session, t, h, &first)?;
            let factor = if error.is_finite() { (0.9 * error.powf(-0.2)).clamp(0.2, 5.0) } else { 0.2 };
            if error <= 1.0 {
                self.h = h * factor;
                break new;
            }
            h *= factor.min(0.9);
        };
        let end = if h == target - t { target } else { t + h };
        self.x = new;
        Self::rates(session, end, &self.x)?;
        let mut event = false;
        if session.interface.needs_completed_step {
            let (status, asked, _) = session.raw.completed_integrator_step();
            session.ok("CompletedIntegratorStep", status)?;
            event = asked;
        }
        let z = indicators(session, self.indicators.len())?;
        event |= z.iter().zip(&self.indicators).any(|(new, old)| (*new > 0.0) != (*old > 0.0));
        self.indicators = z;
        Ok(Some(event))
    }

    /// A step of size `h`, and its error relative to the tolerance.
    fn trial(&self, session: &mut Session, t: f64, h: f64, first: &[f64]) -> Result<(Vec<f64>, f64), Fault> {
        let mut slopes = vec![first.to_vec()];
        let mut at = self.x.clone();
        for stage in 1..C.len() {
            for (i, x) in at.iter_mut().enumerate() {
                let sum: f64 = slopes.iter().zip(A[stage]).map(|(k, a)| a * k[i]).sum();
                *x = self.x[i] + h * sum;
            }
            slopes.push(Self::rates(session, t + C[stage] * h, &at)?);
        }
        let error = (0..at.len()).map(|i| {
            let difference: f64 = slopes.iter().zip(E).map(|(k, e)| e * k[i]).sum::<f64>() * h;
            let scale = self.x[i].abs().max(at[i].abs()).max(1e-3 * self.nominals[i]);
            (difference / (self.tolerance * scale)).abs()
        });
        // `max` ignores NaN, so it is checked separately.
        let worst = error.fold(0.0, |a: f64, b| if b.is_nan() { f64::INFINITY } else { a.max(b) });
        Ok((at, worst.max(1e-10)))
    }
}

/// The event indicators at the session's time and states.
pub(super) fn indicators(session: &mut Session, count: usize) -> Result<Vec<f64>, Fault> {
    let mut z = vec![0.0; count];
    if count > 0 {
        session.call("GetEventIndicators", |raw| raw.get_indicators(&mut z))?;
        if let Some(i) = z.iter().position(|z| !z.is_finite()) {
            return Fault::new(
                &session.interface.place(),
                rules::indicator_not_finite(i + 1, count, z[i], session.now),
            );
        }
    }
    Ok(z)
}
