//! How a step ends where a model's equations end: at the last time within its limits of validity.

use crate::fault::Fault;

/// Why a step is not taken.
#[derive(Clone, Debug)]
pub enum Halt {
    /// The equations cannot be solved.
    Fault(Fault),
    /// It would leave the limits of validity.
    Limit,
}

impl From<Fault> for Halt {
    fn from(fault: Fault) -> Halt {
        Halt::Fault(fault)
    }
}

/// How near the limit a run ends, as a share of the step.
const NEAR: f64 = 1e-9;

/// After a step of `h` seconds from `time` was refused by `first`: advances the model to the last time within its limits, by
/// halving, and gives that time; a step that fails for any other reason leaves the model as it was. `attempt` takes a step from
/// a time, or changes nothing.
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

    /// A clock that ends at 0.3 s is brought there; one that fails at every step stays where it is.
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
