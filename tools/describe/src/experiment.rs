//! The default experiment of an archive: start values of the inputs that act in the modes of its start values, stop time and step.
//!
//! Only the command of the drive gets a start value: what loads or cools the machine stays 0 until the importer sets it, as every
//! unconnected input. A motor at a voltage runs up, a motor at an imposed speed or at a given heat warms up, an imposed current accelerates a
//! free shaft. The current `I` follows from the archive's own thermal network: after three hours under the load `k_t I` the winding has
//! used half of its margin to `thermal.T_w_max`. The resistive drop `R I` is a tenth of the voltage. All values are rounded to two digits, a
//! speed to four. An actuator gets a torque demand of a tenth of the torque at its current limit. `GaitLoad` needs no input.
//!
//! A preset that gives a start value of any of these inputs chooses the operating point itself: then nothing is added.

use crate::{Experiment, StartValues, usage};
use physics::declare::Kind;
use physics::model::{Entry, Model, ModelType};
use physics::resources::Resources;

/// Resistive drop over terminal voltage of a motor.
const DROP: f64 = 0.1;
/// Duty cycle of a drive with pulse-width modulation.
const DUTY: f64 = 0.5;
/// Fraction of the margin of the winding that a motor uses.
const USED: f64 = 0.5;
/// Time after which this fraction is reached, s, and number of steps until then.
const WARM: (f64, u32) = (3.0 * 3600.0, 180);
/// Time of a run-up in time constants, electrical and mechanical.
const RUN_UP: f64 = 20.0;
/// Halvings of the current between the limit for a perfectly cooled housing and none.
const HALVINGS: u32 = 40;
/// Bisections after that.
const BISECTIONS: u32 = 8;
/// Torque demand of an actuator over the torque at its current limit.
const DEMAND: f64 = 0.1;

/// The input that loads a free shaft.
const LOAD: &str = "load_torque";

/// Start values of inputs by name.
type Inputs = Vec<(&'static str, f64)>;

/// The archive before the values of the experiment are added.
#[derive(Clone, Copy)]
struct Bare<'a> {
    kind: &'a ModelType,
    starts: &'a StartValues,
    resources: &'a Resources,
}

/// Inputs and times.
struct Planned {
    inputs: Inputs,
    experiment: Experiment,
}

/// The plan of a model.
type Plan = fn(&Bare<'_>) -> Option<Planned>;

/// A line for each model.
const OWN: &[(&str, Plan)] = &[
    ("AnnulusCooledMotor", motor),
    ("BrushedGearmotor", |bare| bare.run_up(vec![("duty", 1.0)])),
    ("SeriesElasticActuator", |bare| {
        Some(Planned { inputs: actuator(bare)?, experiment: Experiment::default() })
    }),
    ("GaitLoad", |_| Some(Planned { inputs: Vec::new(), experiment: Experiment { stop: 10.0, step: 1e-3 } })),
];
/// Stop times of a motor, s, and number of steps.
const STOPS: [f64; 7] = [60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0];
const STEPS: f64 = 6000.0;
/// Fraction of the winding's rise after which the run may stop.
const SEEN: f64 = 0.1;

/// Start values with those of the default experiment, and its times; `given` are the times of a preset.
pub fn of(
    kind: &ModelType,
    starts: &StartValues,
    resources: &Resources,
    given: Option<Experiment>,
) -> (StartValues, Experiment) {
    let declaration = (kind.declaration)();
    let mut starts = starts.clone();
    let plan = OWN.iter().find(|(model, _)| *model == declaration.name).map(|(_, plan)| plan);
    let planned = plan.and_then(|plan| plan(&Bare { kind, starts: &starts, resources }));
    let Some(Planned { inputs, experiment }) = planned else {
        return (starts, given.unwrap_or_default());
    };
    let entry = |name: &str| declaration.by_name(name);
    if !inputs.iter().filter_map(|(name, _)| entry(name)).any(|entry| starts.names(entry)) {
        for (name, value) in inputs {
            if let Some(entry) = entry(name).filter(|entry| entry.check(value, false).is_ok()) {
                starts.set(entry, value);
            }
        }
    }
    (starts, given.unwrap_or(experiment))
}

/// A motor. On a free shaft there is no load: a voltage makes it run up, a current accelerates it to the speed that the
/// motor would have under load.
fn motor(bare: &Bare<'_>) -> Option<Planned> {
    let (drive, shaft) = (bare.item("drive_mode")?, bare.entry("mechanical_mode")?);
    if bare.item("mechanical_mode")? != "free_shaft" || drive == "power" {
        return bare.warming(loaded);
    }
    if drive != "current" {
        let mut inputs = bare.warm(loaded)?;
        inputs.retain(|(name, _)| *name != LOAD);
        return bare.run_up(inputs);
    }
    let mut starts = bare.starts.clone();
    starts.set(shaft, bare.number(shaft, "imposed_speed")?);
    let mut inputs = Bare { starts: &starts, ..*bare }.warm(loaded)?;
    let value = |name: &str| inputs.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    let acceleration = bare.value("motor.k_t")? * value("current_command")? / bare.value("motor.J")?;
    let stop = rounded(value("imposed_speed")? / acceleration);
    inputs.retain(|(name, _)| *name != "imposed_speed");
    Some(Planned { inputs, experiment: Experiment { stop, step: stop / 100.0 } })
}

/// The inputs of a motor at a current, A.
fn loaded(bare: &Bare<'_>, current: f64) -> Option<Inputs> {
    let (r, k_t) = (bare.value("motor.R_ref")?, bare.value("motor.k_t")?);
    let (current, drive) = (rounded(current), bare.item("drive_mode")?);
    let voltage = rounded(r * current / DROP);
    let mut inputs = match drive {
        "pwm" => vec![("voltage", voltage / DUTY), ("duty", DUTY)],
        "current" => vec![("current_command", current)],
        "power" => vec![("electrical_power", rounded(r * current * current))],
        _ => vec![("voltage", voltage)],
    };
    match (drive, bare.item("mechanical_mode")?) {
        // The power heats the winding; there is no torque.
        ("power", _) => {}
        (_, "imposed_speed") => {
            // The difference of two voltages: two digits would be too few.
            inputs.push(("imposed_speed", digits((voltage - r * current) / k_t, 4)));
        }
        _ => inputs.push((LOAD, rounded(k_t * current))),
    }
    Some(inputs)
}

/// The inputs of an actuator.
fn actuator(bare: &Bare<'_>) -> Option<Inputs> {
    let at_motor = bare.value("control.k_t")? * bare.value("control.current_max")?;
    let ratio = match bare.item("transmission.kind")? {
        "ball_screw" => {
            std::f64::consts::TAU * bare.value("transmission.lever")? / bare.value("transmission.lead")?
        }
        _ => bare.value("transmission.ratio")?,
    };
    Some(vec![("torque_demand", rounded(DEMAND * at_motor * ratio * bare.value("transmission.efficiency")?))])
}

impl Bare<'_> {
    fn entry(&self, name: &str) -> Option<&'static Entry> {
        (self.kind.declaration)().by_name(name)
    }

    fn value(&self, name: &str) -> Option<f64> {
        Some(self.starts.of(self.entry(name)?))
    }

    /// The number of an item of an enumeration.
    fn number(&self, entry: &Entry, item: &str) -> Option<f64> {
        let Kind::Enumeration(table) = entry.row.kind else { return None };
        table.items.iter().find(|known| known.name == item).map(|item| f64::from(item.value))
    }

    /// The selected item of an enumeration.
    fn item(&self, name: &str) -> Option<&'static str> {
        let entry = self.entry(name)?;
        let Kind::Enumeration(table) = entry.row.kind else { return None };
        let value = self.starts.of(entry);
        table.items.iter().find(|item| f64::from(item.value) == value).map(|item| item.name)
    }

    /// The inputs at the current with which the winding uses half of its margin, rounded.
    fn warm(&self, inputs: fn(&Self, f64) -> Option<Inputs>) -> Option<Inputs> {
        let limit = self.value("thermal.T_w_max")?;
        let hot = 1.0 + self.value("motor.alpha")? * (limit - self.value("motor.T_ref")?);
        let margin = limit - self.value("ambient_temperature")?;
        let loss = margin / self.value("thermal.R_wh")?;
        let most = (loss / (self.value("motor.R_ref")? * hot)).sqrt();
        let bears = |current: f64| inputs(self, current).and_then(|inputs| self.bears(&inputs)) == Some(true);
        let mut high = most;
        let mut low = (0..HALVINGS).find_map(|_| {
            let below = 0.5 * high;
            if bears(below) {
                return Some(below);
            }
            high = below;
            None
        })?;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if bears(middle) { low = middle } else { high = middle }
        }
        inputs(self, low)
    }

    /// The same with a stop time at which a part of the rise is visible.
    fn warming(&self, inputs: fn(&Self, f64) -> Option<Inputs>) -> Option<Planned> {
        let inputs = self.warm(inputs)?;
        let mut model = self.started(&inputs)?;
        let margin = self.entry("winding_margin")?.slot;
        let first = model.get(margin);
        let mut time = 0.0;
        let visible = |stop: &f64| {
            let left = model.step(time, stop - time).ok().map(|()| model.get(margin));
            time = *stop;
            left.is_none_or(|left| first - left >= SEEN * USED * first)
        };
        let stop = STOPS.into_iter().find(visible).unwrap_or(STOPS[STOPS.len() - 1]);
        Some(Planned { inputs, experiment: Experiment { stop, step: stop / STEPS } })
    }

    /// A motor that starts without load: 20 time constants, so that the current has fallen to nothing.
    fn run_up(&self, inputs: Inputs) -> Option<Planned> {
        let [r, l, k_t, j] = ["motor.R_ref", "motor.L", "motor.k_t", "motor.J"].map(|name| self.value(name));
        let (r, k_t) = (r?, k_t?);
        let Experiment { stop: least, step } = Experiment::default();
        let stop = rounded(RUN_UP * (l? / r + r * j? / (k_t * k_t))).max(least);
        Some(Planned { inputs, experiment: Experiment { stop, step } })
    }

    /// The model at its start.
    fn started(&self, inputs: &Inputs) -> Option<Box<dyn Model>> {
        let mut model = usage::with_starts(self.kind, self.starts, self.resources);
        for (name, value) in inputs {
            model.set(self.entry(name)?.slot, *value).then_some(())?;
        }
        model.start(0.0).ok()?;
        Some(model)
    }

    /// Whether the winding keeps the rest of its margin.
    fn bears(&self, inputs: &Inputs) -> Option<bool> {
        let mut model = self.started(inputs)?;
        let margin = self.entry("winding_margin")?.slot;
        let allowed = (1.0 - USED) * model.get(margin);
        let h = WARM.0 / f64::from(WARM.1);
        for k in 0..WARM.1 {
            model.step(f64::from(k) * h, h).ok()?;
            if model.get(margin) < allowed {
                return Some(false);
            }
        }
        Some(true)
    }
}

/// Two significant digits.
fn rounded(value: f64) -> f64 {
    digits(value, 2)
}

/// Significant digits.
fn digits(value: f64, count: usize) -> f64 {
    format!("{value:.0$e}", count - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Preset, models};
    use rayon::prelude::*;

    /// Values at the start and at the end of the default experiment, and the smallest margin of the winding's in three hours, relative
    /// to the first.
    fn run(kind: &ModelType, starts: &StartValues, experiment: Experiment, name: &str) -> [f64; 2] {
        let mut model = usage::with_starts(kind, starts, &Resources::default());
        let slot = (kind.declaration)().by_name(name).unwrap().slot;
        model.start(0.0).unwrap();
        let first = model.get(slot);
        let steps = (experiment.stop / experiment.step).round() as u32;
        let mut farthest = first;
        for k in 0..steps {
            model.step(f64::from(k) * experiment.step, experiment.step).unwrap();
            let value = model.get(slot);
            if (value - first).abs() > (farthest - first).abs() {
                farthest = value;
            }
        }
        [first, farthest]
    }

    fn planned(kind: &ModelType, starts: &StartValues) -> (StartValues, Experiment) {
        of(kind, starts, &Resources::default(), None)
    }

    #[test]
    fn every_model_has_its_line() {
        let models: Vec<&str> = models::ALL.iter().map(|kind| (kind.declaration)().name).collect();
        assert_eq!(OWN.iter().map(|(model, _)| *model).collect::<Vec<_>>(), models);
    }

    #[test]
    fn every_model_responds() {
        for (name, output, least) in [
            ("AnnulusCooledMotor", "current", 5.0),
            ("AnnulusCooledMotor", "shaft_speed", 100.0),
            ("BrushedGearmotor", "current", 0.5),
            ("BrushedGearmotor", "shaft_speed", 1.0),
            ("SeriesElasticActuator", "voltage", 5.0),
            ("GaitLoad", "joint_angle", 0.1),
        ] {
            let kind = models::by_name(name).unwrap();
            let (starts, experiment) = planned(kind, &StartValues::default());
            let [first, farthest] = run(kind, &starts, experiment, output);
            assert!((farthest - first).abs() > least, "{name}: {output} {first} -> {farthest}");
        }
    }

    /// The default motor in every cooling mode: a current at a driven shaft warms the winding.
    #[test]
    fn every_cooling_mode_responds() {
        let kind = models::by_name("AnnulusCooledMotor").unwrap();
        let entry = |name: &str| (kind.declaration)().by_name(name).unwrap();
        let Kind::Enumeration(modes) = entry("cooling_mode").row.kind else { unreachable!() };
        for mode in modes.items {
            let mut starts = StartValues::default();
            for (name, item) in [("drive_mode", 3), ("mechanical_mode", 2), ("cooling_mode", mode.value)] {
                starts.set(entry(name), f64::from(item));
            }
            let (starts, experiment) = planned(kind, &starts);
            let [first, farthest] = run(kind, &starts, experiment, "winding_temperature");
            assert!(farthest - first > 1.0, "{}: {first} {farthest}", mode.name);
        }
    }

    /// Every built-in preset of a motor in several drives, shafts and coolings: a voltage and a current turn a free shaft; else the winding
    /// warms in the first run and keeps a part of its margin in three hours. What loads and what cools stays 0.
    #[test]
    fn every_preset_responds_in_every_mode() {
        let motor = models::by_name("AnnulusCooledMotor").unwrap();
        let entry = |name: &str| (motor.declaration)().by_name(name).unwrap();
        Preset::built_in().unwrap().par_iter().for_each(|preset| {
            let kind = models::by_name(&preset.model).unwrap();
            let mut all = vec![preset.starts.clone()];
            if preset.model == "AnnulusCooledMotor" {
                for (drive, shaft, cooling) in [(1, 2, 2), (2, 1, 6), (3, 2, 1), (4, 1, 1), (3, 1, 1)] {
                    let mut starts = preset.starts.clone();
                    starts.set(entry("drive_mode"), f64::from(drive));
                    starts.set(entry("mechanical_mode"), f64::from(shaft));
                    starts.set(entry("cooling_mode"), f64::from(cooling));
                    all.push(starts);
                }
            }
            for (k, bare) in all.into_iter().enumerate() {
                let (starts, experiment) = planned(kind, &bare);
                let what = format!("{} in mode {k}: {:?}, {experiment:?}", preset.name, starts.entries());
                for name in ["load_torque", "fan_command", "coolant_flow_rate"] {
                    let entry = (kind.declaration)().by_name(name);
                    assert!(entry.is_none_or(|entry| starts.of(entry) == bare.of(entry)), "{name}: {what}");
                }
                let bare = Bare { kind, starts: &starts, resources: &Resources::default() };
                let turns = preset.model == "BrushedGearmotor"
                    || bare.item("mechanical_mode") == Some("free_shaft")
                        && bare.item("drive_mode") != Some("power");
                if turns {
                    let [first, farthest] = run(kind, &starts, experiment, "shaft_speed");
                    assert!(farthest - first > 1.0, "{what} {farthest}");
                    continue;
                }
                let [first, farthest] = run(kind, &starts, experiment, "winding_temperature");
                assert!(farthest - first > 1.0, "{what} {first} {farthest}");
                let long = Experiment { stop: WARM.0, step: WARM.0 / f64::from(WARM.1) };
                let [first, farthest] = run(kind, &starts, long, "winding_margin");
                assert!(farthest / first > 0.4 && farthest / first < 0.65, "{what} {first} {farthest}");
            }
        });
    }

    #[test]
    fn a_preset_that_gives_inputs_or_times_keeps_them() {
        let motor = models::by_name("AnnulusCooledMotor").unwrap();
        let entry = |name: &str| (motor.declaration)().by_name(name).unwrap();
        let mut given = StartValues::default();
        given.set(entry("voltage"), 0.0);
        let times = Experiment { stop: 5.0, step: 0.5 };
        let (starts, experiment) = of(motor, &given, &Resources::default(), Some(times));
        assert_eq!((starts, experiment), (given.clone(), times), "a preset may leave the motor at rest");
        // The speed is not imposed in this mode, so that its value is none of an operating point.
        let mut other = StartValues::default();
        other.set(entry("imposed_speed"), 100.0);
        assert!(planned(motor, &other).0.of(entry("voltage")) > 0.0);
    }
}
