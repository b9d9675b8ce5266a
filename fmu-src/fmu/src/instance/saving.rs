//! Saving and restoring of an instance.

use super::Instance;
use super::mode::LIVING;
use crate::refusal::{Outcome, Refused};
use crate::saved::Saved;

impl Instance {
    pub(super) fn require_living(&self) -> Outcome {
        self.require(LIVING)
    }

    /// Saves the instance, in the memory of `old` if that is of the same model.
    pub fn save(&self, old: Option<&mut Saved>) -> Outcome<Option<Saved>> {
        self.require_living()?;
        let (mode, window) = (self.mode, self.window);
        if let Some(old) = old
            && old.interface == self.interface
            && old.model.copy_from(self.model.as_ref())
        {
            (old.mode, old.window, old.tolerance) = (mode, window, self.tolerance);
            old.discrete_pre.clone_from(&self.discrete_pre);
            return Ok(None);
        }
        let interface = self.interface;
        Ok(Some(Saved {
            model: self.model.boxed_clone(),
            interface,
            mode,
            window,
            tolerance: self.tolerance,
            discrete_pre: self.discrete_pre.clone(),
        }))
    }

    /// Restores a saved state.
    pub fn restore(&mut self, saved: &Saved) -> Outcome {
        self.require_living()?;
        if saved.interface != self.interface {
            return Err(Refused::error(format!(
                "the saved state is from an instance for {}, but this instance is for {}.",
                saved.interface.words(),
                self.interface.words()
            )));
        }
        if !self.model.copy_from(saved.model.as_ref()) {
            return Err(Refused::error(format!(
                "the saved state is from {}, not from {}.",
                saved.model.declaration().name,
                self.model.declaration().name
            )));
        }
        (self.window, self.tolerance, self.unsettled) = (saved.window, saved.tolerance, true);
        self.model.scale_tolerances(self.tolerance);
        self.ended = None;
        // The saved state includes the input derivatives for the next step.
        self.saturation.sloped = true;
        self.count();
        if saved.discrete_pre.len() == self.discrete_pre.len() {
            self.discrete_pre.clone_from(&saved.discrete_pre);
        } else {
            self.hold();
        }
        self.log_transition("state restored");
        self.go(saved.mode);
        self.observe();
        Ok(())
    }

    /// Deserializes a saved state.
    pub fn deserialize(&self, bytes: &[u8]) -> Outcome<Saved> {
        self.require_living()?;
        Saved::from_bytes(bytes, self.model.as_ref(), self.interface)
    }
}
