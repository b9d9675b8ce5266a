//! Values over a step.

/// A value that is linear over a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Line {
    /// Value at the start of the step.
    pub start: f64,
    /// Derivative, per second.
    pub slope: f64,
}

impl Line {
    /// The value `t` seconds after the start of the step.
    #[inline]
    pub fn at(&self, t: f64) -> f64 {
        self.start + self.slope * t
    }
}
