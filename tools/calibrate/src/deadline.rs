//! Deadline of a search: after the soft limit no new work starts, at the hard limit simulations stop.

use crate::CalibrateError;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Fraction of the total time between the soft and the hard limit, for work in progress. Numerical: a limit of effort.
const LEFT: f64 = 0.15;

/// When a deadline passes.
#[derive(Clone, Copy, Debug, Default)]
enum End {
    #[default]
    Never,
    /// Soft and hard limit.
    At(Instant, Instant),
    /// After it was asked for so many times, for tests.
    #[cfg(test)]
    Asked(usize),
}

/// The deadline, shared by all parts of a search. The default never passes.
#[derive(Clone, Debug, Default)]
pub struct Deadline(Arc<Mutex<End>>);

impl Deadline {
    /// A deadline after this time.
    pub fn after(time: Duration) -> Deadline {
        let now = Instant::now();
        Deadline(Arc::new(Mutex::new(End::At(now + time.mul_f64(1.0 - LEFT), now + time))))
    }

    /// A deadline whose limits pass when it has been asked for so many times, at the same place on every machine.
    #[cfg(test)]
    pub fn asked(times: usize) -> Deadline {
        Deadline(Arc::new(Mutex::new(End::Asked(times))))
    }

    /// A deadline after this fraction of the time that is left: what ends at it leaves the rest for what follows.
    pub fn share(&self, part: f64) -> Deadline {
        let end = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let End::At(soft, hard) = *end else { return self.clone() };
        let now = Instant::now();
        Deadline(Arc::new(Mutex::new(End::At(now + soft.saturating_duration_since(now).mul_f64(part), hard))))
    }

    fn has_passed(&self, limit: impl Fn(Instant, Instant) -> Instant) -> bool {
        let mut end = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *end {
            End::Never => false,
            End::At(soft, hard) => Instant::now() >= limit(*soft, *hard),
            #[cfg(test)]
            End::Asked(left) => {
                *left = left.saturating_sub(1);
                *left == 0
            }
        }
    }

    /// Whether the soft limit has passed: no new work may start.
    pub fn is_near(&self) -> bool {
        self.has_passed(|soft, _| soft)
    }

    /// Whether the hard limit has passed: running work must stop.
    pub fn is_over(&self) -> bool {
        self.has_passed(|_, hard| hard)
    }

    /// A result; `None` if the deadline ended its simulations, which is no mistake in the input.
    ///
    /// # Errors
    /// The error of the result before the deadline.
    pub fn in_time<T>(&self, result: Result<T, CalibrateError>) -> Result<Option<T>, CalibrateError> {
        match result {
            Err(_) if self.is_near() => Ok(None),
            result => result.map(Some),
        }
    }

    /// Removes the deadline for the work after the search.
    pub fn lift(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = End::Never;
    }
}
