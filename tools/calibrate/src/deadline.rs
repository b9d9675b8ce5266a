//! When a search has to end: softly, so that nothing new is begun, and hard, so that simulations stop.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Fraction of the time that is left at the soft end for what was begun.
const LEFT: f64 = 0.15;

/// The end of a search, shared by all that works for it. Without one it never passes.
#[derive(Clone, Debug, Default)]
pub struct Deadline(Arc<Mutex<Option<(Instant, Instant)>>>);

impl Deadline {
    /// A search that ends after this time.
    pub fn after(time: Duration) -> Deadline {
        let now = Instant::now();
        Deadline(Arc::new(Mutex::new(Some((now + time.mul_f64(1.0 - LEFT), now + time)))))
    }

    fn ends(&self) -> Option<(Instant, Instant)> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether nothing new is to be begun.
    pub fn is_near(&self) -> bool {
        self.ends().is_some_and(|(soft, _)| Instant::now() >= soft)
    }

    /// Whether what runs is to stop.
    pub fn is_over(&self) -> bool {
        self.ends().is_some_and(|(_, hard)| Instant::now() >= hard)
    }

    /// Lifts the deadline, for what has to be done after the search.
    pub fn lift(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
