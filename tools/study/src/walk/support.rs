//! The greatest support that can be given continuously.
//!
//! A support serves where the winding stays below its limit and the actuator follows the torque. More support makes the winding hotter.
//! The torque error is compared with a fraction of the torque, so that an actuator of large inertia serves only from some
//! support on. The search therefore brackets the greatest support between one that serves and one that is too much:
//!
//! ```text
//! 0 ... too little ... serves ... greatest support ... too much
//! ```

use super::cycle::{Done, Near, steady};
use super::load::Load;
use super::periodic::Periodic;
use crate::StudyError;
use crate::numeric::try_root_between;
use crate::reproduce::significant;
use serde::Serialize;

/// Width of the bracket about the support at which the search ends.
const SUPPORT_TOLERANCE: f64 = 1e-5;
/// First support that is tried; doubled while it is too little or can be given continuously.
const FIRST_SUPPORT: f64 = 0.25;
/// Trials between a support that is too little and one that is too much.
const TRIALS: usize = 8;
/// The actuator follows a torque while the rms error is below this fraction of the peak torque, plus so many N.m.
const FOLLOWED: (f64, f64) = (0.05, 0.5);
/// Weight of a tracking error beyond that, K/(N.m), in the search.
const KELVINS: f64 = 100.0;
/// How near its limit a temperature counts as limiting, K.
const NEAR: f64 = 0.5;
/// Fraction of the search that a trial leaves, about.
const LEFT: f64 = 0.85;

impl Periodic {
    /// How far the torque error is above what counts as followed, N.m; negative where it is below.
    fn lag(&self) -> f64 {
        self.torque_error_rms - FOLLOWED.0 * self.joint_torque_peak - FOLLOWED.1
    }
}

/// What limits the continuous support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The winding is at its limit.
    WindingTemperature,
    /// With more support the losses grow faster than the heat flow: no steady state.
    ThermalRunaway,
    /// The actuator no longer follows the torque, for its limits of current and supply voltage.
    TorqueError,
    /// The upper limit of the factor of the load.
    SupportMaximum,
}

impl Limit {
    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Limit::WindingTemperature => "winding temperature",
            Limit::ThermalRunaway => "thermal runaway",
            Limit::TorqueError => "torque error (current or supply voltage limit)",
            Limit::SupportMaximum => "upper limit of the factor",
        }
    }
}

/// The greatest support that can be given continuously.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Continuous {
    /// Fraction of the biological torque.
    pub support: f64,
    /// The periodic steady state there.
    pub at: Periodic,
    /// What limits it.
    pub limited_by: Limit,
}

/// What a support comes to.
#[derive(Clone, Copy, Debug)]
enum Trial {
    /// No steady state.
    Runaway,
    /// The periodic steady state.
    Steady(Periodic),
}

impl Trial {
    /// The larger of the rise over the limit of the winding, K, and of the weighted torque error; positive where the support does
    /// not serve.
    fn excess(&self, limit: f64) -> f64 {
        match self {
            Trial::Runaway => f64::INFINITY,
            Trial::Steady(at) => (at.winding_temperature - limit).max(KELVINS * at.lag()),
        }
    }

    /// Whether only the torque error is too large: more support may serve.
    fn only_lags(&self, limit: f64) -> bool {
        matches!(self, Trial::Steady(at) if at.winding_temperature < limit && at.lag() >= 0.0)
    }

    /// Why the support does not serve.
    fn reason(&self, limit: f64) -> String {
        match self {
            Trial::Runaway => "the winding has no steady state (thermal runaway)".to_owned(),
            Trial::Steady(at) if at.winding_temperature >= limit => format!(
                "the winding reaches {} degC, its limit is {} degC",
                significant(at.winding_temperature - 273.15),
                significant(limit - 273.15)
            ),
            Trial::Steady(at) => format!(
                "the actuator does not follow the joint: torque error {} N.m rms with a peak torque of {} N.m; {} N.m + {} % of the \
                 peak count as followed",
                significant(at.torque_error_rms),
                significant(at.joint_torque_peak),
                FOLLOWED.1,
                100.0 * FOLLOWED.0
            ),
        }
    }
}

/// A support that serves, and one above it that is too much, each with its excess; the second is missing where the greatest factor of
/// the load serves.
struct Bracket {
    serves: (f64, f64),
    too_much: Option<(f64, f64)>,
}

/// The trials of a search.
struct Search<'a> {
    load: &'a Load,
    limit: f64,
    /// The last steady state is near the next.
    warm: Option<Near>,
    /// The greatest support that serves.
    found: Option<(f64, Periodic)>,
    left: f64,
    done: Done<'a>,
}

impl Search<'_> {
    fn trial(&mut self, support: f64) -> Result<Trial, StudyError> {
        (self.done)(1.0 - self.left);
        self.left *= LEFT;
        let mut load = self.load.clone();
        load.set_support(support)?;
        match steady(&load.walker()?, self.warm.as_ref()) {
            Ok((at, near)) => {
                self.warm = Some(near);
                let trial = Trial::Steady(at);
                // The search ends 1e-5 of support, a hundredth of a kelvin, from the limits.
                if trial.excess(self.limit) <= 0.0 && self.found.is_none_or(|(best, _)| support > best) {
                    self.found = Some((support, at));
                }
                Ok(trial)
            }
            Err(StudyError::Unsettled(_)) => Ok(Trial::Runaway),
            Err(other) => Err(other),
        }
    }

    /// The bracket of the greatest support up to `most`, the greatest factor of the load.
    fn bracket(&mut self, most: f64) -> Result<Bracket, StudyError> {
        let idle = self.trial(0.0)?;
        let (mut low, mut trial) = (0.0, idle);
        while low < most && (trial.only_lags(self.limit) || trial.excess(self.limit) < 0.0) {
            let high = if low == 0.0 { FIRST_SUPPORT } else { 2.0 * low }.min(most);
            let next = self.trial(high)?;
            let (below, above) = (trial.excess(self.limit), next.excess(self.limit));
            if below < 0.0 && above >= 0.0 {
                return Ok(Bracket { serves: (low, below), too_much: Some((high, above)) });
            }
            if above >= 0.0 && !next.only_lags(self.limit) {
                return self.between(low, (high, above))?.ok_or_else(|| self.none(&idle, &next, high));
            }
            (low, trial) = (high, next);
        }
        match trial.excess(self.limit) {
            excess if excess < 0.0 => Ok(Bracket { serves: (low, excess), too_much: None }),
            _ => Err(self.none(&idle, &trial, low)),
        }
    }

    /// The bracket between a support that is too little and one that is too much, with its excess, by bisection; `None` where no
    /// support in between serves.
    fn between(
        &mut self,
        mut too_little: f64,
        mut too_much: (f64, f64),
    ) -> Result<Option<Bracket>, StudyError> {
        for _ in 0..TRIALS {
            let middle = 0.5 * (too_little + too_much.0);
            let trial = self.trial(middle)?;
            let excess = trial.excess(self.limit);
            if excess < 0.0 {
                return Ok(Some(Bracket { serves: (middle, excess), too_much: Some(too_much) }));
            }
            if trial.only_lags(self.limit) {
                too_little = middle;
            } else {
                too_much = (middle, excess);
            }
        }
        Ok(None)
    }

    /// No support serves: why, without torque and at the last one that was tried.
    fn none(&self, idle: &Trial, last: &Trial, support: f64) -> StudyError {
        // The speed of the joint is the same at any support.
        if let Ok(notes) = self.load.speed_notes()
            && let Some(note) = notes.first()
        {
            return StudyError::new(format!("no continuous torque: {note}"));
        }
        let of_idle = idle.reason(self.limit);
        let mut text = format!(
            "no continuous torque: without torque at the {}, where the current only accelerates the rotor and overcomes friction, {of_idle}",
            self.load.words().place
        );
        if support > 0.0 {
            let factor = self.load.words().factor[0];
            text += &format!("; at a {factor} of {} {}", significant(support), last.reason(self.limit));
        }
        StudyError::new(text)
    }
}

/// The greatest fraction of the biological torque that the actuator follows and the motor gives continuously; `done` takes the
/// fraction of the search that is done.
///
/// # Errors
/// No support that the actuator follows without overheating, or a load that does not start.
pub fn continuous_support(load: &Load, done: Done<'_>) -> Result<Continuous, StudyError> {
    let limit = load.get("thermal.T_w_max")?;
    let most = load.support_most()?;
    let mut search = Search { load, limit, warm: None, found: None, left: 1.0, done };
    let bracket = search.bracket(most)?;
    if let Some(too_much) = bracket.too_much {
        let excess = |support: f64| Ok::<_, StudyError>(search.trial(support)?.excess(limit));
        try_root_between(excess, bracket.serves, too_much, SUPPORT_TOLERANCE)?;
    }
    done(1.0);
    let (support, at) =
        search.found.ok_or_else(|| StudyError::new("no support has a steady state".to_owned()))?;
    let limited_by = if bracket.too_much.is_none() {
        Limit::SupportMaximum
    } else if at.winding_temperature > limit - NEAR {
        Limit::WindingTemperature
    } else if KELVINS * at.lag() > -NEAR {
        Limit::TorqueError
    } else {
        Limit::ThermalRunaway
    };
    Ok(Continuous { support, at, limited_by })
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::Preset;

    /// A knee with a rotor of large inertia behind its gear.
    fn knee(preset: &str, sets: &[(&str, &str)]) -> Load {
        const KNEE: &str = "[motor]\ndrive_mode = \"current\"\n[gait]\n\"gait.body_mass\" = 65\n\"gait.joint\" = \"knee\"\n\
             \"gait.activity\" = \"walk\"\n";
        let preset = Preset::load(preset).unwrap();
        let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Load::parse(KNEE, "knee.toml", Some(&preset), &sets).unwrap()
    }

    fn search(load: &Load) -> Search<'_> {
        let limit = load.get("thermal.T_w_max").unwrap();
        Search { load, limit, warm: None, found: None, left: 1.0, done: &|_| () }
    }

    /// Without torque at the joint the error is that of the inertia alone, above what counts as followed; a support that is served above
    /// that is found, and the bracket about it is that of the winding's limit.
    #[test]
    fn an_inertia_that_lags_without_torque_does_not_hide_a_support_that_serves() {
        let load = knee("maxon-re40-148877", &[("transmission.ratio", "135")]);
        let mut search = search(&load);
        assert!(search.trial(0.0).unwrap().only_lags(search.limit));
        let found = continuous_support(&load, &|_| ()).unwrap();
        println!("{found:?}");
        assert!(found.support > 0.1 && found.limited_by != Limit::SupportMaximum);
        let serves = |search: &mut Search<'_>, support: f64| {
            let trial = search.trial(support).unwrap();
            trial.excess(search.limit) <= 0.0
        };
        assert!(serves(&mut search, 0.95 * found.support) && !serves(&mut search, 1.05 * found.support));
    }

    /// Each reason is a sentence of its own, with its numbers.
    #[test]
    fn why_no_support_serves_is_said() {
        for (preset, sets, words) in [
            (
                "maxon-ec90flat-323772",
                &[("transmission.ratio", "150"), ("supply_voltage", "100")][..],
                "thermal runaway",
            ),
            (
                "maxon-re40-148877",
                &[("transmission.ratio", "110"), ("control.current_max", "0.1")],
                "does not follow the joint: torque error",
            ),
            (
                "maxon-re40-148877",
                &[("ambient_temperature", "428"), ("transmission.ratio", "100")],
                "its limit is 155",
            ),
            ("maxon-re40-148877", &[("transmission.ratio", "200")], "at supply_voltage = 48.00 V"),
        ] {
            let error = continuous_support(&knee(preset, sets), &|_| ()).unwrap_err().to_string();
            println!("{error}");
            assert!(error.contains(words) && error.starts_with("no continuous torque: "), "{error}");
            assert!(!error.contains("inf") && !error.contains('\n'), "{error}");
        }
    }
}
