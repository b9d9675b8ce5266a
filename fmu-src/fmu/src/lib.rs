//! The C interface: all 44 functions of FMI 2.0 and all 75 of FMI 3.0, for every model, in one library.
//!
//! The path of a call: `fmi2.rs` or `fmi3.rs` only convert the arguments; [`instance`] implements the state machine and rejects calls
//! that the standard or the declaration forbids; the model is in `physics`.
//!
//! *Invariants*: the GUID or instantiation token selects the model; a token of other start values, or of terms or a load table that are
//! missing, is refused. The start values of the archive are the only global data.
//! No panic crosses the interface: it becomes status Error, after which the instance accepts only reset and free.
//! A rejected call does not change the instance. A step allocates no memory.
//!
//! # Safety
//! The arguments of every function are those of the FMI standard: live handles of this library, arrays of the given length,
//! zero-terminated strings. NULL is rejected.

#![allow(non_snake_case)] // function names of the FMI standard

// A panic becomes a status. With `panic = "abort"` it would end the importer's process.
#[cfg(not(panic = "unwind"))]
compile_error!("the C interface needs panic = \"unwind\"");

pub mod boundary;
pub mod contents;
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

/// Start values of the archive, written into this library by the build tool.
#[used]
static START_VALUES: [u8; start_values::SIZE] = start_values::empty();

/// The start values of the archive: value references and values.
pub(crate) fn start_values() -> Vec<(u32, f64)> {
    // SAFETY: the address is that of a live static. The read is volatile because the bytes in the file may differ from those
    // at compile time.
    let block = unsafe { std::ptr::read_volatile(&START_VALUES) };
    start_values::entries(&block).collect()
}

/// A model with the start values of the archive and these resources; `None` if it rejects the resources.
pub(crate) fn new_model(kind: &ModelType, resources: &Resources) -> Option<Box<dyn Model>> {
    let mut model = (kind.new)();
    if !resources.give(model.as_mut()) {
        return None;
    }
    let declaration = model.declaration();
    for (value_reference, value) in start_values() {
        // The build tool has checked the values; values for other models are ignored.
        if let Some(entry) = declaration.by_reference(value_reference)
            && entry.check(value, false).is_ok()
        {
            model.set(entry.slot, value);
        }
    }
    Some(model)
}
