//! Lists of references that a master asks for again at every step: looked up and judged once.
//!
//! What a reference stands for never changes, so there is nothing to forget: not by a reset, nor by a saved state. Nothing is
//! kept of arrays, whose sizes may change, and of lists that call by call name one variable.

use physics::declare::Kind;
use physics::model::{Declaration, Slot, TIME};

/// Longer lists are looked up at every call.
const ROOM: usize = 16;

/// A real scalar: where it lives, and its limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) slot: Slot,
    min: f64,
    max: f64,
}

impl Place {
    /// Whether the variable takes the value.
    #[inline]
    pub(super) fn takes(&self, value: f64) -> bool {
        value.is_finite() && value >= self.min && value <= self.max
    }
}

/// The list that one function was called with last, as far as it was a list of real scalars and was not refused.
#[derive(Clone, Debug)]
pub(super) struct Known {
    count: usize,
    references: [u32; ROOM],
    places: [Place; ROOM],
}

impl Known {
    pub(super) const NOTHING: Known = Known {
        count: 0,
        references: [TIME; ROOM],
        places: [Place { slot: Slot { group: 0, row: 0 }, min: 0.0, max: 0.0 }; ROOM],
    };

    /// The places of these references, where they are the ones that are known.
    #[inline]
    pub(super) fn places(&self, references: &[u32]) -> Option<&[Place]> {
        (references.len() == self.count && references == &self.references[..self.count])
            .then(|| &self.places[..self.count])
    }

    /// Remembers the list.
    pub(super) fn learn(&mut self, declaration: &Declaration, references: &[u32]) {
        self.count = 0;
        if !(2..=ROOM).contains(&references.len()) {
            return;
        }
        for (k, &reference) in references.iter().enumerate() {
            let entry = declaration.by_reference(reference).filter(|_| reference != TIME);
            let Some(entry) = entry.filter(|e| e.element.is_none() && e.row.kind == Kind::Real) else {
                return;
            };
            self.references[k] = reference;
            self.places[k] = Place { slot: entry.slot, min: entry.row.min, max: entry.row.max };
        }
        self.count = references.len();
    }
}
