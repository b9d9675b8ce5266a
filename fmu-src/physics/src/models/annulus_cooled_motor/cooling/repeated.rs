//! The last heat paths of a slow method, which are often needed again: outputs, energy balance, event indicators and derivatives are read at
//! the same temperatures, and so are those of many instances that differ in a parameter of the motor, for sensitivities.
//!
//! The result is that of the evaluation, bit for bit. One memory for each thread, without a destructor: a library with one could not be
//! unloaded.

use super::{Coefficients, Conditions, CoolingMode, Parts};
use crate::components::housing::Housing;
use std::cell::RefCell;

/// Everything that the heat paths depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The conditions.
    pub at: Conditions,
    /// Fan command after the effects at the port fan_flow.
    pub command: f64,
    /// Number of segments of the housing.
    pub segments: usize,
    /// The mode.
    pub mode: CoolingMode,
    /// The housing.
    pub housing: Housing,
    /// The parts of the modes.
    pub parts: Parts,
}

thread_local! {
    static LAST: RefCell<Option<(Key, Coefficients)>> = const { RefCell::new(None) };
}

/// The heat paths of this key, by `compute` unless they are the last ones.
pub fn or(key: Key, compute: impl FnOnce() -> Coefficients) -> Coefficients {
    LAST.with_borrow_mut(|last| match last {
        Some((known, c)) if *known == key => *c,
        _ => last.insert((key, compute())).1,
    })
}
