//! Temperatures over time at a constant current or torque from a cold start, and the thermal steady state.

use crate::Answer;
use crate::choice::{Choice, Load, ZERO_CELSIUS, current_for_torque};
use present::figure::{Axis, Figure};
use present::number;
use present::words::sentence;
use serde::Serialize;
use study::StudyError;
use study::bench::Bench;
use study::numeric::try_root;

/// Points of the curves, and the fewest of a run that ends early.
const POINTS: u32 = 300;
const FEWEST: usize = 150;
/// Runs with shorter steps for a run that ends early.
const REPEATS: usize = 10;
/// Error of the time to the limit, s.
const TIME_TOLERANCE: f64 = 1e-6;

/// The course of the temperatures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Heating {
    /// Times, s.
    pub time: Vec<f64>,
    /// Indicated winding temperature, K.
    pub winding_temperature: Vec<f64>,
    /// Indicated housing temperature, K.
    pub housing_temperature: Vec<f64>,
    /// The winding's limit, K.
    pub limit: f64,
    /// Time at which the winding reaches it, s.
    pub time_to_limit: Option<f64>,
    /// Current at the end, A.
    pub current: f64,
    /// Torque at the end, N.m.
    pub shaft_torque: f64,
    /// The thermal steady state at a constant current, if there is one.
    pub steady: Option<Steady>,
    /// Why the run ended early, or why there is no steady state.
    pub note: Option<String>,
}

/// The thermal steady state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Steady {
    /// Winding, K.
    pub winding_temperature: f64,
    /// Housing, K.
    pub housing_temperature: f64,
    /// Torque at the shaft, N.m.
    pub shaft_torque: f64,
}

/// Sets the current that the load needs in the present state.
fn drive(bench: &mut Bench, load: &Load) -> Result<f64, StudyError> {
    match load {
        Load::Current(current) => bench.set("current_command", *current).map(|()| *current),
        Load::Torque(torque) => current_for_torque(bench, *torque),
        Load::Gait(_) => Err(StudyError::new("a gait is a load of the actuator")),
    }
}

/// Computes the course and the thermal steady state.
///
/// # Errors
/// One sentence: a value outside its limits, a torque that no current gives.
pub fn heating(choice: &Choice) -> Result<Heating, StudyError> {
    let duration = 60.0 * choice.minutes;
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(StudyError::new(format!(
            "the duration {} min must be positive and finite",
            choice.minutes
        )));
    }
    let (mut found, mut span) = (course(choice, duration)?, duration);
    // The steps of a long duration do not resolve a short overload.
    for _ in 0..REPEATS {
        if found.time.len() >= FEWEST {
            break;
        }
        span *= found.time.len() as f64 / f64::from(POINTS);
        found = course(choice, span)?;
    }
    if let Load::Current(_) = choice.load {
        let mut settled = choice.bench()?;
        drive(&mut settled, &choice.load)?;
        match settled.steady_state() {
            Ok(()) => {
                found.steady = Some(Steady {
                    winding_temperature: settled.get("winding_temperature")?,
                    housing_temperature: settled.get("housing_temperature")?,
                    shaft_torque: settled.get("shaft_torque")?,
                });
            }
            Err(StudyError::Unsettled(sentence)) => found.note = found.note.or(Some(sentence)),
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// The course from a cold start over `span`, s, or until the run ends.
fn course(choice: &Choice, span: f64) -> Result<Heating, StudyError> {
    let mut bench = choice.bench()?;
    bench.start()?;
    let mut found = Heating { limit: bench.get("thermal.T_w_max")?, ..Heating::default() };
    let step = span / f64::from(POINTS);
    found.current = drive(&mut bench, &choice.load)?;
    found.push(&mut bench)?;
    for _ in 0..POINTS {
        let before = bench.clone();
        let ended = match bench.step(step) {
            Err(StudyError::Unsettled(sentence)) => Some(sentence),
            done => done.map(|()| None)?,
        };
        let is_hot = ended.is_some() || bench.get("winding_temperature")? >= found.limit;
        if found.time_to_limit.is_none() && is_hot {
            let excess = |h: f64| excess_after(&before, h, found.limit);
            found.time_to_limit = try_root(excess, 0.0, step, TIME_TOLERANCE)?.map(|h| before.time() + h);
        }
        if let Some(limit) = ended {
            found.note = Some(format!("The run ends after {}: {limit}", duration(before.time())));
            break;
        }
        found.current = drive(&mut bench, &choice.load)?;
        found.push(&mut bench)?;
    }
    found.shaft_torque = bench.get("shaft_torque")?;
    Ok(found)
}

/// Winding temperature less the limit after `h` seconds, K; infinite beyond the limits of validity.
fn excess_after(bench: &Bench, h: f64, limit: f64) -> Result<f64, StudyError> {
    let mut part = bench.clone();
    match if h > 0.0 { part.step(h) } else { Ok(()) } {
        Ok(()) => Ok(part.get("winding_temperature")? - limit),
        Err(StudyError::Unsettled(_)) => Ok(f64::INFINITY),
        Err(error) => Err(error),
    }
}

impl Heating {
    fn push(&mut self, bench: &mut Bench) -> Result<(), StudyError> {
        self.time.push(bench.time());
        self.winding_temperature.push(bench.get("winding_temperature")?);
        self.housing_temperature.push(bench.get("housing_temperature")?);
        Ok(())
    }

    fn curve(&self, temperatures: &[f64]) -> Vec<(f64, f64)> {
        self.time.iter().zip(temperatures).map(|(t, k)| (*t, k - ZERO_CELSIUS)).collect()
    }
}

/// Time in the unit that suits its size.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{} s", number(s)),
        s if s < 7200.0 => format!("{} min", number(s / 60.0)),
        s => format!("{} h", number(s / 3600.0)),
    }
}

/// Figure, sentences and values.
pub fn answer(choice: &Choice) -> Result<Answer, StudyError> {
    let found = heating(choice)?;
    let limit = found.limit - ZERO_CELSIUS;
    let mut figure =
        Figure::new("Temperatures from a cold start", Axis::time(), Axis::new("temperature in °C"))
            .line("winding", found.curve(&found.winding_temperature))
            .line("housing", found.curve(&found.housing_temperature))
            .limit(limit, &format!("limit {} °C", number(limit)));
    let mut text = match found.time_to_limit {
        Some(time) => {
            figure = figure.note(time, &duration(time));
            format!("The winding reaches its limit of {} °C after {}.", number(limit), duration(time))
        }
        None => format!(
            "After {} the winding is at {} °C, {} K below its limit.",
            duration(*found.time.last().unwrap_or(&0.0)),
            number(found.winding_temperature.last().unwrap_or(&f64::NAN) - ZERO_CELSIUS),
            number(found.limit - found.winding_temperature.last().unwrap_or(&f64::NAN))
        ),
    };
    text += &format!(
        " Current {} A, torque {} N·m at the end.",
        number(found.current),
        number(found.shaft_torque)
    );
    match (&found.steady, &found.note) {
        (Some(steady), _) => {
            text += &format!(
                " Thermal steady state: winding {} °C, housing {} °C, torque {} N·m.",
                number(steady.winding_temperature - ZERO_CELSIUS),
                number(steady.housing_temperature - ZERO_CELSIUS),
                number(steady.shaft_torque)
            );
        }
        (None, Some(note)) => text += &format!(" {}.", sentence(note.trim_end_matches('.'))),
        (None, None) => {}
    }
    Ok(Answer::new(&figure, text, &found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::tests::choice;

    /// At the continuous current of `motor-fmu steady` the winding ends at its limit; above it reaches the limit in finite time.
    #[test]
    fn the_continuous_current_ends_at_the_limit() {
        let at_rest = choice("maxon-305015", Load::Current(0.0));
        let continuous = study::steady::continuous_torque(&at_rest.bench().unwrap()).unwrap();
        let at = |current: f64| heating(&choice("maxon-305015", Load::Current(current))).unwrap();
        let found = at(continuous.current);
        assert!((found.steady.unwrap().winding_temperature - 428.15).abs() < 1e-3, "{found:?}");
        assert!(found.time_to_limit.is_none());
        let hot = at(2.0 * continuous.current);
        let time = hot.time_to_limit.unwrap();
        assert!(hot.steady.is_none() && hot.note.is_some() && time > 0.0 && time < 1800.0, "{hot:?}");
        // The limit is reached and passed within the first step: adiabatic, C_w dT = R_mean I^2 dt.
        let (current, c_w) =
            (200.0, choice("maxon-305015", Load::Current(0.0)).bench().unwrap().get("thermal.C_w").unwrap());
        let r_mean = 0.386 * 0.0039 * 130.0 / (1.0_f64 + 0.0039 * 130.0).ln();
        let expected = c_w * 130.0 / (r_mean * current * current);
        let short = at(current);
        let time = short.time_to_limit.unwrap();
        assert!((time / expected - 1.0).abs() < 0.05, "{time} s, {expected} s");
        // The rise within a part of the first step of the whole duration is resolved.
        assert!(
            short.time.len() >= FEWEST && short.time.windows(2).all(|t| t[1] - t[0] < 0.02 * time),
            "{}",
            short.time.len()
        );
        assert!(short.note.unwrap().starts_with("The run ends after "));
    }

    /// A constant torque needs more current as the magnets warm.
    #[test]
    fn a_constant_torque_is_kept() {
        let found = heating(&choice("maxon-305015", Load::Torque(0.1))).unwrap();
        assert!((found.shaft_torque - 0.1).abs() < 1e-9, "{}", found.shaft_torque);
        assert!(found.current > 1.01 * 0.1 / 0.0276, "{}", found.current);
    }
}
