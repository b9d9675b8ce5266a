//! Handles of saved states, the same for both standards.
//!
//! A handle contains a tag that depends on its address. A pointer that is not a handle, or a freed handle, is rejected as long as its
//! memory is readable and not reused.

use crate::boundary::{Out, array};
use crate::instance::Instance;
use crate::refusal::{Outcome, Refused};
use crate::saved::Saved;
use std::ffi::c_void;
use std::ptr::null_mut;

/// Memory behind a handle.
#[repr(C)]
struct Tagged {
    tag: usize,
    saved: Saved,
}

/// Constant that, combined with the address of a handle, gives its tag.
const LIVE: usize = 0x4d6f_746f_u32 as usize;

fn tag_at(handle: *mut Tagged) -> usize {
    handle as usize ^ LIVE
}

/// Creates a handle of a saved state.
fn handle_to(saved: Saved) -> *mut c_void {
    let handle = Box::into_raw(Box::new(Tagged { tag: 0, saved }));
    // SAFETY: created above.
    unsafe { (*handle).tag = tag_at(handle) };
    handle.cast()
}

/// Checks that a pointer is a live handle.
///
/// # Safety
/// `state` is NULL or points to readable memory.
unsafe fn live(state: *mut c_void) -> Outcome<*mut Tagged> {
    let handle = state.cast::<Tagged>();
    if handle.is_null() {
        return Err(Refused::error("FMUstate is NULL."));
    }
    // SAFETY: aligned and readable; the tag is the first field.
    if !handle.is_aligned() || unsafe { handle.cast::<usize>().read_volatile() } != tag_at(handle) {
        return Err(Refused::error("FMUstate is not a saved state of this library, or it was freed."));
    }
    Ok(handle)
}

/// Restores the state of a handle.
///
/// # Safety
/// `state` is NULL or a handle from [`save`] or [`deserialize`].
pub unsafe fn restore(i: &mut Instance, state: *mut c_void) -> Outcome {
    unsafe { i.restore(&(*live(state)?).saved) }
}

/// Saves into the handle at `state`; an existing state is overwritten.
///
/// # Safety
/// `state` is NULL or points to NULL or to a handle from this function.
pub unsafe fn save(i: &mut Instance, state: *mut *mut c_void) -> Outcome {
    unsafe {
        let out = Out::variable(state, "FMUstate")?;
        let old = state.read();
        let old = if old.is_null() { None } else { Some(live(old)?) };
        if let Some(saved) = i.save(old.map(|handle| &mut (*handle).saved))? {
            if let Some(handle) = old {
                release(handle);
            }
            out.set(0, handle_to(saved));
        }
        Ok(())
    }
}

/// Frees a live handle.
unsafe fn release(handle: *mut Tagged) {
    unsafe {
        handle.cast::<usize>().write_volatile(0);
        drop(Box::from_raw(handle));
    }
}

/// Frees the handle at `state` and sets it to NULL.
///
/// # Safety
/// As [`save`].
pub unsafe fn free(state: *mut *mut c_void) -> Outcome {
    unsafe {
        if !state.is_null() && !state.read().is_null() {
            release(live(state.read())?);
            state.write(null_mut());
        }
        Ok(())
    }
}

/// Size of a serialized state in bytes.
///
/// # Safety
/// `state` is NULL or a handle from [`save`].
pub unsafe fn serialized_size(state: *mut c_void, size: *mut usize) -> Outcome {
    unsafe {
        let bytes = (*live(state)?).saved.to_bytes().len();
        Out::variable(size, "size")?.set(0, bytes);
        Ok(())
    }
}

/// Serializes a saved state.
///
/// # Safety
/// As [`serialized_size`]; `bytes` points to `n` bytes.
pub unsafe fn serialize(state: *mut c_void, bytes: *mut u8, n: usize) -> Outcome {
    unsafe {
        let written = (*live(state)?).saved.to_bytes();
        let room = Out::array(bytes, n, "serializedState")?;
        let needed = written.len();
        if needed > n {
            return Err(Refused::error(format!("the state needs {needed} bytes, but the buffer has {n}.")));
        }
        room.fill(&written);
        Ok(())
    }
}

/// Deserializes a saved state.
///
/// # Safety
/// As [`save`]; `bytes` points to `n` bytes.
pub unsafe fn deserialize(i: &mut Instance, bytes: *const u8, n: usize, state: *mut *mut c_void) -> Outcome {
    unsafe {
        let saved = i.deserialize(array(bytes, n, "serializedState")?)?;
        let out = Out::variable(state, "FMUstate")?;
        free(state)?;
        out.set(0, handle_to(saved));
        Ok(())
    }
}
