//! Thermal steady state at given inputs, and the continuous torque.
//!
//! R_ha = (T_h - T_a)/Q_h, Q_h the heat flow from the housing to ambient                    (1)
//! continuous torque: the torque at the current whose steady winding temperature is thermal.T_w_max (2)

use crate::StudyError;
use crate::bench::Bench;
use crate::numeric::try_root;
use crate::reproduce::significant;
use describe::Preset;
use describe::usage::is_integral;
use physics::declare::{Causality, Kind};
use serde::Serialize;

/// Smallest heat flow from which a thermal resistance is computed, W.
const LEAST_HEAT: f64 = 1e-3;
/// Relative width of the bracket about the square of the continuous current or load at which the search ends.
const TOLERANCE: f64 = 1e-8;
/// Items of drive_mode: current; voltage and pwm.
const CURRENT: i32 = 3;
const BY_VOLTAGE: [i32; 2] = [1, 2];
/// Inputs that call for a drive mode: name, item.
const DRIVES: [(&str, &str); 4] =
    [("electrical_power", "power"), ("current_command", "current"), ("duty", "pwm"), ("voltage", "voltage")];

/// A model, a preset and values by name: what a study starts from.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Name of the model.
    pub model: String,
    /// Start values that differ from the declared ones.
    pub preset: Option<Preset>,
    /// Names and values as text, the last one of a name counts.
    pub sets: Vec<(String, String)>,
}

impl Setup {
    /// A model of this name with a preset, and values as text by name.
    pub fn new(model: &str, preset: Option<Preset>, sets: &[(&str, &str)]) -> Setup {
        let sets = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Setup { model: model.to_owned(), preset, sets }
    }

    /// The bench with all values set, not started.
    ///
    /// Modes that are not set follow from the inputs that are, as in the design's section 6: electrical_power
    /// means drive_mode power, and so on. The shaft turns at imposed_speed, by default 0, unless load_torque
    /// is set: a free shaft without load has no thermal steady state of interest. A motor that is turned without any
    /// electrical input carries no current; it is not shorted by a voltage of 0.
    ///
    /// # Errors
    /// One sentence naming what is wrong: model, preset, variable, value, limits.
    pub fn bench(&self) -> Result<Bench, StudyError> {
        let mut bench = Bench::new(&self.model, self.preset.as_ref())?;
        let is_set = |name: &str| self.sets.iter().any(|(n, _)| n == name);
        let mechanical = if is_set("load_torque") { "free_shaft" } else { "imposed_speed" };
        if bench.knows("mechanical_mode", Some(mechanical)) {
            bench.set_text("mechanical_mode", mechanical)?;
        }
        let drive =
            DRIVES.iter().find(|(input, item)| is_set(input) && bench.knows("drive_mode", Some(item)));
        if let Some((_, item)) = drive {
            bench.set_text("drive_mode", item)?;
        } else if is_set("imposed_speed") && !is_set("drive_mode") && is_shorted(&mut bench)? {
            bench.set_text("drive_mode", "current")?;
        }
        for (name, text) in &self.sets {
            bench.set_text(name, text)?;
        }
        Ok(bench)
    }
}

/// A value that a model computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// Name of the output.
    pub name: String,
    /// Value in SI units.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
}

/// A steady state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Steady {
    /// All outputs that are no integrals over time.
    pub outputs: Vec<Value>,
    /// Thermal resistance from housing to ambient, K/W, eq. (1); absent where less than a milliwatt flows or the model has
    /// no housing in contact with ambient.
    #[serde(rename = "R_ha")]
    pub r_ha: Option<f64>,
}

impl Steady {
    /// The value of an output.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.outputs.iter().find(|v| v.name == name).map(|v| v.value)
    }

    /// The outputs of a unit: `K` temperatures, `W` heat flows and powers.
    pub fn of_unit(&self, unit: &str) -> impl Iterator<Item = &Value> {
        self.outputs.iter().filter(move |v| v.unit == unit)
    }
}

/// Continuous torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Continuous {
    /// Speed of the shaft, rad/s.
    pub speed: f64,
    /// Current, A.
    pub current: f64,
    /// Torque at the shaft, N.m.
    pub torque: f64,
    /// Torque per total mass, N.m/kg, if the model knows its mass.
    pub torque_density: Option<f64>,
    /// Winding temperature, K: the limit.
    pub winding_temperature: f64,
}

/// Runs the bench to its steady state and reads it.
///
/// # Errors
/// No steady state, in one sentence.
pub fn steady(bench: &mut Bench) -> Result<Steady, StudyError> {
    let cold = bench.clone();
    bench.steady_state().map_err(|error| match error {
        StudyError::Unsettled(sentence) => StudyError::Unsettled(
            cause(cold, bench).map_or(sentence.clone(), |cause| format!("{sentence}; {cause}")),
        ),
        other => other,
    })?;
    let mut outputs = Vec::new();
    for entry in &bench.declaration().entries {
        if entry.row.causality == Causality::Output && entry.row.kind == Kind::Real && !is_integral(entry) {
            let value = bench.get(&entry.name)?;
            outputs.push(Value { name: entry.name.clone(), value, unit: entry.row.unit.name() });
        }
    }
    let mut found = Steady { outputs, r_ha: None };
    found.r_ha = bench
        .housing_heat()
        .filter(|heat| heat.flow.abs() > LEAST_HEAT)
        .map(|heat| (heat.housing - heat.ambient) / heat.flow);
    Ok(found)
}

/// Likely cause of a run without steady state, from its beginning and its end: a blocked shaft, or a current that accelerates it without
/// limit.
fn cause(mut cold: Bench, bench: &mut Bench) -> Option<String> {
    let is_free = cold.get("mechanical_mode").ok()? == 1.0;
    let (drive, load) = (cold.get("drive_mode").ok()?, cold.get("load_torque").ok()?);
    cold.start().ok()?;
    if is_free && drive == f64::from(CURRENT) {
        let (current, k_t) = (cold.get("current").ok()?, cold.get("torque_constant").ok()?);
        let speed = bench.get("shaft_speed").ok()?;
        let accelerates = current * k_t * speed > load * speed;
        let [torque, current, load, speed] = [current * k_t, current, load, speed].map(significant);
        return accelerates.then(|| {
            format!(
                "the shaft accelerates without limit, at the end with {speed} rad/s: current_command = {current} A gives {torque} N.m and \
                 load_torque is {load} N.m"
            )
        });
    }
    let is_blocked = !is_free && cold.get("imposed_speed").ok()? == 0.0;
    (is_blocked && BY_VOLTAGE.map(f64::from).contains(&drive)).then(|| {
        "the shaft is at a standstill (imposed_speed = 0), where the resistance alone limits the current; --set load_torque=... leaves the \
         shaft free"
            .to_owned()
    })
}

/// The continuous torque of the model, eq. (2): at its imposed_speed, or with a free shaft at the speed of the steady state. A model
/// without a command of the current carries the greatest load at its duty cycle.
///
/// The search runs in the square of the current or of the load, to which the temperature is nearly proportional; a value
/// with thermal runaway is too high.
///
/// # Errors
/// A model without a limit or without both; a winding that is too hot without current or load, or never.
pub fn continuous_torque(bench: &Bench) -> Result<Continuous, StudyError> {
    let mut bench = bench.clone();
    let name = bench.declaration().name;
    let none = |why: String| StudyError::new(format!("{name} has no continuous torque: {why}"));
    let is_limited = bench.knows("thermal.T_w_max", None);
    // The load opposes the motion that the duty cycle gives.
    let mut sign = 1.0;
    let command = if is_limited && bench.knows("drive_mode", Some("current")) {
        at_operating_speed(&mut bench)?;
        bench.set_text("drive_mode", "current")?;
        "current_command"
    } else if is_limited && bench.knows("duty", None) && bench.knows("load_torque", None) {
        let duty = bench.get("duty")?;
        if duty == 0.0 {
            return Err(none(
                "at duty = 0 the motor drives no load; --set duty=1 is the full voltage".to_owned(),
            ));
        }
        sign = duty.signum();
        "load_torque"
    } else {
        return Err(none("it needs thermal.T_w_max and a commanded current or a load".to_owned()));
    };
    let limit = bench.get("thermal.T_w_max")?;
    let celsius = significant(limit - 273.15);
    let (greatest, unit) = (bench.entry(command)?.row.max, bench.entry(command)?.row.unit.name());
    bench.start()?;
    // Each search starts from the last steady state, which is nearer than the cold motor.
    let mut settled = bench;
    let mut excess = |square: f64| -> Result<f64, StudyError> {
        let mut next = settled.clone();
        next.set(command, sign * square.sqrt())?;
        match next.settle() {
            Ok(()) => settled = next,
            Err(StudyError::Unsettled(_)) if square > 0.0 => return Ok(f64::INFINITY),
            Err(other) => return Err(other),
        }
        Ok(settled.get("winding_temperature")? - limit)
    };
    let idle = excess(0.0)?;
    if idle >= 0.0 {
        let without = if unit == "A" { "current" } else { "load" };
        return Err(none(format!(
            "without {without} the winding is {idle:.1} K above its limit of {celsius} degC"
        )));
    }
    let (mut low, mut high) = (0.0, 1.0);
    while excess(high)? < 0.0 {
        (low, high) = (high, 4.0 * high);
        if high.sqrt() > greatest {
            let at = low.sqrt();
            return Err(none(format!(
                "even {at:.0} {unit} keep the winding below its limit of {celsius} degC"
            )));
        }
    }
    let square = try_root(&mut excess, low, high, TOLERANCE * high)?
        .ok_or_else(|| StudyError::new(format!("{name}: nothing brings the winding to {celsius} degC")))?;
    excess(square)?;
    let torque_density = match settled.knows("torque_density", None) {
        true => Some(settled.get("torque_density")?),
        false => None,
    };
    Ok(Continuous {
        speed: settled.get("shaft_speed")?,
        current: settled.get("current")?,
        torque: settled.get("shaft_torque")?,
        torque_density,
        winding_temperature: settled.get("winding_temperature")?,
    })
}

/// Imposes the speed of the operating point, where the shaft is free.
fn at_operating_speed(bench: &mut Bench) -> Result<(), StudyError> {
    let mut operating = bench.clone();
    bench.set_text("mechanical_mode", "imposed_speed")?;
    if operating.get("mechanical_mode")? != bench.get("mechanical_mode")? {
        operating.steady_state()?;
        bench.set("imposed_speed", operating.get("shaft_speed")?)?;
    }
    Ok(())
}

/// Whether the motor is driven by a voltage of 0.
fn is_shorted(bench: &mut Bench) -> Result<bool, StudyError> {
    let modes = bench.knows("drive_mode", Some("current")) && bench.knows("drive_mode", Some("voltage"));
    Ok(modes && bench.get("drive_mode")? == 1.0 && bench.get("voltage")? == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(sets: &[(&str, &str)]) -> Setup {
        Setup::new("AnnulusCooledMotor", Preset::load("maxon-305015").ok(), sets)
    }

    /// Modes with a network, whose integrator leaves small errors: each search ends, with the winding at its limit, and the steady state
    /// of that current alone is the same.
    #[test]
    fn the_continuous_torque_of_every_motor_is_found_in_free_and_forced_convection() {
        for preset in ["maxon-re40-148877", "maxon-re25-118743", "maxon-eci40-488607", "faulhaber-1524t006sr"]
        {
            for (mode, fan) in [("bare", "0"), ("fan_crossflow", "0"), ("fan_crossflow", "1")] {
                let sets = [("cooling_mode", mode), ("fan_command", fan)];
                let make = |sets: &[(&str, &str)]| {
                    Setup::new("AnnulusCooledMotor", Preset::load(preset).ok(), sets).bench().unwrap()
                };
                let found =
                    continuous_torque(&make(&sets)).unwrap_or_else(|e| panic!("{preset} {mode} {fan}: {e}"));
                let current = found.current.to_string();
                let alone =
                    steady(&mut make(&[&sets[..], &[("current_command", &current)]].concat())).unwrap();
                let winding = alone.get("winding_temperature").unwrap();
                println!("{preset} {mode} {fan}: {} N.m, {winding} K", found.torque);
                assert!(
                    (winding - found.winding_temperature).abs() < 2e-3,
                    "{preset} {mode} {fan}: {winding} {found:?}"
                );
                let limit = make(&sets).get("thermal.T_w_max").unwrap();
                assert!((winding - limit).abs() < 0.02, "{preset} {mode} {fan}: {winding}");
            }
        }
    }

    /// 10 W through 1/G = 1/0.1351 K/W.
    #[test]
    fn resistance_to_ambient_comes_back() {
        let mut bench = setup(&[("electrical_power", "10")]).bench().unwrap();
        let found = steady(&mut bench).unwrap();
        assert!((found.r_ha.unwrap() - 1.0 / 0.1351).abs() < 1e-4, "{found:?}");
        assert!(found.get("energy_electrical").is_none() && found.of_unit("W").count() > 4);
    }

    /// A speed alone leaves the terminals open; a voltage of 0 that is asked for shorts them.
    #[test]
    fn a_turned_motor_carries_no_current() {
        let copper = |sets: &[(&str, &str)]| {
            let found = steady(&mut setup(sets).bench().unwrap()).unwrap();
            found.get("loss_copper").unwrap()
        };
        assert_eq!(copper(&[("imposed_speed", "400")]), 0.0);
        assert!(copper(&[("imposed_speed", "20"), ("voltage", "0")]) > 0.1);
        assert!(copper(&[("imposed_speed", "20"), ("drive_mode", "voltage")]) > 0.1);
    }

    /// At stall, by hand (audit, T46): I = sqrt((T_max - T_a)/(R_w (R_wh + 1/G))) with R at 155 degC; the
    /// torque with the magnet at the housing's temperature.
    #[test]
    fn continuous_torque_at_stall_by_hand() {
        let found = continuous_torque(&setup(&[]).bench().unwrap()).unwrap();
        let r_hot = 0.386 * (1.0 + 0.0039 * 130.0);
        let heat: f64 = 130.0 / (0.21 + 1.0 / 0.1351);
        let current = (heat / r_hot).sqrt();
        let k_t = 0.0276 * (1.0 - 0.0012 * (130.0 - 0.21 * heat));
        assert!((found.current / current - 1.0).abs() < 1e-5, "{found:?} instead of {current} A");
        assert!((found.current - 5.42).abs() < 0.01, "audit, T46: {found:?}");
        assert!((found.torque / (k_t * current) - 1.0).abs() < 1e-5, "{found:?}");
        assert!((found.torque_density.unwrap() - found.torque / 0.3).abs() < 1e-9);
        assert!((found.winding_temperature - 428.15).abs() < 1e-3);
    }

    /// The gearmotor has no commanded current: the greatest load at its duty cycle. A steady state at this load is at the limit, and one
    /// above it beyond.
    #[test]
    fn the_continuous_torque_of_a_motor_at_a_voltage_is_the_load_that_it_carries() {
        let make = |sets: &[(&str, &str)]| {
            Setup::new("BrushedGearmotor", Preset::load("bdcm-37d").ok(), sets).bench().unwrap()
        };
        let mut torques = Vec::new();
        for duty in ["1", "-0.6"] {
            let found = continuous_torque(&make(&[("duty", duty)])).unwrap();
            assert_eq!(found.torque_density, None);
            let winding = |factor: f64| {
                let load = (factor * found.torque).to_string();
                let at = steady(&mut make(&[("duty", duty), ("load_torque", &load)])).unwrap();
                at.get("winding_margin").unwrap()
            };
            assert!(winding(1.0).abs() < 0.02 && winding(1.02) < -0.1 && winding(0.98) > 0.1, "{found:?}");
            torques.push(found.torque);
        }
        let rest = continuous_torque(&make(&[("duty", "0")])).unwrap_err().to_string();
        assert!(rest.contains("at duty = 0 the motor drives no load"), "{rest}");
        // At less speed friction heats less, so that the winding carries more current; a load opposes the motion.
        assert!(torques[1] < -torques[0], "{torques:?}");
    }

    /// With friction, R_ha is still the reciprocal of the conductance that is set: 4.65 K/W.
    #[test]
    fn friction_leaves_the_resistance_of_the_housing() {
        let sets =
            [("conductance.G_still", "0.21505376344086"), ("current_command", "2"), ("imposed_speed", "300")];
        let found = steady(&mut setup(&sets).bench().unwrap()).unwrap();
        assert!(found.get("loss_friction").unwrap() > 2.0, "{found:?}");
        assert!((found.r_ha.unwrap() - 4.65).abs() < 1e-5, "{:?}", found.r_ha);
    }

    /// What does not leave by leads and by air inside the motor leaves from the housing: the balance of the whole motor gives
    /// the same resistance, in every cooling mode and with every path of heat.
    #[test]
    fn the_balance_of_the_motor_gives_the_resistance_of_the_housing() {
        let (leads, inside) = (0.03, 0.02);
        let text = |number: f64| number.to_string();
        let (leads_text, inside_text) = (text(leads), text(inside));
        let effects = [
            ("current_command", "2"),
            ("imposed_speed", "300"),
            ("fan_command", "0.8"),
            ("heat_power", "1.5"),
            ("thermal.G_leads", leads_text.as_str()),
            ("thermal.G_mount", "0.05"),
            ("effect.iron_loss.k", "1e-4"),
            ("effect.housing_radiation.k", "1e-10"),
            ("effect.contact_drop.V_b", "0.2"),
            ("effect.load_dependent_friction.mu", "0.05"),
            ("effect.interface_temperature.beta", "1e-3"),
            ("effect.forced_convection.G", inside_text.as_str()),
            ("effect.forced_convection.node", "winding"),
            ("effect.ambient_drift.rate", "0"),
        ];
        for preset in ["maxon-305015", "thesis-rig"] {
            for mode in ["conductance", "bare", "fan_crossflow", "annulus_push", "annulus_pull"] {
                let mut setup = setup(&effects);
                setup.preset = Some(Preset::load(preset).unwrap());
                setup.sets.push(("cooling_mode".to_owned(), mode.to_owned()));
                let mut bench = setup.bench().unwrap();
                let found = steady(&mut bench).unwrap();
                let of = |name: &str| found.get(name).unwrap();
                let ambient = bench.get("ambient_temperature").unwrap();
                let from_winding = if mode == "conductance" { inside } else { inside + leads };
                let heat = of("power_electrical") + 1.5
                    - of("power_mechanical")
                    - of("loss_drive")
                    - from_winding * (of("winding_temperature") - ambient);
                let balance = (of("housing_temperature") - ambient) / heat;
                let r_ha = found.r_ha.unwrap();
                assert!((r_ha / balance - 1.0).abs() < 1e-5, "{preset}, {mode}: {r_ha} and {balance} K/W");
            }
        }
    }

    /// Better cooling, more torque; friction at speed, less.
    #[test]
    fn cooling_raises_and_speed_lowers_the_torque() {
        let torque = |sets: &[(&str, &str)]| continuous_torque(&setup(sets).bench().unwrap()).unwrap().torque;
        let still = torque(&[]);
        assert!(torque(&[("fan_command", "1")]) > 1.3 * still);
        assert!(torque(&[("imposed_speed", "500")]) < 0.95 * still);
    }

    /// With a free shaft the speed is that of the operating point.
    #[test]
    fn the_continuous_torque_belongs_to_the_speed_of_the_operating_point() {
        let load = [("voltage", "24"), ("load_torque", "0.05")];
        let speed = steady(&mut setup(&load).bench().unwrap()).unwrap().get("shaft_speed").unwrap();
        let at = |sets: &[(&str, &str)]| continuous_torque(&setup(sets).bench().unwrap()).unwrap();
        let (free, imposed) = (at(&load), at(&[("imposed_speed", &speed.to_string())]));
        assert!(free.speed == imposed.speed && speed > 500.0, "{free:?} {speed}");
        assert!((free.torque / imposed.torque - 1.0).abs() < 1e-6, "{free:?} {imposed:?}");
    }

    #[test]
    fn the_likely_cause_of_a_run_without_steady_state_is_named() {
        for (sets, words) in [
            (&[("voltage", "24")][..], "the shaft is at a standstill (imposed_speed = 0)"),
            (
                &[("current_command", "3"), ("load_torque", "0.05")],
                "current_command = 3.000 A gives 0.08280 N.m and load_torque is 0.05000 N.m",
            ),
        ] {
            let error = steady(&mut setup(sets).bench().unwrap()).unwrap_err().to_string();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        let hot = steady(&mut setup(&[("current_command", "12")]).bench().unwrap()).unwrap_err().to_string();
        assert!(!hot.contains("shaft"), "{hot}");
    }

    #[test]
    fn a_motor_that_is_too_hot_already_is_refused() {
        let bench = setup(&[("ambient_temperature", "430")]).bench().unwrap();
        let error = continuous_torque(&bench).unwrap_err().to_string();
        assert!(error.contains("without current") && error.contains("155.0 degC"), "{error}");
    }

    #[test]
    fn modes_follow_from_inputs() {
        let mode = |sets: &[(&str, &str)], name: &str| setup(sets).bench().unwrap().get(name).unwrap();
        assert_eq!(mode(&[("current_command", "1")], "drive_mode"), 3.0);
        assert_eq!(mode(&[("current_command", "1"), ("drive_mode", "voltage")], "drive_mode"), 1.0);
        assert_eq!(mode(&[], "mechanical_mode"), 2.0);
        assert_eq!(mode(&[("load_torque", "0.1")], "mechanical_mode"), 1.0);
    }
}
