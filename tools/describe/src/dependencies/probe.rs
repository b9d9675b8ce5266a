//! Points at which a model is evaluated: pseudo-random values of its variables.

use crate::preset::StartValues;
use physics::declare::Kind;
use physics::model::{Entry, Model};

/// Pseudo-random numbers, the same in every run: a hash of combination, point and count, because features of `rand` in a product
/// crate would compile it twice.
pub(crate) struct Probe(u64);

impl Probe {
    /// The numbers of one point of one combination, independent of the order of evaluation.
    pub(crate) fn new(combination: usize, point: usize) -> Probe {
        Probe((combination as u64) << 40 | (point as u64) << 32)
    }

    /// A fraction between 0.05 and 0.95: SplitMix64 (Steele, Lea, Flood 2014).
    pub(crate) fn fraction(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) as f64 / u64::MAX as f64).clamp(0.05, 0.95)
    }

    /// About half of these, at random.
    pub(super) fn half_of(&mut self, all: &[&'static str]) -> Vec<&'static str> {
        all.iter().copied().filter(|_| self.fraction() < 0.5).collect()
    }

    /// Changes every state of a started model by a fraction of its nominal value; false if it has no derivatives there.
    pub(crate) fn push(&mut self, model: &mut dyn Model, count: usize) -> bool {
        let declaration = model.declaration();
        let mut states = vec![0.0; count];
        model.read_states(&mut states);
        for (state, [entry, _]) in states.iter_mut().zip(&declaration.states) {
            *state += 0.1 * self.fraction() * declaration.entries[*entry].row.nominal;
        }
        model.write_states(&states);
        model.update();
        model.derivatives(&mut states).is_ok()
    }

    /// A value within the limits, of nominal size, different from the start value; integers and enumerations at their start.
    pub(crate) fn generic(&mut self, entry: &Entry, starts: &StartValues) -> f64 {
        let row = entry.row;
        match row.kind {
            Kind::Real => {
                let base = if row.start == 0.0 { row.nominal } else { row.start };
                let value = base * (0.7 + 0.6 * self.fraction());
                if (row.min..=row.max).contains(&value) {
                    value
                } else {
                    row.min + (row.max - row.min) * self.fraction()
                }
            }
            _ => starts.of(entry),
        }
    }
}
