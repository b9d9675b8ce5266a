//! The importer's handles to saved states, the same for both standards.

use crate::boundary::{array, array_mut, place};
use crate::instance::Instance;
use crate::refusal::{Outcome, Refused};
use crate::saved::Saved;
use std::ffi::c_void;

/// Restores the state of a handle.
///
/// # Safety
/// `state` is NULL or a handle that [`save`] or [`deserialize`] made.
pub unsafe fn restore(i: &mut Instance, state: *mut c_void) -> Outcome {
    i.restore(unsafe { place(state.cast::<Saved>(), "FMUstate")? })
}

/// Saves into the handle at `state`; an existing state is overwritten.
///
/// # Safety
/// `state` is NULL or leads to NULL or to a handle that this function made.
pub unsafe fn save(i: &mut Instance, state: *mut *mut c_void) -> Outcome {
    unsafe {
        let handle = place(state, "FMUstate")?;
        if let Some(saved) = i.save(handle.cast::<Saved>().as_mut())? {
            if !handle.is_null() {
                drop(Box::from_raw(handle.cast::<Saved>()));
            }
            *handle = Box::into_raw(Box::new(saved)).cast();
        }
        Ok(())
    }
}

/// Frees the handle at `state` and sets it to NULL.
///
/// # Safety
/// As [`save`].
pub unsafe fn free(state: *mut *mut c_void) -> Outcome {
    unsafe {
        if let Some(handle) = state.as_mut()
            && !handle.is_null()
        {
            drop(Box::from_raw(handle.cast::<Saved>()));
            *handle = std::ptr::null_mut();
        }
        Ok(())
    }
}

/// Bytes that the saved state needs.
///
/// # Safety
/// `state` is NULL or a handle that [`save`] made.
pub unsafe fn serialized_size(state: *mut c_void, size: *mut usize) -> Outcome {
    unsafe {
        let saved = place(state.cast::<Saved>(), "FMUstate")?;
        *place(size, "size")? = saved.to_bytes().len();
        Ok(())
    }
}

/// Writes the saved state as bytes.
///
/// # Safety
/// As [`serialized_size`]; `bytes` leads to `n` bytes.
pub unsafe fn serialize(state: *mut c_void, bytes: *mut u8, n: usize) -> Outcome {
    unsafe {
        let written = place(state.cast::<Saved>(), "FMUstate")?.to_bytes();
        let room = array_mut(bytes, n, "serializedState")?;
        let needed = written.len();
        let room = room.get_mut(..needed).ok_or_else(|| {
            Refused::error(format!("the state needs {needed} bytes, but the buffer has {n}."))
        })?;
        room.copy_from_slice(&written);
        Ok(())
    }
}

/// Makes a saved state of bytes.
///
/// # Safety
/// As [`save`]; `bytes` leads to `n` bytes.
pub unsafe fn deserialize(i: &mut Instance, bytes: *const u8, n: usize, state: *mut *mut c_void) -> Outcome {
    unsafe {
        let saved = i.deserialize(array(bytes, n, "serializedState")?)?;
        let handle = place(state, "FMUstate")?;
        free(handle)?;
        *handle = Box::into_raw(Box::new(saved)).cast();
        Ok(())
    }
}
