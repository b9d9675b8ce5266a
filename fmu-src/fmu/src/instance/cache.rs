//! Cache of the lists of value references that an importer repeats at every step: resolved and checked once.
//!
//! The meaning of a reference never changes, so a reset or a restored state invalidates no entry. Lists with arrays, whose sizes may
//! change, are not stored. The last few lists are cached, since an importer may set an instance in several calls; a list of one variable
//! replaces no cached list.

use physics::declare::Kind;
use physics::model::{Declaration, Slot, TIME};

/// Longer lists are resolved at every call; a master that records reads all outputs of a model, at most 37.
const ROOM: usize = 40;
/// Number of cached lists.
const LISTS: usize = 4;

/// A real scalar: its slot and its limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) slot: Slot,
    min: f64,
    max: f64,
    /// Whether the variable is an input that saturates.
    pub(super) saturates: bool,
}

impl Place {
    /// Whether the value is finite and within the limits.
    #[inline]
    pub(super) fn takes(&self, value: f64) -> bool {
        value.is_finite() && value >= self.min && value <= self.max
    }
}

/// A checked list of real scalars.
#[derive(Clone, Copy, Debug)]
struct List {
    count: usize,
    references: [u32; ROOM],
    places: [Place; ROOM],
}

const EMPTY: Place = Place { slot: Slot { group: 0, row: 0 }, min: 0.0, max: 0.0, saturates: false };

impl List {
    const EMPTY: List = List { count: 0, references: [TIME; ROOM], places: [EMPTY; ROOM] };
}

/// The most recent different lists of one function.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    lists: [List; LISTS],
    /// Index of the list that the next new list replaces.
    oldest: usize,
}

impl Cache {
    pub(super) const EMPTY: Cache = Cache { lists: [List::EMPTY; LISTS], oldest: 0 };

    /// Slots and limits of these references, if the list is cached.
    #[inline]
    pub(super) fn places(&self, references: &[u32]) -> Option<&[Place]> {
        let same = |list: &&List| {
            let known = list.references.iter();
            list.count == references.len() && known.zip(references).all(|(known, asked)| known == asked)
        };
        self.lists.iter().find(same).map(|list| &list.places[..references.len().min(ROOM)])
    }

    /// Stores the list.
    pub(super) fn store(&mut self, declaration: &Declaration, references: &[u32]) {
        let full = self.lists[self.oldest].count > 0;
        if !(1..=ROOM).contains(&references.len()) || references.len() == 1 && full {
            return;
        }
        let mut list = List { count: references.len(), ..List::EMPTY };
        for (k, &reference) in references.iter().enumerate() {
            let entry = declaration.by_reference(reference).filter(|_| reference != TIME);
            let Some(entry) = entry.filter(|e| e.element.is_none() && e.row.kind == Kind::Real) else {
                return;
            };
            list.references[k] = reference;
            let row = entry.row;
            list.places[k] = Place { slot: entry.slot, min: row.min, max: row.max, saturates: row.saturates };
        }
        self.lists[self.oldest] = list;
        self.oldest = (self.oldest + 1) % LISTS;
    }
}
