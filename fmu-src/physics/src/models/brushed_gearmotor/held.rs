//! What is kept between events for a caller who integrates.

use super::equations::Step;

/// What is held between events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Time of the last event, s.
    pub(super) since: f64,
    /// Sign of the duty at the last event.
    pub(super) direction: f64,
    /// Whether the winding was above its limit at the last event.
    pub over_temperature: bool,
}

impl Held {
    pub const NONE: Held = Held { since: 0.0, direction: 0.0, over_temperature: false };

    /// What a saved instance must hold.
    pub fn to_numbers(self) -> [f64; 3] {
        [self.since, self.direction, f64::from(u8::from(self.over_temperature))]
    }

    /// Takes back what [`to_numbers`](Held::to_numbers) gave.
    pub fn from_numbers([since, direction, over]: [f64; 3]) -> Held {
        Held { since, direction, over_temperature: over != 0.0 }
    }

    /// The equations with the bridge and the magnets as the last event has left them. A duty that has just left
    /// zero has the direction in which it left.
    pub fn applied<'a>(&self, step: Step<'a>, duty: f64) -> Step<'a> {
        let direction = if self.direction == 0.0 && duty != 0.0 { duty.signum() } else { self.direction };
        step.with_events(direction, self.since)
    }
}
