//! The paper: a brushed gearmotor driven by PWM (sections 2 and 3).

mod native;
pub mod published;
mod rows;

pub use native::{Run, Sample, runs};

use super::{Row, significant};
use crate::StudyError;
use crate::numeric::Line;
use published::{CURRENT, DURATION, DUTIES, L_A, R_A, SUPPLY, T_ROOM};
use serde::Serialize;

/// Voltage of the mechanical term at full duty, V, as printed in section 3.2.1.
const V_MECHANICAL: f64 = 8.132;
/// Slope of voltage over duty, V per percent, as printed in section 3.2.1.
const V_SLOPE: f64 = 91.62e-3;
/// Slope of current over duty, A per percent, as printed in section 3.2.2.
const I_SLOPE: f64 = 1.04e-3;
/// Winding temperature up to 40 % and from 60 % on, degC, as printed in section 3.2.3.
const PLATEAUS: (f64, f64) = (31.85, 37.74);

/// A quantity and its parts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// In the resistance.
    pub electrical: f64,
    /// In the inductance.
    pub magnetic: f64,
    /// Against the counter-electromotive force.
    pub mechanical: f64,
    /// All together.
    pub total: f64,
}

impl Parts {
    fn of(electrical: f64, magnetic: f64, mechanical: f64) -> Parts {
        Parts { electrical, magnetic, mechanical, total: electrical + magnetic + mechanical }
    }
}

/// Slopes over duty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Slopes {
    /// Voltage, mV per percent.
    pub voltage_mV_per_percent: f64,
    /// Current, mA per percent.
    pub current_mA_per_percent: f64,
    /// Share of the variance of the voltage that the line explains.
    pub voltage_r2: f64,
    /// Share of the variance of the current that the line explains.
    pub current_r2: f64,
    /// Which voltages and currents: those of the native model, or the printed lines.
    pub of: &'static str,
}

/// The temperatures, which no consistent model explains.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Temperatures {
    /// Printed plateaus, degC: up to 40 %, from 60 % on.
    pub plateaus_degC: (f64, f64),
    /// Power by the consistent voltage and current at each duty, W.
    pub power_W: Vec<f64>,
    /// Measured less the line T = a + b P of least squares, K, at each duty.
    pub residuals_K: Vec<f64>,
    /// Rise of a truly adiabatic box of 95 J/K by the work at full duty, K.
    pub adiabatic_rise_K: f64,
    /// Winding temperature of the native model after 900 s at each duty, degC, each run from the room's.
    pub simulated_degC: Option<Vec<f64>>,
    /// What follows.
    pub finding: String,
}

/// What the paper measured at one duty: the point of its printed lines, and the plateau.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // units in the keys
pub struct Measured {
    /// Duty, percent.
    pub duty_percent: f64,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Voltage of the supply, V.
    pub supply_V: f64,
    /// Temperature of the room, degC.
    pub room_degC: f64,
    /// Voltage at the motor, V.
    pub voltage_V: f64,
    /// Current, A.
    pub current_A: f64,
    /// Temperature of the motor at the end, degC.
    pub temperature_degC: f64,
}

/// Everything about the paper.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Paper {
    /// The five runs as measured.
    pub measured: Vec<Measured>,
    /// Terms of the voltage at full duty, consistent, V.
    pub voltage: Parts,
    /// Current at full duty, A.
    pub current_A: f64,
    /// Power at full duty, V I, W.
    pub power: Parts,
    /// Work over 900 s at full duty, J.
    pub work: Parts,
    /// Slopes over duty.
    pub slopes: Option<Slopes>,
    /// Temperatures.
    pub temperatures: Temperatures,
    /// The native model's runs.
    pub simulated: Option<Vec<Run>>,
    /// Every printed number.
    pub rows: Vec<Row>,
    /// What holds and what does not.
    pub conclusion: String,
    /// Why the native model is not there, where it is not.
    pub absent: Option<String>,
}

/// Recomputes the paper.
///
/// # Errors
/// A native model that refuses a value or fails.
pub fn paper() -> Result<Paper, StudyError> {
    let simulated = runs()?;
    let voltage = Parts::of(R_A * CURRENT, 0.0, V_MECHANICAL);
    let power = Parts::of(voltage.electrical * CURRENT, 0.0, voltage.mechanical * CURRENT);
    let work =
        Parts::of(power.electrical * DURATION, 0.5 * L_A * CURRENT * CURRENT, power.mechanical * DURATION);
    let temperatures = temperatures(&simulated, &work);
    let mut rows = rows::rows(&voltage, &power, &work, &temperatures, simulated.as_deref().ok());
    rows.sort_by_key(|row| row.id);
    let misprints = rows.iter().filter(|r| r.verdict == super::Verdict::UnitError).count();
    let conclusion = format!(
        "At full duty {} V = {} V in the resistance + {} V against the counter-electromotive force, {} A and {} W are \
         consistent; {misprints} numbers and equations have the wrong unit, among them all works; the mechanical part is \
         friction, for no load was on the shaft; {}",
        significant(voltage.total),
        significant(voltage.electrical),
        significant(voltage.mechanical),
        significant(CURRENT),
        significant(power.total),
        temperatures.finding
    );
    Ok(Paper {
        measured: DUTIES.map(measured).to_vec(),
        voltage,
        current_A: CURRENT,
        power,
        work,
        slopes: slopes(&simulated),
        temperatures,
        rows,
        conclusion,
        absent: simulated.as_ref().err().cloned(),
        simulated: simulated.ok(),
    })
}

/// Voltage and current at a duty, by the printed lines through the point at full duty.
fn on_the_lines(duty: f64) -> (f64, f64) {
    let below = duty - 100.0;
    (R_A * CURRENT + V_MECHANICAL + V_SLOPE * below, CURRENT + I_SLOPE * below)
}

/// The plateau at a duty, degC.
fn plateau(duty: f64) -> f64 {
    if duty <= 40.0 { PLATEAUS.0 } else { PLATEAUS.1 }
}

fn measured(duty: f64) -> Measured {
    let (voltage, current) = on_the_lines(duty);
    Measured {
        duty_percent: duty,
        duration_s: DURATION,
        supply_V: SUPPLY,
        room_degC: T_ROOM,
        voltage_V: voltage,
        current_A: current,
        temperature_degC: plateau(duty),
    }
}

fn slopes(simulated: &Result<Vec<Run>, String>) -> Option<Slopes> {
    let (points, of): (Vec<(f64, f64, f64)>, _) = match simulated {
        Ok(runs) => {
            (runs.iter().map(|r| (r.duty_percent, r.voltage.total, r.current_A)).collect(), "simulated")
        }
        Err(_) => {
            let point = |duty: f64| (duty, on_the_lines(duty).0, on_the_lines(duty).1);
            (DUTIES.map(point).to_vec(), "printed lines")
        }
    };
    let line = |f: &dyn Fn(&(f64, f64, f64)) -> f64| {
        Line::through(&points.iter().map(|p| (p.0, f(p))).collect::<Vec<_>>())
    };
    let (voltage, current) = (line(&|p| p.1)?, line(&|p| p.2)?);
    Some(Slopes {
        voltage_mV_per_percent: 1e3 * voltage.slope,
        current_mA_per_percent: 1e3 * current.slope,
        voltage_r2: voltage.r2,
        current_r2: current.r2,
        of,
    })
}

fn temperatures(simulated: &Result<Vec<Run>, String>, work: &Parts) -> Temperatures {
    let power_at = |duty: f64| on_the_lines(duty).0 * on_the_lines(duty).1;
    let points = DUTIES.map(|duty| (power_at(duty), plateau(duty)));
    let line = Line::through(&points);
    let residuals: Vec<f64> = points.iter().map(|p| p.1 - line.map_or(f64::NAN, |l| l.at(p.0))).collect();
    let worst = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let adiabatic = work.total / native::BOX_CAPACITY;
    let ratio = points[4].0 / points[0].0;
    let finding = format!(
        "heating power rises {ratio:.1} times from 20 to 100 % while the winding is said to have two temperatures, \
         {} and {} degC; the best line in power misses them by up to {worst:.1} K, and an adiabatic box of {} J/K \
         has no plateau but a rise of {adiabatic:.1} K in 900 s.",
        PLATEAUS.0,
        PLATEAUS.1,
        native::BOX_CAPACITY
    );
    Temperatures {
        plateaus_degC: PLATEAUS,
        power_W: points.iter().map(|p| p.0).collect(),
        residuals_K: residuals,
        adiabatic_rise_K: adiabatic,
        simulated_degC: simulated.as_ref().ok().map(|runs| runs.iter().map(Run::final_temperature).collect()),
        finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, by: f64) {
        assert!((value - expected).abs() <= by, "{value} instead of {expected}");
    }

    /// The audit: P06 to P13, P28, P30, P31.
    #[test]
    fn the_paper_comes_out() {
        let paper = paper().unwrap();
        near(paper.voltage.total, 9.788, 1e-12);
        near(paper.power.total, 1.7618, 1e-4);
        near(paper.power.mechanical, 1.4638, 1e-4);
        near(paper.work.total, 1585.6, 0.1);
        near(paper.work.magnetic, 29.21e-6, 1e-8);
        for (power, expected) in paper.temperatures.power_W.iter().zip([0.24, 0.50, 0.85, 1.27, 1.76]) {
            near(*power, expected, 6e-3);
        }
        for (residual, expected) in paper.temperatures.residuals_K.iter().zip([-0.5, -1.7, 2.7, 0.8, -1.4]) {
            near(*residual, expected, 0.06);
        }
        near(paper.temperatures.adiabatic_rise_K, 16.7, 0.05);
    }
}
