//! What moves the motor over a period: an actuator under a gait, a cycle at its shaft, or a mix of both with rest.

use super::envelope::Envelope;
use super::periodic::Periodic;
use crate::StudyError;

/// Periods at the start until motion and current repeat.
pub(super) const SETTLING: u32 = 2;

/// A motor with what moves it, simulated period by period.
pub trait Period: Send + Sync {
    /// Time of a period, s.
    fn stride_time(&self) -> f64;

    /// Periods until motion and current repeat.
    fn settling(&self) -> u32 {
        SETTLING
    }

    /// Simulates a period.
    ///
    /// # Errors
    /// Equations that have no solution.
    fn stride(&mut self) -> Result<Periodic, StudyError>;

    /// The temperatures that the motor's heat depends on, K.
    fn temperatures(&self) -> Vec<f64>;

    /// Sets them; current and motion stay.
    fn put_temperatures(&mut self, temperatures: &[f64]);

    /// Simulates a period and finds the mean derivatives of the temperatures' rates with respect to the temperatures, 1/s, a row for
    /// each rate.
    ///
    /// # Errors
    /// Equations that have no solution.
    fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError>;

    /// The winding for `duration`, s, or until it reaches `limit`, K, where the period consists of parts that are followed one by one.
    fn own_envelope(
        &mut self,
        _duration: f64,
        _limit: f64,
        _done: &(dyn Fn(f64) + Sync),
    ) -> Option<Result<Envelope, StudyError>> {
        None
    }

    /// A copy.
    fn boxed_clone(&self) -> Box<dyn Period>;
}

/// Makes a type with methods of these names a [`Period`].
macro_rules! period {
    ($name:ty $(, $further:item)*) => {
        impl $crate::walk::walker::Period for $name {
            fn stride_time(&self) -> f64 {
                <$name>::stride_time(self)
            }
            fn stride(&mut self) -> Result<Periodic, StudyError> {
                <$name>::stride(self)
            }
            fn temperatures(&self) -> Vec<f64> {
                <$name>::temperatures(self)
            }
            fn put_temperatures(&mut self, temperatures: &[f64]) {
                <$name>::put_temperatures(self, temperatures);
            }
            fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
                <$name>::stride_with_slopes(self)
            }
            fn boxed_clone(&self) -> Box<dyn $crate::walk::walker::Period> {
                Box::new(self.clone())
            }
            $($further)*
        }
    };
}
pub(super) use period;

/// Any of them.
pub struct Walker(Box<dyn Period>);

impl Walker {
    pub(super) fn new(period: impl Period + 'static) -> Walker {
        Walker(Box::new(period))
    }
}

impl Clone for Walker {
    fn clone(&self) -> Self {
        Walker(self.0.boxed_clone())
    }
}

impl std::ops::Deref for Walker {
    type Target = dyn Period;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl std::ops::DerefMut for Walker {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}
