//! The calls of Model Exchange.
use super::Instance;
use crate::raw::{DiscreteUpdate, RawInstance, names};
use crate::{Error, FmiVersion, ModelDescription, Status};

impl Instance {
    /// The numbers of continuous states and of event indicators.
    pub(crate) fn numbers(&mut self, description: &ModelDescription) -> Result<(usize, usize), Error> {
        if description.fmi_version == FmiVersion::V2 {
            return Ok((description.state_count, description.indicator_count));
        }
        let mut numbers = (0, 0);
        self.call(names::number_of_states, |raw| match raw.numbers() {
            Ok(read) => {
                numbers = read;
                Status::Ok
            }
            Err(status) => status,
        })?;
        Ok(numbers)
    }

    /// Sets time (s) and continuous states.
    pub(crate) fn set_point(&mut self, t: f64, x: &[f64]) -> Result<(), Error> {
        self.call_at(names::set_time, Some(t), |raw| raw.set_time(t))?;
        if x.is_empty() {
            return Ok(());
        }
        self.call_at(names::set_states, Some(t), |raw| raw.set_states(x))
    }

    /// The derivatives of the states at a point.
    pub(crate) fn rates(&mut self, t: f64, out: &mut [f64]) -> Result<(), Error> {
        if out.is_empty() {
            return Ok(());
        }
        self.call_at(names::get_derivatives, Some(t), |raw| raw.get_derivatives(out))
    }

    /// Reads states and their nominal values.
    pub(crate) fn read_states(&mut self, x: &mut [f64], nominals: &mut [f64]) -> Result<(), Error> {
        if x.is_empty() {
            return Ok(());
        }
        self.call(names::get_states, |raw| raw.get_states(x))?;
        self.call(names::get_nominals, |raw| raw.get_nominals(nominals))
    }

    /// Reads the event indicators.
    pub(crate) fn read_indicators(&mut self, t: f64, z: &mut [f64]) -> Result<(), Error> {
        if z.is_empty() {
            return Ok(());
        }
        self.call_at(names::get_indicators, Some(t), |raw| raw.get_indicators(z))
    }

    /// Reports the end of a step; whether the FMU requests event mode, and the end.
    pub(crate) fn completed_step(&mut self, t: f64) -> Result<(bool, bool), Error> {
        let mut asked = (false, false);
        self.call_at([names::completed_step2[0], names::completed_step3[1]], Some(t), |raw| {
            let (status, event, end) = raw.completed_integrator_step();
            asked = (event, end);
            status
        })?;
        Ok(asked)
    }

    /// Enters event mode from continuous-time mode.
    pub(crate) fn enter_events(&mut self, t: f64) -> Result<(), Error> {
        self.call_at(names::enter_event, Some(t), RawInstance::enter_event_mode)
    }

    /// One event iteration.
    pub(crate) fn update_discrete(&mut self, t: f64) -> Result<DiscreteUpdate, Error> {
        let mut update = DiscreteUpdate::default();
        let names = [names::new_discrete_states[0], names::update_discrete_states[1]];
        self.call_at(names, Some(t), |raw| {
            let (status, result) = raw.update_discrete_states();
            update = result;
            status
        })?;
        Ok(update)
    }

    /// Enters continuous-time mode.
    pub(crate) fn enter_continuous(&mut self, t: f64) -> Result<(), Error> {
        self.call_at(names::enter_continuous, Some(t), RawInstance::enter_continuous_time_mode)
    }
}
