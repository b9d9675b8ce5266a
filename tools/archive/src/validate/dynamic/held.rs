//! The instance of a session, and where it goes afterwards.

use std::cell::Cell;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

use cosim::raw::RawInstance;

/// The only instance of a process whose FMU allows no second one.
pub(super) type Pool = Rc<Cell<Option<RawInstance>>>;

/// An instance of a session; one that must be the only one goes back to the pool.
pub(super) struct Held {
    raw: Option<RawInstance>,
    pool: Option<Pool>,
}

impl Held {
    pub(super) fn new(raw: RawInstance, pool: Option<Pool>) -> Held {
        Held { raw: Some(raw), pool }
    }
}

impl Deref for Held {
    type Target = RawInstance;

    fn deref(&self) -> &RawInstance {
        self.raw.as_ref().expect("it is taken in drop alone")
    }
}

impl DerefMut for Held {
    fn deref_mut(&mut self) -> &mut RawInstance {
        self.raw.as_mut().expect("it is taken in drop alone")
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(pool) = &self.pool {
            pool.set(self.raw.take());
        }
    }
}
