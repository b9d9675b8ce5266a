//! The figures of the page, computed by the model of the archive with its start values and terms.
//!
//! A line is omitted if the model cannot compute it (for example without a fan or a tube in the start values).

mod actuator;
mod gait;

use crate::native::{Native, Run};
use crate::reference;
use describe::DEFAULT_STEP;
use present::figure::{Axis, Figure};

/// Duration of constant torque, s, and number of steps.
const HOUR: f64 = 3600.0;
const HOUR_STEP: f64 = 10.0;
/// Steps to the input that the winding bears, and the relative accuracy of the input and the margin, K, at which they end.
const MOST_STEPS: u32 = 20;
const RESOLVED: f64 = 1e-6;
const LIMIT_MET: f64 = 1e-4;
/// Points of a characteristic.
const POINTS: u32 = 24;

/// A figure with its caption.
pub struct Captioned {
    /// The figure.
    pub figure: Figure,
    /// Two sentences: the simulation, and its result.
    pub caption: String,
}

type Points = Vec<(f64, f64)>;
/// A line: its label, and its points where the model can compute them.
type Line = (String, Option<Points>);

/// The figures and first script of one model.
pub struct Own {
    model: &'static str,
    figures: &'static [fn(&Native<'_>) -> Option<Captioned>],
    /// Inputs that drive the model, each at its nominal value.
    pub drive: &'static [&'static str],
    /// Outputs of the first script; the first is that of the reference figure.
    pub shown: &'static [&'static str],
}

/// A line for each model.
const OWN: &[Own] = &[
    Own {
        model: "AnnulusCooledMotor",
        figures: &[held_torque, torque_and_speed],
        drive: &["voltage", "load_torque"],
        shown: &["shaft_speed", "current", "winding_temperature"],
    },
    Own {
        model: "BrushedGearmotor",
        figures: &[held_load, duties],
        drive: &["duty", "load_torque"],
        shown: &["shaft_speed", "current", "winding_temperature"],
    },
    Own {
        model: "SeriesElasticActuator",
        figures: &[actuator::both_ways, actuator::current_limits],
        drive: &["torque_demand", "joint_angle"],
        shown: &["joint_torque", "load_torque", "current_command"],
    },
    Own {
        model: "GaitLoad",
        figures: &[gait::load_table, gait::torques, gait::powers],
        drive: &[],
        shown: &["torque_demand", "joint_angle", "joint_speed"],
    },
];

/// The line of a model.
pub fn own(native: &Native<'_>) -> &'static Own {
    let name = (native.kind.declaration)().name;
    OWN.iter().find(|own| own.model == name).expect("every model has its line, as the tests see")
}

/// All figures of a model.
pub fn of(native: &Native<'_>) -> Vec<Captioned> {
    let own = own(native).figures.iter();
    own.chain(&[reference_run as fn(&Native<'_>) -> Option<Captioned>]).filter_map(|f| f(native)).collect()
}

fn celsius(kelvin: f64) -> f64 {
    kelvin - 273.15
}

fn figure(title: &str, x: &str, y: &str, lines: Vec<Line>, caption: String) -> Option<Captioned> {
    let mut figure = Figure::new(title, Axis::new(x), Axis::new(y));
    for (label, points) in lines {
        if let Some(points) = points.filter(|points| points.len() > 1) {
            figure = figure.line(&label, points);
        }
    }
    let is_empty = figure.series().next().is_none();
    (!is_empty).then_some(Captioned { figure, caption })
}

/// A characteristic from 0 to `most`.
fn characteristic(most: f64, at: impl Fn(f64) -> Option<f64>) -> Option<Points> {
    let places = (0..=POINTS).map(|k| most * f64::from(k) / f64::from(POINTS));
    places.map(|x| Some((x, at(x)?))).collect()
}

/// The same up to the place where the value would be negative.
fn driven(most: f64, at: impl Fn(f64) -> Option<f64>) -> Option<Points> {
    Some(characteristic(most, at)?.into_iter().filter(|p| p.1 >= 0.0).collect())
}

/// An hour of a model; what is to be drawn, over minutes.
fn hour(run: &mut Run<'_>, name: &str) -> Option<Points> {
    let mut points = vec![(0.0, celsius(run.get(name)?))];
    for k in 1..=(HOUR / HOUR_STEP) as u32 {
        run.step(HOUR_STEP)?;
        points.push((f64::from(k) * HOUR_STEP / 60.0, celsius(run.get(name)?)));
    }
    Some(points)
}

/// The value of an input at which the winding, after an hour, is just below its limit.
fn bearable<'a>(native: &Native<'a>, input: &str, at: impl Fn(f64) -> Option<Run<'a>>) -> Option<f64> {
    let row = native.entry(input)?.row;
    let margin = |value: f64| {
        let mut run = at(value)?;
        hour(&mut run, "winding_temperature")?;
        run.get("winding_margin")
    };
    // A run that ends at a limit of validity has passed the limit of the winding before, by an unknown margin.
    let mut low = (0.0, margin(0.0).filter(|margin| *margin > 0.0)?);
    let mut high = (row.nominal, margin(row.nominal));
    while let Some(left) = high.1.filter(|left| *left > 0.0) {
        (low, high) = ((high.0, left), (2.0 * high.0, margin(2.0 * high.0)));
        if high.0 > row.max {
            return None;
        }
    }
    // Regula falsi; the weight of an end that stays is halved (Dowell, Jarratt, BIT 11 (1971) 168-174).
    for _ in 0..MOST_STEPS {
        let part = high.1.map_or(0.5, |over| low.1 / (low.1 - over));
        let at = low.0 + part * (high.0 - low.0);
        match margin(at) {
            Some(left) if left > 0.0 => {
                (low, high.1) = ((at, left), high.1.map(|over| 0.5 * over));
                if left < LIMIT_MET {
                    break;
                }
            }
            over => (low.1, high) = (0.5 * low.1, (at, over)),
        }
        if high.0 - low.0 < RESOLVED * high.0 {
            break;
        }
    }
    (low.0 > 0.0).then_some(low.0)
}

fn with_limit(captioned: Option<Captioned>, run: &mut Run<'_>) -> Option<Captioned> {
    let limit = celsius(run.get("thermal.T_w_max")?);
    let Captioned { figure, caption } = captioned?;
    Some(Captioned { figure: figure.limit(limit, &format!("limit {limit:.0} °C")), caption })
}

/// The greatest torque of an hour in still air, in all cooling modes.
fn held_torque(native: &Native<'_>) -> Option<Captioned> {
    let at = |cooling: &str, current: f64| {
        let modes =
            [("drive_mode", "current"), ("mechanical_mode", "imposed_speed"), ("cooling_mode", cooling)];
        native.start(&[("current_command", current), ("imposed_speed", 0.0), ("fan_command", 1.0)], &modes)
    };
    let current = bearable(native, "current_command", |current| at("bare", current))?;
    let ways = [("bare", "still air"), ("fan_crossflow", "fan"), ("annulus_push", "fan and annulus")];
    let line = |(mode, label): (&str, &str)| {
        (label.to_string(), at(mode, current).and_then(|mut run| hour(&mut run, "winding_temperature")))
    };
    let torque = at("bare", current).and_then(|mut run| {
        run.step(HOUR_STEP)?;
        run.get("shaft_torque")
    })?;
    let title = format!("Winding temperature at {torque:.3} N·m and standstill");
    let caption = format!(
        "{current:.2} A from a cold start; cooling modes bare, fan crossflow and annulus push, full fan command. \
         At this torque the winding reaches its limit after one hour in still air."
    );
    let figure = figure(
        &title,
        "time in min",
        "winding temperature in °C",
        ways.into_iter().map(line).collect(),
        caption,
    );
    with_limit(figure, &mut at("bare", current)?)
}

/// Torque over speed at the voltage of the archive's default experiment, cold and at the winding's limit. An archive whose drive needs
/// no voltage has the nominal value.
fn torque_and_speed(native: &Native<'_>) -> Option<Captioned> {
    let entry = native.entry("voltage")?;
    let (voltage, what) = match native.starts.of(entry) {
        0.0 => (entry.row.nominal, "the nominal value of the input"),
        start => (start, "the start value of the input"),
    };
    let limit = native.starts.of(native.entry("thermal.T_w_max")?);
    let torque = |ambient: f64, speed: f64| {
        let values = [
            ("voltage", voltage),
            ("imposed_speed", speed),
            ("ambient_temperature", ambient),
            ("heat_power", 0.0),
        ];
        let modes = [("drive_mode", "voltage"), ("mechanical_mode", "imposed_speed")];
        let mut run = native.start(&values, &modes)?;
        // The current has settled after some time constants L / R; the winding has not warmed by then.
        for _ in 0..10 {
            run.step(DEFAULT_STEP)?;
        }
        run.get("shaft_torque")
    };
    let cold = native.starts.of(native.entry("ambient_temperature")?);
    let points = |ambient: f64| -> Option<Points> {
        let constant = native.start(&[("ambient_temperature", ambient)], &[])?.get("torque_constant")?;
        let points = driven(voltage / constant, |speed| torque(ambient, speed))?;
        Some(points.into_iter().map(|(speed, torque)| (torque, speed)).collect())
    };
    let line = |ambient: f64| (format!("all nodes at {:.0} °C", celsius(ambient)), points(ambient));
    let lines = [cold, limit].map(line).to_vec();
    let caption = format!(
        "Voltage drive at {voltage} V, {what}; imposed speed. A hot winding has more resistance, hot \
         magnets less torque per ampere."
    );
    figure("Speed and torque", "shaft torque in N·m", "shaft speed in rad/s", lines, caption)
}

/// The greatest load of the gearmotor for an hour, and its temperatures.
fn held_load(native: &Native<'_>) -> Option<Captioned> {
    let at = |load: f64| native.start(&[("duty", 1.0), ("load_torque", load)], &[]);
    let load = bearable(native, "load_torque", at)?;
    let names = ["winding_temperature", "housing_temperature", "box_temperature"];
    let line = |name: &str| {
        (name.trim_end_matches("_temperature").to_string(), at(load).and_then(|mut run| hour(&mut run, name)))
    };
    let title = format!("Temperatures at a load of {load:.2} N·m");
    let caption =
        "Duty 1 from a cold start. At this load the winding reaches its limit after one hour.".to_string();
    let figure =
        figure(&title, "time in min", "temperature in °C", names.into_iter().map(line).collect(), caption);
    with_limit(figure, &mut at(load)?)
}

/// Speed over load at several duties.
fn duties(native: &Native<'_>) -> Option<Captioned> {
    let most = 2.0 * native.entry("load_torque")?.row.nominal;
    let speed = |duty: f64, load: f64| {
        let mut run = native.start(&[("duty", duty), ("load_torque", load)], &[])?;
        for _ in 0..300 {
            run.step(10.0 * DEFAULT_STEP)?;
        }
        run.get("shaft_speed")
    };
    let line = |duty: f64| (format!("duty {duty}"), driven(most, |load| speed(duty, load)));
    let lines = [1.0, 0.75, 0.5, 0.25].map(line).to_vec();
    let caption = format!(
        "Three seconds after the start, supply voltage {} V. Each line ends where the load would reverse the motor.",
        native.starts.of(native.entry("supply_voltage")?)
    );
    figure("Speed and load", "load torque in N·m", "shaft speed in rad/s", lines, caption)
}

/// The run that the archive carries as reference.
fn reference_run(native: &Native<'_>) -> Option<Captioned> {
    let name = own(native).shown[0];
    let unit = native.entry(name)?.row.unit.name();
    let mut points = Vec::new();
    reference::drive(native, |k, run| {
        points.push((f64::from(k) * DEFAULT_STEP, run.get(name)?));
        Some(())
    })?;
    let caption = format!(
        "The simulation whose inputs and results are stored in {}. The inputs go to their nominal values one after the other.",
        reference::FOLDER
    );
    let label = format!("{} in {}", name.replace('_', " "), unit.replace('.', "·"));
    figure("Reference simulation", "time in s", &label, vec![(String::new(), Some(points))], caption)
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{StartValues, models};

    #[test]
    fn every_model_has_three_figures_and_none_is_empty() {
        for kind in models::ALL.iter() {
            let starts = StartValues::default();
            let figures = of(&Native { kind, starts: &starts, resources: &describe::Resources::default() });
            assert_eq!(figures.len(), 3, "{kind:?}");
            for figure in figures {
                let span = |points: &[(f64, f64)]| {
                    let (low, high) =
                        points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
                    high - low
                };
                assert!(figure.figure.series().all(|(_, p)| span(p) > 0.0), "{}", figure.figure.title());
            }
        }
    }

    #[test]
    fn the_limit_is_reached_in_still_air_alone() {
        let kind = models::by_name("AnnulusCooledMotor").unwrap();
        let starts = StartValues::default();
        let figure =
            held_torque(&Native { kind, starts: &starts, resources: &describe::Resources::default() })
                .unwrap();
        let end: Vec<f64> = figure.figure.series().map(|(_, p)| p.last().unwrap().1).collect();
        let limit = figure.figure.limits().next().unwrap();
        assert!((end[0] - limit).abs() < 0.1, "still air ends at the limit: {end:?}, {limit}");
        assert!(end[1] < end[0] - 10.0 && end[2] < end[0] - 10.0, "{end:?}");
    }
}
