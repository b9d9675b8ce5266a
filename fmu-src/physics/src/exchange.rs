//! Interface of a model for FMI Model Exchange: the importer integrates.
//!
//! The importer sets time, states and inputs, and reads derivatives and event indicators, in any order and any number of times. The
//! results are a function of the values set and of the parameters only: correlations are evaluated at each call, without cached tangents,
//! and discontinuous quantities are constant between events.
//!
//! *States.* Their number is constant. A mode that does not use a state gives it the derivative 0: an imposed quantity (current, speed)
//! is then no state, and neither is the temperature of an absent node. Energies are states, because they are outputs.
//! *State events* (event indicators): the winding temperature passes its limit; a temperature reaches a limit of validity, where the
//! simulation ends; the bridge's duty passes zero; the rotor enters another sector of block commutation. *Time events*: demagnetisation.
//! Friction is smooth at zero speed (`effects/`), and inputs outside their limits are rejected by the caller, so neither needs an event.

use crate::fault::Fault;

/// Result of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// The event has changed the states.
    pub states_changed: bool,
    /// The next time event, s; infinite if there is none.
    pub next_event: f64,
}

/// A model as seen by Model Exchange importers.
///
/// States are in the order of the declaration; slices may be shorter and then hold the first states.
pub trait Exchange {
    /// Switches to Model Exchange for the rest of the run; the present time is treated as an event.
    fn enter_model_exchange(&mut self);
    /// Writes the states.
    fn read_states(&self, out: &mut [f64]);
    /// Sets the states.
    fn write_states(&mut self, states: &[f64]);
    /// Sets the time, s.
    fn write_time(&mut self, time: f64);
    /// Writes the derivatives of the states with respect to time, per second.
    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault>;
    /// Adds the energies since the last accepted step of the importer to the energy balance.
    fn accept_step(&mut self);
    /// Updates the discrete states (pre) from the present time, states and inputs.
    fn update(&mut self) -> Update;
    /// The first time event after the present time, s; infinite if there is none.
    fn next_event(&self) -> f64 {
        f64::INFINITY
    }
    /// Reason for termination if the present states have reached a limit of validity: one sentence.
    fn termination_reason(&mut self) -> Option<String> {
        None
    }
}

/// Tolerance for a temperature at its limit, K: an importer locates the event within rounding, on either side.
const AT_LIMIT: f64 = 1e-6;

/// Whether a temperature with this excess over a limit of validity, K, has reached it.
pub fn is_reached(beyond: f64) -> bool {
    beyond >= -AT_LIMIT || beyond.is_nan()
}

/// Whether a temperature with this excess over its limit, K, is above it; at the limit, the sign of its rate decides, which is evaluated
/// only there.
pub fn is_above(excess: f64, rate: impl FnOnce() -> f64) -> bool {
    if excess.abs() <= AT_LIMIT { rate() > 0.0 } else { excess > 0.0 }
}

#[cfg(test)]
mod tests {
    use super::is_above;

    #[test]
    fn at_the_limit_the_direction_decides() {
        for excess in [0.0, 1e-12, -1e-12] {
            assert!(is_above(excess, || 0.1) && !is_above(excess, || -0.1) && !is_above(excess, || 0.0));
        }
        assert!(is_above(1e-3, || -5.0) && !is_above(-1e-3, || 5.0));
    }
}
