//! C arguments of the calls on saved states, the same for both standards.

use crate::boundary::{Out, array};
use crate::instance::Instance;
use crate::refusal::{Outcome, Refused};
use std::ffi::c_void;
use std::ptr::null_mut;

/// Saves into the handle at `state`; an existing state is overwritten.
///
/// # Safety
/// `state` is NULL or points to NULL or to a handle.
pub unsafe fn save(i: &mut Instance, state: *mut *mut c_void) -> Outcome {
    // SAFETY: by contract.
    let (out, old) = unsafe { (Out::variable(state, "FMUstate")?, state.read()) };
    out.set(0, i.save(old)?);
    Ok(())
}

/// Frees the handle at `state` and sets it to NULL.
///
/// # Safety
/// As [`save`].
pub unsafe fn free(i: &mut Instance, state: *mut *mut c_void) -> Outcome {
    // SAFETY: by contract.
    if !state.is_null() && !unsafe { state.read() }.is_null() {
        // SAFETY: as above.
        i.free_state(unsafe { state.read() })?;
        unsafe { state.write(null_mut()) };
    }
    Ok(())
}

/// Size of a serialized state in bytes.
///
/// # Safety
/// `size` is NULL or writable.
pub unsafe fn serialized_size(i: &Instance, state: *mut c_void, size: *mut usize) -> Outcome {
    let bytes = i.serialized(state)?;
    // SAFETY: by contract.
    unsafe { Out::variable(size, "size") }?.set(0, bytes.len());
    Ok(())
}

/// Serializes a saved state.
///
/// # Safety
/// `bytes` is NULL or points to `n` bytes.
pub unsafe fn serialize(i: &Instance, state: *mut c_void, bytes: *mut u8, n: usize) -> Outcome {
    let written = i.serialized(state)?;
    // SAFETY: by contract.
    let room = unsafe { Out::array(bytes, n, "serializedState") }?;
    let needed = written.len();
    if needed > n {
        return Err(Refused::error(format!("the state needs {needed} bytes, but the buffer has {n}.")));
    }
    room.fill(&written);
    Ok(())
}

/// Deserializes a saved state into the handle at `state`; an existing state is overwritten.
///
/// # Safety
/// As [`save`]; `bytes` is NULL or points to `n` bytes.
pub unsafe fn deserialize(i: &mut Instance, bytes: *const u8, n: usize, state: *mut *mut c_void) -> Outcome {
    // SAFETY: by contract.
    let (bytes, out) = unsafe { (array(bytes, n, "serializedState")?, Out::variable(state, "FMUstate")?) };
    // SAFETY: as above.
    out.set(0, i.deserialize(bytes, unsafe { state.read() })?);
    Ok(())
}
