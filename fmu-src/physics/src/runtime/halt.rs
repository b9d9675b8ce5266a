//! End of a step at a limit of validity: at the last time within the limits.

use crate::fault::Fault;

/// Reason for a step failure.
#[derive(Clone, Debug)]
pub enum Halt {
    /// The equations cannot be solved.
    Fault(Fault),
    /// The step would leave the limits of validity.
    Limit,
}

impl From<Fault> for Halt {
    fn from(fault: Fault) -> Halt {
        Halt::Fault(fault)
    }
}

/// Distance from the limit at which a run ends, as a fraction of the step.
const NEAR: f64 = 1e-9;

/// After a step of `h` seconds from `time` failed with `first`: advances the model by bisection to the last time within its
/// limits and returns that time. If the step fails for any other reason, the model is unchanged. `attempt` takes a step from a
/// given time, or leaves the model unchanged.
#[cold]
pub fn approach<M: Clone>(
    model: &mut M,
    (time, h): (f64, f64),
    first: Halt,
    mut attempt: impl FnMut(&mut M, f64, f64) -> Result<(), Halt>,
) -> Result<f64, Fault> {
    let before = model.clone();
    let (mut at, mut rest) = (time, h);
    let (mut is_limit, mut last) = (false, first);
    let least = (NEAR * h).max(8.0 * f64::EPSILON * time.abs());
    loop {
        is_limit |= matches!(last, Halt::Limit);
        if rest <= least {
            break;
        }
        rest *= 0.5;
        match attempt(model, at, rest) {
            Ok(()) => at += rest,
            Err(halt) => last = halt,
        }
    }
    match last {
        Halt::Fault(fault) if !is_limit => {
            *model = before;
            Err(fault)
        }
        _ => Ok(at),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock that ends at 0.3 s advances to 0.3 s; one that fails at every step is unchanged.
    #[test]
    fn the_last_time_within_the_limit_is_found() {
        let mut clock = 0.0;
        let end = approach(&mut clock, (0.0, 1.0), Halt::Limit, |clock, at, h| {
            if at + h > 0.3 {
                return Err(Halt::Limit);
            }
            *clock = at + h;
            Ok(())
        });
        assert!((clock - 0.3).abs() < 2e-9 && end == Ok(clock), "{clock} {end:?}");
        let fault = || Halt::Fault(Fault("no solution".into()));
        let failed = approach(&mut clock, (0.3, 1.0), fault(), |clock, _, h| {
            *clock += h;
            if h > 0.1 { Err(fault()) } else { Ok(()) }
        });
        assert!(failed.is_err() && (clock - 0.3).abs() < 2e-9);
    }
}
