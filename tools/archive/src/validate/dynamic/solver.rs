//! Model Exchange: integration of the states of a session by the solver of `cosim`.

use cosim::ode::{self, Equations};

use super::report::Fault;
use super::session::Session;
use crate::validate::rules;

/// Evaluations that one integration may take.
const MOST_EVALUATIONS: usize = 200_000;
/// Size of a state below which its error is absolute, relative to its nominal value: models without nominal values have small states.
const SMALL: f64 = 1e-3;

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
    method: ode::Solver,
    /// Evaluations at which the present integration ends.
    most_evaluations: usize,
}

/// The equations of a session.
struct OfSession<'a, 'b>(&'a mut Session<'b>);

impl Equations for OfSession<'_, '_> {
    type Error = Fault;

    fn derivatives(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<bool, Fault> {
        out.copy_from_slice(&Solver::rates(self.0, t, x)?);
        Ok(true)
    }

    fn indicators(&mut self, t: f64, x: &[f64], out: &mut [f64]) -> Result<(), Fault> {
        Solver::rates(self.0, t, x)?;
        out.copy_from_slice(&indicators(self.0, out.len())?);
        Ok(())
    }
}

impl Solver {
    /// Reads states, nominals and indicators.
    pub(super) fn new(session: &mut Session, tolerance: f64) -> Result<Solver, Fault> {
        let x = vec![0.0; session.facts.state_count()];
        let mut solver =
            Solver { x, method: ode::Solver::new(tolerance), most_evaluations: MOST_EVALUATIONS };
        solver.reload(session)?;
        Ok(solver)
    }

    /// Reads what an event may have changed.
    fn reload(&mut self, session: &mut Session) -> Result<(), Fault> {
        let mut nominals = vec![1.0; self.x.len()];
        if !self.x.is_empty() {
            session.call("GetContinuousStates", |raw| raw.get_states(&mut self.x))?;
            session.call("GetNominalsOfContinuousStates", |raw| raw.get_nominals(&mut nominals))?;
        }
        for nominal in &mut nominals {
            *nominal = SMALL * if *nominal > 0.0 && nominal.is_finite() { *nominal } else { 1.0 };
        }
        let indicators = indicators(session, session.facts.indicators)?;
        self.method.restart(nominals, indicators);
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
        self.most_evaluations = self.method.evaluations() + MOST_EVALUATIONS;
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
        let from = (session.now, &self.x[..]);
        let taken = self.method.step(&mut OfSession(session), from, target, self.most_evaluations)?;
        let Some(taken) = taken else { return Ok(None) };
        self.x = taken.x;
        let mut event = taken.event;
        if session.interface.needs_completed_step {
            let (status, asked, _) = session.raw.completed_integrator_step();
            session.ok("CompletedIntegratorStep", status)?;
            event |= asked;
        }
        Ok(Some(event))
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
