//! Operating range as catalogues draw it: continuous operation up to the winding's temperature limit, short-term operation from a cold
//! start, and the limit by the supply voltage.

use crate::Answer;
use crate::choice::{Choice, Load, RPM, current_at_voltage, current_for_torque};
use crate::heating::duration;
use present::figure::{Axis, Figure};
use present::number;
use serde::Serialize;
use study::StudyError;
use study::bench::Bench;
use study::numeric::{linspace, try_root};
use study::steady::continuous_torque;

/// Speeds of the curves.
const SPEEDS: usize = 13;
/// Duration of short-term operation from a cold start, s, and its steps.
const SHORT: (f64, u32) = (60.0, 20);
/// Relative error of the short-term current squared.
const SQUARE_TOLERANCE: f64 = 1e-7;
/// Relative error of the no-load speed.
const SPEED_TOLERANCE: f64 = 1e-9;

/// Torques at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Speed, rad/s.
    pub speed: f64,
    /// Continuous torque, N.m; absent where friction alone makes the winding too hot, and where the voltage does not suffice.
    pub continuous: Option<f64>,
    /// Torque at the end of short-term operation from a cold start, N.m.
    pub short_term: Option<f64>,
    /// Torque of the cold motor at the supply voltage, N.m.
    pub voltage: f64,
}

/// The operating range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// No-load speed of the cold motor at the supply voltage, rad/s.
    pub no_load_speed: f64,
    /// Rows from standstill to the no-load speed.
    pub rows: Vec<Row>,
}

/// Values of a motor at which a first look is worth while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Suggestion {
    /// Continuous current at standstill, A.
    pub current: f64,
    /// Continuous torque at standstill, N.m.
    pub torque: f64,
}

/// The continuous torque at standstill.
///
/// # Errors
/// As of [`continuous_torque`].
pub fn suggestion(choice: &Choice) -> Result<Suggestion, StudyError> {
    let at_rest = Choice { speed: 0.0, ..choice.clone() };
    let found = continuous_torque(&at_rest.bench()?)?;
    Ok(Suggestion { current: found.current, torque: found.torque })
}

/// The motor in its cold state, started.
pub(crate) fn cold(choice: &Choice) -> Result<Bench, StudyError> {
    let mut bench = choice.bench()?;
    bench.start()?;
    Ok(bench)
}

/// Torque of the motor in its present state at a voltage and a speed, N.m.
pub(crate) fn torque_at_voltage(bench: &mut Bench, voltage: f64, speed: f64) -> Result<f64, StudyError> {
    bench.set("imposed_speed", speed)?;
    current_at_voltage(bench, voltage)?;
    bench.get("shaft_torque")
}

/// Speed at which the motor in its present state gives no torque, rad/s.
///
/// # Errors
/// A voltage that does not overcome friction.
pub(crate) fn no_load_speed(bench: &mut Bench, voltage: f64) -> Result<f64, StudyError> {
    let fastest = bench.entry("imposed_speed")?.row.max;
    let mut high = 1.0;
    while torque_at_voltage(bench, voltage, high)? > 0.0 && high < fastest {
        high = (2.0 * high).min(fastest);
    }
    let root = try_root(|w| torque_at_voltage(bench, voltage, w), 0.0, high, SPEED_TOLERANCE * high)?;
    root.filter(|w| *w > 0.0).ok_or_else(|| {
        StudyError::new(format!(
            "the supply voltage {voltage} V does not turn the motor: the torque at standstill is zero"
        ))
    })
}

/// Torque at the end of short-term operation: the constant current that brings the cold winding to its limit in that time.
fn short_term(choice: &Choice, speed: f64) -> Result<Option<f64>, StudyError> {
    let mut start = choice.bench()?;
    start.set("imposed_speed", speed)?;
    start.start()?;
    let limit = start.get("thermal.T_w_max")?;
    let (time, steps) = SHORT;
    let run = |square: f64| -> Result<Option<Bench>, StudyError> {
        let mut bench = start.clone();
        bench.set("current_command", square.sqrt())?;
        for _ in 0..steps {
            match bench.step(time / f64::from(steps)) {
                Ok(()) => {}
                Err(StudyError::Unsettled(_)) => return Ok(None),
                Err(error) => return Err(error),
            }
        }
        Ok(Some(bench))
    };
    let excess = |square: f64| -> Result<f64, StudyError> {
        run(square)?.map_or(Ok(f64::INFINITY), |mut b| Ok(b.get("winding_temperature")? - limit))
    };
    if excess(0.0)? >= 0.0 {
        return Ok(None);
    }
    let most = start.entry("current_command")?.row.max.powi(2);
    let mut high = 1e-4;
    while excess(high)? < 0.0 {
        if high >= most {
            return Ok(None);
        }
        high = (4.0 * high).min(most);
    }
    let square = try_root(excess, 0.25 * high, high, SQUARE_TOLERANCE * high)?;
    let end = square.map_or(Ok(None), run)?;
    end.map(|mut bench| bench.get("shaft_torque")).transpose()
}

/// Computes the range.
///
/// # Errors
/// One sentence: a value outside its limits, a voltage that does not turn the motor.
pub fn range(choice: &Choice) -> Result<Range, StudyError> {
    let mut bench = cold(choice)?;
    let no_load_speed = no_load_speed(&mut bench, choice.voltage)?;
    let mut rows = Vec::new();
    for speed in linspace(0.0, no_load_speed, SPEEDS) {
        let voltage = torque_at_voltage(&mut bench, choice.voltage, speed)?.max(0.0);
        let mut turning = choice.bench()?;
        turning.set("imposed_speed", speed)?;
        // Too hot without current: no continuous operation at this speed.
        let continuous = continuous_torque(&turning).ok().map(|c| c.torque);
        let positive = |torque: Option<f64>| torque.filter(|t| *t >= 0.0).map(|t| t.min(voltage));
        rows.push(Row {
            speed,
            continuous: positive(continuous),
            short_term: positive(short_term(choice, speed)?),
            voltage,
        });
    }
    Ok(Range { no_load_speed, rows })
}

/// Torque and speed of the chosen load, N.m and 1/min.
fn operating_point(choice: &Choice) -> Result<Option<(f64, f64)>, StudyError> {
    let mut bench = cold(choice)?;
    Ok(match choice.load {
        Load::Torque(torque) => current_for_torque(&mut bench, torque).ok().map(|_| (torque, choice.speed)),
        Load::Current(current) => {
            bench.set("current_command", current)?;
            Some((bench.get("shaft_torque")?, choice.speed))
        }
        Load::Gait(_) => None,
    })
}

/// Figure, sentences and values.
pub fn answer(choice: &Choice) -> Result<Answer, StudyError> {
    let found = range(choice)?;
    let curve = |torque: fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
        found.rows.iter().map(|row| (torque(row).unwrap_or(f64::NAN), row.speed / RPM)).collect()
    };
    let widest = found.rows.iter().filter_map(|r| r.short_term.or(r.continuous)).fold(0.0, f64::max);
    let mut figure = Figure::new(
        "Operating range",
        Axis::new("torque in N·m")
            .from_to(0.0, if widest > 0.0 { 1.15 * widest } else { found.rows[0].voltage }),
        Axis::new("speed in 1/min"),
    )
    .line("continuous operation", curve(|r| r.continuous))
    .line(&format!("{} from a cold start", duration(SHORT.0)), curve(|r| r.short_term))
    .dashed(&format!("{} V, cold motor", number(choice.voltage)), curve(|r| Some(r.voltage)));
    if let Some(point) = operating_point(choice)? {
        figure = figure.points("load", vec![point]);
    }
    let standstill = &found.rows[0];
    let torque = |t: Option<f64>| t.map_or("none".to_owned(), |t| format!("{} N·m", number(t)));
    let text = format!(
        "Torque at standstill at an ambient temperature of {} °C: continuous {}, for {} from a cold start {}. No-load speed at {} V: {} 1/min.",
        number(choice.ambient),
        torque(standstill.continuous),
        duration(SHORT.0),
        torque(standstill.short_term),
        number(choice.voltage),
        number(found.no_load_speed / RPM)
    );
    Ok(Answer::new(&figure, text, &found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::tests::choice;

    /// RE 40, 48 V: printed no-load speed 7580 rpm, stall torque 2.5 N.m within the resistance's and torque constant's rounding.
    #[test]
    fn range_of_a_catalogue_motor() {
        let mut choice = choice("maxon-re40-148877", Load::Torque(0.1));
        choice.voltage = 48.0;
        let found = range(&choice).unwrap();
        assert!((found.no_load_speed / RPM / 7580.0 - 1.0).abs() < 0.01, "{}", found.no_load_speed / RPM);
        let first = found.rows[0];
        assert!((first.voltage / (0.0603 * 48.0 / 1.13) - 1.0).abs() < 0.01, "{first:?}");
        let by_study = continuous_torque(&choice.bench().unwrap()).unwrap().torque;
        assert_eq!(first.continuous, Some(by_study));
        assert!(found.rows.iter().all(|r| r.short_term >= r.continuous), "{found:?}");
        assert!(found.rows.windows(2).all(|w| w[1].voltage < w[0].voltage));
        assert!(found.rows[SPEEDS - 1].voltage < 1e-6 * first.voltage);
    }
}
