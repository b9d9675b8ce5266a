//! Periodic steady state of a gait, the winding on the way there, and the objectives of sweeps.

use super::cycle::{Done, Near, envelope, steady};
use super::envelope::Envelope;
use super::load::Load;
use super::periodic::Periodic;
use super::support::continuous_support;
use crate::StudyError;
use describe::preset::nearest;
use present::figure::{Axis, Figure};
use serde::Serialize;

/// 0 degC in K.
const ZERO_CELSIUS: f64 = 273.15;

/// Objective of a sweep under a gait.
#[derive(Clone, Copy)]
pub struct Objective {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the least value is the best.
    pub least_is_best: bool,
    of: Of,
}

/// What an objective is computed from.
#[derive(Clone, Copy)]
enum Of {
    /// The periodic steady state.
    Steady(fn(&Periodic) -> f64),
    /// A search of its own, in a walk of so many hours at most.
    Load(fn(&Load, f64) -> Result<f64, StudyError>),
}

/// The torque and its fraction at the greatest continuous support; temperature, power and torque error in the periodic steady
/// state; the time until the winding reaches its limit, or the duration of the walk where it does not.
const OBJECTIVES: [Objective; 7] = {
    use Of::{Load, Steady};
    const fn new(name: &'static str, unit: &'static str, least_is_best: bool, of: Of) -> Objective {
        Objective { name, unit, least_is_best, of }
    }
    [
        new(
            "continuous_torque",
            "N.m",
            false,
            Load(|l, _| Ok(continuous_support(l, &|_| ())?.at.joint_torque_peak)),
        ),
        new(
            "torque_density",
            "N.m/kg",
            false,
            Load(|l, _| Ok(continuous_support(l, &|_| ())?.at.joint_torque_peak / l.mass()?)),
        ),
        new("continuous_support", "1", false, Load(|l, _| Ok(continuous_support(l, &|_| ())?.support))),
        new("winding_temperature", "K", true, Steady(|s| s.winding_temperature)),
        new("supply_power", "W", true, Steady(|s| s.power_supply)),
        new("torque_error", "N.m", true, Steady(|s| s.torque_error_rms)),
        new(
            TIME_TO_LIMIT,
            "s",
            false,
            Load(|l, hours| Ok(walk(l, hours, &|_| ())?.envelope.time_to_limit.unwrap_or(hours * 3600.0))),
        ),
    ]
};

/// The objective whose value is the longest simulated time if the limit is not reached in it.
pub const TIME_TO_LIMIT: &str = "time_to_limit";

/// What is known of a load and of one near it.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// The periodic steady state of the load.
    steady: Option<Periodic>,
    /// What the search for the last steady state has found, and that before it.
    near: [Option<Near>; 2],
}

impl Known {
    /// For the next load.
    pub fn next_load(&mut self) {
        self.steady = None;
    }

    /// What a search for the next load begins with: temperatures on the line through the last two, as at equal distances on a grid.
    fn ahead(&self) -> Option<Near> {
        let [last, before] = &self.near;
        let mut ahead = last.clone()?;
        if let Some(before) = before {
            for (next, before) in ahead.temperatures.iter_mut().zip(&before.temperatures) {
                *next += *next - before;
            }
        }
        Some(ahead)
    }
}

impl Objective {
    /// From its name.
    ///
    /// # Errors
    /// One sentence with the known names.
    pub fn named(name: &str) -> Result<Objective, StudyError> {
        OBJECTIVES.into_iter().find(|o| o.name == name).ok_or_else(|| {
            StudyError::new(format!(
                "with --load the objectives are {}{}",
                OBJECTIVES.map(|o| o.name).join(", "),
                if name.is_empty() {
                    String::new()
                } else {
                    nearest(name, OBJECTIVES.iter().map(|o| o.name))
                }
            ))
        })
    }

    /// Its value under a load, in a walk of so many hours at most.
    ///
    /// # Errors
    /// A load without that value.
    pub fn of(&self, load: &Load, hours: f64, known: &mut Known) -> Result<f64, StudyError> {
        let of = match self.of {
            Of::Load(of) => return of(load, hours),
            Of::Steady(of) => of,
        };
        let at = match known.steady {
            Some(at) => at,
            None => {
                let (stride, near) = steady(&load.walker()?, known.ahead().as_ref())?;
                known.near.swap(0, 1);
                known.near[0] = Some(near);
                *known.steady.insert(stride)
            }
        };
        Ok(of(&at))
    }
}

/// A walk: its periodic steady state and the way there from a cold start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Walked {
    /// Time of a stride, s.
    pub stride_time: f64,
    /// The winding's limit, K.
    pub limit: f64,
    /// Time for which it was to be simulated, h.
    #[serde(skip)]
    pub hours: f64,
    /// The periodic steady state; absent with thermal runaway.
    pub forever: Option<Periodic>,
    /// The stride in which the winding reaches its limit, where it does.
    pub at_limit: Option<Periodic>,
    /// The way there from a cold start.
    pub envelope: Envelope,
}

impl Walked {
    /// The figure: the winding over the walk, with its limit.
    pub fn figure(&self, title: &str) -> Figure {
        let points = self.envelope.points.iter();
        let points: Vec<_> = points.map(|p| (p.time, p.winding_temperature - ZERO_CELSIUS)).collect();
        let (limit, end) = (self.limit - ZERO_CELSIUS, points.last().map_or(0.0, |p| p.0));
        // The first point belongs to the end of the first stride.
        let time = Axis::time().from_to(0.0, end.max(f64::MIN_POSITIVE));
        let figure = Figure::new(title, time, Axis::new("peak winding temperature in °C"))
            .line("winding, peak of each stride", points)
            .limit(limit, &format!("limit {} °C", present::number(limit)));
        match self.envelope.time_to_limit {
            Some(_) => figure.remark("The curve ends where the winding reaches its limit."),
            None if end < (1.0 - NEARLY) * self.hours * 3600.0 => {
                figure.remark("The curve ends at the periodic steady state, in which all strides are alike.")
            }
            None => figure,
        }
    }
}

/// Part of the time that a last stride may leave.
const NEARLY: f64 = 0.01;

/// Part of [`walk`] that the search for the steady state takes.
const SEARCH: f64 = 0.4;

/// Walks for `hours`: the periodic steady state, and the winding on the way; `done` takes the fraction that is done.
///
/// # Errors
/// A load that does not start, or equations that have no solution.
pub fn walk(load: &Load, hours: f64, done: Done<'_>) -> Result<Walked, StudyError> {
    check_hours(hours)?;
    let walker = load.walker()?;
    let limit = load.get("thermal.T_w_max")?;
    let forever = match steady(&walker, None) {
        Ok((stride, _)) => Some(stride),
        Err(StudyError::Unsettled(_)) => None,
        Err(other) => return Err(other),
    };
    done(SEARCH);
    let envelope =
        envelope(&walker, hours * 3600.0, limit, &|fraction| done(SEARCH + (1.0 - SEARCH) * fraction))?;
    done(1.0);
    Ok(Walked {
        stride_time: walker.stride_time(),
        limit,
        hours,
        forever,
        at_limit: envelope.at_limit,
        envelope,
    })
}

/// Whether a walk can last so long.
///
/// # Errors
/// A duration that is not positive and finite.
pub fn check_hours(hours: f64) -> Result<(), StudyError> {
    if hours > 0.0 && hours.is_finite() {
        return Ok(());
    }
    Err(StudyError::new(format!("--hours {hours}: the duration must be positive and finite, in h")))
}

/// The periodic steady state of a walk, without the way there.
///
/// # Errors
/// Thermal runaway, or a load that does not start.
pub fn periodic(load: &Load) -> Result<Periodic, StudyError> {
    Ok(steady(&load.walker()?, None)?.0)
}

#[cfg(test)]
mod tests {
    use super::super::envelope::EnvelopePoint;
    use super::super::support::Limit;
    use super::*;
    use describe::Preset;
    use rayon::prelude::*;
    use std::time::Instant;

    /// The first point belongs to the end of the first stride, and the curve ends at the limit; neither looks like a cut.
    #[test]
    fn the_figure_has_its_limit_and_all_of_the_time() {
        let point = |time, winding_temperature| EnvelopePoint { time, winding_temperature };
        let points = vec![point(114.0, 330.0), point(1476.0, 428.15)];
        let envelope = Envelope { points, time_to_limit: Some(1476.0), ..Envelope::default() };
        let walked =
            Walked { stride_time: 1.14, limit: 428.15, hours: 1.0, forever: None, at_limit: None, envelope };
        let figure = walked.figure("Winding temperature").svg();
        for text in [">0<", ">limit 155 °C<", ">The curve ends where the winding reaches its limit.<"] {
            assert!(figure.contains(text), "{text}: {figure}");
        }
    }

    fn load(text: &str, sets: &[(&str, &str)]) -> Load {
        let preset = Preset::load("maxon-305015").unwrap();
        let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Load::parse(text, "gait.toml", Some(&preset), &sets).unwrap()
    }

    const WALK: &str = "[motor]\ndrive_mode = \"current\"\n[gait]\n\"gait.support\" = 0.6\n";

    /// The fixed point compared with a simulation stride by stride up to the steady state, in both drives and two cooling modes.
    /// A housing of small heat capacity reaches it in minutes; the steady state does not depend on the capacity.
    #[test]
    fn the_periodic_steady_state_is_where_a_long_walk_ends() {
        let cases = [
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
        ];
        cases.into_par_iter().for_each(|(text, sets)| {
            let load = load(text, sets);
            let begun = Instant::now();
            let found = periodic(&load).unwrap();
            let seconds = begun.elapsed().as_secs_f64();
            // From below, but not from ambient: the way there has been followed by the other tests.
            let mut walker = load.walker().unwrap();
            let (_, near) = steady(&walker, None).unwrap();
            let below: Vec<f64> = near.temperatures.iter().map(|t| t - 1.0).collect();
            walker.put_temperatures(&below);
            let mut twenty_strides =
                || (0..20).map(|_| walker.stride().unwrap().winding_temperature).last().unwrap();
            let mut way = [twenty_strides(), twenty_strides(), twenty_strides()];
            while way[2] - way[1] > 1e-2 {
                way = [way[1], way[2], twenty_strides()];
            }
            // What is left of the way falls as a geometric series (Aitken).
            let left = (way[2] - way[1]).powi(2) / (2.0 * way[1] - way[0] - way[2]);
            let last = way[2] + left;
            assert!(left < 0.5, "{sets:?} {way:?}");
            println!(
                "{sets:?}: {} and {last} K, {} strides in {seconds} s",
                found.winding_temperature, found.strides_walked
            );
            assert!((found.winding_temperature - last).abs() < 1e-3, "{sets:?} {found:?} {last}");
            assert!(found.strides_walked < 15, "{found:?}");
        });
    }

    /// The envelope against every stride, from cold to the limit.
    #[test]
    fn the_envelope_is_the_walk() {
        let load = load(WALK, &[("gait.support", "0.85")]);
        let found = walk(&load, 2.0, &|_| ()).unwrap();
        let mut walker = load.walker().unwrap();
        let mut exact = Vec::new();
        while exact.last().is_none_or(|t| *t < found.limit) {
            exact.push(walker.stride().unwrap().winding_temperature);
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

    /// A search from the steady state of a similar load ends at the same steady state in fewer strides; one from temperatures that lead
    /// nowhere is repeated from the start.
    #[test]
    fn a_steady_state_nearby_shortens_the_search() {
        let find = |load: &Load, near: Option<&Near>| steady(&load.walker().unwrap(), near).unwrap();
        let (_, near) = find(&load(WALK, &[("fan_command", "0.5")]), None);
        let other = load(WALK, &[("fan_command", "0.6")]);
        let (alone, _) = find(&other, None);
        let [mut hot, mut of_another] = [near.clone(), near.clone()];
        hot.temperatures.fill(900.0);
        of_another.temperatures.truncate(1);
        for (near, is_near) in [(near, true), (hot, false), (of_another, false)] {
            let (found, _) = find(&other, Some(&near));
            println!("{near:?}: {} instead of {} strides", found.strides_walked, alone.strides_walked);
            assert!(
                (found.winding_temperature - alone.winding_temperature).abs() < 1e-4,
                "{found:?} {alone:?}"
            );
            assert_eq!(found.strides_walked < alone.strides_walked, is_near, "{near:?}");
        }
    }

    #[test]
    fn cooling_buys_support() {
        let support = |sets: &[(&str, &str)]| continuous_support(&load(WALK, sets), &|_| ()).unwrap();
        let still = support(&[]);
        assert!((still.at.winding_temperature - 428.15).abs() < 0.5, "{still:?}");
        assert_eq!(still.limited_by, Limit::WindingTemperature);
        let fan = support(&[("fan_command", "1")]);
        println!("support {} in still air, {} with a fan", still.support, fan.support);
        assert!(fan.support > 1.3 * still.support);
    }

    /// Supports whose transient passes a limit of validity have no steady state; the search goes on below them.
    #[test]
    fn a_support_beyond_the_limits_of_validity_is_too_much() {
        let support = |sets: &[(&str, &str)]| continuous_support(&load(WALK, sets), &|_| ()).unwrap().support;
        let near = support(&[("validity.winding_temperature", "429")]);
        let far = support(&[]);
        assert!((near - far).abs() < 5e-3 * far, "{near} {far}");
    }

    /// A drive of 8 A limits the torque before the winding is warm, and is named.
    #[test]
    fn the_limit_is_named() {
        let found =
            continuous_support(&load(WALK, &[("fan_command", "1"), ("control.current_max", "8")]), &|_| ())
                .unwrap();
        assert_eq!(found.limited_by, Limit::TorqueError, "{found:?}");
        assert!(found.at.winding_temperature < 420.0);
    }

    /// Mean power from the supply is the motor's electrical power plus the losses of the drive, in both drive modes and
    /// at the current limit, where the voltage that the actuator commands is not the motor's; within the coupling error of
    /// steps of 1 ms.
    #[test]
    fn the_supply_gives_the_electrical_power() {
        for drive in ["current", "voltage"] {
            let sets = [("drive_mode", drive), ("fan_command", "1"), ("conductance.G_forced", "0.35")];
            let found = periodic(&load("", &sets)).unwrap();
            println!(
                "{drive}: {} W from the supply, {} W electrical",
                found.power_supply, found.power_electrical
            );
            assert!((found.power_supply / found.power_electrical - 1.0).abs() < 6e-3, "{drive} {found:?}");
        }
        let sets = [("drive.standby_power", "7"), ("conductance.G_forced", "0.35"), ("fan_command", "1")];
        let found = periodic(&load(WALK, &sets)).unwrap();
        assert!((found.power_supply - found.power_electrical - 7.0).abs() < 0.1, "{found:?}");
    }

    /// Every preset's motor data reach the control; what the file sets wins, and a change of the motor is followed.
    #[test]
    fn the_control_follows_the_motor() {
        const OTHER: &str = "name = \"other\"\nmodel = \"AnnulusCooledMotor\"\n[start]\n\"motor.R_ref\" = 1.1\n\
             \"motor.k_t\" = 0.0535\n\"motor.J\" = 1.2e-5\n\"effect.coulomb_friction.tau_c\" = 0.012\nvoltage = 24\n";
        let preset = Preset::parse(OTHER, "other.toml").unwrap();
        let load = |text: &str| Load::parse(text, "gait.toml", Some(&preset), &[]).unwrap();
        let get = |load: &Load, name: &str| load.get(name).unwrap();
        let other = load(WALK);
        let values = [
            ("control.R", 1.1),
            ("control.k_t", 0.0535),
            ("control.J", 1.2e-5),
            ("control.tau_c", 0.012),
            ("supply_voltage", 24.0),
        ];
        for (name, value) in values {
            assert_eq!(get(&other, name), value, "{name}");
        }
        let derived: Vec<&str> = other.derived().unwrap().iter().map(|d| d.name).collect();
        assert_eq!(derived.len(), values.len(), "{derived:?}");
        let explicit = load(&format!("{WALK}[actuator]\n\"control.k_t\" = 0.03\n"));
        assert_eq!(get(&explicit, "control.k_t"), 0.03);
        assert!(explicit.derived().unwrap().iter().all(|d| d.name != "control.k_t"));
        let mut varied = other.clone();
        varied.set_text("motor.k_t", "0.06").unwrap();
        assert_eq!(get(&varied, "control.k_t"), 0.06);
        // The control of this motor follows the gait, with that of another it does not as well.
        let error = |load: &Load| {
            let mut load = load.clone();
            for (name, value) in [("fan_command", "1"), ("gait.support", "0.3"), ("supply_voltage", "48")] {
                load.set_text(name, value).unwrap();
            }
            periodic(&load).unwrap().torque_error_rms
        };
        let foreign = load(&format!(
            "{WALK}[actuator]\n\"control.k_t\" = 0.0276\n\"control.J\" = 33.3e-7\n\"control.tau_c\" = 0\n"
        ));
        assert!(error(&other) < 0.7 * error(&foreign), "{} {}", error(&other), error(&foreign));
    }

    /// The data source is that of the activity, from its declaration.
    #[test]
    fn the_source_follows_the_activity() {
        let source = |activity: &str| load(WALK, &[("gait.activity", activity)]).source().unwrap();
        assert!(source("walk").contains("adults") && source("walk").contains("Grimmer"));
        assert!(source("child_walk").contains("children") && source("child_walk").contains("Schwartz"));
        assert!(source("stairs_up").contains("Boehme"));
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
        assert!(walk(&load(WALK, &[]), f64::NAN, &|_| ()).is_err());
    }
}
