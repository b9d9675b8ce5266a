//! Variable step size: each step is taken once, rolled back and repeated as two half steps. The difference of the
//! connected outputs estimates the error (Richardson). The result of the half steps is kept.
use super::master::{Master, Outcome};
use super::record::Record;
use crate::{Error, Status};

pub(crate) struct Control {
    /// Error of one step, relative to the largest magnitude that an output has had.
    pub(crate) tolerance: f64,
    /// Order of the coupling: 1 with constant inputs, 2 with input derivatives.
    pub(crate) order: i32,
    /// Length of the first step (s).
    pub(crate) first: f64,
    pub(crate) start: f64,
    pub(crate) stop: f64,
}

/// Safety factor on the tolerance ...
const SAFETY: f64 = 0.8;
/// ... and limits of the change of the step size.
const SHRINK: f64 = 0.2;
const GROW: f64 = 2.0;

/// Result of an attempted step.
enum Attempt {
    /// Completed, with its error estimate over the allowed error.
    Completed(f64),
    /// A component requests the end.
    Ended(usize),
    Refused(Error),
}

/// Runs from start to stop.
///
/// # Errors
/// A step that does not meet the tolerance, or that an FMU refuses, at a billionth of the whole time.
pub(crate) fn run(
    master: &mut Master,
    record: &mut Record,
    control: &Control,
    progress: &mut dyn FnMut(f64),
) -> Result<Outcome, Error> {
    let span = control.stop - control.start;
    let least = 1e-9 * span;
    let mut largest: Vec<f64> = master.outputs().iter().map(|y| y.abs()).collect();
    let mut whole = vec![0.0; largest.len()];
    let (mut t, mut h) = (control.start, control.first.min(span));
    let mut outcome = Outcome::default();
    let mut reported = 0.0;
    while t < control.stop {
        // Inputs over time have a kink at each row.
        let row = master.next_row(t + least).filter(|row| *row < control.stop - least);
        let end = row.unwrap_or(control.stop);
        let rest = end - t;
        // Two equal steps to the end rather than a long and a tiny one; a last step that meets the end exactly.
        let last = h >= rest * (1.0 - 1e-12);
        let step = if last { rest } else { h.min(0.5 * rest) };
        master.save()?;
        let (error, refusal) = match attempt(master, t, step, control, &mut largest, &mut whole)? {
            Attempt::Ended(component) => {
                outcome.ended = Some((component, t));
                return Ok(outcome);
            }
            Attempt::Refused(refusal) => (f64::INFINITY, Some(refusal)),
            Attempt::Completed(error) => (error, None),
        };
        // The error of a step falls with one order more than that of the whole run.
        let factor = SAFETY * error.max(1e-12).powf(-1.0 / f64::from(control.order + 1));
        if error <= 1.0 {
            t = if last { end } else { t + step };
            outcome.steps += 1;
            let last = t >= control.stop;
            record.point(master, t, last)?;
            let proposed = step * factor.clamp(SHRINK, GROW);
            // A row that cuts a step short says nothing about the next one.
            h = if row.is_some() && step < h { proposed.max(h) } else { proposed };
            let share = (t - control.start) / span;
            if share - reported >= 0.005 || last {
                progress(share);
                reported = share;
            }
        } else {
            master.roll_back()?;
            outcome.rejected += 1;
            h = step * factor.clamp(SHRINK, 0.9);
            if h < least {
                let reason = format!("cannot be met at t = {t} s: steps of {step:e} s are still too long");
                return Err(refusal.unwrap_or_else(|| Error::option("tolerance", control.tolerance, reason)));
            }
        }
    }
    Ok(outcome)
}

/// One step, rolled back and repeated as two half steps; the master is at the end of the second one if they complete.
fn attempt(
    master: &mut Master,
    t: f64,
    step: f64,
    control: &Control,
    largest: &mut [f64],
    whole: &mut [f64],
) -> Result<Attempt, Error> {
    let half = 0.5 * step;
    for (k, (at, length)) in [(t, step), (t, half), (t + half, step - half)].into_iter().enumerate() {
        match master.step(at, length) {
            Ok(None) => {}
            Ok(Some(component)) => return Ok(Attempt::Ended(component)),
            Err(error @ Error::Call { status: Status::Discard, .. }) => return Ok(Attempt::Refused(error)),
            Err(error) => return Err(error),
        }
        if k == 0 {
            whole.copy_from_slice(master.outputs());
            master.roll_back()?;
        }
    }
    let mut worst: f64 = 0.0;
    let gain = f64::from(2_i32.pow(control.order as u32) - 1);
    for ((fine, coarse), size) in master.outputs().iter().zip(whole).zip(&*largest) {
        let error = (fine - *coarse).abs() / gain;
        if error > 0.0 {
            worst = worst.max(error / (control.tolerance * size.max(fine.abs())));
        }
    }
    if worst <= 1.0 {
        master.outputs().iter().zip(largest).for_each(|(y, size)| *size = size.max(y.abs()));
    }
    // A step to NaN or infinity is rejected.
    let finite = master.outputs().iter().all(|y| y.is_finite());
    Ok(Attempt::Completed(if finite { worst } else { f64::INFINITY }))
}
