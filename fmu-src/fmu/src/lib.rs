//! The C interface: all 44 functions of FMI 2.0 and all 75 of FMI 3.0, for every model, in one library.
//!
//! A volt passes `fmi2.rs` or `fmi3.rs`, which only translate C into Rust, then [`instance`], which keeps the
//! state machine and refuses what the standard or the declaration forbids, and reaches the model in `physics`.
//!
//! *Invariants*: the GUID or instantiation token picks the model. There are no globals but the start values of
//! the archive. No panic crosses the interface: it becomes status Error, and the instance takes no further call
//! but reset and free. A refused call leaves the instance as it was. Nothing is allocated in a step.
//!
//! # Safety
//! Every function takes what the FMI standard says it takes: handles that this library made and that are not
//! freed, arrays as long as their lengths say, strings that end in zero. NULL is refused, not followed.

#![allow(non_snake_case)] // the functions' names are the standards'

pub mod boundary;
pub mod fmi2;
pub mod fmi3;
pub mod instance;
pub mod logger;
pub mod refusal;
pub mod resources;
pub mod saved;
pub mod saved_handle;

use physics::model::{Model, ModelType};
use physics::start_values;
use physics::terms::GenericTerm;

/// The start values that the archive's builder has written into this library.
#[used]
static START_VALUES: [u8; start_values::SIZE] = start_values::empty();

/// A model at the archive's start values that carries these terms; `None` where it takes none such.
pub(crate) fn new_model(kind: &ModelType, terms: &[GenericTerm]) -> Option<Box<dyn Model>> {
    // SAFETY: the address is that of a live static. The read is volatile because the bytes in the file need not
    // be those the compiler saw.
    let block = unsafe { std::ptr::read_volatile(&START_VALUES) };
    let mut model = (kind.new)();
    if !terms.is_empty() && !model.set_terms(terms) {
        return None;
    }
    let declaration = model.declaration();
    for (value_reference, value) in start_values::entries(&block) {
        // The builder has checked the values; what does not fit this model is not for it.
        if let Some(entry) = declaration.by_reference(value_reference)
            && entry.check(value, false).is_ok()
        {
            model.set(entry.slot, value);
        }
    }
    Some(model)
}
