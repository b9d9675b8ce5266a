//! Saved states of an FMU: get, set, free, to bytes and back.
use super::{Backend, Instance};
use crate::Error;
use std::ffi::{c_int, c_void};
use std::ptr;

/// A saved state of one instance. It is freed by [`Instance::free_state`], or with the instance.
#[derive(Debug)]
pub struct State {
    instance: u64,
    slot: usize,
}

/// The C functions of both standards have the same types here.
struct Functions {
    get: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int,
    set: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int,
    free: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int,
}

struct BytesFunctions {
    size: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> c_int,
    write: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> c_int,
    read: unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> c_int,
}

impl Backend {
    fn handle(&self) -> *mut c_void {
        match self {
            Self::Two(i) => i.component(),
            Self::Three(i) => i.handle(),
        }
    }

    fn state_functions(&self) -> Option<Functions> {
        Some(match self {
            Self::Two(i) => Functions {
                get: i.functions.get_state?,
                set: i.functions.set_state?,
                free: i.functions.free_state?,
            },
            Self::Three(i) => Functions {
                get: i.functions.get_state?,
                set: i.functions.set_state?,
                free: i.functions.free_state?,
            },
        })
    }

    fn bytes_functions(&self) -> Option<BytesFunctions> {
        Some(match self {
            Self::Two(i) => BytesFunctions {
                size: i.functions.state_size?,
                write: i.functions.serialize_state?,
                read: i.functions.deserialize_state?,
            },
            Self::Three(i) => BytesFunctions {
                size: i.functions.state_size?,
                write: i.functions.serialize_state?,
                read: i.functions.deserialize_state?,
            },
        })
    }
}

// SAFETY, for all unsafe blocks below: the functions belong to the loaded library, the handle is alive (`call` refuses
// after Fatal), and state pointers came from this very instance, as `slot` checks.
impl Instance {
    /// Saves the FMU's state. From here on the FMU is told that it may have to go back in time.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Unsupported`] if the FMU does not provide it.
    pub fn get_state(&mut self) -> Result<State, Error> {
        let state = self.new_slot();
        let result = self.update_state(&state);
        if result.is_err() {
            self.free_slots.push(state.slot);
        }
        result.map(|()| state)
    }

    /// Saves the FMU's state once more into a state that is no longer needed, which spares an allocation.
    ///
    /// # Errors
    /// As [`Self::get_state`]; [`Error::Misuse`] for a state of another instance.
    pub fn update_state(&mut self, state: &State) -> Result<(), Error> {
        let functions = ["fmi2GetFMUstate", "fmi3GetFMUState"];
        let mut pointer = self.pointer(functions, state)?;
        self.call_optional(functions, |b| {
            let get = b.state_functions()?.get;
            // SAFETY: see above.
            Some(unsafe { get(b.handle(), &mut pointer) })
        })?;
        self.states[state.slot] = pointer;
        self.saved = true;
        Ok(())
    }

    /// Brings the FMU back to a saved state.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn set_state(&mut self, state: &State) -> Result<(), Error> {
        let functions = ["fmi2SetFMUstate", "fmi3SetFMUState"];
        let pointer = self.pointer(functions, state)?;
        self.call_optional(functions, |b| {
            let set = b.state_functions()?.set;
            // SAFETY: see above.
            Some(unsafe { set(b.handle(), pointer) })
        })
    }

    /// Frees a saved state.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn free_state(&mut self, state: State) -> Result<(), Error> {
        let functions = ["fmi2FreeFMUstate", "fmi3FreeFMUState"];
        let mut pointer = self.pointer(functions, &state)?;
        // Whatever the FMU says, the state must not be used again; the slot can be.
        self.states[state.slot] = ptr::null_mut();
        self.free_slots.push(state.slot);
        self.call_optional(functions, |b| {
            let free = b.state_functions()?.free;
            // SAFETY: see above.
            Some(unsafe { free(b.handle(), &mut pointer) })
        })
    }

    /// A saved state as bytes, for this FMU alone.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn serialize_state(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        let functions = ["fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"];
        let pointer = self.pointer(functions, state)?;
        let mut size = 0;
        self.call_optional(functions, |b| {
            let query = b.bytes_functions()?.size;
            // SAFETY: see above.
            Some(unsafe { query(b.handle(), pointer, &mut size) })
        })?;
        let functions = ["fmi2SerializeFMUstate", "fmi3SerializeFMUState"];
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(size).is_err() {
            return Err(self.misuse(functions, format!("a state of {size} bytes does not fit into memory")));
        }
        bytes.resize(size, 0u8);
        self.call_optional(functions, |b| {
            let write = b.bytes_functions()?.write;
            // SAFETY: see above; `bytes` is as long as the FMU asked for.
            Some(unsafe { write(b.handle(), pointer, bytes.as_mut_ptr(), bytes.len()) })
        })?;
        Ok(bytes)
    }

    /// A state from the bytes of [`Self::serialize_state`].
    ///
    /// # Errors
    /// As [`Self::get_state`].
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let functions = ["fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"];
        let mut pointer = ptr::null_mut();
        self.call_optional(functions, |b| {
            let read = b.bytes_functions()?.read;
            // SAFETY: see above.
            Some(unsafe { read(b.handle(), bytes.as_ptr(), bytes.len(), &mut pointer) })
        })?;
        self.saved = true;
        let state = self.new_slot();
        self.states[state.slot] = pointer;
        Ok(state)
    }

    /// Called by `drop`: the standard wants states freed before the instance.
    pub(super) fn free_all_states(&mut self) {
        let Some(functions) = self.backend.state_functions() else { return };
        for pointer in self.states.drain(..) {
            let mut pointer = pointer;
            if !pointer.is_null() {
                // SAFETY: see above; the status cannot matter any more.
                unsafe { (functions.free)(self.backend.handle(), &mut pointer) };
            }
        }
    }

    fn new_slot(&mut self) -> State {
        let slot = self.free_slots.pop().unwrap_or_else(|| {
            self.states.push(ptr::null_mut());
            self.states.len() - 1
        });
        State { instance: self.id, slot }
    }

    fn pointer(&self, functions: [&'static str; 2], state: &State) -> Result<*mut c_void, Error> {
        if state.instance != self.id {
            return Err(self.misuse(functions, "the state belongs to another instance".to_owned()));
        }
        Ok(self.states.get(state.slot).copied().unwrap_or(ptr::null_mut()))
    }
}
