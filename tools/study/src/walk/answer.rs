//! The questions: what a walk does to the winding for ever and over hours, and how much of the torque can be given for
//! ever.

use super::cycle::{Envelope, envelope, steady};
use super::load::Load;
use super::stride::Stride;
use crate::StudyError;
use crate::numeric::try_root;
use serde::Serialize;

/// Width of the bracket about the support at which the search ends.
const SUPPORT_TOLERANCE: f64 = 1e-5;
/// A torque counts as followed while the root mean square of its error is below this share of its greatest value, and so
/// many N.m.
const FOLLOWED: (f64, f64) = (0.05, 0.5);
/// Kelvins that a newton metre of error too many counts in the search.
const KELVINS: f64 = 100.0;
/// The share of the biological torque that is asked for.
const SUPPORT: &str = "gait.support";

/// What a sweep of walks looks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Walks {
    /// Greatest torque of the joint in a gait that can be walked for ever, N.m.
    ContinuousTorque,
    /// The same per mass of motor, fan and tube, N.m/kg.
    TorqueDensity,
    /// The share of the biological torque that can be given for ever.
    ContinuousSupport,
    /// The winding's greatest temperature in the periodic steady state, K.
    WindingTemperature,
    /// Mean power from the supply in the periodic steady state, W.
    SupplyPower,
    /// Root mean square of the torque's error, N.m.
    TorqueError,
    /// Time until the winding passes its limit, s; so many hours where it does not.
    TimeToLimit {
        /// How long is walked at most.
        hours: f64,
    },
}

impl Walks {
    /// What there is, for a walk of `hours` at most.
    fn all(hours: f64) -> [Walks; 7] {
        use Walks::*;
        [
            ContinuousTorque,
            TorqueDensity,
            ContinuousSupport,
            WindingTemperature,
            SupplyPower,
            TorqueError,
            TimeToLimit { hours },
        ]
    }

    /// From its name.
    ///
    /// # Errors
    /// One sentence with the names that there are.
    pub fn named(name: &str, hours: f64) -> Result<Walks, StudyError> {
        Walks::all(hours).into_iter().find(|w| w.describe().0 == name).ok_or_else(|| {
            let known: Vec<&str> = Walks::all(hours).iter().map(|w| w.describe().0).collect();
            StudyError::new(format!("--objective {name}: of a walk there is {}", known.join(", ")))
        })
    }

    /// Name, unit, and whether the least is the best.
    pub fn describe(&self) -> (&'static str, &'static str, bool) {
        match self {
            Walks::ContinuousTorque => ("continuous_torque", "N.m", false),
            Walks::TorqueDensity => ("torque_density", "N.m/kg", false),
            Walks::ContinuousSupport => ("continuous_support", "1", false),
            Walks::WindingTemperature => ("winding_temperature", "K", true),
            Walks::SupplyPower => ("supply_power", "W", true),
            Walks::TorqueError => ("torque_error", "N.m", true),
            Walks::TimeToLimit { .. } => ("time_to_limit", "s", false),
        }
    }
}

/// A walk in its periodic steady state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Forever {
    /// Greatest temperature of the winding within a stride, K.
    pub winding_temperature: f64,
    /// Mean temperature of the winding, K.
    pub winding_temperature_mean: f64,
    /// Root mean square of the current, A.
    pub current_rms: f64,
    /// Greatest current, A.
    pub current_peak: f64,
    /// Greatest torque at the joint, N.m.
    pub joint_torque_peak: f64,
    /// Root mean square of the torque's error, N.m.
    pub torque_error_rms: f64,
    /// Mean power into the motor's terminals, W.
    pub power_electrical: f64,
    /// Mean power to the joint, W.
    pub power_joint: f64,
    /// Mean power from the supply, W.
    pub power_supply: f64,
    /// Strides that were walked to find it.
    pub strides_walked: u32,
}

impl Forever {
    fn of(stride: &Stride, strides_walked: u32) -> Forever {
        let [electrical, joint, supply] = stride.power;
        Forever {
            winding_temperature: stride.winding[0],
            winding_temperature_mean: stride.winding[1],
            current_rms: stride.current[0],
            current_peak: stride.current[1],
            joint_torque_peak: stride.joint_torque,
            torque_error_rms: stride.torque_error,
            power_electrical: electrical,
            power_joint: joint,
            power_supply: supply,
            strides_walked,
        }
    }
}

/// A walk: for ever, or until the winding has had enough.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Walked {
    /// Time of a stride, s.
    pub stride_time: f64,
    /// The winding's limit, K.
    pub limit: f64,
    /// The steady state; absent where the winding runs away.
    pub forever: Option<Forever>,
    /// The way there from a cold start.
    pub envelope: Envelope,
}

/// Walks for `hours`: the steady state, and the winding on the way.
///
/// # Errors
/// A load that does not start, or equations that have no solution.
pub fn walk(load: &Load, hours: f64) -> Result<Walked, StudyError> {
    if !(hours > 0.0 && hours.is_finite()) {
        return Err(StudyError::new(format!(
            "a walk of {hours} hours is none; hours are positive and finite"
        )));
    }
    let walker = load.walker()?;
    let limit = load.get("thermal.T_w_max")?;
    let forever = match steady(&walker) {
        Ok((_, stride, walked)) => Some(Forever::of(&stride, walked)),
        Err(StudyError::Unsettled(_)) => None,
        Err(other) => return Err(other),
    };
    let envelope = envelope(&walker, hours * 3600.0, limit)?;
    Ok(Walked { stride_time: walker.stride_time(), limit, forever, envelope })
}

/// The steady state of a walk, without the way there.
///
/// # Errors
/// The winding runs away, or the load does not start.
pub fn forever(load: &Load) -> Result<Forever, StudyError> {
    let (_, stride, walked) = steady(&load.walker()?)?;
    Ok(Forever::of(&stride, walked))
}

/// The greatest share of the biological torque that the actuator can follow and the motor give for ever, and the steady
/// state there.
///
/// # Errors
/// A winding that is too hot without any torque, or a load that does not start.
pub fn continuous_support(load: &Load) -> Result<(f64, Forever), StudyError> {
    let limit = load.get("thermal.T_w_max")?;
    let most = load.owner(SUPPORT)?.entry(SUPPORT)?.row.max;
    let mut found = None;
    let mut excess = |support: f64| -> Result<f64, StudyError> {
        let mut load = load.clone();
        load.set_text(SUPPORT, &support.to_string())?;
        match forever(&load) {
            Ok(f) => {
                found = Some(f);
                let lag = f.torque_error_rms - FOLLOWED.0 * f.joint_torque_peak - FOLLOWED.1;
                Ok((f.winding_temperature - limit).max(KELVINS * lag))
            }
            Err(StudyError::Unsettled(_)) => Ok(f64::INFINITY),
            Err(other) => Err(other),
        }
    };
    let idle = excess(0.0)?;
    if idle >= 0.0 {
        return Err(StudyError::new(format!(
            "no torque can be given for ever: already when the actuator only follows the joint, the winding passes its limit \
             of {limit} K or the motor cannot keep up (the excess is worth {idle:.1} K)"
        )));
    }
    let support = if excess(most)? < 0.0 {
        most
    } else {
        try_root(&mut excess, 0.0, most, SUPPORT_TOLERANCE)?.unwrap_or(0.0)
    };
    excess(support)?;
    match found {
        Some(f) => Ok((support, f)),
        None => Err(StudyError::new(format!(
            "no share of the torque up to {most} keeps the winding at {limit} K"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::Preset;
    use std::time::Instant;

    fn load(text: &str, sets: &[(&str, &str)]) -> Load {
        let preset = Preset::load("maxon-305015").unwrap();
        let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Load::parse(text, "gait.toml", Some(&preset), &sets).unwrap()
    }

    const WALK: &str = "[motor]\ndrive_mode = \"current\"\n[gait]\n\"gait.support\" = 0.6\n";

    /// The fixed point against the long way: stride by stride until nothing moves, in both drives and two ways of cooling.
    /// A housing of little capacity gets there in minutes; where it gets does not depend on that.
    #[test]
    fn for_ever_is_where_a_long_walk_ends() {
        for (text, sets) in [
            (WALK, &[("thermal.C_h", "15"), ("fan_command", "0.5")][..]),
            (WALK, &[("thermal.C_h", "15"), ("drive_mode", "voltage"), ("fan_command", "1")]),
            (
                WALK,
                &[
                    ("thermal.C_h", "80"),
                    ("cooling_mode", "annulus_push"),
                    ("air_segments", "3"),
                    ("fan_command", "1"),
                ],
            ),
        ] {
            let load = load(text, sets);
            let begun = Instant::now();
            let found = forever(&load).unwrap();
            let seconds = begun.elapsed().as_secs_f64();
            let mut walker = load.walker().unwrap();
            let mut last = 0.0;
            let mut moved = f64::INFINITY;
            while moved > 1e-4 {
                let before = last;
                for _ in 0..20 {
                    last = walker.stride().unwrap().winding[0];
                }
                moved = (last - before).abs();
            }
            println!(
                "{sets:?}: {} and {last} K, {} strides in {seconds} s",
                found.winding_temperature, found.strides_walked
            );
            assert!((found.winding_temperature - last).abs() < 0.05, "{sets:?} {found:?} {last}");
            assert!(found.strides_walked < 15, "{found:?}");
        }
    }

    /// The envelope against every stride, from cold to the limit.
    #[test]
    fn the_envelope_is_the_walk() {
        let load = load(WALK, &[("gait.support", "1")]);
        let found = walk(&load, 2.0).unwrap();
        let mut walker = load.walker().unwrap();
        let mut exact = Vec::new();
        while exact.last().is_none_or(|t| *t < found.limit) {
            exact.push(walker.stride().unwrap().winding[0]);
        }
        let time = exact.len() as f64 * walker.stride_time();
        let to_limit = found.envelope.time_to_limit.unwrap();
        println!(
            "limit after {to_limit} s and {time} s; {} of {} strides",
            found.envelope.strides_walked,
            exact.len()
        );
        assert!((to_limit - time).abs() < 2.0 * walker.stride_time(), "{to_limit} {time}");
        for p in &found.envelope.points {
            let k = (p.time / walker.stride_time()).round() as usize - 1;
            if let Some(t) = exact.get(k) {
                assert!((p.winding_temperature - t).abs() < 0.1, "{p:?} {t}");
            }
        }
        assert!(found.envelope.strides_walked < exact.len() as u32 / 5);
    }

    #[test]
    fn cooling_buys_support() {
        let support = |sets: &[(&str, &str)]| continuous_support(&load(WALK, sets)).unwrap();
        let (still, f) = support(&[]);
        assert!((f.winding_temperature - 428.15).abs() < 0.05, "{f:?}");
        let (fan, _) = support(&[("fan_command", "1")]);
        println!("support {still} in still air, {fan} with a fan");
        assert!(fan > 1.3 * still);
    }

    #[test]
    fn bad_loads_are_one_sentence() {
        let parse = |text: &str| match Load::parse(text, "g.toml", None, &[]) {
            Ok(load) => load.walker().err().map(|e| e.to_string()).unwrap_or_default(),
            Err(e) => e.to_string(),
        };
        for (text, words) in [
            ("[gate]\n", &["g.toml:1", "gate", "[motor], [actuator], [gait]"][..]),
            (
                "[gait]\n\"gait.bodymass\" = 3\n",
                &["g.toml:2", "gait.bodymass", "did you mean gait.body_mass?"],
            ),
            ("[gait]\n\"gait.activity\" = \"fly\"\n", &["g.toml:2", "fly", "stairs_up"]),
            ("[gait]\n\"gait.body_mass\" = 9000\n", &["gait.body_mass = 9000 kg", "500"]),
            ("[gait]\n\"gait.variation\" = 0.02\n", &["gait.variation", "0"]),
            ("[motor]\ndrive_mode = \"power\"\n", &["drive_mode", "voltage or current"]),
        ] {
            let error = parse(text);
            assert!(words.iter().all(|w| error.contains(w)) && !error.contains('\n'), "{error}");
        }
        assert!(walk(&load(WALK, &[]), f64::NAN).is_err());
    }
}
