//! Saved states of an FMU: get, set, free, to bytes and back.
use super::{Instance, Names};
use crate::Error;
use crate::raw::{Functions, RawState, names};

/// A saved state of one instance. It is freed by [`Instance::free_state`], or with the instance.
#[derive(Debug)]
pub struct State {
    instance: u64,
    slot: usize,
}

impl Instance {
    /// Saves the FMU's state. Later steps are no longer called with noSetFMUStatePriorToCurrentPoint.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Unsupported`] if the FMU does not provide it.
    pub fn get_state(&mut self) -> Result<State, Error> {
        let state = self.new_slot(RawState::NONE);
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
        self.with(names::get_state, state, |instance, raw_state| {
            instance.call_optional(names::get_state, |f| f.get_state.is_some(), |raw| raw.save(raw_state))
        })?;
        self.saved_events[state.slot].clone_from(&self.events);
        self.saved = true;
        Ok(())
    }

    /// Brings the FMU back to a saved state.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn set_state(&mut self, state: &State) -> Result<(), Error> {
        self.with(names::set_state, state, |instance, raw_state| {
            instance.call_optional(names::set_state, |f| f.set_state.is_some(), |raw| raw.restore(raw_state))
        })?;
        self.events.clone_from(&self.saved_events[state.slot]);
        Ok(())
    }

    /// Frees a saved state.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn free_state(&mut self, state: State) -> Result<(), Error> {
        self.with(names::free_state, &state, |instance, raw_state| {
            let has = |f: &Functions| f.free_state.is_some();
            let result = instance.call_optional(names::free_state, has, |raw| raw.free_state(raw_state));
            // Whatever status the FMU returns, the state must not be used again; the slot may be.
            *raw_state = RawState::NONE;
            instance.free_slots.push(state.slot);
            result
        })
    }

    /// A saved state as bytes, for this FMU alone.
    ///
    /// # Errors
    /// As [`Self::update_state`].
    pub fn serialize_state(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        self.with(names::state_size, state, |instance, raw_state| {
            let mut size = 0;
            let has = |f: &Functions| f.state_size.is_some();
            instance.call_optional(names::state_size, has, |raw| raw.state_size(raw_state, &mut size))?;
            let mut bytes = Vec::new();
            if bytes.try_reserve_exact(size).is_err() {
                let reason = format!("a state of {size} bytes does not fit into memory");
                return Err(instance.misuse(names::serialize, reason));
            }
            bytes.resize(size, 0u8);
            let has = |f: &Functions| f.serialize.is_some();
            instance.call_optional(names::serialize, has, |raw| raw.serialize(raw_state, &mut bytes))?;
            Ok(bytes)
        })
    }

    /// A state from the bytes of [`Self::serialize_state`].
    ///
    /// # Errors
    /// As [`Self::get_state`].
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let mut raw_state = RawState::NONE;
        let has = |f: &Functions| f.deserialize.is_some();
        self.call_optional(names::deserialize, has, |raw| raw.deserialize(bytes, &mut raw_state))?;
        self.saved = true;
        Ok(self.new_slot(raw_state))
    }

    fn new_slot(&mut self, state: RawState) -> State {
        let slot = self.free_slots.pop().unwrap_or(self.states.len());
        if slot == self.states.len() {
            self.states.push(state);
            self.saved_events.push(self.events.clone());
        } else {
            self.states[slot] = state;
        }
        State { instance: self.id, slot }
    }

    /// Calls `f` with the FMU's state behind `state`, which must be one of this instance.
    fn with<T>(
        &mut self,
        names: Names,
        state: &State,
        f: impl FnOnce(&mut Self, &mut RawState) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if state.instance != self.id {
            return Err(self.misuse(names, "the state belongs to another instance".to_owned()));
        }
        let mut raw_state = std::mem::replace(&mut self.states[state.slot], RawState::NONE);
        let result = f(self, &mut raw_state);
        self.states[state.slot] = raw_state;
        result
    }
}

impl Drop for Instance {
    /// The standards require that states are freed before the instance.
    fn drop(&mut self) {
        for state in self.states.iter_mut().filter(|state| !state.is_none()) {
            self.raw.free_state(state);
        }
    }
}
