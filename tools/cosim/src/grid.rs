//! The communication points of a run.
use crate::{Error, InputTable};

/// Communication points that one run may have.
const MAX_STEPS: f64 = 1e9;
/// The options of [`Error::Option`] that a grid refuses.
pub(crate) const START: &str = "start time";
pub(crate) const STOP: &str = "stop time";
pub(crate) const STEP: &str = "step size";

/// The communication points `start + k * step`, the last of them `stop`.
pub(crate) struct Grid {
    pub(crate) start: f64,
    pub(crate) stop: f64,
    pub(crate) step: f64,
    pub(crate) steps: usize,
    /// Times closer than this are the same.
    pub(crate) slack: f64,
}

/// Whether a run over a span would have more steps than it may have.
pub(crate) fn is_too_short(step: f64, span: f64) -> bool {
    span / step > MAX_STEPS
}

impl Grid {
    /// The points from `start` to `stop` with `step` between them, by default what `fallback` makes of the span.
    /// `rigid` names an FMU that cannot take a shorter step at the end.
    pub(crate) fn new(
        start: f64,
        stop: f64,
        step: Option<f64>,
        fallback: impl Fn(f64) -> f64,
        rigid: Option<&str>,
    ) -> Result<Self, Error> {
        let refuse =
            |option, value: f64, reason: String| Err(Error::option(option, format!("{value} s"), reason));
        if !start.is_finite() {
            return refuse(START, start, "must be finite".to_owned());
        }
        if !stop.is_finite() || stop <= start {
            return refuse(STOP, stop, format!("must be finite and above the start time {start} s"));
        }
        let span = stop - start;
        let step = step.unwrap_or_else(|| fallback(span));
        if !step.is_finite() || step <= 0.0 {
            return refuse(STEP, step, "must be finite and above 0 s".to_owned());
        }
        let ratio = span / step;
        if is_too_short(step, span) || start + step == start || stop - step == stop {
            return refuse(STEP, step, format!("is too small for a span of {} s", crate::number(span)));
        }
        // An integer up to rounding error: 3600 / 0.01 is not exactly 360000.
        let whole = (ratio - ratio.round()).abs() <= 1e-9 * ratio.max(1.0) && ratio.round() >= 1.0;
        if let (false, Some(name)) = (whole, rigid) {
            let reason = format!(
                "does not divide the time from {start} s to {stop} s, and {name} cannot vary its step"
            );
            return refuse(STEP, step, reason);
        }
        let steps = if whole { ratio.round() } else { ratio.ceil() } as usize;
        Ok(Self { start, stop, step, steps, slack: 1e-9 * step.min(span) })
    }

    /// Takes all steps: `step` gets the start, the length and the end of each, with the number of the communication point there, and gives
    /// the requested end of the simulation; then the number of completed steps and that. A step also ends where an input of `table` jumps,
    /// which is no communication point. `progress` gets the fraction that is done, at most about 200 times.
    pub(crate) fn run<E>(
        &self,
        table: Option<&InputTable>,
        progress: &mut dyn FnMut(f64),
        mut step: impl FnMut(f64, f64, f64, Option<usize>) -> Result<Option<E>, Error>,
    ) -> Result<(usize, Option<E>), Error> {
        let report_every = self.steps.div_ceil(200).max(1);
        let mut taken = 0;
        for k in 0..self.steps {
            let ((mut t, mut h), done) = (self.interval(k), k + 1);
            let end = self.point(done);
            while let Some(jump) = table.and_then(|table| table.next_jump(t, end, self.slack)) {
                let ended = step(t, jump - t, jump, None)?;
                if ended.is_some() {
                    return Ok((taken, ended));
                }
                taken += 1;
                (t, h) = (jump, end - jump);
            }
            let ended = step(t, h, end, Some(done))?;
            if ended.is_some() {
                return Ok((taken, ended));
            }
            taken += 1;
            if done % report_every == 0 || done == self.steps {
                progress(done as f64 / self.steps as f64);
            }
        }
        Ok((taken, None))
    }

    /// Communication point `k`, without accumulated rounding.
    fn point(&self, k: usize) -> f64 {
        if k == self.steps { self.stop } else { self.start + k as f64 * self.step }
    }

    /// Start and length of step `k`. All lengths but the last are the same to the bit, so that an FMU can keep what
    /// it has computed for a length.
    fn interval(&self, k: usize) -> (f64, f64) {
        let t = self.point(k);
        let rest = self.stop - t;
        let shorter = k + 1 == self.steps && (rest - self.step).abs() > self.slack;
        (t, if shorter { rest } else { self.step })
    }
}
