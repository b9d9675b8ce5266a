//! Lists of references that a master asks for again at every step: looked up and judged once.
//!
//! What a reference stands for never changes, so there is nothing to forget: not by a reset, nor by a saved state. Nothing is
//! kept of arrays, whose sizes may change. A master may set an instance in several rounds, so the last few lists are kept; one
//! that names a single variable in each of many calls leaves them alone once they are full.

use physics::declare::Kind;
use physics::model::{Declaration, Slot, TIME};

/// Longer lists are looked up at every call.
const ROOM: usize = 16;
/// Lists that are kept.
const LISTS: usize = 4;

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

/// A list of real scalars that was not refused.
#[derive(Clone, Copy, Debug)]
struct List {
    count: usize,
    references: [u32; ROOM],
    places: [Place; ROOM],
}

impl List {
    const NOTHING: List = List {
        count: 0,
        references: [TIME; ROOM],
        places: [Place { slot: Slot { group: 0, row: 0 }, min: 0.0, max: 0.0 }; ROOM],
    };
}

/// The lists that one function was called with last, the latest but for those that were known.
#[derive(Clone, Debug)]
pub(super) struct Known {
    lists: [List; LISTS],
    /// The one that the next new list replaces.
    oldest: usize,
}

impl Known {
    pub(super) const NOTHING: Known = Known { lists: [List::NOTHING; LISTS], oldest: 0 };

    /// The places of these references, where they are ones that are known.
    #[inline]
    pub(super) fn places(&self, references: &[u32]) -> Option<&[Place]> {
        let same = |list: &&List| {
            let known = list.references.iter();
            list.count == references.len() && known.zip(references).all(|(known, asked)| known == asked)
        };
        self.lists.iter().find(same).map(|list| &list.places[..references.len().min(ROOM)])
    }

    /// Remembers the list.
    pub(super) fn learn(&mut self, declaration: &Declaration, references: &[u32]) {
        let full = self.lists[self.oldest].count > 0;
        if !(1..=ROOM).contains(&references.len()) || references.len() == 1 && full {
            return;
        }
        let mut list = List { count: references.len(), ..List::NOTHING };
        for (k, &reference) in references.iter().enumerate() {
            let entry = declaration.by_reference(reference).filter(|_| reference != TIME);
            let Some(entry) = entry.filter(|e| e.element.is_none() && e.row.kind == Kind::Real) else {
                return;
            };
            list.references[k] = reference;
            list.places[k] = Place { slot: entry.slot, min: entry.row.min, max: entry.row.max };
        }
        self.lists[self.oldest] = list;
        self.oldest = (self.oldest + 1) % LISTS;
    }
}
