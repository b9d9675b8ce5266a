//! Model Exchange: states, derivatives, event indicators and events.

use super::{Instance, Mode, Standard};
use crate::refusal::{Outcome, Refused};
use physics::model::Fault;

/// Modes in which derivatives, states and indicators may be read.
const READABLE: &[Mode] =
    &[Mode::Initialization, Mode::Event, Mode::Continuous, Mode::Terminated, Mode::Error];

fn same_number(what: &str, asked: usize, there: usize) -> Outcome {
    if asked == there {
        return Ok(());
    }
    Err(Refused::error(format!("the number of {what} is {there}, not {asked}.")))
}

fn discard(fault: Fault) -> Refused {
    Refused::discard(fault.0)
}

impl Instance {
    /// Number of continuous states.
    pub fn number_of_states(&self) -> usize {
        let declaration = self.model.declaration();
        declaration.states.iter().filter(|[state, _]| self.holds(&declaration.entries[*state])).count()
    }

    /// Number of event indicators.
    pub fn number_of_indicators(&self) -> usize {
        self.model.declaration().indicators.len()
    }

    /// Event, continuous-time or step mode -> event mode.
    pub fn enter_event(&mut self) -> Outcome {
        self.require_events()?;
        // FMI 2.0 allows the call in event mode, FMI 3.0 does not.
        let again = if self.standard == Standard::Two { Mode::Event } else { Mode::Step };
        self.require(&[again, Mode::Continuous, Mode::Step])?;
        self.go(Mode::Event);
        Ok(())
    }

    /// Event -> continuous-time mode.
    pub fn enter_continuous(&mut self) -> Outcome {
        self.require(&[Mode::Event])?;
        self.go(Mode::Continuous);
        Ok(())
    }

    /// Completes an integrator step; true if the run is over. It never requests event mode, because all events are time events or
    /// state events with indicators.
    pub fn accept_step(&mut self) -> Outcome<bool> {
        self.require(&[Mode::Continuous])?;
        self.model.accept_step();
        Ok(self.is_over())
    }

    /// Sets the time, s.
    pub fn set_time(&mut self, time: f64) -> Outcome {
        // FMI 2.0 of 2014 allows the call in event mode, and importers use it; FMI 3.0 does not.
        let event = if self.standard == Standard::Two { Mode::Event } else { Mode::Continuous };
        self.require(&[event, Mode::Continuous])?;
        if !time.is_finite() {
            return Err(Refused::discard(format!("the time {time} s is not finite.")));
        }
        self.model.write_time(time);
        Ok(())
    }

    /// Sets the continuous states.
    pub fn set_states(&mut self, states: &[f64]) -> Outcome {
        self.require(&[Mode::Continuous])?;
        same_number("continuous states", states.len(), self.number_of_states())?;
        if let Some(k) = states.iter().position(|x| !x.is_finite()) {
            let declaration = self.model.declaration();
            let name = &declaration.entries[declaration.states[k][0]].name;
            return Err(Refused::discard(format!("{name} = {} is not a finite number.", states[k])));
        }
        self.model.write_states(states);
        Ok(())
    }

    /// The first `n` continuous states.
    pub fn states(&mut self, n: usize) -> Outcome<&[f64]> {
        self.require(READABLE)?;
        self.settle()?;
        same_number("continuous states", n, self.number_of_states())?;
        self.model.read_states(&mut self.buffer[..n]);
        Ok(&self.buffer[..n])
    }

    /// Derivatives of the continuous states.
    pub fn derivatives(&mut self, n: usize) -> Outcome<&[f64]> {
        self.require(READABLE)?;
        self.settle()?;
        same_number("continuous states", n, self.number_of_states())?;
        let out = &mut self.buffer[..n];
        self.model.derivatives(out).map_err(discard)?;
        let Some(k) = out.iter().position(|rate| !rate.is_finite()) else { return Ok(out) };
        let declaration = self.model.declaration();
        let name = &declaration.entries[declaration.states[k][1]].name;
        Err(Refused::discard(format!("{name} is not finite at the states that were set.")))
    }

    /// The event indicators.
    pub fn indicators(&mut self, n: usize) -> Outcome<&[f64]> {
        self.require(READABLE)?;
        self.settle()?;
        same_number("event indicators", n, self.number_of_indicators())?;
        let declaration = self.model.declaration();
        for (indicator, &k) in self.buffer.iter_mut().zip(&declaration.indicators) {
            *indicator = self.model.get(declaration.entries[k].slot);
        }
        Ok(&self.buffer[..n])
    }

    /// The nominal values of the continuous states.
    pub fn nominals(&mut self, n: usize) -> Outcome<&[f64]> {
        // FMI 2.0 allows the call before initialization, FMI 3.0 does not.
        match self.standard {
            Standard::Two => self.require_living()?,
            Standard::Three => self.require(READABLE)?,
        }
        same_number("continuous states", n, self.number_of_states())?;
        let declaration = self.model.declaration();
        for (nominal, [state, _]) in self.buffer.iter_mut().zip(&declaration.states) {
            *nominal = declaration.entries[*state].row.nominal;
        }
        Ok(&self.buffer[..n])
    }
}
