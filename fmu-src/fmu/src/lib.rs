//! The C interface: all 44 functions of FMI 2.0 and all 75 of FMI 3.0, for every model, in one library.
//!
//! A call passes through `fmi2.rs` or `fmi3.rs`, which only translate C into Rust, then through [`instance`], which implements the
//! state machine and rejects what the standard or the declaration forbids, and reaches the model in `physics`.
//!
//! *Invariants*: the GUID or instantiation token selects the model. The start values of the archive are the only global data.
//! No panic crosses the interface: it becomes status Error, after which the instance accepts reset and free only.
//! A rejected call does not change the instance. A step allocates no memory.
//!
//! # Safety
//! The arguments of every function are those of the FMI standard: handles of this library that are not freed, arrays of
//! the given length, zero-terminated strings. NULL is rejected.

#![allow(non_snake_case)] // the functions' names are the standards'

// A panic becomes a status. With `panic = "abort"` it would end the importer's process.
#[cfg(not(panic = "unwind"))]
compile_error!("the C interface needs panic = \"unwind\"");

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
use physics::resources::Resources;
use physics::start_values;

/// The start values that the archive's builder has written into this library.
#[used]
static START_VALUES: [u8; start_values::SIZE] = start_values::empty();

/// A model with the archive's start values and these resources; `None` if it does not accept the resources.
pub(crate) fn new_model(kind: &ModelType, resources: &Resources) -> Option<Box<dyn Model>> {
    // SAFETY: the address is that of a live static. The read is volatile because the bytes in the file need not
    // be those the compiler saw.
    let block = unsafe { std::ptr::read_volatile(&START_VALUES) };
    let mut model = (kind.new)();
    if !resources.give(model.as_mut()) {
        return None;
    }
    let declaration = model.declaration();
    for (value_reference, value) in start_values::entries(&block) {
        // The builder has checked the values; values for other models are ignored.
        if let Some(entry) = declaration.by_reference(value_reference)
            && entry.check(value, false).is_ok()
        {
            model.set(entry.slot, value);
        }
    }
    Some(model)
}
