//! The last heat paths of a slow method, which are often needed again: outputs, energy balance, event indicators and derivatives are read at
//! the same temperatures, and so are those of many instances that differ in a parameter of the motor, for sensitivities.
//!
//! The result is that of the evaluation, bit for bit. One memory for each thread, without a destructor: a library with one could not be
//! unloaded.

use super::{Coefficients, Conditions, CoolingMode, Method, Parts, Site};
use crate::components::housing::Housing;
use std::cell::RefCell;

/// Everything that the heat paths depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    at: Conditions,
    command: f64,
    segments: usize,
    mode: CoolingMode,
    housing: Housing,
    parts: Parts,
}

thread_local! {
    static LAST: RefCell<Option<(Key, Coefficients)>> = const { RefCell::new(None) };
}

/// The heat paths of the method of the parameters' mode at a site.
pub fn coefficients(method: &dyn Method, site: &Site) -> Coefficients {
    let p = site.parameters;
    let key = Key {
        at: *site.at,
        command: site.command,
        segments: site.segments,
        mode: p.choices.cooling_mode,
        housing: p.housing,
        parts: p.cooling,
    };
    LAST.with_borrow_mut(|last| match last {
        Some((known, c)) if *known == key => *c,
        _ => {
            let c = site.coefficients(method);
            *last = Some((key, c));
            c
        }
    })
}
