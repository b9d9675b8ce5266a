//! The native model in the thesis's rig.

use super::measured::{CASES, Case, POWER};
use crate::StudyError;
use crate::bench::Bench;
use crate::fit::{Observation, Problem};
use crate::steady::Setup;
use describe::Preset;

/// The model that the thesis is about.
const MODEL: &str = "AnnulusCooledMotor";
/// Its preset for the thesis's rig.
const PRESET: &str = "thesis-rig";

/// Parameters that the eight tests are fitted with.
pub const FITTED: [&str; 6] = [
    "housing.emissivity",
    "annulus.leak_area",
    "annulus.factor_push",
    "annulus.factor_pull",
    "fan.turbulence_factor",
    "fan.decay",
];

/// Settings of the model for a test; with `calibrated` from the preset of the rig.
fn setup(case: &Case, calibrated: bool) -> Result<Setup, StudyError> {
    let preset = calibrated.then(|| Preset::load(PRESET)).transpose()?;
    let (power, ambient) = (POWER.to_string(), case.ambient().to_string());
    let setting = case.setting.map(|(name, value)| (name, value.to_string()));
    let mut sets = vec![
        ("electrical_power", power.as_str()),
        ("cooling_mode", case.cooling_mode),
        ("ambient_temperature", &ambient),
    ];
    sets.extend((case.cooling_mode != "bare").then_some(("fan_command", "1")));
    sets.extend(setting.iter().map(|(name, value)| (*name, value.as_str())));
    Ok(Setup::new(MODEL, preset, &sets))
}

/// The model's steady winding temperature in a test, K.
///
/// # Errors
/// A model that refuses a value or does not settle.
pub fn winding(case: &Case, calibrated: bool) -> Result<f64, StudyError> {
    let mut bench = setup(case, calibrated)?.bench()?;
    bench.steady_state()?;
    bench.get("winding_temperature")
}

/// An output of a test over time from the ambient on, at the rig's preset: times, s, and values.
///
/// # Errors
/// As [`winding`].
pub fn course(
    case: &Case,
    output: &str,
    duration: f64,
    points: usize,
) -> Result<Vec<(f64, f64)>, StudyError> {
    let mut bench = setup(case, true)?.bench()?;
    bench.start()?;
    let mut course = vec![(0.0, bench.get(output)?)];
    for _ in 0..points {
        bench.step(duration / points as f64)?;
        course.push((bench.time(), bench.get(output)?));
    }
    Ok(course)
}

/// Winding temperature over the outer diameter of a pushed annulus, K; `None` if it cannot be computed.
pub fn winding_at(outer_diameter: f64, calibrated: bool) -> Option<f64> {
    let push = CASES.iter().find(|c| c.cooling_mode == "annulus_push")?;
    winding(&Case { setting: Some(("annulus.outer_diameter", outer_diameter)), ..*push }, calibrated).ok()
}

/// The fit of these parameters to the eight measured winding temperatures, from the declared values on.
///
/// # Errors
/// A parameter that the model does not have, or a model that does not settle at the start.
pub fn fit_thesis_rig(parameters: &[&str]) -> Result<Problem, StudyError> {
    let bench = Bench::new(MODEL, None)?;
    let observation = |case: &Case| {
        let mut setup = setup(case, true)?;
        // Fitted parameters start at their declared values; measured parameters keep the values of the preset.
        for name in FITTED.iter().chain(parameters) {
            setup.sets.push(((*name).to_owned(), bench.entry(name)?.row.start.to_string()));
        }
        let (name, output) = (case.name.to_owned(), "winding_temperature");
        Ok(Observation { name, setup, output, measured: case.t_w })
    };
    Problem::new(parameters, CASES.iter().map(observation).collect::<Result<_, StudyError>>()?)
}
