//! The native model in the thesis's rig.

use super::measured::{CASES, Case, POWER};
use crate::StudyError;
use crate::bench::Bench;
use crate::fit::{Observation, Problem};
use crate::steady::{Setup, Steady, steady};
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

/// The native model, as far as available: missing parts are reported and omitted, and are not errors.
pub struct Native {
    preset: Result<Preset, String>,
    missing: Vec<String>,
}

impl Native {
    /// Looks for the model's modes and its preset.
    pub fn find() -> Native {
        let preset = Preset::load(PRESET).map_err(|e| e.to_string());
        let missing = match Bench::new(MODEL, None) {
            Ok(bench) => CASES
                .iter()
                .map(|c| c.cooling_mode)
                .filter(|mode| !bench.knows("cooling_mode", Some(mode)))
                .map(str::to_owned)
                .collect(),
            Err(error) => vec![error.to_string()],
        };
        Native { preset, missing }
    }

    /// Reasons for omitted results.
    pub fn absent(&self) -> Option<String> {
        if !self.missing.is_empty() {
            let mut modes = self.missing.clone();
            modes.dedup();
            return Some(format!("{MODEL} has no cooling_mode {}", modes.join(", ")));
        }
        self.preset.as_ref().err().cloned()
    }

    /// Settings of the model for a test; with `calibrated` from the preset of the rig.
    fn setup(&self, case: &Case, calibrated: bool) -> Option<Setup> {
        let preset = if calibrated { Some(self.preset.clone().ok()?) } else { None };
        if !self.missing.is_empty() {
            return None;
        }
        let mut sets = vec![
            ("electrical_power".to_owned(), POWER.to_string()),
            ("cooling_mode".to_owned(), case.cooling_mode.to_owned()),
            ("ambient_temperature".to_owned(), case.ambient().to_string()),
        ];
        if case.cooling_mode != "bare" {
            sets.push(("fan_command".to_owned(), "1".to_owned()));
        }
        sets.extend(case.setting.map(|(name, value)| (name.to_owned(), value.to_string())));
        Some(Setup { model: MODEL.to_owned(), preset, sets })
    }

    /// The model's steady state in a test, where it can be computed.
    ///
    /// # Errors
    /// A model that refuses a value or does not settle.
    pub fn steady(&self, case: &Case, calibrated: bool) -> Result<Option<Steady>, StudyError> {
        self.setup(case, calibrated).map(|setup| steady(&mut setup.bench()?)).transpose()
    }

    /// An output of a test over time from the ambient on, at the rig's preset: times, s, and values.
    pub fn course(&self, case: &Case, output: &str, duration: f64, points: usize) -> Option<Vec<(f64, f64)>> {
        let mut bench = self.setup(case, true)?.bench().ok()?;
        bench.start().ok()?;
        let mut course = vec![(0.0, bench.get(output).ok()?)];
        for _ in 0..points {
            bench.step(duration / points as f64).ok()?;
            course.push((bench.time(), bench.get(output).ok()?));
        }
        Some(course)
    }

    /// Winding temperature over the outer diameter of a pushed annulus, K; `None` if it cannot be computed.
    pub fn winding_at(&self, outer_diameter: f64, calibrated: bool) -> Option<f64> {
        let push = CASES.iter().find(|c| c.cooling_mode == "annulus_push")?;
        let case = Case { setting: Some(("annulus.outer_diameter", outer_diameter)), ..*push };
        self.steady(&case, calibrated).ok()??.get("winding_temperature")
    }
}

/// The fit of these parameters to the eight measured winding temperatures, from the declared values on. Nothing where the
/// model is not there.
pub fn fit_thesis_rig(native: &Native, parameters: &[&str]) -> Option<Result<Problem, StudyError>> {
    let bench = Bench::new(MODEL, None).ok()?;
    let observation = |case: &Case| {
        let mut setup = native.setup(case, true)?;
        // Fitted parameters start at their declared values; measured parameters keep the values of the preset.
        for name in FITTED.iter().chain(parameters) {
            let row = bench.entry(name).ok()?.row;
            setup.sets.push(((*name).to_owned(), row.start.to_string()));
        }
        Some(Observation {
            name: case.name.to_owned(),
            setup,
            output: "winding_temperature",
            measured: case.t_w,
        })
    };
    let observations: Option<Vec<Observation>> = CASES.iter().map(observation).collect();
    Some(Problem::new(parameters, observations?))
}
