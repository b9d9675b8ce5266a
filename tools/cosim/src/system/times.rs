//! Start, stop and communication steps of a run: those of the caller, else those of the file, else those of the FMUs.
use super::parts::Parts;
use super::structure::Time;
use crate::grid::{Grid, START, STEP, STOP, is_too_short};
use crate::{Error, number};

/// Ratios that differ from a whole number by less are whole.
///
/// *Numerical*: decimal fractions such as 0.001 have rounding errors of 1e-16.
const WHOLE: f64 = 1e-9;

/// The times that a caller gives (s).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    pub(crate) start: Option<f64>,
    pub(crate) stop: Option<f64>,
    pub(crate) step: Option<f64>,
}

/// The communication points of a run. `rigid` names a component that cannot vary its step.
///
/// # Errors
/// Times that contradict each other; with file and line where the wrong one is of the file.
pub(crate) fn grid(parts: Parts, asked: Times, rigid: Option<&str>) -> Result<Grid, Error> {
    let structure = parts.structure;
    let time = |asked: Option<f64>, own: &Option<Time>| asked.or(own.as_ref().map(|time| time.seconds));
    let start = time(asked.start, &structure.start).unwrap_or(0.0);
    let stop = time(asked.stop, &structure.stop).unwrap_or(start + 1.0);
    let proposed = parts.archives.iter().filter_map(|a| a.description().default_experiment.step);
    let step = time(asked.step, &structure.step).or(proposed.reduce(f64::min));
    Grid::new(start, stop, step, |span| span / 500.0, rigid).map_err(|error| {
        let Error::Option { option, .. } = error else { return error };
        let places = [
            (START, asked.start, &structure.start),
            (STOP, asked.stop, &structure.stop),
            (STEP, asked.step, &structure.step),
        ];
        let of_file = places.into_iter().find(|(name, asked, _)| *name == option && asked.is_none());
        match of_file.and_then(|(.., own)| own.as_ref()) {
            Some(own) => own.place.fault(error.to_string()),
            None => error,
        }
    })
}

/// The step of a component divides that of the system, if this is fixed.
///
/// # Errors
/// A step of a component that does not, with its place in the file.
pub(crate) fn check_component_steps(parts: Parts, grid: &Grid, is_fixed: bool) -> Result<(), Error> {
    for component in &parts.structure.components {
        let Some(Time { seconds, place }) = &component.step else { continue };
        let (own, text) = (*seconds, number(*seconds));
        let fault =
            |what: String| place.fault(format!("component {}: its step {text} s {what}", component.name));
        if !(own > 0.0 && own.is_finite()) {
            return Err(fault("must be finite and above 0 s".to_owned()));
        }
        let span = grid.stop - grid.start;
        if is_too_short(own, span) {
            return Err(fault(format!("is too small for a span of {} s", number(span))));
        }
        let ratio = grid.step / own;
        let divides = ratio >= 1.0 - WHOLE && (ratio - ratio.round()).abs() <= WHOLE * ratio;
        if is_fixed && !divides {
            return Err(fault(format!("does not divide the communication step {} s", number(grid.step))));
        }
    }
    Ok(())
}
