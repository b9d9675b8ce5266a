//! The figures of the page, computed by the model of the archive with its start values and terms.
//!
//! A line is omitted if the model cannot compute it (for example without a fan or a tube in the start values).

mod actuator;
mod gait;

use crate::native::{Native, Run};
use crate::reference;
use describe::{DEFAULT_STEP, DEFAULT_STOP};
use present::figure::{Axis, Figure};
use present::page::Plate;

/// Duration of constant torque, s, and number of steps.
const HOUR: f64 = 3600.0;
const HOUR_STEP: f64 = 10.0;
/// Points of a characteristic.
const POINTS: u32 = 24;

/// A figure with its caption.
pub struct Captioned {
    /// The figure.
    pub figure: Figure,
    /// Two sentences: the simulation, and its result.
    pub caption: String,
}

impl Captioned {
    /// As markup of a page.
    pub fn plate(self) -> Plate {
        Plate::new("behaviour", self.figure, self.caption)
    }
}

/// A line: its label and its points.
type Line = (String, Vec<(f64, f64)>);

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
        figures: &[gait::torques, gait::powers],
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
    let lines: Vec<Line> = lines.into_iter().filter(|(_, points)| points.len() > 1).collect();
    if lines.is_empty() {
        return None;
    }
    let empty = Figure::new(title, Axis::new(x), Axis::new(y));
    let figure = lines.into_iter().fold(empty, |figure, (label, points)| figure.line(&label, points));
    Some(Captioned { figure, caption })
}

/// An hour of a model; what is to be drawn, over minutes.
fn hour(run: &mut Run<'_>, name: &str) -> Option<Vec<(f64, f64)>> {
    let mut points = vec![(0.0, celsius(run.get(name)?))];
    for k in 1..=(HOUR / HOUR_STEP) as u32 {
        run.step(HOUR_STEP)?;
        points.push((f64::from(k) * HOUR_STEP / 60.0, celsius(run.get(name)?)));
    }
    Some(points)
}

/// The value of something at which the winding, after an hour, is just below its limit.
fn bearable(from: f64, most: f64, margin: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    // A run that ends at a limit of validity has passed the limit of the winding before.
    let bears = |value: f64| margin(value).is_some_and(|margin| margin > 0.0);
    let mut high = from;
    while bears(high) {
        high *= 2.0;
        if high > most {
            return None;
        }
    }
    let mut low = 0.0;
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if bears(middle) { low = middle } else { high = middle }
    }
    (low > 0.0).then_some(low)
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
    let margin = |current: f64| {
        let mut run = at("bare", current)?;
        hour(&mut run, "winding_temperature")?;
        run.get("winding_margin")
    };
    let nominal = native.entry("current_command")?.row.nominal;
    let current = bearable(nominal, native.entry("current_command")?.row.max, margin)?;
    let ways = [("bare", "still air"), ("fan_crossflow", "fan"), ("annulus_push", "fan and annulus")];
    let line = |(mode, label): (&str, &str)| {
        let points = at(mode, current).and_then(|mut run| hour(&mut run, "winding_temperature"));
        (label.to_string(), points.unwrap_or_default())
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

/// Torque over speed at the nominal voltage, cold and at the winding's limit.
fn torque_and_speed(native: &Native<'_>) -> Option<Captioned> {
    let voltage = native.entry("voltage")?.row.nominal;
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
    let line = |ambient: f64| {
        let constant = native.start(&[("ambient_temperature", ambient)], &[])?.get("torque_constant")?;
        let fastest = voltage / constant;
        let points = (0..=POINTS).map(|k| {
            let speed = fastest * f64::from(k) / f64::from(POINTS);
            torque(ambient, speed).map(|t| (t, speed))
        });
        let points: Option<Vec<_>> = points.collect();
        Some((
            format!("all nodes at {:.0} °C", celsius(ambient)),
            points?.into_iter().filter(|p| p.0 >= 0.0).collect(),
        ))
    };
    let lines = [cold, limit].into_iter().filter_map(line).collect();
    let caption = format!(
        "Voltage drive at {voltage} V, the nominal value of the input; imposed speed. A hot winding has more resistance, hot \
         magnets less torque per ampere."
    );
    figure("Speed and torque", "shaft torque in N·m", "shaft speed in rad/s", lines, caption)
}

/// The greatest load of the gearmotor for an hour, and its temperatures.
fn held_load(native: &Native<'_>) -> Option<Captioned> {
    let at = |load: f64| native.start(&[("duty", 1.0), ("load_torque", load)], &[]);
    let margin = |load: f64| {
        let mut run = at(load)?;
        hour(&mut run, "winding_temperature")?;
        run.get("winding_margin")
    };
    let nominal = native.entry("load_torque")?.row.nominal;
    let load = bearable(nominal, native.entry("load_torque")?.row.max, margin)?;
    let names = ["winding_temperature", "housing_temperature", "box_temperature"];
    let line = |name: &str| {
        let points = at(load).and_then(|mut run| hour(&mut run, name));
        (name.trim_end_matches("_temperature").to_string(), points.unwrap_or_default())
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
    let line = |duty: f64| {
        let points = (0..=POINTS).map(|k| most * f64::from(k) / f64::from(POINTS));
        let points = points.map(|load| speed(duty, load).map(|w| (load, w))).collect::<Option<Vec<_>>>();
        let driven = |p: &(f64, f64)| p.1 >= 0.0;
        Some((format!("duty {duty}"), points?.into_iter().filter(driven).collect()))
    };
    let lines = [1.0, 0.75, 0.5, 0.25].into_iter().filter_map(line).collect();
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
    let mut run = native.start(&[], &[])?;
    let jumps = reference::jumps(native);
    let mut points = vec![(0.0, run.get(name)?)];
    for k in 0..(DEFAULT_STOP / DEFAULT_STEP).round() as u32 {
        for jump in jumps.iter().filter(|j| j.at == k) {
            run.set(&jump.entry.name, jump.to)?;
        }
        run.step(DEFAULT_STEP)?;
        points.push((f64::from(k + 1) * DEFAULT_STEP, run.get(name)?));
    }
    let caption = format!(
        "The simulation whose inputs and results are stored in {}. The inputs go to their nominal values one after the other.",
        reference::FOLDER
    );
    let label = format!("{} in {}", name.replace('_', " "), unit.replace('.', "·"));
    figure("Reference simulation", "time in s", &label, vec![(String::new(), points)], caption)
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{StartValues, models};

    #[test]
    fn every_model_has_three_figures_and_none_is_empty() {
        for kind in models::ALL.iter() {
            let starts = StartValues::default();
            let figures = of(&Native { kind, starts: &starts, terms: &[] });
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
        let figure = held_torque(&Native { kind, starts: &starts, terms: &[] }).unwrap();
        let end: Vec<f64> = figure.figure.series().map(|(_, p)| p.last().unwrap().1).collect();
        let limit = figure.figure.limits().next().unwrap();
        assert!((end[0] - limit).abs() < 0.1, "still air ends at the limit: {end:?}, {limit}");
        assert!(end[1] < end[0] - 10.0 && end[2] < end[0] - 10.0, "{end:?}");
    }
}
