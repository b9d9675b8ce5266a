//! Steps of variable length: each is made once whole and once in two halves, and what the connected outputs differ by
//! tells the error (Richardson). The halves are what is kept.
use super::bus::Bus;
use super::master::Outcome;
use super::record::Record;
use crate::{Error, Status};

/// What governs the step.
pub(crate) struct Control {
    /// Error of one step, relative to the largest amount that an output has had.
    pub(crate) tolerance: f64,
    /// Order of the coupling: 1 with held inputs, 2 with slopes.
    pub(crate) order: i32,
    /// Length of the first step (s).
    pub(crate) first: f64,
    pub(crate) start: f64,
    pub(crate) stop: f64,
}

/// Steps aim at this share of the tolerance ...
const SAFETY: f64 = 0.8;
/// ... and change by these factors at most.
const SHRINK: f64 = 0.2;
const GROW: f64 = 2.0;

/// How a step went.
enum Trial {
    /// Made, with its error over what is allowed.
    Made(f64),
    /// A component asks for the end.
    Ended(usize),
    /// An FMU refused it.
    Refused(Error),
}

/// Runs from start to stop.
///
/// # Errors
/// A step that stays too long for the tolerance, or for an FMU, at a billionth of the whole time.
pub(crate) fn run(
    bus: &mut Bus,
    record: &mut Record,
    control: &Control,
    progress: &mut dyn FnMut(f64),
) -> Result<Outcome, Error> {
    let span = control.stop - control.start;
    let least = 1e-9 * span;
    let mut largest: Vec<f64> = bus.outputs().iter().map(|y| y.abs()).collect();
    let mut whole = vec![0.0; largest.len()];
    let (mut t, mut h) = (control.start, control.first.min(span));
    let mut outcome = Outcome::default();
    let mut told = 0.0;
    while t < control.stop {
        let rest = control.stop - t;
        // Two equal steps to the end rather than a long and a tiny one; a last step that meets the end exactly.
        let last = h >= rest * (1.0 - 1e-12);
        let step = if last { rest } else { h.min(0.5 * rest) };
        bus.save()?;
        let trial = attempt(bus, t, step, control, &mut largest, &mut whole)?;
        let (error, refusal) = match trial {
            Trial::Ended(component) => {
                outcome.ended = Some((component, t));
                return Ok(outcome);
            }
            Trial::Refused(refusal) => (f64::INFINITY, Some(refusal)),
            Trial::Made(error) => (error, None),
        };
        // The error of a step falls with one order more than that of the whole run.
        let factor = SAFETY * error.max(1e-12).powf(-1.0 / f64::from(control.order + 1));
        if error <= 1.0 {
            t = if last { control.stop } else { t + step };
            outcome.steps += 1;
            record.point(bus, t, last)?;
            h = step * factor.clamp(SHRINK, GROW);
            let share = (t - control.start) / span;
            if share - told >= 0.005 || last {
                progress(share);
                told = share;
            }
        } else {
            bus.back()?;
            outcome.rejected += 1;
            h = step * factor.clamp(SHRINK, 0.9);
            if h < least {
                return Err(refusal.unwrap_or_else(|| Error::Option {
                    option: "tolerance",
                    value: control.tolerance.to_string(),
                    reason: format!("cannot be met at t = {t} s: steps of {step:e} s are still too long"),
                }));
            }
        }
    }
    Ok(outcome)
}

/// One step whole, then again in halves; the bus is at the end of the halves if it was made.
fn attempt(
    bus: &mut Bus,
    t: f64,
    step: f64,
    control: &Control,
    largest: &mut [f64],
    whole: &mut [f64],
) -> Result<Trial, Error> {
    let half = 0.5 * step;
    for (k, (at, length)) in [(t, step), (t, half), (t + half, step - half)].into_iter().enumerate() {
        match bus.step(at, length) {
            Ok(None) => {}
            Ok(Some(component)) => return Ok(Trial::Ended(component)),
            Err(error @ Error::Call { status: Status::Discard, .. }) => return Ok(Trial::Refused(error)),
            Err(error) => return Err(error),
        }
        if k == 0 {
            whole.copy_from_slice(bus.outputs());
            bus.back()?;
        }
    }
    let mut worst: f64 = 0.0;
    let gain = f64::from(2_i32.pow(control.order as u32) - 1);
    for ((fine, coarse), size) in bus.outputs().iter().zip(whole).zip(&*largest) {
        let error = (fine - *coarse).abs() / gain;
        if error > 0.0 {
            worst = worst.max(error / (control.tolerance * size.max(fine.abs())));
        }
    }
    if worst <= 1.0 {
        bus.outputs().iter().zip(largest).for_each(|(y, size)| *size = size.max(y.abs()));
    }
    // What is no number is no step.
    let sound = bus.outputs().iter().all(|y| y.is_finite());
    Ok(Trial::Made(if sound { worst } else { f64::INFINITY }))
}
