//! The native gearmotor in the paper's runs.

use super::Parts;
use super::published::{DURATION, DUTIES, SUPPLY, T_ROOM};
use crate::StudyError;
use crate::bench::Bench;
use describe::Preset;
use serde::Serialize;

/// The model that the paper is about.
const MODEL: &str = "BrushedGearmotor";
/// Its preset.
const PRESET: &str = "bdcm-37d";
/// Heat capacity of motor and gear in the box, J/K: an estimate (audit, default parameters).
pub const BOX_CAPACITY: f64 = 95.0;
/// Step of a run, s, and how many steps make a point of a figure.
const STEP: f64 = 0.5;
const STEPS_PER_POINT: usize = 10;

/// A run at one duty.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Duty, percent.
    pub duty_percent: f64,
    /// Its end.
    #[serde(flatten)]
    pub end: Sample,
    /// The course of the run, for the figures.
    #[serde(skip)]
    pub course: Vec<Sample>,
}

/// A moment of a run.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(non_snake_case)] // units in the keys
pub struct Sample {
    /// Terms of the voltage, V.
    pub voltage: Parts,
    /// Current, A.
    pub current_A: f64,
    /// Terms of the power, W.
    pub power: Parts,
    /// Terms of the work since the start, J.
    pub work: Parts,
    /// Speed at the output shaft, rad/s.
    pub shaft_speed_rad_per_s: f64,
    /// Time, s.
    #[serde(skip)]
    pub time: f64,
    /// Winding temperature, degC.
    #[serde(skip)]
    pub temperature: f64,
    /// Torque that the current makes at the output shaft, N.m: mechanical power over speed.
    #[serde(skip)]
    pub torque: f64,
}

/// The five runs of 900 s from the ambient temperature.
///
/// # Errors
/// A model that refuses a value or fails.
pub fn runs() -> Result<Vec<Run>, StudyError> {
    let bench = Bench::new(MODEL, Some(&Preset::load(PRESET)?))?;
    DUTIES.iter().map(|duty| run(bench.clone(), *duty)).collect()
}

fn run(mut bench: Bench, duty: f64) -> Result<Run, StudyError> {
    bench.set("duty", duty / 100.0)?;
    bench.set("supply_voltage", SUPPLY)?;
    bench.set("ambient_temperature", T_ROOM + 273.15)?;
    bench.start()?;
    let mut course = Vec::new();
    let steps = (DURATION / STEP).round() as usize;
    for k in 1..=steps {
        bench.step(STEP)?;
        if k % STEPS_PER_POINT == 0 || k == steps {
            course.push(sample(&mut bench)?);
        }
    }
    Ok(Run { duty_percent: duty, end: sample(&mut bench)?, course })
}

fn sample(bench: &mut Bench) -> Result<Sample, StudyError> {
    let power = parts(bench, "power")?;
    let speed = bench.get("shaft_speed")?;
    Ok(Sample {
        time: bench.time(),
        voltage: parts(bench, "voltage")?,
        current_A: bench.get("current")?,
        power,
        work: parts(bench, "work")?,
        shaft_speed_rad_per_s: speed,
        temperature: bench.get("winding_temperature")? - 273.15,
        torque: if speed.abs() > 1e-6 { power.mechanical / speed } else { 0.0 },
    })
}

fn parts(bench: &mut Bench, quantity: &str) -> Result<Parts, StudyError> {
    let mut part = |name: &str| bench.get(&format!("{quantity}_{name}"));
    Ok(Parts {
        electrical: part("electrical")?,
        magnetic: part("magnetic")?,
        mechanical: part("mechanical")?,
        total: part("total")?,
    })
}
