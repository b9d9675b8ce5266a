//! Deadline of a search: after the soft limit no new work starts, at the hard limit simulations stop.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Fraction of the total time between the soft and the hard limit, for work in progress. Numerical: a limit of effort.
const LEFT: f64 = 0.15;

/// The deadline, shared by all parts of a search. The default never passes.
#[derive(Clone, Debug, Default)]
pub struct Deadline(Arc<Mutex<Option<(Instant, Instant)>>>);

impl Deadline {
    /// A deadline after this time.
    pub fn after(time: Duration) -> Deadline {
        let now = Instant::now();
        Deadline(Arc::new(Mutex::new(Some((now + time.mul_f64(1.0 - LEFT), now + time)))))
    }

    fn ends(&self) -> Option<(Instant, Instant)> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the soft limit has passed: no new work may start.
    pub fn is_near(&self) -> bool {
        self.ends().is_some_and(|(soft, _)| Instant::now() >= soft)
    }

    /// Whether the hard limit has passed: running work must stop.
    pub fn is_over(&self) -> bool {
        self.ends().is_some_and(|(_, hard)| Instant::now() >= hard)
    }

    /// Removes the deadline for the work after the search.
    pub fn lift(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
