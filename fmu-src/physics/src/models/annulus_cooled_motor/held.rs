//! What is kept between events for a caller who integrates.

use super::state_list::{ALL, All};
use std::f64::consts::FRAC_PI_3;

/// What is kept for a caller who integrates.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// The states as the caller has put them, those that stand still among them.
    pub(super) states: All,
    /// Which of them move.
    pub(super) moving: [bool; ALL],
    /// Time of the last event, s.
    pub since: f64,
    /// The sector of block commutation since the last event.
    pub(super) sector: f64,
    /// Whether the winding was above its limit at the last event.
    pub over_temperature: bool,
    /// Whether the duty was zero at the last event.
    pub(super) idle: bool,
    /// The factor on the heat capacities that the books know.
    pub(super) booked: f64,
}

impl Held {
    /// Before any start.
    pub const NONE: Held = Held {
        states: [0.0; ALL],
        moving: [false; ALL],
        since: 0.0,
        sector: 0.0,
        over_temperature: false,
        idle: false,
        booked: 1.0,
    };

    /// An electrical angle in the sector, rad.
    pub fn angle(&self) -> f64 {
        (self.sector + 0.5) * FRAC_PI_3
    }

    /// What a saved instance must hold.
    pub fn to_numbers(self) -> impl Iterator<Item = f64> {
        let flags = self.moving.map(|m| f64::from(u8::from(m)));
        let over = f64::from(u8::from(self.over_temperature));
        self.states.into_iter().chain(flags).chain([
            self.since,
            self.sector,
            over,
            f64::from(u8::from(self.idle)),
            self.booked,
        ])
    }

    /// Takes back what [`to_numbers`](Held::to_numbers) gave; `None` where the numbers run out.
    pub fn from_numbers(next: &mut impl FnMut() -> Option<f64>) -> Option<Held> {
        let mut held = Held::NONE;
        for state in &mut held.states {
            *state = next()?;
        }
        for moving in &mut held.moving {
            *moving = next()? != 0.0;
        }
        held.since = next()?;
        held.sector = next()?;
        held.over_temperature = next()? != 0.0;
        held.idle = next()? != 0.0;
        held.booked = next()?;
        Some(held)
    }
}
