//! A model whose integration is another's: FMI's Model Exchange.
//!
//! The importer puts time, states and inputs, and reads derivatives and event indicators, in any order and as often as
//! it likes. What it gets is a function of what it put and of the parameters alone: correlations are evaluated where
//! they are asked for and not kept as tangents, and what jumps is held from one event to the next.
//!
//! *States.* Their number never changes under way, so a mode that has no use for a state lets it stand still with the
//! derivative 0: what an input imposes (a current, a speed) is then no state, nor is a node that is not there. Energies
//! are states, because outputs show them.
//! *Events.* By indicator: the winding passes its limit, a temperature a limit of validity, where the run ends, the bridge's duty its zero, the rotor a sector of block
//! commutation. By time: magnets that lose strength. Friction is smooth at rest (`effects/`), and inputs beyond their
//! limits are refused before they come here, so neither needs one.

use crate::fault::Fault;

/// What an event has brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// States stand elsewhere than the importer has put them.
    pub states_changed: bool,
    /// The next event that is known by its time, s; infinite where there is none.
    pub next_event: f64,
}

/// A model as those see it who integrate it themselves.
///
/// States are those of the declaration, in its order; slices may be shorter than all of them and hold the first ones.
pub trait Exchange {
    /// Leaves the integration to the caller, from here on and for good; the present time counts as an event.
    fn enter_model_exchange(&mut self);
    /// Writes the states.
    fn read_states(&self, out: &mut [f64]);
    /// Takes the states.
    fn write_states(&mut self, states: &[f64]);
    /// Sets the time, s.
    fn write_time(&mut self, time: f64);
    /// Writes the derivatives of the states with respect to time, per second.
    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault>;
    /// Adds the energies since the last accepted step of the importer to the energy balance.
    fn accept_step(&mut self);
    /// Lets what is held between events follow the present time, states and inputs.
    fn update(&mut self) -> Update;
    /// The first event after the present time that is known by its time, s; infinite where there is none.
    fn next_event(&self) -> f64 {
        f64::INFINITY
    }
    /// Why the run ends here, where the present states have reached a limit of validity: one sentence.
    fn termination_reason(&mut self) -> Option<String> {
        None
    }
}

/// How near a limit a temperature is at it, K: an importer finds the event to rounding, on either side.
const AT_LIMIT: f64 = 1e-6;

/// Whether a temperature this far beyond a limit of validity, K, has reached it.
pub fn is_reached(beyond: f64) -> bool {
    beyond >= -AT_LIMIT || beyond.is_nan()
}

/// Whether a temperature this far above its limit, K, counts as above it; at the limit, where it is heading decides.
pub fn is_above(excess: f64, rate: f64) -> bool {
    if excess.abs() <= AT_LIMIT { rate > 0.0 } else { excess > 0.0 }
}

#[cfg(test)]
mod tests {
    use super::is_above;

    #[test]
    fn at_the_limit_the_direction_decides() {
        for excess in [0.0, 1e-12, -1e-12] {
            assert!(is_above(excess, 0.1) && !is_above(excess, -0.1) && !is_above(excess, 0.0));
        }
        assert!(is_above(1e-3, -5.0) && !is_above(-1e-3, 5.0));
    }
}
