//! Inputs with physical saturation: a finite value outside the limits acts as the limit.
//!
//! The first value of a variable outside its limits returns Warning with a message, further ones return OK. FMI 2.0.5 section 2.2.3
//! and FMI 3.0.2 section 2.2.6.4 leave the handling of an input outside min and max to the FMU. A getter returns the limited value,
//! because the outputs belong to that value. An input derivative (FMI 2) acts until the input reaches the limit: the step is divided
//! at that time.

use super::Instance;
use super::stepping::copy;
use crate::logger::Category;
use crate::refusal::Outcome;
use physics::model::{Declaration, Entry};

/// A continuous input with its derivative.
#[derive(Clone, Debug)]
struct Ramp {
    entry: &'static Entry,
    /// Value at the start of the step.
    from: f64,
    /// Derivative over the step, per second.
    slope: f64,
}

impl Ramp {
    /// Value after `t` seconds without saturation.
    fn after(&self, t: f64) -> f64 {
        self.from + self.slope * t
    }

    /// The limit that the input reaches within `h` seconds, and the time until then, s.
    fn limit(&self, h: f64) -> Option<(f64, f64)> {
        let limit = self.entry.row.limited(self.after(h));
        (limit != self.after(h)).then(|| (limit, ((limit - self.from) / self.slope).clamp(0.0, h)))
    }
}

/// Inputs of an instance that may have derivatives, and the reported saturations.
#[derive(Clone, Debug)]
pub(super) struct Saturation {
    ramps: Vec<Ramp>,
    /// Whether a saturating input may have a derivative in the next step.
    pub(super) sloped: bool,
    /// Value references of the inputs whose saturation has been reported.
    reported: Vec<u32>,
}

impl Saturation {
    pub(super) fn new(declaration: &'static Declaration) -> Saturation {
        let inputs = declaration.entries.iter().filter(|entry| entry.is_continuous_input());
        let ramps: Vec<Ramp> = inputs.map(|entry| Ramp { entry, from: 0.0, slope: 0.0 }).collect();
        let inputs = ramps.len();
        Saturation { reported: Vec::with_capacity(inputs), ramps, sloped: false }
    }

    /// Clears the reported saturations after a reset.
    pub(super) fn reset(&mut self) {
        self.reported.clear();
        self.sloped = false;
    }
}

impl Instance {
    /// Called if a saturating input has a derivative: prepares the copy that the step may need, since a step allocates no memory.
    #[cold]
    pub(super) fn expect_limits(&mut self) {
        self.saturation.sloped = true;
        if self.step_start.is_none() {
            self.step_start = Some(self.model.boxed_clone());
        }
    }

    /// Reports the first value of an input outside its limits.
    #[cold]
    pub(super) fn report_saturation(&mut self, entry: &Entry, value: f64) {
        if self.saturation.reported.contains(&entry.value_reference) {
            return;
        }
        self.saturation.reported.push(entry.value_reference);
        self.has_warned = true;
        let row = entry.row;
        self.log.note(Category::Warning, || {
            format!(
                "{} = {value} is limited to {}: it saturates outside {} ... {}; further values are limited without a message.",
                entry.name,
                row.limited(value),
                row.min,
                row.max
            )
        });
    }

    /// A step with input derivatives, divided at the times when a saturating input reaches its limit.
    #[cold]
    pub(super) fn advance_to_limits(&mut self, at: f64, h: f64) -> Outcome {
        let mut ramps = std::mem::take(&mut self.saturation.ramps);
        for ramp in &mut ramps {
            ramp.from = self.model.get(ramp.entry.slot);
            ramp.slope = self.model.slope(ramp.entry.slot);
        }
        let outcome = if ramps.iter().any(|ramp| ramp.limit(h).is_some()) {
            self.advance_in_parts(at, h, &ramps)
        } else {
            self.take_step(at, h)
        };
        self.saturation.ramps = ramps;
        outcome
    }

    fn advance_in_parts(&mut self, at: f64, h: f64, ramps: &[Ramp]) -> Outcome {
        let before = copy(self.step_start.take(), self.model.as_ref());
        let mut done = 0.0;
        let mut outcome = Ok(());
        while done < h && outcome.is_ok() {
            let limits = ramps.iter().filter_map(|ramp| ramp.limit(h)).map(|(_, t)| t);
            let end = limits.filter(|t| *t > done).fold(h, f64::min);
            for ramp in ramps {
                let slot = ramp.entry.slot;
                match ramp.limit(h) {
                    Some((limit, t)) if t <= done => {
                        self.model.set(slot, limit);
                        self.model.set_slope(slot, 0.0);
                    }
                    _ => self.model.set_slope(slot, ramp.slope),
                }
            }
            outcome = self.take_step(at + done, end - done);
            done = end;
        }
        if outcome.is_ok() {
            for ramp in ramps {
                if let Some((limit, _)) = ramp.limit(h) {
                    self.model.set(ramp.entry.slot, limit);
                    self.report_saturation(ramp.entry, ramp.after(h));
                }
            }
        } else if self.ended.is_none() {
            self.model.copy_from(before.as_ref());
        }
        self.step_start = Some(before);
        outcome
    }
}
