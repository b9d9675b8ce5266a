//! Saving and restoring of an instance.

use super::Instance;
use super::mode::LIVING;
use crate::refusal::{Outcome, Refused};
use crate::saved::Saved;
use std::collections::HashMap;
use std::ffi::c_void;

/// The saved states of an instance. A handle is the address of a state: it is looked up and never followed, so a freed handle or any other
/// pointer is refused.
#[derive(Default)]
pub(super) struct SavedStates(HashMap<usize, Box<Saved>>);

impl SavedStates {
    fn get(&self, handle: *mut c_void) -> Outcome<&Saved> {
        self.0.get(&handle.addr()).map(AsRef::as_ref).ok_or_else(|| unknown(handle))
    }

    fn get_mut(&mut self, handle: *mut c_void) -> Outcome<&mut Saved> {
        self.0.get_mut(&handle.addr()).map(AsMut::as_mut).ok_or_else(|| unknown(handle))
    }

    fn add(&mut self, saved: Saved) -> *mut c_void {
        let mut saved = Box::new(saved);
        let handle: *mut c_void = std::ptr::from_mut(saved.as_mut()).cast();
        self.0.insert(handle.addr(), saved);
        handle
    }
}

#[cold]
fn unknown(handle: *mut c_void) -> Refused {
    Refused::error(if handle.is_null() {
        "FMUstate is NULL."
    } else {
        "FMUstate is not a saved state of this instance, or it was freed; another instance can continue from a serialized state."
    })
}

impl Instance {
    pub(super) fn require_living(&self) -> Outcome {
        self.require(LIVING)
    }

    /// Saves the instance into the state of this handle, or into a new one if the handle is NULL, and returns the handle.
    pub fn save(&mut self, handle: *mut c_void) -> Outcome<*mut c_void> {
        self.require_living()?;
        if handle.is_null() {
            return Ok(self.saved_states.add(Saved {
                model: self.model.boxed_clone(),
                interface: self.interface,
                mode: self.mode,
                window: self.window,
                tolerance: self.tolerance,
                last_step: self.last_step,
                discrete_pre: self.discrete_pre.clone(),
            }));
        }
        let saved = self.saved_states.get_mut(handle)?;
        saved.model.copy_from(self.model.as_ref());
        (saved.mode, saved.window, saved.tolerance) = (self.mode, self.window, self.tolerance);
        saved.last_step = self.last_step;
        saved.discrete_pre.clone_from(&self.discrete_pre);
        Ok(handle)
    }

    /// Restores the state of this handle.
    pub fn restore(&mut self, handle: *mut c_void) -> Outcome {
        self.require_living()?;
        let saved = self.saved_states.get(handle)?;
        let mode = saved.mode;
        self.model.copy_from(saved.model.as_ref());
        (self.window, self.tolerance, self.unsettled) = (saved.window, saved.tolerance, true);
        self.last_step = saved.last_step;
        let has_discrete = saved.discrete_pre.len() == self.discrete_pre.len();
        if has_discrete {
            self.discrete_pre.clone_from(&saved.discrete_pre);
        }
        self.model.scale_tolerances(self.tolerance);
        self.ended = None;
        // The saved state includes the input derivatives for the next step.
        self.saturation.sloped = true;
        self.count();
        if !has_discrete {
            self.hold();
        }
        self.log_transition("state restored");
        self.go(mode);
        self.observe();
        Ok(())
    }

    /// Frees the state of this handle.
    pub fn free_state(&mut self, handle: *mut c_void) -> Outcome {
        self.saved_states.0.remove(&handle.addr()).map(drop).ok_or_else(|| unknown(handle))
    }

    /// The bytes of the state of this handle.
    pub fn serialized(&self, handle: *mut c_void) -> Outcome<Vec<u8>> {
        Ok(self.saved_states.get(handle)?.to_bytes(self.equations))
    }

    /// Deserializes a state into that of this handle, or into a new one if the handle is NULL, and returns the handle.
    pub fn deserialize(&mut self, bytes: &[u8], handle: *mut c_void) -> Outcome<*mut c_void> {
        self.require_living()?;
        let saved = Saved::from_bytes(bytes, self.model.as_ref(), self.equations, self.interface)?;
        if handle.is_null() {
            return Ok(self.saved_states.add(saved));
        }
        *self.saved_states.get_mut(handle)? = saved;
        Ok(handle)
    }
}
